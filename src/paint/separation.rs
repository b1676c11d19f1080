//! Separating texture from colour and putting them together again (section 4.2 of the thesis).

use super::sample::{check_size, PaintSample};
use super::trajectory::Trajectory;
use crate::error::{Error, Result};

/// The brush texture of a sample: the sample minus its colour trajectory, each channel in -1..1.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureDifference {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl TextureDifference {
    /// Subtracts the trajectory from every pixel row of the sample: column `i` loses the trajectory's colour `i`. A
    /// trajectory of another length is resampled to the sample's width first.
    pub fn extract(sample: &PaintSample, trajectory: &Trajectory) -> Self {
        let row = trajectory.row(sample.width() as usize);
        let pixels = combine(sample.pixels(), &row, |value, color| value - color);
        Self { width: sample.width(), height: sample.height(), pixels }
    }

    /// A texture difference from its values, row by row from the top, left to right.
    ///
    /// # Errors
    /// A side of 0 or above [`MAX_SIDE_PX`](super::MAX_SIDE_PX), a wrong number of pixels, or a value that is not in
    /// -1..1.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Result<Self> {
        check_size(width, height, pixels.len())?;
        if let Some(value) = pixels.as_flattened().iter().find(|value| !(-1.0..=1.0).contains(*value)) {
            return Err(Error::parameter("pixels", value, "differences from -1 to 1"));
        }
        Ok(Self { width, height, pixels })
    }

    /// As [`TextureDifference::from_pixels`], of parts that are known to be right.
    pub(super) fn from_parts(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Self {
        Self { width, height, pixels }
    }

    /// Width in pixels, 1 to [`MAX_SIDE_PX`](super::MAX_SIDE_PX).
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels, 1 to [`MAX_SIDE_PX`](super::MAX_SIDE_PX).
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All differences, row by row from the top, left to right; each channel in -1..1.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The difference at column `x` and row `y`; outside of the picture, that of the nearest pixel.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let (x, y) = (x.min(self.width - 1) as usize, y.min(self.height - 1) as usize);
        self.pixels[y * self.width as usize + x]
    }

    /// Adds a trajectory, of this sample or any other, to every pixel row, and clips to 0..1: figure 4.4(c). A
    /// trajectory of another length is resampled to the width first.
    pub fn recombine(&self, trajectory: &Trajectory) -> PaintSample {
        let row = trajectory.row(self.width as usize);
        let pixels = combine(&self.pixels, &row, |difference, color| (difference + color).clamp(0.0, 1.0));
        PaintSample::from_parts(self.width, self.height, pixels)
    }

    /// The difference in 8 bits, -1..1 mapped linearly to 0..255 (chapter 7 of the thesis stores it so), no difference
    /// being 128; red, green, blue and 255 for every pixel, in the order of [`TextureDifference::pixels`].
    pub fn to_unorm8(&self) -> Vec<[u8; 4]> {
        let byte = |value: f32| ((value + 1.0) / 2.0 * 255.0).round() as u8;
        self.pixels.iter().map(|&[r, g, b]| [byte(r), byte(g), byte(b), 255]).collect()
    }

    /// The difference as an 8-bit picture, for writing; values as in [`TextureDifference::to_unorm8`].
    pub fn to_image(&self) -> image::RgbaImage {
        image::RgbaImage::from_raw(self.width, self.height, self.to_unorm8().into_flattened())
            .expect("a difference holds width * height pixels of four bytes each")
    }
}

/// Applies `f` to each channel of each pixel and of the row's colour in the same column.
fn combine(pixels: &[[f32; 3]], row: &[[f32; 3]], f: impl Fn(f32, f32) -> f32) -> Vec<[f32; 3]> {
    pixels.iter().zip(row.iter().cycle()).map(|(p, c)| std::array::from_fn(|k| f(p[k], c[k]))).collect()
}
