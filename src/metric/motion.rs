//! Where the surface at a pixel of one frame is in the next (section 9.3: coherence in object space).

use crate::paint::{decode_picture, read_picture};
use crate::scene::{Guide, Moment};
use crate::{Error, Result};
use glam::{DMat4, DVec2, DVec3};
use image::ColorType;
use std::path::Path;

/// Steps of a pixel in a motion file.
const STEPS: f64 = 64.0;
/// The value of a motion file that is no motion.
const REST: f64 = 32_768.0;
/// How far apart, in pixels of the nearer frame, a point and what the next frame shows at its place may be to be the
/// same. Beyond half a pixel's diagonal, which rounding to whole pixels makes, a slanted surface needs room.
const SAME_PX: f64 = 3.0;

/// For each pixel of a frame the way to its surface's place in the next, in pixels to the right and down; none where
/// the next frame does not show it, or shows it more than 512 pixels away.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    width: u32,
    height: u32,
    way: Vec<Option<[f32; 2]>>,
}

impl Motion {
    /// The exact motion between two moments, of which the guides are: each pixel's point by its depth, moved as its
    /// object moves and seen by the other camera. It is visible there if the other guide has the same object at the
    /// place and nearly the same point. The way goes from the first to the second, whichever is the earlier.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the guides differ in size or a camera has no projection for it.
    pub fn between(moments: [&Moment; 2], guides: [&Guide; 2]) -> Result<Self> {
        let [first, second] = guides;
        let (width, height) = (first.width, first.height);
        if (second.width, second.height) != (width, height) {
            let allowed = format!("{width} x {height} pixels, as the first");
            return Err(Error::parameter("second guide", format!("{} x {}", second.width, second.height), allowed));
        }
        let size = DVec2::new(f64::from(width), f64::from(height));
        let projection = |moment: &Moment| moment.camera.view_projection(width as f32 / height as f32);
        let [to_first, to_second] = [projection(moments[0])?.as_dmat4(), projection(moments[1])?.as_dmat4()];
        let [from_first, from_second] = [to_first.inverse(), to_second.inverse()];
        let point = |from: &DMat4, x: u32, y: u32, depth: f32| {
            let place = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size * 2.0 - 1.0;
            from.project_point3(place.extend(f64::from(depth)))
        };
        // How long a pixel is at a point.
        let pixel = |point: DVec3| {
            let camera = &moments[0].camera;
            let along = (point - camera.eye().as_dvec3()).dot(camera.forward().as_dvec3());
            2.0 * along * (f64::from(camera.fov_y_deg()).to_radians() / 2.0).tan() / size.y
        };
        let way = |x: u32, y: u32| {
            let at = (y * width + x) as usize;
            let id = first.id[at];
            if id == 0 {
                return None;
            }
            let here = point(&from_first, x, y, first.depth[at]);
            let [before, after] = moments.map(|moment| moment.pose(id as usize - 1).matrix());
            let moved = after.transform_point3(before.inverse().transform_point3(here));
            let seen = to_second.project_point3(moved);
            let place = (seen.truncate() * 0.5 + 0.5) * size - 0.5;
            let nearest = place.round();
            let inside = nearest.cmpge(DVec2::ZERO).all() && nearest.cmplt(size).all() && seen.z > 0.0;
            if !inside {
                return None;
            }
            let (nx, ny) = (nearest.x as u32, nearest.y as u32);
            let there = (ny * width + nx) as usize;
            let visible = second.id[there] == id
                && point(&from_second, nx, ny, second.depth[there]).distance(moved) <= SAME_PX * pixel(here);
            // As a file has it, so that measuring with the file gives the same.
            let steps = |way: f64| ((way * STEPS).round() / STEPS) as f32;
            let way = [steps(place.x - f64::from(x)), steps(place.y - f64::from(y))];
            (visible && texel(way).is_some()).then_some(way)
        };
        let way = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| way(x, y)).collect();
        Ok(Motion { width, height, way })
    }

    /// Reads a motion file: a picture of 16 bits in which red is 32,768 + 64 times the pixels to the right, green the
    /// same downwards, and blue 0 where the next frame does not show the surface.
    ///
    /// # Errors
    /// As [`crate::paint::PaintSample::load`], and for a picture that has not red, green and blue of 16 bits.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let picture = decode_picture(&read_picture(path)?, path)?;
        // Fewer bits would be taken for motion that is not there.
        if !matches!(picture.color(), ColorType::Rgb16 | ColorType::Rgba16) {
            return Err(Error::file(path, "is no motion: it must have red, green and blue of 16 bits"));
        }
        let picture = picture.to_rgb16();
        let pixels = |value: u16| ((f64::from(value) - REST) / STEPS) as f32;
        let way = picture.pixels().map(|p| (p.0[2] != 0).then(|| [pixels(p.0[0]), pixels(p.0[1])])).collect();
        Ok(Motion { width: picture.width(), height: picture.height(), way })
    }

    /// The motion as a file has it: red, green and blue of every pixel.
    pub fn to_rgb16(&self) -> Vec<[u16; 3]> {
        self.way.iter().map(|way| way.and_then(texel).unwrap_or([REST as u16, REST as u16, 0])).collect()
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Where the surface at a pixel is in the next frame, in pixels: whole numbers are centres of pixels; `None` where
    /// it is not to be seen.
    pub fn place(&self, x: u32, y: u32) -> Option<[f64; 2]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let [right, down] = self.way[(y * self.width + x) as usize]?;
        Some([f64::from(x) + f64::from(right), f64::from(y) + f64::from(down)])
    }

    /// The pixel of the next frame that is nearest to where this one's surface is; `None` where it is not to be seen.
    pub fn pixel(&self, x: u32, y: u32) -> Option<(u32, u32)> {
        let [to_x, to_y] = self.place(x, y)?;
        let to = |to: f64, side: u32| {
            let to = to.round();
            (to >= 0.0 && to < f64::from(side)).then_some(to as u32)
        };
        Some((to(to_x, self.width)?, to(to_y, self.height)?))
    }
}

/// A way as a file has it; none for what leads further than 512 pixels.
fn texel(way: [f32; 2]) -> Option<[u16; 3]> {
    let [x, y] = way.map(|pixels| (f64::from(pixels) * STEPS + REST).round());
    let fits = |value: f64| (0.0..=65_535.0).contains(&value);
    (fits(x) && fits(y)).then_some([x as u16, y as u16, u16::MAX])
}
