#version 450
// View-dependent interpolation, first pass: what the second needs of each pixel's surface (thesis chapter 8).
// Out: shade, the corner that the face's blend is under, distance from the eye along the view axis.
#extension GL_GOOGLE_include_directive : require
#include "../scene/shade.glsl"

layout(location = 0) in vec3 world_normal;
layout(location = 1) flat in uint face_corner;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out float shade;
layout(location = 1) out uint corner;
layout(location = 2) out float along;

void main() {
    shade = shade_of(world_normal, push.light.xyz, gl_FrontFacing);
    corner = face_corner;
    along = 1.0 / gl_FragCoord.w;
}
