#version 450
// Image-based technique: the model's own range of shade, from the histogram, less half a percent of the pixels at each
// end. One workgroup.

layout(local_size_x = 128) in;

const uint BINS = 1024;
const uint PER_LANE = BINS / 128;

layout(binding = 0, std430) readonly buffer Histogram { uint bins[BINS]; };
layout(binding = 1, std430) writeonly buffer Levels { vec2 levels; };

shared uint sums[128];
shared uint low;
shared uint high;

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint mine = 0;
    for (uint i = 0; i < PER_LANE; i++) {
        mine += bins[lane * PER_LANE + i];
    }
    sums[lane] = mine;
    if (lane == 0) {
        low = BINS - 1;
        high = 0;
    }
    // Inclusive prefix sums.
    for (uint stride = 1; stride < 128; stride *= 2) {
        barrier();
        uint left = lane >= stride ? sums[lane - stride] : 0;
        barrier();
        sums[lane] += left;
    }
    barrier();
    uint total = sums[127];
    uint cut = total / 200;
    uint below = sums[lane] - mine;
    for (uint i = 0; i < PER_LANE; i++) {
        uint bin = lane * PER_LANE + i;
        uint upto = below + bins[bin];
        if (upto > cut) {
            atomicMin(low, bin);
        }
        if (total - below > cut) {
            atomicMax(high, bin);
        }
        below = upto;
    }
    barrier();
    if (lane == 0) {
        levels = vec2(low, high) / float(BINS - 1);
    }
}
