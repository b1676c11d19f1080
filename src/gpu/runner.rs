//! The headless host: records, submits, waits, reads back. Uses the library as any host would.

use super::context::{lock, Context};
use super::memory::{Buffer, BufferKind, Image};
use super::recorder::Recorder;
use super::submission::Submission;
use super::timing::PassTime;
use crate::{Error, Result};

const TIMED_PASSES: u32 = 4096;

/// Runs recordings on a device of our own, one at a time. A [`super::FrameLoop`] keeps several in flight.
pub struct Runner {
    context: Context,
    submission: Submission,
    times: Vec<PassTime>,
}

impl Runner {
    /// Makes a runner for a context that owns its device.
    ///
    /// # Errors
    /// [`Error::Device`] for a borrowed device, where only the host may submit; [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context) -> Result<Self> {
        let submission = Submission::new(context, TIMED_PASSES)?;
        Ok(Runner { context: context.clone(), submission, times: Vec::new() })
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
        let _running = lock(&context.inner().running);
        let value = self.submission.submit(record)?;
        let done = self.submission.wait()?.unwrap_or_default();
        for time in self.submission.times()? {
            match self.times.iter_mut().find(|t| t.name == time.name) {
                Some(sum) => {
                    sum.count += time.count;
                    sum.total_ns += time.total_ns;
                }
                None => self.times.push(time),
            }
        }
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
