#version 450
// Repair, second stage: the canvas as the blocks to be synthesised anew find it.
//
// A pixel keeps its carried texture where a block that keeps its texture reaches; what is left is bare, for the blocks
// around to fill. One workgroup a block, for the pixels from its corner to those of the blocks to the right and below.
// In:  guide, carried places, sample, the blocks' states.
// Out: canvas; previous, the carried texels of all pixels; source, on which nothing is pasted yet.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"
#include "carried.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D guide;
layout(binding = 1, rg32ui) uniform readonly uimage2D carried;
layout(binding = 2, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 3, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 4, r32ui) uniform writeonly uimage2D canvas;
layout(binding = 5, r32ui) uniform writeonly uimage2D previous;
layout(binding = 6, r32ui) uniform writeonly uimage2D source;

layout(push_constant) uniform Push {
    uint sample_width, sample_height;
    uint block_px, overlap_px;
    uint columns, rows;
    uint paint;
} push;

bool keeps(uint row, uint col) {
    return blocks[row * push.columns + col].state == STATE_PLACED;
}

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= blocks.length()) {
        return;
    }
    uint lane = gl_LocalInvocationID.x;
    Block block = blocks[index];
    uint row = index / push.columns;
    uint col = index % push.columns;
    bool here = keeps(row, col);
    bool left = col > 0 && keeps(row, col - 1);
    bool above = row > 0 && keeps(row - 1, col);
    bool corner = col > 0 && row > 0 && keeps(row - 1, col - 1);
    uint step = push.block_px - push.overlap_px;
    uvec2 size = uvec2(col + 1 < push.columns ? step : block.width, row + 1 < push.rows ? step : block.height);
    for (uint i = lane; i < size.x * size.y; i += GROUP) {
        uvec2 in_block = uvec2(i % size.x, i / size.x);
        ivec2 at = ivec2(block.x, block.y) + ivec2(in_block);
        uvec2 place = imageLoad(carried, at).rg;
        ivec2 steps = steps_of(place);
        bool present = imageLoad(guide, at).r >> 16 == push.paint && is_present(place) &&
                       in_sample(steps, uvec2(push.sample_width, push.sample_height));
        uint texel = 0;
        if (present) {
            texel = imageLoad(sample_texels, (steps + STEPS / 2) / STEPS).r | PAINTED;
        }
        bvec2 first = lessThan(in_block, uvec2(push.overlap_px));
        bool kept = here || (first.x && left) || (first.y && above) || (first.x && first.y && corner);
        imageStore(canvas, at, uvec4(kept ? texel : 0));
        imageStore(previous, at, uvec4(texel));
        imageStore(source, at, uvec4(NOT_PASTED));
    }
}
