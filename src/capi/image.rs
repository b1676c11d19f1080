//! A host's images, and how it uses them.

use super::memory::{read, value_if, versioned};
use super::status::{Failure, Result};
use super::types::*;
use crate::gpu::{Context, Image, ImageDesc, Recorder, ResourceState};
use ash::vk;
use ash::vk::Handle;

/// An image of the host's: 2D, with one level and one layer. It and its view must live until whatever was made with it
/// is destroyed and the GPU is done with it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoImage {
    /// sizeof(ImpastoImage).
    pub struct_size: u32,
    /// Its format.
    pub format: VkFormat,
    /// The image.
    pub image: VkImage,
    /// A view of the whole of it.
    pub view: VkImageView,
    /// Its width, pixels.
    pub width_px: u32,
    /// Its height, pixels.
    pub height_px: u32,
    /// What it was made for.
    pub usage: VkImageUsageFlags,
    /// 0.
    pub reserved: u32,
}
versioned!(ImpastoImage);

/// Wraps a host's image.
///
/// # Safety
/// `from` is null or points to a structure, and that describes a live image of the context's device.
pub(super) unsafe fn image(context: &Context, name: &'static str, from: *const ImpastoImage) -> Result<Image> {
    // SAFETY: the caller promises it.
    let image = unsafe { read(from) }?;
    if image.image.is_null() || image.view.is_null() {
        return Err(Failure::new(ImpastoStatus::NullPointer, format!("the image or the view of {name} is null")));
    }
    let (width, height) = (image.width_px, image.height_px);
    let most = context.caps().max_image_2d_px;
    if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
        let allowed = format!("1 to {most} pixels a side on this device");
        return Err(Failure::parameter(name, format!("{width}x{height}"), allowed));
    }
    let desc = ImageDesc { size_px: [width, height, 1], format: image.format, usage: image.usage };
    // SAFETY: the caller promises a live image that fits; its state is told before each use.
    Ok(unsafe { Image::from_host(context, image.image, image.view, &desc, ResourceState::fresh()) })
}

/// A use, with the image that it is of.
pub(super) struct Uses<'a> {
    image: &'a Image,
    before: Option<ResourceState>,
    after: Option<ResourceState>,
}

/// What a host says of its use of an image. `must` wants it to say so: of an image that it alone knows.
///
/// # Safety
/// `from` is null or points to a structure.
pub(super) unsafe fn uses<'a>(
    name: &'static str,
    image: &'a Image,
    from: *const ImpastoImageUse,
    must: bool,
) -> Result<Uses<'a>> {
    // SAFETY: the caller promises it.
    let Some(ImpastoImageUse { before, after }) = (unsafe { value_if(from) }) else {
        if must {
            return Err(Failure::new(ImpastoStatus::NullPointer, format!("the use of {name} is null")));
        }
        return Ok(Uses { image, before: None, after: None });
    };
    let told = |told: ImpastoUse, next: bool| match told {
        ImpastoUse { stages, access, layout } if (stages.as_raw(), access.as_raw(), layout.as_raw()) == (0, 0, 0) => {
            if must {
                return Err(Failure::parameter(name, "used in ways that are not told", "told how it is used"));
            }
            Ok(None)
        }
        told => check(name, image, told, next).map(Some),
    };
    Ok(Uses { image, before: told(before, false)?, after: told(after, true)? })
}

impl Uses<'_> {
    /// Takes over what the host has done.
    ///
    /// # Safety
    /// The host must have told the truth.
    pub unsafe fn begin(&self) {
        if let Some(before) = self.before {
            // SAFETY: the caller promises it.
            unsafe { self.image.set_state(before) };
        }
    }

    /// Leaves the image as the host wants it.
    pub fn end(&self, recorder: &mut Recorder<'_>) {
        if let Some(after) = self.after {
            recorder.hand_over(self.image, after);
        }
    }
}

/// Checks that an image such as this can be used so. `next` is a use that waits for ours.
fn check(name: &'static str, image: &Image, told: ImpastoUse, next: bool) -> Result<ResourceState> {
    use vk::ImageLayout as L;
    use vk::ImageUsageFlags as U;
    let ImpastoUse { stages, access, layout } = told;
    if next && stages.is_empty() {
        return Err(Failure::parameter(name, "used next by no stage", "used by one or more"));
    }
    let depth = is_depth(image.format());
    let made_for = match layout {
        L::GENERAL => Some(U::empty()),
        L::SHADER_READ_ONLY_OPTIMAL => Some(U::SAMPLED | U::INPUT_ATTACHMENT),
        L::TRANSFER_SRC_OPTIMAL => Some(U::TRANSFER_SRC),
        L::TRANSFER_DST_OPTIMAL => Some(U::TRANSFER_DST),
        L::COLOR_ATTACHMENT_OPTIMAL if !depth => Some(U::COLOR_ATTACHMENT),
        L::PRESENT_SRC_KHR if !depth => Some(U::empty()),
        L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL
        | L::DEPTH_STENCIL_READ_ONLY_OPTIMAL
        | L::DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL
        | L::DEPTH_ATTACHMENT_STENCIL_READ_ONLY_OPTIMAL
            if depth =>
        {
            Some(U::empty())
        }
        _ => None,
    };
    let Some(made_for) = made_for else {
        let kind = if depth { "depth" } else { "colour" };
        let allowed = format!("in a layout of Vulkan 1.1 that keeps what is in a {kind} image");
        return Err(Failure::parameter(name, format!("in {layout:?}"), allowed));
    };
    if !made_for.is_empty() && !image.usage().intersects(made_for) {
        let allowed = format!("made for {made_for:?}");
        return Err(Failure::parameter(name, format!("in {layout:?}, made for {:?}", image.usage()), allowed));
    }
    Ok(ResourceState::from_host(stages, access, layout))
}

fn is_depth(format: vk::Format) -> bool {
    use vk::Format as F;
    let depths = [F::D16_UNORM, F::X8_D24_UNORM_PACK32, F::D32_SFLOAT, F::D16_UNORM_S8_UINT, F::D24_UNORM_S8_UINT];
    depths.contains(&format) || format == F::D32_SFLOAT_S8_UINT
}
