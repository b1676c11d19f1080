#version 450
// Pruned quilting, for the blocks of one wave: the coordinates of what is painted in their overlaps.
//
// The strips of a block are its overlaps with the neighbours to the left and above, the second without the corner that
// is in the first. A strip that is painted as a whole is projected to the orthonormal directions of the sample's own
// strips; see src/synthesis/strips.rs for the directions, and for why what quilt_bound makes of the coordinates is no
// more than the error. Another strip counts nothing, nor do overlaps to the right and below (of blocks that close a
// ring): leaving something out makes a bound less tight, not wrong.
// One workgroup a block.
// In:  canvas, directions of the left and then of the top strip (a row a direction, a texel a pixel of the strip),
//      blocks, order.
// Out: templates, in chunks of STRIDE blocks: by layers of four coordinates and then by blocks; after them, for each
//      block, the constant part, the first column of its window, and how many columns that has.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D canvas;
layout(binding = 1, rgba32f) uniform readonly image2D directions;
layout(binding = 2, rgba32f) uniform writeonly image2D templates;
layout(binding = 3, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 4, std430) readonly buffer Order { uint order[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint block_px, overlap_px;
    uint tileable;
    uint columns, rows;
    // The blocks of this dispatch are order[first_block + gl_WorkGroupID.x].
    uint first_block;
    // Lengths of vertical and horizontal strips, pixels.
    uint vertical_px, horizontal_px;
    // The colour that is subtracted.
    float centre_r, centre_g, centre_b;
    // Of each strip: the margin for rounding, and the steps that the sample's coordinates are in.
    float left_margin, top_margin;
    float left_step, top_step;
} push;

#include "prune.glsl"
#include "fields.glsl"

shared float squares[STRIPS];
shared float coordinates[STRIPS * DIRECTIONS];
shared bool used[STRIPS];

vec3 canvas_colour(uint x, uint y) {
    x -= x >= push.output_width ? push.output_width : 0;
    y -= y >= push.output_height ? push.output_height : 0;
    return vec3(unpack_rgb(imageLoad(canvas, ivec2(x, y)).r)) - vec3(push.centre_r, push.centre_g, push.centre_b);
}

float margin_of(uint strip) {
    return strip == LEFT ? push.left_margin : push.top_margin;
}

float step_of(uint strip) {
    return strip == LEFT ? push.left_step : push.top_step;
}

// Length of what the directions leave out of a strip.
float left_out(uint strip) {
    float rest = squares[strip] * (1.0 + margin_of(strip));
    for (uint j = 0; j < DIRECTIONS; j++) {
        float c = coordinates[strip * DIRECTIONS + j];
        rest -= c * c;
    }
    return sqrt(max(rest, 0.0));
}

// What a bound has besides its products, less what the sample's coordinates lack by being whole numbers of steps.
float constant(uint strip) {
    float margin = margin_of(strip);
    float rounded = 1.01 * sqrt(float(DIRECTIONS)) * step_of(strip);
    return squares[strip] * (1.0 - margin) - rounded * sqrt(squares[strip] * (1.0 + margin));
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.x;
    uint index = order[push.first_block + slot];
    Block block = blocks[index];
    bool pending = block.state == STATE_PENDING;
    if (lane < STRIPS) {
        int row = int(index / push.columns);
        int col = int(index % push.columns);
        bool neighbour = lane == LEFT ? placed(row, col, 0, -1) : placed(row, col, -1, 0);
        bool fits = lane == LEFT ? block.height >= push.vertical_px : block.width >= push.overlap_px + push.horizontal_px;
        used[lane] = pending && neighbour && fits;
    }
    barrier();
    // After its directions, each strip's squared length.
    for (uint i = lane; i < STRIPS * (DIRECTIONS + 1); i += GROUP) {
        uint strip = i / (DIRECTIONS + 1);
        uint direction = i % (DIRECTIONS + 1);
        uint begin = strip == LEFT ? 0 : push.overlap_px;
        uint end = strip == LEFT ? push.overlap_px : push.overlap_px + push.horizontal_px;
        uint rows = strip == LEFT ? push.vertical_px : push.overlap_px;
        uint pixels = used[strip] ? (end - begin) * rows : 0;
        // Row by row, so that no product passes through many roundings.
        float sum = 0.0;
        float row_sum = 0.0;
        uint dx = begin;
        uint dy = 0;
        for (uint pixel = 0; pixel < pixels; pixel++) {
            vec3 colour = canvas_colour(block.x + dx, block.y + dy);
            vec3 weight = colour;
            if (direction < DIRECTIONS) {
                weight = imageLoad(directions, ivec2(pixel, strip * DIRECTIONS + direction)).rgb;
            }
            row_sum += dot(weight, colour);
            dx++;
            bool ends = dx == end;
            sum += ends ? row_sum : 0.0;
            row_sum = ends ? 0.0 : row_sum;
            dy += ends ? 1 : 0;
            dx = ends ? begin : dx;
        }
        if (direction < DIRECTIONS) {
            coordinates[strip * DIRECTIONS + direction] = sum;
        } else {
            squares[strip] = sum;
        }
    }
    barrier();
    // The last vector is the header.
    for (uint layer = lane; layer < STRIPS * LAYERS + 1; layer += GROUP) {
        uint strip = layer / LAYERS;
        vec4 value = vec4(pending ? constant(LEFT) + constant(TOP) : 3.0e38, block.sx0, block.sx1 - block.sx0 + 1, 0);
        if (strip < STRIPS) {
            uint first = strip * DIRECTIONS + 4 * (layer % LAYERS);
            bool last = layer % LAYERS == LAYERS - 1;
            float c[4] = float[](0, 0, 0, 0);
            for (uint j = 0; j < (last ? 1 : 4); j++) {
                c[j] = -2.0 * step_of(strip) * coordinates[first + j];
            }
            value = vec4(c[0], c[1], c[2], c[3]);
            if (last && used[strip]) {
                value.yz = vec2(-2.0 * step_of(strip) * left_out(strip), 1.0);
            }
        }
        imageStore(templates, ivec2(slot, layer), value);
    }
}
