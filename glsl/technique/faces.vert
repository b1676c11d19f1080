#version 450
// View-dependent interpolation, preparation: three vertices of its own for every face, so that a vertex tells its face.
// Push constants are those of faces.frag.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint id;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out vec3 world_normal;
layout(location = 1) flat out uint object_id;
layout(location = 2) flat out uint face_id;

void main() {
    gl_Position = push.view_projection * vec4(position, 1.0);
    world_normal = normal;
    object_id = id;
    face_id = uint(gl_VertexIndex) / 3u + 1u;
}
