//! Makes a picture tileable with the circular mask of thesis 3.2.3, on the GPU.
//!
//! The picture is blended with itself, shifted by half its size, so that what were its edges lie in the middle under
//! the mask. The oracle is [`super::tile_oracle`]; quilting with [`super::params::QuiltParams::tileable`] is the
//! alternative that keeps texture sharp.

use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Shader, Uploads,
};
use crate::{Error, Result};
use ash::vk;

pub(crate) const TILE_MASK: Shader = Shader {
    name: "tile_mask",
    spirv: include_bytes!("../../glsl/spirv/synthesis/tile_mask.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: 0,
};

/// One picture to be made tileable.
pub struct TileMask {
    pipeline: ComputePipeline,
    set: BindingSet,
    tileable: Image,
}

impl TileMask {
    /// Prepares to make `pixels` (RGBA, row by row, `size` = (width, height)) tileable.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the pixels do not fit the size or the size does not fit the device.
    pub fn new(context: &Context, uploads: &mut Uploads, pixels: &[[u8; 4]], size: (u32, u32)) -> Result<Self> {
        if pixels.len() as u64 != u64::from(size.0) * u64::from(size.1) {
            return Err(Error::parameter("picture pixels", pixels.len(), format!("{} x {}", size.0, size.1)));
        }
        let desc = ImageDesc::storage_2d(size.0, size.1, vk::Format::R32_UINT);
        let picture = Image::new(context, "tile picture", &desc)?;
        uploads.image(context, &picture, bytemuck::cast_slice(pixels))?;
        Self::of_image(context, uploads, &picture)
    }

    /// Prepares to make a picture on the device tileable: R32_UINT, red in the low byte.
    pub(crate) fn of_image(context: &Context, uploads: &mut Uploads, picture: &Image) -> Result<Self> {
        let [width, height, _] = picture.size_px();
        let desc = ImageDesc::storage_2d(width, height, vk::Format::R32_UINT);
        let mask = Image::new(context, "tile mask", &desc)?;
        let tileable = Image::new(context, "tileable picture", &desc)?;
        uploads.image(context, &mask, bytemuck::cast_slice(&circular_mask((width, height))))?;
        let pipeline = ComputePipeline::new(context, &TILE_MASK)?;
        let set = BindingSet::new(context, &pipeline, &[picture.into(), (&mask).into(), (&tileable).into()])?;
        Ok(TileMask { pipeline, set, tileable })
    }

    /// Records the blend.
    pub fn record(&self, recorder: &mut Recorder<'_>) {
        let [width, height, _] = self.tileable.size_px();
        recorder.dispatch(&self.pipeline, &self.set, &(), [width.div_ceil(16), height.div_ceil(8), 1]);
    }

    /// The tileable picture: R32_UINT, red in the low byte, alpha in the high one.
    pub fn image(&self) -> &Image {
        &self.tileable
    }
}

/// M = 255 - 255 r, r the distance from the middle with the edges at 1, clipped to [1, 255], in 1/4096. For a square
/// this is the thesis's mask; for another shape the circle is stretched to an ellipse.
fn circular_mask(size: (u32, u32)) -> Vec<u32> {
    let from_middle = |i: u32, n: u32| (2.0 * f64::from(i) - f64::from(n)) / f64::from(n);
    let mut mask = Vec::with_capacity(size.0 as usize * size.1 as usize);
    for y in 0..size.1 {
        for x in 0..size.0 {
            let (u, v) = (from_middle(x, size.0), from_middle(y, size.1));
            let m = (255.0 - 255.0 * (u * u + v * v).sqrt()).clamp(1.0, 255.0);
            mask.push((m * 4096.0 + 0.5).floor() as u32);
        }
    }
    mask
}
