#version 450
// View-dependent interpolation, preparation: what one of the important views sees (thesis chapter 8).
// Out: shade and object ID as in the guide pass, and the face, from 1.
#extension GL_GOOGLE_include_directive : require
#include "../scene/shade.glsl"

layout(location = 0) in vec3 world_normal;
layout(location = 1) flat in uint object_id;
layout(location = 2) flat in uint face_id;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out float shade;
layout(location = 1) out uint id;
layout(location = 2) out uint face;

void main() {
    shade = shade_of(world_normal, push.light.xyz, gl_FrontFacing);
    id = object_id;
    face = face_id;
}
