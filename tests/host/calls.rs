//! Counts calls of device functions, and makes some of them fail, by standing between the host's function table and
//! Vulkan. Each thread has counts and faults of its own.

use ash::vk;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::{c_void, CStr};
use std::sync::Mutex;

/// Vulkan's own functions, as numbers, because pointers to functions of different types are kept side by side. They are
/// the same for all devices that are made in the same way, as the tests' hosts are.
static REAL: Mutex<BTreeMap<&'static str, usize>> = Mutex::new(BTreeMap::new());

thread_local! {
    static COUNTS: RefCell<BTreeMap<&'static str, u32>> = const { RefCell::new(BTreeMap::new()) };
    static FAULT: RefCell<Option<Fault>> = const { RefCell::new(None) };
}

/// A function that is to fail.
#[derive(Debug, Clone, Copy)]
struct Fault {
    name: &'static str,
    /// So many calls go through first.
    after: u32,
    result: vk::Result,
    failed: u32,
}

/// How often this thread has called each of the counted functions since the last time; those that it has called.
pub fn take() -> BTreeMap<&'static str, u32> {
    COUNTS.take()
}

/// Makes a function fail with `result` in this thread, without a call of Vulkan, once `after` more calls have gone
/// through, and from then on until [`heal`].
pub fn fail(name: &'static str, after: u32, result: vk::Result) {
    FAULT.set(Some(Fault { name, after, result, failed: 0 }));
}

/// From here on no function fails; how many calls did.
pub fn heal() -> u32 {
    FAULT.take().map_or(0, |fault| fault.failed)
}

/// Notes a call; Vulkan's own function, or what the call is to fail with.
fn note(name: &'static str) -> Result<usize, vk::Result> {
    COUNTS.with_borrow_mut(|counts| *counts.entry(name).or_default() += 1);
    FAULT.with_borrow_mut(|fault| match fault.as_mut().filter(|fault| fault.name == name) {
        Some(fault) if fault.after == 0 => {
            fault.failed += 1;
            Err(fault.result)
        }
        Some(fault) => {
            fault.after -= 1;
            Ok(())
        }
        None => Ok(()),
    })?;
    Ok(*REAL.lock().expect("no panic here").get(name).expect("a device was loaded"))
}

/// What a function answers when it is made to fail.
trait Answer {
    fn failed(result: vk::Result) -> Self;
}

impl Answer for vk::Result {
    fn failed(result: vk::Result) -> Self {
        result
    }
}

impl Answer for () {
    fn failed(_: vk::Result) {}
}

/// One counting function for each that is listed, and the table of them. Where one fails, `out` becomes null.
macro_rules! counted {
    ($($name:ident($($argument:ident: $kind:ty),* $(; $out:ident: *mut $made:ty)?) $(-> $result:ty)?;)*) => {
        mod functions {
            use super::*;
            $(
                #[allow(non_snake_case)]
                pub unsafe extern "system" fn $name(
                    $($argument: $kind,)* $($out: *mut $made)?
                ) $(-> $result)? {
                    type Real = unsafe extern "system" fn($($kind,)* $(*mut $made)?) $(-> $result)?;
                    match note(stringify!($name)) {
                        // SAFETY: this is what Vulkan gave for the function of this name and type.
                        Ok(real) => unsafe {
                            std::mem::transmute::<usize, Real>(real)($($argument,)* $($out)?)
                        },
                        Err(result) => {
                            // SAFETY: the library asks for one object at a time, and its place may be all zeros.
                            $(unsafe { $out.write_bytes(0, 1) };)?
                            Answer::failed(result)
                        }
                    }
                }
            )*
        }

        /// The counting function that stands for `real`, or `real` where there is none.
        pub fn hooked(name: &CStr, real: *const c_void) -> *const c_void {
            let (name, hook) = match name.to_bytes() {
                $(name if name == stringify!($name).as_bytes() => {
                    (stringify!($name), functions::$name as *const c_void)
                })*
                _ => return real,
            };
            REAL.lock().expect("no panic here").insert(name, real as usize);
            hook
        }
    };
}

type Device = vk::Device;
type Callbacks = *const vk::AllocationCallbacks<'static>;

counted! {
    // Submitting and waiting.
    vkQueueSubmit(queue: vk::Queue, count: u32, infos: *const vk::SubmitInfo<'static>, fence: vk::Fence) -> vk::Result;
    vkQueueBindSparse(
        queue: vk::Queue, count: u32, infos: *const vk::BindSparseInfo<'static>, fence: vk::Fence
    ) -> vk::Result;
    vkQueueWaitIdle(queue: vk::Queue) -> vk::Result;
    vkDeviceWaitIdle(device: Device) -> vk::Result;
    vkWaitForFences(device: Device, count: u32, fences: *const vk::Fence, all: vk::Bool32, timeout: u64) -> vk::Result;
    vkGetFenceStatus(device: Device, fence: vk::Fence) -> vk::Result;
    vkResetFences(device: Device, count: u32, fences: *const vk::Fence) -> vk::Result;
    // Memory.
    vkAllocateMemory(
        device: Device, info: *const vk::MemoryAllocateInfo<'static>, c: Callbacks; out: *mut vk::DeviceMemory
    ) -> vk::Result;
    vkFreeMemory(device: Device, memory: vk::DeviceMemory, c: Callbacks);
    vkMapMemory(
        device: Device, memory: vk::DeviceMemory, at: u64, size: u64, flags: vk::MemoryMapFlags; out: *mut *mut c_void
    ) -> vk::Result;
    vkBindBufferMemory(device: Device, buffer: vk::Buffer, memory: vk::DeviceMemory, at: u64) -> vk::Result;
    vkBindImageMemory(device: Device, image: vk::Image, memory: vk::DeviceMemory, at: u64) -> vk::Result;
    // Objects.
    vkCreateBuffer(
        device: Device, info: *const vk::BufferCreateInfo<'static>, c: Callbacks; out: *mut vk::Buffer
    ) -> vk::Result;
    vkDestroyBuffer(device: Device, buffer: vk::Buffer, c: Callbacks);
    vkCreateImage(
        device: Device, info: *const vk::ImageCreateInfo<'static>, c: Callbacks; out: *mut vk::Image
    ) -> vk::Result;
    vkDestroyImage(device: Device, image: vk::Image, c: Callbacks);
    vkCreateImageView(
        device: Device, info: *const vk::ImageViewCreateInfo<'static>, c: Callbacks; out: *mut vk::ImageView
    ) -> vk::Result;
    vkCreateSampler(
        device: Device, info: *const vk::SamplerCreateInfo<'static>, c: Callbacks; out: *mut vk::Sampler
    ) -> vk::Result;
    vkCreateShaderModule(
        device: Device, info: *const vk::ShaderModuleCreateInfo<'static>, c: Callbacks; out: *mut vk::ShaderModule
    ) -> vk::Result;
    vkCreatePipelineLayout(
        device: Device, info: *const vk::PipelineLayoutCreateInfo<'static>, c: Callbacks; out: *mut vk::PipelineLayout
    ) -> vk::Result;
    vkCreatePipelineCache(
        device: Device, info: *const vk::PipelineCacheCreateInfo<'static>, c: Callbacks; out: *mut vk::PipelineCache
    ) -> vk::Result;
    vkCreateComputePipelines(
        device: Device, cache: vk::PipelineCache, count: u32, infos: *const vk::ComputePipelineCreateInfo<'static>,
        c: Callbacks; out: *mut vk::Pipeline
    ) -> vk::Result;
    vkCreateGraphicsPipelines(
        device: Device, cache: vk::PipelineCache, count: u32, infos: *const vk::GraphicsPipelineCreateInfo<'static>,
        c: Callbacks; out: *mut vk::Pipeline
    ) -> vk::Result;
    vkDestroyPipeline(device: Device, pipeline: vk::Pipeline, c: Callbacks);
    vkCreateRenderPass(
        device: Device, info: *const vk::RenderPassCreateInfo<'static>, c: Callbacks; out: *mut vk::RenderPass
    ) -> vk::Result;
    vkCreateFramebuffer(
        device: Device, info: *const vk::FramebufferCreateInfo<'static>, c: Callbacks; out: *mut vk::Framebuffer
    ) -> vk::Result;
    vkCreateDescriptorSetLayout(
        device: Device, info: *const vk::DescriptorSetLayoutCreateInfo<'static>, c: Callbacks;
        out: *mut vk::DescriptorSetLayout
    ) -> vk::Result;
    vkCreateDescriptorPool(
        device: Device, info: *const vk::DescriptorPoolCreateInfo<'static>, c: Callbacks; out: *mut vk::DescriptorPool
    ) -> vk::Result;
    vkDestroyDescriptorPool(device: Device, pool: vk::DescriptorPool, c: Callbacks);
    vkAllocateDescriptorSets(
        device: Device, info: *const vk::DescriptorSetAllocateInfo<'static>; out: *mut vk::DescriptorSet
    ) -> vk::Result;
    vkUpdateDescriptorSets(
        device: Device, writes: u32, write: *const vk::WriteDescriptorSet<'static>, copies: u32,
        copy: *const vk::CopyDescriptorSet<'static>
    );
    vkCreateQueryPool(
        device: Device, info: *const vk::QueryPoolCreateInfo<'static>, c: Callbacks; out: *mut vk::QueryPool
    ) -> vk::Result;
    vkGetQueryPoolResults(
        device: Device, pool: vk::QueryPool, first: u32, count: u32, bytes: usize, data: *mut c_void, stride: u64,
        flags: vk::QueryResultFlags
    ) -> vk::Result;
    vkCreateFence(
        device: Device, info: *const vk::FenceCreateInfo<'static>, c: Callbacks; out: *mut vk::Fence
    ) -> vk::Result;
    vkCreateSemaphore(
        device: Device, info: *const vk::SemaphoreCreateInfo<'static>, c: Callbacks; out: *mut vk::Semaphore
    ) -> vk::Result;
    vkCreateCommandPool(
        device: Device, info: *const vk::CommandPoolCreateInfo<'static>, c: Callbacks; out: *mut vk::CommandPool
    ) -> vk::Result;
    vkAllocateCommandBuffers(
        device: Device, info: *const vk::CommandBufferAllocateInfo<'static>; out: *mut vk::CommandBuffer
    ) -> vk::Result;
    vkBeginCommandBuffer(commands: vk::CommandBuffer, info: *const vk::CommandBufferBeginInfo<'static>) -> vk::Result;
    vkEndCommandBuffer(commands: vk::CommandBuffer) -> vk::Result;
    // Commands, to know that the counting works.
    vkCmdDispatch(commands: vk::CommandBuffer, x: u32, y: u32, z: u32);
    vkCmdDrawIndexed(commands: vk::CommandBuffer, indices: u32, instances: u32, first: u32, offset: i32, instance: u32);
}
