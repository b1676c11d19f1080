//! FLIP: what a person sees who flips between two frames.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström and M. Fairchild, "FLIP: A Difference Evaluator
//! for Alternating Images" (HPG 2020). Colours are filtered as far as the eye cannot resolve them, compared in a
//! perceptual space, and differences weigh more where edges or points come or go. The other measures look at a texture
//! as a whole; this one at every pixel, so that it says how much of a frame changed, and where.
//!
//! The computation is NVIDIA's own, by the crate `nv-flip`. Its C++ is what keeps this module to builds with the
//! feature `cli`. Unlike elsewhere in the crate, stored values are read as sRGB, since FLIP is about what a display
//! shows.

use super::Picture;
use crate::{Error, Result};
use nv_flip::FlipImageRgb8;

/// The most pixels of a frame, enough for 8K: the C++ code takes some hundred bytes for each and ends the process where
/// there are none left.
const MAX_PIXELS: usize = 1 << 25;

/// What stands where a frame has no paint: grey, as far from dark paint as from light.
const OUTSIDE: [u8; 3] = [128; 3];

/// How frames are looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlipParams {
    /// Pixels in a degree of the visual field, 1 to 256: the more, the less of fine detail is seen.
    pub pixels_per_degree: f32,
}

impl Default for FlipParams {
    /// The paper's: a 4K display 0.7 m wide, seen from 0.7 m.
    fn default() -> Self {
        FlipParams { pixels_per_degree: nv_flip::DEFAULT_PIXELS_PER_DEGREE }
    }
}

/// The visible error between two frames.
#[derive(Debug, Clone, PartialEq)]
pub struct FlipErrors {
    /// The mean error of the pixels that are inside in at least one of the frames, 0 to 1.
    pub mean: f64,
    /// The error of every pixel, 0 (the same) to 1, row by row from the top; 0 where both frames are outside.
    pub map: Vec<f32>,
}

/// Compares two frames of one size. Exchanging them changes nothing.
///
/// # Errors
/// [`Error::Parameter`] for a parameter outside of its range, frames of different sizes or of more than 33,554,432
/// pixels, and where no pixel of either frame is inside.
pub fn flip(first: &Picture, second: &Picture, params: &FlipParams) -> Result<FlipErrors> {
    if !(1.0..=256.0).contains(&params.pixels_per_degree) {
        return Err(Error::parameter("pixels_per_degree", params.pixels_per_degree, "1 to 256"));
    }
    let size = |frame: &Picture| format!("{} x {} pixels", frame.width(), frame.height());
    if (first.width(), first.height()) != (second.width(), second.height()) {
        return Err(Error::parameter(
            "size of the second frame",
            size(second),
            format!("that of the first, {}", size(first)),
        ));
    }
    if first.pixels().len() > MAX_PIXELS {
        return Err(Error::parameter("size of the frames", size(first), format!("at most {MAX_PIXELS} pixels")));
    }
    let mut map = nv_flip::flip(rgb(first), rgb(second), params.pixels_per_degree).to_vec();
    let (mut sum, mut inside) = (0.0, 0u32);
    for (error, (a, b)) in map.iter_mut().zip(first.pixels().iter().zip(second.pixels())) {
        if a[3] == 255 || b[3] == 255 {
            *error = error.clamp(0.0, 1.0);
            sum += f64::from(*error);
            inside += 1;
        } else {
            *error = 0.0;
        }
    }
    if inside == 0 {
        return Err(Error::parameter("number of pixels inside the frames", 0, "at least 1"));
    }
    Ok(FlipErrors { mean: sum / f64::from(inside), map })
}

fn rgb(frame: &Picture) -> FlipImageRgb8 {
    let color = |&[red, green, blue, alpha]: &[u8; 4]| if alpha == 255 { [red, green, blue] } else { OUTSIDE };
    let bytes: Vec<u8> = frame.pixels().iter().flat_map(color).collect();
    FlipImageRgb8::with_data(frame.width(), frame.height(), &bytes)
}
