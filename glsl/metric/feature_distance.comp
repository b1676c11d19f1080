#version 450
// The thesis's texture metric (chapter 9.1): the distances of a batch of tested blocks to many source blocks. One invocation
// compares one source block with eight tested ones, so that what it loads serves eight times.
//
// A histogram's squared distance is |a|^2 + |b|^2 - 2 a.b, and two counts stand in a word: with the other side's halves
// exchanged, the upper half of a product is the sum of two of the dot product's terms. Counts sum up to 144 at most, so no
// half runs over. Integers up to the root, which devices may round differently: the host compares the best again.
// In:  the source's features (features.comp); eight tested blocks, 30 vectors each: for each histogram the counts 2 and 0, 3
//      and 1, 6 and 4, 7 and 5, 9 and 8, the first of each pair in the lower half, and the sum of the squares.
// Out: sum over the histograms of the Euclidean distance; tested block t and source block n at texel t * blocks + n, along
//      rows of 4096.

layout(local_size_x = 64) in;

layout(binding = 0, rgba32ui) uniform readonly uimage2D features;
layout(binding = 1, std140) uniform Tested { uvec4 tested[8 * 30]; };
layout(binding = 2, r32f) uniform writeonly image2D distances;

layout(push_constant) uniform Push {
    uint blocks;
    // The number of the first of the eight tested blocks.
    uint first;
} push;

uvec4 histogram(uint h, uint block) {
    uint texel = h * push.blocks + block;
    return imageLoad(features, ivec2(texel & 4095u, texel >> 12));
}

// Histogram h of the source block, and of tested block t. Written out with literals: some compilers read a uniform once for
// all invocations only where its place is a constant, which makes a factor of four.
#define TESTED(t, h) { \
        uvec4 b = tested[30 * t + 2 * h]; \
        uvec2 c = tested[30 * t + 2 * h + 1].xy; \
        uint both = (a0 * b.x + a1 * b.y + a2 * b.z + a3 * b.w + a4 * c.x) >> 16; \
        sum##t += sqrt(float(a.w + c.y - 2 * both)); \
    }
#define HISTOGRAM(h) { \
        uvec4 a = histogram(h, block); \
        uint a0 = a.x & 0xff00ffu, a1 = (a.x >> 8) & 0xff00ffu, a2 = a.y & 0xff00ffu, a3 = (a.y >> 8) & 0xff00ffu; \
        uint a4 = (a.z & 255u) | (a.z & 0xff00u) << 8; \
        TESTED(0, h) TESTED(1, h) TESTED(2, h) TESTED(3, h) TESTED(4, h) TESTED(5, h) TESTED(6, h) TESTED(7, h) \
    }
#define STORE(t) { \
        uint texel = (push.first + t) * push.blocks + block; \
        imageStore(distances, ivec2(texel & 4095u, texel >> 12), vec4(sum##t)); \
    }

void main() {
    uint block = gl_GlobalInvocationID.x;
    if (block >= push.blocks) {
        return;
    }
    float sum0 = 0.0, sum1 = 0.0, sum2 = 0.0, sum3 = 0.0, sum4 = 0.0, sum5 = 0.0, sum6 = 0.0, sum7 = 0.0;
    HISTOGRAM(0) HISTOGRAM(1) HISTOGRAM(2) HISTOGRAM(3) HISTOGRAM(4)
    HISTOGRAM(5) HISTOGRAM(6) HISTOGRAM(7) HISTOGRAM(8) HISTOGRAM(9)
    HISTOGRAM(10) HISTOGRAM(11) HISTOGRAM(12) HISTOGRAM(13) HISTOGRAM(14)
    STORE(0) STORE(1) STORE(2) STORE(3) STORE(4) STORE(5) STORE(6) STORE(7)
}
