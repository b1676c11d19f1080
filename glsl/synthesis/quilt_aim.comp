#version 450
// Pruned quilting, for the blocks of one wave: a bound on the least error.
//
// Where a neighbour is placed, the position from which its texture would go on over this block is often the best of
// all, and its error bounds the least error from above. Where no neighbour's texture goes on within the sample (or within the
// window of a guide), positions at random serve. A few tiles are compared (overlap.glsl).
// One workgroup a block.
// In:  sample, its squares, canvas, blocks, order.  Out: the least error found, after the groups' minima; tile_bounds, cleared.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D sample_squares;
layout(binding = 2, r32ui) uniform readonly uimage2D canvas;
layout(binding = 3, r32ui) uniform writeonly uimage2D tile_bounds;
layout(binding = 4, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 5, std430) readonly buffer Order { uint order[]; };
layout(binding = 6, std430) writeonly buffer GroupMinima { uint group_minima[]; };

#include "search_push.glsl"
#include "block.glsl"
#include "fields.glsl"
#include "overlap.glsl"
#include "tile_bounds.glsl"

// Tiles that are compared: one for each neighbour.
const uint LIKELY = 8;

shared uint painted;
shared uint likely;
shared uint least;

// From the left (or top) edge of a neighbour `by` blocks away to that of the block, around the end of the output.
int advance(uint from, uint to, int by, uint size) {
    int way = int(to) - int(from);
    return by < 0 && way < 0 ? way + int(size) : by > 0 && way > 0 ? way - int(size) : way;
}

// The tile in which the texture of neighbour 0 to 7 goes on, or -1.
int continuing_tile(uint neighbour, uint index, Block block, uint tiles_x, int tile_rows) {
    int at = int(neighbour) + (neighbour < 4 ? 0 : 1);
    ivec2 by = ivec2(at % 3 - 1, at / 3 - 1);
    ivec2 grid = ivec2(push.columns, push.rows);
    ivec2 cell = ivec2(index % push.columns, index / push.columns);
    if (!placed(cell.y, cell.x, by.y, by.x)) {
        return -1;
    }
    cell = (cell + by + grid) % grid;
    Block other = blocks[cell.y * grid.x + cell.x];
    int sx = int(other.sx) + advance(other.x, block.x, by.x, push.output_width);
    int sy = int(other.sy) + advance(other.y, block.y, by.y, push.output_height);
    bool allowed = sx >= int(block.sx0) && sx <= int(block.sx1) && sy >= 0 && sy < tile_rows;
    return allowed ? sy * int(tiles_x) + (sx - int(block.sx0)) / int(TILE) : -1;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.x;
    uint index = order[push.first_block + slot];
    Block block = load_block(index);
    if (block.state != STATE_PENDING) {
        return;
    }
    uint columns = block.sx1 - block.sx0 + 1;
    uint tiles_x = (columns + TILE - 1) / TILE;
    uint tile_rows = push.sample_height - push.block_px + 1;
    uint tiles = tiles_x * tile_rows;
    if (lane == 0) {
        painted = painted_fields(index);
        likely = 0;
        least = 0xffffffffu;
    }
    for (uint tile = lane; tile < (tiles + GROUP - 1) / GROUP * GROUP; tile += GROUP) {
        imageStore(tile_bounds, bound_word(slot, push.bound_rows, tile), uvec4(NO_BOUND));
    }
    barrier();
    int tile = -1;
    if (lane < LIKELY) {
        tile = continuing_tile(lane, index, block, tiles_x, int(tile_rows));
        if (tile >= 0) {
            atomicAdd(likely, 1);
        }
    }
    barrier();
    if (likely == 0 && lane < LIKELY) {
        uint at;
        uint low;
        umulExtended(random_bits(lane, index, 0), tiles, at, low);
        tile = int(at);
    }
    if (tile >= 0) {
        uint tile_x = uint(tile) % tiles_x;
        int error[TILE];
        overlap_errors(block, painted, int(block.sx0 + TILE * tile_x), tile / int(tiles_x), error);
        uint mine = 0xffffffffu;
        for (uint j = 0; j < TILE; j++) {
            mine = min(mine, TILE * tile_x + j < columns ? uint(error[j]) : 0xffffffffu);
        }
        atomicMin(least, mine);
    }
    barrier();
    if (lane == 0) {
        group_minima[push.first_least + slot] = least;
    }
}
