//! The shade that each pixel should have, from a file (section 9.2).

use crate::paint::{decode_picture, read_picture};
use crate::Result;
use std::path::Path;

/// A picture of shades, 0 dark to 1 light.
#[derive(Debug, Clone, PartialEq)]
pub struct Shades {
    width: u32,
    values: Vec<f64>,
}

impl Shades {
    /// Shades, row by row from the top.
    pub fn new(width: u32, values: Vec<f64>) -> Self {
        Shades { width: width.max(1), values }
    }

    /// Reads a grey picture of 8 or 16 bits; of a coloured one, its luminance.
    ///
    /// # Errors
    /// As [`crate::paint::PaintSample::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let picture = decode_picture(&read_picture(path)?, path)?.to_luma16();
        let values = picture.pixels().map(|pixel| f64::from(pixel.0[0]) / f64::from(u16::MAX)).collect();
        Ok(Shades { width: picture.width(), values })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.values.len() as u32 / self.width)
    }

    /// The shade at a pixel; 0 outside of the picture.
    pub fn at(&self, x: u32, y: u32) -> f64 {
        let inside = x < self.width;
        self.values.get((y * self.width + x) as usize).copied().filter(|_| inside).unwrap_or_default()
    }
}
