#version 450
// Image-based technique: the shade that is painted, and the guide of the synthesis (thesis chapter 6).
//
// In:  shade and object ID of the guide pass, the paint of each object; the range of shade that becomes 0 to 1.
// Out: tone, the shade in use; guide, shade in 8 bits in the low byte and the paint's number (from 1) in the high half.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32f) uniform readonly image2D shade;
layout(binding = 1, r32ui) uniform readonly uimage2D id;
layout(binding = 2, r32ui) uniform readonly uimage2D paint_of_object;
layout(binding = 3, r32f) uniform writeonly image2D tone;
layout(binding = 4, r32ui) uniform writeonly uimage2D guide;

layout(push_constant) uniform Push {
    // The shades that become 0 and 1.
    float low, high;
} push;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(shade)))) {
        return;
    }
    uint object = imageLoad(id, p).r;
    if (object == 0) {
        imageStore(tone, p, vec4(0.0));
        imageStore(guide, p, uvec4(0));
        return;
    }
    float s = imageLoad(shade, p).r;
    // A flat model has no range to spread.
    if (push.high > push.low) {
        s = (s - push.low) / (push.high - push.low);
    }
    s = clamp(s, 0.0, 1.0);
    // Not to be fused into one operation, so that every device rounds alike.
    precise float scaled = s * 255.0;
    precise float rounded = scaled + 0.5;
    imageStore(tone, p, vec4(s));
    imageStore(guide, p, uvec4(uint(rounded) | ((imageLoad(paint_of_object, ivec2((object - 1) & 1023u, (object - 1) >> 10)).r + 1) << 16)));
}
