#version 450
// The guide pass: shade s = (1 + N.L) / 2 (thesis equation 3.1) and object ID of each pixel.
// `light` is the weighted mean of the lights' unit vectors, which the equation is linear in. A face seen from behind is
// lit as if it were turned round, so that open models show paint inside too.

layout(location = 0) in vec3 world_normal;
layout(location = 1) flat in uint object_id;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
} push;

layout(location = 0) out float shade;
layout(location = 1) out uint id;

void main() {
    // Normals of a face may cancel between its corners; nothing faces the light there.
    float squared = dot(world_normal, world_normal);
    vec3 n = squared > 0.0 ? world_normal * inversesqrt(squared) : vec3(0.0);
    float facing = gl_FrontFacing ? 1.0 : -1.0;
    shade = clamp(0.5 + 0.5 * facing * dot(n, push.light.xyz), 0.0, 1.0);
    id = object_id;
}
