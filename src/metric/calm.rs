//! How much the paint on a surface changes from a frame to the next.
//!
//! The thesis's coherence (section 9.3) compares histograms of blocks: it says whether the texture stays alike, and
//! little of whether it stays. Flicker is a change of colour at a point of the surface, and that is measured here: each
//! pixel's colour against the colour of the same surface point in the next frame.
//!
//! The point lies between pixels there. The nearest pixel is up to half a pixel away, so that even paint that sticks to
//! the surface perfectly differs from it. Interpolating between the four pixels around it takes most of that away, but
//! blurs the next frame, which makes even unrelated frames a little more alike. Hence both, each to be read beside the
//! same figure of frames without any coherence. Where light changes, so does colour, and that counts as well.

use super::{Motion, Picture};
use crate::{Error, Result};

/// The mean difference between colours of the same surface points: of |frame - next| over red, green and blue, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameDifference {
    /// To the nearest pixel of the next frame.
    pub nearest: f64,
    /// To the next frame's colour at the exact place (motion has 1/64 px), bilinear between the four pixels around it.
    pub bilinear: f64,
    /// How many surface points were compared.
    pub pixels: usize,
}

/// Compares two frames of one size at the same surface points.
///
/// Compared are pixels inside `frame` whose surface the next frame shows and for whose place there all pixels that
/// bilinear interpolation looks at are inside `next`; both means are over the same pixels. Interpolation at an outline
/// within the model may look at another surface; that is rare and the same for all ways of painting.
///
/// # Errors
/// [`Error::Parameter`] for frames or a motion of different sizes, and where no pixel can be compared.
pub fn frame_difference(frame: &Picture, next: &Picture, motion: &Motion) -> Result<FrameDifference> {
    let (width, height) = (frame.width(), frame.height());
    next.check_size("next frame", width, height)?;
    if motion.size() != (width, height) {
        let (own_width, own_height) = motion.size();
        let allowed = format!("{width} x {height} pixels, as the frame");
        return Err(Error::parameter("motion", format!("{own_width} x {own_height}"), allowed));
    }
    let (mut nearest, mut bilinear, mut pixels) = (0.0, 0.0, 0);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|&(x, y)| frame.is_inside(x, y)) {
        let (Some((to_x, to_y)), Some(place)) = (motion.pixel(x, y), motion.place(x, y)) else { continue };
        let Some(between) = interpolated(next, place) else { continue };
        let color = color(frame, x, y);
        nearest += difference(color, self::color(next, to_x, to_y));
        bilinear += difference(color, between);
        pixels += 1;
    }
    if pixels == 0 {
        return Err(Error::parameter("number of surface points that both frames show", 0, "at least 1"));
    }
    let mean = |sum: f64| sum / pixels as f64;
    Ok(FrameDifference { nearest: mean(nearest), bilinear: mean(bilinear), pixels })
}

fn color(picture: &Picture, x: u32, y: u32) -> [f64; 3] {
    let [red, green, blue, _] = picture.pixels()[(y * picture.width() + x) as usize];
    [red, green, blue].map(|value| f64::from(value) / 255.0)
}

fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / 3.0
}

/// The colour at a place between pixels; `None` where a pixel that counts for it is not inside.
fn interpolated(picture: &Picture, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
    let mut sum = [0.0; 3];
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let (to_x, to_y) = (x.floor() + dx, y.floor() + dy);
        let weight = (1.0 - (x - to_x).abs()) * (1.0 - (y - to_y).abs());
        if weight == 0.0 {
            continue;
        }
        let (width, height) = (f64::from(picture.width()), f64::from(picture.height()));
        if to_x < 0.0 || to_y < 0.0 || to_x >= width || to_y >= height {
            return None;
        }
        let (to_x, to_y) = (to_x as u32, to_y as u32);
        if !picture.is_inside(to_x, to_y) {
            return None;
        }
        sum.iter_mut().zip(color(picture, to_x, to_y)).for_each(|(sum, value)| *sum += weight * value);
    }
    Some(sum)
}
