// The record of a workgroup's block. For shaders that have declared `blocks`.

shared Block shared_block;

// All invocations call it at once. One of them loads: eleven words for each would cost lavapipe as much as comparing
// some positions, and what is shared, at a place that is known when the pipeline is made, it reads once for all.
Block load_block(uint index) {
    if (gl_LocalInvocationIndex == 0) {
        shared_block = blocks[index];
    }
    barrier();
    return shared_block;
}
