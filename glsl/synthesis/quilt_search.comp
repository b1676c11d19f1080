#version 450
// Quilting, second stage: the overlap error of the blocks of one wave at every allowed position of the sample.
//
// PARTS invocations compare TILE positions that are neighbours in x (overlap.glsl), and add up what they found. So a
// workgroup compares GROUP / PARTS tiles, in raster order, and PARTS workgroups make a group of GROUP tiles. With more
// parts an invocation has a shorter walk through the overlap, which counts where a wave does not fill the device.
// In:  sample (TILE + CHUNK texels wider than it is, so that no load leaves it), its summed-area table of |a|^2 (one
//      row and column of zeros first), canvas, blocks, the blocks' order.
// Out: errors, in raster order with rows of positions padded to TILE; padding is 2^32 - 1. Least error of each
//      PARTS-th of a group.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D sample_squares;
layout(binding = 2, r32ui) uniform readonly uimage2D canvas;
layout(binding = 3, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 4, std430) readonly buffer Order { uint order[]; };
layout(binding = 5, std430) writeonly buffer Errors { uvec4 errors[]; };
layout(binding = 6, std430) writeonly buffer GroupMinima { uint group_minima[]; };

// Invocations that share a tile: 1, 2, 4 or 8.
layout(constant_id = 1) const uint PARTS = 1;
const uint TILES = GROUP / PARTS;

#include "search_push.glsl"
#include "fields.glsl"
#include "overlap.glsl"

shared uint painted;
shared uint least[GROUP];
shared int terms[TILE * GROUP];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.y;
    uint index = order[push.first_block + slot];
    Block block = blocks[index];
    if (block.state != STATE_PENDING) {
        return;
    }
    uint group = push.first_group + gl_WorkGroupID.x / PARTS;
    uint columns = block.sx1 - block.sx0 + 1;
    uint tiles_x = (columns + TILE - 1) / TILE;
    uint tiles = tiles_x * (push.sample_height - push.block_px + 1);
    if (group * GROUP >= tiles) {
        return;
    }
    // Side by side are invocations with the same part, which walk through the same pixels of the block.
    uint part = PARTS > 1 ? lane / TILES : 0;
    uint in_group = gl_WorkGroupID.x % PARTS;
    uint tile = group * GROUP + in_group * TILES + lane % TILES;
    bool live = tile < tiles;
    uint tile_x = live ? tile % tiles_x : 0;
    int sx = int(block.sx0 + TILE * tile_x);
    int sy = int(live ? tile / tiles_x : 0);
    if (lane == 0) {
        painted = painted_fields(index);
    }
    barrier();
    uint fields = painted;

    int total[TILE];
    overlap_part(block, fields, int(part), int(PARTS), sx, sy, total);
    if (PARTS > 1) {
        [[unroll]] for (uint j = 0; j < TILE; j++) {
            terms[j * GROUP + lane] = total[j];
        }
        barrier();
        [[unroll]] for (uint i = 1; i < PARTS; i++) {
            [[unroll]] for (uint j = 0; j < TILE; j++) {
                total[j] += terms[j * GROUP + lane % TILES + i * TILES];
            }
        }
    }

    uint mine = 0xffffffffu;
    uint error[TILE];
    for (uint j = 0; j < TILE; j++) {
        error[j] = live && part == 0 && TILE * tile_x + j < columns ? uint(total[j]) : 0xffffffffu;
        mine = min(mine, error[j]);
    }
    uint group_at = slot * push.groups_per_block + group;
    uint place = (group_at * GROUP + tile % GROUP) * (TILE / 4);
    for (uint j = 0; j < TILE / 4 && part == 0; j++) {
        errors[place + j] = uvec4(error[4 * j], error[4 * j + 1], error[4 * j + 2], error[4 * j + 3]);
    }
    // Two short serial steps: few of the slow shared accesses, and few barriers.
    least[lane] = mine;
    barrier();
    if (lane < GROUP / 8) {
        for (uint i = 1; i < 8; i++) {
            mine = min(mine, least[lane + i * GROUP / 8]);
        }
    }
    barrier();
    if (lane < GROUP / 8) {
        least[lane] = mine;
    }
    barrier();
    if (lane == 0) {
        for (uint i = 1; i < GROUP / 8; i++) {
            mine = min(mine, least[i]);
        }
        group_minima[group_at * PARTS + in_group] = mine;
    }
}
