#version 450
// Pruned quilting, for the blocks of one wave: a lower bound of the overlap error at every allowed position, and which
// tiles of positions it leaves.
//
// A product of two matrices: the coordinates of the sample's strips at each position (src/synthesis/strips.rs) and the
// templates of the blocks. An invocation takes a position, or ROWS of them one above the other, and BLOCKS blocks, so
// that each coordinate that is loaded serves several products.
// Without a guide, a dispatch has one chunk of blocks, whose templates stand in shared memory at places that are known
// when the pipeline is made: lavapipe reads those once for all invocations.
// In:  coordinates of the sample's strips at each position, texel below texel; templates, least errors known.
// Out: tile_bounds.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "quilt.glsl"
#include "prune.glsl"

// A tile of positions across, as lavapipe has invocations in a vector.
layout(local_size_x = 8, local_size_y = 16) in;

// Blocks of the chunk that there are.
layout(constant_id = 1) const uint BLOCKS = 8;
// At most.
const uint MAX_BLOCKS = 10;
// Rows of positions of an invocation.
layout(constant_id = 2) const uint ROWS = 1;
// Whether each block is searched for within a window of its own; then BLOCKS is 1.
layout(constant_id = 3) const bool WINDOWED = false;
// A bit for each texel whose last word is the squared length of a strip.
layout(constant_id = 4) const uint SQUARES = 0x88;

layout(binding = 0, rgba32ui) uniform readonly uimage2D coordinates;
layout(binding = 1, r32ui) uniform uimage2D tile_bounds;
layout(binding = 2, rgba32f) uniform readonly image2D templates;
layout(binding = 3, std430) readonly buffer GroupMinima { uint group_minima[]; };

layout(push_constant) uniform Push {
    uint position_columns, position_rows;
    // Where blocks begin among templates, least errors and `tile_bounds`; windowed ones go on by gl_WorkGroupID.z.
    uint first_slot;
    // How many blocks the wave has; in the last chunk there may be fewer than BLOCKS left.
    uint slots;
    uint bound_rows;
    // In 1/10,000.
    uint tolerance;
    // Where the least errors of `quilt_aim` begin among the groups' minima.
    uint first_least;
} push;

#include "tile_bounds.glsl"

// Those of a chunk of blocks, and last their headers; shared, because lavapipe reads what is shared, at a place that is
// known when the pipeline is made, once for all invocations.
shared vec4 chunk[(2 * MAX_TEXELS + 1) * MAX_BLOCKS];
shared float limits[MAX_BLOCKS];

// Two coordinates of 16 bits.
vec2 unpacked(uint word) {
    return vec2(int(word << 16) >> 16, int(word) >> 16);
}

void main() {
    uint first_slot = push.first_slot + (WINDOWED ? gl_WorkGroupID.z : 0);
    for (uint i = gl_LocalInvocationIndex; i < (2 * TEXELS + 1) * BLOCKS; i += 128) {
        chunk[i] = imageLoad(templates, ivec2(min(first_slot + i % BLOCKS, push.slots - 1), i / BLOCKS));
    }
    if (gl_LocalInvocationIndex < BLOCKS) {
        uint slot = first_slot + gl_LocalInvocationIndex;
        // A block that there is not keeps no tile: its bounds would stay for a later wave.
        bool exists = slot < push.slots;
        limits[gl_LocalInvocationIndex] =
            exists ? bound_limit(group_minima[push.first_least + slot], push.tolerance) : -3.0e38;
    }
    barrier();
    const uint headers = 2 * TEXELS * BLOCKS;
    uint columns = WINDOWED ? uint(chunk[headers].z) : push.position_columns;
    uint column = gl_GlobalInvocationID.x;
    uint row = gl_GlobalInvocationID.y * ROWS;
    // Nothing is left early: with some invocations gone, lavapipe would read what is shared for each of the others.
    int sx = int(min(column, columns - 1)) + (WINDOWED ? int(chunk[headers].y) : 0);
    float bound[ROWS * BLOCKS];
    [[unroll]] for (uint i = 0; i < ROWS * BLOCKS; i++) {
        bound[i] = chunk[headers + i % BLOCKS].x;
    }
    [[unroll]] for (uint i = 0; i < TEXELS; i++) {
        [[unroll]] for (uint r = 0; r < ROWS; r++) {
            uint y = min(row + r, push.position_rows - 1) + push.position_rows * i;
            uvec4 words = imageLoad(coordinates, ivec2(sx, y));
            vec4 a = vec4(unpacked(words.x), unpacked(words.y));
            bool square = (SQUARES >> i & 1u) != 0;
            vec4 b = vec4(unpacked(words.z), square ? vec2(uintBitsToFloat(words.w), 0.0) : unpacked(words.w));
            [[unroll]] for (uint k = 0; k < BLOCKS; k++) {
                bound[r * BLOCKS + k] += dot(a, chunk[2 * i * BLOCKS + k]) + dot(b, chunk[(2 * i + 1) * BLOCKS + k]);
            }
        }
    }
    uint tiles_x = (columns + TILE - 1) / TILE;
    [[unroll]] for (uint k = 0; k < BLOCKS; k++) {
        float limit = limits[k];
        [[unroll]] for (uint r = 0; r < ROWS; r++) {
            if (bound[r * BLOCKS + k] <= limit && column < columns && row + r < push.position_rows) {
                uint tile = (row + r) * tiles_x + column / TILE;
                ivec2 at = bound_word(first_slot + k, push.bound_rows, tile);
                imageAtomicMin(tile_bounds, at, floatBitsToUint(max(bound[r * BLOCKS + k], 0.0)));
            }
        }
    }
}
