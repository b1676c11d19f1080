// The host's last pass: reads the finished frame, twice as large as the picture, and makes the picture of it. Each
// pixel is the mean of four, and the corners darken a little.

@group(0) @binding(0) var frame: texture_2d<f32>;

@vertex
fn corners(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, corner == 1u), select(-1.0, 3.0, corner == 2u), 0.0, 1.0);
}

@fragment
fn develop(@builtin(position) place: vec4f) -> @location(0) vec4f {
    let at = 2 * vec2i(place.xy);
    let sum = textureLoad(frame, at, 0) + textureLoad(frame, at + vec2i(1, 0), 0)
        + textureLoad(frame, at + vec2i(0, 1), 0) + textureLoad(frame, at + vec2i(1, 1), 0);
    let from_middle = place.xy / (0.5 * vec2f(textureDimensions(frame))) - 0.5;
    let darker = 1.0 - 0.3 * dot(from_middle, from_middle);
    return vec4f(0.25 * darker * sum.rgb, 1.0);
}
