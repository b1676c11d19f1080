//! Turns a signed distance field into triangles: naive surface nets (S. Gibson, "Constrained Elastic Surface Nets",
//! 1998), then the vertices are relaxed along the surface and put exactly onto it.
//!
//! Every cell of the grid that the surface passes through gets one vertex; every grid edge that crosses the surface
//! gets a quadrilateral between the vertices of the four cells around it. The result is finer than wanted and
//! evenly dense; `decimate` thins it afterwards.

use super::mesh::Mesh;
use glam::DVec3;

/// A signed distance field (negative inside).
pub type Field<'a> = dyn Fn(DVec3) -> f64 + 'a;

/// The surface of `field` within the box `low`..`high`, on a grid of `cell` side length.
pub fn polygonise(field: &Field, low: DVec3, high: DVec3, cell: f64) -> Mesh {
    let grid = Grid::sample(field, low, high, cell);
    let mut mesh = grid.net();
    for _ in 0..3 {
        relax(&mut mesh, 0.5);
        project(&mut mesh, field, cell);
    }
    project(&mut mesh, field, cell);
    mesh
}

/// Side length, in corners, of the blocks in which the field is sampled.
const BLOCK: usize = 4;

/// The three indices of element `i` of an array of `size`, the first one running fastest.
fn unfold(i: usize, size: [usize; 3]) -> [usize; 3] {
    [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])]
}

/// Field values on the corners of a grid of cubes.
struct Grid {
    size: [usize; 3],
    low: DVec3,
    cell: f64,
    values: Vec<f64>,
}

impl Grid {
    fn sample(field: &Field, low: DVec3, high: DVec3, cell: f64) -> Self {
        let size = ((high - low) / cell).to_array().map(|n| n.ceil() as usize + 1);
        let mut grid = Self { size, low, cell, values: vec![0.0; size[0] * size[1] * size[2]] };
        let blocks = size.map(|n| n.div_ceil(BLOCK));
        for block in (0..blocks[0] * blocks[1] * blocks[2]).map(|i| unfold(i, blocks)) {
            grid.sample_block(field, block.map(|n| n * BLOCK));
        }
        grid.fill_pinches();
        grid
    }

    /// Fills the corners of one block. Where the surface is far away the value at the middle stands for them all:
    /// only its sign will be looked at.
    fn sample_block(&mut self, field: &Field, first: [usize; 3]) {
        let half_side = BLOCK as f64 * 0.5;
        let middle = field(self.corner(first) + DVec3::splat((half_side - 0.5) * self.cell));
        // The half diagonal is 1.73 half sides; twice that, as the values are not quite distances.
        let far = middle.abs() > 3.5 * half_side * self.cell;
        let last: [usize; 3] = std::array::from_fn(|k| (first[k] + BLOCK).min(self.size[k]));
        for z in first[2]..last[2] {
            for y in first[1]..last[1] {
                for x in first[0]..last[0] {
                    let i = self.index([x, y, z]);
                    self.values[i] = if far { middle } else { field(self.corner([x, y, z])) };
                }
            }
        }
    }

    /// Makes the inside "well-composed" (L. Latecki, "3D Well-Composed Pictures", 1997): wherever two inside corners
    /// touch only diagonally, across a face or across a whole cell, a corner between them becomes inside as well.
    /// One vertex per cell is then enough for a surface that pinches nowhere, so every edge has just two triangles.
    fn fill_pinches(&mut self) {
        let (size, count) = (self.size, self.values.len());
        loop {
            let mut filled = false;
            for at in (0..count).map(|i| unfold(i, size)) {
                for (axis_u, axis_v) in [(0, 1), (1, 2), (2, 0)] {
                    filled |= self.fill_face(at, axis_u, axis_v);
                }
                filled |= self.fill_cell(at);
            }
            if !filled {
                break;
            }
        }
    }

    /// A face whose inside corners are just one diagonal gets a third; true where that was so.
    fn fill_face(&mut self, at: [usize; 3], u: usize, v: usize) -> bool {
        if at[u] + 1 >= self.size[u] || at[v] + 1 >= self.size[v] {
            return false;
        }
        let corner = |du, dv| {
            let mut c = at;
            c[u] += du;
            c[v] += dv;
            self.index(c)
        };
        let ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        let inside = ring.map(|i| self.values[i] < 0.0);
        if inside[0] != inside[2] || inside[1] != inside[3] || inside[0] == inside[1] {
            return false;
        }
        let outside = if inside[0] { [ring[1], ring[3]] } else { [ring[0], ring[2]] };
        let nearer = if self.values[outside[0]] <= self.values[outside[1]] { outside[0] } else { outside[1] };
        self.values[nearer] = -0.01 * self.cell;
        true
    }

    /// A cell with only two opposite corners inside (or only two outside) gets one of the others filled.
    fn fill_cell(&mut self, at: [usize; 3]) -> bool {
        if (0..3).any(|k| at[k] + 1 >= self.size[k]) {
            return false;
        }
        let corners: [usize; 8] =
            std::array::from_fn(|i| self.index([at[0] + (i & 1), at[1] + (i >> 1 & 1), at[2] + (i >> 2)]));
        let inside = corners.map(|i| self.values[i] < 0.0);
        let count = inside.iter().filter(|&&i| i).count();
        let diagonal = (0..4).any(|i| inside[i] == inside[7 - i] && inside[i] == (count == 2));
        if (count != 2 && count != 6) || !diagonal {
            return false;
        }
        let outside = (0..8).filter(|&i| !inside[i]).map(|i| corners[i]);
        let nearest = outside.min_by(|&a, &b| self.values[a].total_cmp(&self.values[b]));
        nearest.is_some_and(|i| {
            self.values[i] = -0.01 * self.cell;
            true
        })
    }

    fn corner(&self, [x, y, z]: [usize; 3]) -> DVec3 {
        self.low + DVec3::new(x as f64, y as f64, z as f64) * self.cell
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// The mean of the places where the surface cuts the twelve edges of a cell, if it cuts any.
    fn cell_vertex(&self, at: [usize; 3]) -> Option<DVec3> {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for axis in 0..3 {
            for side in 0..4 {
                let mut a = at;
                a[(axis + 1) % 3] += side & 1;
                a[(axis + 2) % 3] += side >> 1;
                let mut b = a;
                b[axis] += 1;
                let (va, vb) = (self.values[self.index(a)], self.values[self.index(b)]);
                if (va < 0.0) != (vb < 0.0) {
                    sum += self.corner(a).lerp(self.corner(b), va / (va - vb));
                    count += 1.0;
                }
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    fn net(&self) -> Mesh {
        const NONE: u32 = u32::MAX;
        let mut mesh = Mesh::default();
        let mut vertex_of = vec![NONE; self.values.len()];
        let [nx, ny, nz] = self.size;
        let cells = |n: usize| 0..n - 1;
        for z in cells(nz) {
            for y in cells(ny) {
                for x in cells(nx) {
                    if let Some(p) = self.cell_vertex([x, y, z]) {
                        vertex_of[self.index([x, y, z])] = mesh.positions.len() as u32;
                        mesh.positions.push(p);
                    }
                }
            }
        }
        for z in 1..nz - 1 {
            for y in 1..ny - 1 {
                for x in 1..nx - 1 {
                    self.quads_at([x, y, z], &vertex_of, &mut mesh);
                }
            }
        }
        mesh
    }

    /// The quadrilaterals across the three grid edges that start at a corner.
    fn quads_at(&self, at: [usize; 3], vertex_of: &[u32], mesh: &mut Mesh) {
        let here = self.values[self.index(at)] < 0.0;
        for axis in 0..3 {
            let mut next = at;
            next[axis] += 1;
            if here == (self.values[self.index(next)] < 0.0) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            // Round the edge, counter-clockwise seen from the end of the axis.
            let mut quad = [[1, 1], [0, 1], [0, 0], [1, 0]].map(|[back_u, back_v]: [usize; 2]| {
                let mut cell = at;
                cell[u] -= back_u;
                cell[v] -= back_v;
                vertex_of[self.index(cell)]
            });
            if !here {
                quad.reverse();
            }
            let [a, b, c, d] = quad;
            let p = |i: u32| mesh.positions[i as usize];
            // The shorter diagonal gives the better-shaped pair of triangles.
            if p(a).distance_squared(p(c)) <= p(b).distance_squared(p(d)) {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                mesh.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
}

/// Moves every vertex the part `amount` of the way to the mean of its neighbours, along the surface only.
pub fn relax(mesh: &mut Mesh, amount: f64) {
    let mut sum = vec![DVec3::ZERO; mesh.positions.len()];
    let mut count = vec![0.0; mesh.positions.len()];
    let mut normal = vec![DVec3::ZERO; mesh.positions.len()];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        let area_normal = (b - a).cross(c - a);
        for k in 0..3 {
            let (i, j) = (t[k] as usize, t[(k + 1) % 3] as usize);
            sum[i] += mesh.positions[j];
            count[i] += 1.0;
            normal[i] += area_normal;
        }
    }
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        if count[i] > 0.0 {
            let step = (sum[i] / count[i] - *p) * amount;
            let n = normal[i].normalize_or_zero();
            *p += step - n * n.dot(step);
        }
    }
}

/// Puts every vertex onto the surface by a Newton step along the gradient, no longer than half a `cell`.
pub fn project(mesh: &mut Mesh, field: &Field, cell: f64) {
    for p in &mut mesh.positions {
        let slope = gradient(field, *p, cell * 0.05);
        let step = slope * (field(*p) / slope.length_squared().max(0.1));
        *p -= step.clamp_length_max(cell * 0.5);
    }
}

/// The field's gradient by central differences over `2 h`.
pub fn gradient(field: &Field, p: DVec3, h: f64) -> DVec3 {
    let along = |axis: DVec3| (field(p + axis * h) - field(p - axis * h)) / (2.0 * h);
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}
