//! The guide pass on the CPU, kept as plain as possible: what the Vulkan pass is compared with.
//!
//! It draws what the later stages are guided by: the shade of every pixel (equation 3.1), which object it belongs to
//! (the ID buffer of section 3.1.3), and its depth. The rules are Vulkan's: samples at pixel centres, corners rounded
//! to 1/256 pixel, top-left rule, clipping at near and far plane, depth test LESS in the order of the triangles. A
//! Vulkan device may differ at the outlines, where its rounding of a corner may fall to the other side of a pixel
//! centre, and in the last bits of depth and shade.

use glam::{DVec3, DVec4, Vec3};

use super::light::Lights;
use super::mesh::Mesh;
use super::moment::Moment;
use crate::error::{Error, Result};

/// The longest side of a guide image.
pub const MAX_GUIDE_SIDE_PX: u32 = 16_384;
/// Corners are rounded to this fraction of a pixel (`subPixelPrecisionBits` = 8).
const SUBPIXELS: i64 = 256;

/// Guide images: rows from top to bottom, pixels from left to right.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The light that each pixel receives, 0 to 1; 0 in the background.
    pub shade: Vec<f32>,
    /// Object index + 1; 0 in the background.
    pub id: Vec<u32>,
    /// 0 at the near plane to 1 at the far plane; 1 in the background.
    pub depth: Vec<f32>,
}

/// The plain CPU rasteriser.
#[derive(Debug)]
pub struct GuideOracle;

/// A corner of a triangle on its way to the screen.
#[derive(Clone, Copy)]
struct Corner {
    clip: DVec4,
    normal: DVec3,
}

impl GuideOracle {
    /// Draws the mesh as it is at a moment.
    ///
    /// The world-space normal is interpolated with perspective correction, brought to unit length, and turned for
    /// triangles that show their back, before equation 3.1 is applied.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a side is not in 1..=[`MAX_GUIDE_SIDE_PX`].
    pub fn render(mesh: &Mesh, moment: &Moment, width: u32, height: u32) -> Result<Guide> {
        for (name, side) in [("width", width), ("height", height)] {
            if !(1..=MAX_GUIDE_SIDE_PX).contains(&side) {
                return Err(Error::parameter(name, side, format!("from 1 to {MAX_GUIDE_SIDE_PX} pixels")));
            }
        }
        let view_projection = moment.camera.view_projection(width as f32 / height as f32)?.as_dmat4();
        let pixels = width as usize * height as usize;
        let mut guide =
            Guide { width, height, shade: vec![0.0; pixels], id: vec![0; pixels], depth: vec![1.0; pixels] };

        for (object, part) in mesh.objects().iter().enumerate() {
            let to_world = moment.pose(object).matrix();
            let range = part.first_index as usize..(part.first_index + part.index_count) as usize;
            for triangle in mesh.indices()[range].chunks_exact(3) {
                let corners = [0, 1, 2].map(|k| {
                    let vertex = triangle[k] as usize;
                    let position = Vec3::from(mesh.positions()[vertex]).as_dvec3();
                    let normal = to_world.transform_vector3(Vec3::from(mesh.normals()[vertex]).as_dvec3());
                    Corner { clip: view_projection * to_world * position.extend(1.0), normal }
                });
                let polygon = clip_near(&corners);
                for k in 2..polygon.len() {
                    guide.draw([polygon[0], polygon[k - 1], polygon[k]], object as u32 + 1, &moment.lights);
                }
            }
        }
        Ok(guide)
    }
}

/// Cuts off what lies before the near plane (clip z below 0): 0, 3 or 4 corners are left.
fn clip_near(corners: &[Corner; 3]) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(4);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        if a.clip.z >= 0.0 {
            kept.push(a);
        }
        if (a.clip.z >= 0.0) != (b.clip.z >= 0.0) {
            let t = a.clip.z / (a.clip.z - b.clip.z);
            kept.push(Corner { clip: a.clip.lerp(b.clip, t), normal: a.normal.lerp(b.normal, t) });
        }
    }
    kept
}

impl Guide {
    /// Draws one triangle that lies behind the near plane.
    fn draw(&mut self, mut corners: [Corner; 3], id: u32, lights: &Lights) {
        let mut points = corners.map(|corner| self.to_screen(corner.clip));
        // On the screen y points down, so the front's counter-clockwise corners give a negative area.
        let mut area = edge(points[0], points[1], points[2]);
        let is_front = area < 0;
        if is_front {
            points.swap(1, 2);
            corners.swap(1, 2);
            area = -area;
        }
        if area == 0 {
            return;
        }
        let facing = if is_front { 1.0 } else { -1.0 };
        let [columns, rows] = [(0, self.width), (1, self.height)].map(|(axis, side)| {
            let values = points.map(|point| point[axis]);
            let low = values.into_iter().fold(i128::MAX, i128::min).div_euclid(SUBPIXELS.into());
            let high = values.into_iter().fold(i128::MIN, i128::max).div_euclid(SUBPIXELS.into());
            low.clamp(0, side.into()) as u32..(high + 1).clamp(0, side.into()) as u32
        });
        for y in rows {
            for x in columns.clone() {
                let center = [x, y].map(|pixel| i128::from(pixel) * i128::from(SUBPIXELS) + i128::from(SUBPIXELS / 2));
                // Twice the areas of the three triangles that the pixel centre makes with the edges: how far it is
                // towards the corner across from each.
                let [a, b, c] = points;
                let parts = [edge(b, c, center), edge(c, a, center), edge(a, b, center)];
                let borders = [is_top_left(b, c), is_top_left(c, a), is_top_left(a, b)];
                if (0..3).all(|k| parts[k] > 0 || (parts[k] == 0 && borders[k])) {
                    let weights = parts.map(|part| part as f64 / area as f64);
                    self.write((x, y), &corners, weights, facing, id, lights);
                }
            }
        }
    }

    /// Screen position in subpixels. What lies absurdly far outside stays within what products of 128 bits can hold.
    fn to_screen(&self, clip: DVec4) -> [i128; 2] {
        [(clip.x, self.width), (clip.y, self.height)].map(|(value, side)| {
            let pixels = (value / clip.w + 1.0) / 2.0 * f64::from(side);
            (pixels * SUBPIXELS as f64).round().clamp(-1e15, 1e15) as i128
        })
    }

    /// Depth test, and the values of one pixel. `weights` are the barycentric coordinates on the screen.
    fn write(
        &mut self,
        (x, y): (u32, u32),
        corners: &[Corner; 3],
        weights: [f64; 3],
        facing: f64,
        id: u32,
        lights: &Lights,
    ) {
        let at = y as usize * self.width as usize + x as usize;
        let depth: f64 = (0..3).map(|k| weights[k] * corners[k].clip.z / corners[k].clip.w).sum();
        let depth = depth as f32;
        if !(depth <= 1.0 && depth < self.depth[at]) {
            return;
        }
        // Weights on the screen become weights on the surface when each is divided by w.
        let normal: DVec3 = (0..3).map(|k| corners[k].normal * (weights[k] / corners[k].clip.w)).sum();
        let normal = facing * normal.normalize_or_zero();
        self.depth[at] = depth;
        self.id[at] = id;
        self.shade[at] = lights.shade(normal.as_vec3());
    }
}

/// Twice the area of the triangle a, b, p: positive if p lies to the right of the way from a to b (y points down, so
/// that is clockwise on the screen).
fn edge(a: [i128; 2], b: [i128; 2], p: [i128; 2]) -> i128 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// True if a pixel centre exactly on the edge from a to b belongs to this triangle: a left edge goes up, a top edge
/// goes to the right.
fn is_top_left(a: [i128; 2], b: [i128; 2]) -> bool {
    b[1] < a[1] || (b[1] == a[1] && b[0] > a[0])
}
