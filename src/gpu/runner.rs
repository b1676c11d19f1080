//! The headless host: records, submits, waits, reads back. Uses the library as any host would.

use super::context::{lock, Context};
use super::memory::{Buffer, BufferKind, Image};
use super::recorder::Recorder;
use super::timing::{PassTime, PassTimer};
use crate::{Error, Result};
use ash::vk;

/// How long a submission may run before a runner calls it stuck; far beyond any driver's own watchdog.
const TIMEOUT_NS: u64 = 120_000_000_000;
const TIMED_PASSES: u32 = 4096;

/// Runs recordings on a device of our own, one at a time.
pub struct Runner {
    context: Context,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    timer: PassTimer,
    times: Vec<PassTime>,
    /// A submission went wrong and may still be under way.
    broken: bool,
}

impl Runner {
    /// Makes a runner for a context that owns its device.
    ///
    /// # Errors
    /// [`Error::Device`] for a borrowed device, where only the host may submit; [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context) -> Result<Self> {
        if context.inner().queue == vk::Queue::null() {
            return Err(Error::Device("a borrowed device is submitted to by its host, not by a runner".to_owned()));
        }
        let device = context.usable()?;
        let timer = PassTimer::new(context, TIMED_PASSES)?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(context.inner().queue_family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: plain creations on a live device; `runner` frees what was made when a later call fails.
        unsafe {
            let pool = device.create_command_pool(&info, None).map_err(context.failed("vkCreateCommandPool"))?;
            let mut runner = Runner {
                context: context.clone(),
                pool,
                commands: vk::CommandBuffer::null(),
                fence: vk::Fence::null(),
                timer,
                times: Vec::new(),
                broken: false,
            };
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let buffers = device.allocate_command_buffers(&info).map_err(context.failed("vkAllocateCommandBuffers"))?;
            runner.commands = buffers.first().copied().unwrap_or_default();
            runner.fence =
                device.create_fence(&vk::FenceCreateInfo::default(), None).map_err(context.failed("vkCreateFence"))?;
            Ok(runner)
        }
    }

    /// Records with `record`, submits, and waits until the GPU is done.
    ///
    /// What was recorded before `record` failed is run all the same, since every resource remembers it.
    ///
    /// # Errors
    /// Those of `record`; [`Error::Vulkan`] when a call fails or the work is stuck, after which the runner is of no
    /// more use and answers [`Error::Device`]; [`Error::DeviceLost`].
    pub fn run<T>(&mut self, record: impl FnOnce(&mut Recorder<'_>) -> Result<T>) -> Result<T> {
        let context = self.context.clone();
        let device = context.usable()?;
        if self.broken {
            return Err(Error::Device("an earlier submission failed or did not end".to_owned()));
        }
        let _running = lock(&context.inner().running);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submission was waited for, so the command buffer is free; it is ours alone.
        let value = unsafe {
            device.begin_command_buffer(self.commands, &begin).map_err(context.failed("vkBeginCommandBuffer"))?;
            let mut recorder = Recorder::new(&self.context, self.commands, Some(&mut self.timer));
            let value = record(&mut recorder);
            // What was recorded may be destroyed already.
            context.usable()?;
            device.end_command_buffer(self.commands).map_err(context.failed("vkEndCommandBuffer"))?;
            value
        };
        let commands = [self.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
        // Until all has gone well command buffer and fence may be in use.
        self.broken = true;
        // SAFETY: queue, command buffer and fence are ours and idle; `running` keeps other threads off the queue.
        unsafe {
            device
                .queue_submit(self.context.inner().queue, &submit, self.fence)
                .map_err(context.failed("vkQueueSubmit"))?;
            device.wait_for_fences(&[self.fence], true, TIMEOUT_NS).map_err(context.failed("vkWaitForFences"))?;
            device.reset_fences(&[self.fence]).map_err(context.failed("vkResetFences"))?;
        }
        self.broken = false;
        for time in self.timer.read()? {
            match self.times.iter_mut().find(|t| t.name == time.name) {
                Some(sum) => {
                    sum.count += time.count;
                    sum.total_ns += time.total_ns;
                }
                None => self.times.push(time),
            }
        }
        let done = context.frame();
        context.advance(done + 1, done);
        value
    }

    /// The context that it runs on.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The GPU time of all passes run so far, by name; forgets them.
    pub fn take_times(&mut self) -> Vec<PassTime> {
        std::mem::take(&mut self.times)
    }

    /// Reads an image's texels, tightly packed.
    pub fn read_image(&mut self, image: &Image) -> Result<Vec<u8>> {
        let texel = image.texel_bytes();
        if texel == 0 {
            return Err(Error::Device(format!("images of format {:?} are not read back", image.format())));
        }
        let to = Buffer::new(&self.context, "readback", BufferKind::Readback, image.texels() * texel)?;
        self.run(|recorder| {
            recorder.download_image("readback", image, &to);
            Ok(())
        })?;
        Ok(to.mapped().to_vec())
    }

    /// Reads a buffer.
    pub fn read_buffer(&mut self, buffer: &Buffer) -> Result<Vec<u8>> {
        let to = Buffer::new(&self.context, "readback", BufferKind::Readback, buffer.bytes())?;
        self.run(|recorder| {
            recorder.download_buffer("readback", buffer, &to);
            Ok(())
        })?;
        Ok(to.mapped().to_vec())
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        let device = self.context.device();
        // SAFETY: after the wait nothing of ours is in flight; the handles are ours and freed once.
        unsafe {
            let _running = lock(&self.context.inner().running);
            self.context.wait_idle();
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}
