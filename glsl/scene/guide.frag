#version 450
// The guide pass: shade and object ID of each pixel (thesis 3.1.2, 3.1.3).
#extension GL_GOOGLE_include_directive : require
#include "shade.glsl"

layout(location = 0) in vec3 world_normal;
layout(location = 1) flat in uint object_id;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out float shade;
layout(location = 1) out uint id;

void main() {
    shade = shade_of(world_normal, push.light.xyz, gl_FrontFacing);
    id = object_id;
}
