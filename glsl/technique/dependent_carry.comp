#version 450
// View-dependent interpolation: the direction by which each corner's faces take their texture, carried from frame to
// frame, and how much of which slices they take, seen from there (thesis chapter 8; weights after Buehler et al. 2001).
// One invocation a corner; that of number i is in column i % 4096 and row i / 4096.
// In:  each corner's place, and its normal in four times 8 bits; where its set's slices begin and end, its paint and its
//      object; the slices of every set, each with its direction before its number; for object i in columns
//      2 * (i % 1024) and the next, and row i / 1024, the direction that it is seen from, and the eye.
// Carried: direction, and how far the corner was turned away from the eye (the negative cosine).
// Out: four weights of 16 bits, the four slices of 8 bits, the paint in 16 bits and the object in 16.

layout(local_size_x = 64) in;

layout(binding = 0, rgba32ui) uniform readonly uimage2D corners;
layout(binding = 1, rgba32ui) uniform readonly uimage2D sets;
layout(binding = 2, rgba32f) uniform readonly image2D slices;
// Both as the object has them; the direction is that from the middle of the model towards the eye, unit length.
layout(binding = 3, rgba32f) uniform readonly image2D objects;
layout(binding = 4, rgba32f) uniform image2D carried;
layout(binding = 5, rgba32ui) uniform writeonly uimage2D blends;

layout(push_constant) uniform Push {
    uint count;
    // Nothing was before.
    uint cut;
    // Tangent of half the angle that a direction may turn in a frame.
    float turn;
} push;

ivec2 place(uint number) {
    return ivec2(number & 4095u, number >> 12);
}

// `from`, turned towards `to`; `turn` is the tangent of half the angle.
vec3 turned(vec3 from, vec3 to, float turn) {
    float square = turn * turn;
    vec3 apart = to - from;
    // Not further apart than it may turn: the chord of an angle is twice its half's sine.
    if (dot(apart, apart) * (1.0 + square) <= 4.0 * square) {
        return to;
    }
    vec3 aside = to - dot(from, to) * from;
    // Towards the opposite any way will do.
    if (dot(aside, aside) < 1e-8) {
        aside = cross(from, abs(from.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0));
    }
    vec3 next = (1.0 - square) * from + 2.0 * turn * inversesqrt(dot(aside, aside)) * aside;
    return next * inversesqrt(dot(next, next));
}

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number >= push.count) {
        return;
    }
    uvec4 corner = imageLoad(corners, place(number));
    uvec4 set = imageLoad(sets, place(number));
    ivec2 object = ivec2(2u * (set.w & 1023u), set.w >> 10);
    vec3 normal = unpackSnorm4x8(corner.w).xyz;
    vec3 to_eye = imageLoad(objects, object + ivec2(1, 0)).xyz - uintBitsToFloat(corner.xyz);
    float away = -dot(normal, to_eye) * inversesqrt(max(dot(to_eye, to_eye), 1e-30));
    vec3 direction = imageLoad(objects, object).xyz;
    if (push.cut == 0) {
        vec4 before = imageLoad(carried, place(number));
        // What could not be seen forgets, what was far behind the horizon at once, so that no edge shows how far the
        // horizon came.
        float hidden = clamp(2.5 * before.w - 0.25, 0.0, 1.0);
        // What is now seen much straighter than its texture's views see it has its marks stretched.
        float straighter = max(dot(normal, direction - before.xyz) - 0.25, 0.0);
        if (hidden < 1.0) {
            float square = hidden * hidden;
            float turn = push.turn + square / (1.0 - square) + 0.3 * straighter * straighter;
            direction = turned(before.xyz, direction, turn);
        }
        imageStore(carried, place(number), vec4(direction, away));
        if (direction == before.xyz) {
            return;
        }
    } else {
        imageStore(carried, place(number), vec4(direction, away));
    }

    // The five nearest, by insertion; of equally near ones the first of the set stays first. The last one gives the
    // threshold; where there is none it lies beyond the largest distance, 2.
    float distance[5] = float[](2.5, 2.5, 2.5, 2.5, 2.5);
    uint nearest[5] = uint[](0, 0, 0, 0, 0);
    for (uint i = set.x; i < set.y; i++) {
        vec4 of_slice = imageLoad(slices, place(i));
        uint slice = uint(of_slice.w);
        vec3 apart = of_slice.xyz - direction;
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
    imageStore(blends, place(number),
               uvec4(packUnorm2x16(weight.xy), packUnorm2x16(weight.zw), four, set.z | set.w << 16));
}
