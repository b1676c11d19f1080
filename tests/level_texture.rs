//! The file of a paint's levels: it gives back what was put in, it is what KTX 2.0 says, and no bytes make it panic.
//! The files are looked at here by the offsets of the KTX 2.0 specification, not with the crate that writes them.

use impasto::paint::{PaintSample, Trajectory, TrajectoryOptions};
use impasto::technique::aligned::LevelTexture;
use impasto::Error;
use std::path::Path;

const SIZE: u32 = 16;
const LEVELS: u32 = 3;
/// Where the header's fields lie: KTX 2.0, section 3.
const FORMAT: usize = 12;
const TYPE_SIZE: usize = 16;
const WIDTH: usize = 20;
const HEIGHT: usize = 24;
const DEPTH: usize = 28;
const LAYERS: usize = 32;
const FACES: usize = 36;
const MIPS: usize = 40;
const SCHEME: usize = 44;
const DFD_OFFSET: usize = 48;
const DFD_LENGTH: usize = 52;
const KVD_OFFSET: usize = 56;
const KVD_LENGTH: usize = 60;
const LEVEL_OFFSET: usize = 80;
const LEVEL_LENGTH: usize = 88;
const LEVEL_UNCOMPRESSED: usize = 96;

fn texels(size: u32, levels: u32) -> Vec<[u8; 4]> {
    (0..levels * size * size).map(|i| [i as u8, (i / 7) as u8, (i * 31) as u8, 255]).collect()
}

fn colors() -> Vec<[f32; 3]> {
    vec![[0.0, 0.1, 0.25], [0.3, f32::MIN_POSITIVE, 0.5], [0.75, 0.9, 1.0]]
}

fn texture() -> LevelTexture {
    let trajectory = Trajectory::from_colors(colors()).expect("colours");
    LevelTexture::new(SIZE, LEVELS, texels(SIZE, LEVELS), trajectory).expect("a texture")
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

fn long(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

/// A texture's file with one word changed.
fn with(at: usize, value: u32) -> Vec<u8> {
    let mut bytes = texture().to_ktx2();
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    bytes
}

/// Where the value of a key lies, of which the length is written before it.
fn value_at(bytes: &[u8], key: &str) -> usize {
    let key = [key.as_bytes(), b"\0"].concat();
    bytes.windows(key.len()).position(|window| window == key).expect("the key") + key.len()
}

/// A texture's file with a value replaced by another one; the parts after it move.
fn with_value(key: &str, value: &[u8]) -> Vec<u8> {
    let mut bytes = texture().to_ktx2();
    let at = value_at(&bytes, key);
    let start = at - key.len() - 1;
    let old = word(&bytes, start - 4) as usize;
    let mut entry = ((key.len() + 1 + value.len()) as u32).to_le_bytes().to_vec();
    entry.extend([key.as_bytes(), b"\0", value].concat());
    entry.resize(entry.len().next_multiple_of(4), 0);
    let range = start - 4..start + old.next_multiple_of(4);
    let grown = entry.len() as i64 - range.len() as i64;
    bytes.splice(range, entry);
    let length = (i64::from(word(&bytes, KVD_LENGTH)) + grown) as u32;
    bytes[KVD_LENGTH..KVD_LENGTH + 4].copy_from_slice(&length.to_le_bytes());
    let offset = long(&bytes, LEVEL_OFFSET) as i64 + grown;
    bytes[LEVEL_OFFSET..LEVEL_OFFSET + 8].copy_from_slice(&offset.to_le_bytes());
    bytes
}

/// What is said of bytes that are refused, which starts with the file's name.
fn refusal(bytes: &[u8]) -> String {
    let error = LevelTexture::from_ktx2(bytes, Path::new("some paint.ktx2")).expect_err("bytes to refuse");
    assert!(matches!(error, Error::File { .. }), "{error:?}");
    let text = error.to_string();
    text.strip_prefix("some paint.ktx2: ").unwrap_or_else(|| panic!("{text}")).to_owned()
}

#[track_caller]
fn assert_refused(bytes: &[u8], part: &str) {
    let text = refusal(bytes);
    assert!(text.contains(part), "{text}");
}

#[test]
fn what_is_written_is_read() {
    for (size, levels, colors) in [(16, 1, vec![[0.5; 3]]), (16, 64, colors()), (37, 8, vec![[1.0, -0.0, 0.0]; 65536])]
    {
        let trajectory = Trajectory::from_colors(colors).expect("colours");
        let texture = LevelTexture::new(size, levels, texels(size, levels), trajectory.clone()).expect("a texture");
        assert_eq!((texture.size_px(), texture.levels()), (size, levels));
        assert_eq!(texture.texels(), texels(size, levels));
        assert_eq!(texture.trajectory(), &trajectory);
        let bytes = texture.to_ktx2();
        assert!(LevelTexture::is_ktx2(&bytes));
        assert_eq!(LevelTexture::from_ktx2(&bytes, Path::new("x")).expect("a texture"), texture);
        assert_eq!(bytes, texture.clone().to_ktx2());
    }
}

#[test]
fn a_trajectory_drawn_from_a_strip_survives_too() {
    let pixels = (0..32).map(|x| [x as f32 / 31.0; 3]).collect();
    let strip = PaintSample::from_pixels(32, 1, pixels).expect("a strip");
    let trajectory = Trajectory::extract(&strip, &TrajectoryOptions::default()).expect("a trajectory");
    assert!(!trajectory.kept_columns().is_empty());
    let texture = LevelTexture::new(SIZE, 1, texels(SIZE, 1), trajectory.clone()).expect("a texture");
    let read = LevelTexture::from_ktx2(&texture.to_ktx2(), Path::new("x")).expect("a texture");
    assert_eq!(read, texture);
    assert_eq!(read.trajectory().colors(), trajectory.colors());
}

#[test]
fn files_are_loaded() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("a paint.ktx2");
    std::fs::write(&path, texture().to_ktx2()).expect("a file");
    assert_eq!(LevelTexture::load(&path).expect("a texture"), texture());

    let missing = LevelTexture::load(dir.path().join("none.ktx2")).expect_err("no file");
    assert!(matches!(missing, Error::Io { .. }) && missing.to_string().contains("none.ktx2"), "{missing}");
    assert!(LevelTexture::load(dir.path()).is_err());

    let file = std::fs::OpenOptions::new().write(true).open(&path).expect("the file");
    file.set_len(LevelTexture::MAX_FILE_BYTES + 1).expect("a hole in the file");
    let large = LevelTexture::load(&path).expect_err("a large file").to_string();
    assert!(large.contains("a paint.ktx2") && large.contains("larger than"), "{large}");
}

#[test]
fn the_header_is_that_of_a_volume() {
    let bytes = texture().to_ktx2();
    assert_eq!(bytes[..12], [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n']);
    let fields = [FORMAT, TYPE_SIZE, WIDTH, HEIGHT, DEPTH, LAYERS, FACES, MIPS, SCHEME].map(|at| word(&bytes, at));
    assert_eq!(fields, [37, 1, SIZE, SIZE, LEVELS, 0, 1, 1, 0]);
    // No supercompression global data.
    assert_eq!((long(&bytes, 64), long(&bytes, 72)), (0, 0));
    // The parts lie one behind the other and fill the file.
    assert_eq!((word(&bytes, DFD_OFFSET), word(&bytes, DFD_LENGTH)), (104, 92));
    assert_eq!(word(&bytes, KVD_OFFSET), 196);
    let texels_at = 196 + u64::from(word(&bytes, KVD_LENGTH));
    assert_eq!(long(&bytes, LEVEL_OFFSET), texels_at);
    assert_eq!(texels_at % 4, 0);
    let length = u64::from(LEVELS * SIZE * SIZE * 4);
    assert_eq!((long(&bytes, LEVEL_LENGTH), long(&bytes, LEVEL_UNCOMPRESSED)), (length, length));
    assert_eq!(bytes.len() as u64, texels_at + length);
    assert_eq!(bytes[texels_at as usize..], *texels(SIZE, LEVELS).as_flattened());
}

#[test]
fn the_data_format_is_that_of_linear_rgba() {
    let bytes = texture().to_ktx2();
    let words: Vec<u32> = (104..196).step_by(4).map(|at| word(&bytes, at)).collect();
    // Total size; vendor Khronos and type basic; version 2 and block size 24 + 16 * 4; RGBSDA, BT.709, linear, straight
    // alpha; a texel block of 1; 4 bytes in plane 0.
    assert_eq!(words[..7], [92, 0, 2 | 88 << 16, 0x0001_0101, 0, 4, 0]);
    for (sample, channel) in words[7..].chunks(4).zip([0, 1, 2, 15]) {
        let offset = if channel == 15 { 24 } else { channel * 8 };
        // Bit offset, bits less one, channel; position; the values of 0 and 1.
        assert_eq!(sample, [offset | 7 << 16 | channel << 24, 0, 0, 255]);
    }
}

#[test]
fn the_entries_are_sorted_and_padded() {
    let bytes = texture().to_ktx2();
    let (mut at, end) = (196, 196 + word(&bytes, KVD_LENGTH) as usize);
    let mut entries = Vec::new();
    while at < end {
        let length = word(&bytes, at) as usize;
        let entry = &bytes[at + 4..at + 4 + length];
        let nul = entry.iter().position(|&byte| byte == 0).expect("the key's end");
        entries.push((&entry[..nul], &entry[nul + 1..]));
        let next = at + 4 + length.next_multiple_of(4);
        assert!(bytes[at + 4 + length..next].iter().all(|&byte| byte == 0));
        at = next;
    }
    assert_eq!(at, end);
    let writer = format!("impasto {}\0", env!("CARGO_PKG_VERSION"));
    let floats: Vec<u8> = colors().as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let expected: [(&[u8], &[u8]); 4] = [
        (b"KTXorientation", b"rdi\0"),
        (b"KTXwriter", writer.as_bytes()),
        (b"impastoLevels", b"1\0"),
        (b"impastoTrajectory", &floats),
    ];
    assert_eq!(entries, expected);
    assert!(entries.is_sorted());
}

#[test]
fn no_part_of_a_file_is_enough() {
    let bytes = texture().to_ktx2();
    for length in 0..bytes.len() {
        let text = refusal(&bytes[..length]);
        let expected = if length < 12 { "is not a KTX2 file" } else { "is truncated" };
        assert!(text.contains(expected), "{length}: {text}");
    }
}

#[test]
fn no_change_of_a_byte_panics() {
    let bytes = texture().to_ktx2();
    for at in 0..400 {
        for value in [0, 1, 0x7f, 0x80, 0xfe, 0xff, bytes[at] ^ 0xff, bytes[at] ^ 1, bytes[at].wrapping_add(1)] {
            let mut changed = bytes.clone();
            changed[at] = value;
            if let Ok(texture) = LevelTexture::from_ktx2(&changed, Path::new("x")) {
                assert_eq!((texture.size_px(), texture.levels()), (SIZE, LEVELS), "byte {at} = {value}");
            }
        }
    }
}

#[test]
fn huge_lengths_are_refused() {
    for at in (DFD_OFFSET..=KVD_LENGTH).step_by(4).chain((LEVEL_OFFSET..104).step_by(4)) {
        for value in [u32::MAX, u32::MAX - 3, 1 << 31] {
            refusal(&with(at, value));
        }
    }
    // An offset that the length wraps around.
    let mut bytes = texture().to_ktx2();
    bytes[LEVEL_OFFSET..LEVEL_OFFSET + 8].copy_from_slice(&(u64::MAX - 8).to_le_bytes());
    assert_refused(&bytes, "is truncated");
    // A key/value length that would reach far beyond the section.
    let at = value_at(&texture().to_ktx2(), "KTXorientation") - 15 - 4;
    refusal(&with(at, u32::MAX));
}

#[test]
fn other_files_are_refused_by_name() {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(16, 16).write_to(&mut png, image::ImageFormat::Png).expect("a picture");
    for bytes in [&png.into_inner()[..], b"", b"s,r,g,b\n0,0,0,0\n", &[0; 300]] {
        assert!(!LevelTexture::is_ktx2(bytes));
        assert_refused(bytes, "is not a KTX2 file");
    }
    // KTX 1.1
    assert_refused(b"\xabKTX 11\xbb\r\n\x1a\n", "is not a KTX2 file");
}

#[test]
fn other_versions_are_refused() {
    for value in [&b"2\0"[..], b"2", b"37\0"] {
        assert_refused(&with_value("impastoLevels", value), "was made by a later version");
    }
    for value in [&b"0\0"[..], b"", b"\0", b"one\0", b"-1\0", b"1\0\0", b"99999999999\0", b"\xff\xff"] {
        assert_refused(&with_value("impastoLevels", value), "is no version of its format");
    }
    LevelTexture::from_ktx2(&with_value("impastoLevels", b"1"), Path::new("x")).expect("a version without its NUL");
    // A later version may be of another format: that it is later is what matters.
    let mut later = with_value("impastoLevels", b"2\0");
    later[FORMAT] = 43;
    assert_refused(&later, "was made by a later version");
    for key in ["impastoLevels", "impastoTrajectory"] {
        let mut unnamed = texture().to_ktx2();
        let at = value_at(&unnamed, key) - 2;
        unnamed[at] = b'?';
        assert_refused(&unnamed, &format!("has no entry {key}"));
    }
}

#[test]
fn other_textures_are_refused() {
    for (at, value, part) in [
        (FORMAT, 43, "vkFormat 43"),
        (FORMAT, 0, "vkFormat 0"),
        (TYPE_SIZE, 4, "typeSize 4"),
        (WIDTH, 0, "zero pixel width"),
        (WIDTH, 17, "must be square"),
        (HEIGHT, 0, "1D or 2D"),
        (HEIGHT, 32, "must be square"),
        (DEPTH, 0, "1D or 2D"),
        (DEPTH, 2, "3072 bytes of texels"),
        (DEPTH, 4, "4 levels of 16 x 16 are 4096"),
        (DEPTH, 65, "levels is 65, but must be 1 to 64"),
        (DEPTH, u32::MAX, "levels is 4294967295"),
        (LAYERS, 1, "array of 1 layers"),
        (FACES, 0, "zero face count"),
        (FACES, 6, "6 faces"),
        (MIPS, 0, "0 mip levels"),
        (MIPS, 5, "5 mip levels"),
        (SCHEME, 2, "supercompressed (scheme 2)"),
        (LEVEL_LENGTH, 3068, "3068 bytes of texels"),
        (LEVEL_UNCOMPRESSED, 0, "0 uncompressed"),
        (DFD_LENGTH, 76, "data format descriptor"),
        // Texel blocks of 256, which no descriptor can mean.
        (120, u32::MAX, "data format descriptor"),
    ] {
        assert_refused(&with(at, value), part);
    }
    for size in [0u32, 8, 15, 2049, u32::MAX] {
        let mut bytes = with(WIDTH, size);
        bytes[HEIGHT..HEIGHT + 4].copy_from_slice(&size.to_le_bytes());
        let part = if size == 0 { "zero pixel width" } else { "must be 16 to 2048" };
        assert_refused(&bytes, part);
    }
    let mut clear = texture().to_ktx2();
    *clear.last_mut().expect("an alpha") = 254;
    assert_refused(&clear, "alpha 254");
}

#[test]
fn other_trajectories_are_refused() {
    let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    for length in [0, 4, 11, 13, 12 * 65537] {
        let part = format!("(impastoTrajectory) of {length} bytes");
        assert_refused(&with_value("impastoTrajectory", &vec![0; length]), &part);
    }
    for value in [1.001, -0.001, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_refused(&with_value("impastoTrajectory", &floats(&[0.0, 1.0, 0.5, 0.5, value, 0.5])), "out of range");
    }
    let read = LevelTexture::from_ktx2(&with_value("impastoTrajectory", &floats(&[0.0, 1.0, 0.25])), Path::new("x"));
    assert_eq!(read.expect("a texture").trajectory().colors(), [[0.0, 1.0, 0.25]]);
}

#[test]
fn parts_out_of_range_are_refused() {
    let one = || Trajectory::from_colors(vec![[0.5; 3]]).expect("a colour");
    let refused = |size, levels, texels, trajectory, part: &str| {
        let error = LevelTexture::new(size, levels, texels, trajectory).expect_err("parts to refuse");
        assert!(matches!(error, Error::Parameter { .. }), "{error:?}");
        assert!(error.to_string().contains(part), "{error}");
    };
    for size in [0, 15, 2049, u32::MAX] {
        refused(size, 1, Vec::new(), one(), "must be 16 to 2048");
    }
    for levels in [0, 65, u32::MAX] {
        refused(16, levels, Vec::new(), one(), "must be 1 to 64");
    }
    refused(2048, 64, Vec::new(), one(), "268435456 texels");
    refused(16, 2, texels(16, 1), one(), "2 * 16 * 16 = 512 texels");
    refused(16, 1, vec![[128, 128, 128, 0]; 256], one(), "alpha 0");
    let many = Trajectory::from_colors(vec![[0.5; 3]; 65537]).expect("colours");
    refused(16, 1, texels(16, 1), many, "of 1 to 65536 colours");
}
