#version 450
// Pruned quilting, for the blocks of one wave: what their searches need to know first. Two things:
//
// A bound on the least error, from above. Where a neighbour is placed, the position from which its texture would go on
// over this block is often the best of all. Where no neighbour's texture goes on within the sample (or within the
// window of a guide), positions at random serve. The error there is that of overlap.glsl, pixel by pixel.
//
// The template of each block: the coordinates of what is painted in its overlaps. Strips are parts of the overlaps with
// the neighbours to the left and above. One that is painted as a whole is projected to the orthonormal directions of
// the sample's own strips; see src/synthesis/strips.rs for the directions, and for why what quilt_bound makes of the
// coordinates is no more than the error. Another strip counts nothing, nor do overlaps to the right and below (of
// blocks that close a ring): leaving something out makes a bound less tight, not wrong.
//
// One workgroup a block.
// In:  sample, canvas, directions (a row for each coordinate that has one, a texel a pixel of its strip), blocks,
//      order, strips.
// Out: templates, a column a block, four coordinates a texel; in the last row, what the bound has besides its products,
//      the first column of the block's window, and how many columns that has. The least error found, after the groups'
//      minima.
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

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D canvas;
layout(binding = 2, rgba32f) uniform readonly image2D directions;
layout(binding = 3, rgba32f) uniform writeonly image2D templates;
layout(binding = 4, std430) readonly buffer Blocks { Block blocks[]; };
layout(binding = 5, std430) readonly buffer Order { uint order[]; };
layout(binding = 6, std430) readonly buffer Strips { Strip strips[]; };
layout(binding = 7, std430) writeonly buffer GroupMinima { uint group_minima[]; };

layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_height;
    uint block_px, overlap_px;
    uint tileable;
    uint columns, rows;
    // The blocks of this dispatch are order[first_block + gl_WorkGroupID.x].
    uint first_block;
    uint strips;
    // Where the least errors begin among the groups' minima.
    uint first_least;
    // The colour that is subtracted from what is projected.
    float centre_r, centre_g, centre_b;
} push;

#include "prune.glsl"
#include "fields.glsl"

// Positions whose errors are compared, one for each neighbour, and invocations that share one.
const uint LIKELY = 8;
const uint SHARE = GROUP / LIKELY;

// Projections, and after those of each strip its squared length.
shared float sums[8 * MAX_TEXELS];
shared uint painted;
shared uint likely;
shared uint errors[GROUP];

uint canvas_texel(uint x, uint y) {
    x -= x >= push.output_width ? push.output_width : 0;
    y -= y >= push.output_height ? push.output_height : 0;
    return imageLoad(canvas, ivec2(x, y)).r;
}

vec3 canvas_colour(uint x, uint y) {
    return vec3(unpack_rgb(canvas_texel(x, y))) - vec3(push.centre_r, push.centre_g, push.centre_b);
}

// From the left (or top) edge of a neighbour `by` blocks away to that of the block, around the end of the output.
int advance(uint from, uint to, int by, uint size) {
    int way = int(to) - int(from);
    return by < 0 && way < 0 ? way + int(size) : by > 0 && way > 0 ? way - int(size) : way;
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

// Where the texture of neighbour 0 to 7 goes on, or (-1, -1).
ivec2 continuing(uint neighbour, uint index, Block block) {
    int at = int(neighbour) + (neighbour < 4 ? 0 : 1);
    ivec2 by = ivec2(at % 3 - 1, at / 3 - 1);
    ivec2 grid = ivec2(push.columns, push.rows);
    ivec2 cell = ivec2(index % push.columns, index / push.columns);
    if (!placed(cell.y, cell.x, by.y, by.x)) {
        return ivec2(-1);
    }
    cell = (cell + by + grid) % grid;
    Block other = blocks[cell.y * grid.x + cell.x];
    int sx = int(other.sx) + advance(other.x, block.x, by.x, push.output_width);
    int sy = int(other.sy) + advance(other.y, block.y, by.y, push.output_height);
    int last = int(push.sample_height - push.block_px);
    bool allowed = sx >= int(block.sx0) && sx <= int(block.sx1) && sy >= 0 && sy <= last;
    return allowed ? ivec2(sx, sy) : ivec2(-1);
}

// A position at random.
ivec2 somewhere(uint number, uint index, Block block) {
    uint bits = random_bits(number, index, 0);
    uint sx = block.sx0 + (bits & 0xffffu) * (block.sx1 - block.sx0 + 1) / 65536u;
    uint sy = (bits >> 16) * (push.sample_height - push.block_px + 1) / 65536u;
    return ivec2(sx, sy);
}

// This invocation's share of the error at a position.
uint share_of_error(Block block, ivec2 position, uint part) {
    // Nothing but the overlaps to the left and above is painted in most blocks.
    bool whole = (painted & ~79u) != 0;
    uint error = 0;
    for (uint dy = 0; dy < block.height; dy++) {
        uint width = whole || dy < push.overlap_px ? block.width : min(push.overlap_px, block.width);
        for (uint dx = part; dx < width; dx += SHARE) {
            uint old = canvas_texel(block.x + dx, block.y + dy);
            uint new = imageLoad(sample_texels, position + ivec2(dx, dy)).r;
            error += (painted & field_of(block, dx, dy)) != 0 ? squared_difference(old, new) : 0;
        }
    }
    return error;
}

// Leaves the least error of the likely positions.
void aim(uint slot, uint index, Block block) {
    uint lane = gl_LocalInvocationID.x;
    if (lane == 0) {
        painted = painted_fields(index);
        likely = 0;
    }
    barrier();
    ivec2 position = continuing(lane / SHARE, index, block);
    if (position.x >= 0 && lane % SHARE == 0) {
        atomicAdd(likely, 1);
    }
    barrier();
    if (likely == 0) {
        position = somewhere(lane / SHARE, index, block);
    }
    errors[lane] = position.x >= 0 ? share_of_error(block, position, lane % SHARE) : 0xffffffffu;
    barrier();
    if (lane == 0) {
        uint least = 0xffffffffu;
        for (uint i = 0; i < LIKELY; i++) {
            uint error = errors[i * SHARE];
            for (uint j = 1; j < SHARE && error != 0xffffffffu; j++) {
                error += errors[i * SHARE + j];
            }
            least = min(least, error);
        }
        group_minima[push.first_least + slot] = least;
    }
}

// Leaves the block's template; `pending` says whether it has one.
void describe(uint slot, uint index, Block block, bool pending) {
    uint lane = gl_LocalInvocationID.x;
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

void main() {
    uint slot = gl_WorkGroupID.x;
    uint index = order[push.first_block + slot];
    Block block = blocks[index];
    bool pending = block.state == STATE_PENDING;
    describe(slot, index, block, pending);
    if (pending) {
        aim(slot, index, block);
    }
}
