#version 450
// Object-based texture mapping (thesis chapter 5): s is the shade, t the vertices' own coordinate.
//
// Where the surface is flat, or lit along the direction of t, the place on the strip hardly changes over the surface:
// one texel spreads over all of it and the paint is lost (figures 5.2 and 5.3). With KEEP_PAINT such places take
// their texture from the plane of two world axes that they lie flattest on instead, from the part of the strip around
// their shade.
// In:  the strip's texture difference, which repeats along t; the paints' colours.  Out: frame.
#extension GL_GOOGLE_include_directive : require
#include "../scene/shade.glsl"
#include "paint.glsl"

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) in float vertex_t;

layout(binding = 0) uniform sampler2D strip;
layout(binding = 1, r32ui) uniform readonly uimage2D colors;

layout(push_constant) uniform Push {
    mat4 view_projection;
    vec4 light;
    vec2 range;
    // Repeats of the strip to a unit of the world.
    float density;
    uint paint;
    uint show;
} push;

layout(location = 0) out vec4 frame;

// Whether to keep the paint where the mapping loses it; set when the pipeline is made.
layout(constant_id = 0) const uint KEEP_PAINT = 1;

// How far to each side of its shade a flat place takes texture from, as a part of the strip.
const float WINDOW = 0.0625;
// Texels of the strip over the surface, as a part of what the density asks for: less is lost, more is kept as it is.
const float LOST = 0.01;
const float KEPT = 0.1;

// The texture at a place on a plane, in repeats; to and fro across the window around the shade.
vec3 on_plane(vec2 place, float tone, vec2 size) {
    float across = place.x * size.y / (size.x * 4.0 * WINDOW);
    float to_and_fro = abs(4.0 * fract(across) - 2.0) - 1.0;
    float center = clamp(tone, WINDOW, 1.0 - WINDOW);
    return 2.0 * textureLod(strip, vec2(center + WINDOW * to_and_fro, place.y), 0.0).rgb - 1.0;
}

void main() {
    float tone = tone_of(shade_of(world_normal, push.light.xyz, gl_FrontFacing), push.range);
    vec2 size = vec2(textureSize(strip, 0));
    vec2 st = vec2((tone * (size.x - 1.0) + 0.5) / size.x, vertex_t);
    vec3 difference = 2.0 * textureLod(strip, st, 0.0).rgb - 1.0;
    if (KEEP_PAINT != 0) {
        vec2 st_x = dFdx(st) * size;
        vec2 st_y = dFdy(st) * size;
        vec3 face = cross(dFdx(world_position), dFdy(world_position));
        float texels = abs(st_x.x * st_y.y - st_x.y * st_y.x);
        float side = push.density * size.y;
        float wanted = length(face) * side * side;
        float lost = wanted > 0.0 ? 1.0 - smoothstep(LOST, KEPT, texels / wanted) : 0.0;
        // The plane that the face lies flattest on; blending all three would cost two more samples for every pixel.
        vec3 flat_on = abs(face);
        vec3 place = world_position * push.density;
        vec2 on = flat_on.y >= max(flat_on.x, flat_on.z) ? place.xz : flat_on.x >= flat_on.z ? place.zy : place.xy;
        vec3 plane = on_plane(on, tone, size);
        difference = mix(difference, plane, lost) * contrast_kept(lost * lost + (1.0 - lost) * (1.0 - lost));
    }
    frame = shown(unpackUnorm4x8(imageLoad(colors, color_place(tone, push.paint)).r).rgb, difference, push.show);
}
