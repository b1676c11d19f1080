#version 450
// The thesis's texture metric (chapter 9.1): which bin of each of its 15 histograms every pixel falls into.
// In:  a picture, red in the low byte.
// Out: 4 bits for each histogram: 0 to 7 in `low`, 8 to 14 in `high`. Channel c has 5c (its colour) and 5c + 1 to 5c + 4 (the
//      four edge filters in the thesis's order). In integers, so the same everywhere.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32ui) uniform readonly uimage2D picture;
layout(binding = 1, r32ui) uniform writeonly uimage2D low;
layout(binding = 2, r32ui) uniform writeonly uimage2D high;

// A pixel's channels; at the edge of the picture its last pixel goes on.
ivec3 at(ivec2 p, ivec2 most) {
    uint texel = imageLoad(picture, clamp(p, ivec2(0), most)).r;
    return ivec3(texel & 255u, (texel >> 8) & 255u, (texel >> 16) & 255u);
}

// Ten equal bins over [0, 1], here [0, 255].
uvec3 color_bin(ivec3 value) {
    return min(uvec3(value * 10) / 255u, 9u);
}

// Ten equal bins over [-3, 3], here [-765, 765].
uvec3 edge_bin(ivec3 value) {
    return min(uvec3(value + 765) / 153u, 9u);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 most = imageSize(picture) - 1;
    if (any(greaterThan(p, most))) {
        return;
    }
    ivec3 nw = at(p + ivec2(-1, -1), most), n = at(p + ivec2(0, -1), most), ne = at(p + ivec2(1, -1), most);
    ivec3 w = at(p + ivec2(-1, 0), most), e = at(p + ivec2(1, 0), most);
    ivec3 sw = at(p + ivec2(-1, 1), most), s = at(p + ivec2(0, 1), most), se = at(p + ivec2(1, 1), most);
    uvec3 bins[5] = uvec3[](color_bin(at(p, most)), edge_bin(ne + e + se - nw - w - sw), edge_bin(sw + s + se - nw - n - ne),
                            edge_bin(3 * (ne - sw)), edge_bin(3 * (se - nw)));
    uint words[2] = uint[](0, 0);
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 5; k++) {
            int histogram = 5 * c + k;
            words[histogram / 8] |= bins[k][c] << (4 * (histogram % 8));
        }
    }
    imageStore(low, p, uvec4(words[0]));
    imageStore(high, p, uvec4(words[1]));
}
