#version 450
// Pruned quilting, for the blocks of one wave: the coordinates of what is painted in their overlaps.
//
// Strips are parts of a block's overlaps with the neighbours to the left and above. One that is painted as a whole is
// projected to the orthonormal directions of the sample's own strips; see src/synthesis/strips.rs for the directions, and
// for why what quilt_bound makes of the coordinates is no more than the error. Another strip counts nothing, nor do
// overlaps to the right and below (of blocks that close a ring): leaving something out makes a bound less tight, not
// wrong.
// One workgroup a block, an invocation for each coordinate.
// In:  canvas, directions (a row for each coordinate that has one, a texel a pixel of its strip), blocks, order, strips.
// Out: templates, a column a block, four coordinates a texel; in the last row, what the bound has besides its products,
//      the first column of the block's window, and how many columns that has.
#extension GL_GOOGLE_include_directive : require
#include "quilt.glsl"

layout(local_size_x = 128) in;

struct Strip {
    // In the block, pixels.
    uint x, y, width, height;
    // Whether its neighbour is the one to the left; else it is the one above.
    uint left;
    // Its first coordinate among all, and how many directions it has. Then come the length of what these leave out, and
    // the squared length, which takes the place of two.
    uint first, directions;
    // For rounding, and the step that the sample's coordinates are in.
    float margin, step;
};

layout(binding = 0, r32ui) uniform readonly uimage2D canvas;
layout(binding = 1, rgba32f) uniform readonly image2D directions;
layout(binding = 2, rgba32f) uniform writeonly image2D templates;
layout(binding = 3, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 4, std430) readonly buffer Order { uint order[]; };
layout(binding = 5, std430) readonly buffer Strips { Strip strips[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint block_px, overlap_px;
    uint tileable;
    uint columns, rows;
    // The blocks of this dispatch are order[first_block + gl_WorkGroupID.x].
    uint first_block;
    uint strips;
    // The colour that is subtracted.
    float centre_r, centre_g, centre_b;
} push;

#include "prune.glsl"
#include "block.glsl"
#include "fields.glsl"

// Projections, and after those of each strip its squared length.
shared float sums[COORDINATES];

vec3 canvas_colour(uint x, uint y) {
    x -= x >= push.output_width ? push.output_width : 0;
    y -= y >= push.output_height ? push.output_height : 0;
    return vec3(unpack_rgb(imageLoad(canvas, ivec2(x, y)).r)) - vec3(push.centre_r, push.centre_g, push.centre_b);
}

// The projection of what is painted in a strip, or its squared length.
float project(Block block, Strip strip, uint coordinate) {
    // Row by row, so that no product passes through many roundings.
    float sum = 0.0;
    float row_sum = 0.0;
    uint dx = 0;
    uint dy = 0;
    for (uint pixel = 0; pixel < strip.width * strip.height; pixel++) {
        vec3 colour = canvas_colour(block.x + strip.x + dx, block.y + strip.y + dy);
        vec3 weight = imageLoad(directions, ivec2(pixel, coordinate)).rgb;
        weight = coordinate < strip.first + strip.directions ? weight : colour;
        row_sum += dot(weight, colour);
        dx++;
        bool ends = dx == strip.width;
        sum += ends ? row_sum : 0.0;
        row_sum = ends ? 0.0 : row_sum;
        dy += ends ? 1 : 0;
        dx = ends ? 0 : dx;
    }
    return sum;
}

// The length of what the directions leave out of a strip.
float left_out(Strip strip) {
    float rest = sums[strip.first + strip.directions] * (1.0 + strip.margin);
    for (uint j = 0; j < strip.directions; j++) {
        float c = sums[strip.first + j];
        rest -= c * c;
    }
    return sqrt(max(rest, 0.0));
}

// What a bound has besides its products, less what the sample's coordinates lack by being whole numbers of steps.
float constant() {
    float sum = 0.0;
    for (uint i = 0; i < push.strips; i++) {
        Strip strip = strips[i];
        float square = sums[strip.first + strip.directions];
        float rounded = 1.01 * sqrt(float(strip.directions)) * strip.step;
        sum += square * (1.0 - strip.margin) - rounded * sqrt(square * (1.0 + strip.margin));
    }
    return sum;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = gl_WorkGroupID.x;
    uint index = order[push.first_block + slot];
    Block block = load_block(index);
    bool pending = block.state == STATE_PENDING;
    int row = int(index / push.columns);
    int col = int(index % push.columns);
    Strip strip = strips[0];
    for (uint i = 1; i < push.strips; i++) {
        if (strips[i].first <= lane) {
            strip = strips[i];
        }
    }
    bool neighbour = strip.left != 0 ? placed(row, col, 0, -1) : placed(row, col, -1, 0);
    bool fits = strip.x + strip.width <= block.width && strip.y + strip.height <= block.height;
    bool used = pending && neighbour && fits;
    uint place = lane - strip.first;
    if (lane < COORDINATES) {
        sums[lane] = used && place <= strip.directions ? project(block, strip, lane) : 0.0;
    }
    barrier();
    float value = place < strip.directions    ? -2.0 * strip.step * sums[min(lane, COORDINATES - 1)]
                : place == strip.directions   ? -2.0 * strip.step * left_out(strip)
                : place == strip.directions + 1 ? 1.0
                                              : 0.0;
    barrier();
    float besides = constant();
    barrier();
    if (lane < COORDINATES) {
        sums[lane] = used ? value : 0.0;
    }
    barrier();
    if (lane < COORDINATES / 4) {
        uint i = 4 * lane;
        imageStore(templates, ivec2(slot, lane), vec4(sums[i], sums[i + 1], sums[i + 2], sums[i + 3]));
    } else if (lane == COORDINATES / 4) {
        vec4 header = vec4(pending ? besides : 3.0e38, block.sx0, block.sx1 - block.sx0 + 1, 0);
        imageStore(templates, ivec2(slot, lane), header);
    }
}
