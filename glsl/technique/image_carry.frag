#version 450
// Image-based technique, texture that follows the surface: brings the places of the last frame's texture to where its
// surface is now.
//
// Each pixel takes its place from the pixel of the last frame that its surface was nearest to, and goes on from there
// to where it was exactly, by the differences between places that lie there already: places are linear within a piece
// of texture, so nothing is lost by this however often it is done, and no colour is ever mixed. The differences also
// tell how far the texture is stretched. A surface that comes into sight takes what lies beside it and moves as it
// does, as if the texture went on there; what it was hidden by moves otherwise.
// In:  guide, motion (where the surface was in the last frame, twice 15 bits, x low, 16,384 + 64 times the pixels; the
//      highest bit where that frame showed it; 0 where nothing is known), the last frame's places, the paint's 8-bit
//      sample.
// Out: carried places and the canvas that repairs start from, for the pixels of one paint. Integer arithmetic throughout.
#extension GL_GOOGLE_include_directive : require
#include "../synthesis/carried.glsl"
#include "../synthesis/quilt.glsl"

layout(binding = 0, r32ui) uniform readonly uimage2D motion;
layout(binding = 1, r32ui) uniform readonly uimage2D guide;
layout(binding = 2, rgba16ui) uniform readonly uimage2D places;
layout(binding = 3, r32ui) uniform readonly uimage2D sample_texels;

layout(push_constant) uniform Push {
    uint sample_width, sample_height;
    uint paint;
    // The least and the most that texture may be compressed and stretched: singular values of J, in steps.
    uint least, most;
} push;

layout(location = 0) out uvec4 carried;
layout(location = 1) out uint canvas;

// Steps of a pixel in the motion are those of a texel in places.
const int REST = 16384;
const uint SHOWN = 0x80000000u;

// How far, in pixels, texture grows over a surface that comes into sight, and how far, in steps, what moves as that
// does may come apart from it in a frame.
const int REACH = 8;
const int TOGETHER = STEPS;

// The motion of a pixel of this paint; 0 for others.
uint motion_at(ivec2 p, ivec2 size) {
    p = clamp(p, ivec2(0), size - 1);
    return imageLoad(guide, p).r >> 16 == push.paint ? imageLoad(motion, p).r : 0;
}

ivec2 way_of(uint word) {
    return ivec2(word & 0x7fffu, word >> 15 & 0x7fffu) - REST;
}

uvec4 place_at(ivec2 p, ivec2 size) {
    bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
    uvec4 place = imageLoad(places, clamp(p, ivec2(0), size - 1));
    return inside ? place : uvec4(0);
}

// How the place changes from the pixel at `here` along `way`, with neighbours after and before it.
ivec2 slope(ivec2 here, uvec4 after, uvec4 before, ivec2 way, bool prefer_after) {
    ivec2 forward = steps_of(after) - here;
    ivec2 backward = here - steps_of(before);
    bool can_forward = is_present(after) && follows(forward, way);
    bool can_backward = is_present(before) && follows(backward, way);
    ivec2 either = can_backward ? backward : STEPS * way;
    return can_forward && (prefer_after || !can_backward) ? forward : either;
}

// The tangent of 30 degrees.
const int TURN_NUMERATOR = 15;
const int TURN_DENOMINATOR = 26;

// Whether texture still looks like the sample where the Jacobian J, from picture to sample, has these columns, in
// steps: its singular values are within limits, and it turns by no more than 30 degrees.
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
    ivec2 p = ivec2(gl_FragCoord.xy);
    ivec2 size = imageSize(motion);
    bool mine = imageLoad(guide, p).r >> 16 == push.paint;
    uint word = motion_at(p, size);
    // Where the surface was hidden, the pixel around that moves most alike; of those alike the nearest.
    uint own = word;
    ivec2 shift = ivec2(0);
    int best = TOGETHER;
    for (int r = 1; r <= REACH && own < SHOWN && mine; r++) {
        for (int side = 0; side < 4; side++) {
            ivec2 by = r * ivec2(side == 0 ? 1 : side == 1 ? -1 : 0, side == 2 ? 1 : side == 3 ? -1 : 0);
            uint there = motion_at(p + by, size);
            ivec2 apart = abs(way_of(there) - way_of(own));
            // Where nothing is known of its own motion, the nearest will do.
            int cost = (own != 0 ? apart.x + apart.y : 0) + r;
            bool better = there >= SHOWN && cost < best;
            word = better ? there : word;
            shift = better ? by : shift;
            best = better ? cost : best;
        }
    }
    ivec2 way = way_of(word);
    // The nearest pixel, and the way from there, -32 to 31 steps.
    ivec2 nearest = (way + STEPS / 2) >> 6;
    ivec2 rest = way - STEPS * nearest;
    ivec2 from = p + shift + nearest;
    uvec4 middle = place_at(from, size);
    uvec4 right = place_at(from + ivec2(1, 0), size);
    uvec4 left = place_at(from - ivec2(1, 0), size);
    uvec4 below = place_at(from + ivec2(0, 1), size);
    uvec4 above = place_at(from - ivec2(0, 1), size);
    ivec2 here = steps_of(middle);
    ivec2 along = slope(here, right, left, ivec2(1, 0), rest.x >= 0);
    ivec2 down = slope(here, below, above, ivec2(0, 1), rest.y >= 0);
    ivec2 place = here + ((along * rest.x + down * rest.y + STEPS / 2) >> 6);
    bool present = is_present(middle);
    if (!present) {
        // The nearest neighbour that has texture, which goes on to here.
        ivec2 beyond = steps_of(above) + ivec2(0, STEPS);
        beyond = is_present(below) ? steps_of(below) - ivec2(0, STEPS) : beyond;
        beyond = is_present(left) ? steps_of(left) + ivec2(STEPS, 0) : beyond;
        beyond = is_present(right) ? steps_of(right) - ivec2(STEPS, 0) : beyond;
        place = beyond + rest;
        present = is_present(right) || is_present(left) || is_present(below) || is_present(above);
    }
    place -= STEPS * shift;
    present = present && mine && word >= SHOWN && in_sample(place, uvec2(push.sample_width, push.sample_height));
    carried = present ? place_of(place) : uvec4(0);
    // Where the middle has no texture, there are no differences to it either.
    carried.w |= present && is_present(middle) && !fits(along, down) ? MISFIT : 0;
    canvas = present ? imageLoad(sample_texels, (place + STEPS / 2) / STEPS).r | PAINTED : 0;
}
