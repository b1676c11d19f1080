#version 450
// Image-based technique, last stage: colour by shade from the trajectory, plus the texture difference that the
// synthesis brought to the pixel, clipped (thesis chapter 6, figure 6.1). One dispatch for each paint; pixels of others
// stay.
// In:  tone, guide, the synthesis's source coordinates, the paint's texture difference, the paints' colours.
// Out: frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "paint.glsl"

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32f) uniform readonly image2D tone;
layout(binding = 1, r32ui) uniform readonly uimage2D guide;
layout(binding = 2, r32ui) uniform readonly uimage2D source;
layout(binding = 3, rgba32f) uniform readonly image2D difference;
layout(binding = 4, r32ui) uniform readonly uimage2D colors;
layout(binding = 5, rgba8) uniform writeonly image2D frame;

layout(push_constant) uniform Push {
    uint paint;
    // 0 painted, 1 colour only, 2 texture only (mapped to 0..1).
    uint show;
} push;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(tone)))) {
        return;
    }
    uint texel = imageLoad(guide, p).r;
    if (texel >> 16 != push.paint) {
        // The first paint's dispatch also clears what nobody paints.
        if (push.paint == 1 && texel == 0) {
            imageStore(frame, p, vec4(0.0));
        }
        return;
    }
    vec3 color = unpackUnorm4x8(imageLoad(colors, color_place(imageLoad(tone, p).r, push.paint - 1)).r).rgb;
    uint from = imageLoad(source, p).r;
    vec3 texture_difference = imageLoad(difference, ivec2(from & 0xffffu, from >> 16)).rgb;
    imageStore(frame, p, shown(color, texture_difference, push.show));
}
