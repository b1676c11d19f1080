// The host's own scene: boxes on a floor in daylight, and a string of beads. There are no vertex buffers: corners
// follow from the vertex's number, and what is drawn from the instance's.

struct Solid {
    middle: vec4f,
    half: vec4f,
    color: vec4f,
}

struct Frame {
    to_clip: mat4x4f,
    right: vec4f,
    up: vec4f,
    eye: vec4f,
    // Towards the light.
    light: vec4f,
    backdrop: vec4f,
    // The painted object's shape for its shadow: two ellipsoids, as middle and radii.
    casts: array<vec4f, 4>,
    solids: array<Solid, 16>,
    beads: array<vec4f, 48>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec3f,
}

@vertex
fn solid_vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Surface {
    // Two triangles for each of the six faces, counter-clockwise seen from outside.
    let face = corner / 6u;
    let axis = face / 2u;
    let side = select(-1.0, 1.0, face % 2u == 1u);
    let k = corner % 6u;
    let first = select(-1.0, 1.0, k == 1u || k == 2u || k == 4u);
    let second = select(-1.0, 1.0, k == 2u || k == 4u || k == 5u);
    var normal = vec3f(0.0);
    normal[axis] = side;
    var unit = normal;
    unit[(axis + 1u) % 3u] = first * side;
    unit[(axis + 2u) % 3u] = second;
    let solid = frame.solids[number];
    var out: Surface;
    out.position = solid.middle.xyz + unit * solid.half.xyz;
    out.normal = normal;
    out.color = solid.color.rgb;
    out.clip = frame.to_clip * vec4f(out.position, 1.0);
    return out;
}

// 1 where the ray meets the box.
fn box_hit(origin: vec3f, direction: vec3f, solid: Solid) -> f32 {
    let from_middle = origin - solid.middle.xyz;
    let a = (-solid.half.xyz - from_middle) / direction;
    let b = (solid.half.xyz - from_middle) / direction;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), near.z);
    let leave = min(min(far.x, far.y), far.z);
    return select(0.0, 1.0, leave > max(enter, 0.01));
}

// How much light passes the ellipsoid: 0 through it, 1 well beside it.
fn ellipsoid_passes(origin: vec3f, direction: vec3f, middle: vec3f, radii: vec3f) -> f32 {
    let o = (origin - middle) / radii;
    let d = normalize(direction / radii);
    let along = max(-dot(o, d), 0.0);
    return smoothstep(0.82, 1.12, length(o + along * d));
}

fn daylight(position: vec3f, normal: vec3f) -> f32 {
    let light = frame.light.xyz;
    let origin = position + 0.02 * normal;
    var passes = ellipsoid_passes(origin, light, frame.casts[0].xyz, frame.casts[1].xyz)
        * ellipsoid_passes(origin, light, frame.casts[2].xyz, frame.casts[3].xyz);
    for (var i = 0u; i < u32(frame.light.w); i++) {
        passes *= 1.0 - box_hit(origin, light, frame.solids[i]);
    }
    return passes * max(dot(normal, light), 0.0);
}

@fragment
fn solid_fragment(in: Surface) -> @location(0) vec4f {
    let sky = 0.5 + 0.5 * in.normal.y;
    let lit = in.color * (vec3f(0.40, 0.44, 0.52) * (0.55 + 0.45 * sky) + 0.66 * vec3f(1.0, 0.95, 0.84)
        * daylight(in.position, in.normal));
    // The floor runs out into the backdrop.
    let away = smoothstep(70.0, 170.0, length(in.position.xz));
    return vec4f(mix(lit, frame.backdrop.rgb, away), 1.0);
}

struct Bead {
    @builtin(position) clip: vec4f,
    @location(0) place: vec2f,
    @location(1) middle: vec3f,
}

@vertex
fn bead_vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Bead {
    let place = vec2f(select(-1.0, 1.0, corner % 2u == 1u), select(-1.0, 1.0, corner > 1u));
    let bead = frame.beads[number];
    var out: Bead;
    out.place = place;
    out.middle = bead.xyz;
    out.clip = frame.to_clip
        * vec4f(bead.xyz + bead.w * (place.x * frame.right.xyz + place.y * frame.up.xyz), 1.0);
    return out;
}

@fragment
fn bead_fragment(in: Bead) -> @location(0) vec4f {
    let beyond = dot(in.place, in.place);
    if beyond > 1.0 {
        discard;
    }
    let toward = cross(frame.right.xyz, frame.up.xyz);
    let normal = in.place.x * frame.right.xyz + in.place.y * frame.up.xyz + sqrt(1.0 - beyond) * toward;
    let diffuse = 0.5 + 0.5 * dot(normal, frame.light.xyz);
    let half = normalize(frame.light.xyz + normalize(frame.eye.xyz - in.middle));
    let shine = pow(max(dot(normal, half), 0.0), 40.0);
    return vec4f(vec3f(0.93, 0.36, 0.16) * diffuse * diffuse + vec3f(0.8 * shine), 1.0);
}
