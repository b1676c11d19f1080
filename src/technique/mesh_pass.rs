//! A render pass over a mesh into a frame: what the techniques that draw the mesh themselves share.

use crate::gpu::{
    Attachment, Buffer, Context, Draw, Framebuffer, Geometry, Image, ImageDesc, RasterDesc, RasterPipeline,
    RasterShader, Recorder, RenderPass, Role, Uploads, VertexAttribute,
};
use crate::scene::{upload_geometry, Camera, Mesh, Solid};
use crate::Result;
use ash::vk;

/// The pass, with the mesh on the device and the frame that it draws.
pub(super) struct MeshPass {
    pass: RenderPass,
    target: Framebuffer,
    /// Draw all faces, and only those that show their front.
    pipelines: [RasterPipeline; 2],
    solid: Solid,
    vertices: Buffer,
    indices: Buffer,
    frame: Image,
}

impl MeshPass {
    /// Prepares to draw `indices` of `vertices`, which are those of `mesh` with what the technique adds, at `size` =
    /// (width, height) pixels. `constants` are the fragment shader's specialisation constants.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a size that the device cannot do, [`crate::Error::Memory`] when the budget does
    /// not allow it, [`crate::Error::Vulkan`] when a call fails.
    #[allow(clippy::too_many_arguments)] // the device, the mesh, the shader with its input
    pub fn new<V: bytemuck::NoUninit>(
        context: &Context,
        uploads: &mut Uploads,
        mesh: &Mesh,
        size: (u32, u32),
        shader: RasterShader,
        attributes: &[VertexAttribute],
        constants: &[u32],
        (vertices, indices): (&[V], &[u32]),
    ) -> Result<Self> {
        let frame = Image::new(context, shader.name, &ImageDesc::frame(size.0, size.1))?;
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let desc = ImageDesc { size_px: [size.0, size.1, 1], format: context.caps().depth_format, usage };
        let depth = Image::new(context, shader.name, &desc)?;
        let attachments = [
            Attachment { format: frame.format(), role: Role::Color },
            Attachment { format: depth.format(), role: Role::Depth },
        ];
        let pass = RenderPass::new(context, shader.name, &attachments)?;
        let target = Framebuffer::new(context, &pass, &[&frame, &depth])?;
        let pipeline = |cull_back| {
            let vertex_bytes = size_of::<V>() as u32;
            let desc = RasterDesc { shader, vertex_bytes, attributes, cull_back, constants };
            RasterPipeline::new(context, &pass, &desc)
        };
        let pipelines = [pipeline(false)?, pipeline(true)?];
        let (vertices, indices) = upload_geometry(context, uploads, vertices, indices)?;
        Ok(MeshPass { pass, target, pipelines, solid: Solid::new(mesh), vertices, indices, frame })
    }

    /// What binding sets are made for.
    pub fn pipeline(&self) -> &RasterPipeline {
        &self.pipelines[0]
    }

    /// The frame: R8G8B8A8_UNORM, straight alpha, background 0.
    pub fn frame(&self) -> &Image {
        &self.frame
    }

    /// The camera's projection for the frame's shape.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when the camera has none.
    pub fn view_projection(&self, camera: &Camera) -> Result<[f32; 16]> {
        let [width, height, _] = self.frame.size_px();
        Ok(camera.view_projection(width as f32 / height as f32)?.to_cols_array())
    }

    /// Records the pass.
    pub fn record<P: bytemuck::NoUninit>(&self, recorder: &mut Recorder<'_>, camera: &Camera, draws: &[Draw<'_, P>]) {
        let geometry = Geometry { vertices: &self.vertices, indices: &self.indices };
        let pipeline = &self.pipelines[usize::from(self.solid.hides_back_faces(camera))];
        recorder.draw(&self.pass, &self.target, pipeline, Some(&geometry), draws);
    }
}
