#version 450
// Image-based technique, a frame between two textures that were synthesised for other frames (thesis chapter 6): colour by
// this frame's shade, texture blended between the two. One dispatch for each paint; pixels of others stay.
// Where only one of the two has texture, that is taken; the contrast of a blend is kept (paint.glsl), but blending takes
// none where both are the same texel, as they are wherever a block was matched with itself.
// In:  tone, guide, the canvases of the earlier and the later texture, the paints' colours.
// Out: frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "../synthesis/quilt.glsl"
#include "paint.glsl"

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32f) uniform readonly image2D tone;
layout(binding = 1, r32ui) uniform readonly uimage2D guide;
layout(binding = 2, r32ui) uniform readonly uimage2D earlier;
layout(binding = 3, r32ui) uniform readonly uimage2D later;
layout(binding = 4, r32ui) uniform readonly uimage2D colors;
layout(binding = 5, rgba8) uniform writeonly image2D frame;

layout(push_constant) uniform Push {
    uint paint;
    // 0 painted, 1 colour only, 2 texture only (mapped to 0..1).
    uint show;
    // 0 the earlier, 1 the later.
    float blend;
} push;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(tone)))) {
        return;
    }
    uint guided = imageLoad(guide, p).r;
    if (guided >> 16 != push.paint) {
        // The first paint's dispatch also clears what nobody paints.
        if (push.paint == 1 && guided == 0) {
            imageStore(frame, p, vec4(0.0));
        }
        return;
    }
    uvec2 texels = uvec2(imageLoad(earlier, p).r, imageLoad(later, p).r);
    bvec2 there = greaterThanEqual(texels, uvec2(PAINTED));
    vec2 w = vec2(1.0 - push.blend, push.blend);
    w = all(there) ? w : vec2(there);
    vec3 a = 2.0 * unpackUnorm4x8(texels.x).rgb - 1.0;
    vec3 b = 2.0 * unpackUnorm4x8(texels.y).rgb - 1.0;
    // Where neither has any, colour is all there is.
    float kept = texels.x == texels.y ? 1.0 : contrast_kept(dot(w, w));
    vec3 difference = any(there) ? (w.x * a + w.y * b) * kept : vec3(0.0);
    float shade = imageLoad(tone, p).r;
    vec3 color = unpackUnorm4x8(imageLoad(colors, color_place(shade, push.paint - 1)).r).rgb;
    imageStore(frame, p, shown(color, difference, push.show));
}
