//! Signed distance fields: the parts that the head is modelled from.
//!
//! A field is a function from a point to its distance from a surface, negative inside. Shapes are joined by taking
//! the smaller of two distances and carved by taking the larger; the smooth forms round the joint off over a width
//! `k`, which is what makes separate ellipsoids and tubes read as one grown bone. (The polynomial smooth minimum is
//! well known; see I. Quilez, "Smooth minimum".) After smoothing the values are no longer exact distances, only
//! close to them near the surface, and that is all the polygoniser asks for.
//!
//! Only `+ - * /` and the square root are used, whose results IEEE 754 fixes to the last bit, so that the models
//! come out the same everywhere.

use super::curve::spline;
use glam::{DMat3, DVec2, DVec3};

/// The union of two fields, the joint filled over the width `k`.
pub fn union(a: f64, b: f64, k: f64) -> f64 {
    let h = ((k - (a - b).abs()) / k).max(0.0);
    a.min(b) - h * h * k * 0.25
}

/// Field `a` with field `b` carved out, the rim rounded over the width `k`.
pub fn carve(a: f64, b: f64, k: f64) -> f64 {
    -union(-a, b, k)
}

/// A rotation whose third axis is `forward` and whose second lies as near to y as it can.
pub fn facing(forward: DVec3) -> DMat3 {
    let z = forward.normalize();
    let x = DVec3::Y.cross(z).normalize();
    DMat3::from_cols(x, z.cross(x), z)
}

/// An ellipsoid, its axes along x, y, z.
pub fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    ellipsoid_at(p - centre, radii)
}

/// An ellipsoid turned so that its third axis points along `forward`.
pub fn ellipsoid_facing(p: DVec3, centre: DVec3, forward: DVec3, radii: DVec3) -> f64 {
    ellipsoid_at(facing(forward).transpose() * (p - centre), radii)
}

/// First-order distance: the implicit value |q/r| - 1 over the length of its gradient.
fn ellipsoid_at(q: DVec3, radii: DVec3) -> f64 {
    let value = (q / radii).length();
    let slope = (q / (radii * radii)).length();
    if slope < 1e-12 {
        return -radii.min_element();
    }
    value * (value - 1.0) / slope
}

/// A capsule from `a` to `b` whose radius goes from `ra` to `rb`.
pub fn capsule(p: DVec3, a: DVec3, b: DVec3, ra: f64, rb: f64) -> f64 {
    let (ap, ab) = (p - a, b - a);
    let t = (ap.dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
    (ap - ab * t).length() - (ra + (rb - ra) * t)
}

/// A box of half extents `half` whose edges are rounded by `round` (the rounding stays within the box).
pub fn rounded_box(q: DVec3, half: DVec3, round: f64) -> f64 {
    let d = q.abs() - half + DVec3::splat(round);
    d.max(DVec3::ZERO).length() + d.max_element().min(0.0) - round
}

/// The signed distance to a closed polygon in the plane.
pub fn polygon(p: DVec2, corners: &[DVec2]) -> f64 {
    let mut nearest = f64::INFINITY;
    let mut inside = false;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (ap, ab) = (p - a, b - a);
        let t = (ap.dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min((ap - ab * t).length_squared());
        // Even-odd rule: each edge that a ray towards +x crosses turns inside to outside.
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + ab.x * (p.y - a.y) / ab.y {
            inside = !inside;
        }
    }
    if inside {
        -nearest.sqrt()
    } else {
        nearest.sqrt()
    }
}

/// A bent bar of changing radius, taller than thick where `flatten` is above 1.
pub struct Tube {
    /// Centre and radius, with y already divided by `flatten`.
    points: Vec<(DVec3, f64)>,
    flatten: f64,
    middle: DVec3,
    reach: f64,
}

impl Tube {
    /// A tube along a smooth curve through knots `[x, y, z, radius]`; its cross-section is `flatten` times as tall.
    pub fn new(knots: &[[f64; 4]], flatten: f64) -> Self {
        let points: Vec<(DVec3, f64)> =
            spline(knots, 4).into_iter().map(|[x, y, z, radius]| (DVec3::new(x, y / flatten, z), radius)).collect();
        let middle = points.iter().map(|p| p.0).sum::<DVec3>() / points.len() as f64;
        let reach = points.iter().map(|p| p.0.distance(middle) + p.1).fold(0.0, f64::max);
        Self { points, flatten, middle, reach }
    }

    /// The signed distance (a lower bound of it far away, where only "far" matters).
    pub fn distance(&self, p: DVec3) -> f64 {
        let q = DVec3::new(p.x, p.y / self.flatten, p.z);
        let bound = q.distance(self.middle) - self.reach;
        if bound > 3.0 {
            return bound;
        }
        let legs = self.points.windows(2);
        legs.map(|leg| capsule(q, leg[0].0, leg[1].0, leg[0].1, leg[1].1)).fold(f64::INFINITY, f64::min)
    }
}

/// A standing wall along a curve in the plan (x, z): the form of a jaw.
pub struct Wall {
    /// `[x, z, middle height, half height, half thickness]`.
    points: Vec<[f64; 5]>,
}

impl Wall {
    /// A wall along a smooth curve through knots `[x, z, middle height, half height, half thickness]`.
    pub fn new(knots: &[[f64; 5]]) -> Self {
        Self { points: spline(knots, 5) }
    }

    /// The signed distance.
    pub fn distance(&self, p: DVec3) -> f64 {
        let mut best = (f64::INFINITY, [0.0; 5]);
        for leg in self.points.windows(2) {
            let (a, b) = (leg[0], leg[1]);
            let (ap, ab) = (DVec2::new(p.x - a[0], p.z - a[1]), DVec2::new(b[0] - a[0], b[1] - a[1]));
            let t = (ap.dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
            let away = (ap - ab * t).length();
            if away < best.0 {
                best = (away, std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t));
            }
        }
        let (away, [_, _, middle, half_height, half_thickness]) = best;
        let round = half_thickness * 0.9;
        let d = DVec2::new(away - half_thickness, (p.y - middle).abs() - half_height) + DVec2::splat(round);
        d.max(DVec2::ZERO).length() + d.max_element().min(0.0) - round
    }
}
