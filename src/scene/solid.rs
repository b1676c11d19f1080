//! Whether the back faces of a mesh can be left out of a picture: half of the triangles need no drawing then.
//!
//! A closed surface whose pieces all face outwards hides its back faces from every eye outside of it. Leaving them out
//! changes no pixel, then, but the drawing takes half the time.

use super::{Camera, Mesh};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// What is known of a mesh's back faces.
#[derive(Debug)]
pub(crate) struct Solid {
    /// The mesh's positions, if it is closed and faces outwards.
    positions: Option<Vec<Vec3>>,
}

impl Solid {
    /// Looks at a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        Solid { positions: is_solid(mesh).then(|| mesh.positions().iter().copied().map(Vec3::from).collect()) }
    }

    /// Whether no back face can be seen through this camera: the mesh is solid, and lies wholly beyond the near plane.
    ///
    /// Looks at every vertex, for the near plane may be close to the first: some 30 microseconds for 50,000.
    pub fn hides_back_faces(&self, camera: &Camera) -> bool {
        let (eye, forward, near) = (camera.eye(), camera.forward(), camera.near());
        self.positions.as_ref().is_some_and(|positions| {
            let nearest = positions.iter().fold(f32::INFINITY, |least, p| least.min((*p - eye).dot(forward)));
            nearest > near
        })
    }
}

/// True if every edge is passed as often one way as the other, and every connected piece encloses a volume.
fn is_solid(mesh: &Mesh) -> bool {
    let places = places(mesh.positions());
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(mesh.indices().len());
    let mut piece: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    for triangle in mesh.indices().chunks_exact(3) {
        let corners = [0, 1, 2].map(|k| places[triangle[k] as usize]);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), a < b));
            join(&mut piece, a, b);
        }
    }
    edges.sort_unstable();
    let closed = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).all(|edge| {
        let forth = edge.iter().filter(|(_, _, forth)| *forth).count();
        2 * forth == edge.len()
    });
    if !closed {
        return false;
    }
    // Six times the volume of each piece, from a point close by so that the terms do not cancel.
    let origin = mesh.bounding_sphere().center.as_dvec3();
    let mut volumes: HashMap<u32, f64> = HashMap::new();
    for triangle in mesh.indices().chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| corner(mesh, triangle[k]) - origin);
        *volumes.entry(root(&mut piece, places[triangle[0] as usize])).or_default() += a.dot(b.cross(c));
    }
    volumes.values().all(|volume| *volume > 0.0)
}

fn corner(mesh: &Mesh, vertex: u32) -> DVec3 {
    Vec3::from(mesh.positions()[vertex as usize]).as_dvec3()
}

/// For each vertex the first one at the same position.
pub(crate) fn places(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    // Adding 0 makes -0 and 0 the same.
    let bits = |position: &[f32; 3]| position.map(|x| (x + 0.0).to_bits());
    (0..).zip(positions).map(|(i, position)| *first.entry(bits(position)).or_insert(i)).collect()
}

fn root(piece: &mut [u32], mut vertex: u32) -> u32 {
    while piece[vertex as usize] != vertex {
        let above = piece[piece[vertex as usize] as usize];
        piece[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

fn join(piece: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(piece, a), root(piece, b));
    piece[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Framing, MeshOptions};

    const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

    fn mesh(text: &str) -> Mesh {
        Mesh::parse(text.as_bytes(), "test", &MeshOptions::default()).expect("a mesh").mesh
    }

    #[test]
    fn a_cube_is_solid_and_one_without_lid_or_turned_inside_out_is_not() {
        assert!(is_solid(&mesh(CUBE)), "creased, so its vertices are doubled");
        assert!(!is_solid(&mesh(CUBE.trim_end_matches("f 4 1 5 8\n"))));
        let inside_out: String = CUBE
            .lines()
            .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["f", a, b, c, d] => format!("f {d} {c} {b} {a}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        assert!(!is_solid(&mesh(&inside_out)));
        // One good piece does not make up for a bad one: the second cube's corners are counted from the end.
        let second: String = inside_out
            .lines()
            .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["v", x, y, z] => format!("v {} {y} {z}\n", x.parse::<f32>().expect("a number") + 5.0),
                ["f", a, b, c, d] => {
                    let index = |text: &str| text.parse::<i32>().expect("an index") - 9;
                    format!("f {} {} {} {}\n", index(a), index(b), index(c), index(d))
                }
                _ => String::new(),
            })
            .collect();
        assert!(!is_solid(&mesh(&format!("{CUBE}{second}"))));
    }

    #[test]
    fn back_faces_show_to_an_eye_inside() {
        let mesh = mesh(CUBE);
        let solid = Solid::new(&mesh);
        let outside = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
        assert!(solid.hides_back_faces(&outside));
        let inside = Camera::look_at(Vec3::ZERO, Vec3::Z, None, 60.0).expect("a camera").fit_depth(&mesh);
        assert!(!solid.hides_back_faces(&inside));
    }
}
