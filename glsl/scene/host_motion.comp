#version 450
// A host's own motion vectors as words of motion, and whether the previous frame showed the surface (thesis 9.3).
// In:  the host's vectors (the first two channels); ID and depth now and then.
// Out: words as those of motion.comp: two times 15 bits, x low, each 16,384 + 64 times the pixels of the way to the
//      place then, and the highest bit where that frame showed it: the same object, at nearly the same distance along
//      the view axis. Where nothing is now, or the way is longer or no number, the 0 that the image was cleared to
//      stays.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32ui) uniform readonly uimage2D id_now;
layout(binding = 1) uniform sampler2D depth_now;
layout(binding = 2) uniform sampler2D vectors;
layout(binding = 3, r32ui) uniform readonly uimage2D id_then;
layout(binding = 4) uniform sampler2D depth_then;
layout(binding = 5, r32ui) uniform writeonly uimage2D motion;

layout(push_constant) uniform Push {
    // What a vector is multiplied by to be pixels of the way to the place then.
    vec2 scale;
    // 1 / the distances of the near and the far plane, now and then.
    vec2 nearness_now;
    vec2 nearness_then;
    // How far apart two distances may be to be the same, by the distance now.
    float same;
} push;

// 1 / the distance along the view axis, which is linear in depth. Where depths crowd just below 1, 1 - depth is exact.
float nearness(vec2 planes, float depth) {
    return planes.x * (1.0 - depth) + planes.y * depth;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(id_now);
    if (any(greaterThanEqual(p, size))) {
        return;
    }
    uint id = imageLoad(id_now, p).r;
    if (id == 0u) {
        return;
    }
    vec2 pixels = push.scale * texelFetch(vectors, p, 0).xy;
    vec2 nearest = floor(vec2(p) + pixels + 0.5);
    bool inside = all(greaterThanEqual(nearest, vec2(0.0))) && all(lessThan(nearest, vec2(size)));
    ivec2 q = inside ? ivec2(nearest) : p;
    float now = nearness(push.nearness_now, texelFetch(depth_now, p, 0).r);
    float then = nearness(push.nearness_then, texelFetch(depth_then, q, 0).r);
    // |1 / then - 1 / now| <= same / now
    bool shown = inside && imageLoad(id_then, q).r == id && abs(now - then) <= push.same * then;
    vec2 way = floor(64.0 * pixels + 0.5) + 16384.0;
    if (all(greaterThanEqual(way, vec2(0.0))) && all(lessThan(way, vec2(32768.0)))) {
        imageStore(motion, p, uvec4(uint(way.x) | uint(way.y) << 15 | (shown ? 0x80000000u : 0u)));
    }
}
