#version 450
// Image-based technique, texture that follows the surface, last stage: where each pixel's texture comes from after this
// frame's repairs, and the frame. One draw for each paint; pixels of others stay.
//
// Places lie between texels. The texture difference is taken there once, from the sample itself, by cubic convolution
// (Keys 1981), which is the texel itself where a place is one: what was pasted in this frame is a plain copy.
// In:  tone, guide, source (what was pasted in this frame), carried places, the paint's texture difference,
//      the paints' colours.
// Out: frame, straight alpha, background 0; places, for the next frame.
#extension GL_GOOGLE_include_directive : require
#include "../synthesis/carried.glsl"
#include "paint.glsl"

layout(binding = 0, r32f) uniform readonly image2D tone;
layout(binding = 1, r32ui) uniform readonly uimage2D guide;
layout(binding = 2, r32ui) uniform readonly uimage2D source;
layout(binding = 3, rgba16ui) uniform readonly uimage2D carried;
layout(binding = 4) uniform sampler2D difference;
layout(binding = 5, r32ui) uniform readonly uimage2D colors;

layout(push_constant) uniform Push {
    uint paint;
    // 0 painted, 1 colour only, 2 texture only (mapped to 0..1).
    uint show;
} push;

layout(location = 0) out vec4 frame;
layout(location = 1) out uvec4 places;

// Keys's parameter. Below his -1/2 the filter sharpens a little: places between texels then have on the mean the
// contrast of texels, over brush marks, charcoal and watercolour alike, and carrying takes no sharpness from a
// sequence.
const float A = -0.9;

// Weights of the texels at -1, 0, 1 and 2 for a place at t between 0 and 1.
vec4 cubic(float t) {
    float u = 1.0 - t;
    return vec4(A * t * u * u, ((A + 2.0) * t - (A + 3.0)) * t * t + 1.0, ((A + 2.0) * u - (A + 3.0)) * u * u + 1.0,
                A * u * t * t);
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    if (imageLoad(guide, p).r >> 16 != push.paint) {
        discard;
    }
    uint from = imageLoad(source, p).r;
    ivec2 pasted = STEPS * ivec2(from & 0xffffu, from >> 16);
    ivec2 steps = from != NOT_PASTED ? pasted : steps_of(imageLoad(carried, p));
    places = place_of(steps);

    // Texels in pairs: where the hardware's linear filter must look to weigh the two in the middle as it should.
    ivec2 at = steps >> 6;
    vec2 t = vec2(steps - STEPS * at) / float(STEPS);
    vec4 x = cubic(t.x);
    vec4 y = cubic(t.y);
    vec2 middle = vec2(x.y + x.z, y.y + y.z);
    vec2 size = vec2(textureSize(difference, 0));
    vec2 before = (vec2(at) - 0.5) / size;
    vec2 between = (vec2(at) + 0.5 + vec2(x.z, y.z) / middle) / size;
    vec2 after = (vec2(at) + 2.5) / size;
    // The corners' weights are small, at most 1/56, and go to the others.
    vec3 sum = textureLod(difference, between, 0.0).rgb * (middle.x * middle.y);
    sum += textureLod(difference, vec2(before.x, between.y), 0.0).rgb * (x.x * middle.y);
    sum += textureLod(difference, vec2(after.x, between.y), 0.0).rgb * (x.w * middle.y);
    sum += textureLod(difference, vec2(between.x, before.y), 0.0).rgb * (middle.x * y.x);
    sum += textureLod(difference, vec2(between.x, after.y), 0.0).rgb * (middle.x * y.w);
    float weight = middle.x * middle.y + (x.x + x.w) * middle.y + middle.x * (y.x + y.w);
    vec3 texture_difference = 2.0 * sum / weight - 1.0;
    float shade = imageLoad(tone, p).r;
    vec3 color = unpackUnorm4x8(imageLoad(colors, color_place(shade, push.paint - 1)).r).rgb;
    frame = shown(color, texture_difference, push.show);
}
