//! Reading pictures as paint samples: what the values are, and that every odd file gives a sample or a clear error.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageFormat, Luma, LumaA, Rgb, RgbImage, Rgba};
use impasto::paint::{PaintSample, StripHint, MAX_SIDE_PX};

const FORMATS: [ImageFormat; 5] =
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp, ImageFormat::Gif, ImageFormat::Tiff];

fn encode(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.into().write_to(&mut bytes, format).expect("an encodable picture");
    bytes.into_inner()
}

fn decode(bytes: &[u8]) -> Result<PaintSample, String> {
    PaintSample::decode(bytes, Path::new("some file.png")).map_err(|error| {
        let text = error.to_string();
        assert!(text.starts_with("some file.png: "), "{text}");
        text
    })
}

fn pattern() -> RgbImage {
    RgbImage::from_fn(23, 17, |x, y| Rgb([x as u8 * 11, y as u8 * 15, (x * y) as u8]))
}

#[test]
fn values_are_the_files_own() {
    for format in [ImageFormat::Png, ImageFormat::Bmp, ImageFormat::Tiff] {
        let sample = decode(&encode(pattern(), format)).expect("a picture");
        assert_eq!((sample.width(), sample.height()), (23, 17));
        for (x, y, pixel) in pattern().enumerate_pixels() {
            assert_eq!(sample.pixel(x, y), pixel.0.map(|value| f32::from(value) / 255.0));
        }
        assert_eq!(sample.to_image(), DynamicImage::from(pattern()).to_rgba8());
    }
}

#[test]
fn sixteen_bits_keep_their_precision() {
    let values = [0u16, 1, 258, 40_000, 65_534, 65_535];
    let bytes = encode(image::ImageBuffer::from_fn(6, 1, |x, _| Rgb([values[x as usize]; 3])), ImageFormat::Png);
    let sample = decode(&bytes).expect("a picture");
    assert_eq!(sample.pixels(), values.map(|value| [f32::from(value) / 65_535.0; 3]));
    let bytes = encode(image::ImageBuffer::from_fn(6, 1, |x, _| Luma([values[x as usize]])), ImageFormat::Png);
    assert_eq!(decode(&bytes).expect("a picture"), sample);
}

#[test]
fn grey_becomes_rgb_and_alpha_shows_white_paper() {
    let grey = decode(&encode(image::ImageBuffer::from_fn(2, 1, |x, _| Luma([51 * x as u8])), ImageFormat::Png));
    assert_eq!(grey.expect("a picture").pixels(), [[0.0; 3], [0.2; 3]]);
    // 0.2 * 0.6 + 1 * 0.4 = 0.52.
    let half = decode(&encode(image::ImageBuffer::from_fn(1, 1, |_, _| LumaA([51u8, 153])), ImageFormat::Png));
    assert!((half.expect("a picture").pixel(0, 0)[1] - 0.52).abs() < 1e-6);
    let clear = image::ImageBuffer::from_fn(1, 1, |_, _| Rgba([200u8, 0, 0, 0]));
    for format in [ImageFormat::Png, ImageFormat::Gif] {
        assert_eq!(decode(&encode(clear.clone(), format)).expect("a picture").pixels(), [[1.0; 3]]);
    }
    let solid = decode(&encode(image::ImageBuffer::from_fn(1, 1, |_, _| Rgba([51u8, 0, 255, 255])), ImageFormat::Png));
    assert_eq!(solid.expect("a picture").pixels(), [[0.2, 0.0, 1.0]]);
}

#[test]
fn exif_orientation_is_applied() {
    // Dark on the left, light on the right; orientation 6 turns the stored picture clockwise: dark comes to the top.
    let picture = RgbImage::from_fn(32, 16, |x, _| if x < 16 { Rgb([0; 3]) } else { Rgb([255; 3]) });
    let mut jpeg = encode(picture, ImageFormat::Jpeg);
    // An APP1 segment behind SOI: "Exif", a little-endian TIFF header, and a directory with the one tag 0x0112.
    let mut exif = vec![0xFF, 0xE1, 0, 34];
    exif.extend(b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0");
    assert_eq!(exif.len(), 2 + 34, "the segment's length counts itself, but not the marker");
    jpeg.splice(2..2, exif);
    let sample = decode(&jpeg).expect("a picture");
    assert_eq!((sample.width(), sample.height()), (16, 32));
    assert!(sample.pixel(8, 2)[0] < 0.1 && sample.pixel(8, 29)[0] > 0.9);
}

#[test]
fn content_decides_the_format_and_pixels_beyond_the_border_repeat_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("really a bitmap.jpg");
    std::fs::write(&path, encode(pattern(), ImageFormat::Bmp)).expect("a writable folder");
    let sample = PaintSample::load(&path).expect("a picture");
    assert_eq!(sample.pixel(100, 100), sample.pixel(22, 16));
}

#[test]
fn errors_name_the_file_and_the_reason() {
    let missing = PaintSample::load("no such folder/strip.png").expect_err("no file").to_string();
    assert!(missing.starts_with("no such folder/strip.png: "), "{missing}");
    assert!(PaintSample::load(env!("CARGO_MANIFEST_DIR")).is_err());
    assert!(decode(b"").expect_err("no bytes").contains("empty"));
    assert!(decode(b"# a text file, not a picture\n").expect_err("text").contains("not a PNG"));
    let wide = decode(&encode(RgbImage::new(MAX_SIDE_PX + 1, 2), ImageFormat::Png)).expect_err("too wide");
    assert!(wide.contains("4097 x 2 pixels") && wide.contains("4096"), "{wide}");
    let high = decode(&encode(RgbImage::new(2, MAX_SIDE_PX + 1), ImageFormat::Gif)).expect_err("too high");
    assert!(high.contains("2 x 4097 pixels") && high.contains("4096"), "{high}");
    assert!(decode(&encode(RgbImage::new(MAX_SIDE_PX, 1), ImageFormat::Png)).is_ok());
}

#[test]
fn bad_pixels_are_refused() {
    assert!(PaintSample::from_pixels(0, 1, Vec::new()).is_err());
    assert!(PaintSample::from_pixels(1, MAX_SIDE_PX + 1, vec![[0.0; 3]; 4097]).is_err());
    assert!(PaintSample::from_pixels(2, 1, vec![[0.0; 3]]).is_err());
    for value in [-0.01, 1.01, f32::NAN, f32::INFINITY] {
        assert!(PaintSample::from_pixels(1, 1, vec![[0.5, value, 0.5]]).is_err());
    }
}

#[test]
fn a_cut_file_is_an_error_or_lacks_nothing() {
    for format in FORMATS {
        let bytes = encode(pattern(), format);
        let whole = decode(&bytes).expect("a picture");
        assert!(decode(&bytes[..bytes.len() / 2]).is_err(), "{format:?}");
        for end in 0..bytes.len() {
            // The last bytes (checksums, end markers) may be missing where all pixels are there.
            if let Ok(sample) = decode(&bytes[..end]) {
                assert_eq!(sample, whole, "{format:?} cut at {end} of {}", bytes.len());
            }
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut state = 88_172_645_463_325_252u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below
    };
    for format in FORMATS {
        let bytes = encode(pattern(), format);
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random(4) {
                let at = random(bytes.len());
                damaged[at] = [0, 255, random(256) as u8][random(3)];
            }
            if let Ok(sample) = decode(&damaged) {
                assert!(sample.pixels().as_flattened().iter().all(|value| (0.0..=1.0).contains(value)));
            }
        }
    }
}

// Real files.

fn data_folder() -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    Some(std::env::var_os("IMPASTO_DATA").map_or(beside, PathBuf::from)).filter(|folder| folder.is_dir())
}

#[test]
fn odd_images_give_a_sample_or_name_themselves() {
    let Some(folder) = data_folder() else { return eprintln!("no sample data, nothing tested") };
    let mut refused = Vec::new();
    for entry in std::fs::read_dir(folder.join("odd_images")).expect("the folder of odd images") {
        let path = entry.expect("a folder entry").path();
        match PaintSample::load(&path) {
            Ok(sample) => {
                assert_eq!(sample.pixels().len(), sample.width() as usize * sample.height() as usize);
                assert!(sample.pixels().as_flattened().iter().all(|value| (0.0..=1.0).contains(value)));
            }
            Err(error) => {
                let name = path.file_name().expect("a file").to_string_lossy().into_owned();
                assert!(error.to_string().contains(&name), "{error}");
                refused.push(name);
            }
        }
    }
    refused.sort();
    let expected = [
        "decompression_bomb.gif",
        "derived_bomb_65535.png",
        "derived_empty.png",
        "derived_strip_half_file.png",
        "truncated_image.png",
        "truncated_jpeg.jpg",
        "xhdn0g08.png",
    ];
    assert_eq!(refused, expected);
}

#[test]
fn variants_of_one_strip_look_alike() {
    let Some(folder) = data_folder() else { return eprintln!("no sample data, nothing tested") };
    let load = |name: &str| PaintSample::load(folder.join(name)).expect("a strip");
    let original = load("paint/mypaint_oil_green_yellow_512x128.png");
    for (name, tolerance) in [("16bit.png", 0.01), ("cmyk.jpg", 0.05), ("progressive.jpg", 0.05), ("palette.png", 0.05)]
    {
        let variant = load(&format!("odd_images/derived_strip_{name}"));
        assert_eq!((variant.width(), variant.height()), (512, 128));
        for (a, b) in variant.column_means().as_flattened().iter().zip(original.column_means().as_flattened()) {
            assert!((a - b).abs() < tolerance, "{name}: {a} but {b}");
        }
    }
    assert_eq!(load("odd_images/derived_strip_reversed.png").strip_hint(), Some(StripHint::LightToDark));
    assert_eq!(load("odd_images/derived_strip_vertical.png").strip_hint(), Some(StripHint::StoodOnEnd));
}
