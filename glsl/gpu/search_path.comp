#version 450
// Ceilings: multiply-adds by the path of quilt_search: 19 loads of packed RGB from r32ui storage images for 6 texels of
// a block at 8 neighbouring positions of a sample, that is 48 comparisons of three multiply-adds.
//
// Channels are below 16, so that 4,095 texels can be summed in a float without rounding.
// In:  sample, 176 x 80 texels, and a block of 30 x 64. The 16 x 16 places an invocation may have repeat.
// Out: a word for each invocation, which depends on the lowest 8 bits of its number.

layout(local_size_x = 128) in;

layout(binding = 0, r32ui) uniform readonly uimage2D sample_texels;
layout(binding = 1, r32ui) uniform readonly uimage2D block_texels;
layout(binding = 2, std430) writeonly buffer Results { uint results[]; };

layout(push_constant) uniform Push {
    // Rows of the block that are compared; after 64 it begins again.
    uint rows;
    // Tells rounds apart.
    uint seed;
} push;

const int BLOCK_WIDTH = 30;

vec3 unpack_rgb(uint texel) {
    return vec3(uvec3(texel, texel >> 8, texel >> 16) & 0xffu);
}

// Written out as in quilt_search.
#define BLOCK_TEXEL(i) vec3 b##i = unpack_rgb(imageLoad(block_texels, ivec2(dx + i, row)).r);
#define SAMPLE_TEXEL(k) vec3 a##k = unpack_rgb(imageLoad(sample_texels, at + ivec2(dx + k, row)).r);
#define POSITION(s, p0, p1, p2, p3, p4, p5)                                                                            \
    s += dot(p0, b0) + dot(p1, b1) + dot(p2, b2) + dot(p3, b3) + dot(p4, b4) + dot(p5, b5);

void main() {
    uint lane = gl_GlobalInvocationID.x & 255u;
    ivec2 at = ivec2(8u * (lane & 15u), lane >> 4);
    float s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0, s4 = 0.0, s5 = 0.0, s6 = 0.0, s7 = 0.0;
    int dx = 0;
    for (uint dy = 0; dy < push.rows;) {
        int row = int(dy & 63u);
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
        dx += 6;
        dy += dx < BLOCK_WIDTH ? 0 : 1;
        dx = dx < BLOCK_WIDTH ? dx : 0;
    }
    uint sum = uint(s0) + 3u * uint(s1) + 5u * uint(s2) + 7u * uint(s3);
    sum += 9u * uint(s4) + 11u * uint(s5) + 13u * uint(s6) + 15u * uint(s7);
    results[gl_GlobalInvocationID.x] = sum ^ push.seed;
}
