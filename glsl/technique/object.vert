#version 450
// Object-based texture mapping: the mesh with its fixed coordinate t (thesis chapter 5). Push constants are those of
// object.frag.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float t;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
    vec2 range;
    float density;
    uint paint;
    uint show;
} push;

layout(location = 0) out vec3 world_position;
layout(location = 1) out vec3 world_normal;
layout(location = 2) out float vertex_t;

void main() {
    gl_Position = push.view_projection * vec4(position, 1.0);
    world_position = position;
    world_normal = normal;
    vertex_t = t;
}
