//! An allocator of the host's own, as plain as can be: one piece of Vulkan's memory for each that is asked for.

use ash::vk;
use impasto::gpu::{HostAllocation, HostMemory, MemoryKind};
use std::collections::BTreeMap;
use std::ptr::NonNull;
use std::sync::Mutex;

use super::Host;

pub struct Pieces {
    // Vulkan's own table, so that the counters see the library alone.
    device: ash::Device,
    types: vk::PhysicalDeviceMemoryProperties,
    held: Mutex<Held>,
}

#[derive(Default)]
struct Held {
    next: u64,
    pieces: BTreeMap<u64, (vk::DeviceMemory, u64, MemoryKind)>,
    /// How many pieces there were in all.
    count: BTreeMap<&'static str, u32>,
    /// No more than so many more are given.
    left: Option<u32>,
}

impl Pieces {
    pub fn new(host: &Host) -> Self {
        // SAFETY: the host's handles are live.
        unsafe {
            let device = ash::Device::load(host.instance.fp_v1_0(), host.device.handle());
            let types = host.instance.get_physical_device_memory_properties(host.physical);
            Pieces { device, types, held: Mutex::default() }
        }
    }

    fn held(&self) -> std::sync::MutexGuard<'_, Held> {
        self.held.lock().expect("no panic here")
    }

    /// How many pieces there are now, and how large they are.
    pub fn now(&self) -> (usize, u64) {
        let held = self.held();
        (held.pieces.len(), held.pieces.values().map(|(_, bytes, _)| bytes).sum())
    }

    /// How many pieces of each kind there were.
    pub fn counts(&self) -> BTreeMap<&'static str, u32> {
        self.held().count.clone()
    }

    /// Gives `left` more, and then no others.
    pub fn limit(&self, left: Option<u32>) {
        self.held().left = left;
    }
}

// SAFETY: every piece is memory of its own, of a type asked for, at its start, and mapped from beginning to end.
unsafe impl HostMemory for Pieces {
    fn allocate(
        &self,
        needs: &vk::MemoryRequirements,
        kind: MemoryKind,
        image: bool,
    ) -> Result<HostAllocation, vk::Result> {
        use vk::MemoryPropertyFlags as P;
        let mut held = self.held();
        match &mut held.left {
            Some(0) => return Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY),
            Some(left) => *left -= 1,
            None => {}
        }
        let (wanted, name) = match (kind, image) {
            (MemoryKind::Device, true) => (P::DEVICE_LOCAL, "image"),
            (MemoryKind::Device, false) => (P::DEVICE_LOCAL, "buffer"),
            (MemoryKind::Upload, _) => (P::HOST_VISIBLE | P::HOST_COHERENT, "upload"),
            (MemoryKind::Readback, _) => (P::HOST_VISIBLE | P::HOST_COHERENT, "readback"),
        };
        let types = &self.types.memory_types[..self.types.memory_type_count as usize];
        let fits = |(i, t): (usize, &vk::MemoryType)| {
            needs.memory_type_bits >> i & 1 == 1 && t.property_flags.contains(wanted)
        };
        let index = types.iter().enumerate().position(fits).ok_or(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY)?;
        // The library's object does not begin where the memory does.
        let offset = needs.alignment;
        let bytes = offset + needs.size;
        let info = vk::MemoryAllocateInfo::default().allocation_size(bytes).memory_type_index(index as u32);
        // SAFETY: plain Vulkan on a live device.
        let (memory, mapped) = unsafe {
            let memory = self.device.allocate_memory(&info, None)?;
            let mapped = match kind {
                MemoryKind::Device => None,
                _ => {
                    let start = self.device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
                    NonNull::new(start.cast::<u8>().add(offset as usize))
                }
            };
            (memory, mapped)
        };
        held.next += 1;
        let id = held.next;
        held.pieces.insert(id, (memory, needs.size, kind));
        *held.count.entry(name).or_default() += 1;
        Ok(HostAllocation { memory, offset, mapped, id })
    }

    unsafe fn free(&self, allocation: HostAllocation) {
        let (memory, _, _) = self.held().pieces.remove(&allocation.id).expect("a piece that was given, once");
        assert_eq!(memory, allocation.memory);
        // SAFETY: nothing is bound to it any more; freeing unmaps.
        unsafe { self.device.free_memory(memory, None) };
    }
}
