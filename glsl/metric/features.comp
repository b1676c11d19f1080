#version 450
// The thesis's texture metric (chapter 9.1): the 15 histograms of the blocks around chosen pixels. One invocation a
// histogram.
// In:  the pixels' bins (feature_bins.comp); the blocks' upper left corners.
// Out: for histogram h of block n, at texel h * blocks + n along rows of 4096: its ten counts, 8 bits each, and the sum of
//      their squares.

layout(local_size_x = 64) in;

layout(binding = 0, r32ui) uniform readonly uimage2D low;
layout(binding = 1, r32ui) uniform readonly uimage2D high;
layout(binding = 2, std430) readonly buffer Corners { uvec2 corners[]; };
layout(binding = 3, rgba32ui) uniform writeonly uimage2D features;

layout(push_constant) uniform Push {
    uint blocks;
    int block_px;
} push;

void main() {
    uint block = gl_GlobalInvocationID.x;
    uint histogram = gl_GlobalInvocationID.y;
    if (block >= push.blocks) {
        return;
    }
    ivec2 corner = ivec2(corners[block]);
    bool in_low = histogram < 8;
    uint shift = 4 * (histogram & 7u);
    // Four counts to a word, 8 bits each: a block has 144 pixels at most.
    uvec3 counts = uvec3(0);
    for (int y = 0; y < push.block_px; y++) {
        for (int x = 0; x < push.block_px; x++) {
            ivec2 p = corner + ivec2(x, y);
            uint texel = in_low ? imageLoad(low, p).r : imageLoad(high, p).r;
            uint bin = (texel >> shift) & 15u;
            uint one = 1u << (8 * (bin & 3u));
            counts += uvec3(bin < 4 ? one : 0, (bin & 12u) == 4 ? one : 0, bin >= 8 ? one : 0);
        }
    }
    uint square = 0;
    for (uint bin = 0; bin < 10; bin++) {
        uint count = (counts[bin >> 2] >> (8 * (bin & 3u))) & 255u;
        square += count * count;
    }
    uint texel = histogram * push.blocks + block;
    imageStore(features, ivec2(texel & 4095u, texel >> 12), uvec4(counts, square));
}
