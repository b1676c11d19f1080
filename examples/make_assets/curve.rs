//! Curves, and surfaces drawn along them.

use super::mesh::Mesh;
use glam::DVec3;

/// The value at `t` in 0..1 of the Catmull-Rom spline between `p[1]` and `p[2]`.
fn catmull_rom<const N: usize>(p: [&[f64; N]; 4], t: f64) -> [f64; N] {
    std::array::from_fn(|i| {
        let [a, b, c, d] = p.map(|v| v[i]);
        let (linear, square, cube) = (c - a, 2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * (b - c) + d - a);
        b + 0.5 * t * (linear + t * (square + t * cube))
    })
}

/// Points on a smooth curve through `knots`, `steps` to each span, both ends included.
pub fn spline<const N: usize>(knots: &[[f64; N]], steps: usize) -> Vec<[f64; N]> {
    let at = |i: isize| &knots[i.clamp(0, knots.len() as isize - 1) as usize];
    let mut points = Vec::with_capacity(steps * (knots.len() - 1) + 1);
    for span in 0..knots.len() as isize - 1 {
        let around = [at(span - 1), at(span), at(span + 1), at(span + 2)];
        points.extend((0..steps).map(|s| catmull_rom(around, s as f64 / steps as f64)));
    }
    points.push(knots[knots.len() - 1]);
    points
}

/// `6 * 2^halvings` points (cosine, sine) evenly round the unit circle.
///
/// The angle of one step comes from 60 degrees by the half-angle formulas, and the points from repeated rotation, so
/// that nothing but exactly specified arithmetic is used.
pub fn unit_circle(halvings: u32) -> Vec<(f64, f64)> {
    let (mut cosine, mut sine) = (0.5, 0.75_f64.sqrt());
    for _ in 0..halvings {
        let half = ((1.0 + cosine) * 0.5_f64).sqrt();
        (cosine, sine) = (half, sine / (2.0 * half));
    }
    let turn = |&(x, y): &(f64, f64)| Some((x * cosine - y * sine, x * sine + y * cosine));
    std::iter::successors(Some((1.0, 0.0)), turn).take(6 << halvings).collect()
}

/// A closed surface through rings of equally many points, its ends closed by fans round two poles.
///
/// Seen from `end` towards `start`, the rings must run counter-clockwise; then so do the triangles seen from outside.
pub fn loft(start: DVec3, rings: &[Vec<DVec3>], end: DVec3) -> Mesh {
    let mut mesh = Mesh { positions: vec![start], triangles: Vec::new() };
    let count = rings.first().map_or(0, Vec::len) as u32;
    rings.iter().for_each(|ring| mesh.positions.extend_from_slice(ring));
    mesh.positions.push(end);
    let last = mesh.positions.len() as u32 - 1;
    for k in 0..count {
        let next = (k + 1) % count;
        mesh.triangles.push([0, 1 + next, 1 + k]);
        for ring in 1..rings.len() as u32 {
            let (low, high) = (1 + (ring - 1) * count, 1 + ring * count);
            mesh.triangles.push([low + k, low + next, high + next]);
            mesh.triangles.push([low + k, high + next, high + k]);
        }
        mesh.triangles.push([last, last - count + k, last - count + next]);
    }
    mesh
}

/// A body of revolution round the y axis. `profile` holds `[radius, y]`, from the pole at the bottom to the one at
/// the top, whose radii are taken as 0.
pub fn revolve(profile: &[[f64; 2]], halvings: u32) -> Mesh {
    let circle = unit_circle(halvings);
    let pole = |i: usize| DVec3::new(0.0, profile[i][1], 0.0);
    let ring = |&[radius, y]: &[f64; 2]| circle.iter().map(|&(c, s)| DVec3::new(radius * c, y, -radius * s)).collect();
    let inner = &profile[1..profile.len() - 1];
    loft(pole(0), &inner.iter().map(ring).collect::<Vec<_>>(), pole(profile.len() - 1))
}

/// A tube along a curve in the plane z = 0; each station is `[x, y, half width in the plane, half width along z]`.
/// Where the stations turn back, the tube's inside is drawn.
pub fn sweep(stations: &[[f64; 4]], halvings: u32) -> Mesh {
    let circle = unit_circle(halvings);
    let place = |s: &[f64; 4]| DVec3::new(s[0], s[1], 0.0);
    let last = stations.len() - 1;
    let mut along = (place(&stations[1]) - place(&stations[0])).normalize_or_zero();
    let rings: Vec<Vec<DVec3>> = stations
        .iter()
        .enumerate()
        .map(|(i, station)| {
            // The direction of the curve; stations at one place (a lip) keep the one before.
            let ahead =
                (place(&stations[(i + 1).min(last)]) - place(&stations[i.saturating_sub(1)])).normalize_or_zero();
            // On the way back the sections keep their sense, so that the surface faces inwards by itself.
            along = if ahead == DVec3::ZERO { along } else { ahead * ahead.dot(along).signum() };
            let side = DVec3::Z.cross(along);
            let [_, _, wide, deep] = *station;
            circle.iter().map(|&(c, s)| place(station) + side * (c * wide) + DVec3::Z * (s * deep)).collect()
        })
        .collect();
    loft(place(&stations[0]), &rings, place(&stations[last]))
}
