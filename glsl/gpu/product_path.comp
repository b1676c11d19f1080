#version 450
// Ceilings: multiply-adds of the product of a matrix of positions with one of templates: 16 loads from an rgba32f
// storage image, 64 coordinates of a position, each multiplied with those of 8 templates in a uniform buffer, whose
// places are literals (some compilers read uniforms for each lane otherwise).
//
// Coordinates are integers below 16, so that 1,165 products of positions can be summed in a float without rounding.
// In:  coordinates, 256 positions in x, 4 rows of positions, of 16 texels each, in y; templates, all texels 0 of the 8
//      first.
// Out: a word for each invocation, which depends on the lowest 8 bits of its number.

layout(local_size_x = 128) in;

layout(binding = 0, rgba32f) uniform readonly image2D coordinates;
layout(binding = 1, std140) uniform Templates { vec4 templates[128]; };
layout(binding = 2, std430) writeonly buffer Results { uint results[]; };

layout(push_constant) uniform Push {
    // How many rows of positions are multiplied; after 4 they begin again.
    uint rows;
    // Tells rounds apart.
    uint seed;
} push;

// Written out, because arrays would be kept in memory by some compilers.
#define TEXEL(i)                                                                                                       \
    p = imageLoad(coordinates, at + ivec2(0, i));                                                                      \
    s0 += dot(p, templates[8 * i]);                                                                                    \
    s1 += dot(p, templates[8 * i + 1]);                                                                                \
    s2 += dot(p, templates[8 * i + 2]);                                                                                \
    s3 += dot(p, templates[8 * i + 3]);                                                                                \
    s4 += dot(p, templates[8 * i + 4]);                                                                                \
    s5 += dot(p, templates[8 * i + 5]);                                                                                \
    s6 += dot(p, templates[8 * i + 6]);                                                                                \
    s7 += dot(p, templates[8 * i + 7]);

void main() {
    int x = int(gl_GlobalInvocationID.x & 255u);
    float s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0, s4 = 0.0, s5 = 0.0, s6 = 0.0, s7 = 0.0;
    for (uint row = 0; row < push.rows; row++) {
        ivec2 at = ivec2(x, 16u * (row & 3u));
        vec4 p;
        TEXEL(0) TEXEL(1) TEXEL(2) TEXEL(3) TEXEL(4) TEXEL(5) TEXEL(6) TEXEL(7)
        TEXEL(8) TEXEL(9) TEXEL(10) TEXEL(11) TEXEL(12) TEXEL(13) TEXEL(14) TEXEL(15)
    }
    uint sum = uint(s0) + 3u * uint(s1) + 5u * uint(s2) + 7u * uint(s3);
    sum += 9u * uint(s4) + 11u * uint(s5) + 13u * uint(s6) + 15u * uint(s7);
    results[gl_GlobalInvocationID.x] = sum ^ push.seed;
}
