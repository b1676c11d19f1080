//! Thins a fine mesh to a wanted number of triangles: edge collapse by quadric error (M. Garland, P. Heckbert,
//! "Surface Simplification Using Quadric Error Metrics", 1997), so that flat bone keeps few and large triangles and
//! teeth and rims keep many small ones.
//!
//! To Garland and Heckbert's plane quadrics a small share of point quadrics is added: it makes it cost something to
//! pull vertices far along a flat surface, which keeps the triangles there even instead of long and thin.

use super::mesh::Mesh;
use glam::{DMat3, DVec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The share of the point quadrics.
const EVENNESS: f64 = 0.005;

/// A quadratic error function: x^T A x + 2 b.x + c.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    const ZERO: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 };

    /// `weight` times the squared distance from the plane through `p` with the unit normal `n`.
    fn plane(p: DVec3, n: DVec3, weight: f64) -> Self {
        let d = -n.dot(p);
        let outer = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        Self { a: outer * weight, b: n * d * weight, c: d * d * weight }
    }

    /// `weight` times the squared distance from the point `p`.
    fn point(p: DVec3, weight: f64) -> Self {
        Self { a: DMat3::IDENTITY * weight, b: -p * weight, c: p.length_squared() * weight }
    }

    fn plus(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    fn error(&self, x: DVec3) -> f64 {
        x.dot(self.a * x) + 2.0 * self.b.dot(x) + self.c
    }

    /// The place of least error; the point quadrics keep the matrix well away from singular.
    fn minimum(&self) -> DVec3 {
        self.a.inverse() * -self.b
    }
}

/// A possible collapse. The order is by error (whose bits sort like the number, as it is not negative), then by the
/// vertices, so that equal errors cannot make two runs differ.
type Candidate = Reverse<(u64, u32, u32, u32)>;

/// Collapses edges until at most `target` triangles are left (or none can go without spoiling the form).
/// `detail` says how much an error counts at a place.
pub fn decimate(mesh: &Mesh, target: usize, detail: &dyn Fn(DVec3) -> f64) -> Mesh {
    let mut work = Work::new(mesh, detail);
    let mut heap: BinaryHeap<Candidate> = BinaryHeap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            // Each inner edge is met twice, once in either direction.
            if i < j {
                heap.push(work.candidate(i, j));
            }
        }
    }
    while work.alive > target {
        let Some(Reverse((_, i, j, stamp))) = heap.pop() else { break };
        let current = work.stamps[i as usize].wrapping_add(work.stamps[j as usize]);
        if stamp != current || !work.collapse(i, j) {
            continue;
        }
        for n in work.neighbours(i) {
            heap.push(work.candidate(i.min(n), i.max(n)));
        }
    }
    work.finish()
}

struct Work {
    positions: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    /// The triangles round each vertex; empty once the vertex is gone.
    fans: Vec<Vec<u32>>,
    triangles: Vec<Option<[u32; 3]>>,
    /// Grows whenever a vertex changes, so that outdated candidates can be told.
    stamps: Vec<u32>,
    alive: usize,
}

impl Work {
    fn new(mesh: &Mesh, detail: &dyn Fn(DVec3) -> f64) -> Self {
        let count = mesh.positions.len();
        let mut work = Self {
            positions: mesh.positions.clone(),
            quadrics: vec![Quadric::ZERO; count],
            fans: vec![Vec::new(); count],
            triangles: mesh.triangles.iter().map(|&t| Some(t)).collect(),
            stamps: vec![0; count],
            alive: mesh.triangles.len(),
        };
        for (index, t) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(c - a);
            let weight = normal.length() * 0.5 * detail((a + b + c) / 3.0);
            let plane = Quadric::plane(a, normal.normalize_or_zero(), weight);
            for &i in t {
                let point = Quadric::point(mesh.positions[i as usize], weight * EVENNESS);
                work.quadrics[i as usize] = work.quadrics[i as usize].plus(&plane).plus(&point);
                work.fans[i as usize].push(index as u32);
            }
        }
        work
    }

    fn candidate(&self, i: u32, j: u32) -> Candidate {
        let joined = self.quadrics[i as usize].plus(&self.quadrics[j as usize]);
        let error = joined.error(joined.minimum()).max(0.0);
        let stamp = self.stamps[i as usize].wrapping_add(self.stamps[j as usize]);
        Reverse((error.to_bits(), i, j, stamp))
    }

    fn corners(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize].expect("a fan holds living triangles only")
    }

    /// The vertices next to `i`, in rising order.
    fn neighbours(&self, i: u32) -> Vec<u32> {
        let mut around: Vec<u32> = self.fans[i as usize].iter().flat_map(|&t| self.corners(t)).collect();
        around.sort_unstable();
        around.dedup();
        around.retain(|&n| n != i);
        around
    }

    /// Moves `i` to the best place for the edge `i`-`j` and removes `j`; false where that would spoil the mesh.
    fn collapse(&mut self, i: u32, j: u32) -> bool {
        let (around_i, around_j) = (self.neighbours(i), self.neighbours(j));
        // Link condition: only the two corners opposite the edge may see both ends, or the surface would pinch.
        if around_i.iter().filter(|n| around_j.contains(n)).count() != 2 {
            return false;
        }
        let joined = self.quadrics[i as usize].plus(&self.quadrics[j as usize]);
        let place = joined.minimum();
        if !self.keeps_form(i, j, place) || !self.keeps_form(j, i, place) {
            return false;
        }
        self.positions[i as usize] = place;
        self.quadrics[i as usize] = joined;
        for t in std::mem::take(&mut self.fans[j as usize]) {
            let corners = self.corners(t);
            if corners.contains(&i) {
                self.triangles[t as usize] = None;
                self.alive -= 1;
                for c in corners {
                    self.fans[c as usize].retain(|&other| other != t);
                }
            } else {
                self.triangles[t as usize] = Some(corners.map(|c| if c == j { i } else { c }));
                self.fans[i as usize].push(t);
            }
        }
        self.stamps[i as usize] = self.stamps[i as usize].wrapping_add(1);
        true
    }

    /// Whether no triangle that keeps corner `moved` (and lacks `gone`) tips over or becomes a sliver.
    fn keeps_form(&self, moved: u32, gone: u32, place: DVec3) -> bool {
        self.fans[moved as usize].iter().map(|&t| self.corners(t)).filter(|t| !t.contains(&gone)).all(|t| {
            let before = t.map(|c| self.positions[c as usize]);
            let after = t.map(|c| if c == moved { place } else { self.positions[c as usize] });
            let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            let (old, new) = (normal(before), normal(after));
            let [a, b, c] = after;
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            // 0.87 is the area-to-side ratio of the even triangle; a fifth of it is a fairly thin one.
            new.length() > 0.17 * longest && old.dot(new) > 0.5 * old.length() * new.length()
        })
    }

    fn finish(self) -> Mesh {
        Mesh { positions: self.positions, triangles: self.triangles.into_iter().flatten().collect() }.without_unused()
    }
}
