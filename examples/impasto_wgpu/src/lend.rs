//! Lends wgpu's device to impasto, and its command buffers.
//!
//! wgpu-hal is built on ash, as impasto is. Where the two agree on ash's version, as wgpu 30 does (ash 0.38), its
//! objects are passed on as they are; otherwise `HostDevice::from_raw` takes plain Vulkan handles.

use crate::Result;
use ash::vk;
use impasto::gpu::{Access, Context, HostDevice, Image, ImageDesc, LogLevel, Recorder, ResourceState};
use std::sync::Arc;
use wgpu::hal::api::Vulkan;

/// impasto's context on wgpu's device. It must be gone before the device is, and then the device must be idle.
pub fn context(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Result<Context> {
    // SAFETY: nothing is destroyed through the raw objects.
    let raw = unsafe { (adapter.as_hal::<Vulkan>(), device.as_hal::<Vulkan>()) };
    let (Some(adapter), Some(raw)) = raw else { return Err("the adapter is not Vulkan's".into()) };
    let instance = raw.shared_instance();
    // What wgpu has enabled, which is less than what the device offers.
    let enabled = adapter.physical_device_features(raw.enabled_device_extensions(), device.features());
    let mut host = HostDevice::new(
        instance.raw_instance().clone(),
        raw.raw_physical_device(),
        raw.raw_device().clone(),
        raw.queue_family_index(),
    );
    host.enabled_features = enabled.get_core();
    host.debug_utils = instance.extensions().contains(&ash::ext::debug_utils::NAME);
    host.log = Some(Arc::new(|level, message| log::log!(of_impasto(level), "{message}")));
    // SAFETY: the handles are live and belong together, wgpu's queue draws and computes, and the caller keeps the
    // device for longer than the context.
    Ok(unsafe { Context::from_host(host) }?)
}

fn of_impasto(level: LogLevel) -> log::Level {
    match level {
        LogLevel::Error => log::Level::Error,
        LogLevel::Warning => log::Level::Warn,
    }
}

/// How wgpu leaves a texture in the state `COLOR_TARGET`, and expects to find it: stages, accesses and layout are those
/// of wgpu-hal's `map_texture_usage_to_barrier` and `derive_image_layout`.
pub fn color_attachment() -> ResourceState {
    ResourceState::of(Access::ColorBlend)
}

/// The same of `DEPTH_STENCIL_WRITE`.
pub fn depth_attachment() -> ResourceState {
    ResourceState::of(Access::DepthTest)
}

/// Brings wgpu's textures to these two states, as the last thing in an encoder.
pub fn bring_to_attachment(encoder: &mut wgpu::CommandEncoder, color: &wgpu::Texture, depth: &wgpu::Texture) {
    let states = [(color, wgpu::TextureUses::COLOR_TARGET), (depth, wgpu::TextureUses::DEPTH_STENCIL_WRITE)];
    let to = |(texture, state)| wgpu::wgt::TextureTransition { texture, selector: None, state };
    encoder.transition_resources(std::iter::empty(), states.into_iter().map(to));
}

/// wgpu's texture as impasto sees it. The texture and the view must outlive the image.
pub fn image(context: &Context, texture: &wgpu::Texture, view: &wgpu::TextureView) -> Result<Image> {
    // One after the other: what `as_hal` gives holds a lock of wgpu's, which may be taken once.
    // SAFETY: nothing is destroyed through the raw objects.
    let raw_texture = unsafe { texture.as_hal::<Vulkan>().map(|raw| raw.raw_handle()) };
    let raw_view = unsafe { view.as_hal::<Vulkan>().map(|raw| raw.raw_handle()) };
    let (Some(raw_texture), Some(raw_view)) = (raw_texture, raw_view) else {
        return Err("the texture is not Vulkan's".into());
    };
    let (format, usage, state) = match texture.format() {
        wgpu::TextureFormat::Rgba8Unorm => {
            (vk::Format::R8G8B8A8_UNORM, vk::ImageUsageFlags::COLOR_ATTACHMENT, color_attachment())
        }
        wgpu::TextureFormat::Depth32Float => {
            (vk::Format::D32_SFLOAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT, depth_attachment())
        }
        other => return Err(format!("{other:?} is not among the formats of this example").into()),
    };
    let desc = ImageDesc { size_px: [texture.width(), texture.height(), 1], format, usage };
    // SAFETY: the caller keeps both for longer than the image, and records only when they lie in this state.
    Ok(unsafe { Image::from_host(context, raw_texture, raw_view, &desc, state) })
}

/// A command buffer of wgpu's that holds nothing but what `record` writes into it.
pub fn record(
    device: &wgpu::Device,
    context: &Context,
    record: impl FnOnce(&mut Recorder<'_>) -> Result<()>,
) -> Result<wgpu::CommandBuffer> {
    // An encoder is wgpu's or raw, never both: wgpu keeps its own commands back until `finish`.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("impasto") });
    // SAFETY: the command buffer is neither ended nor kept, and wgpu is not called meanwhile.
    let recorded = unsafe {
        encoder.as_hal_mut::<Vulkan, _, Result<()>>(|raw| {
            let raw = raw.ok_or("the encoder is not Vulkan's")?;
            record(&mut Recorder::new(context, raw.raw_handle(), None))
        })
    };
    recorded?;
    Ok(encoder.finish())
}
