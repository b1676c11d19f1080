#version 450
// The thesis's texture metric (chapter 9.1): the distances of tested blocks to source blocks, all with all. One
// invocation compares four source blocks with eight tested ones, so that each that it loads serves several times.
//
// A histogram's squared distance is |a|^2 + |b|^2 - 2 a.b, and two counts stand in a word: with the other side's halves
// exchanged, the upper half of a product is the sum of two of the dot product's terms. Counts sum up to 144 at most, so
// no half runs over. Integers up to the root, which devices may round differently: the host compares the best again.
// In:  the features of the source and of the tested blocks (features.comp).
// Out: sum over the histograms of the Euclidean distance; tested block t and source block n at texel t * blocks + n, along
//      rows of 4096.

layout(local_size_x = 64) in;

layout(binding = 0, rgba32ui) uniform readonly uimage2D source;
layout(binding = 1, rgba32ui) uniform readonly uimage2D tested;
layout(binding = 2, r32f) uniform writeonly image2D distances;

layout(push_constant) uniform Push {
    uint blocks;
    // Source blocks that lie between an invocation's four.
    uint apart;
    uint tested_blocks;
} push;

// Two counts to a word: 0 and 2, 1 and 3, 4 and 6, 5 and 7, 8 and 9.
struct Histogram {
    uvec4 counts;
    uint last;
    uint square;
};

Histogram unpacked(uvec4 texel) {
    Histogram h;
    h.counts = uvec4(texel.x, texel.x >> 8, texel.y, texel.y >> 8) & 0xff00ffu;
    h.last = (texel.z & 255u) | (texel.z & 0xff00u) << 8;
    h.square = texel.w;
    return h;
}

Histogram of_source(uint h, uint block) {
    uint texel = h * push.blocks + min(block, push.blocks - 1);
    return unpacked(imageLoad(source, ivec2(texel & 4095u, texel >> 12)));
}

// With the halves exchanged.
Histogram of_tested(uint h, uint block) {
    uint texel = h * push.tested_blocks + min(block, push.tested_blocks - 1);
    Histogram b = unpacked(imageLoad(tested, ivec2(texel & 4095u, texel >> 12)));
    b.counts = b.counts << 16 | b.counts >> 16;
    b.last = b.last << 16 | b.last >> 16;
    return b;
}

float distance_of(Histogram a, Histogram b) {
    uvec4 products = a.counts * b.counts;
    uint both = (products.x + products.y + products.z + products.w + a.last * b.last) >> 16;
    return sqrt(float(a.square + b.square - 2 * both));
}

void store(uint tested_block, uint block, float value) {
    if (block < push.blocks && tested_block < push.tested_blocks) {
        uint texel = tested_block * push.blocks + block;
        imageStore(distances, ivec2(texel & 4095u, texel >> 12), vec4(value));
    }
}

void store4(uint tested_block, uint block, vec4 values) {
    store(tested_block, block, values.x);
    store(tested_block, block + push.apart, values.y);
    store(tested_block, block + 2 * push.apart, values.z);
    store(tested_block, block + 3 * push.apart, values.w);
}

void main() {
    uint block = gl_GlobalInvocationID.x;
    uint first = gl_GlobalInvocationID.y * 8;
    if (block >= push.apart) {
        return;
    }
    // Written out, since some compilers keep arrays in memory.
    vec4 sum0 = vec4(0.0), sum1 = vec4(0.0), sum2 = vec4(0.0), sum3 = vec4(0.0);
    vec4 sum4 = vec4(0.0), sum5 = vec4(0.0), sum6 = vec4(0.0), sum7 = vec4(0.0);
    for (uint h = 0; h < 15; h++) {
        Histogram a0 = of_source(h, block), a1 = of_source(h, block + push.apart);
        Histogram a2 = of_source(h, block + 2 * push.apart), a3 = of_source(h, block + 3 * push.apart);
        Histogram b;
#define ADD(t) \
        b = of_tested(h, first + t); \
        sum##t += vec4(distance_of(a0, b), distance_of(a1, b), distance_of(a2, b), distance_of(a3, b));
        ADD(0) ADD(1) ADD(2) ADD(3) ADD(4) ADD(5) ADD(6) ADD(7)
    }
    store4(first, block, sum0);
    store4(first + 1, block, sum1);
    store4(first + 2, block, sum2);
    store4(first + 3, block, sum3);
    store4(first + 4, block, sum4);
    store4(first + 5, block, sum5);
    store4(first + 6, block, sum6);
    store4(first + 7, block, sum7);
}
