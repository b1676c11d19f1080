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
pub(super) const PICTURE: &[u8] = include_bytes!("../../glsl/spirv/technique/picture.vert.spv");

/// The pass, with the frame that it draws.
pub(super) struct PicturePass {
    pass: RenderPass,
    target: Framebuffer,
    pipeline: RasterPipeline,
    frame: Image,
}

impl PicturePass {
    /// Prepares to run a shader, whose vertex shader is [`PICTURE`], over the pixels that `depth` has something at.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] when the budget does not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, shader: RasterShader, depth: &Image) -> Result<Self> {
        let [width, height, _] = depth.size_px();
        let frame = Image::new(context, shader.name, &ImageDesc::frame(width, height))?;
        let attachments = [
            Attachment { format: frame.format(), role: Role::Color },
            Attachment { format: depth.format(), role: Role::DepthBefore },
        ];
        let pass = RenderPass::new(context, shader.name, &attachments)?;
        let target = Framebuffer::new(context, &pass, &[&frame, depth])?;
        let desc = RasterDesc { shader, vertex_bytes: 0, attributes: &[], cull_back: false, constants: &[] };
        let pipeline = RasterPipeline::new(context, &pass, &desc)?;
        Ok(PicturePass { pass, target, pipeline, frame })
    }

    /// What binding sets are made for.
    pub fn pipeline(&self) -> &RasterPipeline {
        &self.pipeline
    }

    /// The frame: R8G8B8A8_UNORM, straight alpha, background 0.
    pub fn frame(&self) -> &Image {
        &self.frame
    }

    /// Records the pass; what it reads must have been drawn before.
    pub fn record<P: bytemuck::NoUninit>(&self, recorder: &mut Recorder<'_>, set: &BindingSet, push: P) {
        let draw = Draw { set: Some(set), push, range: 0..3 };
        recorder.draw(&self.pass, &self.target, &self.pipeline, None, &[draw]);
    }
}
