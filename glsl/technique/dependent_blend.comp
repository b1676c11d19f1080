#version 450
// View-dependent interpolation: how much of which slices each set of slices takes, seen from this frame's direction
// (thesis chapter 8; weights after Buehler et al. 2001). One invocation a set.
// In:  where each set's slices begin, with the set's paint and object; the slices of every set; the direction of every
//      slice; for object i in column 4 * (i % 1024) + 3 and row i / 1024 where it is seen from.
// Out: for set i in column i % 1024 and row i / 1024: four weights of 16 bits, the four slices of 8 bits, the paint in
//      16 bits and the object in 16.

layout(local_size_x = 64) in;

layout(binding = 0, std430) readonly buffer Sets { uvec2 sets[]; };
layout(binding = 1, std430) readonly buffer Slices { uint slices[]; };
layout(binding = 2, std430) readonly buffer Directions { vec4 directions[]; };
// Unit vectors from the middle of the model, as the object has it, towards the eye.
layout(binding = 3, rgba32f) uniform readonly image2D objects;
layout(binding = 4, rgba32ui) uniform writeonly uimage2D blends;

layout(push_constant) uniform Push {
    uint sets;
} push;

void main() {
    uint set = gl_GlobalInvocationID.x;
    if (set >= push.sets) {
        return;
    }
    uint object = sets[set].y >> 16;
    vec3 direction = imageLoad(objects, ivec2(4u * (object & 1023u) + 3u, object >> 10)).xyz;
    // The five nearest, by insertion; of equally near ones the first of the set stays first. The last one gives the
    // threshold; where there is none it lies beyond the largest distance, 2.
    float distance[5] = float[](2.5, 2.5, 2.5, 2.5, 2.5);
    uint nearest[5] = uint[](0, 0, 0, 0, 0);
    uint end = sets[set + 1].x;
    for (uint i = sets[set].x; i < end; i++) {
        uint slice = slices[i];
        vec3 apart = directions[slice].xyz - direction;
        // 1 - the cosine of the angle between the two, exact for small angles as well.
        float a = 0.5 * dot(apart, apart);
        bool placed = false;
        for (int k = 0; k < 5; k++) {
            placed = placed || a < distance[k];
            if (placed) {
                float next = distance[k];
                distance[k] = a;
                a = next;
                uint next_slice = nearest[k];
                nearest[k] = slice;
                slice = next_slice;
            }
        }
    }
    vec4 near = vec4(distance[0], distance[1], distance[2], distance[3]);
    vec4 weight = max(vec4(0.0), distance[4] - near) / (near + 1e-4);
    float sum = weight.x + weight.y + weight.z + weight.w;
    weight = sum > 0.0 ? weight / sum : vec4(1.0, 0.0, 0.0, 0.0);
    uint four = nearest[0] | nearest[1] << 8 | nearest[2] << 16 | nearest[3] << 24;
    imageStore(blends, ivec2(set & 1023u, set >> 10),
               uvec4(packUnorm2x16(weight.xy), packUnorm2x16(weight.zw), four, sets[set].y));
}
