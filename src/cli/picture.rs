//! Encoding pictures; the file's extension says how.

use super::failure::{Failure, Result};
use image::{DynamicImage, GrayAlphaImage, ImageFormat, RgbImage, RgbaImage};
use std::io::Cursor;
use std::path::Path;

/// The file formats that pictures are written in.
const FORMATS: [(&str, ImageFormat); 6] = [
    ("png", ImageFormat::Png),
    ("jpg", ImageFormat::Jpeg),
    ("jpeg", ImageFormat::Jpeg),
    ("bmp", ImageFormat::Bmp),
    ("tif", ImageFormat::Tiff),
    ("tiff", ImageFormat::Tiff),
];

/// What a file name's extension stands for.
pub fn format_of(path: &Path) -> Result<ImageFormat> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let found = FORMATS.iter().find(|(name, _)| *name == extension);
    found.map(|(_, format)| *format).ok_or_else(|| {
        let names: Vec<&str> = FORMATS.iter().map(|(name, _)| *name).collect();
        Failure::file(path, format!("the name of a picture must end in one of .{}", names.join(", .")))
    })
}

/// Encodes a picture with straight alpha. JPEG knows no alpha: there it lies on white.
pub fn encode(picture: RgbaImage, format: ImageFormat) -> Result<Vec<u8>> {
    let picture = match format {
        ImageFormat::Jpeg => {
            let flat = over(picture, [255; 3]);
            let rgb = RgbImage::from_fn(flat.width(), flat.height(), |x, y| {
                let [r, g, b, _] = flat.get_pixel(x, y).0;
                image::Rgb([r, g, b])
            });
            DynamicImage::ImageRgb8(rgb)
        }
        _ => DynamicImage::ImageRgba8(picture),
    };
    write(&picture, format)
}

/// Encodes an opaque or transparent picture as PNG.
pub fn png(picture: RgbaImage) -> Result<Vec<u8>> {
    encode(picture, ImageFormat::Png)
}

/// Encodes grey values with alpha as PNG.
pub fn gray_png(picture: GrayAlphaImage) -> Result<Vec<u8>> {
    write(&DynamicImage::ImageLumaA8(picture), ImageFormat::Png)
}

/// Encodes 16-bit colours as PNG.
pub fn png16(width: u32, height: u32, pixels: &[[u16; 3]]) -> Result<Vec<u8>> {
    let picture = image::ImageBuffer::from_raw(width, height, pixels.as_flattened().to_vec())
        .ok_or_else(|| Failure::new(format!("no picture of {width}x{height} pixels")))?;
    write(&DynamicImage::ImageRgb16(picture), ImageFormat::Png)
}

fn write(picture: &DynamicImage, format: ImageFormat) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).map_err(|error| Failure::new(format!("encoding the picture: {error}")))?;
    Ok(bytes.into_inner())
}

/// Lays a picture over one colour.
pub fn over(mut picture: RgbaImage, background: [u8; 3]) -> RgbaImage {
    for pixel in picture.pixels_mut() {
        let alpha = u32::from(pixel.0[3]);
        for (value, below) in pixel.0.iter_mut().zip(background) {
            *value = ((u32::from(*value) * alpha + u32::from(below) * (255 - alpha) + 127) / 255) as u8;
        }
        pixel.0[3] = 255;
    }
    picture
}

/// A picture of RGBA texels, row by row from the top.
pub fn from_texels(texels: Vec<u8>, (width, height): (u32, u32)) -> Result<RgbaImage> {
    RgbaImage::from_raw(width, height, texels)
        .ok_or_else(|| Failure::new(format!("the device gave no {width}x{height} picture")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides_and_an_unknown_one_is_refused() {
        assert_eq!(format_of(Path::new("a/b.PNG")).ok(), Some(ImageFormat::Png));
        assert_eq!(format_of(Path::new("b.tif")).ok(), Some(ImageFormat::Tiff));
        for wrong in ["b", "b.gif", "png", ".png", "b.png.txt"] {
            let failure = format_of(Path::new(wrong)).expect_err(wrong);
            assert!(failure.0.starts_with(&format!("{wrong}: ")) && failure.0.contains(".png"), "{}", failure.0);
        }
    }

    #[test]
    fn half_transparent_black_over_white_is_grey() {
        let picture = RgbaImage::from_raw(3, 1, vec![0, 0, 0, 128, 9, 8, 7, 0, 9, 8, 7, 255]).expect("three pixels");
        let flat = over(picture, [255, 255, 255]);
        assert_eq!(flat.into_raw(), [127, 127, 127, 255, 255, 255, 255, 255, 9, 8, 7, 255]);
    }
}
