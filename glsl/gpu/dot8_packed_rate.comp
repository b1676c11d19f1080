#version 450
// Ceilings: as dot8_rate, by the instruction of SPV_KHR_integer_dot_product. Only for devices with that feature.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_spirv_intrinsics : require
#define VALUE uvec4

// OpSDot with the capabilities DotProduct and DotProductInput4x8BitPacked, of PackedVectorFormat4x8Bit.
spirv_instruction(extensions = ["SPV_KHR_integer_dot_product"], capabilities = [6019, 6018], id = 4450)
int packed_dot(uint a, uint b, spirv_literal int format);

#define DOT(x, i) uint(packed_dot(x[i], multiplier[i], 0))
#define STEP(x) x += uvec4(DOT(x, 0), DOT(x, 1), DOT(x, 2), DOT(x, 3));
#include "rate.glsl"
