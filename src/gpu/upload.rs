//! Data on its way to the device: staged at once, copied by a recorded pass.

use super::context::Context;
use super::memory::{Buffer, Image};
use super::pipeline::Bound;
use super::recorder::Recorder;
use crate::Result;

/// Copies that wait to be recorded.
#[derive(Default)]
pub struct Uploads {
    pending: Vec<(Buffer, Bound)>,
}

impl Uploads {
    /// Stages `data` for the start of `to`.
    ///
    /// # Errors
    /// Those of [`Buffer::upload`].
    pub fn buffer(&mut self, context: &Context, to: &Buffer, data: &[u8]) -> Result<()> {
        self.pending.push((Buffer::upload(context, "staging", data)?, Bound::from(to)));
        Ok(())
    }

    /// Stages the tightly packed texels of the whole of `to`.
    ///
    /// # Errors
    /// Those of [`Buffer::upload`].
    pub fn image(&mut self, context: &Context, to: &Image, data: &[u8]) -> Result<()> {
        self.pending.push((Buffer::upload(context, "staging", data)?, Bound::from(to)));
        Ok(())
    }

    /// Records all copies. The staging memory goes when the frame is safe.
    pub fn record(&mut self, recorder: &mut Recorder<'_>) {
        for (from, to) in self.pending.drain(..) {
            match &to {
                Bound::Buffer(to) => recorder.copy_buffer("upload", &from, to),
                Bound::Image(to) => recorder.upload_image("upload", &from, to),
            }
        }
    }
}
