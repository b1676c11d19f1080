#version 450
// Pruned quilting, for the blocks of one wave: the overlap error of the tiles of positions that are left.
//
// A workgroup takes SPAN groups of positions; it first lists the tiles of which any position is left, so that
// invocations side by side all have one to compare (overlap.glsl).
// In:  sample, its squares, canvas, survivors, blocks, order.
// Out: errors and least error of each group, as of quilt_search; errors only where a tile is left.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D sample_squares;
layout(binding = 2, r32ui) uniform readonly uimage2D canvas;
layout(binding = 3, r32ui) uniform readonly uimage2D survivors;
layout(binding = 4, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 5, std430) readonly buffer Order { uint order[]; };
layout(binding = 6, std430) writeonly buffer Errors { uvec4 errors[]; };
layout(binding = 7, std430) writeonly buffer GroupMinima { uint group_minima[]; };

// Groups of GROUP tiles that a workgroup takes.
const uint SPAN = 8;

#include "search_push.glsl"
#include "fields.glsl"
#include "overlap.glsl"
#include "survivors.glsl"

shared uint painted;
shared uint count;
shared uint left[SPAN * GROUP];
shared uint least[SPAN];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.y;
    uint index = order[push.first_block + slot];
    Block block = blocks[index];
    if (block.state != STATE_PENDING) {
        return;
    }
    uint columns = block.sx1 - block.sx0 + 1;
    uint tiles_x = (columns + TILE - 1) / TILE;
    uint tiles = tiles_x * (push.sample_height - push.block_px + 1);
    uint first = gl_WorkGroupID.x * SPAN * GROUP;
    if (first >= tiles) {
        return;
    }
    if (lane == 0) {
        painted = painted_fields(index);
        count = 0;
    }
    if (lane < SPAN) {
        least[lane] = 0xffffffffu;
    }
    barrier();
    for (uint tile = first + 4 * lane; tile < min(first + SPAN * GROUP, tiles); tile += 4 * GROUP) {
        uint word = imageLoad(survivors, survivor_word(slot, push.survivor_rows, tile)).r;
        for (; word != 0; ) {
            uint byte = uint(findLSB(word)) / 8;
            // The order of the list does not matter.
            left[atomicAdd(count, 1)] = tile + byte;
            word &= ~(255u << (8 * byte));
        }
    }
    barrier();
    for (uint i = lane; i < count; i += GROUP) {
        uint tile = left[i];
        uint tile_x = tile % tiles_x;
        int total[TILE];
        overlap_errors(block, painted, int(block.sx0 + TILE * tile_x), int(tile / tiles_x), total);
        uint mine = 0xffffffffu;
        uint error[TILE];
        for (uint j = 0; j < TILE; j++) {
            error[j] = TILE * tile_x + j < columns ? uint(total[j]) : 0xffffffffu;
            mine = min(mine, error[j]);
        }
        uint place = (slot * push.groups_per_block * GROUP + tile) * (TILE / 4);
        for (uint j = 0; j < TILE / 4; j++) {
            errors[place + j] = uvec4(error[4 * j], error[4 * j + 1], error[4 * j + 2], error[4 * j + 3]);
        }
        atomicMin(least[(tile - first) / GROUP], mine);
    }
    barrier();
    if (lane < SPAN && first + lane * GROUP < tiles) {
        group_minima[slot * push.groups_per_block + first / GROUP + lane] = least[lane];
    }
}
