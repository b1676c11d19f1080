//! Normals for vertices that have none: the mean of the faces around them, but not across creases.
//!
//! Faces are neighbours if they share an edge, by position: a model whose patches or texture seams double their
//! vertices is as smooth as one that shares them. Around a vertex, neighbours that meet at no more than the crease
//! angle form one smooth region with one normal, the mean of its faces' normals, each weighted by the face's angle at
//! the vertex (Thuermer and Wuethrich 1998), so that it does not depend on how a flat area happens to be cut into
//! triangles.

use super::edges::{following, sorted_edges};
use super::solid::places;
use glam::DVec3;

/// The smooth region of each triangle corner, and the unit normal of each region. The corners of a region are all at
/// the same position.
pub(super) struct CornerNormals {
    region: Vec<u32>,
    normals: Vec<[f32; 3]>,
}

impl CornerNormals {
    /// How many regions there are.
    pub fn region_count(&self) -> usize {
        self.normals.len()
    }

    /// Region and normal of a corner; corner `3 t + k` is corner `k` of triangle `t`.
    pub fn at(&self, corner: usize) -> (u32, [f32; 3]) {
        let region = self.region[corner];
        (region, self.normals[region as usize])
    }
}

/// Computes normals for all corners of triangles that have an area. `crease_deg` is in 0..=180.
pub(super) fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]], crease_deg: f32) -> CornerNormals {
    let of_vertex = places(positions);
    let corner_places: Vec<u32> = triangles.iter().flatten().map(|vertex| of_vertex[*vertex as usize]).collect();
    let point = |vertex: u32| DVec3::from(positions[vertex as usize].map(f64::from));
    let face_normals: Vec<DVec3> = triangles
        .iter()
        .map(|&[a, b, c]| (point(b) - point(a)).cross(point(c) - point(a)).normalize_or_zero())
        .collect();

    let mut sets = join_corners(&corner_places, &face_normals, crease_deg);
    let mut totals: Vec<(DVec3, usize)> = Vec::new();
    let mut region = vec![u32::MAX; triangles.len() * 3];
    for (t, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(point);
        for (k, [here, next, before]) in [[a, b, c], [b, c, a], [c, a, b]].into_iter().enumerate() {
            // The root of a set is its lowest corner, so it has its number by now, or is this corner.
            let corner = 3 * t + k;
            let root = sets.root(corner as u32) as usize;
            if region[root] == u32::MAX {
                region[root] = totals.len() as u32;
                totals.push((DVec3::ZERO, t));
            }
            region[corner] = region[root];
            let (p, q) = (next - here, before - here);
            let angle = p.cross(q).length().atan2(p.dot(q));
            totals[region[corner] as usize].0 += angle * face_normals[t];
        }
    }
    // Faces that cancel each other out leave no direction; then any of them is better than none.
    let normals = totals
        .iter()
        .map(|&(sum, t)| if sum.length() > 1e-6 { sum.normalize() } else { face_normals[t] })
        .map(|normal| normal.as_vec3().to_array())
        .collect();
    CornerNormals { region, normals }
}

/// Joins the corners, on both ends of every edge, of faces that meet there without a crease.
fn join_corners(places: &[u32], face_normals: &[DVec3], crease_deg: f32) -> CornerSets {
    // Faces that meet at the crease angle itself, up to rounding, are still smooth.
    let least = (f64::from(crease_deg).to_radians().cos() - 1e-4).max(-1.0);
    let mut sets = CornerSets::new(places.len());
    let mut leaders: Vec<u32> = Vec::with_capacity(MAX_LEADERS);
    for faces in sorted_edges(places).chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        // More than two faces may meet at an edge. Each joins the first that it is smooth with; comparing it with a few
        // is enough, because few directions are creased against each other.
        leaders.clear();
        for &(low, _, corner) in faces {
            let normal = face_normals[corner as usize / 3];
            let leader = leaders.iter().copied().find(|&leader| normal.dot(face_normals[leader as usize / 3]) >= least);
            let Some(leader) = leader else {
                if leaders.len() < MAX_LEADERS {
                    leaders.push(corner);
                }
                continue;
            };
            let ends = |start: u32| {
                if places[start as usize] == low {
                    (start, following(start))
                } else {
                    (following(start), start)
                }
            };
            let ((low_a, high_a), (low_b, high_b)) = (ends(leader), ends(corner));
            sets.join(low_a, low_b);
            sets.join(high_a, high_b);
        }
    }
    sets
}

/// How many faces of one edge, all creased against each other, a further face is compared with.
const MAX_LEADERS: usize = 16;

/// Disjoint sets of corners. The root of a set is its lowest corner, so the outcome does not depend on the order.
struct CornerSets {
    parent: Vec<u32>,
}

impl CornerSets {
    fn new(corners: usize) -> Self {
        Self { parent: (0..corners as u32).collect() }
    }

    fn root(&mut self, mut corner: u32) -> u32 {
        while self.parent[corner as usize] != corner {
            let above = self.parent[self.parent[corner as usize] as usize];
            self.parent[corner as usize] = above;
            corner = above;
        }
        corner
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
