//! Timestamps around passes.

use super::context::Context;
use super::memory::Garbage;
use crate::Result;
use ash::vk;

/// So many passes' queries are reset at a time: most command buffers have few of those that there is room for.
const RESET_PASSES: u32 = 32;

/// How long passes of one name took on the GPU, added up.
#[derive(Debug, Clone, PartialEq)]
pub struct PassTime {
    /// The pass's name.
    pub name: &'static str,
    /// How many passes of that name were timed.
    pub count: u32,
    /// Their time together, nanoseconds.
    pub total_ns: u64,
}

/// Times the passes of one command buffer. Where the queue has no timestamps, it times nothing and says nothing.
pub struct PassTimer {
    context: Context,
    pool: vk::QueryPool,
    capacity: u32,
    names: Vec<&'static str>,
}

impl PassTimer {
    /// Makes room for `passes` passes in a command buffer; further ones go untimed.
    pub fn new(context: &Context, passes: u32) -> Result<Self> {
        let capacity = if context.caps().timestamp_bits == 0 { 0 } else { passes };
        let mut pool = vk::QueryPool::null();
        if capacity > 0 {
            let info =
                vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(capacity * 2);
            // SAFETY: a plain creation on a live device.
            pool = unsafe { context.usable()?.create_query_pool(&info, None) }
                .map_err(context.failed("vkCreateQueryPool"))?;
        }
        Ok(PassTimer { context: context.clone(), pool, capacity, names: Vec::with_capacity(capacity as usize) })
    }

    /// Begins a command buffer.
    pub(crate) fn reset(&mut self) {
        self.names.clear();
    }

    pub(crate) fn begin(&mut self, context: &Context, commands: vk::CommandBuffer, name: &'static str) -> Option<u32> {
        let slot = self.names.len() as u32;
        if slot >= self.capacity {
            return None;
        }
        if slot.is_multiple_of(RESET_PASSES) {
            let passes = RESET_PASSES.min(self.capacity - slot);
            // SAFETY: the pool is live and has these queries; the command buffer is recording outside of a render pass.
            unsafe { context.device().cmd_reset_query_pool(commands, self.pool, slot * 2, passes * 2) };
        }
        self.names.push(name);
        // When all earlier work has run, so that the times of passes do not overlap.
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the query was reset earlier in this command buffer and is written once.
        unsafe { context.device().cmd_write_timestamp(commands, stage, self.pool, slot * 2) };
        Some(slot)
    }

    pub(crate) fn end(&self, context: &Context, commands: vk::CommandBuffer, slot: u32) {
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: as in `begin`.
        unsafe { context.device().cmd_write_timestamp(commands, stage, self.pool, slot * 2 + 1) };
    }

    /// The times of the passes that were recorded last, in the order in which their names first appear.
    /// To be called when the command buffer is known to have run.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] when the results cannot be had, as before the command buffer has run.
    pub fn read(&self) -> Result<Vec<PassTime>> {
        let mut times: Vec<PassTime> = Vec::new();
        if self.names.is_empty() {
            return Ok(times);
        }
        let mut ticks = vec![0u64; self.names.len() * 2];
        // SAFETY: the pool is live and holds at least this many queries.
        unsafe {
            self.context.usable()?.get_query_pool_results(self.pool, 0, &mut ticks, vk::QueryResultFlags::TYPE_64)
        }
        .map_err(self.context.failed("vkGetQueryPoolResults"))?;
        let caps = self.context.caps();
        let mask = if caps.timestamp_bits >= 64 { u64::MAX } else { (1 << caps.timestamp_bits) - 1 };
        for (name, pair) in self.names.iter().zip(ticks.chunks_exact(2)) {
            let elapsed = pair[1].wrapping_sub(pair[0]) & mask;
            let ns = (elapsed as f64 * f64::from(caps.timestamp_period_ns)) as u64;
            match times.iter_mut().find(|time| time.name == *name) {
                Some(time) => {
                    time.count += 1;
                    time.total_ns += ns;
                }
                None => times.push(PassTime { name, count: 1, total_ns: ns }),
            }
        }
        Ok(times)
    }
}

impl Drop for PassTimer {
    fn drop(&mut self) {
        self.context.bury(Garbage::QueryPool(self.pool));
    }
}
