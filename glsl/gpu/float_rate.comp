#version 450
// Ceilings: multiply-adds of 32-bit floats without loads. The values are integers that a float holds exactly, with or
// without fused operations. Out: see rate.glsl.
#extension GL_GOOGLE_include_directive : require
#define VALUE vec4
#define STEP(x) x = x * multiplier + addend;
#include "rate.glsl"
