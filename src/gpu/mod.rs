//! Every Vulkan call of the crate, and every `unsafe` (the C boundary aside). Knows nothing of paint.
//!
//! A [`Context`] owns a device or borrows a host's. On it stand [`Buffer`]s and [`Image`]s (freed only when the GPU
//! is done with them), pipelines with their binding sets, and explicit render passes. A [`Recorder`] writes *passes*
//! into a command buffer that it is given: each pass declares what it reads and writes ([`Access`]), and label, timer
//! and barriers are derived from that in one place. Nothing here submits but the headless [`Runner`] and
//! [`FrameLoop`], which are just two more hosts.

mod access;
mod allocation;
mod caps;
pub mod ceilings;
mod context;
mod frame_loop;
mod host_device;
mod loader;
mod measuring;
mod memory;
mod pipeline;
mod recorder;
mod render_pass;
mod requirements;
mod runner;
mod submission;
mod timing;
mod upload;
mod validation;

pub use access::{Access, Barrier, ResourceState};
pub use allocation::{HostAllocation, HostMemory, MemoryKind};
pub use caps::{list_devices, Caps, DeviceChoice, DeviceInfo, DeviceKind, PciAddress, Uuid};
pub(crate) use context::lock;
pub use context::{Context, ContextOptions, LogCallback, LogLevel};
pub use frame_loop::FrameLoop;
pub use host_device::HostDevice;
pub(crate) use measuring::measuring;
pub(crate) use memory::Sampler;
pub use memory::{Buffer, BufferKind, Image, ImageDesc};
pub use pipeline::{BindingKind, PipelineCacheFile, RasterShader, Shader};
pub(crate) use pipeline::{BindingSet, Bound, ComputePipeline};
pub use recorder::Recorder;
pub(crate) use render_pass::{
    Attachment, Draw, Framebuffer, Geometry, RasterDesc, RasterPipeline, RenderPass, Role, VertexAttribute,
};
pub use requirements::{requirements, Format, Limits, Requirements};
pub use runner::Runner;
pub use timing::{PassTime, PassTimer};
pub use upload::Uploads;

/// The Vulkan version that is asked for, and all that is needed of a device.
pub const API_VERSION: u32 = ash::vk::API_VERSION_1_1;
