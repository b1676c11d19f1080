#version 450
// Lays an effect's picture over a host's image, at the depth that the host has for the same surface.
// In:  the picture, straight alpha; its depth.
// Out: colour with straight alpha, to be blended over; the host's depth. Nothing where the picture is empty.

// The host's image holds light, not stored values: an sRGB format, or a float one.
layout(constant_id = 0) const uint LINEAR = 0;

layout(binding = 0, rgba8) uniform readonly image2D picture;
layout(binding = 1) uniform sampler2D depth;

layout(push_constant) uniform Push {
    // The host's depth is x + y * depth: both are linear in one over the distance along the view axis.
    vec2 to_host;
    // Where the picture's upper left corner lies in the host's image.
    ivec2 at;
} push;

layout(location = 0) out vec4 frame;

// IEC 61966-2-1.
vec3 decoded(vec3 stored) {
    vec3 low = stored / 12.92;
    vec3 high = pow((stored + 0.055) / 1.055, vec3(2.4));
    return mix(high, low, lessThanEqual(stored, vec3(0.04045)));
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy) - push.at;
    vec4 paint = imageLoad(picture, p);
    if (paint.a == 0.0) {
        discard;
    }
    frame = LINEAR != 0 ? vec4(decoded(paint.rgb), paint.a) : paint;
    gl_FragDepth = clamp(push.to_host.x + push.to_host.y * texelFetch(depth, p, 0).r, 0.0, 1.0);
}
