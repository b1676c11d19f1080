#version 450
// Quilting, second stage where blocks have more to fit than their overlap: the weighted error of the blocks of one wave
// at every allowed position of the sample.
//
// The error is the sum over the block's pixels of w1 |a - c|^2 + w2 |a - p|^2: a the sample, c what is painted on the
// canvas and p what the frame before had there; a pixel that is not painted, or that no
// placed block holds, counts nothing. Thesis chapter 6 asks each
// block to match the previous frame; texture that was carried along surrounds a block on any side.
// Without a previous frame, what a position lacks of the contrast around it counts as error too: the sum of |c|^2 less
// that of |a|^2, of colours less 128, if that is above 0. A quiet position is no nearer to strokes than other strokes
// are, but half as far by squared differences; what must fit on all sides, frame after frame, would grow ever quieter.
// Arithmetic: both together are W |a|^2 - 2 a.B + C with W = w1 + w2, B = w1 c + w2 p. All colours are taken less 128,
// which changes no difference, and sums of floats stay below 2^24 over CHUNK texels, so that they are exact: see
// quilt_search, whose positions, groups and results these are. A workgroup first lists the chunks of the block that
// have any weight.
// In:  sample (TILE + CHUNK texels wider than it is), canvas, previous, blocks, the blocks' order.
// Out: errors and least error of each group, as of quilt_search.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D canvas;
layout(binding = 2, r32ui) uniform readonly uimage2D previous;
layout(binding = 3, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 4, std430) readonly buffer Order { uint order[]; };
layout(binding = 5, std430) writeonly buffer Errors { uvec4 errors[]; };
layout(binding = 6, std430) writeonly buffer GroupMinima { uint group_minima[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_height;
    uint block_px, overlap_px;
    uint tileable;
    uint columns, rows;
    // The blocks of this dispatch are order[first_block + gl_WorkGroupID.y].
    uint first_block;
    // Groups are first_group + gl_WorkGroupID.x of groups_per_block.
    uint first_group, groups_per_block;
    uint canvas_weight, previous_weight;
    // Only these rows of positions are compared: first_row, first_row + row_step, ...
    uint first_row, row_step;
} push;

// Texels of a block's row that are compared at a time. 6 * 3 * 128^2 * (1 + 2) * 18 < 2^24: weights up to 18 are exact.
const int CHUNK = 6;

// Whether the frame before is compared with at all.
layout(constant_id = 0) const bool WITH_PREVIOUS = true;

#include "fields.glsl"

const uint CHUNKS_ACROSS = (MAX_BLOCK + CHUNK - 1) / CHUNK;

shared uint painted;
shared uint count;
// Chunks with any weight: column, and row in the high half.
shared uint chunks[CHUNKS_ACROSS * MAX_BLOCK];
shared uint least[GROUP];

vec3 centred(uint texel) {
    return vec3(ivec3(unpack_rgb(texel)) - 128);
}

ivec2 place(Block block, int dx, int dy) {
    ivec2 size = ivec2(push.output_width, push.output_height);
    ivec2 at = ivec2(block.x, block.y) + ivec2(dx, dy);
    return at - ivec2(greaterThanEqual(at, size)) * size;
}

// Weights of canvas and previous frame at the block's pixel, which show `c` and `p`.
uvec2 weights(Block block, uint c, uint p, int dx, int dy) {
    bool inside = dx < int(block.width);
    bool stays = inside && c >= PAINTED && (painted & field_of(block, dx, dy)) != 0;
    return uvec2(stays ? push.canvas_weight : 0, WITH_PREVIOUS && inside && p >= PAINTED ? push.previous_weight : 0);
}

// -2 B and W of the block's pixel; adds to C.
vec4 target(Block block, int dx, int dy, inout float constant) {
    ivec2 at = place(block, min(dx, int(block.width) - 1), dy);
    uint c = imageLoad(canvas, at).r;
    uint p = WITH_PREVIOUS ? imageLoad(previous, at).r : 0;
    vec2 w = vec2(weights(block, c, p, dx, dy));
    vec3 b = centred(c);
    constant += w.x * dot(b, b);
    b *= w.x;
    if (WITH_PREVIOUS) {
        vec3 before = centred(p);
        constant += w.y * dot(before, before);
        b += w.y * before;
    }
    return vec4(-2.0 * b, w.x + w.y);
}

// The sample's colour, and |a|^2.
vec4 load_sample(int x, int y) {
    vec3 a = centred(imageLoad(sample_texels, ivec2(x, y)).r);
    return vec4(a, dot(a, a));
}

#define BLOCK_TEXEL(i) vec4 b##i = target(block, dx + i, dy, constant);
#define SAMPLE_TEXEL(k) vec4 a##k = load_sample(sx + dx + k, sy + dy);
#define POSITION(total, energy, p0, p1, p2, p3, p4, p5)                                                                \
    total += squares + int(dot(p0, b0) + dot(p1, b1) + dot(p2, b2) + dot(p3, b3) + dot(p4, b4) + dot(p5, b5));          \
    energy += WITH_PREVIOUS ? 0 : int(p0.w * b0.w + p1.w * b1.w + p2.w * b2.w + p3.w * b3.w + p4.w * b4.w + p5.w * b5.w);

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.y;
    uint index = order[push.first_block + slot];
    Block block = blocks[index];
    if (block.state != STATE_PENDING) {
        return;
    }
    uint group = push.first_group + gl_WorkGroupID.x;
    uint columns = block.sx1 - block.sx0 + 1;
    uint tiles_x = (columns + TILE - 1) / TILE;
    uint tiles = tiles_x * ((push.sample_height - push.block_px - push.first_row) / push.row_step + 1);
    if (group * GROUP >= tiles) {
        return;
    }
    uint tile = group * GROUP + lane;
    bool live = tile < tiles;
    uint tile_x = live ? tile % tiles_x : 0;
    int sx = int(block.sx0 + TILE * tile_x);
    int sy = int(push.first_row + push.row_step * (live ? tile / tiles_x : 0));

    if (lane == 0) {
        painted = painted_fields(index);
        count = 0;
    }
    barrier();
    uint across = (block.width + CHUNK - 1) / CHUNK;
    for (uint i = lane; i < across * block.height; i += GROUP) {
        uint dx = CHUNK * (i % across);
        uint dy = i / across;
        uint weight = 0;
        for (uint j = 0; j < CHUNK; j++) {
            int column = int(min(dx + j, block.width - 1));
            ivec2 at = place(block, column, int(dy));
            uint p = WITH_PREVIOUS ? imageLoad(previous, at).r : 0;
            uvec2 w = weights(block, imageLoad(canvas, at).r, p, column, int(dy));
            weight += w.x + w.y;
        }
        if (weight > 0) {
            // Integer sums do not care for the order.
            chunks[atomicAdd(count, 1)] = dx | dy << 16;
        }
    }
    barrier();
    uint chunk_count = count;

    int t0 = 0, t1 = 0, t2 = 0, t3 = 0, t4 = 0, t5 = 0, t6 = 0, t7 = 0;
    int e0 = 0, e1 = 0, e2 = 0, e3 = 0, e4 = 0, e5 = 0, e6 = 0, e7 = 0;
    int around = 0;
    for (uint i = 0; i < chunk_count; i++) {
        int dx = int(chunks[i] & 0xffffu);
        int dy = int(chunks[i] >> 16);
        float constant = 0.0;
        BLOCK_TEXEL(0) BLOCK_TEXEL(1) BLOCK_TEXEL(2) BLOCK_TEXEL(3) BLOCK_TEXEL(4) BLOCK_TEXEL(5)
        SAMPLE_TEXEL(0) SAMPLE_TEXEL(1) SAMPLE_TEXEL(2) SAMPLE_TEXEL(3) SAMPLE_TEXEL(4) SAMPLE_TEXEL(5)
        SAMPLE_TEXEL(6) SAMPLE_TEXEL(7) SAMPLE_TEXEL(8) SAMPLE_TEXEL(9) SAMPLE_TEXEL(10) SAMPLE_TEXEL(11)
        SAMPLE_TEXEL(12)
        int squares = int(constant);
        around += squares;
        POSITION(t0, e0, a0, a1, a2, a3, a4, a5)
        POSITION(t1, e1, a1, a2, a3, a4, a5, a6)
        POSITION(t2, e2, a2, a3, a4, a5, a6, a7)
        POSITION(t3, e3, a3, a4, a5, a6, a7, a8)
        POSITION(t4, e4, a4, a5, a6, a7, a8, a9)
        POSITION(t5, e5, a5, a6, a7, a8, a9, a10)
        POSITION(t6, e6, a6, a7, a8, a9, a10, a11)
        POSITION(t7, e7, a7, a8, a9, a10, a11, a12)
    }

    // The sums may pass 2^31, and are right as unsigned numbers.
    uint total[TILE] = uint[](uint(t0), uint(t1), uint(t2), uint(t3), uint(t4), uint(t5), uint(t6), uint(t7));
    int energy[TILE] = int[](e0, e1, e2, e3, e4, e5, e6, e7);
    uint mine = 0xffffffffu;
    for (uint j = 0; j < TILE; j++) {
        total[j] += WITH_PREVIOUS ? 0 : uint(max(around - energy[j], 0));
        total[j] = live && TILE * tile_x + j < columns ? total[j] : 0xffffffffu;
        mine = min(mine, total[j]);
    }
    uint at = ((slot * push.groups_per_block + group) * GROUP + lane) * (TILE / 4);
    for (uint j = 0; j < TILE / 4; j++) {
        errors[at + j] = uvec4(total[4 * j], total[4 * j + 1], total[4 * j + 2], total[4 * j + 3]);
    }
    least[lane] = mine;
    for (uint stride = GROUP / 2; stride > 0; stride /= 2) {
        barrier();
        if (lane < stride) {
            least[lane] = min(least[lane], least[lane + stride]);
        }
    }
    barrier();
    if (lane == 0) {
        group_minima[slot * push.groups_per_block + group] = least[0];
    }
}
