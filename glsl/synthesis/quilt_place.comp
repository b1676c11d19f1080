#version 450
// Quilting, third stage: choice, minimum-error cut and paste of the blocks of one wave.
//
// One workgroup a block; the blocks of a wave touch disjoint pixels.
// Choice: uniform among the positions with error <= (1 + tolerance) * least, in raster order.
// Cut: on each side whose neighbour is placed, the path through the strip of the overlap with the least sum of squared
// differences, by dynamic programming, ties to the lowest index (thesis 3.2.2; Efros and Freeman 2001).
// Paste: a painted pixel beyond a cut stays as it is, every other one takes the new block's texel.
// A neighbour may be placed on any side: those to the right and below are where texture was carried along.
// In:  errors and group minima of this wave's search, and, if it was pruned, which tiles have errors.  Out: canvas, source coordinates, the blocks' records.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform uimage2D canvas;
// x + (y << 16) of the sample's texel that each pixel came from.
layout(binding = 2, r32ui) uniform writeonly uimage2D source;
layout(binding = 3, r32ui) uniform readonly uimage2D tile_bounds;
layout(binding = 4, std430) buffer Blocks { Block blocks[]; };
layout(binding = 5, std430) readonly buffer Order { uint order[]; };
layout(binding = 6, std430) readonly buffer Errors { uvec4 errors[]; };
layout(binding = 7, std430) readonly buffer GroupMinima { uint group_minima[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_height;
    uint block_px, overlap_px;
    uint tileable;
    uint first_block;
    uint groups_per_block;
    uint columns, rows;
    // In 1/10,000.
    uint tolerance;
    uint seed, frame;
    // The rows of positions that were compared: first_row, first_row + row_step, ...
    uint first_row, row_step;
    // Rows of `tile_bounds` that a block has.
    uint bound_rows;
} push;

// Whether only the tiles that still have a bound in `tile_bounds` were compared.
layout(constant_id = 0) const bool PRUNED = false;
// Entries of `group_minima` that a group has.
layout(constant_id = 1) const uint PARTS = 1;

#include "fields.glsl"
#include "tile_bounds.glsl"

const uint LEFT = 0;
const uint TOP = 1;
const uint RIGHT = 2;
const uint BOTTOM = 3;

shared uint scratch[GROUP];
// The cumulative errors of one strip, `overlap_px` to a step along it.
shared uint cumulative[MAX_BLOCK * MAX_OVERLAP];
shared uint cuts[4 * MAX_BLOCK];
shared uint in_span[GROUP];
shared uvec2 position;
shared uint position_error;

bool is_compared(uint slot, uint tile) {
    return !PRUNED || imageLoad(tile_bounds, bound_word(slot, push.bound_rows, tile)).r != NO_BOUND;
}

uint group_least(uint group) {
    uint least = group_minima[group * PARTS];
    for (uint i = 1; i < PARTS; i++) {
        least = min(least, group_minima[group * PARTS + i]);
    }
    return least;
}

uint admissible_of(uvec4 e, uint limit) {
    return uint(e.x <= limit && e.x != 0xffffffffu) + uint(e.y <= limit && e.y != 0xffffffffu) +
           uint(e.z <= limit && e.z != 0xffffffffu) + uint(e.w <= limit && e.w != 0xffffffffu);
}

// Chooses among the block's admissible positions; leaves position, position_error; returns the least error.
uint choose(uint slot, uint index, uint sx0, uint tiles_x, uint groups) {
    uint lane = gl_LocalInvocationID.x;
    uint first = slot * push.groups_per_block;
    uint least = 0xffffffffu;
    for (uint group = lane; group < groups; group += GROUP) {
        least = min(least, group_least(first + group));
    }
    scratch[lane] = least;
    in_span[lane] = 0;
    for (uint stride = GROUP / 2; stride > 0; stride /= 2) {
        barrier();
        if (lane < stride) {
            scratch[lane] = min(scratch[lane], scratch[lane + stride]);
        }
    }
    barrier();
    least = scratch[0];
    uint limit = threshold(least, push.tolerance);

    // How many are admissible, in each of GROUP spans of groups and in all.
    uint span = (groups + GROUP - 1) / GROUP;
    for (uint begin = 0, at = 0; begin < groups; begin += span, at++) {
        uint mine = 0;
        uint end = min(begin + span, groups);
        for (uint group = begin; group < end; group++) {
            if (group_least(first + group) <= limit) {
                if (is_compared(slot, group * GROUP + lane)) {
                    uint place = ((first + group) * GROUP + lane) * 2;
                    mine += admissible_of(errors[place], limit) + admissible_of(errors[place + 1], limit);
                }
            }
        }
        if (mine > 0) {
            atomicAdd(in_span[at], mine);
        }
    }
    barrier();
    uint admissible = 0;
    for (uint at = 0; at < GROUP; at++) {
        admissible += in_span[at];
    }
    uint wanted;
    uint low;
    umulExtended(random_bits(push.seed, index, push.frame), admissible, wanted, low);

    // The span that holds the wanted one, then the group, then the invocation, then the position. Only one span's
    // groups are looked at again: some compilers allow an invocation no more than 65,535 rounds of loops in all.
    uint before = 0;
    uint wanted_span = 0;
    while (wanted_span + 1 < GROUP && before + in_span[wanted_span] <= wanted) {
        before += in_span[wanted_span];
        wanted_span++;
    }
    uint last_group = min((wanted_span + 1) * span, groups);
    for (uint group = wanted_span * span; group < last_group; group++) {
        if (group_least(first + group) > limit) {
            continue;
        }
        uint place = ((first + group) * GROUP + lane) * 2;
        bool compared = is_compared(slot, group * GROUP + lane);
        uvec4 a = compared ? errors[place] : uvec4(0xffffffffu);
        uvec4 b = compared ? errors[place + 1] : uvec4(0xffffffffu);
        uint mine_here = admissible_of(a, limit) + admissible_of(b, limit);
        barrier();
        scratch[lane] = mine_here;
        // Inclusive prefix sums over the group.
        for (uint stride = 1; stride < GROUP; stride *= 2) {
            barrier();
            uint left = lane >= stride ? scratch[lane - stride] : 0;
            barrier();
            scratch[lane] += left;
        }
        barrier();
        uint in_group = scratch[GROUP - 1];
        uint start = before + scratch[lane] - mine_here;
        if (wanted >= start && wanted < start + mine_here) {
            uint e[TILE] = uint[](a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
            uint rank = start;
            for (uint j = 0; j < TILE; j++) {
                if (e[j] <= limit && e[j] != 0xffffffffu) {
                    if (rank == wanted) {
                        uint tile = group * GROUP + lane;
                        position = uvec2(sx0 + TILE * (tile % tiles_x) + j, push.first_row + push.row_step * (tile / tiles_x));
                        position_error = e[j];
                    }
                    rank++;
                }
            }
        }
        before += in_group;
        if (before > wanted) {
            break;
        }
    }
    barrier();
    return least;
}

// What is painted on the block's pixel at `dx`, `dy`; 0 if nothing is.
uint canvas_at(Block block, uint dx, uint dy) {
    uint x = block.x + dx;
    uint y = block.y + dy;
    x -= x >= push.output_width ? push.output_width : 0;
    y -= y >= push.output_height ? push.output_height : 0;
    return imageLoad(canvas, ivec2(x, y)).r;
}

// The pixel of the block that lies `along` and `across` the strip of `side`.
uvec2 strip_pixel(Block block, uint side, uint along, uint across) {
    if (side == LEFT) {
        return uvec2(across, along);
    } else if (side == TOP) {
        return uvec2(along, across);
    } else if (side == RIGHT) {
        return uvec2(block.width - push.overlap_px + across, along);
    }
    return uvec2(along, block.height - push.overlap_px + across);
}

// The minimum-error cut through the strip of `side` into cuts[side * MAX_BLOCK ...].
void cut(Block block, uint side) {
    uint lane = gl_LocalInvocationID.x;
    bool vertical = side == LEFT || side == RIGHT;
    uint length = vertical ? block.height : block.width;
    uint strip = min(push.overlap_px, vertical ? block.width : block.height);
    barrier();
    for (uint i = lane; i < length * strip; i += GROUP) {
        uvec2 p = strip_pixel(block, side, i / strip, i % strip);
        uint old = canvas_at(block, p.x, p.y);
        uint new = imageLoad(sample_texels, ivec2(position + p)).r;
        cumulative[i] = old >= PAINTED ? squared_difference(old, new) : 0;
    }
    for (uint step = 1; step < length; step++) {
        barrier();
        if (lane < strip) {
            uint row = (step - 1) * strip;
            uint best = cumulative[row + lane];
            if (lane > 0) {
                best = min(best, cumulative[row + lane - 1]);
            }
            if (lane + 1 < strip) {
                best = min(best, cumulative[row + lane + 1]);
            }
            cumulative[step * strip + lane] += best;
        }
    }
    barrier();
    if (lane == 0) {
        uint low = 0;
        uint high = strip;
        for (uint step = length; step-- > 0;) {
            uint best = low;
            for (uint j = low + 1; j < high; j++) {
                if (cumulative[step * strip + j] < cumulative[step * strip + best]) {
                    best = j;
                }
            }
            cuts[side * MAX_BLOCK + step] = best;
            low = best - min(best, 1u);
            high = min(best + 2, strip);
        }
    }
    barrier();
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.x;
    uint index = order[push.first_block + slot];
    Block block = blocks[index];
    if (block.state != STATE_PENDING) {
        return;
    }
    uint tiles_x = (block.sx1 - block.sx0 + TILE) / TILE;
    uint tiles = tiles_x * ((push.sample_height - push.block_px - push.first_row) / push.row_step + 1);
    uint least = choose(slot, index, block.sx0, tiles_x, (tiles + GROUP - 1) / GROUP);

    int row = int(index / push.columns);
    int col = int(index % push.columns);
    bool joined[4];
    joined[LEFT] = placed(row, col, 0, -1);
    joined[TOP] = placed(row, col, -1, 0);
    joined[RIGHT] = placed(row, col, 0, 1);
    joined[BOTTOM] = placed(row, col, 1, 0);
    for (uint side = 0; side < 4; side++) {
        if (joined[side]) {
            cut(block, side);
        }
    }

    uint overlap = push.overlap_px;
    for (uint i = lane; i < block.width * block.height; i += GROUP) {
        uint dx = i % block.width;
        uint dy = i / block.width;
        uint x = block.x + dx;
        uint y = block.y + dy;
        x -= x >= push.output_width ? push.output_width : 0;
        y -= y >= push.output_height ? push.output_height : 0;
        bool keep = joined[LEFT] && dx < overlap && dx < cuts[LEFT * MAX_BLOCK + dy];
        keep = keep || (joined[TOP] && dy < overlap && dy < cuts[TOP * MAX_BLOCK + dx]);
        keep = keep || (joined[RIGHT] && dx + overlap >= block.width &&
                        dx + overlap - block.width > cuts[RIGHT * MAX_BLOCK + dy]);
        keep = keep || (joined[BOTTOM] && dy + overlap >= block.height &&
                        dy + overlap - block.height > cuts[BOTTOM * MAX_BLOCK + dx]);
        keep = keep && canvas_at(block, dx, dy) >= PAINTED;
        if (!keep) {
            uvec2 from = position + uvec2(dx, dy);
            uint texel = imageLoad(sample_texels, ivec2(from)).r;
            imageStore(canvas, ivec2(x, y), uvec4(texel | PAINTED));
            imageStore(source, ivec2(x, y), uvec4(from.x | (from.y << 16)));
        }
    }
    if (lane == 0) {
        blocks[index].state = STATE_PLACED;
        blocks[index].sx = position.x;
        blocks[index].sy = position.y;
        blocks[index].error = position_error;
        blocks[index].min_error = least;
    }
}
