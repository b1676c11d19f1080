//! The mesh as the render pass wants it: the first vertex of every face tells the corner that the face begins at, with
//! its set of slices.

use crate::scene::Mesh;
use std::collections::HashMap;

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    /// Read of the first vertex of a face alone: the index of its corner.
    pub corner: u32,
}

/// Where faces of one set begin: they all take the same slices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub set: u32,
}

/// Corners at which faces begin, vertices and indices. Vertices are doubled only where faces of several sets begin at
/// one: the corners of a face are turned so that it begins where one of its set is there already.
pub(super) fn face_corners(mesh: &Mesh, set_of_face: &[u32]) -> (Vec<Corner>, Vec<Vertex>, Vec<u32>) {
    let mut vertices: Vec<Corner> = Vec::with_capacity(mesh.positions().len());
    let mut made: HashMap<(u32, u32), u32> = HashMap::with_capacity(mesh.positions().len());
    // Any vertex of that position and normal; u32::MAX where there is none yet.
    let mut any = vec![u32::MAX; mesh.positions().len()];
    let mut add = |corner: u32, set: u32, vertices: &mut Vec<Corner>, any: &mut [u32]| {
        *made.entry((corner, set)).or_insert_with(|| {
            let at = corner as usize;
            vertices.push(Corner { position: mesh.positions()[at], normal: mesh.normals()[at], set });
            let number = vertices.len() as u32 - 1;
            if any[at] == u32::MAX {
                any[at] = number;
            }
            number
        })
    };
    let mut faces: Vec<[u32; 3]> = Vec::with_capacity(set_of_face.len());
    let mut first: HashMap<u32, u32> = HashMap::new();
    for (triangle, &set) in mesh.indices().chunks_exact(3).zip(set_of_face) {
        // Most faces around a vertex have its first set.
        let turn = (0..3).find(|&k| first.get(&triangle[k]) == Some(&set));
        let turn = turn.or_else(|| (0..3).find(|&k| !first.contains_key(&triangle[k]))).unwrap_or(0);
        let corners = [0, 1, 2].map(|k| triangle[(turn + k) % 3]);
        first.entry(corners[0]).or_insert(set);
        let begin = add(corners[0], set, &mut vertices, &mut any);
        faces.push([begin, corners[1], corners[2]]);
    }
    let mut indices = Vec::with_capacity(3 * faces.len());
    for ([begin, second, third], &set) in faces.into_iter().zip(set_of_face) {
        indices.push(begin);
        for corner in [second, third] {
            let known = any[corner as usize];
            indices.push(if known == u32::MAX { add(corner, set, &mut vertices, &mut any) } else { known });
        }
    }
    let mut begins = vec![false; vertices.len()];
    indices.iter().step_by(3).for_each(|first| begins[*first as usize] = true);
    let mut corners = Vec::new();
    let number = |(vertex, begins): (Corner, bool)| {
        let corner = corners.len() as u32;
        if begins {
            corners.push(vertex);
        }
        Vertex { position: vertex.position, normal: vertex.normal, corner }
    };
    let vertices = vertices.into_iter().zip(begins).map(number).collect();
    (corners, vertices, indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MeshOptions;

    #[test]
    fn every_face_begins_with_its_set_and_keeps_its_corners_and_winding() {
        let text = include_str!("../../../assets/teapot_on_table.obj");
        let mesh = Mesh::parse(text.as_bytes(), "teapot", &MeshOptions::default()).expect("a mesh").mesh;
        let faces = mesh.indices().len() / 3;
        let sets: Vec<u32> = (0..faces as u32).map(|face| (face / 7) % 5).collect();
        let (corners, vertices, indices) = face_corners(&mesh, &sets);
        assert!(corners.len() < vertices.len(), "{} corners", corners.len());
        assert_eq!(indices.len(), mesh.indices().len());
        assert!(vertices.len() < faces * 2, "{} vertices for {faces} faces", vertices.len());
        for (face, (own, old)) in indices.chunks(3).zip(mesh.indices().chunks(3)).enumerate() {
            let first = vertices[own[0] as usize];
            let at = corners[first.corner as usize];
            assert_eq!((at.position, at.normal, at.set), (first.position, first.normal, sets[face]));
            let corner = |vertex: u32| (vertices[vertex as usize].position, vertices[vertex as usize].normal);
            let new = [0, 1, 2].map(|k| corner(own[k]));
            let turned = (0..3).any(|turn| {
                (0..3).all(|k| {
                    let vertex = old[(turn + k) % 3] as usize;
                    new[k] == (mesh.positions()[vertex], mesh.normals()[vertex])
                })
            });
            assert!(turned, "face {face}");
        }
    }
}
