// What both ways of drawing an image-based frame share: colour by shade from the trajectory, plus the texture difference,
// clipped (thesis chapter 6, figure 6.1).

vec4 recombined(vec3 color, vec3 texture_difference, uint show) {
    vec3 shown = color + texture_difference;
    if (show == 1) {
        shown = color;
    } else if (show == 2) {
        shown = 0.5 + 0.5 * texture_difference;
    }
    return vec4(clamp(shown, 0.0, 1.0), 1.0);
}
