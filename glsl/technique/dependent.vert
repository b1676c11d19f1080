#version 450
// View-dependent interpolation: the mesh, the first vertex of each face with the face's set of slices and its paint
// (thesis chapter 8). Push constants are those of dependent.frag.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uvec2 set_and_paint;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
    vec2 range;
    uint slices;
    uint show;
} push;

layout(location = 0) out vec3 world_position;
layout(location = 1) out vec3 world_normal;
layout(location = 2) flat out uvec2 face;

void main() {
    gl_Position = push.view_projection * vec4(position, 1.0);
    world_position = position;
    world_normal = normal;
    face = set_and_paint;
}
