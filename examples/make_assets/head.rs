//! The skull-like head, as a signed distance field.
//!
//! Lengths are centimetres of a common adult skull. The origin lies midway between the ear openings, x is to the
//! skull's left, y up and z to the front; the form is symmetric, so that only x >= 0 is described. The measures
//! (breadth 14, length 18, face height 12, orbits 4 by 3.4 ...) are those of ordinary craniometry.

use super::field::{capsule, carve, ellipsoid, ellipsoid_facing, facing, polygon, rounded_box, union, Tube, Wall};
use super::mesh::Mesh;
use super::{decimate, surface_nets};
use glam::{DMat3, DVec2, DVec3};

/// Number of triangles of the finished head, at most.
pub const TRIANGLES: usize = 19_600;

/// Side length of the polygoniser's grid cells.
const CELL: f64 = 0.17;

/// Builds the finished mesh, its lowest point at y = 0.
pub fn mesh() -> Mesh {
    let head = Head::new();
    let field = |p: DVec3| head.distance(p);
    let fine = surface_nets::polygonise(&field, DVec3::new(-8.4, -10.6, -10.2), DVec3::new(8.4, 13.0, 11.6), CELL);
    let mut mesh = decimate::decimate(&fine.largest_piece(), TRIANGLES, &detail);
    surface_nets::project(&mut mesh, &field, CELL);
    let lift = DVec3::new(0.0, -mesh.bounds().0.y, 0.0);
    mesh.positions.iter_mut().for_each(|p| *p += lift);
    mesh
}

/// How much more an error counts at a place: the teeth are small, but much looked at.
fn detail(p: DVec3) -> f64 {
    let from_teeth = ellipsoid(p, v(0.0, -5.3, 7.5), v(3.8, 1.2, 3.2));
    let from_face = ellipsoid(p, v(0.0, -1.0, 7.5), v(5.0, 5.0, 3.0));
    1.0 + 2.0 * (1.0 - from_face).clamp(0.0, 1.0) + 9.0 * (1.0 - from_teeth * 2.0).clamp(0.0, 1.0)
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// One tooth: a rounded box on the dental arch.
struct Tooth {
    centre: DVec3,
    /// Columns: along the arch, up, outwards.
    axes: DMat3,
    half: DVec3,
}

/// The field and its precomputed parts.
struct Head {
    orbit_rim: Tube,
    brow: Tube,
    zygomatic_arch: Tube,
    cheek_buttress: Tube,
    temporal_line: Tube,
    nuchal_line: Tube,
    upper_wall: Wall,
    lower_wall: Wall,
    teeth: Vec<Tooth>,
    ramus: [DVec2; 16],
}

impl Head {
    /// Places all parts.
    fn new() -> Self {
        let mut teeth = dental_arch(&UPPER_TEETH);
        teeth.extend(dental_arch(&LOWER_TEETH));
        Self {
            orbit_rim: Tube::new(&ORBIT_RIM, 1.0),
            brow: Tube::new(&BROW, 1.0),
            zygomatic_arch: Tube::new(&ZYGOMATIC_ARCH, 1.7),
            cheek_buttress: Tube::new(&CHEEK_BUTTRESS, 1.0),
            temporal_line: Tube::new(&TEMPORAL_LINE, 1.0),
            nuchal_line: Tube::new(&NUCHAL_LINE, 1.0),
            upper_wall: Wall::new(&UPPER_WALL),
            lower_wall: Wall::new(&LOWER_WALL),
            teeth,
            ramus: RAMUS.map(|[z, y]| DVec2::new(z, y)),
        }
    }

    /// The signed distance from the head's surface.
    fn distance(&self, p: DVec3) -> f64 {
        let p = v(p.x.abs(), p.y, p.z);
        let mut d = self.braincase(p);
        d = union(d, self.midface(p), 0.9);
        d = union(d, self.upper_wall.distance(p), 1.0);
        d = carve_openings(d, p);
        d = union(d, self.zygomatic_arch.distance(p), 0.5);
        d = union(d, upper_jaw(p), 0.3);
        d = self.with_teeth(d, p, true);
        union(d, self.mandible(p), 0.12)
    }

    fn braincase(&self, p: DVec3) -> f64 {
        let mut d = ellipsoid(p, v(0.0, 4.7, -0.9), v(6.5, 7.0, 8.0));
        d = union(d, ellipsoid(p, v(0.0, 5.0, 2.8), v(5.3, 6.0, 6.2)), 2.0);
        d = union(d, ellipsoid(p, v(2.4, 5.2, -2.8), v(4.5, 4.8, 4.8)), 2.5);
        d = union(d, ellipsoid(p, v(0.0, 2.6, -4.2), v(5.2, 4.6, 5.0)), 2.0);
        d = union(d, ellipsoid(p, v(0.0, -0.2, -3.6), v(4.8, 3.0, 4.5)), 2.2);
        // Base of the skull, and the temporal bone by the ear.
        d = union(d, capsule(p, v(0.0, -0.2, -1.0), v(0.0, 0.2, 4.5), 2.2, 2.0), 1.5);
        d = union(d, ellipsoid(p, v(4.6, 0.6, 0.2), v(1.7, 1.6, 2.6)), 1.2);
        d = union(d, capsule(p, v(5.3, -0.2, -1.3), v(4.9, -2.6, -0.7), 1.15, 0.7), 0.9);
        d = union(d, self.nuchal_line.distance(p), 1.4);
        // Temples.
        d = carve(d, ellipsoid_facing(p, v(7.4, 1.5, 4.6), v(0.40, 0.1, 1.0), v(2.1, 3.3, 3.3)), 1.8);
        d = union(d, self.temporal_line.distance(p), 1.2);
        // Foramen magnum and the ear opening.
        d = carve(d, ellipsoid(p, v(0.0, -3.0, -2.2), v(1.4, 1.6, 1.7)), 0.5);
        carve(d, capsule(p, v(7.2, -0.35, 0.1), v(5.2, -0.35, 0.2), 0.34, 0.28), 0.3)
    }

    fn midface(&self, p: DVec3) -> f64 {
        let mut d = ellipsoid(p, v(0.0, 0.4, 5.4), v(4.2, 3.8, 3.2));
        d = union(d, ellipsoid(p, v(0.0, -1.6, 6.2), v(2.9, 2.6, 2.7)), 1.0);
        // Outer wall of the eye socket.
        d = union(d, capsule(p, v(4.6, 1.1, 6.3), v(3.4, 1.2, 3.8), 0.85, 1.3), 0.6);
        d = union(d, self.orbit_rim.distance(p), 0.7);
        d = union(d, self.brow.distance(p), 0.9);
        d = union(d, self.cheek_buttress.distance(p), 0.9);
        d = union(d, ellipsoid_facing(p, v(4.5, -0.85, 6.8), v(0.75, 0.0, 1.0), v(1.5, 1.35, 0.8)), 0.9);
        // Canine fossa: the hollow beside the nose.
        d = carve(d, ellipsoid_facing(p, v(2.9, -2.0, 9.0), v(0.45, 0.1, 1.0), v(1.0, 1.1, 1.0)), 1.0);
        // Nasal bones: a roof from between the brows down to the opening, and the opening's sides.
        d = union(d, capsule(p, v(0.0, 3.0, 8.5), v(0.0, 0.95, 9.75), 0.55, 0.40), 0.5);
        d = union(d, capsule(p, v(0.35, 2.6, 8.5), v(0.75, 0.8, 9.0), 0.50, 0.45), 0.7);
        union(d, capsule(p, v(0.75, 1.4, 8.6), v(1.40, -1.4, 8.75), 0.5, 0.5), 0.6)
    }

    fn mandible(&self, p: DVec3) -> f64 {
        let mut d = self.lower_wall.distance(p);
        d = union(d, ellipsoid(p, v(0.0, -8.6, 8.9), v(1.1, 0.9, 0.65)), 0.8);
        d = union(d, ellipsoid(p, v(1.3, -8.9, 8.5), v(0.8, 0.5, 0.6)), 0.7);
        // Ramus: a plate that leans outwards towards the top and the back.
        let lean = 4.95 + 0.05 * (p.y + 6.0) - 0.16 * (p.z - 2.2);
        let plate = polygon(DVec2::new(p.z, p.y), &self.ramus);
        let across = (p.x - lean).abs() - 0.42;
        let edge = DVec2::new(plate, across) + DVec2::splat(0.38);
        let ramus = edge.max(DVec2::ZERO).length() + edge.max_element().min(0.0) - 0.38;
        d = union(d, ramus, 0.9);
        d = union(d, ellipsoid(p, v(5.3, -0.75, 1.2), v(0.95, 0.5, 0.55)), 0.4);
        self.with_teeth(d, p, false)
    }

    /// One row of teeth joined to the jaw `d`: the swellings over the roots run softly into it, the crowns stand out.
    fn with_teeth(&self, mut d: f64, p: DVec3, upper: bool) -> f64 {
        let half = self.teeth.len() / 2;
        let row = if upper { &self.teeth[..half] } else { &self.teeth[half..] };
        let (to_root, root_end) = if upper { (1.0, v(0.0, 2.0, -0.05)) } else { (-1.0, v(0.0, -1.7, -0.10)) };
        let mut crowns = f64::INFINITY;
        for tooth in row {
            let q = tooth.axes.transpose() * (p - tooth.centre);
            if q.length_squared() > 9.0 {
                crowns = crowns.min(q.length() - 1.0);
                continue;
            }
            // Crowns narrow towards the neck.
            let narrow = 1.0 + 0.10 * (to_root * q.y / tooth.half.y).clamp(-1.0, 1.0);
            crowns = crowns.min(rounded_box(v(q.x * narrow, q.y, q.z), tooth.half, 0.26));
            d = union(d, capsule(q, DVec3::ZERO, root_end, 0.27, 0.16), 0.3);
        }
        union(d, crowns, 0.1)
    }
}

/// The palate with the plates behind it, and the nasal spine.
fn upper_jaw(p: DVec3) -> f64 {
    let mut d = ellipsoid(p, v(0.0, -2.6, 5.6), v(3.0, 0.8, 3.2));
    d = union(d, capsule(p, v(1.5, -1.0, 3.2), v(1.7, -3.8, 3.4), 0.6, 0.4), 0.6);
    union(d, capsule(p, v(0.0, -2.5, 8.8), v(0.0, -2.3, 9.55), 0.40, 0.20), 0.4)
}

/// Eye socket and nose.
fn carve_openings(d: f64, p: DVec3) -> f64 {
    let d = carve(d, orbit(p), 0.3);
    let depth = (p.z - 7.6).abs() - 3.4;
    let across = polygon(DVec2::new(p.x, p.y), &NOSE.map(|[x, y]| DVec2::new(x, y)));
    carve(d, depth.max(across), 0.3)
}

/// The eye socket: a deep bowl with a rounded-square opening that looks a little outwards.
fn orbit(p: DVec3) -> f64 {
    let axes = facing(v(0.36, -0.06, 1.0));
    let q = axes.transpose() * (p - v(3.2, 1.65, 7.4));
    // The upper edge runs down towards the temple.
    let (x, y) = (q.x, q.y + 0.18 * q.x);
    let flare = 1.0 + 0.06 * q.z.max(0.0);
    let (a, b) = (x / (1.95 * flare), y / (1.62 * flare));
    let (a2, b2, c) = (a * a, b * b, q.z.min(0.0) / 4.4);
    let square = (a2 * a2 + b2 * b2).sqrt();
    (((a2 + b2) * 0.45 + square * 0.55 + c * c).sqrt() - 1.0) * 1.6
}

/// The measures of one row of teeth.
struct ToothRow {
    /// Widths of one half, from the middle outwards.
    widths: [f64; 7],
    /// The row follows the parabola z = `front` - `bend` x^2 ...
    front: f64,
    bend: f64,
    /// ... with the middle of the crowns at this height.
    height: f64,
    /// How far the crowns lean outwards.
    flare: f64,
}

fn dental_arch(row: &ToothRow) -> Vec<Tooth> {
    let slope = |x: f64| -2.0 * row.bend * x;
    let (mut x, mut walked, mut start) = (0.0, 0.0, 0.0);
    let mut teeth = Vec::new();
    for (i, &width) in row.widths.iter().enumerate() {
        // Walk along the parabola to the tooth's middle.
        while walked < start + width * 0.5 {
            x += 0.01 / (1.0 + slope(x) * slope(x)).sqrt();
            walked += 0.01;
        }
        start += width;
        let along = v(1.0, 0.0, slope(x)).normalize();
        let outwards = v(-along.z, 0.0, along.x);
        let up = (DVec3::Y + outwards * row.flare).normalize();
        let half_height = [0.62, 0.57, 0.66, 0.58, 0.58, 0.58, 0.55][i];
        let half_depth = if i < 3 { 0.36 } else { 0.50 };
        teeth.push(Tooth {
            centre: v(x, row.height, row.front - row.bend * x * x),
            axes: DMat3::from_cols(along, up, along.cross(up)),
            half: v(width * 0.5 + 0.02, half_height, half_depth),
        });
    }
    teeth
}

const UPPER_TEETH: ToothRow =
    ToothRow { widths: [0.92, 0.72, 0.82, 0.74, 0.72, 1.0, 0.95], front: 9.2, bend: 0.48, height: -4.75, flare: -0.10 };
const LOWER_TEETH: ToothRow =
    ToothRow { widths: [0.62, 0.66, 0.76, 0.76, 0.76, 1.05, 1.0], front: 8.85, bend: 0.47, height: -5.90, flare: 0.06 };

/// Outline of the ramus seen from the side, `[z, y]`: from the jaw's angle forwards, up to the coronoid process,
/// through the notch to the condyle and down the back.
const RAMUS: [[f64; 2]; 16] = [
    [2.0, -6.9],
    [4.4, -7.8],
    [5.0, -6.4],
    [4.6, -4.4],
    [4.5, -2.4],
    [4.25, -0.9],
    [3.75, -0.65],
    [3.2, -1.6],
    [2.5, -2.05],
    [1.95, -1.4],
    [1.7, -0.6],
    [1.1, -0.55],
    [0.75, -1.3],
    [0.95, -3.6],
    [0.9, -5.4],
    [1.2, -6.3],
];

/// Outline of the nasal opening, `[x, y]`.
const NOSE: [[f64; 2]; 14] = [
    [0.0, 0.95],
    [0.38, 0.78],
    [0.70, 0.1],
    [1.0, -0.8],
    [1.22, -1.6],
    [1.12, -2.15],
    [0.6, -2.45],
    [0.0, -2.25],
    [-0.6, -2.45],
    [-1.12, -2.15],
    [-1.22, -1.6],
    [-1.0, -0.8],
    [-0.70, 0.1],
    [-0.38, 0.78],
];

// Tubes: [x, y, z, radius].
const ORBIT_RIM: [[f64; 4]; 11] = [
    [1.25, 1.9, 8.5, 0.42],
    [1.65, 3.05, 8.5, 0.60],
    [2.8, 3.68, 8.4, 0.62],
    [4.2, 3.5, 7.8, 0.60],
    [5.1, 2.5, 6.9, 0.60],
    [5.1, 1.2, 6.35, 0.55],
    [4.85, 0.2, 6.6, 0.55],
    [3.9, -0.5, 7.3, 0.50],
    [2.6, -0.45, 8.0, 0.42],
    [1.65, 0.25, 8.4, 0.38],
    [1.3, 1.2, 8.5, 0.38],
];
const BROW: [[f64; 4]; 4] =
    [[0.0, 3.6, 8.75, 0.55], [1.2, 3.8, 8.8, 0.60], [2.6, 4.2, 8.45, 0.50], [3.8, 4.2, 7.8, 0.40]];
const ZYGOMATIC_ARCH: [[f64; 4]; 6] = [
    [4.75, -0.75, 6.4, 0.75],
    [5.75, -0.85, 5.4, 0.60],
    [6.4, -0.65, 4.0, 0.42],
    [6.65, -0.40, 2.6, 0.40],
    [6.45, -0.1, 1.2, 0.45],
    [6.0, 0.15, -0.2, 0.50],
];
const CHEEK_BUTTRESS: [[f64; 4]; 4] =
    [[5.1, -0.7, 6.4, 0.85], [4.6, -1.6, 6.6, 0.80], [3.9, -2.6, 6.8, 0.68], [3.4, -3.6, 6.8, 0.55]];
const TEMPORAL_LINE: [[f64; 4]; 6] = [
    [5.0, 2.9, 6.5, 0.50],
    [4.75, 4.0, 6.2, 0.45],
    [4.8, 5.4, 5.2, 0.30],
    [5.2, 6.8, 3.0, 0.15],
    [5.7, 7.7, 0.0, 0.10],
    [5.6, 7.4, -3.0, 0.05],
];
const NUCHAL_LINE: [[f64; 4]; 4] =
    [[0.0, 0.0, -8.2, 0.40], [1.8, 0.1, -7.7, 0.20], [3.8, -0.4, -6.0, 0.20], [5.0, -1.0, -3.4, 0.30]];

// Walls: [x, z, middle height, half height, half thickness].
const UPPER_WALL: [[f64; 5]; 5] = [
    [0.0, 8.75, -3.2, 1.25, 0.55],
    [1.6, 8.35, -3.2, 1.25, 0.56],
    [2.6, 7.0, -3.2, 1.25, 0.60],
    [3.1, 5.4, -3.1, 1.35, 0.66],
    [3.3, 4.2, -3.0, 1.35, 0.62],
];
const LOWER_WALL: [[f64; 5]; 6] = [
    [0.0, 8.55, -7.9, 1.50, 0.52],
    [1.5, 8.2, -7.85, 1.48, 0.54],
    [2.7, 6.9, -7.65, 1.36, 0.60],
    [3.6, 5.1, -7.3, 1.15, 0.66],
    [4.4, 3.5, -6.85, 1.05, 0.60],
    [4.85, 2.3, -6.3, 0.95, 0.50],
];
