#version 450
// The guide pass: every object of the scene, for shade, ID and depth (thesis 3.1.2, 3.1.3).
// Push constants are shared with guide.frag.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint id;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out vec3 world_normal;
layout(location = 1) flat out uint object_id;

void main() {
    gl_Position = push.view_projection * vec4(position, 1.0);
    world_normal = normal;
    object_id = id;
}
