#version 450
// View-dependent interpolation: how much of which slices each set of slices takes, seen from this frame's direction
// (thesis chapter 8; weights after Buehler et al. 2001). One invocation a set.
// In:  the slices of every set, the direction of every slice.
// Out: for set i in column i % 1024 and rows 2 (i / 1024) and the next: three weights and what keeps the contrast of
//      their blend; the three slices.

layout(local_size_x = 64) in;

layout(binding = 0, std430) readonly buffer Starts { uint starts[]; };
layout(binding = 1, std430) readonly buffer Slices { uint slices[]; };
layout(binding = 2, std430) readonly buffer Directions { vec4 directions[]; };
layout(binding = 3, rgba32f) uniform writeonly image2D blends;

layout(push_constant) uniform Push {
    // From the middle of the model towards the eye, unit length.
    vec4 direction;
    uint sets;
    uint keep_contrast;
} push;

void main() {
    uint set = gl_GlobalInvocationID.x;
    if (set >= push.sets) {
        return;
    }
    // The four nearest, by insertion; of equally near ones the first of the set stays first. The last one gives the
    // threshold; where there is none it lies beyond the largest distance, 2.
    vec4 distance = vec4(2.5);
    uvec4 nearest = uvec4(0);
    uint end = starts[set + 1];
    for (uint i = starts[set]; i < end; i++) {
        uint slice = slices[i];
        vec3 apart = directions[slice].xyz - push.direction.xyz;
        // 1 - the cosine of the angle between the two, exact for small angles as well.
        float a = 0.5 * dot(apart, apart);
        if (a < distance.x) {
            distance = vec4(a, distance.xyz);
            nearest = uvec4(slice, nearest.xyz);
        } else if (a < distance.y) {
            distance.yzw = vec3(a, distance.yz);
            nearest.yzw = uvec3(slice, nearest.yz);
        } else if (a < distance.z) {
            distance.zw = vec2(a, distance.z);
            nearest.zw = uvec2(slice, nearest.z);
        } else if (a < distance.w) {
            distance.w = a;
            nearest.w = slice;
        }
    }
    vec3 weight = max(vec3(0.0), distance.w - distance.xyz) / (distance.xyz + 1e-4);
    float sum = weight.x + weight.y + weight.z;
    weight = sum > 0.0 ? weight / sum : vec3(1.0, 0.0, 0.0);
    float gain = push.keep_contrast != 0 ? inversesqrt(dot(weight, weight)) : 1.0;
    ivec2 place = ivec2(set & 1023u, 2 * (set >> 10));
    imageStore(blends, place, vec4(weight, gain));
    imageStore(blends, place + ivec2(0, 1), vec4(nearest.xyz, 0.0));
}
