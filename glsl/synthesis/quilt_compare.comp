#version 450
// Pruned quilting, for the blocks of one wave: the overlap error of the tiles of positions that are left.
//
// A workgroup takes SPAN groups of positions. First it compares the most promising tiles, which gives a better bound on
// the least error, often the least itself; then it lists the tiles of which any position may still be chosen, so that
// invocations side by side all have one to compare (overlap.glsl).
// In:  sample, its squares, canvas, blocks, order; least errors known and tile_bounds.
// Out: errors and least error of each group, as of quilt_search; errors only of tiles that keep their bound.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D sample_squares;
layout(binding = 2, r32ui) uniform readonly uimage2D canvas;
layout(binding = 3, r32ui) uniform uimage2D tile_bounds;
layout(binding = 4, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 5, std430) readonly buffer Order { uint order[]; };
layout(binding = 6, std430) writeonly buffer Errors { uvec4 errors[]; };
layout(binding = 7, std430) buffer GroupMinima { uint group_minima[]; };

// Groups of GROUP tiles that a workgroup takes.
const uint SPAN = 16;
// Tiles that are compared first; each of so many parts of the workgroup has one.
const uint PROMISING = 8;

#include "search_push.glsl"
#include "fields.glsl"
#include "overlap.glsl"
#include "tile_bounds.glsl"

shared uint painted;
shared uint count;
shared uint best;
shared uint left[SPAN * GROUP];
shared uint least[SPAN];
shared uvec2 promising[GROUP];

// Compares a tile: stores its errors, and returns the least of them.
uint compare(Block block, uint slot, uint tile, uint columns, uint tiles_x) {
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
    return mine;
}

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
    uint end = min(first + SPAN * GROUP, tiles);
    if (lane == 0) {
        painted = painted_fields(index);
        count = 0;
        // Workgroups of a block tell each other; whichever is first, what is known is a bound.
        best = atomicMin(group_minima[push.first_least + slot], 0xffffffffu);
    }
    if (lane < SPAN) {
        least[lane] = 0xffffffffu;
    }
    uvec2 mine = uvec2(NO_BOUND);
    for (uint tile = first + lane; tile < end; tile += GROUP) {
        uint bound = imageLoad(tile_bounds, bound_word(slot, push.bound_rows, tile)).r;
        mine = bound < mine.x ? uvec2(bound, tile) : mine;
    }
    promising[lane] = mine;
    barrier();
    if (lane < PROMISING) {
        for (uint i = 1; i < GROUP / PROMISING; i++) {
            uvec2 other = promising[lane + i * PROMISING];
            mine = other.x < mine.x ? other : mine;
        }
        if (mine.x != NO_BOUND) {
            atomicMin(best, compare(block, slot, mine.y, columns, tiles_x));
        }
    }
    barrier();
    if (lane == 0) {
        best = min(best, atomicMin(group_minima[push.first_least + slot], best));
    }
    barrier();
    uint limit = floatBitsToUint(bound_limit(best, push.tolerance));
    for (uint tile = first + lane; tile < end; tile += GROUP) {
        ivec2 at = bound_word(slot, push.bound_rows, tile);
        uint bound = imageLoad(tile_bounds, at).r;
        if (bound <= limit) {
            // The order of the list does not matter.
            left[atomicAdd(count, 1)] = tile;
        } else if (bound != NO_BOUND) {
            imageStore(tile_bounds, at, uvec4(NO_BOUND));
        }
    }
    barrier();
    for (uint i = lane; i < count; i += GROUP) {
        atomicMin(least[(left[i] - first) / GROUP], compare(block, slot, left[i], columns, tiles_x));
    }
    barrier();
    if (lane < SPAN && first + lane * GROUP < tiles) {
        group_minima[slot * push.groups_per_block + first / GROUP + lane] = least[lane];
    }
}
