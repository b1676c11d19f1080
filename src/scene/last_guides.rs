//! ID and depth of the frame before, for passes that look for what it showed.

use super::GuideImages;
use crate::gpu::{Context, Image, ImageDesc, Recorder};
use crate::Result;
use ash::vk;

/// The images now, and copies of what they were.
pub(super) struct LastGuides {
    now: [Image; 2],
    then: [Image; 2],
}

impl LastGuides {
    /// Makes room for a frame of `guides`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for images that cannot be sampled or copied from, [`crate::Error::Memory`] when the
    /// budget does not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, guides: &GuideImages) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let (id, depth) = (guides.id(), guides.depth());
        id.check_usage("guide id", U::TRANSFER_SRC)?;
        depth.check_usage("guide depth", U::SAMPLED | U::TRANSFER_SRC)?;
        let [width, height, _] = id.size_px();
        let id_then = Image::new(context, "previous id", &ImageDesc::storage_2d(width, height, id.format()))?;
        let depth_then = Image::new(context, "previous depth", &ImageDesc::sampled(depth.size_px(), depth.format()))?;
        Ok(LastGuides { now: [id.clone(), depth.clone()], then: [id_then, depth_then] })
    }

    /// ID and depth now.
    pub fn now(&self) -> [&Image; 2] {
        self.now.each_ref()
    }

    /// ID and depth of the frame that was kept last.
    pub fn then(&self) -> [&Image; 2] {
        self.then.each_ref()
    }

    /// Records that the frame is kept for the next.
    pub fn record(&self, recorder: &mut Recorder<'_>, name: &'static str) {
        let pair = |i: usize| (&self.now[i], &self.then[i]);
        recorder.copy_images(name, &[pair(0), pair(1)]);
    }
}
