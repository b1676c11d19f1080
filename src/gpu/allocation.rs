//! Where the memory of buffers and images comes from: an allocator of our own, or the host's.

use super::context::{lock, Context, Inner, LogLevel};
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::{AllocationCreateDesc, AllocationScheme, Allocator};
use gpu_allocator::{AllocationError, MemoryLocation};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// What memory is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MemoryKind {
    /// Touched by the GPU alone: device-local.
    Device,
    /// Written by the host, read by the GPU: mapped and coherent.
    Upload,
    /// Written by the GPU, read by the host: mapped and coherent, better cached.
    Readback,
}

/// A piece of a host's memory.
#[derive(Debug, Clone, Copy)]
pub struct HostAllocation {
    /// The memory that it lies in.
    pub memory: vk::DeviceMemory,
    /// Where it begins in there, bytes, aligned as was asked for.
    pub offset: u64,
    /// Where its first byte is mapped, for [`MemoryKind::Upload`] and [`MemoryKind::Readback`].
    pub mapped: Option<NonNull<u8>>,
    /// The host's own mark, which comes back with [`HostMemory::free`].
    pub id: u64,
}

// SAFETY: what `mapped` points to may be touched from any thread (`HostMemory`); whoever holds the allocation sees to it
// that nobody else does so at the same time.
unsafe impl Send for HostAllocation {}
// SAFETY: as above; a shared allocation is only read.
unsafe impl Sync for HostAllocation {}

/// A host's allocator, for hosts that want all memory to be their own; [`super::HostDevice::memory`]. The library then
/// never calls `vkAllocateMemory` itself. Called from any thread that makes or drops objects, or advances the context;
/// it must not call the library.
///
/// # Safety
/// What is allocated must be memory of the context's device, as large and as aligned as is asked for, of one of the
/// types asked for and of the kind, apart from all that is in use (images and buffers at least `bufferImageGranularity`
/// apart), and stay so and mapped until it is freed.
pub unsafe trait HostMemory: Send + Sync {
    /// A piece of memory for a buffer or, if `image`, for an image with optimal tiling.
    ///
    /// # Errors
    /// What Vulkan answered, as `VK_ERROR_OUT_OF_DEVICE_MEMORY`.
    fn allocate(
        &self,
        needs: &vk::MemoryRequirements,
        kind: MemoryKind,
        image: bool,
    ) -> std::result::Result<HostAllocation, vk::Result>;

    /// Takes a piece back: what was bound to it is destroyed.
    ///
    /// # Safety
    /// It must be one that [`HostMemory::allocate`] gave, once.
    unsafe fn free(&self, allocation: HostAllocation);
}

/// All memory of a context, with how much of it is in use.
pub(crate) struct Memory {
    source: Source,
    /// Bytes that objects take now.
    allocated: AtomicU64,
}

enum Source {
    /// `None` once the context is being torn down.
    Own(Mutex<Option<Box<Allocator>>>),
    Host(Arc<dyn HostMemory>),
}

/// A piece of memory that an object is bound to.
pub(crate) struct Allocation {
    piece: Piece,
    bytes: u64,
}

enum Piece {
    Own(gpu_allocator::vulkan::Allocation),
    Host(HostAllocation),
}

impl Memory {
    pub fn own(allocator: Allocator) -> Self {
        Memory { source: Source::Own(Mutex::new(Some(Box::new(allocator)))), allocated: AtomicU64::new(0) }
    }

    pub fn of_host(memory: Arc<dyn HostMemory>) -> Self {
        Memory { source: Source::Host(memory), allocated: AtomicU64::new(0) }
    }

    /// Bytes that objects take now.
    pub fn allocated_bytes(&self) -> u64 {
        self.allocated.load(Ordering::Relaxed)
    }

    /// Takes so many bytes out of the budget, or answers with how many are left: several threads may ask at once.
    fn reserve(&self, bytes: u64, budget: u64) -> Result<(), u64> {
        let more = |now: u64| now.checked_add(bytes).filter(|sum| *sum <= budget);
        let reserved = self.allocated.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        reserved.map(drop).map_err(|now| budget.saturating_sub(now))
    }

    /// A piece of memory whose bytes are reserved.
    fn allocate(
        &self,
        name: &str,
        needs: vk::MemoryRequirements,
        kind: MemoryKind,
        image: bool,
    ) -> Result<Allocation, Failure> {
        let piece = match &self.source {
            Source::Own(allocator) => {
                let mut allocator = lock(allocator);
                let allocator = allocator.as_mut().ok_or(Failure::TornDown)?;
                let location = match kind {
                    MemoryKind::Device => MemoryLocation::GpuOnly,
                    MemoryKind::Upload => MemoryLocation::CpuToGpu,
                    MemoryKind::Readback => MemoryLocation::GpuToCpu,
                };
                let desc = AllocationCreateDesc {
                    name,
                    requirements: needs,
                    location,
                    linear: !image,
                    allocation_scheme: AllocationScheme::GpuAllocatorManaged,
                };
                Piece::Own(allocator.allocate(&desc).map_err(Failure::Own)?)
            }
            Source::Host(memory) => {
                let allocation = memory.allocate(&needs, kind, image).map_err(Failure::Host)?;
                if kind != MemoryKind::Device && allocation.mapped.is_none() {
                    // SAFETY: it was just allocated, and nothing is bound to it.
                    unsafe { memory.free(allocation) };
                    return Err(Failure::NotMapped);
                }
                Piece::Host(allocation)
            }
        };
        Ok(Allocation { piece, bytes: needs.size })
    }

    /// Takes back what nothing is bound to any more.
    pub fn free(&self, allocation: Allocation) {
        self.allocated.fetch_sub(allocation.bytes, Ordering::Relaxed);
        match (allocation.piece, &self.source) {
            (Piece::Own(piece), Source::Own(allocator)) => {
                if let Some(allocator) = lock(allocator).as_mut() {
                    // Freeing only fails for a foreign allocation, and these are all the allocator's own.
                    let _ = allocator.free(piece);
                }
            }
            // SAFETY: the host gave it, and allocations are neither cloned nor kept.
            (Piece::Host(piece), Source::Host(memory)) => unsafe { memory.free(piece) },
            // There is one source for as long as the context lives.
            (Piece::Own(_), Source::Host(_)) | (Piece::Host(_), Source::Own(_)) => {}
        }
    }

    /// Gives blocks of memory back to Vulkan, while the device still lives.
    pub fn close(&self) {
        if let Source::Own(allocator) = &self.source {
            drop(lock(allocator).take());
        }
    }
}

impl Allocation {
    pub fn memory(&self) -> vk::DeviceMemory {
        match &self.piece {
            // SAFETY: the handle is only bound to, and the piece is kept until what is bound is destroyed.
            Piece::Own(piece) => unsafe { piece.memory() },
            Piece::Host(piece) => piece.memory,
        }
    }

    pub fn offset(&self) -> u64 {
        match &self.piece {
            Piece::Own(piece) => piece.offset(),
            Piece::Host(piece) => piece.offset,
        }
    }

    fn mapped_ptr(&self) -> Option<NonNull<u8>> {
        match &self.piece {
            Piece::Own(piece) => piece.mapped_ptr().map(NonNull::cast),
            Piece::Host(piece) => piece.mapped,
        }
    }

    /// Its bytes, where they are mapped.
    pub fn mapped(&self) -> Option<&[u8]> {
        let bytes = usize::try_from(self.bytes).ok()?;
        // SAFETY: so many bytes are mapped there for as long as the allocation lives, and shared they are only read.
        self.mapped_ptr().map(|at| unsafe { std::slice::from_raw_parts(at.as_ptr(), bytes) })
    }

    /// Its bytes, where they are mapped, to be written.
    pub fn mapped_mut(&mut self) -> Option<&mut [u8]> {
        let bytes = usize::try_from(self.bytes).ok()?;
        // SAFETY: as above, and nobody else has the allocation.
        self.mapped_ptr().map(|at| unsafe { std::slice::from_raw_parts_mut(at.as_ptr(), bytes) })
    }
}

enum Failure {
    TornDown,
    NotMapped,
    Own(AllocationError),
    Host(vk::Result),
}

/// Memory for an object, if the context's budget allows it.
///
/// # Errors
/// [`Error::Memory`] when the budget does not allow it; [`Error::Vulkan`] when the device or the host has no more, and
/// then the log tells what it was for.
pub(crate) fn allocate(
    context: &Context,
    name: &str,
    needs: vk::MemoryRequirements,
    kind: MemoryKind,
    image: bool,
) -> Result<Allocation> {
    let Inner { memory, budget, .. } = context.inner();
    let over = |available| Error::Memory { what: name.to_owned(), needed: needs.size, available };
    memory.reserve(needs.size, *budget).map_err(over)?;
    memory.allocate(name, needs, kind, image).map_err(|failure| {
        memory.allocated.fetch_sub(needs.size, Ordering::Relaxed);
        let error = match failure {
            Failure::TornDown => return Error::Device("the context is being torn down".to_owned()),
            Failure::NotMapped => return Error::Device(format!("{name}: the host's memory is not mapped")),
            Failure::Own(AllocationError::OutOfMemory) => {
                context.failed("vkAllocateMemory")(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY)
            }
            Failure::Own(AllocationError::FailedToMap(_)) => {
                context.failed("vkMapMemory")(vk::Result::ERROR_MEMORY_MAP_FAILED)
            }
            Failure::Own(error) => Error::Device(format!("{name}: {} bytes could not be had: {error}", needs.size)),
            Failure::Host(result) => context.failed("HostMemory::allocate")(result),
        };
        context.log(LogLevel::Error, &format!("{name}: {} bytes of GPU memory could not be had: {error}", needs.size));
        error
    })
}

/// # Errors
/// [`Error::Memory`] when the context's budget does not allow so many more bytes.
pub(crate) fn check_budget(context: &Context, name: &str, bytes: u64) -> Result<()> {
    let available = context.inner().budget.saturating_sub(context.allocated_bytes());
    if bytes > available {
        return Err(Error::Memory { what: name.to_owned(), needed: bytes, available });
    }
    Ok(())
}
