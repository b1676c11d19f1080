// Where a guide lets a block be searched for (thesis chapter 6).

// floor(a * b / d) for a <= d < 2^24 and b < 2^14, by long division: the product does not fit 32 bits.
uint scaled(uint a, uint b, uint d) {
    uint quotient = 0;
    uint rest = 0;
    for (int bit = 13; bit >= 0; bit--) {
        rest = 2 * rest + (((b >> bit) & 1u) != 0 ? a : 0);
        quotient = 2 * quotient + rest / d;
        rest %= d;
    }
    return quotient;
}

// The columns of the sample that may be the left edge of a block whose `covered` pixels have shades (0 to 255) of this
// sum: `window_px` around x0 = L * W_sample, both ends included.
uvec2 guided_window(uint shade_sum, uint covered, uint sample_width, uint block_px, uint window_px) {
    uint last = sample_width - block_px;
    uint x0 = scaled(shade_sum, sample_width, 255 * covered);
    return uvec2(min(x0 - min(x0, window_px), last), min(x0 + window_px, last));
}
