#version 450
// View-dependent interpolation, second pass (thesis chapter 8): texture from the slices of the views that show the
// face, each at the place where its view shows the point; colour by shade.
// In:  shade, corner and distance of each pixel's surface, the blend of every corner, the rows x, y and w of each
//      slice's projection, the slices, the paints' colours, for each object the rows that take world space to the
//      mesh's.
// Out: frame, straight alpha, background 0.
#extension GL_GOOGLE_include_directive : require
#include "paint.glsl"

layout(binding = 0, r32f) uniform readonly image2D shade;
layout(binding = 1, r32ui) uniform readonly uimage2D corner;
layout(binding = 2, r32f) uniform readonly image2D along;
layout(binding = 3, rgba32ui) uniform readonly uimage2D blends;
layout(binding = 4, rgba32f) uniform readonly image2D projections;
layout(binding = 5) uniform sampler3D volume;
layout(binding = 6, r32ui) uniform readonly uimage2D colors;
layout(binding = 7, rgba32f) uniform readonly image2D objects;

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

// Whether any object is elsewhere than in the mesh.
layout(constant_id = 0) const bool MOVED = true;

layout(location = 0) out vec4 frame;

// Difference, and how far inside the slice's faces the place lies, 0 to 1.
vec4 slice_at(uint slice, vec4 position) {
    int row = int(slice);
    vec3 clip = vec3(dot(imageLoad(projections, ivec2(0, row)), position),
                     dot(imageLoad(projections, ivec2(1, row)), position),
                     dot(imageLoad(projections, ivec2(2, row)), position));
    vec2 st = 0.5 + 0.5 * clip.xy / clip.z;
    vec4 texel = textureLod(volume, vec3(st, (float(slice) + 0.5) / float(push.slices)), 0.0);
    return vec4(2.0 * texel.rgb - 1.0, texel.a);
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    uint c = imageLoad(corner, p).r;
    uvec4 blend = imageLoad(blends, ivec2(c & 4095u, c >> 12));
    vec4 weight = vec4(unpackUnorm2x16(blend.x), unpackUnorm2x16(blend.y));
    vec3 ray = push.corner.xyz + gl_FragCoord.x * push.across.xyz + gl_FragCoord.y * push.down.xyz;
    vec4 world = vec4(push.eye.xyz + imageLoad(along, p).r * ray, 1.0);
    vec4 position = world;
    if (MOVED) {
        uint object = blend.w >> 16;
        ivec2 rows = ivec2(3u * (object & 1023u), object >> 10);
        position.xyz = vec3(dot(imageLoad(objects, rows), world), dot(imageLoad(objects, rows + ivec2(1, 0)), world),
                            dot(imageLoad(objects, rows + ivec2(2, 0)), world));
    }
    // A slice counts for less towards the faces that it does not show, and for nearly nothing where it ends.
    vec4 blended = vec4(0.0);
    float squares = 0.0;
    for (int i = 0; i < 4; i++) {
        if (weight[i] > 0.0) {
            vec4 texel = slice_at((blend.z >> (8 * i)) & 255u, position);
            float counts = weight[i] * max(texel.a, 1.0 / 255.0);
            blended += counts * vec4(texel.rgb, 1.0);
            squares += counts * counts;
        }
    }
    vec3 difference = blended.rgb / blended.w;
    if (push.keep_contrast != 0) {
        difference *= contrast_kept(squares / (blended.w * blended.w));
    }
    float tone = tone_of(imageLoad(shade, p).r, push.range);
    frame = shown(unpackUnorm4x8(imageLoad(colors, color_place(tone, blend.w & 65535u)).r).rgb, difference, push.show);
}
