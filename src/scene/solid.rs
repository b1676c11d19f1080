//! Whether the back faces of a mesh can be left out of a picture: half of the triangles need no drawing then.
//!
//! A closed surface whose pieces all face outwards hides its back faces from every eye outside of it. Leaving them out
//! changes no pixel, then, but the drawing takes half the time. Objects that move apart must each be closed.

use super::edges::sorted_edges;
use super::{Mesh, Moment};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::hash::Hash;

/// What is known of a mesh's back faces.
#[derive(Debug)]
pub(crate) struct Solid {
    /// The mesh is closed and faces outwards.
    together: bool,
    /// So is each of its objects by itself, wherever the others are.
    apart: bool,
    /// The positions of every object; none where nothing is solid.
    objects: Vec<Vec<Vec3>>,
}

impl Solid {
    /// Looks at a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let together = is_solid(mesh, &places(mesh.positions()));
        let owners = mesh.object_of_vertex();
        let apart = match mesh.objects() {
            [_] => together,
            _ => is_solid(mesh, &first_of(mesh.positions().iter().zip(&owners).map(|(p, owner)| (bits(p), *owner)))),
        };
        let mut objects = Vec::new();
        if together || apart {
            objects.resize(mesh.objects().len(), Vec::new());
            for (position, owner) in mesh.positions().iter().zip(owners) {
                objects[owner as usize].push(Vec3::from(*position));
            }
        }
        Solid { together, apart, objects }
    }

    /// Whether no back face can be seen at this moment: what moves by itself is solid, and all lies wholly beyond the
    /// near plane.
    ///
    /// Looks at every vertex, for the near plane may be close to the first: some 30 microseconds for 50,000.
    pub fn hides_back_faces(&self, moment: &Moment) -> bool {
        let as_one = (1..self.objects.len()).all(|object| moment.pose(object) == moment.pose(0));
        let near = moment.camera.near();
        let beyond = |(number, positions): (usize, &Vec<Vec3>)| {
            let pose = moment.pose(number);
            let eye = pose.point_to_object(moment.camera.eye());
            let forward = pose.to_object(moment.camera.forward());
            positions.iter().fold(f32::INFINITY, |least, p| least.min((*p - eye).dot(forward))) > near
        };
        (if as_one { self.together } else { self.apart }) && self.objects.iter().enumerate().all(beyond)
    }
}

/// True if every edge is passed as often one way as the other, and every connected piece encloses a volume. Vertices
/// with the same place are one.
fn is_solid(mesh: &Mesh, places: &[u32]) -> bool {
    let corners: Vec<u32> = mesh.indices().iter().map(|vertex| places[*vertex as usize]).collect();
    let closed = sorted_edges(&corners).chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).all(|edge| {
        let forth = edge.iter().filter(|(low, _, corner)| corners[*corner as usize] == *low).count();
        2 * forth == edge.len()
    });
    if !closed {
        return false;
    }
    let mut piece: Vec<u32> = (0..places.len() as u32).collect();
    for triangle in corners.chunks_exact(3) {
        join(&mut piece, triangle[0], triangle[1]);
        join(&mut piece, triangle[1], triangle[2]);
    }
    // Six times the volume of each piece, from a point close by so that the terms do not cancel.
    let origin = mesh.bounding_sphere().center.as_dvec3();
    let mut volumes = vec![0.0; places.len()];
    for (triangle, places) in mesh.indices().chunks_exact(3).zip(corners.chunks_exact(3)) {
        let [a, b, c] = [0, 1, 2].map(|k| corner(mesh, triangle[k]) - origin);
        volumes[root(&mut piece, places[0]) as usize] += a.dot(b.cross(c));
    }
    corners.iter().all(|place| volumes[root(&mut piece, *place) as usize] > 0.0)
}

fn corner(mesh: &Mesh, vertex: u32) -> DVec3 {
    Vec3::from(mesh.positions()[vertex as usize]).as_dvec3()
}

/// For each vertex the first one at the same position.
pub(crate) fn places(positions: &[[f32; 3]]) -> Vec<u32> {
    first_of(positions.iter().map(bits))
}

/// For each key the place of the first that is the same.
fn first_of<K: Eq + Hash>(keys: impl Iterator<Item = K>) -> Vec<u32> {
    let mut first: HashMap<K, u32> = HashMap::with_capacity(keys.size_hint().0);
    (0..).zip(keys).map(|(i, key)| *first.entry(key).or_insert(i)).collect()
}

/// What positions are compared by. Adding 0 makes -0 and 0 the same.
fn bits(position: &[f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
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
    use crate::scene::{Camera, Framing, Lights, MeshOptions, Pose};

    const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

    fn mesh(text: &str) -> Mesh {
        Mesh::parse(text.as_bytes(), "test", &MeshOptions::default()).expect("a mesh").mesh
    }

    fn solid_alone(mesh: &Mesh) -> bool {
        is_solid(mesh, &places(mesh.positions()))
    }

    #[test]
    fn a_cube_is_solid_and_one_without_lid_or_turned_inside_out_is_not() {
        assert!(solid_alone(&mesh(CUBE)), "creased, so its vertices are doubled");
        assert!(!solid_alone(&mesh(CUBE.trim_end_matches("f 4 1 5 8\n"))));
        let inside_out: String = CUBE
            .lines()
            .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["f", a, b, c, d] => format!("f {d} {c} {b} {a}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        assert!(!solid_alone(&mesh(&inside_out)));
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
        assert!(!solid_alone(&mesh(&format!("{CUBE}{second}"))));
    }

    #[test]
    fn back_faces_show_to_an_eye_inside() {
        let mesh = mesh(CUBE);
        let solid = Solid::new(&mesh);
        let outside = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
        let at_rest = |camera| Moment::at_rest(camera, Lights::default());
        assert!(solid.hides_back_faces(&at_rest(outside)));
        let inside = Camera::look_at(Vec3::ZERO, Vec3::Z, None, 60.0).expect("a camera").fit_depth(&mesh);
        assert!(!solid.hides_back_faces(&at_rest(inside)));
        // It comes to the eye instead.
        let eye = outside.eye();
        let pose = Pose::new(0.0, Vec3::Y, Vec3::ZERO, eye).expect("a pose");
        assert!(!solid.hides_back_faces(&Moment { poses: vec![pose], ..at_rest(outside) }));
    }

    #[test]
    fn two_halves_that_come_apart_show_their_inside() {
        let (lower, upper) = CUBE.split_at(CUBE.find("f 1 2 6 5").expect("a face"));
        let mesh = mesh(&format!("o lower\n{lower}o upper\n{upper}"));
        assert_eq!(mesh.objects().len(), 2);
        let solid = Solid::new(&mesh);
        let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
        let pose = |way| Pose::new(30.0, Vec3::Y, Vec3::ZERO, way).expect("a pose");
        let at = |poses| solid.hides_back_faces(&Moment { poses, ..Moment::at_rest(camera, Lights::default()) });
        assert!(at(vec![]));
        assert!(at(vec![pose(Vec3::ZERO); 2]), "moved as one");
        assert!(!at(vec![pose(Vec3::ZERO)]));
    }
}
