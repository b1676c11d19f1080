#version 450
// Image-based technique, texture that follows the surface, last stage: where each pixel's texture comes from after this
// frame's repairs, and the frame. One dispatch for each paint; pixels of others stay.
//
// Places lie between texels. The texture difference is taken there once, from the sample itself, by cubic convolution
// (Keys 1981, a = -1/2), which is the texel itself where a place is one: what was pasted in this frame is a plain copy.
// In:  tone, guide, source (what was pasted in this frame), carried places, the paint's texture difference, trajectory.
// Out: places, for the next frame; frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "../synthesis/carried.glsl"
#include "recombine.glsl"

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32f) uniform readonly image2D tone;
layout(binding = 1, r32ui) uniform readonly uimage2D guide;
layout(binding = 2, r32ui) uniform readonly uimage2D source;
layout(binding = 3, rg32ui) uniform readonly uimage2D carried;
layout(binding = 4, rgba32f) uniform readonly image2D difference;
layout(binding = 5, std430) readonly buffer Trajectory { vec4 colors[]; };
layout(binding = 6, rg32ui) uniform writeonly uimage2D places;
layout(binding = 7, rgba8) uniform writeonly image2D frame;

layout(push_constant) uniform Push {
    uint paint;
    // 0 painted, 1 colour only, 2 texture only (mapped to 0..1).
    uint show;
} push;

// Weights of the texels at -1, 0, 1 and 2 for a place at t between 0 and 1.
vec4 cubic(float t) {
    float u = 1.0 - t;
    return 0.5 * vec4(-t * u * u, 2.0 + t * t * (3.0 * t - 5.0), 2.0 + u * u * (3.0 * u - 5.0), -u * t * t);
}

vec3 texel(ivec2 at, ivec2 last) {
    return imageLoad(difference, clamp(at, ivec2(0), last)).rgb;
}

vec3 row(ivec2 at, vec4 w, ivec2 last) {
    return w.x * texel(at - ivec2(1, 0), last) + w.y * texel(at, last) + w.z * texel(at + ivec2(1, 0), last) +
           w.w * texel(at + ivec2(2, 0), last);
}

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
            imageStore(places, p, uvec4(0));
        }
        return;
    }
    uint from = imageLoad(source, p).r;
    ivec2 pasted = STEPS * ivec2(from & 0xffffu, from >> 16);
    ivec2 place = from != NOT_PASTED ? pasted : steps_of(imageLoad(carried, p).rg);
    imageStore(places, p, uvec4(place.x, uint(place.y) | PRESENT, 0, 0));

    ivec2 at = place >> 6;
    vec2 t = vec2(place - STEPS * at) / float(STEPS);
    ivec2 last = imageSize(difference) - 1;
    vec4 across = cubic(t.x);
    vec4 down = cubic(t.y);
    vec3 texture_difference = down.x * row(at - ivec2(0, 1), across, last) + down.y * row(at, across, last) +
                              down.z * row(at + ivec2(0, 1), across, last) + down.w * row(at + ivec2(0, 2), across, last);
    float shade = imageLoad(tone, p).r * float(colors.length() - 1);
    int i = clamp(int(shade), 0, colors.length() - 1);
    vec3 color = mix(colors[i].rgb, colors[min(i + 1, colors.length() - 1)].rgb, shade - float(i));
    imageStore(frame, p, recombined(color, texture_difference, push.show));
}
