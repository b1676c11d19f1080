// Shade s = (1 + N.L) / 2 (thesis equation 3.1). `light` is the weighted mean of the lights' unit vectors, which the
// equation is linear in. A face seen from behind is lit as if it were turned round, so that open models show paint
// inside too.
float shade_of(vec3 world_normal, vec3 light, bool front) {
    // Normals of a face may cancel between its corners; nothing faces the light there.
    float squared = dot(world_normal, world_normal);
    vec3 n = squared > 0.0 ? world_normal * inversesqrt(squared) : vec3(0.0);
    float facing = front ? 1.0 : -1.0;
    return clamp(0.5 + 0.5 * facing * dot(n, light), 0.0, 1.0);
}
