//! The paint sample of section 3.1.6 of the thesis: a strip of real paint, dark on its left, light on its right.

use crate::error::{Error, Result};

/// The largest width and the largest height of a sample, in pixels.
pub const MAX_SIDE_PX: u32 = 4096;

/// Weights of red, green and blue in the lightness of a stored (not linear) colour: luma of Rec. ITU-R BT.601.
const LUMA: [f64; 3] = [0.299, 0.587, 0.114];
/// A change of lightness over a whole side below which nothing is said of a strip's direction.
const CLEAR_CHANGE: f64 = 0.1;

/// A picture of paint: `width * height` colours, each channel in 0..1.
///
/// The values are the file's own RGB values scaled to 0..1; nothing is linearised. As a strip it holds a colour
/// transition from dark (left) to light (right) and a brush texture upon it; as a quilt sample it is just a texture.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintSample {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

/// Signs that a strip does not go from dark on the left to light on the right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum StripHint {
    /// The strip grows darker from left to right: it wants mirroring.
    LightToDark,
    /// The strip is taller than wide, and its light changes from top to bottom: it wants turning.
    StoodOnEnd,
}

impl std::fmt::Display for StripHint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            StripHint::LightToDark => "the strip grows darker from left to right, but dark belongs on the left",
            StripHint::StoodOnEnd => "the strip stands on end, but its light should change from left to right",
        })
    }
}

impl PaintSample {
    /// A sample from its colours, row by row from the top, left to right.
    ///
    /// # Errors
    /// A side of 0 or above [`MAX_SIDE_PX`], a wrong number of pixels, or a value that is not in 0..1.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Result<Self> {
        check_size(width, height, pixels.len())?;
        if let Some(value) = pixels.as_flattened().iter().find(|value| !(0.0..=1.0).contains(*value)) {
            return Err(Error::parameter("pixels", value, "colours with channels from 0 to 1"));
        }
        Ok(Self { width, height, pixels })
    }

    /// As [`PaintSample::from_pixels`], of parts that are known to be right.
    pub(super) fn from_parts(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Self {
        Self { width, height, pixels }
    }

    /// Width in pixels, 1 to [`MAX_SIDE_PX`].
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels, 1 to [`MAX_SIDE_PX`].
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All colours, row by row from the top, left to right; each channel in 0..1.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The colour at column `x` and row `y` (row 0 is the top one); outside of the picture, that of the nearest pixel.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let (x, y) = (x.min(self.width - 1) as usize, y.min(self.height - 1) as usize);
        self.pixels[y * self.width as usize + x]
    }

    /// The mean colour of every pixel column, `width` of them: the unsorted colour trajectory of section 4.1.
    pub fn column_means(&self) -> Vec<[f32; 3]> {
        let mut sums = vec![[0.0f64; 3]; self.width as usize];
        for row in self.pixels.chunks_exact(self.width as usize) {
            for (sum, color) in sums.iter_mut().zip(row) {
                for (sum, value) in sum.iter_mut().zip(color) {
                    *sum += f64::from(*value);
                }
            }
        }
        sums.into_iter().map(|sum| sum.map(|value| (value / f64::from(self.height)) as f32)).collect()
    }

    /// Whether the sample, taken as a strip, seems mirrored or turned; `None` where it looks right or nothing is clear.
    ///
    /// A quilt sample is no strip: there the answer means nothing.
    pub fn strip_hint(&self) -> Option<StripHint> {
        let (across, down) = (self.light_change(|x, _| (x, self.width)), self.light_change(|_, y| (y, self.height)));
        if self.height > self.width && down.abs() > CLEAR_CHANGE && down.abs() > 2.0 * across.abs() {
            Some(StripHint::StoodOnEnd)
        } else if across < -CLEAR_CHANGE {
            Some(StripHint::LightToDark)
        } else {
            None
        }
    }

    /// Change of lightness over a side: twice the second half's mean minus the first half's, which for an even ramp is
    /// last minus first. `place` tells a pixel's place along the side, and the side's length.
    fn light_change(&self, place: impl Fn(u32, u32) -> (u32, u32)) -> f64 {
        let (mut sums, mut counts) = ([0.0f64; 2], [0u32; 2]);
        for (y, row) in (0u32..).zip(self.pixels.chunks_exact(self.width as usize)) {
            for (x, color) in (0u32..).zip(row) {
                let (at, length) = place(x, y);
                // The middle pixel of an odd length belongs to neither half.
                let half = match (2 * at + 1).cmp(&length) {
                    std::cmp::Ordering::Less => 0,
                    std::cmp::Ordering::Equal => continue,
                    std::cmp::Ordering::Greater => 1,
                };
                sums[half] += color.iter().zip(LUMA).map(|(value, weight)| f64::from(*value) * weight).sum::<f64>();
                counts[half] += 1;
            }
        }
        if counts[0] == 0 {
            return 0.0;
        }
        2.0 * (sums[1] / f64::from(counts[1]) - sums[0] / f64::from(counts[0]))
    }

    /// The sample in 8 bits: red, green, blue and 255 for every pixel, in the order of [`PaintSample::pixels`].
    pub fn to_rgba8(&self) -> Vec<[u8; 4]> {
        let byte = |value: f32| (value * 255.0).round() as u8;
        self.pixels.iter().map(|&[r, g, b]| [byte(r), byte(g), byte(b), 255]).collect()
    }

    /// The sample as an 8-bit picture, for writing.
    pub fn to_image(&self) -> image::RgbaImage {
        image::RgbaImage::from_raw(self.width, self.height, self.to_rgba8().into_flattened())
            .expect("a sample holds width * height pixels of four bytes each")
    }
}

/// Checks the sides of a picture, and that it has `pixels` pixels.
pub(super) fn check_size(width: u32, height: u32, pixels: usize) -> Result<()> {
    for (name, side) in [("width", width), ("height", height)] {
        if !(1..=MAX_SIDE_PX).contains(&side) {
            return Err(Error::parameter(name, side, format!("1 to {MAX_SIDE_PX} pixels")));
        }
    }
    let expected = width as usize * height as usize;
    if pixels != expected {
        return Err(Error::parameter("pixels", pixels, format!("{expected} colours ({width} x {height})")));
    }
    Ok(())
}
