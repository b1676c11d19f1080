//! Buffers and images: named, counted against the context's budget, freed only when the GPU is done with them.

use super::access::ResourceState;
use super::allocation::{allocate, check_budget, Allocation, Memory, MemoryKind};
use super::context::{lock, Context};
use crate::{Error, Result};
use ash::vk;
use std::sync::{Arc, Mutex, MutexGuard};

/// A Vulkan object on its way out.
pub(crate) enum Garbage {
    Buffer(vk::Buffer, Option<Allocation>),
    Image(vk::Image, vk::ImageView, Option<Allocation>),
    Sampler(vk::Sampler),
    Pipeline(vk::Pipeline, vk::PipelineLayout, vk::DescriptorSetLayout),
    DescriptorPool(vk::DescriptorPool),
    RenderPass(vk::RenderPass),
    Framebuffer(vk::Framebuffer),
    QueryPool(vk::QueryPool),
}

impl Garbage {
    pub fn destroy(self, device: &ash::Device, memory: &Memory) {
        let free = |allocation: Option<Allocation>| {
            if let Some(allocation) = allocation {
                memory.free(allocation);
            }
        };
        // SAFETY: the context destroys garbage only when the GPU is done with the frame in which it was dropped, and
        // the handles are owned: each is here once. Null handles are ignored by Vulkan.
        unsafe {
            match self {
                Garbage::Buffer(buffer, allocation) => {
                    device.destroy_buffer(buffer, None);
                    free(allocation);
                }
                Garbage::Image(image, view, allocation) => {
                    device.destroy_image_view(view, None);
                    device.destroy_image(image, None);
                    free(allocation);
                }
                Garbage::Sampler(sampler) => device.destroy_sampler(sampler, None),
                Garbage::Pipeline(pipeline, layout, set_layout) => {
                    device.destroy_pipeline(pipeline, None);
                    device.destroy_pipeline_layout(layout, None);
                    device.destroy_descriptor_set_layout(set_layout, None);
                }
                Garbage::DescriptorPool(pool) => device.destroy_descriptor_pool(pool, None),
                Garbage::RenderPass(pass) => device.destroy_render_pass(pass, None),
                Garbage::Framebuffer(framebuffer) => device.destroy_framebuffer(framebuffer, None),
                Garbage::QueryPool(pool) => device.destroy_query_pool(pool, None),
            }
        }
    }
}

/// What a buffer is for, which decides its usage flags and where it lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BufferKind {
    /// Read and written by shaders; lies on the device.
    Storage,
    /// Vertices and indices; lies on the device.
    Geometry,
    /// Written by the host, copied from by the GPU.
    Upload,
    /// Copied to by the GPU, read by the host.
    Readback,
}

/// A linear piece of memory. Clones are the same buffer.
#[derive(Clone)]
pub struct Buffer(Arc<BufferInner>);

struct BufferInner {
    context: Context,
    handle: vk::Buffer,
    allocation: Option<Allocation>,
    bytes: u64,
    id: u64,
    state: Mutex<ResourceState>,
}

impl Buffer {
    /// Makes a buffer of `bytes` bytes; its content is undefined.
    ///
    /// # Errors
    /// [`Error::Memory`] when the context's budget does not allow it, [`Error::Device`] when it is a storage buffer
    /// larger than the device allows, [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, name: &str, kind: BufferKind, bytes: u64) -> Result<Self> {
        Ok(Buffer(Arc::new(BufferInner::new(context, name, kind, bytes)?)))
    }

    /// Makes an upload buffer that holds `data`.
    pub fn upload(context: &Context, name: &str, data: &[u8]) -> Result<Self> {
        let mut buffer = BufferInner::new(context, name, BufferKind::Upload, data.len() as u64)?;
        let memory = buffer.allocation.as_mut().and_then(Allocation::mapped_mut);
        let Some(memory) = memory else { return Err(Error::Device(format!("{name}: upload memory is not mapped"))) };
        memory[..data.len()].copy_from_slice(data);
        Ok(Buffer(Arc::new(buffer)))
    }

    /// What the GPU wrote to a readback buffer; to be called after the submission is known to be done.
    pub fn mapped(&self) -> &[u8] {
        let all = self.0.allocation.as_ref().and_then(Allocation::mapped).unwrap_or_default();
        &all[..all.len().min(self.0.bytes as usize)]
    }

    /// Its size in bytes.
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    pub(crate) fn handle(&self) -> vk::Buffer {
        self.0.handle
    }

    pub(crate) fn id(&self) -> u64 {
        self.0.id
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, ResourceState> {
        lock(&self.0.state)
    }
}

impl BufferInner {
    fn new(context: &Context, name: &str, kind: BufferKind, bytes: u64) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let (usage, memory) = match kind {
            BufferKind::Storage => {
                (U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_SRC | U::TRANSFER_DST, MemoryKind::Device)
            }
            BufferKind::Geometry => (U::VERTEX_BUFFER | U::INDEX_BUFFER | U::TRANSFER_DST, MemoryKind::Device),
            BufferKind::Upload => (U::TRANSFER_SRC, MemoryKind::Upload),
            BufferKind::Readback => (U::TRANSFER_DST, MemoryKind::Readback),
        };
        let bytes = bytes.max(4);
        if kind == BufferKind::Storage && bytes > context.caps().max_storage_buffer_bytes {
            let limit = context.caps().max_storage_buffer_bytes;
            let device = &context.device_info().name;
            return Err(Error::Device(format!(
                "{name} needs a storage buffer of {bytes} bytes, but {device} allows {limit} bytes"
            )));
        }
        // Before Vulkan sees it: drivers need not take any size, and would not say what it was for.
        check_budget(context, name, bytes)?;
        let device = context.usable()?;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: a plain creation on a live device.
        let (handle, requirements) = unsafe {
            let handle = device.create_buffer(&info, None).map_err(context.failed("vkCreateBuffer"))?;
            (handle, device.get_buffer_memory_requirements(handle))
        };
        // From here on dropping `buffer` frees what there is of it.
        let mut buffer = BufferInner {
            context: context.clone(),
            handle,
            allocation: None,
            bytes,
            id: context.next_id(),
            state: Mutex::new(ResourceState::fresh()),
        };
        let allocation = buffer.allocation.insert(allocate(context, name, requirements, memory, false)?);
        // SAFETY: the memory was allocated for this buffer's requirements and is bound once.
        unsafe { device.bind_buffer_memory(handle, allocation.memory(), allocation.offset()) }
            .map_err(context.failed("vkBindBufferMemory"))?;
        context.name(handle, name);
        Ok(buffer)
    }
}

impl Drop for BufferInner {
    fn drop(&mut self) {
        self.context.bury(Garbage::Buffer(self.handle, self.allocation.take()));
    }
}

/// How to make an [`Image`].
#[derive(Debug, Clone, Copy)]
pub struct ImageDesc {
    /// Width, height and depth, texels; depth 1 makes a 2D image.
    pub size_px: [u32; 3],
    /// The format.
    pub format: vk::Format,
    /// What it is used for.
    pub usage: vk::ImageUsageFlags,
}

impl ImageDesc {
    /// A 2D image for compute shaders and copies.
    pub fn storage_2d(width_px: u32, height_px: u32, format: vk::Format) -> Self {
        use vk::ImageUsageFlags as U;
        let usage = U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST;
        ImageDesc { size_px: [width_px, height_px, 1], format, usage }
    }

    /// A 2D or 3D image that fragment shaders sample, and that is copied to.
    pub fn sampled(size_px: [u32; 3], format: vk::Format) -> Self {
        use vk::ImageUsageFlags as U;
        ImageDesc { size_px, format, usage: U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST }
    }

    /// A 2D image that is drawn to and then read by shaders and copies.
    pub fn drawn(width_px: u32, height_px: u32, format: vk::Format) -> Self {
        use vk::ImageUsageFlags as U;
        let usage = U::COLOR_ATTACHMENT | U::STORAGE | U::TRANSFER_SRC;
        ImageDesc { size_px: [width_px, height_px, 1], format, usage }
    }

    /// A 2D image that is drawn to and then read by whoever wants to: a frame.
    pub fn frame(width_px: u32, height_px: u32) -> Self {
        let drawn = Self::drawn(width_px, height_px, vk::Format::R8G8B8A8_UNORM);
        ImageDesc { usage: drawn.usage | vk::ImageUsageFlags::SAMPLED, ..drawn }
    }
}

/// A 2D or 3D image of one level with a view of the whole of it. Clones are the same image.
#[derive(Clone)]
pub struct Image(Arc<ImageInner>);

struct ImageInner {
    context: Context,
    handle: vk::Image,
    view: vk::ImageView,
    /// `None` when the image is a host's.
    allocation: Option<Allocation>,
    owned: bool,
    desc: ImageDesc,
    id: u64,
    state: Mutex<ResourceState>,
}

impl Image {
    /// Makes an image; its content is undefined.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a size of 0 or over the device's limit, [`Error::Memory`] when the budget does not
    /// allow it, [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, name: &str, desc: &ImageDesc) -> Result<Self> {
        let [width, height, depth] = desc.size_px;
        let caps = context.caps();
        let limit = if depth > 1 { caps.max_image_3d_px } else { caps.max_image_2d_px };
        if desc.size_px.iter().any(|side| !(1..=limit).contains(side)) {
            return Err(Error::parameter(
                "image size",
                format!("{width}x{height}x{depth}"),
                format!("1 to {limit} pixels a side on this device"),
            ));
        }
        let device = context.usable()?;
        let (kind, view_kind) = match depth {
            1 => (vk::ImageType::TYPE_2D, vk::ImageViewType::TYPE_2D),
            _ => (vk::ImageType::TYPE_3D, vk::ImageViewType::TYPE_3D),
        };
        let info = vk::ImageCreateInfo::default()
            .image_type(kind)
            .format(desc.format)
            .extent(vk::Extent3D { width, height, depth })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(desc.usage);
        // SAFETY: a plain creation on a live device.
        let (handle, requirements) = unsafe {
            let handle = device.create_image(&info, None).map_err(context.failed("vkCreateImage"))?;
            (handle, device.get_image_memory_requirements(handle))
        };
        // From here on dropping `image` frees what there is of it.
        let mut image = ImageInner {
            context: context.clone(),
            handle,
            view: vk::ImageView::null(),
            allocation: None,
            owned: true,
            desc: *desc,
            id: context.next_id(),
            state: Mutex::new(ResourceState::fresh()),
        };
        let memory = allocate(context, name, requirements, MemoryKind::Device, true)?;
        let allocation = image.allocation.insert(memory);
        // SAFETY: the memory was allocated for this image's requirements and is bound once.
        unsafe { device.bind_image_memory(handle, allocation.memory(), allocation.offset()) }
            .map_err(context.failed("vkBindImageMemory"))?;
        let view = vk::ImageViewCreateInfo::default()
            .image(handle)
            .view_type(view_kind)
            .format(desc.format)
            .subresource_range(whole_range(desc.format));
        // SAFETY: the image is live and bound.
        image.view = unsafe { device.create_image_view(&view, None) }.map_err(context.failed("vkCreateImageView"))?;
        context.name(handle, name);
        Ok(Image(Arc::new(image)))
    }

    /// Wraps a host's image. It is not destroyed with the wrapper.
    ///
    /// # Safety
    /// `handle` and `view` must be live on the context's device for as long as the wrapper and the work recorded with
    /// it, fit `desc`, and be in `state` when the commands recorded with it run.
    pub unsafe fn from_host(
        context: &Context,
        handle: vk::Image,
        view: vk::ImageView,
        desc: &ImageDesc,
        state: ResourceState,
    ) -> Self {
        Image(Arc::new(ImageInner {
            context: context.clone(),
            handle,
            view,
            allocation: None,
            owned: false,
            desc: *desc,
            id: context.next_id(),
            state: Mutex::new(state),
        }))
    }

    /// Tells what somebody else did to the image since it was last recorded here: a host that wrote to it, moved it to
    /// another layout, or threw away a command buffer that it was recorded in.
    ///
    /// # Safety
    /// `state` must be what the image is in when the commands recorded next run.
    pub unsafe fn set_state(&self, state: ResourceState) {
        *self.state() = state;
    }

    /// Checks that the image, which a caller brought as `name`, is of one of these formats and made for this use.
    ///
    /// # Errors
    /// [`Error::Parameter`] that tells what it is and what it must be.
    pub(crate) fn check(&self, name: &'static str, formats: &[vk::Format], usage: vk::ImageUsageFlags) -> Result<()> {
        let format = self.format();
        if !formats.contains(&format) {
            let allowed: Vec<String> = formats.iter().map(|format| format!("{format:?}")).collect();
            return Err(Error::parameter(name, format!("{format:?}"), allowed.join(" or ")));
        }
        self.check_usage(name, usage)
    }

    /// Checks that the image, which a caller brought as `name`, was made for this use.
    ///
    /// # Errors
    /// [`Error::Parameter`] that tells what it was made for and what it must be.
    pub(crate) fn check_usage(&self, name: &'static str, usage: vk::ImageUsageFlags) -> Result<()> {
        let made_for = self.0.desc.usage;
        if !made_for.contains(usage) {
            return Err(Error::parameter(name, format!("made for {made_for:?}"), format!("made for {usage:?}")));
        }
        Ok(())
    }

    /// Checks that the image, which a caller brought as `name`, holds something, as far as was told.
    ///
    /// # Errors
    /// [`Error::Parameter`] for one whose layout has no content.
    pub(crate) fn check_content(&self, name: &'static str) -> Result<()> {
        let layout = self.layout();
        if matches!(layout, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PREINITIALIZED) {
            let allowed = "in a layout with content, as told by Image::from_host or set_state";
            return Err(Error::parameter(name, format!("in layout {layout:?}"), allowed));
        }
        Ok(())
    }

    /// Checks that the image, which a caller brought as `name`, has this size.
    ///
    /// # Errors
    /// [`Error::Parameter`] that tells both sizes.
    pub(crate) fn check_size(&self, name: &'static str, size_px: [u32; 3]) -> Result<()> {
        if self.size_px() != size_px {
            let shown = |[width, height, depth]: [u32; 3]| match depth {
                1 => format!("{width}x{height}"),
                _ => format!("{width}x{height}x{depth}"),
            };
            return Err(Error::parameter(name, shown(self.size_px()), shown(size_px)));
        }
        Ok(())
    }

    /// Bytes of a texel, or 0 for formats that are neither uploaded nor read back.
    pub(crate) fn texel_bytes(&self) -> u64 {
        match self.0.desc.format {
            vk::Format::R8G8B8A8_UNORM | vk::Format::R32_UINT | vk::Format::R32_SFLOAT | vk::Format::D32_SFLOAT => 4,
            vk::Format::R16G16_SFLOAT => 4,
            vk::Format::R16G16B16A16_UINT | vk::Format::R16G16B16A16_SFLOAT | vk::Format::R32G32_SFLOAT => 8,
            vk::Format::R32G32B32A32_SFLOAT | vk::Format::R32G32B32A32_UINT => 16,
            _ => 0,
        }
    }

    /// Width, height and depth in texels.
    pub fn size_px(&self) -> [u32; 3] {
        self.0.desc.size_px
    }

    /// The format.
    pub fn format(&self) -> vk::Format {
        self.0.desc.format
    }

    /// What it was made for.
    pub fn usage(&self) -> vk::ImageUsageFlags {
        self.0.desc.usage
    }

    /// The Vulkan image, for hosts that read from it themselves.
    pub fn handle(&self) -> vk::Image {
        self.0.handle
    }

    /// The view of the whole image.
    pub fn view(&self) -> vk::ImageView {
        self.0.view
    }

    /// The layout in which all that was recorded so far leaves the image.
    pub fn layout(&self) -> vk::ImageLayout {
        self.state().layout()
    }

    pub(crate) fn id(&self) -> u64 {
        self.0.id
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, ResourceState> {
        lock(&self.0.state)
    }

    pub(crate) fn range(&self) -> vk::ImageSubresourceRange {
        whole_range(self.0.desc.format)
    }

    /// The copy region that covers all of it, tightly packed in a buffer.
    pub(crate) fn whole(&self) -> vk::BufferImageCopy {
        let [width, height, depth] = self.0.desc.size_px;
        let range = self.range();
        vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: range.aspect_mask,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_extent(vk::Extent3D { width, height, depth })
    }

    /// Texels in all.
    pub fn texels(&self) -> u64 {
        self.0.desc.size_px.iter().map(|&s| u64::from(s)).product()
    }
}

impl Drop for ImageInner {
    fn drop(&mut self) {
        if self.owned {
            self.context.bury(Garbage::Image(self.handle, self.view, self.allocation.take()));
        }
    }
}

/// How an image is sampled, one level. Clones are the same sampler.
#[derive(Clone)]
pub(crate) struct Sampler(Arc<SamplerInner>);

struct SamplerInner {
    context: Context,
    handle: vk::Sampler,
}

impl Sampler {
    /// Makes a sampler that is linear between texels, with these ways to go on beyond the edges in x, y and z.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when the call fails.
    pub fn linear(context: &Context, edges: [vk::SamplerAddressMode; 3]) -> Result<Self> {
        Self::new(context, vk::Filter::LINEAR, edges)
    }

    /// Makes a sampler for single texels, of formats that cannot be sampled in between.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when the call fails.
    pub fn nearest(context: &Context) -> Result<Self> {
        Self::new(context, vk::Filter::NEAREST, [vk::SamplerAddressMode::CLAMP_TO_EDGE; 3])
    }

    fn new(context: &Context, filter: vk::Filter, edges: [vk::SamplerAddressMode; 3]) -> Result<Self> {
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(filter)
            .min_filter(filter)
            .address_mode_u(edges[0])
            .address_mode_v(edges[1])
            .address_mode_w(edges[2]);
        // SAFETY: a plain creation on a live device.
        let handle =
            unsafe { context.usable()?.create_sampler(&info, None) }.map_err(context.failed("vkCreateSampler"))?;
        Ok(Sampler(Arc::new(SamplerInner { context: context.clone(), handle })))
    }

    pub fn handle(&self) -> vk::Sampler {
        self.0.handle
    }
}

impl Drop for SamplerInner {
    fn drop(&mut self) {
        self.context.bury(Garbage::Sampler(self.handle));
    }
}

fn whole_range(format: vk::Format) -> vk::ImageSubresourceRange {
    use vk::{Format as F, ImageAspectFlags as A};
    let aspect = match format {
        F::D32_SFLOAT | F::D16_UNORM | F::X8_D24_UNORM_PACK32 => A::DEPTH,
        F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    };
    vk::ImageSubresourceRange {
        aspect_mask: aspect,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: 1,
    }
}
