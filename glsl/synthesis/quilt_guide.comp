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
#include "guided.glsl"

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

void main() {
    // In two dimensions, because one of them need not reach beyond 65,535.
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= blocks.length()) {
        return;
    }
    uint lane = gl_LocalInvocationID.x;
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
    uvec2 window = uvec2(0, push.sample_width - push.block_px);
    uint state = STATE_PENDING;
    if (push.guided != 0) {
        if (count == 0) {
            state = STATE_SKIPPED;
        } else {
            window = guided_window(sum, count, push.sample_width, push.block_px, push.window_px);
        }
    }
    blocks[index].sx0 = window.x;
    blocks[index].sx1 = window.y;
    blocks[index].state = state;
}
