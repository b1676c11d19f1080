//! A paint's tileable textures by level of shade, and their file.
//!
//! # The file
//!
//! A level texture is kept as a volume texture of KTX 2.0, the Khronos Group's texture container, so that common tools
//! can read it. All numbers are little-endian; the same texture and version of impasto always give the same bytes.
//!
//! | Part | Content |
//! |---|---|
//! | format | `vkFormat` 37 (`VK_FORMAT_R8G8B8A8_UNORM`), `typeSize` 1, `supercompressionScheme` 0 |
//! | shape | `pixelWidth` = `pixelHeight` = size, `pixelDepth` = levels |
//! | counts | `layerCount` 0, `faceCount` 1, `levelCount` 1 |
//! | data format | one basic block, version 2: RGBSDA, BT.709, linear, straight alpha, four samples of 8 bits |
//! | `KTXorientation` | `rdi`: texels run right, down and into the stack |
//! | `KTXwriter` | `impasto` and its version |
//! | `impastoLevels` | the version of this format as decimal text: `1` |
//! | `impastoTrajectory` | the colours, dark first: red, green and blue of each as 32-bit floats in 0..1 |
//! | texels | four bytes each, levels dark first, rows from the top, columns from the left; at a multiple of 4 |
//!
//! The texts end with a NUL, as KTX has it; a reader takes the version without one too. Red, green and blue of a texel
//! are the difference -1..1 mapped linearly to 0..255, alpha is 255. KTX's own levels are mip levels, of which there is
//! one: the levels of shade are the slices of its depth.
//!
//! Of the entries a reader needs `impastoLevels` and `impastoTrajectory`; it passes over all others.

use crate::error::{Error, Result};
use crate::paint::Trajectory;
use ktx2::{dfd, Format, Header, Index, KeyValueDataIterator, LevelIndex};
use std::io::Read;
use std::path::Path;

/// The format's version, which `impastoLevels` holds.
const FORMAT_VERSION: u32 = 1;
const VERSION_KEY: &str = "impastoLevels";
const TRAJECTORY_KEY: &str = "impastoTrajectory";
const TEXEL_BYTES: u64 = 4;
const COLOR_BYTES: usize = 12;

/// A paint prepared for view-aligned projection (chapter 7 of the thesis): a stack of tileable textures, one for each
/// level of shade, and its colours.
///
/// The textures are differences: what the paint adds to the colour that the trajectory gives for the shade. The file
/// is a KTX 2.0 volume texture: `vkFormat` R8G8B8A8_UNORM, one slice of its depth for each level, the colours in the
/// key/value entry `impastoTrajectory` and the format's version, 1, in `impastoLevels`.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelTexture {
    size_px: u32,
    levels: u32,
    texels: Vec<[u8; 4]>,
    trajectory: Trajectory,
}

impl LevelTexture {
    /// The smallest width and height, in texels.
    pub const MIN_SIZE_PX: u32 = 16;
    /// The largest width and height, in texels.
    pub const MAX_SIZE_PX: u32 = 2048;
    /// The largest number of levels of shade; the thesis has 8.
    pub const MAX_LEVELS: u32 = 64;
    /// The largest number of colours of the trajectory.
    pub const MAX_COLORS: usize = 65536;
    /// The largest file that [`LevelTexture::load`] reads: 1 GiB, which the most texels fill, and 1 MiB for the rest.
    pub const MAX_FILE_BYTES: u64 = (1 << 30) + (1 << 20);

    /// A level texture from its parts.
    ///
    /// `texels` holds `levels` squares of `size_px * size_px`, the darkest level first, each row by row from the top,
    /// left to right. Red, green and blue are the difference -1..1 mapped linearly to 0..255, as
    /// [`TextureDifference::to_unorm8`](crate::paint::TextureDifference::to_unorm8) gives it; alpha is 255. Of the
    /// trajectory only the colours are kept, not the columns that they were drawn from.
    ///
    /// # Errors
    /// A size outside of [`MIN_SIZE_PX`](Self::MIN_SIZE_PX) to [`MAX_SIZE_PX`](Self::MAX_SIZE_PX), levels outside of 1
    /// to [`MAX_LEVELS`](Self::MAX_LEVELS), a wrong number of texels, an alpha other than 255, or a trajectory of more
    /// than [`MAX_COLORS`](Self::MAX_COLORS).
    pub fn new(size_px: u32, levels: u32, texels: Vec<[u8; 4]>, trajectory: Trajectory) -> Result<Self> {
        let count = texel_count(size_px, levels)?;
        if texels.len() as u64 != count {
            let allowed = format!("{levels} * {size_px} * {size_px} = {count} texels");
            return Err(Error::parameter("texels", format!("{} texels", texels.len()), allowed));
        }
        if let Some([_, _, _, alpha]) = texels.iter().find(|texel| texel[3] != 255) {
            return Err(Error::parameter("texels", format!("alpha {alpha}"), "of alpha 255"));
        }
        if trajectory.len() > Self::MAX_COLORS {
            let allowed = format!("of 1 to {} colours", Self::MAX_COLORS);
            return Err(Error::parameter("trajectory", format!("{} colours", trajectory.len()), allowed));
        }
        // The columns of the strip mean nothing without it and are not in the file; kept, they would make a texture
        // differ from itself after it was written and read.
        let trajectory = Trajectory::from_colors(trajectory.colors().to_vec())?;
        Ok(Self { size_px, levels, texels, trajectory })
    }

    /// Width and height of every level in texels, [`MIN_SIZE_PX`](Self::MIN_SIZE_PX) to
    /// [`MAX_SIZE_PX`](Self::MAX_SIZE_PX).
    pub fn size_px(&self) -> u32 {
        self.size_px
    }

    /// The number of levels of shade, 1 to [`MAX_LEVELS`](Self::MAX_LEVELS).
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// All texels, in the order and with the values of [`LevelTexture::new`].
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// The colours that the differences are added to, 1 to [`MAX_COLORS`](Self::MAX_COLORS).
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// The bytes of the texture's file; the same texture gives the same bytes every time.
    pub fn to_ktx2(&self) -> Vec<u8> {
        let descriptor = data_format_descriptor();
        let colors: Vec<u8> =
            self.trajectory.colors().as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        // KTX wants the entries sorted by the bytes of their keys.
        let mut entries = Vec::new();
        push_entry(&mut entries, "KTXorientation", b"rdi\0");
        push_entry(&mut entries, "KTXwriter", concat!("impasto ", env!("CARGO_PKG_VERSION"), "\0").as_bytes());
        push_entry(&mut entries, VERSION_KEY, format!("{FORMAT_VERSION}\0").as_bytes());
        push_entry(&mut entries, TRAJECTORY_KEY, &colors);

        // Every part's length is a multiple of 4, so that the texels lie where KTX wants them without padding.
        let descriptor_at = Header::LENGTH + LevelIndex::LENGTH;
        let entries_at = descriptor_at + descriptor.len();
        let texels_at = entries_at + entries.len();
        let texels: &[u8] = self.texels.as_flattened();
        let header = Header {
            format: Some(Format::R8G8B8A8_UNORM),
            type_size: 1,
            pixel_width: self.size_px,
            pixel_height: self.size_px,
            pixel_depth: self.levels,
            layer_count: 0,
            face_count: 1,
            level_count: 1,
            supercompression_scheme: None,
            index: Index {
                dfd_byte_offset: descriptor_at as u32,
                dfd_byte_length: descriptor.len() as u32,
                kvd_byte_offset: entries_at as u32,
                kvd_byte_length: entries.len() as u32,
                sgd_byte_offset: 0,
                sgd_byte_length: 0,
            },
        };
        let level = LevelIndex {
            byte_offset: texels_at as u64,
            byte_length: texels.len() as u64,
            uncompressed_byte_length: texels.len() as u64,
        };
        let mut bytes = Vec::with_capacity(texels_at + texels.len());
        bytes.extend(header.as_bytes());
        bytes.extend(level.as_bytes());
        bytes.extend(descriptor);
        bytes.extend(entries);
        bytes.extend_from_slice(texels);
        bytes
    }

    /// A level texture from the bytes of its file; `name` is what error messages call them.
    ///
    /// # Errors
    /// [`Error::File`] for bytes that are no such file: no KTX2 file or a truncated one, a texture of another kind or
    /// format, one that is no level texture or one of a later version, parts out of the ranges of
    /// [`LevelTexture::new`], or colours that are not in 0..1.
    pub fn from_ktx2(bytes: &[u8], name: &Path) -> Result<Self> {
        parse(bytes).map_err(|reason| Error::file(name, reason))
    }

    /// Reads a level texture from its file.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read; [`Error::File`] when it is larger than
    /// [`MAX_FILE_BYTES`](Self::MAX_FILE_BYTES), and as [`LevelTexture::from_ktx2`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let io = |error| Error::io(path, error);
        let too_large = || Error::file(path, "is larger than 1025 MiB, the most that a level texture takes");
        let file = std::fs::File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        if length > Self::MAX_FILE_BYTES {
            return Err(too_large());
        }
        // What is no regular file, or grows meanwhile, has no true length: reading stops at the limit by itself.
        let mut bytes = Vec::with_capacity(length as usize);
        file.take(Self::MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
        if bytes.len() as u64 > Self::MAX_FILE_BYTES {
            return Err(too_large());
        }
        Self::from_ktx2(&bytes, path)
    }

    /// Whether `bytes` start like a KTX2 file: with its 12 bytes of identifier.
    pub fn is_ktx2(bytes: &[u8]) -> bool {
        bytes.starts_with(&ktx2::MAGIC)
    }
}

/// The number of texels of a texture, once its size and levels are in their ranges: 2^28 at most.
fn texel_count(size_px: u32, levels: u32) -> Result<u64> {
    let (min, max, max_levels) = (LevelTexture::MIN_SIZE_PX, LevelTexture::MAX_SIZE_PX, LevelTexture::MAX_LEVELS);
    if !(min..=max).contains(&size_px) {
        return Err(Error::parameter("size_px", size_px, format!("{min} to {max}")));
    }
    if !(1..=max_levels).contains(&levels) {
        return Err(Error::parameter("levels", levels, format!("1 to {max_levels}")));
    }
    Ok(u64::from(levels) * u64::from(size_px) * u64::from(size_px))
}

/// KTX2's data format descriptor with its total size in front.
fn data_format_descriptor() -> Vec<u8> {
    let (basic, _type_size) =
        dfd::Basic::from_format(Format::R8G8B8A8_UNORM).expect("ktx2 knows the most common of all formats");
    let block = dfd::Block::Basic(basic).to_vec();
    let mut bytes = (block.len() as u32 + 4).to_le_bytes().to_vec();
    bytes.extend(block);
    bytes
}

/// Appends a key/value entry: length of key, NUL and value, these three, and zeros up to a multiple of 4.
fn push_entry(entries: &mut Vec<u8>, key: &str, value: &[u8]) {
    let length = key.len() + 1 + value.len();
    entries.extend((length as u32).to_le_bytes());
    entries.extend(key.bytes());
    entries.push(0);
    entries.extend_from_slice(value);
    entries.resize(entries.len().next_multiple_of(4), 0);
}

/// Reads a file, or says what is wrong with it.
///
/// `ktx2::Reader` is not used: it panics on a data format descriptor with a texel block of 256, which a damaged file
/// may have.
fn parse(bytes: &[u8]) -> Result<LevelTexture, String> {
    if !LevelTexture::is_ktx2(bytes) {
        return Err("is not a KTX2 file".into());
    }
    let head = bytes.first_chunk::<{ Header::LENGTH }>().ok_or_else(truncated)?;
    let header = Header::from_bytes(head).map_err(|error| format!("is a damaged KTX2 file: {error}"))?;
    let index = header.index;
    let entries = section(bytes, index.kvd_byte_offset.into(), index.kvd_byte_length.into())?;
    // The version goes first: a later one may well be of another format.
    let version = value(entries, VERSION_KEY)
        .ok_or_else(|| format!("is a KTX2 texture, but not one of levels: it has no entry {VERSION_KEY}"))?;
    check_version(version)?;
    check_header(&header)?;

    let descriptor = section(bytes, index.dfd_byte_offset.into(), index.dfd_byte_length.into())?;
    if descriptor != data_format_descriptor() {
        return Err("has a data format descriptor that is not the one of linear R8G8B8A8_UNORM".into());
    }
    let level = bytes.get(Header::LENGTH..).and_then(|rest| rest.first_chunk::<{ LevelIndex::LENGTH }>());
    let level = LevelIndex::from_bytes(level.ok_or_else(truncated)?);
    let (size_px, levels) = (header.pixel_width, header.pixel_depth);
    let expected = texel_count(size_px, levels).map_err(|error| error.to_string())? * TEXEL_BYTES;
    if level.byte_length != expected || level.uncompressed_byte_length != expected {
        return Err(format!(
            "has {} bytes of texels, {} uncompressed, but {levels} levels of {size_px} x {size_px} are {expected}",
            level.byte_length, level.uncompressed_byte_length
        ));
    }
    let texels = section(bytes, level.byte_offset, level.byte_length)?;
    let colors = value(entries, TRAJECTORY_KEY).ok_or_else(|| format!("has no entry {TRAJECTORY_KEY}"))?;
    let trajectory = parse_trajectory(colors)?;
    let texels = bytemuck::cast_slice(texels).to_vec();
    LevelTexture::new(size_px, levels, texels, trajectory).map_err(|error| error.to_string())
}

fn truncated() -> String {
    "is truncated: its KTX2 header tells of more than the file holds".into()
}

/// The part of the file at a place that its header gives.
fn section(bytes: &[u8], offset: u64, length: u64) -> Result<&[u8], String> {
    let end = offset.checked_add(length).and_then(|end| usize::try_from(end).ok());
    let start = usize::try_from(offset).ok();
    start.zip(end).and_then(|(start, end)| bytes.get(start..end)).ok_or_else(truncated)
}

/// The value of the first entry with this key.
fn value<'a>(entries: &'a [u8], key: &str) -> Option<&'a [u8]> {
    KeyValueDataIterator::new(entries).find(|(name, _)| *name == key).map(|(_, value)| value)
}

fn check_version(value: &[u8]) -> Result<(), String> {
    let text = std::str::from_utf8(value.strip_suffix(b"\0").unwrap_or(value)).unwrap_or_default();
    match text.parse::<u32>() {
        Ok(FORMAT_VERSION) => Ok(()),
        Ok(version) if version > FORMAT_VERSION => Err(format!(
            "was made by a later version of impasto: its format is {version}, and this version reads {FORMAT_VERSION}"
        )),
        _ => Err(format!("has an entry {VERSION_KEY} that is no version of its format; it should be {FORMAT_VERSION}")),
    }
}

/// Checks that the texture is a square volume of plain R8G8B8A8_UNORM.
fn check_header(header: &Header) -> Result<(), String> {
    if header.format != Some(Format::R8G8B8A8_UNORM) || header.type_size != 1 {
        let (format, size) = (header.format.map_or(0, |format| format.value()), header.type_size);
        return Err(format!("has vkFormat {format} and typeSize {size}, but must have 37 (R8G8B8A8_UNORM) and 1"));
    }
    if let Some(scheme) = header.supercompression_scheme {
        return Err(format!("is supercompressed (scheme {}), but must not be", scheme.value()));
    }
    if header.face_count != 1 {
        return Err(format!("is a cube map or the like, of {} faces, but must have 1", header.face_count));
    }
    if header.layer_count != 0 {
        return Err(format!("is an array of {} layers, but must be no array", header.layer_count));
    }
    if header.level_count != 1 {
        return Err(format!("has a levelCount of {} mip levels, but must have 1", header.level_count));
    }
    if header.pixel_height == 0 || header.pixel_depth == 0 {
        return Err("is a 1D or 2D texture, but must be a volume, with a slice for each level".into());
    }
    if header.pixel_width != header.pixel_height {
        return Err(format!("is {} x {} texels, but must be square", header.pixel_width, header.pixel_height));
    }
    Ok(())
}

fn parse_trajectory(bytes: &[u8]) -> Result<Trajectory, String> {
    if bytes.is_empty()
        || !bytes.len().is_multiple_of(COLOR_BYTES)
        || bytes.len() / COLOR_BYTES > LevelTexture::MAX_COLORS
    {
        return Err(format!(
            "has a trajectory ({TRAJECTORY_KEY}) of {} bytes, but must have {COLOR_BYTES} for each of 1 to {} colours",
            bytes.len(),
            LevelTexture::MAX_COLORS
        ));
    }
    // Entries lie at multiples of 4, but their values do not, so the floats are put together from their bytes.
    let float = |at: &[u8]| at.iter().rev().fold(0, |bits, &byte| bits << 8 | u32::from(byte));
    let colors = bytes
        .chunks_exact(COLOR_BYTES)
        .map(|color| std::array::from_fn(|channel| f32::from_bits(float(&color[channel * 4..][..4]))))
        .collect();
    Trajectory::from_colors(colors)
        .map_err(|error| format!("has a trajectory ({TRAJECTORY_KEY}) out of range: {error}"))
}
