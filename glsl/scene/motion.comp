#version 450
// Where each pixel's surface was in the previous frame, and whether that frame showed it (thesis 9.3: coherence in
// object space).
// In:  ID and depth now and then; for object i, in columns 3 * (i % 1024) to + 2 and row i / 1024, the rows that take a
//      place now, (x, y, 1 - depth, 1) of clip space, to x, y and w of clip space then, by the distance now.
// Out: a word of two times 15 bits, x low, each 16,384 + 64 times the pixels of the way to the place then, and the highest
//      bit where that frame showed it. Where nothing is now, or the way is longer, the 0 that the image was cleared to
//      stays: on lavapipe a store costs more than all the arithmetic.
//
// Far from the eye depths crowd just below 1, where 1 - depth is exact. Distances along the view axis are linear in it.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32ui) uniform readonly uimage2D id_now;
layout(binding = 1) uniform sampler2D depth_now;
layout(binding = 2, r32ui) uniform readonly uimage2D id_then;
layout(binding = 3) uniform sampler2D depth_then;
layout(binding = 4, rgba32f) uniform readonly image2D objects;
layout(binding = 5, r32ui) uniform writeonly uimage2D motion;

layout(push_constant) uniform Push {
    // What a place, as above, is multiplied by to give 1 / its distance along the view axis, now and then.
    vec4 nearness_now;
    vec4 nearness_then;
    // Half of what the camera then sees across and down, one unit before it.
    vec2 half_view;
    // The near plane then.
    float near;
    // How far apart, one unit before the eye now, two points may be to be the same.
    float same;
} push;

vec4 place_at(ivec2 p, float depth, vec2 pixel) {
    return vec4((vec2(p) + 0.5) * pixel - 1.0, 1.0 - depth, 1.0);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(id_now);
    if (any(greaterThanEqual(p, size))) {
        return;
    }
    vec2 pixel = 2.0 / vec2(size);
    uint id = imageLoad(id_now, p).r;
    if (id == 0u) {
        return;
    }
    uint object = id - 1u;
    vec4 here = place_at(p, texelFetch(depth_now, p, 0).r, pixel);
    ivec2 rows = ivec2(3u * (object & 1023u), object >> 10);
    // The surface's point as the eye had it then: across, down, along; all by its distance now.
    vec3 seen = vec3(dot(imageLoad(objects, rows), here), dot(imageLoad(objects, rows + ivec2(1, 0)), here),
                     dot(imageLoad(objects, rows + ivec2(2, 0)), here));
    float nearness = dot(push.nearness_now, here);
    vec2 then = (seen.xy / seen.z + 1.0) / pixel - 0.5;
    vec2 nearest = floor(then + 0.5);
    bool inside = seen.z > push.near * nearness && all(greaterThanEqual(nearest, vec2(0.0))) &&
                  all(lessThan(nearest, vec2(size)));
    ivec2 q = inside ? ivec2(nearest) : p;
    // What was shown there, in the same terms.
    vec4 there = place_at(q, texelFetch(depth_then, q, 0).r, pixel);
    vec3 apart = seen - vec3(there.xy, 1.0) * (nearness / dot(push.nearness_then, there));
    apart.xy *= push.half_view;
    bool shown = inside && imageLoad(id_then, q).r == id && dot(apart, apart) <= push.same * push.same;
    vec2 way = floor(64.0 * (then - vec2(p)) + 0.5) + 16384.0;
    bool fits = all(greaterThanEqual(way, vec2(0.0))) && all(lessThan(way, vec2(32768.0))) && seen.z > 0.0;
    if (fits) {
        imageStore(motion, p, uvec4(uint(way.x) | uint(way.y) << 15 | (shown ? 0x80000000u : 0u)));
    }
}
