#version 450
// View-dependent interpolation (thesis chapter 8): texture from the slices of the views that show the face, each at the
// place where its view shows the point; colour by shade.
// In:  the blend of every set of slices, the rows x, y and w of each slice's projection, the slices, the paints' colours.
// Out: frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "../scene/shade.glsl"
#include "paint.glsl"

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) flat in uvec2 face;

layout(binding = 0, rgba32f) uniform readonly image2D blends;
layout(binding = 1, rgba32f) uniform readonly image2D projections;
layout(binding = 2) uniform sampler3D volume;
layout(binding = 3, r32ui) uniform readonly uimage2D colors;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
    vec2 range;
    uint slices;
    uint show;
} push;

layout(location = 0) out vec4 frame;

vec3 slice_at(float slice) {
    vec4 p = vec4(world_position, 1.0);
    int row = int(slice);
    vec3 clip = vec3(dot(imageLoad(projections, ivec2(0, row)), p), dot(imageLoad(projections, ivec2(1, row)), p),
                     dot(imageLoad(projections, ivec2(2, row)), p));
    vec2 st = 0.5 + 0.5 * clip.xy / clip.z;
    return 2.0 * textureLod(volume, vec3(st, (slice + 0.5) / float(push.slices)), 0.0).rgb - 1.0;
}

void main() {
    float tone = tone_of(shade_of(world_normal, push.light.xyz, gl_FrontFacing), push.range);
    ivec2 place = ivec2(face.x & 1023u, 2 * (face.x >> 10));
    vec4 weight = imageLoad(blends, place);
    vec3 slice = imageLoad(blends, place + ivec2(0, 1)).xyz;
    vec3 difference = weight.x * slice_at(slice.x);
    if (weight.y > 0.0) {
        difference += weight.y * slice_at(slice.y);
    }
    if (weight.z > 0.0) {
        difference += weight.z * slice_at(slice.z);
    }
    frame = shown(unpackUnorm4x8(imageLoad(colors, color_place(tone, face.y)).r).rgb, difference * weight.w, push.show);
}
