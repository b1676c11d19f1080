//! All that reaches below wgpu: its raw handles, and command buffers that impasto records into. All `unsafe` is here.
//!
//! wgpu keeps track of the layouts of its textures, and of what a command buffer does with them. It knows nothing of
//! what is recorded into raw handles. So a texture is first brought to a state that is known, by
//! `transition_resources` in a command buffer of wgpu's; then comes one that holds raw commands alone, as wgpu wants
//! it, and leaves the texture in that very state, with a barrier of its own.

use ash::vk;
use bevy::log::{error, warn};
use bevy::render::render_resource::{Texture, TextureView};
use bevy::render::renderer::{RenderAdapter, RenderContext, RenderDevice, RenderInstance};
use impasto::gpu::{Access, Context, HostDevice, Image, ImageDesc, LogCallback, LogLevel, Recorder, ResourceState};
use impasto::{Error, Result};
use std::sync::Arc;
use wgpu::hal::api::Vulkan;
use wgpu::{TextureTransition, TextureUses};

/// A context on Bevy's device.
///
/// # Errors
/// [`Error::Device`] on a backend other than Vulkan, or for a device that impasto cannot use.
pub fn context(device: &RenderDevice, adapter: &RenderAdapter, instance: &RenderInstance) -> Result<Context> {
    let no_vulkan = || Error::Device("Bevy renders by another backend than Vulkan".to_owned());
    // SAFETY: no handle is destroyed through these; the caller keeps the device for as long as the context.
    let (device, adapter, instance) = unsafe {
        (
            device.wgpu_device().as_hal::<Vulkan>().ok_or_else(no_vulkan)?,
            adapter.as_hal::<Vulkan>().ok_or_else(no_vulkan)?,
            instance.as_hal::<Vulkan>().ok_or_else(no_vulkan)?,
        )
    };
    let shared = instance.shared_instance();
    let (instance, physical) = (shared.raw_instance().clone(), adapter.raw_physical_device());
    let host = HostDevice::new(instance, physical, device.raw_device().clone(), device.queue_family_index());
    let debug_utils = shared.extensions().contains(&ash::ext::debug_utils::NAME);
    let log: LogCallback = Arc::new(|level, message| match level {
        LogLevel::Error => error!("{message}"),
        _ => warn!("{message}"),
    });
    let host = HostDevice { debug_utils, log: Some(log), ..host };
    // SAFETY: the handles are live and belong together; `Painter` drops the context before the device, and waits for
    // the GPU first.
    unsafe { Context::from_host(host) }
}

/// Adds a command buffer to the frame and lets `record` record into it.
///
/// `textures` are brought to the states of the given uses before; `record` is to leave them there.
///
/// # Errors
/// Those of `record`; what it has recorded so far is part of the frame nonetheless.
pub fn record<R>(
    ctx: &mut RenderContext,
    context: &Context,
    textures: &[(&Texture, Attachment)],
    record: impl FnOnce(&mut Recorder<'_>) -> Result<R>,
) -> Result<R> {
    if !textures.is_empty() {
        let states = textures.iter().map(|(texture, of)| TextureTransition {
            texture: &***texture,
            selector: None,
            state: of.wgpu(),
        });
        ctx.command_encoder().transition_resources(std::iter::empty(), states);
    }
    let label = wgpu::CommandEncoderDescriptor { label: Some("impasto") };
    let mut encoder = ctx.render_device().create_command_encoder(&label);
    // SAFETY: the command buffer is neither ended nor destroyed here, and the encoder is used for nothing else. Bevy
    // submits the command buffers of a frame in the order in which they were added, to one queue.
    let recorded = unsafe {
        encoder.as_hal_mut::<Vulkan, _, _>(|raw| match raw {
            Some(raw) => record(&mut Recorder::new(context, raw.raw_handle(), None)),
            None => Err(Error::Device("the command encoder of the frame is not one of Vulkan's".to_owned())),
        })
    };
    ctx.add_command_buffer(encoder.finish());
    recorded
}

/// A use of a view's texture as an attachment, as wgpu and as impasto call it.
#[derive(Clone, Copy)]
pub enum Attachment {
    Color,
    Depth,
}

impl Attachment {
    fn wgpu(self) -> TextureUses {
        match self {
            Attachment::Color => TextureUses::COLOR_TARGET,
            Attachment::Depth => TextureUses::DEPTH_STENCIL_WRITE,
        }
    }

    /// How wgpu leaves the texture, and wants it back.
    pub fn state(self) -> ResourceState {
        ResourceState::of(match self {
            Attachment::Color => Access::ColorBlend,
            Attachment::Depth => Access::DepthTest,
        })
    }

    /// Tells that the image is again in the state that [`record`] has brought its texture to.
    pub fn take(self, image: &Image) {
        // SAFETY: that is what `record` does, before anything of impasto's.
        unsafe { image.set_state(self.state()) };
    }
}

/// Bevy's texture as impasto's image; the view must be kept for as long as it.
///
/// # Errors
/// [`Error::Device`] for a texture of another backend, [`Error::Parameter`] for a format that is no view's.
pub fn image(context: &Context, texture: &Texture, view: &TextureView, of: Attachment) -> Result<Image> {
    let format = match texture.format() {
        wgpu::TextureFormat::Rgba8Unorm => vk::Format::R8G8B8A8_UNORM,
        wgpu::TextureFormat::Rgba8UnormSrgb => vk::Format::R8G8B8A8_SRGB,
        wgpu::TextureFormat::Bgra8Unorm => vk::Format::B8G8R8A8_UNORM,
        wgpu::TextureFormat::Bgra8UnormSrgb => vk::Format::B8G8R8A8_SRGB,
        wgpu::TextureFormat::Rgba16Float => vk::Format::R16G16B16A16_SFLOAT,
        wgpu::TextureFormat::Depth32Float => vk::Format::D32_SFLOAT,
        other => return Err(Error::parameter("format of the view", format!("{other:?}"), "8 bits, or half floats")),
    };
    let usage = match of {
        Attachment::Color => vk::ImageUsageFlags::COLOR_ATTACHMENT,
        Attachment::Depth => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
    };
    let desc = ImageDesc { size_px: [texture.width(), texture.height(), 1], format, usage };
    // wgpu locks what lends its handles: one after the other.
    // SAFETY: nothing is destroyed through the handles.
    let handle = unsafe { texture.as_hal::<Vulkan>().map(|texture| texture.raw_handle()) };
    // SAFETY: as above.
    let view = unsafe { view.as_hal::<Vulkan>().map(|view| view.raw_handle()) };
    let (Some(handle), Some(view)) = (handle, view) else {
        return Err(Error::Device("the view's texture is not one of Vulkan's".to_owned()));
    };
    // SAFETY: the image is what `desc` says, in the state that `record` brings it to, and lives as long as its view,
    // which the caller keeps.
    Ok(unsafe { Image::from_host(context, handle, view, &desc, of.state()) })
}
