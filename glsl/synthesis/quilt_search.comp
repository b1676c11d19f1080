#version 450
// Quilting, second stage: the overlap error of the blocks of one wave at every allowed position of the sample.
//
// Thesis 3.2.2; Efros and Freeman 2001. The error is the sum of squared differences of 8-bit RGB over those pixels of
// the block that are painted already (the L of its overlaps), each pixel once.
// Work: a workgroup compares GROUP * TILE positions in raster order, an invocation TILE neighbours in x, so that a
// texel of the sample that is loaded and unpacked once serves TILE comparisons.
// Arithmetic: sum (a - b)^2 = sum (a^2 - 2ab) + sum b^2. The terms of one row of a block stay below 64 * 3 * 255^2
// < 2^24, so 32-bit floats hold them exactly, with or without fused operations; rows are added up as integers.
// In:  sample (8 texels wider than it is, so that no load leaves it), canvas, blocks, the blocks' order.
// Out: errors, in raster order with rows of positions padded to TILE; padding is 2^32 - 1. Least error of each group.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D canvas;
layout(binding = 2, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 3, std430) readonly buffer Order { uint order[]; };
layout(binding = 4, std430) writeonly buffer Errors { uvec4 errors[]; };
layout(binding = 5, std430) writeonly buffer GroupMinima { uint group_minima[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_height;
    uint block_px, overlap_px;
    uint tileable;
    // The blocks of this dispatch are order[first_block + gl_WorkGroupID.y].
    uint first_block;
    // Groups are first_group + gl_WorkGroupID.x of groups_per_block.
    uint first_group, groups_per_block;
} push;

shared uint least[GROUP];

vec4 load_sample(int x, int y) {
    vec3 rgb = vec3(unpack_rgb(imageLoad(sample_texels, ivec2(x, y)).r));
    return vec4(rgb, dot(rgb, rgb));
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.y;
    Block block = blocks[order[push.first_block + slot]];
    if (block.state != STATE_PENDING) {
        return;
    }
    uint group = push.first_group + gl_WorkGroupID.x;
    uint columns = block.sx1 - block.sx0 + 1;
    uint tiles_x = (columns + TILE - 1) / TILE;
    uint rows = push.sample_height - push.block_px + 1;
    if (group * GROUP >= tiles_x * rows) {
        return;
    }
    uint tile = group * GROUP + lane;
    bool live = tile < tiles_x * rows;
    uint tile_x = live ? tile % tiles_x : 0;
    int sx = int(block.sx0 + TILE * tile_x);
    int sy = int(live ? tile / tiles_x : 0);

    int total[TILE];
    for (int j = 0; j < TILE; j++) {
        total[j] = 0;
    }
    int overlap = int(push.overlap_px);
    int width = int(block.width);
    int height = int(block.height);
    int runs = push.tileable != 0 ? 2 : 1;
    for (int dy = 0; dy < height; dy++) {
        int y = int(block.y) + dy;
        y -= y >= int(push.output_height) ? int(push.output_height) : 0;
        bool whole_row = dy < overlap || (push.tileable != 0 && dy >= height - overlap);
        int row_runs = whole_row ? 1 : runs;
        for (int run = 0; run < row_runs; run++) {
            int begin = run == 0 ? 0 : width - overlap;
            int end = whole_row || run == 1 ? width : min(overlap, width);
            float sum[TILE];
            vec4 a[TILE];
            for (int j = 0; j < TILE; j++) {
                sum[j] = 0.0;
            }
            for (int j = 1; j < TILE; j++) {
                a[j] = load_sample(sx + begin + j - 1, sy + dy);
            }
            float constant = 0.0;
            for (int dx = begin; dx < end; dx++) {
                for (int j = 0; j + 1 < TILE; j++) {
                    a[j] = a[j + 1];
                }
                a[TILE - 1] = load_sample(sx + dx + int(TILE) - 1, sy + dy);
                int x = int(block.x) + dx;
                x -= x >= int(push.output_width) ? int(push.output_width) : 0;
                uint texel = imageLoad(canvas, ivec2(x, y)).r;
                vec3 b = vec3(unpack_rgb(texel));
                float painted = texel >= PAINTED ? 1.0 : 0.0;
                constant += dot(b, b);
                b *= -2.0;
                for (int j = 0; j < TILE; j++) {
                    sum[j] += painted * a[j].w + dot(a[j].xyz, b);
                }
            }
            for (int j = 0; j < TILE; j++) {
                total[j] += int(sum[j] + constant);
            }
        }
    }

    uint mine = 0xffffffffu;
    uint error[TILE];
    for (uint j = 0; j < TILE; j++) {
        error[j] = live && TILE * tile_x + j < columns ? uint(total[j]) : 0xffffffffu;
        mine = min(mine, error[j]);
    }
    uint place = ((slot * push.groups_per_block + group) * GROUP + lane) * (TILE / 4);
    for (uint j = 0; j < TILE / 4; j++) {
        errors[place + j] = uvec4(error[4 * j], error[4 * j + 1], error[4 * j + 2], error[4 * j + 3]);
    }
    least[lane] = mine;
    for (uint stride = GROUP / 2; stride > 0; stride /= 2) {
        barrier();
        if (lane < stride) {
            least[lane] = min(least[lane], least[lane + stride]);
        }
    }
    if (lane == 0) {
        group_minima[slot * push.groups_per_block + group] = least[0];
    }
}
