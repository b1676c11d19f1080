// Texture that was carried from one frame to the next: a *place*, where in the sample a pixel's texture comes from.
// Rust's side of it is src/synthesis/repair.rs.

// Steps of a texel, in x and y of a place.
const int STEPS = 64;

// A place as images have it, 16 bits to a channel: x in the first two, y in the others, low half first. None is all
// zero; this is in the last one where there is one.
const uint PRESENT = 0x8000u;

// In the last one too, where the texture there is stretched, compressed or turned so far that it no longer looks like
// the sample.
const uint MISFIT = 0x4000u;

// What `source` holds where nothing was pasted in this frame.
const uint NOT_PASTED = 0xffffffffu;

// The differences between the places of neighbouring pixels that belong to one piece of texture are within this of one
// texel, in steps.
const int ONE_PIECE = 48;

bool is_present(uvec4 place) {
    return place.w >= PRESENT;
}

bool is_misfit(uvec4 place) {
    return (place.w & MISFIT) != 0;
}

ivec2 steps_of(uvec4 place) {
    return ivec2(place.x | place.y << 16, place.z | (place.w & ~(PRESENT | MISFIT)) << 16);
}

uvec4 place_of(ivec2 steps) {
    uvec2 s = uvec2(steps);
    return uvec4(s.x & 0xffffu, s.x >> 16, s.y & 0xffffu, s.y >> 16 | PRESENT);
}

// Whether the sample has a texel nearest to the place.
bool in_sample(ivec2 steps, uvec2 sample_size) {
    return all(greaterThanEqual(steps, ivec2(0))) && all(lessThanEqual(steps, STEPS * (ivec2(sample_size) - 1)));
}

// From a pixel's place to that of the pixel at the way (1, 0) or (0, 1) from it, if both are of one piece.
bool follows(ivec2 difference, ivec2 way) {
    return all(lessThanEqual(abs(difference - STEPS * way), ivec2(ONE_PIECE)));
}
