#version 450
// View-dependent interpolation, first pass: the mesh, the first vertex of each face with the number of the corner that
// the face's blend is under (thesis chapter 8). Push constants are those of dependent_mesh.frag.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint corner;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out vec3 world_normal;
layout(location = 1) flat out uint face_corner;

void main() {
    gl_Position = push.view_projection * vec4(position, 1.0);
    world_normal = normal;
    face_corner = corner;
}
