#version 450
// Puts a synthesised texture into one slice of a volume (thesis chapters 7 and 8: textures stacked into a 3D texture).
// In:  a quilt's canvas; with `paint` not 0 a guide, of which the pixels of other paints keep what the slice holds.
//      Its alpha, 0 to 255; without a guide it is 255.
// Out: the slice, where the canvas is painted. Dispatched with `first`, the rest becomes no difference (128).

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32ui) uniform readonly uimage2D canvas;
layout(binding = 1, r32ui) uniform readonly uimage2D guide;
layout(binding = 2, r32ui) uniform readonly uimage2D alpha;
layout(binding = 3, rgba8) uniform writeonly image3D volume;

layout(push_constant) uniform Push {
    uint slice;
    uint paint;
    uint first;
} push;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(canvas)))) {
        return;
    }
    uint texel = imageLoad(canvas, p).r;
    bool ours = texel >> 24 != 0;
    if (push.paint != 0) {
        // Texels beside the model are read by the linear filter at its outline: any paint that is there will do.
        uint owner = imageLoad(guide, p).r >> 16;
        ours = ours && (owner == push.paint || owner == 0);
    }
    if (!ours && push.first == 0) {
        return;
    }
    vec3 rgb = ours ? vec3(texel & 255u, (texel >> 8) & 255u, (texel >> 16) & 255u) : vec3(128.0);
    float a = push.paint != 0 ? float(imageLoad(alpha, p).r) : 255.0;
    imageStore(volume, ivec3(p, push.slice), vec4(rgb, a) / 255.0);
}
