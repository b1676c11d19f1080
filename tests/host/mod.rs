//! A host that knows nothing of the library: an instance, a device, a queue and command buffers made with plain ash.
//!
//! Its device has no extension and no feature. Validation, with synchronisation, watches all of it; the messages are
//! what [`Host::destroy`] returns, after the layer has had its chance to report what was left over.
#![allow(dead_code)]

pub mod calls;
pub mod memory;

use ash::vk;
use impasto::gpu::HostDevice;
use std::ffi::{c_char, c_void, CStr};
use std::sync::Mutex;

pub struct Host {
    // Keeps the loader's library mapped.
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub device: ash::Device,
    pub family: u32,
    pub queue: vk::Queue,
    pool: vk::CommandPool,
    fence: vk::Fence,
    messenger: vk::DebugUtilsMessengerEXT,
    // Boxed: the messenger points to it.
    messages: Box<Mutex<Vec<String>>>,
}

unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes a valid structure, and the pointer that the messenger was made with.
    let (text, messages) = unsafe { ((*data).message_as_c_str(), &*user.cast::<Mutex<Vec<String>>>()) };
    let text = text.map(CStr::to_string_lossy).unwrap_or_default().into_owned();
    if let Ok(mut messages) = messages.lock() {
        messages.push(text);
    }
    vk::FALSE
}

/// An image with memory of its own that the host made itself.
pub struct HostImage {
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub memory: vk::DeviceMemory,
    pub format: vk::Format,
    pub usage: vk::ImageUsageFlags,
    pub size: (u32, u32),
}

/// A number that the GPU sets when it has run all that was recorded before, seen without a wait.
pub struct Flag(HostBuffer);

impl Flag {
    pub fn is_set(&self, host: &Host) -> bool {
        host.map(&self.0, |bytes| bytes == [1, 0, 0, 0])
    }

    pub fn destroy(self, host: &Host) {
        host.destroy_buffer(self.0);
    }
}

struct HostBuffer {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    bytes: u64,
}

// SAFETY, for all of this file: plain Vulkan as its specification wants it, on handles that `Host` owns and destroys
// once; the validation layer would say if it were not.
impl Host {
    pub fn new() -> Self {
        unsafe {
            let entry = ash::Entry::load().expect("a Vulkan loader");
            let layers: [*const c_char; 1] = [c"VK_LAYER_KHRONOS_validation".as_ptr()];
            let extensions = [ash::ext::debug_utils::NAME.as_ptr(), ash::ext::validation_features::NAME.as_ptr()];
            let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
            let app = vk::ApplicationInfo::default().application_name(c"host").api_version(vk::API_VERSION_1_1);
            let info = vk::InstanceCreateInfo::default()
                .application_info(&app)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
            let instance = entry.create_instance(&info, None).expect("an instance");
            let messages = Box::new(Mutex::new(Vec::new()));
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(
                    vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
                )
                .message_type(
                    vk::DebugUtilsMessageTypeFlagsEXT::GENERAL
                        | vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                        | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
                )
                .pfn_user_callback(Some(on_message))
                .user_data(std::ptr::from_ref(&*messages).cast::<c_void>().cast_mut());
            let debug = ash::ext::debug_utils::Instance::new(&entry, &instance);
            let messenger = debug.create_debug_utils_messenger(&info, None).expect("a messenger");

            let physical = instance.enumerate_physical_devices().expect("devices")[0];
            let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
            let families = instance.get_physical_device_queue_family_properties(physical);
            let family = families.iter().position(|f| f.queue_flags.contains(both)).expect("a queue") as u32;
            let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
            let made = instance.create_device(physical, &info, None).expect("a device");
            // The same device, with counters in front of some of its functions.
            let device = ash::Device::load_with(
                |name| {
                    let real = instance.get_device_proc_addr(made.handle(), name.as_ptr());
                    calls::hooked(name, real.map_or(std::ptr::null(), |f| f as *const c_void))
                },
                made.handle(),
            );
            let queue = device.get_device_queue(family, 0);
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None).expect("a command pool");
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).expect("a fence");
            Host { entry, instance, physical, device, family, queue, pool, fence, messenger, messages }
        }
    }

    /// What an engine that uses ash hands over.
    pub fn lent(&self) -> HostDevice {
        HostDevice {
            instance: self.instance.clone(),
            physical_device: self.physical,
            device: self.device.clone(),
            queue_family: self.family,
            enabled_features: vk::PhysicalDeviceFeatures::default(),
            pipeline_cache: vk::PipelineCache::null(),
            debug_utils: true,
            memory_budget: None,
            log: None,
            memory: None,
        }
    }

    /// What an engine that does not use ash hands over.
    pub fn lent_raw(&self) -> HostDevice {
        let loader = self.entry.static_fn().get_instance_proc_addr;
        let (instance, device) = (self.instance.handle(), self.device.handle());
        unsafe { HostDevice::from_raw(loader, instance, self.physical, device, self.family) }
    }

    /// The messages so far; taking them means that they are expected.
    pub fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut *self.messages.lock().expect("no panic here"))
    }

    /// A command buffer in the recording state.
    pub fn begin(&self) -> vk::CommandBuffer {
        unsafe {
            let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
            let commands = self.device.allocate_command_buffers(&info).expect("a command buffer")[0];
            self.begin_again(commands);
            commands
        }
    }

    /// Starts a command buffer afresh.
    pub fn begin_again(&self, commands: vk::CommandBuffer) {
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        unsafe { self.device.begin_command_buffer(commands, &info) }.expect("begin");
    }

    pub fn end(&self, commands: vk::CommandBuffer) {
        unsafe { self.device.end_command_buffer(commands) }.expect("end");
    }

    /// Submits ended command buffers in one go, without a wait.
    pub fn submit(&self, commands: &[vk::CommandBuffer]) {
        let info = [vk::SubmitInfo::default().command_buffers(commands)];
        unsafe { self.device.queue_submit(self.queue, &info, self.fence) }.expect("submit");
    }

    /// Waits for what was submitted last.
    pub fn wait(&self) {
        unsafe {
            self.device.wait_for_fences(&[self.fence], true, 60_000_000_000).expect("wait");
            self.device.reset_fences(&[self.fence]).expect("reset");
        }
    }

    /// Records with `record`, submits, waits.
    pub fn run(&self, record: impl FnOnce(vk::CommandBuffer)) {
        let commands = self.begin();
        record(commands);
        self.end(commands);
        self.submit(&[commands]);
        self.wait();
        unsafe { self.device.free_command_buffers(self.pool, &[commands]) };
    }

    fn memory(&self, needs: vk::MemoryRequirements, wanted: vk::MemoryPropertyFlags) -> vk::DeviceMemory {
        unsafe {
            let all = self.instance.get_physical_device_memory_properties(self.physical);
            let fits = |i: &u32| {
                needs.memory_type_bits & (1 << i) != 0 && all.memory_types[*i as usize].property_flags.contains(wanted)
            };
            let index = (0..all.memory_type_count).find(fits).expect("a type of memory");
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
            self.device.allocate_memory(&info, None).expect("memory")
        }
    }

    fn buffer(&self, bytes: u64, usage: vk::BufferUsageFlags) -> HostBuffer {
        unsafe {
            let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
            let buffer = self.device.create_buffer(&info, None).expect("a buffer");
            let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let memory = self.memory(self.device.get_buffer_memory_requirements(buffer), visible);
            self.device.bind_buffer_memory(buffer, memory, 0).expect("bind");
            HostBuffer { buffer, memory, bytes }
        }
    }

    /// The bytes of a host-visible buffer, through `with`.
    fn map<R>(&self, buffer: &HostBuffer, with: impl FnOnce(&mut [u8]) -> R) -> R {
        unsafe {
            let at = self.device.map_memory(buffer.memory, 0, buffer.bytes, vk::MemoryMapFlags::empty()).expect("map");
            let value = with(std::slice::from_raw_parts_mut(at.cast::<u8>(), buffer.bytes as usize));
            self.device.unmap_memory(buffer.memory);
            value
        }
    }

    fn destroy_buffer(&self, buffer: HostBuffer) {
        unsafe {
            self.device.destroy_buffer(buffer.buffer, None);
            self.device.free_memory(buffer.memory, None);
        }
    }

    /// Whether such depth can be drawn to and copied.
    pub fn draws_depth(&self, format: vk::Format) -> bool {
        use vk::FormatFeatureFlags as F;
        let needed = F::DEPTH_STENCIL_ATTACHMENT | F::TRANSFER_SRC | F::TRANSFER_DST;
        let offered = unsafe { self.instance.get_physical_device_format_properties(self.physical, format) };
        offered.optimal_tiling_features.contains(needed)
    }

    /// An image that nothing was written to.
    pub fn image(&self, format: vk::Format, usage: vk::ImageUsageFlags, size: (u32, u32)) -> HostImage {
        unsafe {
            let info = vk::ImageCreateInfo::default()
                .image_type(vk::ImageType::TYPE_2D)
                .format(format)
                .extent(vk::Extent3D { width: size.0, height: size.1, depth: 1 })
                .mip_levels(1)
                .array_layers(1)
                .samples(vk::SampleCountFlags::TYPE_1)
                .usage(usage);
            let image = self.device.create_image(&info, None).expect("an image");
            let memory =
                self.memory(self.device.get_image_memory_requirements(image), vk::MemoryPropertyFlags::empty());
            self.device.bind_image_memory(image, memory, 0).expect("bind");
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(whole(aspect(format)));
            let view = self.device.create_image_view(&info, None).expect("a view");
            HostImage { image, view, memory, format, usage, size }
        }
    }

    /// Writes all texels, and after them the bytes of a stencil, wherever the image lay; it is left in the layout of a
    /// copy's destination.
    pub fn write_image(&self, to: &HostImage, texels: &[u8]) {
        let staging = self.buffer(texels.len() as u64, vk::BufferUsageFlags::TRANSFER_SRC);
        self.map(&staging, |bytes| bytes.copy_from_slice(texels));
        let (layout, aspect) = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, aspect(to.format));
        self.run(|commands| {
            self.barrier(commands, to.image, aspect, [vk::ImageLayout::UNDEFINED, layout]);
            let regions = regions(to.size, aspect, texel_bytes(to.format));
            unsafe { self.device.cmd_copy_buffer_to_image(commands, staging.buffer, to.image, layout, &regions) };
        });
        self.destroy_buffer(staging);
    }

    pub fn destroy_image(&self, image: HostImage) {
        unsafe {
            self.device.destroy_image_view(image.view, None);
            self.device.destroy_image(image.image, None);
            self.device.free_memory(image.memory, None);
        }
    }

    /// Waits for everything before it, and makes all of it visible to everything after it.
    fn barrier(
        &self,
        commands: vk::CommandBuffer,
        image: vk::Image,
        aspect: vk::ImageAspectFlags,
        [from, to]: [vk::ImageLayout; 2],
    ) {
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let access = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(access)
            .dst_access_mask(access)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image)
            .subresource_range(whole(aspect))];
        let none = vk::DependencyFlags::empty();
        unsafe { self.device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &barrier) };
    }

    /// Records the setting of a flag as the last command.
    pub fn flag_when_done(&self, commands: vk::CommandBuffer) -> Flag {
        let flag = self.buffer(4, vk::BufferUsageFlags::TRANSFER_DST);
        self.map(&flag, |bytes| bytes.fill(0));
        let (all, copy) = (vk::PipelineStageFlags::ALL_COMMANDS, vk::PipelineStageFlags::TRANSFER);
        unsafe {
            self.device.cmd_pipeline_barrier(commands, all, copy, vk::DependencyFlags::empty(), &[], &[], &[]);
            self.device.cmd_fill_buffer(commands, flag.buffer, 0, 4, 1);
        }
        Flag(flag)
    }

    /// The texels (four bytes each) of a colour image that lies in `layout`, and is left in it.
    pub fn read_image(&self, image: vk::Image, layout: vk::ImageLayout, size: (u32, u32)) -> Vec<u8> {
        self.read(image, vk::ImageAspectFlags::COLOR, layout, size)
    }

    /// The same of an image of the host's own, colour or depth.
    pub fn read_own(&self, image: &HostImage, layout: vk::ImageLayout) -> Vec<u8> {
        self.read_texels(image.image, aspect(image.format), layout, image.size, texel_bytes(image.format))
    }

    pub fn read(
        &self,
        image: vk::Image,
        aspect: vk::ImageAspectFlags,
        layout: vk::ImageLayout,
        size: (u32, u32),
    ) -> Vec<u8> {
        self.read_texels(image, aspect, layout, size, 4)
    }

    fn read_texels(
        &self,
        image: vk::Image,
        aspect: vk::ImageAspectFlags,
        layout: vk::ImageLayout,
        size: (u32, u32),
        texel_bytes: u64,
    ) -> Vec<u8> {
        let stencil = u64::from(aspect.contains(vk::ImageAspectFlags::STENCIL));
        let bytes = u64::from(size.0 * size.1) * (texel_bytes + stencil);
        let buffer = self.buffer(bytes, vk::BufferUsageFlags::TRANSFER_DST);
        let from = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        self.run(|commands| {
            self.barrier(commands, image, aspect, [layout, from]);
            let regions = regions(size, aspect, texel_bytes);
            unsafe { self.device.cmd_copy_image_to_buffer(commands, image, from, buffer.buffer, &regions) };
            self.barrier(commands, image, aspect, [from, layout]);
        });
        let bytes = self.map(&buffer, |bytes| bytes.to_vec());
        self.destroy_buffer(buffer);
        bytes
    }

    /// Destroys what the host made, the device last; all messages that were not taken.
    pub fn destroy(self) -> Vec<String> {
        unsafe {
            self.device.device_wait_idle().expect("idle");
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            let debug = ash::ext::debug_utils::Instance::new(&self.entry, &self.instance);
            debug.destroy_debug_utils_messenger(self.messenger, None);
            self.instance.destroy_instance(None);
        }
        self.take_messages()
    }
}

/// What an image must be made for to be a guide or a canvas.
pub fn usage() -> vk::ImageUsageFlags {
    vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST
}

fn aspect(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::{Format as F, ImageAspectFlags as A};
    match format {
        F::D32_SFLOAT | F::D16_UNORM | F::X8_D24_UNORM_PACK32 => A::DEPTH,
        F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    }
}

/// Bytes of a texel's colour or depth in a buffer.
fn texel_bytes(format: vk::Format) -> u64 {
    match format {
        vk::Format::D16_UNORM => 2,
        vk::Format::R32G32_SFLOAT | vk::Format::R16G16B16A16_SFLOAT => 8,
        _ => 4,
    }
}

fn whole(aspect_mask: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange { aspect_mask, level_count: 1, layer_count: 1, ..Default::default() }
}

/// Colour or depth, and then the stencil, one after the other in a buffer.
fn regions(size: (u32, u32), aspect: vk::ImageAspectFlags, texel_bytes: u64) -> Vec<vk::BufferImageCopy> {
    use vk::ImageAspectFlags as A;
    let texels = u64::from(size.0 * size.1);
    let parts = [A::COLOR, A::DEPTH, A::STENCIL].into_iter().filter(|part| aspect.contains(*part));
    let region = |aspect_mask| vk::BufferImageCopy {
        buffer_offset: if aspect_mask == A::STENCIL { texels * texel_bytes } else { 0 },
        image_subresource: vk::ImageSubresourceLayers { aspect_mask, layer_count: 1, ..Default::default() },
        image_extent: vk::Extent3D { width: size.0, height: size.1, depth: 1 },
        ..Default::default()
    };
    parts.map(region).collect()
}
