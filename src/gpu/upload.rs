//! Data on its way to the device: staged at once, copied by a recorded pass.

use super::context::Context;
use super::memory::{Buffer, Image};
use super::recorder::Recorder;
use crate::{Error, Result};
use std::ops::Range;

/// Copies that wait to be recorded.
#[derive(Default)]
pub struct Uploads {
    pending: Vec<(Buffer, Target)>,
}

enum Target {
    Buffer(Buffer),
    Image(Image),
    Slices(Image, Range<u32>),
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
        self.pending.push((Buffer::upload(context, "staging", data)?, Target::Buffer(to.clone())));
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
        self.pending.push((Buffer::upload(context, "staging", data)?, Target::Image(to.clone())));
        Ok(())
    }

    /// Stages the tightly packed texels of some slices of a 3D image.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the image has no such slices or the data is not theirs, and those of
    /// [`Buffer::upload`].
    pub fn slices(&mut self, context: &Context, to: &Image, slices: Range<u32>, data: &[u8]) -> Result<()> {
        let [width, height, depth] = to.size_px();
        if slices.is_empty() || slices.end > depth {
            let allowed = format!("some of the image's {depth} slices");
            return Err(Error::parameter("uploaded slices", format!("{slices:?}"), allowed));
        }
        let bytes = u64::from(width) * u64::from(height) * slices.len() as u64 * to.texel_bytes();
        if data.len() as u64 != bytes {
            return Err(Error::parameter("uploaded bytes", data.len(), format!("{bytes}, the slices' texels")));
        }
        self.pending.push((Buffer::upload(context, "staging", data)?, Target::Slices(to.clone(), slices)));
        Ok(())
    }

    /// Records all copies. The staging memory goes when the frame is safe.
    pub fn record(&mut self, recorder: &mut Recorder<'_>) {
        for (from, to) in self.pending.drain(..) {
            match &to {
                Target::Buffer(to) => recorder.copy_buffer("upload", &from, to),
                Target::Image(to) => recorder.upload_image("upload", &from, to),
                Target::Slices(to, slices) => recorder.upload_slices("upload", &from, to, slices.clone()),
            }
        }
    }
}
