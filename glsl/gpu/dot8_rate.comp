#version 450
// Ceilings: scalar products of four pairs of signed 8-bit integers, added to 32 bits, without loads, by shifts: what
// every device can do. Out: see rate.glsl.
#extension GL_GOOGLE_include_directive : require
#define VALUE uvec4

// The four scalar products of x with the multiplier.
#define PAIR(i) uvec4(bitfieldExtract(ivec4(x), 8 * i, 8) * bitfieldExtract(ivec4(multiplier), 8 * i, 8))
#define STEP(x) x += dot8(x);
uvec4 dot8(uvec4 x);
#include "rate.glsl"

uvec4 dot8(uvec4 x) {
    return PAIR(0) + PAIR(1) + PAIR(2) + PAIR(3);
}
