#version 450
// Pruned quilting, for the blocks of one wave: a lower bound of the overlap error at every allowed position, and which
// positions it leaves.
//
// A product of two matrices: the coordinates of the sample's strips at each position (src/synthesis/strips.rs) and the
// templates of the blocks. An invocation takes a position, or ROWS of them one above the other, and BLOCKS blocks, so
// that each coordinate that is loaded serves several products.
// The templates lie in a uniform buffer. Without a guide, a dispatch has one chunk of blocks, whose coordinates stand
// at places that are known when the pipeline is made: lavapipe reads those once for all invocations.
// In:  coordinates of the left and of the top strip at each position, layer below layer; templates, limits.  Out: survivors.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "prune.glsl"

// A tile of positions across, as lavapipe has invocations in a vector.
layout(local_size_x = 8, local_size_y = 16) in;

// Blocks of the chunk that there are.
layout(constant_id = 1) const uint BLOCKS = 8;
// Rows of positions of an invocation.
layout(constant_id = 2) const uint ROWS = 1;
// Whether each block is searched for within a window of its own; then STRIDE and BLOCKS are 1.
layout(constant_id = 3) const bool WINDOWED = false;

layout(binding = 0, rgba32f) uniform readonly image2D left_strips;
layout(binding = 1, rgba32f) uniform readonly image2D top_strips;
layout(binding = 2, r32ui) uniform uimage2D survivors;
layout(binding = 3, rgba32f) uniform readonly image2D templates;
layout(binding = 4, std430) readonly buffer Limits { float limits[]; };

layout(push_constant) uniform Push {
    uint position_columns, position_rows;
    // Where blocks begin in `limits` and in `survivors`; windowed ones go on by gl_WorkGroupID.z.
    uint first_slot;
    uint survivor_rows;
} push;

const uint TILE = 8;
#include "survivors.glsl"

// The number of an invocation that is broadcast has to be a literal.
#define EACH_BLOCK(DO) DO(0) DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7)

shared vec4 tm[8 * 17];
void main() {
    uint lane = gl_SubgroupInvocationID;
    uint first_slot = push.first_slot + (WINDOWED ? gl_WorkGroupID.z : 0);
    // Column of `templates`
    uint n = first_slot + (WINDOWED ? 0 : lane % 8);
    for (uint i = gl_LocalInvocationIndex; i < 8 * 17; i += 128) { tm[i] = imageLoad(templates, ivec2(push.first_slot + i % 8, i / 8)); }
    barrier();
    vec4 header = imageLoad(templates, ivec2(n, STRIPS * LAYERS));
    uint columns = WINDOWED ? uint(header.z) : push.position_columns;
    uint column = gl_GlobalInvocationID.x;
    uint row = gl_GlobalInvocationID.y * ROWS;
    bool live = column < columns;
    int sx = int(min(column, columns - 1)) + (WINDOWED ? int(header.y) : 0);
    float bound[ROWS * BLOCKS];
#define BEGIN(k)                                                                                                       \
    [[unroll]] for (uint r = 0; r < (k < BLOCKS ? ROWS : 0); r++) {                                                    \
        bound[r * BLOCKS + k] = subgroupBroadcast(header.x, k);                                                        \
    }
    EACH_BLOCK(BEGIN)
    [[unroll]] for (uint layer = 0; layer < STRIPS * LAYERS; layer++) {
        uint strip = layer / LAYERS;
        vec4 a[ROWS];
        [[unroll]] for (uint r = 0; r < ROWS; r++) {
            ivec2 at = ivec2(sx, min(row + r, push.position_rows - 1) + push.position_rows * (layer % LAYERS));
            a[r] = strip == LEFT ? imageLoad(left_strips, at) : imageLoad(top_strips, at);
        }
#define ADD(k)                                                                                                         \
    vec4 b##k = tm[layer * 8 + k];                                                                      \
    [[unroll]] for (uint r = 0; r < (k < BLOCKS ? ROWS : 0); r++) {                                                    \
        bound[r * BLOCKS + k] += a[r].x * b##k.x + a[r].y * b##k.y + a[r].z * b##k.z + a[r].w * b##k.w;                \
    }
        EACH_BLOCK(ADD)
    }
    uint tiles_x = (columns + TILE - 1) / TILE;
    [[unroll]] for (uint k = 0; k < BLOCKS; k++) {
        float limit = limits[first_slot + k];
        [[unroll]] for (uint r = 0; r < ROWS; r++) {
            if (bound[r * BLOCKS + k] <= limit && live && row + r < push.position_rows) {
                uint tile = (row + r) * tiles_x + column / TILE;
                ivec2 at = survivor_word(first_slot + k, push.survivor_rows, tile);
                imageAtomicOr(survivors, at, 1u << (survivor_bit(tile) + column % TILE));
            }
        }
    }
}
