//! A round-bellied teapot on a table of two triangles.
//!
//! The pot stands on the plane y = 0, its spout towards +x. Body and lid are bodies of revolution, handle and spout
//! are tubes drawn along curves; each of the four is closed by itself and they reach into one another. The table is
//! as coarse as a table can be: one flat shade and two triangles are a hard case for painting, and meant to be one.

use super::curve::{revolve, spline, sweep};
use super::mesh::Mesh;
use glam::DVec3;

/// Outline of the body, `[radius, y]`: the hollow of the foot, its ring, belly, shoulder, rim, and the flat inside.
const BODY: [[f64; 2]; 18] = [
    [0.0, 0.10],
    [0.85, 0.09],
    [1.00, 0.02],
    [1.09, 0.0],
    [1.17, 0.03],
    [1.20, 0.14],
    [1.55, 0.36],
    [1.92, 0.80],
    [2.06, 1.30],
    [1.98, 1.78],
    [1.70, 2.20],
    [1.36, 2.46],
    [1.20, 2.56],
    [1.18, 2.66],
    [1.13, 2.71],
    [1.07, 2.67],
    [1.04, 2.58],
    [0.0, 2.58],
];

/// Outline of the lid, `[radius, y]`: its rounded edge, the dome, the neck and the knob.
const LID: [[f64; 2]; 13] = [
    [0.0, 2.64],
    [0.95, 2.64],
    [1.02, 2.69],
    [1.01, 2.75],
    [0.90, 2.82],
    [0.62, 2.94],
    [0.30, 3.02],
    [0.15, 3.09],
    [0.15, 3.17],
    [0.28, 3.27],
    [0.31, 3.40],
    [0.20, 3.52],
    [0.0, 3.56],
];

/// Course of the handle, from the shoulder round to the belly: `[x, y, half width in the plane, half width along z]`.
const HANDLE: [[f64; 4]; 9] = [
    [-1.40, 2.18, 0.17, 0.28],
    [-1.85, 2.30, 0.15, 0.26],
    [-2.40, 2.42, 0.12, 0.21],
    [-2.92, 2.28, 0.12, 0.20],
    [-3.18, 1.82, 0.12, 0.20],
    [-3.06, 1.30, 0.12, 0.20],
    [-2.66, 0.92, 0.12, 0.20],
    [-2.15, 0.72, 0.14, 0.23],
    [-1.60, 0.72, 0.16, 0.26],
];

/// Course of the spout's outside, from within the belly to the lip, as for the handle.
const SPOUT: [[f64; 4]; 7] = [
    [1.20, 0.84, 0.58, 0.60],
    [1.80, 0.94, 0.51, 0.50],
    [2.32, 1.16, 0.40, 0.40],
    [2.68, 1.62, 0.29, 0.31],
    [2.92, 2.10, 0.225, 0.25],
    [3.16, 2.50, 0.195, 0.22],
    [3.50, 2.78, 0.20, 0.21],
];

/// The lip, and the spout's inside a little way down.
const SPOUT_INSIDE: [[f64; 4]; 4] =
    [[3.515, 2.79, 0.175, 0.185], [3.49, 2.77, 0.15, 0.16], [3.16, 2.50, 0.14, 0.16], [2.94, 2.14, 0.14, 0.16]];

/// The pot: body, lid, handle and spout.
pub fn pot() -> Mesh {
    let mut pot = revolve(&spline(&BODY, 2), 3);
    pot.append(&revolve(&spline(&LID, 2), 3));
    pot.append(&sweep(&spline(&HANDLE, 3), 2));
    let mut spout = spline(&SPOUT, 3);
    spout.extend(SPOUT_INSIDE);
    pot.append(&sweep(&spout, 2));
    pot
}

/// The table top: one rectangle of two triangles.
pub fn table() -> Mesh {
    let corner = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    Mesh {
        positions: vec![corner(-5.6, 4.4), corner(5.6, 4.4), corner(5.6, -4.4), corner(-5.6, -4.4)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}
