//! Data on its way to the device: staged at once, copied by a recorded pass.

use super::context::Context;
use super::memory::{Buffer, Image};
use super::pipeline::Bound;
use super::recorder::Recorder;
use crate::{Error, Result};

/// Copies that wait to be recorded.
#[derive(Default)]
pub struct Uploads {
    pending: Vec<(Buffer, Bound)>,
}

impl Uploads {
    /// Stages `data` for the start of `to`.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is more of it than the buffer holds, and those of [`Buffer::upload`].
    pub fn buffer(&mut self, context: &Context, to: &Buffer, data: &[u8]) -> Result<()> {
        if data.len() as u64 > to.bytes() {
            return Err(Error::parameter("uploaded bytes", data.len(), format!("at most {}", to.bytes())));
        }
        self.pending.push((Buffer::upload(context, "staging", data)?, Bound::from(to)));
        Ok(())
    }

    /// Stages the tightly packed texels of the whole of `to`.
    ///
    /// # Errors
    /// [`Error::Parameter`] when that is not what the data is, and those of [`Buffer::upload`].
    pub fn image(&mut self, context: &Context, to: &Image, data: &[u8]) -> Result<()> {
        let bytes = to.texels() * to.texel_bytes();
        if data.len() as u64 != bytes {
            return Err(Error::parameter("uploaded bytes", data.len(), format!("{bytes}, the image's texels")));
        }
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
