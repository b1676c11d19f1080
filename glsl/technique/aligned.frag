#version 450
// View-aligned 3D texture projection (thesis chapter 7): texture from the volume by place in the picture and by shade,
// colour by shade.
// In:  shade and object ID of the guides; for each object where its texture lies, two floats as bits, and its paint;
//      all paints' levels in one volume (dark first), the paints' colours.
// Out: frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "paint.glsl"

layout(binding = 0, r32f) uniform readonly image2D shade;
layout(binding = 1, r32ui) uniform readonly uimage2D id;
layout(binding = 2, rgba32ui) uniform readonly uimage2D objects;
layout(binding = 3) uniform sampler3D volume;
layout(binding = 4, r32ui) uniform readonly uimage2D colors;

layout(push_constant) uniform Push {
    vec2 range;
    // Repeats of the texture to a pixel of the picture.
    float scale;
    uint levels;
    uint slices;
    uint show;
    uint keep_contrast;
} push;

layout(location = 0) out vec4 frame;

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    uint object = imageLoad(id, p).r;
    if (object == 0) {
        frame = vec4(0.0);
        return;
    }
    object--;
    uvec4 own = imageLoad(objects, ivec2(object & 1023u, object >> 10));
    // Where the picture's left upper corner lies on the texture, in repeats of it.
    vec2 offset = uintBitsToFloat(own.xy);
    uint paint = own.z;
    float tone = tone_of(imageLoad(shade, p).r, push.range);
    // The shade's place among the levels, 0 to levels - 1, is a place among texel centres.
    float place = tone * float(push.levels - 1);
    float r = (float(paint * push.levels) + place + 0.5) / float(push.slices);
    vec2 st = gl_FragCoord.xy * push.scale + offset;
    vec3 difference = 2.0 * textureLod(volume, vec3(st, r), 0.0).rgb - 1.0;
    if (push.keep_contrast != 0) {
        float f = fract(place);
        difference *= contrast_kept(f * f + (1.0 - f) * (1.0 - f));
    }
    frame = shown(unpackUnorm4x8(imageLoad(colors, color_place(tone, paint)).r).rgb, difference, push.show);
}
