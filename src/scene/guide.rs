//! The guide pass: one explicit render pass that draws the scene's shade, object IDs and depth (thesis 3.1.2, 3.1.3).
//!
//! Techniques read its images: shade decides which paint goes where, the ID which pixels are painted at all and with
//! which strip. The oracle is [`super::GuideOracle`].

use super::{Camera, Lights, Mesh, Solid};
use crate::gpu::{
    Attachment, Buffer, BufferKind, Context, Draw, Framebuffer, Geometry, Image, ImageDesc, RasterDesc, RasterPipeline,
    RasterShader, Recorder, RenderPass, Role, Uploads, VertexAttribute,
};
use crate::Result;
use ash::vk;

pub(crate) const GUIDE: RasterShader = RasterShader {
    name: "guide",
    vertex_spirv: include_bytes!("../../glsl/spirv/scene/guide.vert.spv"),
    fragment_spirv: include_bytes!("../../glsl/spirv/scene/guide.frag.spv"),
    bindings: &[],
    push_bytes: size_of::<Push>() as u32,
};

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
    /// Draws all faces, and only those that show their front.
    pipelines: [RasterPipeline; 2],
    solid: Solid,
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
            Attachment { format: shade.format(), role: Role::Color },
            Attachment { format: id.format(), role: Role::Color },
            Attachment { format: depth.format(), role: Role::Depth },
        ];
        let pass = RenderPass::new(context, "guide", &attachments)?;
        let target = Framebuffer::new(context, &pass, &[&shade, &id, &depth])?;
        let attribute = |format, offset| VertexAttribute { format, offset_bytes: offset as u32 };
        let pipeline = |cull_back| {
            let desc = RasterDesc {
                shader: GUIDE,
                vertex_bytes: size_of::<Vertex>() as u32,
                attributes: &[
                    attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position)),
                    attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal)),
                    attribute(vk::Format::R32_UINT, std::mem::offset_of!(Vertex, id)),
                ],
                cull_back,
                constants: &[],
            };
            RasterPipeline::new(context, &pass, &desc)
        };
        let pipelines = [pipeline(false)?, pipeline(true)?];
        let data: Vec<Vertex> = mesh
            .positions()
            .iter()
            .zip(mesh.normals())
            .zip(mesh.object_of_vertex())
            .map(|((&position, &normal), object)| Vertex { position, normal, id: object + 1 })
            .collect();
        let (vertices, indices) = upload_geometry(context, uploads, &data, mesh.indices())?;
        let index_count = mesh.indices().len() as u32;
        let object_count = mesh.objects().len();
        let solid = Solid::new(mesh);
        Ok(GuidePass { pass, target, pipelines, solid, vertices, indices, index_count, object_count, shade, id, depth })
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
        let geometry = Geometry { vertices: &self.vertices, indices: &self.indices };
        let draw = Draw { set: None, push, range: 0..self.index_count };
        let pipeline = &self.pipelines[usize::from(self.solid.hides_back_faces(camera))];
        recorder.draw(&self.pass, &self.target, pipeline, Some(&geometry), &[draw]);
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

/// Vertices and indices on their way to the device.
pub(crate) fn upload_geometry<V: bytemuck::NoUninit>(
    context: &Context,
    uploads: &mut Uploads,
    vertices: &[V],
    indices: &[u32],
) -> Result<(Buffer, Buffer)> {
    let mut buffer = |name, data: &[u8]| {
        let buffer = Buffer::new(context, name, BufferKind::Geometry, data.len() as u64)?;
        uploads.buffer(context, &buffer, data)?;
        Ok::<_, crate::Error>(buffer)
    };
    Ok((
        buffer("mesh vertices", bytemuck::cast_slice(vertices))?,
        buffer("mesh indices", bytemuck::cast_slice(indices))?,
    ))
}
