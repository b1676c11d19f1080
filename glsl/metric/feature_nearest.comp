#version 450
// The thesis's texture metric (chapter 9.1): the nearest source blocks of each tested block in a segment of the source.
// One invocation a segment; the host takes the nearest of all segments.
// In:  distances (feature_distance.comp).
// Out: for tested block t and segment s, from (t * segments + s) * KEPT on, the KEPT nearest, nearest first and of equal ones
//      the first: the distance's bits and the source block; unused ones have an infinite distance.

layout(local_size_x = 64) in;

layout(constant_id = 0) const int KEPT = 16;

layout(binding = 0, r32f) uniform readonly image2D distances;
layout(binding = 1, std430) writeonly buffer Nearest { uvec2 nearest[]; };

layout(push_constant) uniform Push {
    uint blocks;
    uint segments;
    uint segment_blocks;
    uint tested;
} push;

void main() {
    uint segment = gl_GlobalInvocationID.x % push.segments;
    uint tested = gl_GlobalInvocationID.x / push.segments;
    if (tested >= push.tested) {
        return;
    }
    float best[KEPT];
    uint at[KEPT];
    for (int k = 0; k < KEPT; k++) {
        best[k] = uintBitsToFloat(0x7f800000u);
        at[k] = 0;
    }
    uint end = min((segment + 1) * push.segment_blocks, push.blocks);
    for (uint block = segment * push.segment_blocks; block < end; block++) {
        uint texel = tested * push.blocks + block;
        float a = imageLoad(distances, ivec2(texel & 4095u, texel >> 12)).r;
        uint i = block;
        // What is nearer than one that is kept takes its place, and all that follow move on by one.
        bool placed = false;
        for (int k = 0; k < KEPT; k++) {
            placed = placed || a < best[k];
            float moved = best[k];
            uint moved_at = at[k];
            best[k] = placed ? a : moved;
            at[k] = placed ? i : moved_at;
            a = placed ? moved : a;
            i = placed ? moved_at : i;
        }
    }
    uint first = (tested * push.segments + segment) * uint(KEPT);
    for (int k = 0; k < KEPT; k++) {
        nearest[first + k] = uvec2(floatBitsToUint(best[k]), at[k]);
    }
}
