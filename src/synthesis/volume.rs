//! Textures stacked into one 3D image, a slice each (thesis chapters 7 and 8).

use super::quilt::Quilt;
use crate::gpu::{Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Shader};
use crate::{Error, Result};
use ash::vk;

pub(crate) const VOLUME_SLICE: Shader = Shader {
    name: "volume_slice",
    spirv: include_bytes!("../../glsl/spirv/synthesis/volume_slice.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<SlicePush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct SlicePush {
    slice: u32,
    paint: u32,
    first: u32,
}

/// The 3D image, and the stage that fills its slices.
pub(crate) struct Volume {
    image: Image,
    stage: ComputePipeline,
}

/// One texture's way into its slice.
pub(crate) struct SliceCopy {
    set: BindingSet,
    push: SlicePush,
}

impl Volume {
    /// Makes room for `slices` textures of `size_px` = (width, height).
    ///
    /// # Errors
    /// [`Error::Device`] when the device's 3D images are too small for it, [`Error::Memory`] when the budget does not
    /// allow it.
    pub fn new(context: &Context, name: &'static str, size_px: (u32, u32), slices: u32) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let limit = context.caps().max_image_3d_px;
        if size_px.0.max(size_px.1).max(slices) > limit {
            let device = &context.device_info().name;
            return Err(Error::Device(format!(
                "{name} needs a 3D image of {}x{}x{slices}, but {device} allows {limit} a side",
                size_px.0, size_px.1
            )));
        }
        // A depth of 1 would make a 2D image.
        let desc = ImageDesc {
            size_px: [size_px.0, size_px.1, slices.max(2)],
            format: vk::Format::R8G8B8A8_UNORM,
            usage: U::STORAGE | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST,
        };
        Ok(Volume { image: Image::new(context, name, &desc)?, stage: ComputePipeline::new(context, &VOLUME_SLICE)? })
    }

    /// The 3D image: R8G8B8A8_UNORM, differences from [-1, 1] mapped to [0, 1].
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Prepares to put a texture, R32_UINT with red in the low byte, into a slice.
    pub fn copy(&self, context: &Context, texture: &Image, slice: u32) -> Result<SliceCopy> {
        let set = BindingSet::new(
            context,
            &self.stage,
            &[texture.into(), texture.into(), texture.into(), (&self.image).into()],
        )?;
        Ok(SliceCopy { set, push: SlicePush { slice, paint: 0, first: 1 } })
    }

    /// Prepares to put a guided quilt into a slice, where the guide (its first image) has its paint, with an alpha (its
    /// second image, R32_UINT, 0 to 255); `first` for the first of a slice.
    pub fn copy_guided(
        &self,
        context: &Context,
        quilt: &Quilt,
        [guide, alpha]: [&Image; 2],
        paint: u32,
        slice: u32,
        first: bool,
    ) -> Result<SliceCopy> {
        let bound = [quilt.canvas().into(), guide.into(), alpha.into(), (&self.image).into()];
        let set = BindingSet::new(context, &self.stage, &bound)?;
        Ok(SliceCopy { set, push: SlicePush { slice, paint, first: u32::from(first) } })
    }

    /// Records a copy.
    pub fn record(&self, recorder: &mut Recorder<'_>, copy: &SliceCopy) {
        let [width, height, _] = self.image.size_px();
        recorder.dispatch(&self.stage, &copy.set, &copy.push, [width.div_ceil(16), height.div_ceil(8), 1]);
    }
}
