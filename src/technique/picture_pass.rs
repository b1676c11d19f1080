//! A render pass over the pixels of a picture in which something was drawn before.
//!
//! Its triangle lies at the far end: the test against the depth of what was drawn leaves out the background, which on
//! some devices spares all of its work.

use crate::gpu::{
    Attachment, BindingSet, Context, Draw, Framebuffer, Image, ImageDesc, RasterDesc, RasterPipeline, RasterShader,
    Recorder, RenderPass, Role,
};
use crate::Result;

/// The vertex shader of all of them: picture.vert.
pub(crate) const PICTURE: &[u8] = include_bytes!("../../glsl/spirv/technique/picture.vert.spv");

/// The pass.
pub(super) struct PicturePass {
    pass: RenderPass,
    target: Framebuffer,
    pipeline: RasterPipeline,
}

impl PicturePass {
    /// Prepares to run a shader, whose vertex shader is [`PICTURE`] and which writes `images`, of one size, over the
    /// pixels that `depth` has something at. Elsewhere they become 0. `constants` are its specialisation constants 0,
    /// 1, ...
    ///
    /// # Errors
    /// [`crate::Error::Memory`] when the budget does not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(
        context: &Context,
        shader: RasterShader,
        constants: &[u32],
        images: &[&Image],
        depth: &Image,
    ) -> Result<Self> {
        let color = |image: &&Image| Attachment { format: image.format(), role: Role::Color };
        let mut attachments: Vec<Attachment> = images.iter().map(color).collect();
        attachments.push(Attachment { format: depth.format(), role: Role::DepthBefore });
        let pass = RenderPass::new(context, shader.name, &attachments)?;
        let images: Vec<&Image> = images.iter().copied().chain([depth]).collect();
        let target = Framebuffer::new(context, &pass, &images)?;
        let desc = RasterDesc { shader, vertex_bytes: 0, attributes: &[], cull_back: false, constants };
        let pipeline = RasterPipeline::new(context, &pass, &desc)?;
        Ok(PicturePass { pass, target, pipeline })
    }

    /// What binding sets are made for.
    pub fn pipeline(&self) -> &RasterPipeline {
        &self.pipeline
    }

    /// Records the pass, a draw after the other; what they read must have been drawn before.
    pub fn record<P: bytemuck::NoUninit>(&self, recorder: &mut Recorder<'_>, draws: &[(&BindingSet, P)]) {
        let draws = draws.iter().map(|&(set, push)| Draw { set: Some(set), push, range: 0..3 });
        let draws: Vec<_> = draws.collect();
        recorder.draw(&self.pass, &self.target, &self.pipeline, None, &draws);
    }
}

/// What a technique's picture pass draws to.
pub(super) fn frame_for(context: &Context, name: &'static str, depth: &Image) -> Result<Image> {
    let [width, height, _] = depth.size_px();
    Image::new(context, name, &ImageDesc::frame(width, height))
}
