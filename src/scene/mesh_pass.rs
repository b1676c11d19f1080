//! A render pass that draws a mesh to images of the caller's choice: the guide pass, and what techniques draw
//! themselves.

use super::{upload_ordered, Mesh, Moment, Object, Solid};
use crate::gpu::{
    Attachment, Buffer, Context, Draw, Framebuffer, Geometry, Image, ImageDesc, RasterDesc, RasterPipeline,
    RasterShader, Recorder, RenderPass, Role, Uploads, VertexAttribute,
};
use crate::Result;
use ash::vk;
use std::ops::Range;

/// What a [`MeshPass`] draws, and how.
pub(crate) struct MeshDesc<'a, V> {
    /// Its shaders.
    pub shader: RasterShader,
    /// The fragment shader's specialisation constants 0, 1, ...
    pub constants: &'a [u32],
    /// The images that the fragment shader writes, in order; cleared to 0 where nothing is drawn.
    pub images: &'a [&'a Image],
    /// What a vertex holds.
    pub attributes: &'a [VertexAttribute],
    /// Those of the mesh with what the technique adds, or more of them.
    pub vertices: &'a [V],
    /// Indices into `vertices`, as many as the mesh has, object by object.
    pub indices: &'a [u32],
}

/// Objects side by side that are drawn at once.
pub(crate) struct Run<K> {
    /// Their indices.
    pub range: Range<u32>,
    /// What they share besides their pose.
    pub kind: K,
    /// From the mesh to clip space.
    pub to_clip: [f32; 16],
    /// The lights' mean direction, as the objects have it.
    pub light: [f32; 4],
}

/// The pass, with the mesh on the device.
pub(crate) struct MeshPass {
    pass: RenderPass,
    target: Framebuffer,
    /// Draw all faces, and only those that show their front.
    pipelines: [RasterPipeline; 2],
    solid: Solid,
    objects: Vec<Object>,
    vertices: Buffer,
    indices: Buffer,
    depth: Image,
}

impl MeshPass {
    /// Prepares to draw `mesh` to `desc.images`, which have one size.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a size that the device cannot do, [`crate::Error::Memory`] when the budget does
    /// not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new<V: bytemuck::NoUninit>(
        context: &Context,
        uploads: &mut Uploads,
        mesh: &Mesh,
        desc: &MeshDesc<'_, V>,
    ) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let shader = desc.shader;
        let size_px = desc.images.first().map_or([1; 3], |image| image.size_px());
        let usage = U::DEPTH_STENCIL_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC;
        let depth_desc = ImageDesc { size_px, format: context.caps().depth_format, usage };
        let depth = Image::new(context, shader.name, &depth_desc)?;
        let color = |image: &&Image| Attachment { format: image.format(), role: Role::Color };
        let mut attachments: Vec<Attachment> = desc.images.iter().map(color).collect();
        attachments.push(Attachment { format: depth.format(), role: Role::Depth });
        let pass = RenderPass::new(context, shader.name, &attachments)?;
        let images: Vec<&Image> = desc.images.iter().copied().chain([&depth]).collect();
        let target = Framebuffer::new(context, &pass, &images)?;
        let pipeline = |cull_back| {
            let vertex_bytes = size_of::<V>() as u32;
            let (attributes, constants) = (desc.attributes, desc.constants);
            let desc = RasterDesc { shader, vertex_bytes, attributes, cull_back, constants };
            RasterPipeline::new(context, &pass, &desc)
        };
        let pipelines = [pipeline(false)?, pipeline(true)?];
        let (vertices, indices) = upload_ordered(context, uploads, desc.vertices, desc.indices, mesh.objects())?;
        let (solid, objects) = (Solid::new(mesh), mesh.objects().to_vec());
        Ok(MeshPass { pass, target, pipelines, solid, objects, vertices, indices, depth })
    }

    /// What binding sets are made for.
    pub fn pipeline(&self) -> &RasterPipeline {
        &self.pipelines[0]
    }

    /// Depth, 0 near to 1 far; 1 where nothing is.
    pub fn depth(&self) -> &Image {
        &self.depth
    }

    /// Width and height of what `recorder` draws of the pictures, pixels.
    pub fn size_px(&self, recorder: &Recorder<'_>) -> [u32; 2] {
        let [width, height, _] = self.depth.size_px();
        let drawn = recorder.drawn_area([width, height]).extent;
        [drawn.width, drawn.height]
    }

    /// The draws that a moment takes in a picture of this size: one for each run of objects with the same pose and
    /// `kind`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when the camera has no projection for the picture's shape.
    pub fn runs<K: PartialEq>(
        &self,
        [width, height]: [u32; 2],
        moment: &Moment,
        kind: impl Fn(usize) -> K,
    ) -> Result<Vec<Run<K>>> {
        let view_projection = moment.camera.view_projection(width as f32 / height as f32)?.as_dmat4();
        let light = moment.lights.mean_direction();
        let mut runs: Vec<Run<K>> = Vec::new();
        let mut last = None;
        for (number, object) in self.objects.iter().enumerate().filter(|(_, object)| object.index_count > 0) {
            let (pose, kind) = (moment.pose(number), kind(number));
            let range = object.first_index..object.first_index + object.index_count;
            match runs.last_mut() {
                Some(run) if run.kind == kind && last == Some(pose) => run.range.end = range.end,
                _ => runs.push(Run {
                    range,
                    kind,
                    to_clip: (view_projection * pose.matrix()).as_mat4().to_cols_array(),
                    light: pose.to_object(light).extend(0.0).to_array(),
                }),
            }
            last = Some(pose);
        }
        Ok(runs)
    }

    /// Records the pass.
    pub fn record<P: bytemuck::NoUninit>(&self, recorder: &mut Recorder<'_>, moment: &Moment, draws: &[Draw<'_, P>]) {
        let geometry = Geometry { vertices: &self.vertices, indices: &self.indices };
        let pipeline = &self.pipelines[usize::from(self.solid.hides_back_faces(moment))];
        recorder.draw(&self.pass, &self.target, pipeline, Some(&geometry), draws);
    }
}
