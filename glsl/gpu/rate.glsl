// What the shaders that measure a rate of arithmetic without loads share. Whoever includes this defines VALUE, a vector
// of four, and STEP(x), which changes the four each by a step of its own: one operation, or one multiply-add, or one
// scalar product of four pairs.
//
// Twelve independent chains, so that no step waits for the one before it, and few enough for 16 registers. The
// multiplier is a push constant, so that no compiler can know it.
// Out: a word for each invocation, which depends on the lowest 8 bits of its number and on all steps.

layout(local_size_x = 128) in;

layout(binding = 0, std430) writeonly buffer Results { uint results[]; };

layout(push_constant) uniform Push {
    uint iterations;
    uint multiplier, addend;
    // Tells rounds apart.
    uint seed;
} push;

VALUE multiplier, addend;

void main() {
    multiplier = VALUE(push.multiplier);
    addend = VALUE(push.addend);
    uvec4 start = (gl_GlobalInvocationID.x & 255u) + uvec4(0, 1, 2, 3);
    VALUE a = VALUE(start), b = VALUE(start + 4u), c = VALUE(start + 8u);
    for (uint i = 0; i < push.iterations; i++) {
        STEP(a) STEP(b) STEP(c) STEP(a) STEP(b) STEP(c) STEP(a) STEP(b) STEP(c) STEP(a) STEP(b) STEP(c)
    }
    uvec4 sum = uvec4(a) + uvec4(b) + uvec4(c);
    results[gl_GlobalInvocationID.x] = (sum.x + 3u * sum.y + 5u * sum.z + 7u * sum.w) ^ push.seed;
}
