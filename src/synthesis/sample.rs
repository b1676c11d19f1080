//! What is synthesised from, on the device.

use super::quilt_stages::TILE;
use crate::gpu::{Context, Image, ImageDesc, Uploads};
use crate::{Error, Result};
use ash::vk;

/// Texels that a search may read beyond the right edge of a sample.
const PADDING: u32 = TILE + 6;

/// A sample's 8-bit texels on the device, and the summed-area table of their squares.
pub struct SampleTexels {
    image: Image,
    squares: Image,
    texels: Vec<[u8; 4]>,
    size: (u32, u32),
}

impl SampleTexels {
    /// Stages `texels` (RGBA, row by row; alpha is ignored) for upload.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the texels are not `size.0 * size.1`, or a side is over 4,096 px.
    pub fn new(context: &Context, uploads: &mut Uploads, texels: &[[u8; 4]], size: (u32, u32)) -> Result<Self> {
        // The summed-area table is the largest image that is made.
        let limit = super::params::MAX_SAMPLE_PX.min(context.caps().max_image_2d_px.saturating_sub(PADDING + 1));
        if size.0 == 0 || size.1 == 0 || size.0 > limit || size.1 > limit {
            return Err(Error::parameter(
                "sample size",
                format!("{}x{}", size.0, size.1),
                format!("1 to {limit} px a side"),
            ));
        }
        if texels.len() as u64 != u64::from(size.0) * u64::from(size.1) {
            return Err(Error::parameter("sample texels", texels.len(), format!("{} x {}", size.0, size.1)));
        }
        // A tile of positions at the right edge reads beyond it; what it reads is there, and unused.
        let (width, height) = (size.0 as usize, size.1 as usize);
        let padded_width = width + PADDING as usize;
        let mut padded = vec![[0u8; 4]; padded_width * height];
        for (to, from) in padded.chunks_exact_mut(padded_width).zip(texels.chunks_exact(width)) {
            to[..width].copy_from_slice(from);
        }
        let square = |texel: &[u8; 4]| texel[..3].iter().map(|&c| u32::from(c).pow(2)).sum();
        let squares = summed_area(padded.iter().map(square), padded_width);
        let image = |name, width: usize, height: usize, data: &[u8], uploads: &mut Uploads| {
            let desc = ImageDesc::storage_2d(width as u32, height as u32, vk::Format::R32_UINT);
            let image = Image::new(context, name, &desc)?;
            uploads.image(context, &image, data)?;
            Ok::<_, Error>(image)
        };
        let image_texels = image("quilt sample", padded_width, height, bytemuck::cast_slice(&padded), uploads)?;
        let squares =
            image("quilt sample squares", padded_width + 1, height + 1, bytemuck::cast_slice(&squares), uploads)?;
        Ok(SampleTexels { image: image_texels, squares, texels: texels.to_vec(), size })
    }

    /// Its texels, with what a search may read beyond them.
    pub(crate) fn image(&self) -> &Image {
        &self.image
    }

    /// The summed-area table.
    pub(super) fn squares(&self) -> &Image {
        &self.squares
    }

    /// Its texels on the host.
    pub(super) fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// Width and height of the sample, pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }
}

/// The summed-area table of a picture's values, row by row, with a row and a column of zeros first. It wraps around;
/// differences do not care.
pub(super) fn summed_area(values: impl Iterator<Item = u32>, width: usize) -> Vec<u32> {
    let mut table = vec![0u32; width + 1];
    let mut row = 0u32;
    for (i, value) in values.enumerate() {
        if i % width == 0 {
            row = 0;
            table.push(0);
        }
        row = row.wrapping_add(value);
        table.push(table[table.len() - width - 1].wrapping_add(row));
    }
    table
}
