//! A context on which everything can be made and nothing is: to learn how much memory that would take.
//!
//! It stands between the library and the device. Buffers and images are made for as long as it takes to ask the driver
//! how large they are; pipelines, views and sets are not made at all, and memory comes from nowhere. So what is measured
//! is what the same code takes in earnest, without a formula beside it that could go stale.

use super::allocation::{HostAllocation, HostMemory, MemoryKind};
use super::context::{lock, Context};
use crate::Result;
use ash::vk;
use std::collections::HashMap;
use std::ffi::{c_void, CStr};
use std::ptr::NonNull;
use std::sync::{Arc, Mutex};

/// Memory that is counted, and only there where the host writes to it.
#[derive(Default)]
pub(crate) struct Measured(Mutex<Counts>);

#[derive(Default)]
struct Counts {
    now: u64,
    most: u64,
    next_id: u64,
    /// What pretends to be memory, with the bytes that it counts as.
    pieces: HashMap<u64, (u64, Box<[u8]>)>,
}

impl Measured {
    /// The most bytes that there were at a time.
    pub fn most_bytes(&self) -> u64 {
        lock(&self.0).most
    }
}

// SAFETY: nothing is ever bound to the memory, since binding does nothing here. What is mapped is as large as asked for,
// and is kept until it is freed.
unsafe impl HostMemory for Measured {
    fn allocate(
        &self,
        needs: &vk::MemoryRequirements,
        kind: MemoryKind,
        _: bool,
    ) -> std::result::Result<HostAllocation, vk::Result> {
        let mut counts = lock(&self.0);
        let bytes = if kind == MemoryKind::Device { 0 } else { needs.size as usize };
        let mut piece = vec![0; bytes].into_boxed_slice();
        let mapped = (kind != MemoryKind::Device).then(|| NonNull::from(&mut *piece).cast::<u8>());
        counts.now += needs.size;
        counts.most = counts.most.max(counts.now);
        counts.next_id += 1;
        let id = counts.next_id;
        counts.pieces.insert(id, (needs.size, piece));
        Ok(HostAllocation { memory: vk::DeviceMemory::null(), offset: 0, mapped, id })
    }

    unsafe fn free(&self, allocation: HostAllocation) {
        let mut counts = lock(&self.0);
        if let Some((bytes, _)) = counts.pieces.remove(&allocation.id) {
            counts.now -= bytes;
        }
    }
}

/// `vkCreate...` of whatever has a handle of 64 bits.
unsafe extern "system" fn make_nothing(
    _: vk::Device,
    _: *const c_void,
    _: *const c_void,
    handle: *mut u64,
) -> vk::Result {
    // SAFETY: the caller brought room for a handle.
    unsafe { handle.write(0) };
    vk::Result::SUCCESS
}

unsafe extern "system" fn make_no_pipelines(
    _: vk::Device,
    _: vk::PipelineCache,
    count: u32,
    _: *const c_void,
    _: *const c_void,
    pipelines: *mut vk::Pipeline,
) -> vk::Result {
    // SAFETY: the caller brought room for so many handles.
    unsafe { pipelines.write_bytes(0, count as usize) };
    vk::Result::SUCCESS
}

unsafe extern "system" fn make_no_sets(
    _: vk::Device,
    info: *const vk::DescriptorSetAllocateInfo<'_>,
    sets: *mut vk::DescriptorSet,
) -> vk::Result {
    // SAFETY: the caller brought a structure, and room for as many handles as it says.
    unsafe { sets.write_bytes(0, (*info).descriptor_set_count as usize) };
    vk::Result::SUCCESS
}

unsafe extern "system" fn update_nothing(_: vk::Device, _: u32, _: *const c_void, _: u32, _: *const c_void) {}

unsafe extern "system" fn bind_nothing(_: vk::Device, _: u64, _: vk::DeviceMemory, _: u64) -> vk::Result {
    vk::Result::SUCCESS
}

/// What stands for a function of the device, if it must not be called.
fn stand_in(name: &CStr) -> Option<*const c_void> {
    Some(match name.to_bytes() {
        b"vkCreateImageView"
        | b"vkCreateSampler"
        | b"vkCreateShaderModule"
        | b"vkCreatePipelineLayout"
        | b"vkCreateDescriptorSetLayout"
        | b"vkCreateDescriptorPool"
        | b"vkCreateRenderPass"
        | b"vkCreateFramebuffer"
        | b"vkCreateQueryPool" => make_nothing as *const c_void,
        b"vkCreateComputePipelines" | b"vkCreateGraphicsPipelines" => make_no_pipelines as *const c_void,
        b"vkAllocateDescriptorSets" => make_no_sets as *const c_void,
        b"vkUpdateDescriptorSets" => update_nothing as *const c_void,
        b"vkBindBufferMemory" | b"vkBindImageMemory" => bind_nothing as *const c_void,
        _ => return None,
    })
}

/// A measuring context on the device of `context`, with its budget, and what counts its memory. Nothing can be recorded
/// with what is made on it.
pub(crate) fn measuring(context: &Context) -> Result<(Context, Arc<Measured>)> {
    let inner = context.inner();
    let real = |name: &CStr| {
        // SAFETY: instance and device are live.
        let function = unsafe { inner.instance.get_device_proc_addr(inner.device.handle(), name.as_ptr()) };
        function.map_or(std::ptr::null(), |function| function as *const c_void)
    };
    // SAFETY: each function is the device's own or has its shape, and those that have a handle of something that was not
    // made take null.
    let device =
        unsafe { ash::Device::load_with(|name| stand_in(name).unwrap_or_else(|| real(name)), inner.device.handle()) };
    let measured = Arc::new(Measured::default());
    Ok((context.on_other_device(device, measured.clone())?, measured))
}
