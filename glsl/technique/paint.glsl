// What the real-time techniques share: from shade to colour, and from colour and texture to the frame.

// As in src/technique/colors.rs.
const float COLORS = 2048.0;

// Spreads the range of shade that is in use over the whole strip.
float tone_of(float shade, vec2 range) {
    return range.y > range.x ? clamp((shade - range.x) / (range.y - range.x), 0.0, 1.0) : shade;
}

// The place of a tone in the picture that has a row of colours for each paint.
ivec2 color_place(float tone, uint paint) {
    return ivec2(int(tone * (COLORS - 1.0) + 0.5), int(paint));
}

// The frame's value: 0 colour and texture added and clipped (thesis chapter 6), 1 colour only, 2 texture only, [-1, 1]
// mapped to [0, 1].
vec4 shown(vec3 color, vec3 difference, uint show) {
    vec3 value = show == 1 ? color : show == 2 ? 0.5 + 0.5 * difference : color + difference;
    return vec4(clamp(value, 0.0, 1.0), 1.0);
}

// What a blend of independent textures is multiplied with to keep their contrast: the root of the sum of the squared
// weights is what blending leaves of it (Heitz and Neyret 2018, equation 2).
float contrast_kept(float sum_of_squared_weights) {
    return inversesqrt(sum_of_squared_weights);
}
