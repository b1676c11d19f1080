//! Triangle lists and the OBJ text that they are written as.

use glam::DVec3;
use std::fmt::Write;

/// A triangle list; corners run counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Three indices into `positions` per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Appends another mesh.
    pub fn append(&mut self, other: &Mesh) {
        let base = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    /// The connected piece with the most triangles (a carved field can enclose small bubbles, which nobody sees).
    pub fn largest_piece(&self) -> Mesh {
        let mut root: Vec<u32> = (0..self.positions.len() as u32).collect();
        for t in &self.triangles {
            let a = find(&mut root, t[0]);
            for &corner in &t[1..] {
                let b = find(&mut root, corner);
                root[b as usize] = a;
            }
        }
        let mut size = vec![0; root.len()];
        self.triangles.iter().for_each(|t| size[find(&mut root, t[0]) as usize] += 1);
        let largest = (0..size.len()).max_by_key(|&i| size[i]).unwrap_or(0) as u32;
        let kept = self.triangles.iter().copied().filter(|t| find(&mut root, t[0]) == largest).collect();
        Mesh { positions: self.positions.clone(), triangles: kept }.without_unused()
    }

    /// The same mesh without vertices that no triangle uses; the others are numbered in the order of their use.
    pub fn without_unused(&self) -> Mesh {
        const NONE: u32 = u32::MAX;
        let mut mesh = Mesh::default();
        let mut new_index = vec![NONE; self.positions.len()];
        for t in &self.triangles {
            mesh.triangles.push(t.map(|i| {
                let slot = &mut new_index[i as usize];
                if *slot == NONE {
                    *slot = mesh.positions.len() as u32;
                    mesh.positions.push(self.positions[i as usize]);
                }
                *slot
            }));
        }
        mesh
    }

    /// The smallest and the largest coordinates.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.positions.iter().fold(none, |(low, high), &p| (low.min(p), high.max(p)))
    }
}

/// The representative of `i` in a union-find forest, whose paths are halved on the way.
fn find(root: &mut [u32], mut i: u32) -> u32 {
    while root[i as usize] != i {
        root[i as usize] = root[root[i as usize] as usize];
        i = root[i as usize];
    }
    i
}

/// OBJ text of some named objects: no normals (they follow from the form), `decimals` digits after the point.
pub fn to_obj(comment: &str, objects: &[(&str, &Mesh)], decimals: usize) -> String {
    let mut text = format!("# {comment}\n");
    let mut base = 1;
    // Writing to a String cannot fail.
    for (name, mesh) in objects {
        let _ = writeln!(text, "o {name}");
        for p in &mesh.positions {
            let [x, y, z] = p.to_array().map(|v| short_decimal(v, decimals));
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| i + base);
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        base += mesh.positions.len() as u32;
    }
    text
}

/// A number rounded to `decimals` digits, without trailing zeros and without a minus before zero.
fn short_decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0" } else { text }.to_owned()
}
