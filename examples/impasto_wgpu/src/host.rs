//! The host: wgpu's device, its frames in flight, and what it reads back. Nothing here knows of impasto.

use crate::scene::PICTURE;
use crate::Result;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use wgpu::hal::vulkan;

/// Frames that the device may still be busy with while the next is recorded.
pub const IN_FLIGHT: u64 = 2;

/// Pixels of a picture, rows from the top.
pub type Picture = Vec<[u8; 4]>;

struct Submitted {
    frame: u64,
    index: wgpu::SubmissionIndex,
    /// Its picture is wanted.
    keep: bool,
}

pub struct Host {
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// The device is lost: told by wgpu, perhaps from another thread.
    pub lost: Arc<AtomicBool>,
    readback: Vec<wgpu::Buffer>,
    submitted: VecDeque<Submitted>,
    /// The frame that is recorded now; the first is 1.
    pub frame: u64,
    /// The pictures of the frames that were kept, in their order.
    pub pictures: Vec<Picture>,
}

impl Host {
    pub fn new(validation: bool) -> Result<Self> {
        let instance = if validation { validated_instance()? } else { instance() };
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        // No feature and no limit is asked for on impasto's behalf: it needs none.
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let lost = Arc::new(AtomicBool::new(false));
        let told = lost.clone();
        device.set_device_lost_callback(move |_, _| told.store(true, Ordering::Relaxed));
        let readback = (0..IN_FLIGHT)
            .map(|_| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("readback"),
                    size: u64::from(4 * PICTURE[0] * PICTURE[1]),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                })
            })
            .collect();
        Ok(Host { adapter, device, queue, lost, readback, submitted: VecDeque::new(), frame: 0, pictures: Vec::new() })
    }

    /// Begins a frame: waits until no more than `IN_FLIGHT - 1` others are on their way. Answers with the number of the
    /// last frame that the device is done with.
    pub fn begin_frame(&mut self) -> Result<u64> {
        while self.submitted.len() as u64 >= IN_FLIGHT {
            self.collect()?;
        }
        let safe = self.frame - self.submitted.len() as u64;
        self.frame += 1;
        Ok(safe)
    }

    /// The buffer that this frame's picture goes to.
    pub fn readback(&self) -> &wgpu::Buffer {
        &self.readback[(self.frame % IN_FLIGHT) as usize]
    }

    /// Submits a frame: its command buffers run in this order.
    pub fn submit(&mut self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>, keep: bool) {
        let index = self.queue.submit(commands);
        if keep {
            self.readback().slice(..).map_async(wgpu::MapMode::Read, |_| ());
        }
        self.submitted.push_back(Submitted { frame: self.frame, index, keep });
    }

    /// Waits for everything.
    pub fn wait(&mut self) -> Result<()> {
        while !self.submitted.is_empty() {
            self.collect()?;
        }
        Ok(())
    }

    /// Waits for the oldest frame, and takes its picture.
    fn collect(&mut self) -> Result<()> {
        let Some(Submitted { frame, index, keep }) = self.submitted.pop_front() else { return Ok(()) };
        self.device.poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: None })?;
        if keep {
            let buffer = &self.readback[(frame % IN_FLIGHT) as usize];
            self.pictures.push(bytemuck::pod_collect_to_vec(&buffer.slice(..).get_mapped_range()?));
            buffer.unmap();
        }
        Ok(())
    }
}

fn instance() -> wgpu::Instance {
    let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    desc.backends = wgpu::Backends::VULKAN;
    desc.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(desc)
}

/// An instance with the validation layer and its synchronisation validation, if the layer is installed.
///
/// `InstanceFlags::DEBUG` would bring the extension too through which the layer's messages reach wgpu, but it also
/// marks shaders as WGSL's, which layers of 2023 take for an error.
fn validated_instance() -> Result<wgpu::Instance> {
    let desc = wgpu::hal::InstanceDescriptor {
        name: "impasto_wgpu",
        flags: wgpu::InstanceFlags::VALIDATION,
        memory_budget_thresholds: Default::default(),
        backend_options: Default::default(),
        telemetry: None,
        display: None,
    };
    let messages: Box<vulkan::CreateInstanceCallback<'_>> =
        Box::new(|args| args.extensions.push(ash::ext::debug_utils::NAME));
    // SAFETY: nothing is taken from what wgpu asks for; every Vulkan loader offers the extension.
    let instance = unsafe { vulkan::Instance::init_with_callback(&desc, Some(messages)) }?;
    // SAFETY: wgpu alone owns the instance.
    Ok(unsafe { wgpu::Instance::from_hal::<wgpu::hal::api::Vulkan>(instance) })
}
