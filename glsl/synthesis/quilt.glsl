// What the quilting stages share: constants, the record of a block, and the counter-based random numbers.
// Rust's side of it is src/synthesis/quilt.rs; a test compares the layouts.

// Invocations of a workgroup, and positions of the sample that one invocation of the search compares.
const uint GROUP = 128;
const uint TILE = 8;
const uint GROUP_POSITIONS = GROUP * TILE;

// Largest block side and overlap, pixels.
const uint MAX_BLOCK = 64;
const uint MAX_OVERLAP = 32;

// A canvas texel holds red, green and blue in its low bytes, and this once it is painted.
const uint PAINTED = 0xff000000u;

const uint STATE_SKIPPED = 0;
const uint STATE_PENDING = 1;
const uint STATE_PLACED = 2;

struct Block {
    // Where the block lies in the output, pixels; it may wrap around.
    uint x, y, width, height;
    // Columns of the sample that may become the block's left edge, inclusive.
    uint sx0, sx1;
    uint state;
    // The position chosen, its overlap error, and the least error there was.
    uint sx, sy, error, min_error;
};

// The hash "lowbias32" of C. Wellons (2018) behind the golden ratio as increment.
uint mix_bits(uint x) {
    x += 0x9e3779b9u;
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

uint random_bits(uint seed, uint block, uint frame) {
    return mix_bits(mix_bits(mix_bits(seed) ^ block) ^ frame);
}

uvec3 unpack_rgb(uint texel) {
    return uvec3(texel & 255u, (texel >> 8) & 255u, (texel >> 16) & 255u);
}

// Sum of squared differences of two packed colours.
uint squared_difference(uint a, uint b) {
    ivec3 d = ivec3(unpack_rgb(a)) - ivec3(unpack_rgb(b));
    return uint(d.x * d.x + d.y * d.y + d.z * d.z);
}

// Largest error that is still chosen: least + floor(least * tolerance / 10,000), or 2^32 - 1 where that does not fit.
uint threshold(uint least, uint tolerance) {
    uint whole = least / 10000u;
    uint high;
    uint product;
    umulExtended(whole, tolerance, high, product);
    uint carry;
    uint sum = uaddCarry(product, (least % 10000u) * tolerance / 10000u, carry);
    uint carry_least;
    sum = uaddCarry(sum, least, carry_least);
    return high != 0 || carry != 0 || carry_least != 0 ? 0xffffffffu : sum;
}
