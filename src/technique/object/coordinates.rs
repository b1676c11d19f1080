//! The coordinate t of every vertex (thesis chapter 5, equation 5.1): from neighbour to neighbour over the surface.
//!
//! Vertices at one position are one vertex here, whatever their normals. All arithmetic is in double precision and in
//! one order, and random numbers are a hash of (seed, vertex), so that a mesh has the same t everywhere.

use super::nearest::NearestTree;
use crate::scene::{places, Mesh, Vec3};
use crate::{Error, Result};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};

/// Along what the strip repeats.
#[derive(Debug, Clone, PartialEq)]
pub enum Orientation {
    /// Along one direction everywhere; of any length.
    Axis(Vec3),
    /// Along a direction of its own at each vertex of [`Mesh::positions`]; of any length.
    Field(Vec<Vec3>),
}

/// What happens where the mesh falls apart into pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SeamPolicy {
    /// t goes on from the closest vertex that has one: for seams within what should be continuous.
    #[default]
    Carry,
    /// Each piece begins at a random vertex with a random t, which shows the seam.
    Fresh,
}

/// How t is spread over a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateParams {
    /// Beta, how often the strip repeats over the mesh: 0.01 to 1000.
    pub repeats: f32,
    /// Gamma, the most by which t changes at random from a vertex to the next, in repeats: 0 to 1.
    pub variation: f32,
    /// Along what the strip repeats.
    pub orientation: Orientation,
    /// What happens between pieces.
    pub seams: SeamPolicy,
    /// Enters the random choices.
    pub seed: u32,
}

impl Default for CoordinateParams {
    fn default() -> Self {
        CoordinateParams {
            repeats: 4.0,
            variation: 0.0,
            orientation: Orientation::Axis(Vec3::Y),
            seams: SeamPolicy::default(),
            seed: 1,
        }
    }
}

impl CoordinateParams {
    fn check(&self, mesh: &Mesh) -> Result<()> {
        if !(0.01..=1000.0).contains(&self.repeats) {
            return Err(Error::parameter("repeats", self.repeats, "0.01 to 1000"));
        }
        if !(0.0..=1.0).contains(&self.variation) {
            return Err(Error::parameter("variation", self.variation, "0 to 1"));
        }
        let directions = match &self.orientation {
            Orientation::Axis(axis) => std::slice::from_ref(axis),
            Orientation::Field(field) => field,
        };
        if let Some(bad) = directions.iter().find(|d| !d.is_finite() || d.as_dvec3().try_normalize().is_none()) {
            return Err(Error::parameter("orientation", bad, "finite directions that are not zero"));
        }
        let vertices = mesh.positions().len();
        if matches!(self.orientation, Orientation::Field(_)) && directions.len() != vertices {
            let allowed = format!("one for each of the {vertices} vertices");
            return Err(Error::parameter("orientation", format!("{} directions", directions.len()), allowed));
        }
        Ok(())
    }
}

/// t of every vertex of [`Mesh::positions`], not brought into 0 to 1 (equation 5.1):
/// t = t of the nearest neighbour that has one + (its step along the orientation / the mesh's extent) * beta + gamma.
///
/// A random vertex begins with a random t; its neighbours queue, and theirs. Along an axis the extent is the mesh's;
/// along a field it is the range of the steps added up over the mesh, which is the same where the field is constant. A
/// mesh without extent along the orientation, such as a plane across the axis, has one t but for the variation.
///
/// # Errors
/// [`Error::Parameter`] for a parameter out of range, a direction that is zero or not finite, or a field that has not one
/// direction for each vertex.
pub fn texture_coordinates(mesh: &Mesh, params: &CoordinateParams) -> Result<Vec<f32>> {
    params.check(mesh)?;
    let surface = Surface::new(mesh, &params.orientation);
    let scale = surface.extent().map_or(0.0, |extent| f64::from(params.repeats) / extent);
    let t = surface.propagate(scale, f64::from(params.variation), params.seams, params.seed);
    Ok(surface.point_of_vertex.iter().map(|&point| t[point as usize] as f32).collect())
}

/// How often the strip repeats over a unit of the world along the orientation: beta over the extent, or over the
/// longest side of the bounding box where there is no extent.
///
/// # Errors
/// As [`texture_coordinates`].
pub fn density(mesh: &Mesh, params: &CoordinateParams) -> Result<f32> {
    params.check(mesh)?;
    let surface = Surface::new(mesh, &params.orientation);
    let extent = surface.extent().unwrap_or(surface.longest);
    Ok((f64::from(params.repeats) / extent) as f32)
}

/// What of the longest side counts as no extent: several times the rounding of 32-bit positions.
const NO_EXTENT: f64 = 1e-6;

/// The mesh with one point for all vertices at a position.
struct Surface {
    point_of_vertex: Vec<u32>,
    points: Vec<DVec3>,
    /// The longest side of the bounding box.
    longest: f64,
    /// One direction, or one for each point; unit length.
    directions: Vec<DVec3>,
    /// The neighbours of point i are `neighbours[starts[i]..starts[i + 1]]`, ascending.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Surface {
    fn new(mesh: &Mesh, orientation: &Orientation) -> Self {
        let places = places(mesh.positions());
        let mut point_of_vertex = vec![0u32; places.len()];
        let (mut points, mut first_vertex) = (Vec::new(), Vec::new());
        for (vertex, &place) in places.iter().enumerate() {
            if place as usize == vertex {
                point_of_vertex[vertex] = points.len() as u32;
                points.push(Vec3::from(mesh.positions()[vertex]).as_dvec3());
                first_vertex.push(vertex);
            } else {
                point_of_vertex[vertex] = point_of_vertex[place as usize];
            }
        }
        let unit = |direction: &Vec3| direction.as_dvec3().normalize();
        let directions = match orientation {
            Orientation::Axis(axis) => vec![unit(axis)],
            Orientation::Field(field) => first_vertex.iter().map(|&vertex| unit(&field[vertex])).collect(),
        };
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(2 * mesh.indices().len());
        for triangle in mesh.indices().chunks_exact(3) {
            for k in 0..3 {
                let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(|vertex| point_of_vertex[vertex as usize]);
                edges.push((a, b));
                edges.push((b, a));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut starts = vec![0u32; points.len() + 1];
        edges.iter().for_each(|&(a, _)| starts[a as usize + 1] += 1);
        for i in 0..points.len() {
            starts[i + 1] += starts[i];
        }
        let neighbours = edges.into_iter().map(|(_, b)| b).collect();
        let (low, high) = mesh.bounds();
        let longest = f64::from((high - low).max_element());
        Surface { point_of_vertex, points, longest, directions, starts, neighbours }
    }

    /// The step from one point to another along the orientation.
    fn step(&self, from: u32, to: u32) -> f64 {
        let direction = match self.directions[..] {
            [axis] => axis,
            _ => (self.directions[from as usize] + self.directions[to as usize]) * 0.5,
        };
        (self.points[to as usize] - self.points[from as usize]).dot(direction)
    }

    /// How far the surface reaches along the orientation; `None` where that is nothing but rounding.
    fn extent(&self) -> Option<f64> {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let extent = match self.directions[..] {
            [axis] => range(&mut self.points.iter().map(|point| point.dot(axis))),
            _ => range(&mut self.propagate(1.0, 0.0, SeamPolicy::Carry, 0).into_iter()),
        };
        (extent > NO_EXTENT * self.longest).then_some(extent)
    }

    fn propagate(&self, scale: f64, variation: f64, seams: SeamPolicy, seed: u32) -> Vec<f64> {
        let count = self.points.len();
        let mut walk = Walk {
            surface: self,
            scale,
            variation,
            seed,
            t: vec![0.0; count],
            done: vec![false; count],
            queued: vec![false; count],
            queue: VecDeque::new(),
            fresh: Vec::new(),
        };
        match seams {
            SeamPolicy::Carry => walk.carry(),
            SeamPolicy::Fresh => walk.fresh(),
        }
        walk.t
    }
}

/// A propagation under way.
struct Walk<'a> {
    surface: &'a Surface,
    scale: f64,
    variation: f64,
    seed: u32,
    t: Vec<f64>,
    done: Vec<bool>,
    queued: Vec<bool>,
    queue: VecDeque<u32>,
    /// The points done since this was emptied.
    fresh: Vec<u32>,
}

/// What a random number is for.
const START: u32 = 0;
const VALUE: u32 = 1;
const GAMMA: u32 = 2;

impl Walk<'_> {
    /// A random number in [0, 1).
    fn random(&self, number: u32, purpose: u32) -> f64 {
        crate::random::unit(self.seed, number, purpose)
    }

    fn finish(&mut self, point: u32, t: f64) {
        self.t[point as usize] = t;
        self.done[point as usize] = true;
        self.fresh.push(point);
        let range = self.surface.starts[point as usize] as usize..self.surface.starts[point as usize + 1] as usize;
        for &neighbour in &self.surface.neighbours[range] {
            if !self.done[neighbour as usize] && !self.queued[neighbour as usize] {
                self.queued[neighbour as usize] = true;
                self.queue.push_back(neighbour);
            }
        }
    }

    /// Equation 5.1.
    fn forward(&mut self, from: u32, to: u32) {
        let gamma = (2.0 * self.random(to, GAMMA) - 1.0) * self.variation;
        let t = self.t[from as usize] + self.surface.step(from, to) * self.scale + gamma;
        self.finish(to, t);
    }

    /// Works off the queue: the rest of a connected piece.
    fn spread(&mut self) {
        while let Some(point) = self.queue.pop_front() {
            let surface = self.surface;
            let range = surface.starts[point as usize] as usize..surface.starts[point as usize + 1] as usize;
            let nearest =
                surface.neighbours[range].iter().copied().filter(|&n| self.done[n as usize]).min_by(|&a, &b| {
                    let distance = |n: u32| surface.points[n as usize].distance_squared(surface.points[point as usize]);
                    distance(a).total_cmp(&distance(b)).then(a.cmp(&b))
                });
            if let Some(nearest) = nearest {
                self.forward(nearest, point);
            }
        }
    }

    /// Begins at a random point that has no t yet, the first one from a random place on.
    fn begin(&mut self, piece: u32, next: &mut NextFree) {
        let count = self.surface.points.len();
        let place = (self.random(piece, START) * count as f64) as usize;
        if let Some(start) = next.find(place, &self.done) {
            let t = self.random(piece, VALUE);
            self.finish(start, t);
            self.spread();
        }
    }

    fn fresh(&mut self) {
        let mut next = NextFree::new(self.surface.points.len());
        let mut piece = 0;
        let mut left = self.surface.points.len();
        while left > 0 {
            self.fresh.clear();
            self.begin(piece, &mut next);
            left -= self.fresh.len();
            piece += 1;
        }
    }

    /// Each further piece goes on from the closest pair of a point with and a point without t.
    fn carry(&mut self) {
        self.begin(0, &mut NextFree::new(self.surface.points.len()));
        let mut left = self.surface.points.len() - self.fresh.len();
        if left == 0 {
            return;
        }
        let mut tree = NearestTree::new(&self.surface.points);
        let mut heap = BinaryHeap::new();
        while left > 0 {
            let news = std::mem::take(&mut self.fresh);
            news.iter().for_each(|&point| tree.remove(point));
            for &from in &news {
                heap.extend(Bridge::find(&tree, self.surface, from));
            }
            // What a point with t was closest to may have got its t meanwhile; its next closest is farther away.
            let bridge = loop {
                let Some(bridge) = heap.pop() else { return };
                if !self.done[bridge.to as usize] {
                    break bridge;
                }
                heap.extend(Bridge::find(&tree, self.surface, bridge.from));
            };
            // The point may still be the closest one to others.
            let again = bridge.from;
            self.forward(bridge.from, bridge.to);
            self.spread();
            left -= self.fresh.len();
            self.fresh.push(again);
        }
    }
}

/// A point with t and the closest one without; the shortest is the greatest, as a heap wants it.
#[derive(PartialEq)]
struct Bridge {
    distance: f64,
    to: u32,
    from: u32,
}

impl Bridge {
    fn find(tree: &NearestTree, surface: &Surface, from: u32) -> Option<Bridge> {
        let (to, distance) = tree.nearest(surface.points[from as usize])?;
        Some(Bridge { distance, to, from })
    }
}

impl Eq for Bridge {}

impl Ord for Bridge {
    fn cmp(&self, other: &Self) -> Ordering {
        let key =
            |a: &Self, b: &Self| b.distance.total_cmp(&a.distance).then(b.to.cmp(&a.to)).then(b.from.cmp(&a.from));
        key(self, other)
    }
}

impl PartialOrd for Bridge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Finds the first point without t from a place on, around the end.
struct NextFree(Vec<u32>);

impl NextFree {
    fn new(count: usize) -> Self {
        NextFree((0..=count as u32).collect())
    }

    fn find(&mut self, place: usize, done: &[bool]) -> Option<u32> {
        let after = self.root(place, done);
        let found = if after == done.len() { self.root(0, done) } else { after };
        (found < done.len()).then_some(found as u32)
    }

    fn root(&mut self, place: usize, done: &[bool]) -> usize {
        let mut at = place;
        while at < done.len() && done[at] {
            let next = self.0[at] as usize;
            at = if next == at { at + 1 } else { next };
        }
        // The whole way leads straight there the next time.
        let mut way = place;
        while way < at {
            let next = self.0[way] as usize;
            self.0[way] = at as u32;
            way = if next == way { way + 1 } else { next };
        }
        at
    }
}
