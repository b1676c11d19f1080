#version 450
// View-dependent interpolation: how far inside a slice's faces each texel lies, so that a slice fades out towards faces
// that it does not show instead of ending at a seam.
// In:  rows first: the slice's guide, 0 where none of its faces is. Then columns: what the rows gave.
// Out: rows: the distance along the row to the next texel without a face, `radius` at most. Columns: the square of the
//      distance to it, as a part of the radius's square, 0 to 255. All in integers, so the same everywhere.

layout(local_size_x = 16, local_size_y = 8) in;

layout(binding = 0, r32ui) uniform readonly uimage2D source;
layout(binding = 1, r32ui) uniform writeonly uimage2D result;

layout(push_constant) uniform Push {
    uint columns;
    int radius;
} push;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(source);
    if (any(greaterThanEqual(p, size))) {
        return;
    }
    bool columns = push.columns != 0;
    ivec2 along = columns ? ivec2(0, 1) : ivec2(1, 0);
    int square = push.radius * push.radius;
    int nearest = columns ? square : push.radius;
    for (int d = -push.radius; d <= push.radius; d++) {
        ivec2 q = p + d * along;
        bool inside = all(greaterThanEqual(q, ivec2(0))) && all(lessThan(q, size));
        int value = inside ? int(imageLoad(source, q).r) : 0;
        if (columns) {
            nearest = min(nearest, value * value + d * d);
        } else if (value == 0) {
            nearest = min(nearest, abs(d));
        }
    }
    imageStore(result, p, uvec4(columns ? nearest * 255 / square : nearest));
}
