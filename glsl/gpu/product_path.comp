#version 450
// Ceilings: multiply-adds by the path of quilt_bound: 16-bit coordinates of positions, eight to a texel of an rgba32ui
// storage image, times templates in shared memory. An invocation takes two positions, one above the other, and 10
// templates. As there, no loop stands around it: with one, lavapipe reached less than half.
//
// Coordinates are small integers, whose products must add up to less than 2^24, as floats hold no more exactly.
// In:  coordinates, 256 positions in x, 2 in y, 8 texels each, the first texels of both rows first; templates, side by
//      side, two texels of four numbers for each texel of coordinates.
// Out: a word for each invocation, which depends on the lowest 8 bits of its number.
#extension GL_EXT_control_flow_attributes : require

layout(local_size_x = 128) in;

const uint TEXELS = 8;
const uint TEMPLATES = 10;
// Rows of positions.
const uint ROWS = 2;

layout(binding = 0, rgba32ui) uniform readonly uimage2D coordinates;
layout(binding = 1, rgba32f) uniform readonly image2D templates;
layout(binding = 2, std430) writeonly buffer Results { uint results[]; };

layout(push_constant) uniform Push {
    // Tells rounds apart.
    uint seed;
} push;

shared vec4 chunk[2 * TEXELS * TEMPLATES];

// Two coordinates of 16 bits.
vec2 unpacked(uint word) {
    return vec2(int(word << 16) >> 16, int(word) >> 16);
}

void main() {
    for (uint i = gl_LocalInvocationIndex; i < 2 * TEXELS * TEMPLATES; i += 128) {
        chunk[i] = imageLoad(templates, ivec2(i % TEMPLATES, i / TEMPLATES));
    }
    barrier();
    uint x = gl_GlobalInvocationID.x & 255u;
    float sums[ROWS * TEMPLATES];
    [[unroll]] for (uint i = 0; i < ROWS * TEMPLATES; i++) {
        sums[i] = 0.0;
    }
    [[unroll]] for (uint i = 0; i < TEXELS; i++) {
        [[unroll]] for (uint r = 0; r < ROWS; r++) {
            uvec4 words = imageLoad(coordinates, ivec2(x, ROWS * i + r));
            vec4 a = vec4(unpacked(words.x), unpacked(words.y));
            vec4 b = vec4(unpacked(words.z), unpacked(words.w));
            [[unroll]] for (uint k = 0; k < TEMPLATES; k++) {
                sums[r * TEMPLATES + k] +=
                    dot(a, chunk[2 * i * TEMPLATES + k]) + dot(b, chunk[(2 * i + 1) * TEMPLATES + k]);
            }
        }
    }
    uint sum = 0;
    [[unroll]] for (uint i = 0; i < ROWS * TEMPLATES; i++) {
        sum += (2 * i + 1) * uint(int(sums[i]));
    }
    results[gl_GlobalInvocationID.x] = sum ^ push.seed;
}
