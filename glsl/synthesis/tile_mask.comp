#version 450
// Makes a picture tileable by blending it with itself, shifted by half, under a circular mask (thesis 3.2.3):
// O = (T M + T' M') / (M + M'), in integers, rounded to nearest.
// In:  picture, packed RGBA8; mask, M in 1/4096.  Out: the tileable picture.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32ui) uniform readonly uimage2D picture;
layout(binding = 1, r32ui) uniform readonly uimage2D mask;
layout(binding = 2, r32ui) uniform writeonly uimage2D tileable;

void main() {
    ivec2 size = imageSize(picture);
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, size))) {
        return;
    }
    ivec2 shifted = (p + size / 2) % size;
    uint here = imageLoad(picture, p).r;
    uint there = imageLoad(picture, shifted).r;
    uint m = imageLoad(mask, p).r;
    uint n = imageLoad(mask, shifted).r;
    uint texel = 0;
    for (int bit = 0; bit < 32; bit += 8) {
        uint a = (here >> bit) & 255u;
        uint b = (there >> bit) & 255u;
        texel |= (a * m + b * n + (m + n) / 2) / (m + n) << bit;
    }
    imageStore(tileable, p, uvec4(texel));
}
