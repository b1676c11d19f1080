//! The guide pass: one explicit render pass that draws the scene's shade, object IDs and depth (thesis 3.1.2, 3.1.3).
//!
//! Techniques read its images: shade decides which paint goes where, the ID which pixels are painted at all and with
//! which strip. The oracle is [`super::GuideOracle`].

use super::{Camera, Lights, Mesh};
use crate::gpu::{
    Attachment, Buffer, BufferKind, Context, Framebuffer, Geometry, Image, ImageDesc, RasterDesc, RasterPipeline,
    Recorder, RenderPass, Uploads, VertexAttribute,
};
use crate::Result;
use ash::vk;

pub(crate) const GUIDE_VERTEX: &[u8] = include_bytes!("../../glsl/spirv/scene/guide.vert.spv");
pub(crate) const GUIDE_FRAGMENT: &[u8] = include_bytes!("../../glsl/spirv/scene/guide.frag.spv");

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    /// Object index + 1.
    id: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    view_projection: [f32; 16],
    light: [f32; 4],
}

/// A mesh on the device and the images that its guides are drawn to.
pub struct GuidePass {
    pass: RenderPass,
    target: Framebuffer,
    pipeline: RasterPipeline,
    vertices: Buffer,
    indices: Buffer,
    index_count: u32,
    object_count: usize,
    shade: Image,
    id: Image,
    depth: Image,
}

impl GuidePass {
    /// Prepares to draw `mesh` at `size` = (width, height) pixels.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a size that the device cannot do, [`crate::Error::Memory`] when the budget does
    /// not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, uploads: &mut Uploads, mesh: &Mesh, size: (u32, u32)) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image =
            |name, format, usage| Image::new(context, name, &ImageDesc { size_px: [size.0, size.1, 1], format, usage });
        let color = U::COLOR_ATTACHMENT | U::STORAGE | U::TRANSFER_SRC;
        let shade = image("guide shade", vk::Format::R32_SFLOAT, color)?;
        let id = image("guide id", vk::Format::R32_UINT, color)?;
        let depth = image("guide depth", context.caps().depth_format, U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC)?;
        let attachments = [
            Attachment { format: shade.format(), depth: false },
            Attachment { format: id.format(), depth: false },
            Attachment { format: depth.format(), depth: true },
        ];
        let pass = RenderPass::new(context, "guide", &attachments)?;
        let target = Framebuffer::new(context, &pass, &[&shade, &id, &depth])?;
        let attribute = |format, offset| VertexAttribute { format, offset_bytes: offset as u32 };
        let desc = RasterDesc {
            name: "guide",
            vertex_spirv: GUIDE_VERTEX,
            fragment_spirv: GUIDE_FRAGMENT,
            vertex_bytes: size_of::<Vertex>() as u32,
            attributes: &[
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position)),
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal)),
                attribute(vk::Format::R32_UINT, std::mem::offset_of!(Vertex, id)),
            ],
            push_bytes: size_of::<Push>() as u32,
        };
        let pipeline = RasterPipeline::new(context, &pass, &desc)?;
        let data: Vec<Vertex> = mesh
            .positions()
            .iter()
            .zip(mesh.normals())
            .zip(mesh.object_of_vertex())
            .map(|((&position, &normal), object)| Vertex { position, normal, id: object + 1 })
            .collect();
        let geometry = |name, data: &[u8], uploads: &mut Uploads| {
            let buffer = Buffer::new(context, name, BufferKind::Geometry, data.len() as u64)?;
            uploads.buffer(context, &buffer, data)?;
            Ok::<_, crate::Error>(buffer)
        };
        let vertices = geometry("mesh vertices", bytemuck::cast_slice(&data), uploads)?;
        let indices = geometry("mesh indices", bytemuck::cast_slice(mesh.indices()), uploads)?;
        let index_count = mesh.indices().len() as u32;
        let object_count = mesh.objects().len();
        Ok(GuidePass { pass, target, pipeline, vertices, indices, index_count, object_count, shade, id, depth })
    }

    /// Records the pass.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when the camera has no projection for this picture's shape; nothing is recorded then.
    pub fn record(&self, recorder: &mut Recorder<'_>, camera: &Camera, lights: &Lights) -> Result<()> {
        let [width, height, _] = self.shade.size_px();
        let view_projection = camera.view_projection(width as f32 / height as f32)?;
        let push = Push {
            view_projection: view_projection.to_cols_array(),
            light: lights.mean_direction().extend(0.0).to_array(),
        };
        let geometry = Geometry { vertices: &self.vertices, indices: &self.indices, index_count: self.index_count };
        recorder.draw(&self.pass, &self.target, &self.pipeline, &geometry, &push);
        Ok(())
    }

    /// Objects of the mesh; IDs go from 1 to this.
    pub fn object_count(&self) -> usize {
        self.object_count
    }

    /// Shade, R32_SFLOAT in [0, 1]; 0 where nothing is.
    pub fn shade(&self) -> &Image {
        &self.shade
    }

    /// Object index + 1, R32_UINT; 0 where nothing is.
    pub fn id(&self) -> &Image {
        &self.id
    }

    /// Depth, 0 near to 1 far; 1 where nothing is.
    pub fn depth(&self) -> &Image {
        &self.depth
    }
}
