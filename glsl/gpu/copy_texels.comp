#version 450
// Ceilings: reads a storage image and writes another, a texel of 16 bytes an invocation.
// In: from. Out: to, each word with the bits of the seed turned over, which tells rounds apart.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, rgba32ui) uniform readonly uimage2D from;
layout(binding = 1, rgba32ui) uniform writeonly uimage2D to;

layout(push_constant) uniform Push {
    uint seed;
} push;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    imageStore(to, at, imageLoad(from, at) ^ push.seed);
}
