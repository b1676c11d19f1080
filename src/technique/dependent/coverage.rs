//! Which views show which faces (thesis chapter 8).
//!
//! The pictures of face IDs are drawn elsewhere: [`Coverage`] says which, and works on the host.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};

use crate::scene::{places, Camera, Framing, Mesh};
use crate::{Error, Result};

/// The most slices that faces can be spread over: a slice is numbered in 8 bits, 0 to 254.
pub const MAX_SLICES: usize = 255;
/// Slices that a mesh is supposed to take, for each view that is asked for and at least: models of the test data took up
/// to 2.2 for each of 14 views, and 21 for 2 views, since further rounds find what few views leave.
const SUPPOSED_SLICES: (usize, usize) = (3, 48);
/// The most views that may be asked for.
pub const MAX_VIEWS: usize = 64;

/// Rounds of drawing, the first included.
const MAX_ROUNDS: u32 = 8;
/// Sides that pictures of face IDs may have, in pixels.
const SIZE_PX: std::ops::RangeInclusive<u32> = 512..=4096;
/// What stays free on every side of a picture, so that no corner falls on its border.
const MARGIN: f32 = 0.01;
/// A pixel centre counts for a face from this many pixels inside of its outline on: where exactly a device rounds the
/// outline to does not matter then.
const INSET_PX: f64 = 1.0 / 16.0;
/// Faces that are seen at a smaller cosine than this are so distorted in a picture that another view is better.
const MIN_FACING: f64 = 0.15;
/// Pitch of a cube's corners, seen from its middle: asin(1 / sqrt(3)), in degrees.
const CORNER_PITCH_DEG: f32 = 35.264_39;

/// A direction from which the model is looked at, as in [`Framing`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// 0 looks at the model from +z, 90 from +x. In degrees, any finite.
    pub yaw_deg: f32,
    /// How far above the horizon the eye is, in degrees: -90 to 90.
    pub pitch_deg: f32,
}

/// Fourteen views around a model: along the axes (front, right, back, left, top, bottom), and from the corners of a
/// cube. The thesis takes 12 to 15 (chapter 8).
pub fn default_views() -> Vec<View> {
    let around = |first: f32, pitch_deg| {
        [0.0, 90.0, 180.0, 270.0].into_iter().map(move |yaw| View { yaw_deg: first + yaw, pitch_deg })
    };
    let poles = [90.0, -90.0].map(|pitch_deg| View { yaw_deg: 0.0, pitch_deg });
    let corners = around(45.0, CORNER_PITCH_DEG).chain(around(45.0, -CORNER_PITCH_DEG));
    around(0.0, 0.0).chain(poles).chain(corners).collect()
}

/// Checks how many views are asked for, and the side of their pictures.
///
/// # Errors
/// [`Error::Parameter`] for what is out of range.
pub(crate) fn check_views(views: &[View], view_px: u32) -> Result<()> {
    if !(1..=MAX_VIEWS).contains(&views.len()) {
        return Err(Error::parameter("views", views.len(), format!("1 to {MAX_VIEWS}")));
    }
    if !SIZE_PX.contains(&view_px) {
        let allowed = format!("from {} to {} pixels", SIZE_PX.start(), SIZE_PX.end());
        return Err(Error::parameter("view_px", view_px, allowed));
    }
    Ok(())
}

/// Finds out which views show which faces (thesis chapter 8): says what has to be drawn, takes the pictures, and ends
/// with the slices, which are the views that are kept, and the slices of every face.
///
/// The first round draws all faces from the views that are asked for. A face is covered by a view if it faces the eye
/// and nothing hides any part of it. As long as faces are left that no view covers, further rounds draw those alone,
/// from the [`default_views`], and keep of these as many as are needed: the one that covers the most, then the one
/// that adds the most, and so on. Views that a face is turned away from by more than 81 degrees (a cosine below 0.15)
/// show it too distorted: it keeps them only if that round has no better one for it, and further rounds take them only
/// when they would add nothing without them. It ends when nothing is left, when a further round adds nothing, or after
/// 8 rounds. Faces that are left then, such as triangles that cross each other, are given the slice of the first round
/// whose eye they face most.
///
/// A picture shows the faces of its round from one camera: back faces culled, the front being counter-clockwise; depth
/// test LESS; each pixel the index of its triangle + 1, or 0 where there is none; rows from the top.
///
/// Where a face has pixel centres in it (more than 1/16 pixel from its outline), every one has to show it. A smaller
/// one is covered if the pixels of four points in it show it, or a face that has a corner in the same place.
#[derive(Debug)]
pub struct Coverage {
    geometry: Geometry,
    size_px: u32,
    /// What the first round looks from, and what all others do.
    asked: Vec<Aimed>,
    further: Vec<Aimed>,
    /// Faces that no slice covers, ascending.
    left: Vec<u32>,
    /// Slices of every face, ascending.
    slices_of_face: Vec<Vec<u8>>,
    kept: Vec<Kept>,
    rounds: u32,
    covered_at_first: usize,
    is_done: bool,
}

/// What has to be drawn: every camera sees the same faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// One for each picture, for an aspect of 1.
    pub cameras: Vec<Camera>,
    /// Indices of the triangles to draw, ascending; no others may be in the pictures.
    pub faces: Vec<u32>,
}

/// Which slices there are, and which of them show a face.
#[derive(Debug, Clone, PartialEq)]
pub struct Covered {
    /// The views that were kept, by round; at least one, at most [`MAX_SLICES`].
    pub slices: Vec<Slice>,
    /// The lists of slices that faces have: ascending, none empty, no two the same.
    pub sets: Vec<Vec<u8>>,
    /// For every triangle of the mesh the index of its list in `sets`.
    pub set_of_face: Vec<u32>,
    /// Figures.
    pub report: CoverageReport,
}

/// A view that was kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    /// Where it looks from.
    pub view: View,
    /// Its camera, which shows the whole mesh at an aspect of 1.
    pub camera: Camera,
    /// Unit vector from the middle of the mesh's bounding sphere towards the eye.
    pub direction: Vec3,
    /// The round that it is from, the first being 1.
    pub round: u32,
    /// The triangles that have this slice in their set, and so are drawn into it; ascending. Empty for no slice.
    pub faces: Vec<u32>,
}

/// How it went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoverageReport {
    /// Views that were asked for.
    pub views: usize,
    /// Rounds that were drawn.
    pub rounds: u32,
    /// Slices that were kept.
    pub slices: usize,
    /// Different sets of slices.
    pub sets: usize,
    /// Triangles of the mesh: `covered` + `forced`.
    pub faces: usize,
    /// Triangles that a slice shows whole.
    pub covered: usize,
    /// Those of them that a view of the first round shows whole.
    pub covered_at_first: usize,
    /// Triangles that no slice shows whole, and that were given the one whose eye they face most.
    pub forced: usize,
}

/// A view with its camera.
#[derive(Debug, Clone, Copy)]
struct Aimed {
    view: View,
    camera: Camera,
}

/// A view that became a slice.
#[derive(Debug, Clone, Copy)]
struct Kept {
    aimed: Aimed,
    round: u32,
}

/// What is needed of the mesh.
#[derive(Debug)]
struct Geometry {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// A number for each vertex: the same for all vertices in the same place.
    place_of_vertex: Vec<u32>,
    center: DVec3,
}

impl Coverage {
    /// Prepares the first round. `size_px` is the side of the square pictures, 512 to 4096.
    ///
    /// # Errors
    /// [`Error::Parameter`] if there are no views or more than [`MAX_VIEWS`], one of their angles is out of range, or
    /// `size_px` is.
    pub fn new(mesh: &Mesh, views: &[View], size_px: u32) -> Result<Self> {
        check_views(views, size_px)?;
        let geometry = Geometry::new(mesh);
        let faces = geometry.triangles.len();
        Ok(Self {
            geometry,
            size_px,
            asked: aim(mesh, views)?,
            further: aim(mesh, &default_views())?,
            left: (0..faces as u32).collect(),
            slices_of_face: vec![Vec::new(); faces],
            kept: Vec::new(),
            rounds: 0,
            covered_at_first: 0,
            is_done: false,
        })
    }

    /// What has to be drawn next; `None` when all is known.
    pub fn round(&self) -> Option<Round> {
        let cameras = || self.candidates().iter().map(|aimed| aimed.camera).collect();
        (!self.is_done).then(|| Round { cameras: cameras(), faces: self.left.clone() })
    }

    /// Takes the pictures of the round, one for each of its cameras: `size_px` x `size_px` values, rows from the top,
    /// triangle index + 1, or 0 where there is none.
    ///
    /// # Errors
    /// [`Error::Parameter`] if there is not one picture for each camera, or one has another size or a number beyond
    /// the mesh's triangles; nothing has changed then.
    pub fn take(&mut self, face_ids: &[Vec<u32>]) -> Result<()> {
        self.check(face_ids)?;
        if self.is_done {
            return Ok(());
        }
        let seen = self.seen(face_ids)?;
        let is_first = self.rounds == 0;
        let room = MAX_SLICES - self.kept.len();
        let candidates = self.candidates().to_vec();
        let chosen = match is_first {
            true => {
                (0..candidates.len()).filter(|&k| seen.iter().any(|views| views >> k & 1 == 1)).take(room).collect()
            }
            false => greedy(&seen, candidates.len(), room),
        };
        self.rounds += 1;
        let first = self.kept.len();
        self.kept.extend(chosen.iter().map(|&k| Kept { aimed: candidates[k], round: self.rounds }));
        let drawn = std::mem::take(&mut self.left);
        for (&face, views) in drawn.iter().zip(&seen) {
            let slices = &mut self.slices_of_face[face as usize];
            slices.extend((first..).zip(&chosen).filter(|&(_, k)| views >> k & 1 == 1).map(|(slice, _)| slice as u8));
            if slices.is_empty() {
                self.left.push(face);
            }
        }
        if is_first {
            self.covered_at_first = drawn.len() - self.left.len();
        }
        // The first round may show nothing and still be followed by others, which look from elsewhere.
        let is_stuck = !is_first && self.left.len() == drawn.len();
        let is_full = self.rounds == MAX_ROUNDS || self.kept.len() == MAX_SLICES;
        self.is_done = self.left.is_empty() || is_stuck || is_full;
        Ok(())
    }

    /// What the search may come to, for whoever needs room for it before it was made: [`SUPPOSED_SLICES`], each of which
    /// shows half of the faces, neighbours in different sets.
    pub(crate) fn suppose(mut self) -> Covered {
        let (for_each, least) = SUPPOSED_SLICES;
        let slices = (self.asked.len() * for_each).clamp(least, MAX_SLICES);
        self.kept = self.asked.iter().cycle().take(slices).map(|&aimed| Kept { aimed, round: 1 }).collect();
        for (face, of_face) in self.slices_of_face.iter_mut().enumerate() {
            *of_face = (0..slices as u8).filter(|slice| usize::from(*slice) % 2 == face % 2).collect();
            if of_face.is_empty() {
                of_face.push(0);
            }
        }
        self.left.clear();
        self.finish()
    }

    /// The slices and the sets, when [`Coverage::round`] gives `None`. Before that, all faces that are still left are
    /// given the slice whose eye they face most, as if nothing more could be seen.
    pub fn finish(mut self) -> Covered {
        if self.kept.is_empty() {
            self.kept.push(Kept { aimed: self.asked[0], round: 1 });
        }
        // Slices of further rounds are made for few faces. They serve only if there are no others.
        let of_first = self.kept.iter().filter(|kept| kept.round == 1).count();
        let eligible = if of_first > 0 { of_first } else { self.kept.len() };
        for &face in &self.left {
            let mut best = (0, f64::NEG_INFINITY);
            for (slice, kept) in self.kept[..eligible].iter().enumerate() {
                let facing = self.geometry.facing(face, kept.aimed.camera.eye().as_dvec3());
                if facing > best.1 {
                    best = (slice, facing);
                }
            }
            self.slices_of_face[face as usize].push(best.0 as u8);
        }

        let center = self.geometry.center;
        let mut slices: Vec<Slice> = self
            .kept
            .iter()
            .map(|&Kept { aimed: Aimed { view, camera }, round }| {
                let direction = (camera.eye().as_dvec3() - center).try_normalize();
                let direction = direction.map_or(-camera.forward(), |direction| direction.as_vec3());
                Slice { view, camera, direction, round, faces: Vec::new() }
            })
            .collect();
        let mut sets: Vec<Vec<u8>> = Vec::new();
        let mut set_of_face = Vec::with_capacity(self.slices_of_face.len());
        let mut number_of_set = HashMap::new();
        for (face, set) in self.slices_of_face.into_iter().enumerate() {
            set.iter().for_each(|&slice| slices[usize::from(slice)].faces.push(face as u32));
            let number = *number_of_set.entry(set).or_insert_with_key(|set| {
                sets.push(set.clone());
                sets.len() as u32 - 1
            });
            set_of_face.push(number);
        }
        let (faces, forced) = (set_of_face.len(), self.left.len());
        let report = CoverageReport {
            views: self.asked.len(),
            rounds: self.rounds,
            slices: slices.len(),
            sets: sets.len(),
            faces,
            covered: faces - forced,
            covered_at_first: self.covered_at_first,
            forced,
        };
        Covered { slices, sets, set_of_face, report }
    }

    /// What the next round looks from.
    fn candidates(&self) -> &[Aimed] {
        if self.rounds == 0 {
            &self.asked
        } else {
            &self.further
        }
    }

    fn check(&self, face_ids: &[Vec<u32>]) -> Result<()> {
        let expected = if self.is_done { 0 } else { self.candidates().len() };
        if face_ids.len() != expected {
            let value = format!("{} pictures", face_ids.len());
            return Err(Error::parameter("face_ids", value, format!("{expected}: one for each camera of the round")));
        }
        let pixels = self.size_px as usize * self.size_px as usize;
        if let Some(stray) = face_ids.iter().find(|picture| picture.len() != pixels) {
            let value = format!("a picture of {} values", stray.len());
            return Err(Error::parameter("face_ids", value, format!("pictures of {pixels}")));
        }
        let faces = self.geometry.triangles.len() as u32;
        let highest = face_ids.iter().flatten().max().copied().unwrap_or(0);
        if highest > faces {
            return Err(Error::parameter("face_ids", highest, format!("at most the number of triangles ({faces})")));
        }
        Ok(())
    }

    /// For each face that is left, a bit for each view that covers it. Views that it faces too little do not count if
    /// it has others, and in further rounds as long as any face is covered without them.
    fn seen(&self, face_ids: &[Vec<u32>]) -> Result<Vec<u64>> {
        let mut seen = vec![(0_u64, 0_u64); self.left.len()];
        for (k, (aimed, face_ids)) in self.candidates().iter().zip(face_ids).enumerate() {
            let picture = Picture::new(&self.geometry, &aimed.camera, face_ids, self.size_px)?;
            for (&face, (any, well)) in self.left.iter().zip(&mut seen) {
                let facing = self.geometry.facing(face, picture.eye);
                if facing > 0.0 && picture.covers(face) {
                    *any |= 1 << k;
                    *well |= u64::from(facing >= MIN_FACING) << k;
                }
            }
        }
        // In the first round the views are the user's choice. Of the others, later ones draw fewer faces: what hides a
        // face from where it would be seen well may be gone then.
        let is_first_or_last = self.rounds == 0 || self.rounds + 1 == MAX_ROUNDS;
        let takes_any = is_first_or_last || seen.iter().all(|&(_, well)| well == 0);
        let choose = |(any, well)| if well == 0 && takes_any { any } else { well };
        Ok(seen.into_iter().map(choose).collect())
    }
}

/// Views (of `count`) in the order in which they add the most faces, of equal ones the first, until none adds any.
fn greedy(seen: &[u64], count: usize, room: usize) -> Vec<usize> {
    let mut open = seen.to_vec();
    let mut chosen = Vec::new();
    while chosen.len() < room {
        open.retain(|&views| views != 0);
        let mut best = (0, 0);
        for k in 0..count {
            let adds = open.iter().filter(|&views| views >> k & 1 == 1).count();
            if adds > best.1 {
                best = (k, adds);
            }
        }
        if best.1 == 0 {
            break;
        }
        chosen.push(best.0);
        open.retain(|views| views >> best.0 & 1 == 0);
    }
    chosen
}

/// Cameras that show the whole mesh.
fn aim(mesh: &Mesh, views: &[View]) -> Result<Vec<Aimed>> {
    let aim = |&view: &View| {
        let View { yaw_deg, pitch_deg } = view;
        let framing = Framing { yaw_deg, pitch_deg, distance: None, margin: MARGIN, ..Framing::default() };
        Ok(Aimed { view, camera: Camera::framing(mesh, &framing, 1.0)? })
    };
    views.iter().map(aim).collect()
}

impl Geometry {
    fn new(mesh: &Mesh) -> Self {
        Self {
            place_of_vertex: places(mesh.positions()),
            positions: mesh.positions().iter().map(|&position| Vec3::from(position).as_dvec3()).collect(),
            triangles: mesh.indices().chunks_exact(3).map(|corner| [corner[0], corner[1], corner[2]]).collect(),
            center: mesh.bounding_sphere().center.as_dvec3(),
        }
    }

    /// Cosine of the angle between a face's normal and the direction from its centroid to the eye.
    fn facing(&self, face: u32, eye: DVec3) -> f64 {
        let [a, b, c] = self.triangles[face as usize].map(|vertex| self.positions[vertex as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        normal.dot((eye - (a + b + c) / 3.0).normalize_or_zero())
    }

    /// True if two faces are the same or have a corner in the same place.
    fn touch(&self, face: u32, other: u32) -> bool {
        let [of_face, of_other] =
            [face, other].map(|face| self.triangles[face as usize].map(|vertex| self.place_of_vertex[vertex as usize]));
        of_face.iter().any(|place| of_other.contains(place))
    }
}

/// A picture of face IDs, and where the vertices are in it.
struct Picture<'a> {
    geometry: &'a Geometry,
    face_ids: &'a [u32],
    size_px: u32,
    eye: DVec3,
    /// In pixels from the top left; `None` for vertices outside of the picture.
    points: Vec<Option<DVec2>>,
}

impl<'a> Picture<'a> {
    fn new(geometry: &'a Geometry, camera: &Camera, face_ids: &'a [u32], size_px: u32) -> Result<Self> {
        let to_clip = camera.view_projection(1.0)?.as_dmat4();
        let side = f64::from(size_px);
        let project = |position: &DVec3| {
            let clip = to_clip * position.extend(1.0);
            let point = (clip.truncate().truncate() / clip.w + 1.0) / 2.0 * side;
            let is_inside = clip.w > 0.0 && point.min_element() >= 0.0 && point.max_element() <= side;
            is_inside.then_some(point)
        };
        let points = geometry.positions.iter().map(project).collect();
        Ok(Self { geometry, face_ids, size_px, eye: camera.eye().as_dvec3(), points })
    }

    /// True if a face that is turned towards the eye is in the picture as a whole.
    fn covers(&self, face: u32) -> bool {
        let [a, b, c] = self.geometry.triangles[face as usize].map(|vertex| self.points[vertex as usize]);
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { return false };
        let is_only_this = |(row, columns): (usize, std::ops::Range<usize>)| {
            let row = &self.face_ids[row * self.size_px as usize..][columns];
            row.iter().all(|&id| id == face + 1)
        };
        let mut rows = inner_pixels([a, b, c], self.size_px).peekable();
        if rows.peek().is_some() {
            return rows.all(is_only_this);
        }
        let middle = (a + b + c) / 3.0;
        [a, b, c].map(|corner| corner.lerp(middle, 0.25)).into_iter().chain([middle]).all(|point| {
            let last = self.size_px as usize - 1;
            let [column, row] = point.to_array().map(|value| (value as usize).min(last));
            match self.face_ids[row * self.size_px as usize + column] {
                0 => false,
                id => self.geometry.touch(face, id - 1),
            }
        })
    }
}

/// Rows and columns of the pixels whose centres are inside of a triangle that is counter-clockwise for the viewer, and
/// no closer to its edges than the inset. No row is given without columns.
fn inner_pixels(corners: [DVec2; 3], size_px: u32) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
    let [a, b, c] = corners;
    // Distance from an edge, towards the inside: slope . point - offset. As y points down, the inside of a
    // counter-clockwise triangle is to the left of the way around it.
    let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        let along = (to - from).normalize_or_zero();
        let slope = DVec2::new(along.y, -along.x);
        (slope, slope.dot(from))
    });
    let low = a.y.min(b.y).min(c.y).floor().max(0.0) as usize;
    let high = (a.y.max(b.y).max(c.y).ceil().max(0.0) as usize).min(size_px as usize);
    (low..high).filter_map(move |row| {
        let y = row as f64 + 0.5;
        // Columns of pixel centres, x = column + 0.5, that are far enough inside of all three edges.
        let (mut first, mut last) = (0.0_f64, f64::from(size_px) - 1.0);
        for (slope, offset) in edges {
            let missing = INSET_PX + offset - slope.y * y;
            if slope.x > 0.0 {
                first = first.max((missing / slope.x - 0.5).ceil());
            } else if slope.x < 0.0 {
                last = last.min((missing / slope.x - 0.5).floor());
            } else if missing > 0.0 {
                return None;
            }
        }
        (first <= last).then(|| (row, first as usize..last as usize + 1))
    })
}
