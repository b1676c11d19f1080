//! What is measured: a picture of 8-bit colours, and which of its pixels count.

use crate::paint::{decode_picture, read_picture};
use crate::{Error, Result};
use std::path::Path;

/// The longest side of a picture that is measured, pixels.
pub const MAX_PICTURE_SIDE_PX: u32 = 16_384;

/// The grey of a pixel in thousandths of its stored values, 0 to 255,000: 0.299 R + 0.587 G + 0.114 B, in integers.
pub(super) fn grey([red, green, blue, _]: [u8; 4]) -> u32 {
    299 * u32::from(red) + 587 * u32::from(green) + 114 * u32::from(blue)
}

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
        Self::check_sides(width, height)?;
        if pixels.len() != width as usize * height as usize {
            return Err(Error::parameter("pixels of a picture", pixels.len(), format!("{width} x {height}")));
        }
        Ok(Picture { width, height, pixels })
    }

    /// Refuses a side that no picture has, before anybody makes its pixels.
    pub(super) fn check_sides(width: u32, height: u32) -> Result<()> {
        for (name, side) in [("picture width", width), ("picture height", height)] {
            if !(1..=MAX_PICTURE_SIDE_PX).contains(&side) {
                return Err(Error::parameter(name, side, format!("1 to {MAX_PICTURE_SIDE_PX} pixels")));
            }
        }
        Ok(())
    }

    /// A picture of the same size; each pixel follows from its place, y * width + x.
    pub(super) fn map_places(&self, pixel: impl Fn(u32) -> [u8; 4]) -> Picture {
        let pixels = (0..self.pixels.len() as u32).map(pixel).collect();
        Picture { width: self.width, height: self.height, pixels }
    }

    /// Reads a picture file of any kind that paint is read from; 16-bit values are rounded to 8 bits.
    ///
    /// # Errors
    /// As [`crate::paint::PaintSample::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let picture = decode_picture(&read_picture(path)?, path)?.to_rgba8();
        let pixels = picture.pixels().map(|pixel| pixel.0).collect();
        Picture::new(picture.width(), picture.height(), pixels)
    }

    /// The picture with only those pixels inside that are so already and that are light (128 or more in green) and
    /// inside in `mask`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a mask of another size.
    pub fn masked(mut self, mask: &Picture) -> Result<Self> {
        mask.check_size("mask", self.width, self.height)?;
        for (pixel, mask) in self.pixels.iter_mut().zip(&mask.pixels) {
            if mask[1] < 128 || mask[3] != 255 {
                pixel[3] = 0;
            }
        }
        Ok(self)
    }

    /// Checks that the picture, called `name`, has a size.
    pub(crate) fn check_size(&self, name: &'static str, width: u32, height: u32) -> Result<()> {
        if (self.width, self.height) != (width, height) {
            let allowed = format!("{width} x {height} pixels, as the frame");
            return Err(Error::parameter(name, format!("{} x {}", self.width, self.height), allowed));
        }
        Ok(())
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
