#version 450
// Repair, first stage: which blocks keep the texture that was carried along, and which are synthesised anew.
//
// One workgroup a block. A block answers for its cell: its part of the output up to the middle of its overlaps. It is
// synthesised anew when a covered pixel of the cell has no carried texture, when the carried texture is stretched,
// compressed or turned too far on more than half of the cell, or when it comes from another part of the sample than
// the cell's shade now asks for.
// Stretch: the way from a pixel's place to those of its neighbours to the right and below is the Jacobian J of screen
// to sample. Its singular values must lie within [least, most], and it must not turn by more than 30 degrees.
// Shade: as quilt_guide, L the mean shade of the block's covered pixels; a block of the sample whose texel (x, y) lies at
// pixel (x, y) of the block would have its left edge at the mean of place - pixel, which must lie within the window, or
// `slack` beyond it.
// In:  guide, carried places.  Out: state and allowed columns of every block. Integer arithmetic throughout.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"
#include "guided.glsl"
#include "carried.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D guide;
layout(binding = 1, rgba16ui) uniform readonly uimage2D carried;
layout(binding = 2, std430) buffer Blocks { Block blocks[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_width, sample_height;
    uint block_px, overlap_px;
    uint columns, rows;
    uint paint;
    uint window_px;
    // In texels.
    uint slack;
    // Singular values of J, in steps.
    uint least, most;
} push;

// The tangent of 30 degrees.
const int TURN_NUMERATOR = 15;
const int TURN_DENOMINATOR = 26;

shared uint covered;
shared uint shade_sum;
shared uint cell_pixels;
shared uint missing;
shared uint misfits;
shared int edge_sum;

// Whether texture with this Jacobian, its columns in steps, still looks like the sample.
bool fits(ivec2 right, ivec2 down) {
    int e = right.x * right.x + right.y * right.y + down.x * down.x + down.y * down.y;
    int det = right.x * down.y - right.y * down.x;
    // The squares of the singular values are the roots of x^2 - e x + det^2.
    int most = int(push.most * push.most);
    int least = int(push.least * push.least);
    bool below = e <= 2 * most && most * most - e * most + det * det >= 0;
    bool above = e >= 2 * least && least * least - e * least + det * det >= 0;
    bool upright = abs(right.y - down.x) * TURN_DENOMINATOR <= (right.x + down.y) * TURN_NUMERATOR;
    return below && above && upright;
}

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= blocks.length()) {
        return;
    }
    uint lane = gl_LocalInvocationID.x;
    if (lane == 0) {
        covered = 0;
        shade_sum = 0;
        cell_pixels = 0;
        missing = 0;
        misfits = 0;
        edge_sum = 0;
    }
    barrier();
    Block block = blocks[index];
    uvec2 grid = uvec2(index % push.columns, index / push.columns);
    uvec2 sample_size = uvec2(push.sample_width, push.sample_height);
    // The cell, in pixels of the block.
    uvec2 begin = mix(uvec2(push.overlap_px / 2), uvec2(0), equal(grid, uvec2(0)));
    uvec2 end = mix(uvec2(push.block_px - push.overlap_px + push.overlap_px / 2), uvec2(block.width, block.height),
                    equal(grid + 1, uvec2(push.columns, push.rows)));
    uint my_covered = 0, my_shade = 0, my_cell = 0, my_missing = 0, my_misfits = 0;
    int my_edge = 0;
    for (uint i = lane; i < block.width * block.height; i += GROUP) {
        uvec2 in_block = uvec2(i % block.width, i / block.width);
        ivec2 at = ivec2(block.x, block.y) + ivec2(in_block);
        uint texel = imageLoad(guide, at).r;
        if (texel >> 16 != push.paint) {
            continue;
        }
        my_covered++;
        my_shade += texel & 255u;
        if (any(lessThan(in_block, begin)) || any(greaterThanEqual(in_block, end))) {
            continue;
        }
        my_cell++;
        uvec4 place = imageLoad(carried, at);
        ivec2 here = steps_of(place);
        if (!is_present(place) || !in_sample(here, sample_size)) {
            my_missing++;
            continue;
        }
        my_edge += here.x - STEPS * int(in_block.x);
        // At the edge of the picture a pixel is its own neighbour, which is not one piece.
        ivec2 last = ivec2(push.output_width, push.output_height) - 1;
        uvec4 place_right = imageLoad(carried, min(at + ivec2(1, 0), last));
        uvec4 place_down = imageLoad(carried, min(at + ivec2(0, 1), last));
        ivec2 right = steps_of(place_right) - here;
        ivec2 down = steps_of(place_down) - here;
        bool one_piece = is_present(place_right) && is_present(place_down) && follows(right, ivec2(1, 0)) &&
                         follows(down, ivec2(0, 1));
        my_misfits += one_piece && !fits(right, down) ? 1 : 0;
    }
    atomicAdd(covered, my_covered);
    atomicAdd(shade_sum, my_shade);
    atomicAdd(cell_pixels, my_cell);
    atomicAdd(missing, my_missing);
    atomicAdd(misfits, my_misfits);
    atomicAdd(edge_sum, my_edge);
    barrier();
    if (lane != 0) {
        return;
    }
    uint state = STATE_SKIPPED;
    uvec2 window = uvec2(0);
    if (cell_pixels > 0) {
        window = guided_window(shade_sum, covered, push.sample_width, push.block_px, push.window_px);
        int present = int(cell_pixels - missing);
        int low = STEPS * (int(window.x) - int(push.slack)) * present;
        int high = STEPS * (int(window.y) + int(push.slack)) * present;
        bool keep = missing == 0 && 2 * misfits <= cell_pixels && edge_sum >= low && edge_sum <= high;
        state = keep ? STATE_PLACED : STATE_PENDING;
    }
    blocks[index].sx0 = window.x;
    blocks[index].sx1 = window.y;
    blocks[index].state = state;
}
