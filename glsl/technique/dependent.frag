#version 450
// View-dependent interpolation, second pass (thesis chapter 8): texture from the slices of the views that show the face,
// each at the place where its view shows the point; colour by shade.
// In:  shade, set of slices and distance of each pixel's surface, the blend of every set, the rows x, y and w of each
//      slice's projection, the slices, the paints' colours.
// Out: frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "paint.glsl"

layout(binding = 0, r32f) uniform readonly image2D shade;
layout(binding = 1, r32ui) uniform readonly uimage2D set;
layout(binding = 2, r32f) uniform readonly image2D along;
layout(binding = 3, rgba32ui) uniform readonly uimage2D blends;
layout(binding = 4, rgba32f) uniform readonly image2D projections;
layout(binding = 5) uniform sampler3D volume;
layout(binding = 6, r32ui) uniform readonly uimage2D colors;

layout(push_constant) uniform Push {
    // The surface of pixel (x, y) at distance d along the view axis is eye + d * (corner + x * across + y * down).
    vec4 eye;
    vec4 corner;
    vec4 across;
    vec4 down;
    vec2 range;
    uint slices;
    uint show;
    uint keep_contrast;
} push;

layout(location = 0) out vec4 frame;

vec3 slice_at(uint slice, vec4 position) {
    int row = int(slice);
    vec3 clip = vec3(dot(imageLoad(projections, ivec2(0, row)), position),
                     dot(imageLoad(projections, ivec2(1, row)), position),
                     dot(imageLoad(projections, ivec2(2, row)), position));
    vec2 st = 0.5 + 0.5 * clip.xy / clip.z;
    return 2.0 * textureLod(volume, vec3(st, (float(slice) + 0.5) / float(push.slices)), 0.0).rgb - 1.0;
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    uint s = imageLoad(set, p).r;
    uvec4 blend = imageLoad(blends, ivec2(s & 1023u, s >> 10));
    vec4 weight = vec4(unpackUnorm2x16(blend.x), unpackUnorm2x16(blend.y));
    vec3 ray = push.corner.xyz + gl_FragCoord.x * push.across.xyz + gl_FragCoord.y * push.down.xyz;
    vec4 position = vec4(push.eye.xyz + imageLoad(along, p).r * ray, 1.0);
    vec3 difference = weight.x * slice_at(blend.z & 255u, position);
    if (weight.y > 0.0) {
        difference += weight.y * slice_at((blend.z >> 8) & 255u, position);
    }
    if (weight.z > 0.0) {
        difference += weight.z * slice_at((blend.z >> 16) & 255u, position);
    }
    if (weight.w > 0.0) {
        difference += weight.w * slice_at(blend.z >> 24, position);
    }
    if (push.keep_contrast != 0) {
        difference *= contrast_kept(dot(weight, weight));
    }
    float tone = tone_of(imageLoad(shade, p).r, push.range);
    frame = shown(unpackUnorm4x8(imageLoad(colors, color_place(tone, blend.w)).r).rgb, difference, push.show);
}
