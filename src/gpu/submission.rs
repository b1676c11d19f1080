//! One command buffer with its fence: recorded, submitted, waited for. What the hosts of our own are made of.

use super::context::{lock, Context};
use super::recorder::Recorder;
use super::timing::{PassTime, PassTimer};
use crate::{Error, Result};
use ash::vk;

/// How long a submission may run before it counts as stuck; far beyond any driver's own watchdog.
const TIMEOUT_NS: u64 = 120_000_000_000;

/// A command buffer that is used again and again. Callers hold the context's `running` while they submit.
pub(super) struct Submission {
    context: Context,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    timer: PassTimer,
    /// The frame that was submitted and not waited for yet.
    under_way: Option<u64>,
    /// A submission went wrong and may still be under way.
    broken: bool,
}

impl Submission {
    /// Makes one that times so many passes.
    ///
    /// # Errors
    /// [`Error::Device`] for a borrowed device, where only the host may submit; [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, timed_passes: u32) -> Result<Self> {
        if context.inner().queue == vk::Queue::null() {
            return Err(Error::Device("a borrowed device is submitted to by its host, not by a runner".to_owned()));
        }
        let device = context.usable()?;
        let timer = PassTimer::new(context, timed_passes)?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(context.inner().queue_family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: plain creations on a live device; `made` frees what was made when a later call fails.
        unsafe {
            let pool = device.create_command_pool(&info, None).map_err(context.failed("vkCreateCommandPool"))?;
            let mut made = Submission {
                context: context.clone(),
                pool,
                commands: vk::CommandBuffer::null(),
                fence: vk::Fence::null(),
                timer,
                under_way: None,
                broken: false,
            };
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let buffers = device.allocate_command_buffers(&info).map_err(context.failed("vkAllocateCommandBuffers"))?;
            made.commands = buffers.first().copied().unwrap_or_default();
            made.fence =
                device.create_fence(&vk::FenceCreateInfo::default(), None).map_err(context.failed("vkCreateFence"))?;
            Ok(made)
        }
    }

    /// Records with `record` and submits; the last submission must have been waited for. What was recorded before
    /// `record` failed is run all the same, since every resource remembers it: its own result is the inner one.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when a call fails; after that [`Error::Device`], always. [`Error::DeviceLost`].
    pub fn submit<T>(&mut self, record: impl FnOnce(&mut Recorder<'_>) -> Result<T>) -> Result<Result<T>> {
        if self.broken || self.under_way.is_some() {
            return Err(Error::Device("an earlier submission failed or did not end".to_owned()));
        }
        let context = &self.context;
        let device = context.usable()?;
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
        self.broken = true;
        // SAFETY: queue, command buffer and fence are ours and idle; `running` keeps other threads off the queue.
        unsafe { device.queue_submit(context.inner().queue, &submit, self.fence) }
            .map_err(context.failed("vkQueueSubmit"))?;
        self.broken = false;
        self.under_way = Some(self.context.frame());
        Ok(value)
    }

    /// Waits until the GPU is done with what was submitted last. Its frame, and with it all frames before, has run
    /// then; none if there is nothing to wait for.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when a call fails or the work is stuck; after that [`Error::Device`], always.
    pub fn wait(&mut self) -> Result<Option<u64>> {
        if self.broken {
            return Err(Error::Device("an earlier submission failed or did not end".to_owned()));
        }
        let Some(frame) = self.under_way.take() else { return Ok(None) };
        // Until all has gone well command buffer and fence may be in use.
        self.broken = true;
        let context = &self.context;
        let device = context.usable()?;
        // SAFETY: the fence is ours and was submitted.
        unsafe {
            device.wait_for_fences(&[self.fence], true, TIMEOUT_NS).map_err(context.failed("vkWaitForFences"))?;
            device.reset_fences(&[self.fence]).map_err(context.failed("vkResetFences"))?;
        }
        self.broken = false;
        Ok(Some(frame))
    }

    /// The times of the passes that were waited for last.
    ///
    /// # Errors
    /// As [`PassTimer::read`].
    pub fn times(&self) -> Result<Vec<PassTime>> {
        self.timer.read()
    }
}

impl Drop for Submission {
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
