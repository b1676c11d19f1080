#version 450
// Repair, first stage: which blocks keep the texture that was carried along, and which are synthesised anew.
//
// One workgroup a block. A block answers for its cell: its part of the output up to the middle of its overlaps. It is
// synthesised anew when a covered pixel of the cell has no carried texture, when the texture of more than half of the
// cell no longer looks like the sample, or when it comes from another part of the sample than the cell's shade now asks
// for: as in quilt_guide, L the mean shade of the block's covered pixels; a block of the sample whose texel (x, y) lies
// at pixel (x, y) of the block would have its left edge at the mean of place - pixel, which must lie within the window,
// or `slack` beyond it. Rounds: blocks that are placed at once share no pixel; see src/synthesis/repair.rs.
// In:  guide, carried places.
// Out: state and allowed columns of every block; the blocks of each round, in any order, and how many they are, as the
//      workgroups of search and placing. Integer arithmetic throughout.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"
#include "guided.glsl"
#include "carried.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D guide;
layout(binding = 1, rgba16ui) uniform readonly uimage2D carried;
layout(binding = 2, std430) buffer Blocks { Block blocks[]; };
layout(binding = 3, std430) writeonly buffer Order { uint order[]; };
layout(binding = 4, std430) buffer Counts { uint counts[]; };

layout(push_constant) uniform Push {
    uint sample_width;
    uint block_px, overlap_px;
    uint columns, rows;
    uint paint;
    uint window_px;
    // In texels.
    uint slack;
    // Of a round, in blocks; of a band of rounds, in rows.
    uint capacity, band_rows;
} push;

shared uint covered;
shared uint shade_sum;
shared uint cell_pixels;
shared uint missing;
shared uint misfits;
shared int edge_sum;

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= blocks.length()) {
        return;
    }
    uint lane = gl_LocalInvocationID.x;
    if (lane == 0) {
        covered = 0;
        shade_sum = 0;
        cell_pixels = 0;
        missing = 0;
        misfits = 0;
        edge_sum = 0;
    }
    barrier();
    Block block = blocks[index];
    uvec2 grid = uvec2(index % push.columns, index / push.columns);
    // The cell, in pixels of the block.
    uvec2 begin = mix(uvec2(push.overlap_px / 2), uvec2(0), equal(grid, uvec2(0)));
    uvec2 end = mix(uvec2(push.block_px - push.overlap_px + push.overlap_px / 2), uvec2(block.width, block.height),
                    equal(grid + 1, uvec2(push.columns, push.rows)));
    uint my_covered = 0, my_shade = 0, my_cell = 0, my_missing = 0, my_misfits = 0;
    int my_edge = 0;
    for (uint i = lane; i < block.width * block.height; i += GROUP) {
        uvec2 in_block = uvec2(i % block.width, i / block.width);
        ivec2 at = ivec2(block.x, block.y) + ivec2(in_block);
        uint texel = imageLoad(guide, at).r;
        if (texel >> 16 != push.paint) {
            continue;
        }
        my_covered++;
        my_shade += texel & 255u;
        if (any(lessThan(in_block, begin)) || any(greaterThanEqual(in_block, end))) {
            continue;
        }
        my_cell++;
        uvec4 place = imageLoad(carried, at);
        if (!is_present(place)) {
            my_missing++;
            continue;
        }
        my_edge += steps_of(place).x - STEPS * int(in_block.x);
        my_misfits += is_misfit(place) ? 1 : 0;
    }
    atomicAdd(covered, my_covered);
    atomicAdd(shade_sum, my_shade);
    atomicAdd(cell_pixels, my_cell);
    atomicAdd(missing, my_missing);
    atomicAdd(misfits, my_misfits);
    atomicAdd(edge_sum, my_edge);
    barrier();
    if (lane != 0) {
        return;
    }
    uint state = STATE_SKIPPED;
    uvec2 window = uvec2(0);
    if (cell_pixels > 0) {
        window = guided_window(shade_sum, covered, push.sample_width, push.block_px, push.window_px);
        int present = int(cell_pixels - missing);
        int low = STEPS * (int(window.x) - int(push.slack)) * present;
        int high = STEPS * (int(window.y) + int(push.slack)) * present;
        bool keep = missing == 0 && 2 * misfits <= cell_pixels && edge_sum >= low && edge_sum <= high;
        state = keep ? STATE_PLACED : STATE_PENDING;
    }
    if (state == STATE_PENDING) {
        uint round = 4 * (grid.y / push.band_rows) + 2 * (grid.y & 1u) + (grid.x & 1u);
        uint at = atomicAdd(counts[6 * round + 1], 1);
        atomicAdd(counts[6 * round + 3], 1);
        order[round * push.capacity + at] = index;
    }
    blocks[index].sx0 = window.x;
    blocks[index].sx1 = window.y;
    blocks[index].state = state;
}
