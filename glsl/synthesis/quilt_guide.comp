#version 450
// Quilting, first stage: which blocks there are to place, and where each may be searched for.
//
// One workgroup a block. With a guide (thesis chapter 6) a block without a covered pixel is skipped, and the others are
// limited to `window_px` columns around x0 = L * W_sample, L the mean shade of the covered pixels. Without one every
// block is placed and searched for everywhere.
// In:  guide, a texel a pixel: shade in the low byte, the paint's number (from 1; 0 is background) in the high half.
// Out: state and allowed columns of every block. Integer arithmetic throughout.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D guide;
layout(binding = 1, std430) buffer Blocks { Block blocks[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_width;
    uint block_px;
    uint guided;
    uint paint;
    uint window_px;
} push;

shared uint count;
shared uint sum;

// floor(a * b / d) for a <= d < 2^24 and b < 2^14, by long division: the product does not fit 32 bits.
uint scaled(uint a, uint b, uint d) {
    uint quotient = 0;
    uint rest = 0;
    for (int bit = 13; bit >= 0; bit--) {
        rest = 2 * rest + (((b >> bit) & 1u) != 0 ? a : 0);
        quotient = 2 * quotient + rest / d;
        rest %= d;
    }
    return quotient;
}

void main() {
    // In two dimensions, because one of them need not reach beyond 65,535.
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= blocks.length()) {
        return;
    }
    uint lane = gl_LocalInvocationID.x;
    uint last = push.sample_width - push.block_px;
    if (lane == 0) {
        count = 0;
        sum = 0;
    }
    barrier();
    if (push.guided != 0) {
        Block block = blocks[index];
        uint my_count = 0;
        uint my_sum = 0;
        for (uint i = lane; i < block.width * block.height; i += GROUP) {
            uint x = block.x + i % block.width;
            uint y = block.y + i / block.width;
            x -= x >= push.output_width ? push.output_width : 0;
            y -= y >= push.output_height ? push.output_height : 0;
            uint texel = imageLoad(guide, ivec2(x, y)).r;
            if (texel >> 16 == push.paint) {
                my_count++;
                my_sum += texel & 255u;
            }
        }
        atomicAdd(count, my_count);
        atomicAdd(sum, my_sum);
    }
    barrier();
    if (lane != 0) {
        return;
    }
    uint sx0 = 0;
    uint sx1 = last;
    uint state = STATE_PENDING;
    if (push.guided != 0) {
        if (count == 0) {
            state = STATE_SKIPPED;
        } else {
            uint x0 = scaled(sum, push.sample_width, 255 * count);
            sx0 = min(x0 - min(x0, push.window_px), last);
            sx1 = min(x0 + push.window_px, last);
        }
    }
    blocks[index].sx0 = sx0;
    blocks[index].sx1 = sx1;
    blocks[index].state = state;
}
