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
    // What is left of a squared length for a safe bound.
    float kept_vertical, kept_horizontal;
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

// Length of what the directions leave out of a strip.
float left_out(uint strip) {
    float rest = squares[strip];
    for (uint j = 0; j < DIRECTIONS; j++) {
        float c = coordinates[strip * DIRECTIONS + j];
        rest -= c * c;
    }
    return sqrt(max(rest, 0.0));
}

// What a bound has besides its products.
float constant() {
    return push.kept_vertical * squares[LEFT] + push.kept_horizontal * squares[TOP];
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
        float sum = 0.0;
        uint dx = begin;
        uint dy = 0;
        for (uint pixel = 0; pixel < pixels; pixel++) {
            vec3 colour = canvas_colour(block.x + dx, block.y + dy);
            vec3 weight = colour;
            if (direction < DIRECTIONS) {
                weight = imageLoad(directions, ivec2(pixel, strip * DIRECTIONS + direction)).rgb;
            }
            sum += dot(weight, colour);
            dx++;
            dy += dx < end ? 0 : 1;
            dx = dx < end ? dx : begin;
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
        vec4 value = vec4(pending ? constant() : 3.0e38, block.sx0, block.sx1 - block.sx0 + 1, 0);
        if (strip < STRIPS) {
            uint first = strip * DIRECTIONS + 4 * (layer % LAYERS);
            bool last = layer % LAYERS == LAYERS - 1;
            float c[4] = float[](0, 0, 0, 0);
            for (uint j = 0; j < (last ? 2 : 4); j++) {
                c[j] = -2.0 * coordinates[first + j];
            }
            value = vec4(c[0], c[1], c[2], c[3]);
            if (last && used[strip]) {
                value.zw = vec2(-2.0 * left_out(strip), 1.0);
            }
        }
        imageStore(templates, ivec2(slot, layer), value);
    }
}
