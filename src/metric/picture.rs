//! What is measured: a picture of 8-bit colours, and which of its pixels count.

use crate::{Error, Result};

/// The longest side of a picture that is measured, pixels.
pub const MAX_PICTURE_SIDE_PX: u32 = 16_384;

/// A picture: rows from top to bottom, pixels from left to right.
///
/// Colours are the file's own values, as everywhere. A pixel belongs to the object where its alpha is 255; what is
/// translucent there is mixed with a background that the paint does not know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Picture {
    /// A picture of `width` x `height` pixels, RGBA.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a side out of 1 to [`MAX_PICTURE_SIDE_PX`], or another number of pixels.
    pub fn new(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Result<Self> {
        for (name, side) in [("picture width", width), ("picture height", height)] {
            if !(1..=MAX_PICTURE_SIDE_PX).contains(&side) {
                return Err(Error::parameter(name, side, format!("1 to {MAX_PICTURE_SIDE_PX} pixels")));
            }
        }
        if pixels.len() != width as usize * height as usize {
            return Err(Error::parameter("pixels of a picture", pixels.len(), format!("{width} x {height}")));
        }
        Ok(Picture { width, height, pixels })
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, RGBA.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// Whether the pixel belongs to the object.
    pub fn is_inside(&self, x: u32, y: u32) -> bool {
        self.pixels[(y * self.width + x) as usize][3] == 255
    }
}
