//! What an important view sees of some faces: face ID for the coverage, shade and object ID for the synthesis.

use crate::gpu::{
    Attachment, Buffer, Context, Draw, Framebuffer, Geometry, Image, ImageDesc, RasterDesc, RasterPipeline,
    RasterShader, Recorder, RenderPass, Role, Uploads, VertexAttribute,
};
use crate::scene::{upload_geometry, Camera, Lights, Mesh};
use crate::Result;
use ash::vk;
use std::ops::Range;

pub(crate) const FACES: RasterShader = RasterShader {
    name: "faces",
    vertex_spirv: include_bytes!("../../../glsl/spirv/technique/faces.vert.spv"),
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/faces.frag.spv"),
    bindings: &[],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    view_projection: [f32; 16],
    light: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    id: u32,
}

/// Draws lists of faces, back faces left out.
pub(super) struct FacePass {
    pass: RenderPass,
    target: Framebuffer,
    pipeline: RasterPipeline,
    vertices: Buffer,
    indices: Buffer,
    pub shade: Image,
    pub id: Image,
    pub face: Image,
}

impl FacePass {
    /// Prepares to draw the faces of `lists`, one list after the other, into square pictures.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        mesh: &Mesh,
        size_px: u32,
        lists: impl Iterator<Item = u32>,
    ) -> Result<Self> {
        let image = |name, format| Image::new(context, name, &ImageDesc::drawn(size_px, size_px, format));
        let shade = image("view shade", vk::Format::R32_SFLOAT)?;
        let id = image("view id", vk::Format::R32_UINT)?;
        let face = image("view faces", vk::Format::R32_UINT)?;
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let desc = ImageDesc { size_px: [size_px, size_px, 1], format: context.caps().depth_format, usage };
        let depth = Image::new(context, "view depth", &desc)?;
        let images = [&shade, &id, &face, &depth];
        let attachments = [0, 1, 2, 3]
            .map(|i| Attachment { format: images[i].format(), role: if i == 3 { Role::Depth } else { Role::Color } });
        let pass = RenderPass::new(context, "faces", &attachments)?;
        let target = Framebuffer::new(context, &pass, &images)?;
        let attribute = |format, offset| VertexAttribute { format, offset_bytes: offset as u32 };
        let desc = RasterDesc {
            shader: FACES,
            vertex_bytes: size_of::<Vertex>() as u32,
            attributes: &[
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position)),
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal)),
                attribute(vk::Format::R32_UINT, std::mem::offset_of!(Vertex, id)),
            ],
            cull_back: true,
            constants: &[],
        };
        let pipeline = RasterPipeline::new(context, &pass, &desc)?;
        let objects = mesh.object_of_vertex();
        let corner = |&vertex: &u32| {
            let vertex = vertex as usize;
            Vertex { position: mesh.positions()[vertex], normal: mesh.normals()[vertex], id: objects[vertex] + 1 }
        };
        let corners: Vec<Vertex> = mesh.indices().iter().map(corner).collect();
        let indices: Vec<u32> = lists.flat_map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        let (vertices, indices) = upload_geometry(context, uploads, &corners, &indices)?;
        Ok(FacePass { pass, target, pipeline, vertices, indices, shade, id, face })
    }

    /// Records the faces at `range` of the lists, seen through `camera`.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        camera: &Camera,
        lights: &Lights,
        range: Range<u32>,
    ) -> Result<()> {
        let push = Push {
            view_projection: camera.view_projection(1.0)?.to_cols_array(),
            light: lights.mean_direction().extend(0.0).to_array(),
        };
        let geometry = Geometry { vertices: &self.vertices, indices: &self.indices };
        let draw = Draw { set: None, push, range: 3 * range.start..3 * range.end };
        recorder.draw(&self.pass, &self.target, &self.pipeline, Some(&geometry), &[draw]);
        Ok(())
    }
}
