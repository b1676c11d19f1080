#version 450
// Ceilings: multiply-adds of 32-bit integers without loads, which wrap around. Out: see rate.glsl.
#extension GL_GOOGLE_include_directive : require
#define VALUE uvec4
#define STEP(x) x = x * multiplier + addend;
#include "rate.glsl"
