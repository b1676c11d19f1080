//! The shade that each pixel should have (section 9.2).

use crate::paint::{decode_picture, read_picture};
use crate::Result;
use std::path::Path;

/// A picture of shades, 0 dark to 1 light; none where the picture has none.
#[derive(Debug, Clone, PartialEq)]
pub struct Shades {
    width: u32,
    values: Vec<Option<f64>>,
}

impl Shades {
    /// Shades, row by row from the top.
    pub fn new(width: u32, values: Vec<Option<f64>>) -> Self {
        Shades { width: width.max(1), values }
    }

    /// Reads a grey picture of 8 or 16 bits; of a coloured one, its luminance. Pixels that are not opaque have no
    /// shade.
    ///
    /// # Errors
    /// As [`crate::paint::PaintSample::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let picture = decode_picture(&read_picture(path)?, path)?.to_luma_alpha16();
        let shade = |[value, alpha]: [u16; 2]| (alpha == u16::MAX).then(|| f64::from(value) / f64::from(u16::MAX));
        Ok(Shades::new(picture.width(), picture.pixels().map(|pixel| shade(pixel.0)).collect()))
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.values.len() as u32 / self.width)
    }

    /// The shade at a pixel; none outside of the picture either.
    pub fn at(&self, x: u32, y: u32) -> Option<f64> {
        let inside = x < self.width;
        self.values.get((y * self.width + x) as usize).copied().flatten().filter(|_| inside)
    }
}
