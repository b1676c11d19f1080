//! Reading a picture file into a [`PaintSample`]: every format becomes plain RGB on white paper, upright.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageFormat, ImageReader, Limits, Pixel, Primitive};

use super::sample::{PaintSample, MAX_SIDE_PX};
use crate::error::{Error, Result};

/// The largest file that is read: no picture within [`MAX_SIDE_PX`] needs more.
const MAX_FILE_BYTES: u64 = 256 << 20;
/// What a decoder may allocate.
const MAX_DECODER_BYTES: u64 = 256 << 20;

impl PaintSample {
    /// Reads a picture file: PNG, JPEG, BMP, GIF (its first frame) or TIFF, whatever the file is called.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read, otherwise as [`PaintSample::decode`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::decode(&read_picture(path)?, path)
    }

    /// Decodes a picture file in memory; `name` is what an error calls it.
    ///
    /// The colours are the file's own RGB values scaled to 0..1, from 16-bit files with all their bits. Grey and
    /// palette files become RGB, transparent parts show white paper, the EXIF orientation is applied.
    ///
    /// # Errors
    /// [`Error::File`] with the name: an unknown format, a damaged or truncated file, no pixels, more than
    /// [`MAX_SIDE_PX`] pixels on a side (found before anything is allocated), values that are not numbers.
    pub fn decode(bytes: &[u8], name: &Path) -> Result<Self> {
        let picture = decode_picture(bytes, name)?;
        let fail = |reason: String| Error::file(name, reason);
        let pixels = on_white_paper(&picture).ok_or_else(|| fail("holds values that are not numbers".into()))?;
        Self::from_pixels(picture.width(), picture.height(), pixels).map_err(|error| fail(error.to_string()))
    }
}

/// Reads a picture file as [`decode_picture`] takes it.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; a larger one than is decoded is read no further.
pub(crate) fn read_picture(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|source| Error::io(path, source))?;
    Ok(bytes)
}

/// Decodes a picture file in memory, upright.
///
/// # Errors
/// As [`PaintSample::decode`], but for values that are not numbers.
pub(crate) fn decode_picture(bytes: &[u8], name: &Path) -> Result<DynamicImage> {
    let fail = |reason: String| Error::file(name, reason);
    if bytes.is_empty() {
        return Err(fail("the file is empty".into()));
    }
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(fail(format!("larger than the {} MiB that are read", MAX_FILE_BYTES >> 20)));
    }
    let format = image::guess_format(bytes).map_err(|_| fail("not a PNG, JPEG, BMP, GIF or TIFF file".into()))?;
    // The JPEG decoder fills what is missing at the end with grey, and reports success.
    if format == ImageFormat::Jpeg && !jpeg_has_end(bytes) {
        return Err(fail("the JPEG data end too early: the file is truncated".into()));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|error| fail(error.to_string()))?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        return Err(fail(format!("{width} x {height} pixels, but a side must have 1 to {MAX_SIDE_PX}")));
    }
    // A damaged EXIF block is no reason to refuse a picture.
    let orientation = decoder.orientation().unwrap_or(image::metadata::Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|error| fail(error.to_string()))?;
    picture.apply_orientation(orientation);
    Ok(picture)
}

/// All pixels as RGB in 0..1 over white; `None` if a value is not a number.
fn on_white_paper(picture: &DynamicImage) -> Option<Vec<[f32; 3]>> {
    match picture {
        DynamicImage::ImageLuma8(buffer) => composite(buffer),
        DynamicImage::ImageLumaA8(buffer) => composite(buffer),
        DynamicImage::ImageRgb8(buffer) => composite(buffer),
        DynamicImage::ImageRgba8(buffer) => composite(buffer),
        DynamicImage::ImageLuma16(buffer) => composite(buffer),
        DynamicImage::ImageLumaA16(buffer) => composite(buffer),
        DynamicImage::ImageRgb16(buffer) => composite(buffer),
        DynamicImage::ImageRgba16(buffer) => composite(buffer),
        DynamicImage::ImageRgb32F(buffer) => composite(buffer),
        DynamicImage::ImageRgba32F(buffer) => composite(buffer),
        // The enum may grow; whatever comes is at most as precise as this.
        other => composite(&other.to_rgba32f()),
    }
}

fn composite<P>(buffer: &ImageBuffer<P, Vec<P::Subpixel>>) -> Option<Vec<[f32; 3]>>
where
    P: Pixel,
    P::Subpixel: Into<f32>,
{
    let full: f32 = P::Subpixel::DEFAULT_MAX_VALUE.into();
    buffer
        .pixels()
        .map(|pixel| {
            let [r, g, b, alpha] = pixel.to_rgba().0.map(|value| value.into() / full);
            let color = [r, g, b].map(|value| (value * alpha + (1.0 - alpha)).clamp(0.0, 1.0));
            (!color.iter().any(|value| value.is_nan())).then_some(color)
        })
        .collect()
}

/// Whether a JPEG file reaches its end-of-image marker (ITU-T T.81, annex B): walks the marker segments by their
/// lengths, so that the marker of an embedded thumbnail does not count, and skips the entropy-coded data between.
fn jpeg_has_end(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    loop {
        match rest {
            [0xFF, 0xD9, ..] => return true,
            // Fill bytes, a stuffed zero, TEM, restart markers and SOI stand alone.
            [0xFF, 0xFF, ..] => rest = &rest[1..],
            [0xFF, 0x00 | 0x01 | 0xD0..=0xD8, ..] => rest = &rest[2..],
            [0xFF, _, high, low, ..] => {
                let length = 2 + usize::from(u16::from_be_bytes([*high, *low]));
                rest = rest.get(length..).unwrap_or_default();
            }
            [0xFF, ..] | [] => return false,
            [_, ..] => {
                let next = rest.iter().position(|&byte| byte == 0xFF);
                rest = next.map_or(&[], |next| &rest[next..]);
            }
        }
    }
}
