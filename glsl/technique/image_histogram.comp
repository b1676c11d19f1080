#version 450
// Image-based technique, before its levels: how often each shade occurs on the model, so that the model's own range can
// be spread over the whole strip. One bin for each 1/1024 of shade. Counts are integers, so their order does not
// matter.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32f) uniform readonly image2D shade;
layout(binding = 1, r32ui) uniform readonly uimage2D id;
layout(binding = 2, std430) buffer Histogram { uint bins[1024]; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(shade))) || imageLoad(id, p).r == 0) {
        return;
    }
    uint bin = uint(clamp(imageLoad(shade, p).r, 0.0, 1.0) * 1023.0 + 0.5);
    atomicAdd(bins[bin], 1);
}
