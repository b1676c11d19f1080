// The overlap error of a block at TILE neighbouring positions of the sample. For shaders that have declared
// `sample_texels`, `sample_squares`, `canvas` and a block of push constants with overlap_px, block_px, tileable,
// output_width and output_height.
//
// Thesis 3.2.2; Efros and Freeman 2001. The error is the sum of squared differences of 8-bit RGB over those pixels of
// the block that are painted already (the L of its overlaps), each pixel once. Which pixels those are follows from the
// neighbours (fields.glsl). Painted fields side by side make a *run*, and a run through the rows of its band a
// rectangle.
// Arithmetic: sum (a - b)^2 = sum a^2 - 2 sum ab + sum b^2. The first comes from a summed-area table of the sample, in
// 32-bit integers that may wrap around, since the sum itself fits. Products ab are summed in 32-bit floats over so few
// texels that they hold them exactly, with or without fused operations. A texel of the sample that is loaded and
// unpacked once serves TILE comparisons.
// Where a device has more invocations than there are tiles, several share one: each takes every so many-th chunk of a
// run. Sums of integers do not depend on who adds which.

// Texels of a block's row that are compared at a time: 4, 5 or 6, whichever wastes least at the ends of runs.
layout(constant_id = 0) const int CHUNK = 4;

// So many products of two colours can be summed in a float without rounding: 86 * 3 * 255^2 < 2^24.
const int EXACT_TEXELS = 86;
const int EXACT_CHUNKS = EXACT_TEXELS / CHUNK;

vec3 load_rgb(int x, int y) {
    return vec3(unpack_rgb(imageLoad(sample_texels, ivec2(x, y)).r));
}

int wrapped(int at, uint size) {
    return at >= int(size) ? at - int(size) : at;
}

// The block's texel at column `dx` of a run that ends at `end`; black beyond it, which adds nothing to any sum.
vec3 load_block(int x, int y, int dx, int end) {
    uint texel = imageLoad(canvas, ivec2(wrapped(x + min(dx, end - 1), push.output_width), y)).r;
    return vec3(unpack_rgb(dx < end ? texel : 0));
}

// The inner loop is written out, because arrays would be kept in memory by some compilers. Parts beyond CHUNK vanish
// when the pipeline is made.
#define BLOCK_TEXEL(i)                                                                                                 \
    vec3 b##i = i < CHUNK ? load_block(int(block.x), y, dx + i, end) : vec3(0.0);                                      \
    constant += dot(b##i, b##i);
#define SAMPLE_TEXEL(k) vec3 a##k = k < CHUNK + 7 ? load_rgb(sx + dx + k, sy + dy) : vec3(0.0);
#define POSITION(s, p0, p1, p2, p3, p4, p5)                                                                            \
    s += dot(p0, b0) + dot(p1, b1) + dot(p2, b2) + dot(p3, b3);                                                        \
    s += CHUNK > 5 ? dot(p4, b4) + dot(p5, b5) : CHUNK > 4 ? dot(p4, b4) : 0.0;

// Sets `total` to terms of the errors at (sx, sy), (sx + 1, sy) and so on; `fields` are those that are painted. The
// errors are the sums over `part` = 0 to `parts` - 1; `parts`, a constant, divides TILE.
void overlap_part(Block block, uint fields, int part, int parts, int sx, int sy, out int total[TILE]) {
    for (int j = 0; j < TILE; j++) {
        total[j] = 0;
    }
    int overlap = int(push.overlap_px);
    ivec2 size = ivec2(block.width, block.height);
    // Where the fields begin and end. A block cut off by the output has no third field, nor a second if it is narrow.
    ivec2 first = min(ivec2(overlap), size);
    ivec2 second = max(first, push.tileable != 0 ? size - overlap : min(size, int(push.block_px) - overlap));
    // Each rectangle of painted fields once. Rectangles are taken as large as they come, and fields that are not
    // painted cost nothing: lavapipe runs what stands in a loop once more than it is needed.
    for (uint left = fields & 511u; left != 0;) {
        int lowest = int(findLSB(left));
        int band = lowest < 3 ? 0 : lowest < 6 ? 1 : 2;
        int field = lowest - 3 * band;
        int fields_on = int(findLSB(~(left >> lowest & ((1u << (3 - field)) - 1u))));
        uint row = ((1u << fields_on) - 1u) << lowest;
        bool one_more = band < 2 && (left & row << 3) == row << 3;
        bool two_more = one_more && band < 1 && (left & row << 6) == row << 6;
        left &= ~(row | (one_more ? row << 3 : 0) | (two_more ? row << 6 : 0));
        int begin = field == 0 ? 0 : field == 1 ? first.x : second.x;
        int last = field + fields_on;
        int end = last == 1 ? first.x : last == 2 ? second.x : size.x;
        int top = band == 0 ? 0 : band == 1 ? first.y : second.y;
        int last_band = band + (two_more ? 2 : one_more ? 1 : 0);
        int bottom = last_band == 0 ? first.y : last_band == 1 ? second.y : size.y;
        // Narrow blocks have fields without a pixel.
        bottom = end > begin ? bottom : top;

        // A part has the squares of one position of `parts`; which one, no index needs to know.
        [[unroll]] for (int j = 0; j < TILE; j += parts) {
            ivec2 from = ivec2(sx + begin + j + part, sy + top);
            ivec2 to = ivec2(sx + end + j + part, sy + bottom);
            uint squares = imageLoad(sample_squares, to).r - imageLoad(sample_squares, ivec2(from.x, to.y)).r -
                           imageLoad(sample_squares, ivec2(to.x, from.y)).r + imageLoad(sample_squares, from).r;
            [[unroll]] for (int i = 0; i < parts; i++) {
                total[j + i] += i == part ? int(squares) : 0;
            }
        }
        int chunks = max((end - begin + CHUNK - 1) / CHUNK, 1);
        int steps = chunks * (bottom - top);
        // Where the part begins, and how far it is to its next chunk. A lone part needs no slow division.
        int rows_from = parts > 1 ? part / chunks : 0;
        int dx = begin + (part - rows_from * chunks) * CHUNK;
        int dy = top + rows_from;
        int rows_on = parts > 1 ? parts / chunks : 0;
        int columns_on = (parts - rows_on * chunks) * CHUNK;
        // So many chunks at a time that the sums stay exact.
        for (int first_step = part; first_step < steps; first_step += EXACT_CHUNKS * parts) {
            float s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0, s4 = 0.0, s5 = 0.0, s6 = 0.0, s7 = 0.0;
            float constant = 0.0;
            int end_step = min(first_step + EXACT_CHUNKS * parts, steps);
            // One loop over rows and chunks: an inner loop would be entered anew for each of many short rows.
            for (int step = first_step; step < end_step; step += parts) {
                int y = wrapped(int(block.y) + dy, push.output_height);
                // The block's texels, and the sample's that face them at the TILE positions.
                BLOCK_TEXEL(0) BLOCK_TEXEL(1) BLOCK_TEXEL(2) BLOCK_TEXEL(3) BLOCK_TEXEL(4) BLOCK_TEXEL(5)
                SAMPLE_TEXEL(0) SAMPLE_TEXEL(1) SAMPLE_TEXEL(2) SAMPLE_TEXEL(3) SAMPLE_TEXEL(4)
                SAMPLE_TEXEL(5) SAMPLE_TEXEL(6) SAMPLE_TEXEL(7) SAMPLE_TEXEL(8) SAMPLE_TEXEL(9)
                SAMPLE_TEXEL(10) SAMPLE_TEXEL(11) SAMPLE_TEXEL(12)
                POSITION(s0, a0, a1, a2, a3, a4, a5)
                POSITION(s1, a1, a2, a3, a4, a5, a6)
                POSITION(s2, a2, a3, a4, a5, a6, a7)
                POSITION(s3, a3, a4, a5, a6, a7, a8)
                POSITION(s4, a4, a5, a6, a7, a8, a9)
                POSITION(s5, a5, a6, a7, a8, a9, a10)
                POSITION(s6, a6, a7, a8, a9, a10, a11)
                POSITION(s7, a7, a8, a9, a10, a11, a12)
                dx += columns_on;
                dy += dx < end ? rows_on : rows_on + 1;
                dx -= dx < end ? 0 : chunks * CHUNK;
            }
            int squares = int(constant);
            total[0] += squares - 2 * int(s0);
            total[1] += squares - 2 * int(s1);
            total[2] += squares - 2 * int(s2);
            total[3] += squares - 2 * int(s3);
            total[4] += squares - 2 * int(s4);
            total[5] += squares - 2 * int(s5);
            total[6] += squares - 2 * int(s6);
            total[7] += squares - 2 * int(s7);
        }
    }
}

// Sets `total` to the errors at (sx, sy), (sx + 1, sy) and so on; `fields` are those that are painted.
void overlap_errors(Block block, uint fields, int sx, int sy, out int total[TILE]) {
    overlap_part(block, fields, 0, 1, sx, sy, total);
}
