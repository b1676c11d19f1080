#version 450
// Ceilings: reads a storage buffer and writes another.
// Each invocation copies four times 16 bytes, so far apart that neighbours touch what lies side by side.
// In: from. Out: to, each word with the bits of the seed turned over, which tells rounds apart.

layout(local_size_x = 128) in;

layout(binding = 0, std430) readonly buffer From { uvec4 from[]; };
layout(binding = 1, std430) writeonly buffer To { uvec4 to[]; };

layout(push_constant) uniform Push {
    uint seed;
} push;

void main() {
    uint at = 4u * gl_WorkGroupSize.x * gl_WorkGroupID.x + gl_LocalInvocationID.x;
    for (uint i = 0; i < 4; i++) {
        to[at] = from[at] ^ push.seed;
        at += gl_WorkGroupSize.x;
    }
}
