#version 450
// Quilting, third stage: choice, minimum-error cut and paste of the blocks of one wave.
//
// One workgroup a block; the blocks of a wave touch disjoint pixels.
// Choice: uniform among the positions with error <= (1 + tolerance) * least, in raster order.
// Cut: on each side whose neighbour is placed, the path through the strip of the overlap with the least sum of squared
// differences, by dynamic programming, ties to the lowest index (thesis 3.2.2; Efros and Freeman 2001).
// Paste: a painted pixel beyond a cut stays as it is, every other one takes the new block's texel.
// A neighbour may be placed on any side: those to the right and below are where texture was carried along.
// In:  errors and group minima of this wave's search, and, if it was pruned, which tiles have errors.
// Out: canvas, source coordinates, the blocks' records.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform uimage2D canvas;
// x + (y << 16) of the sample's texel that each pixel came from.
layout(binding = 2, r32ui) uniform writeonly uimage2D source;
layout(binding = 3, r32ui) uniform uimage2D tile_bounds;
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

// Bits of a word of `list` that count; the others number an invocation.
const uint COUNT_BITS = 25;
// Low bits of a word of `cumulative`, see there.
const uint FROM_BITS = 5;
const uint FROM = MAX_OVERLAP - 1;

// What all invocations need to know of the block; to read it once is less than once an invocation.
shared uint index;
shared Block shared_block;
// Bit `side` is set where the neighbour on that side is placed.
shared uint shared_joined;

shared uint least_error;
shared uint admissible;
shared uint in_span[GROUP];
shared uint wanted_span;
shared uint before_span;
shared uint is_found;
shared uvec2 position;
shared uint position_error;

// What `gather` gathered.
shared uint list[GROUP];
shared uint listed;

// The cumulative errors of the strips that are cut together, each `block_px` * `overlap_px` words, a strip's width to a
// step along it. A word is (error << FROM_BITS) | where the path came from: below 64 * 3 * 255^2 << 5, so it fits.
shared uint cumulative[MAX_BLOCK * MAX_OVERLAP];
// How many pixels lie beyond the cuts, for each row and then for each column of the block: from its left or upper edge
// on in the low byte, up to its right or lower edge in the next.
shared uint beyond[2 * MAX_BLOCK];

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

// Gathers the `entry` of each invocation that has one into `list`, in any order; returns how many there are.
uint gather(bool has, uint entry) {
    barrier();
    if (gl_LocalInvocationID.x == 0) {
        listed = 0;
    }
    barrier();
    if (has) {
        list[atomicAdd(listed, 1)] = entry;
    }
    barrier();
    return listed;
}

// Whether this invocation has item `wanted`, when each has `count` of them and they are numbered in the invocations'
// order; `before` is how many the invocations before have. Few have any, so that this beats prefix sums over all.
bool has_item(uint count, uint wanted, out uint before) {
    uint lane = gl_LocalInvocationID.x;
    uint n = gather(count > 0, (lane << COUNT_BITS) | count);
    before = 0;
    for (uint i = 0; count > 0 && i < n; i++) {
        uint entry = list[i];
        before += (entry >> COUNT_BITS) < lane ? bitfieldExtract(entry, 0, int(COUNT_BITS)) : 0;
    }
    return wanted >= before && wanted - before < count;
}

// The least of the block's errors, for all invocations.
uint least_of(uint first, uint groups) {
    uint least = 0xffffffffu;
    for (uint group = gl_LocalInvocationID.x; group < groups; group += GROUP) {
        least = min(least, group_least(first + group));
    }
    if (least != 0xffffffffu) {
        atomicMin(least_error, least);
    }
    barrier();
    return least_error;
}

// The errors of this invocation's tile in `group`; 2^32 - 1 where nothing was compared.
void load_errors(uint slot, uint group, out uvec4 a, out uvec4 b) {
    uint lane = gl_LocalInvocationID.x;
    a = uvec4(0xffffffffu);
    b = a;
    if (is_compared(slot, group * GROUP + lane)) {
        uint place = ((slot * push.groups_per_block + group) * GROUP + lane) * 2;
        a = errors[place];
        b = errors[place + 1];
    }
}

// Counts the admissible positions, in each of GROUP spans of groups and in all.
void count_admissible(uint slot, uint groups, uint span, uint limit) {
    uint first = slot * push.groups_per_block;
    for (uint begin = 0; begin < groups; begin += GROUP) {
        uint mine = begin + gl_LocalInvocationID.x;
        uint n = gather(mine < groups && group_least(first + mine) <= limit, mine);
        for (uint i = 0; i < n; i++) {
            uint group = list[i];
            uvec4 a, b;
            load_errors(slot, group, a, b);
            uint count = admissible_of(a, limit) + admissible_of(b, limit);
            if (count > 0) {
                atomicAdd(in_span[group / span], count);
                atomicAdd(admissible, count);
            }
        }
    }
    barrier();
}

// Leaves position and position_error of the admissible position `wanted` of this invocation's tile.
void take(uint tile, uint tiles_x, uvec4 a, uvec4 b, uint limit, uint wanted) {
    uint e[TILE] = uint[](a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
    uint rank = 0;
    for (uint j = 0; j < TILE; j++) {
        if (e[j] <= limit && e[j] != 0xffffffffu) {
            if (rank == wanted) {
                position = uvec2(shared_block.sx0 + TILE * (tile % tiles_x) + j,
                                 push.first_row + push.row_step * (tile / tiles_x));
                position_error = e[j];
            }
            rank++;
        }
    }
}

// Chooses among the block's admissible positions; leaves position, position_error; returns the least error.
uint choose(uint slot, uint tiles_x, uint groups) {
    uint lane = gl_LocalInvocationID.x;
    uint first = slot * push.groups_per_block;
    uint least = least_of(first, groups);
    uint limit = threshold(least, push.tolerance);
    uint span = (groups + GROUP - 1) / GROUP;
    count_admissible(slot, groups, span, limit);
    uint wanted;
    uint low;
    umulExtended(random_bits(push.seed, index, push.frame), admissible, wanted, low);

    // The span that holds the wanted one, then the group, then the invocation, then the position. Only one span's
    // groups are looked at again: some compilers allow an invocation no more than 65,535 rounds of loops in all.
    uint before;
    if (has_item(in_span[lane], wanted, before)) {
        wanted_span = lane;
        before_span = before;
    }
    barrier();
    wanted -= before_span;
    uint begin = wanted_span * span;
    uint end = min(begin + span, groups);
    for (uint group = begin; group < end && is_found == 0; group++) {
        if (group_least(first + group) > limit) {
            continue;
        }
        uvec4 a, b;
        load_errors(slot, group, a, b);
        if (has_item(admissible_of(a, limit) + admissible_of(b, limit), wanted, before)) {
            take(group * GROUP + lane, tiles_x, a, b, limit, wanted - before);
            is_found = 1;
        }
        barrier();
        if (is_found == 0) {
            for (uint i = 0; i < listed; i++) {
                wanted -= bitfieldExtract(list[i], 0, int(COUNT_BITS));
            }
        }
    }
    barrier();
    return least;
}

// Where the block's pixel `p` lies on the canvas.
ivec2 canvas_pixel(Block block, uvec2 p) {
    uvec2 size = uvec2(push.output_width, push.output_height);
    uvec2 at = uvec2(block.x, block.y) + p;
    return ivec2(at - mix(uvec2(0), size, greaterThanEqual(at, size)));
}

// The next place of an invocation that walks through rows of `width` in strides of x + y * width = GROUP.
uvec2 walk(uvec2 at, uvec2 stride, uint width) {
    at += stride;
    return at.x < width ? at : uvec2(at.x - width, at.y + 1);
}

bool is_joined(uint joined, uint side) {
    return (joined & (1u << side)) != 0;
}

// The width of the strip of `side`, and its length.
uvec2 strip_size(Block block, uint side) {
    bool vertical = side == LEFT || side == RIGHT;
    uvec2 size = vertical ? uvec2(block.width, block.height) : uvec2(block.height, block.width);
    return uvec2(min(push.overlap_px, size.x), size.y);
}

// The pixel of the block that lies `p.x` across and `p.y` along the strip of `side`.
uvec2 strip_pixel(Block block, uint side, uvec2 p) {
    if (side == LEFT) {
        return p;
    } else if (side == TOP) {
        return p.yx;
    } else if (side == RIGHT) {
        return uvec2(block.width - push.overlap_px + p.x, p.y);
    }
    return uvec2(p.y, block.height - push.overlap_px + p.x);
}

// Puts the squared differences in the strip of `side` into cumulative[base ...].
void compare_strip(Block block, uint side, uint base) {
    uint lane = gl_LocalInvocationID.x;
    uvec2 size = strip_size(block, side);
    uvec2 stride = uvec2(GROUP % size.x, GROUP / size.x);
    uvec2 at = uvec2(lane % size.x, lane / size.x);
    for (uint i = base + lane; at.y < size.y; i += GROUP) {
        uvec2 p = strip_pixel(block, side, at);
        uint old = imageLoad(canvas, canvas_pixel(block, p)).r;
        uint new = imageLoad(sample_texels, ivec2(position + p)).r;
        cumulative[i] = old >= PAINTED ? squared_difference(old, new) << FROM_BITS : 0;
        at = walk(at, stride, size.x);
    }
}

// A word of `cumulative` as the way over place `across` of the strip. The least of several is the one of least error
// and, among equals, of the lowest place.
uint way(uint word, uint across) {
    return (word & ~FROM) | across;
}

// Follows the path of least error through the strip at cumulative[base ...] back from its end.
void trace(Block block, uint side, uint base) {
    uvec2 size = strip_size(block, side);
    bool low = side == LEFT || side == TOP;
    uint line = side == LEFT || side == RIGHT ? 0 : MAX_BLOCK;
    uint row = base + (size.y - 1) * size.x;
    uint best = 0xffffffffu;
    for (uint j = 0; j < size.x; j++) {
        best = min(best, way(cumulative[row + j], j));
    }
    uint across = best & FROM;
    for (uint step = size.y; step-- > 0;) {
        // The strips of two sides write to the same word.
        atomicAdd(beyond[line + step], low ? across : (push.overlap_px - 1 - across) << 8);
        across = cumulative[row + across] & FROM;
        row -= size.x;
    }
}

// The minimum-error cuts through the strips of `count` sides from `first` on, into `beyond`; MAX_OVERLAP invocations
// a side.
void cut(Block block, uint joined, uint first, uint count) {
    uint lane = gl_LocalInvocationID.x;
    uint words = push.block_px * push.overlap_px;
    barrier();
    for (uint i = 0; i < count; i++) {
        if (is_joined(joined, first + i)) {
            compare_strip(block, first + i, i * words);
        }
    }
    uint nth = lane / MAX_OVERLAP;
    uint across = lane % MAX_OVERLAP;
    uvec2 size = strip_size(block, first + nth);
    uint steps = nth < count && is_joined(joined, first + nth) && across < size.x ? size.y : 0;
    uint left = max(across, 1) - 1;
    uint right = min(across + 1, size.x - 1);
    uint row = nth * words;
    for (uint step = 1; step < max(block.width, block.height); step++) {
        barrier();
        if (step < steps) {
            uint best = min(way(cumulative[row + left], left), way(cumulative[row + across], across));
            best = min(best, way(cumulative[row + right], right));
            row += size.x;
            cumulative[row + across] += best;
        }
    }
    barrier();
    if (lane < count && is_joined(joined, first + lane)) {
        trace(block, first + lane, lane * words);
    }
}

// Finds the cuts on all sides, as many at a time as have room in `cumulative`.
void cut_all(Block block, uint joined) {
    uint room = MAX_BLOCK * MAX_OVERLAP / (push.block_px * push.overlap_px);
    uint count = room >= 4 ? 4 : room >= 2 ? 2 : 1;
    for (uint first = 0; first < 4; first += count) {
        if (bitfieldExtract(joined, int(first), int(count)) != 0) {
            cut(block, joined, first, count);
        }
    }
    barrier();
}

// Pastes the block from `position`, but for the painted pixels beyond a cut.
void paste(Block block) {
    uint lane = gl_LocalInvocationID.x;
    uvec2 size = uvec2(block.width, block.height);
    uvec2 stride = uvec2(GROUP % size.x, GROUP / size.x);
    uvec2 corner = position;
    uvec2 p = uvec2(lane % size.x, lane / size.x);
    while (p.y < size.y) {
        uvec2 lines = uvec2(beyond[p.y], beyond[MAX_BLOCK + p.x]);
        ivec2 at = canvas_pixel(block, p);
        bool keep = any(lessThan(p, lines & 255u)) || any(lessThan(size - 1 - p, lines >> 8));
        if (!keep || imageLoad(canvas, at).r < PAINTED) {
            uvec2 from = corner + p;
            uint texel = imageLoad(sample_texels, ivec2(from)).r;
            imageStore(canvas, at, uvec4(texel | PAINTED));
            imageStore(source, at, uvec4(from.x | (from.y << 16)));
        }
        p = walk(p, stride, size.x);
    }
}

// Whether the neighbour on `side` is placed.
bool is_neighbour_placed(uint side) {
    int row = int(index / push.columns);
    int col = int(index % push.columns);
    int away = side == LEFT || side == TOP ? -1 : 1;
    bool vertical = side == LEFT || side == RIGHT;
    return placed(row, col, vertical ? 0 : away, vertical ? away : 0);
}

// Fills the shared variables that have a value from the start.
void begin() {
    uint lane = gl_LocalInvocationID.x;
    if (lane == 0) {
        index = order[push.first_block + gl_WorkGroupID.x];
        shared_block = blocks[index];
        shared_joined = 0;
        least_error = 0xffffffffu;
        admissible = 0;
        wanted_span = 0;
        before_span = 0;
        is_found = 0;
    }
    in_span[lane] = 0;
    beyond[lane] = 0;
    barrier();
    if (lane < 4 && is_neighbour_placed(lane)) {
        atomicOr(shared_joined, 1u << lane);
    }
    barrier();
}

// For the next wave.
void clear_bounds(uint slot, uint tiles) {
    for (uint tile = gl_LocalInvocationID.x; tile < tiles; tile += GROUP) {
        imageStore(tile_bounds, bound_word(slot, push.bound_rows, tile), uvec4(NO_BOUND));
    }
}

void main() {
    begin();
    Block block = shared_block;
    if (block.state != STATE_PENDING) {
        return;
    }
    uint tiles_x = (block.sx1 - block.sx0 + TILE) / TILE;
    uint tiles = tiles_x * ((push.sample_height - push.block_px - push.first_row) / push.row_step + 1);
    uint least = choose(gl_WorkGroupID.x, tiles_x, (tiles + GROUP - 1) / GROUP);
    cut_all(block, shared_joined);
    paste(block);
    if (PRUNED) {
        clear_bounds(gl_WorkGroupID.x, tiles);
    }
    if (gl_LocalInvocationID.x == 0) {
        blocks[index].state = STATE_PLACED;
        blocks[index].sx = position.x;
        blocks[index].sy = position.y;
        blocks[index].error = position_error;
        blocks[index].min_error = least;
    }
}
