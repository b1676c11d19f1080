//! The headless host of a stream of frames: records one while the GPU is still at those before it.

use super::context::{lock, Context};
use super::recorder::Recorder;
use super::submission::Submission;
use crate::{Error, Result};

/// The most submissions in flight: more only add delay.
const MOST: usize = 256;

/// Submits on a device of our own, several submissions in flight, as a game does it. A [`super::Runner`] waits for each
/// instead, times it, and reads back; both may be used with one context in turn.
///
/// What is recorded for frame n must not touch from the host what frames in flight use: nothing that the crate's
/// `record` functions do.
pub struct FrameLoop {
    context: Context,
    slots: Vec<Submission>,
    /// The slot whose submission is the oldest.
    next: usize,
    /// All frames up to this one have run.
    safe: u64,
}

impl FrameLoop {
    /// Makes a loop with room for `in_flight` submissions: 1 to 256.
    ///
    /// # Errors
    /// [`Error::Parameter`] for another number; [`Error::Device`] for a borrowed device, where only the host may
    /// submit; [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, in_flight: usize) -> Result<Self> {
        if !(1..=MOST).contains(&in_flight) {
            return Err(Error::parameter("submissions in flight", in_flight, format!("1 to {MOST}")));
        }
        let slots = (0..in_flight).map(|_| Submission::new(context, 0)).collect::<Result<_>>()?;
        Ok(FrameLoop { context: context.clone(), slots, next: 0, safe: 0 })
    }

    /// Waits until there is room, records with `record`, and submits without waiting.
    ///
    /// What was recorded before `record` failed is run all the same, since every resource remembers it.
    ///
    /// # Errors
    /// Those of `record`; [`Error::Vulkan`] when a call fails or the work is stuck, after which the loop is of no more
    /// use and answers [`Error::Device`].
    pub fn run<T>(&mut self, record: impl FnOnce(&mut Recorder<'_>) -> Result<T>) -> Result<T> {
        let context = self.context.clone();
        let _running = lock(&context.inner().running);
        let slot = &mut self.slots[self.next];
        self.safe = slot.wait()?.unwrap_or(self.safe);
        let value = slot.submit(record)?;
        self.next = (self.next + 1) % self.slots.len();
        context.advance(context.frame() + 1, self.safe);
        value
    }

    /// Waits until the GPU is done with everything.
    ///
    /// # Errors
    /// As [`FrameLoop::run`].
    pub fn finish(&mut self) -> Result<()> {
        for age in 0..self.slots.len() {
            let slot = (self.next + age) % self.slots.len();
            self.safe = self.slots[slot].wait()?.unwrap_or(self.safe);
        }
        let _running = lock(&self.context.inner().running);
        self.context.advance(self.context.frame(), self.safe);
        Ok(())
    }
}
