//! The guide pass: one explicit render pass that draws the scene's shade, object IDs and depth (thesis 3.1.2, 3.1.3).
//!
//! Techniques read its images: shade decides which paint goes where, the ID which pixels are painted at all and with
//! which strip. The oracle is [`super::GuideOracle`]. A host that draws these images itself needs no pass of ours: it
//! hands them over as [`GuideImages`].

use super::mesh_pass::{MeshDesc, MeshPass, Run};
use super::{Mesh, Moment, MAX_OBJECTS};
use crate::gpu::{Context, Draw, Image, ImageDesc, RasterShader, Recorder, Uploads, VertexAttribute};
use crate::{Error, Result};
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
    to_clip: [f32; 16],
    light: [f32; 4],
}

/// What techniques read of a scene, by [`GuidePass`] or by a host. Clones are the same images.
#[derive(Clone)]
pub struct GuideImages {
    shade: Image,
    id: Image,
    depth: Image,
    object_count: usize,
}

impl GuideImages {
    /// Takes a host's images, which hold what those of [`GuidePass`] do, of a scene of `object_count` objects (1 to
    /// [`MAX_OBJECTS`]). All are 2D, have one size, and are read wherever a frame is recorded.
    ///
    /// - `shade`: R32_SFLOAT, made for STORAGE; 0 dark to 1 light.
    /// - `id`: R32_UINT, made for STORAGE, and for TRANSFER_SRC where motion is followed; object index + 1, at most
    ///   `object_count`, and 0 in the background.
    /// - `depth`: D32_SFLOAT or X8_D24_UNORM_PACK32, made for DEPTH_STENCIL_ATTACHMENT, and for SAMPLED and
    ///   TRANSFER_SRC where motion is followed; 0 near to 1 far, and 1 exactly where `id` is 0. A reversed depth must
    ///   be turned first.
    ///
    /// # Errors
    /// [`Error::Parameter`] for another format, use or size, or a number of objects out of range.
    pub fn new(shade: &Image, id: &Image, depth: &Image, object_count: usize) -> Result<Self> {
        use vk::{Format as F, ImageUsageFlags as U};
        shade.check("guide shade", &[F::R32_SFLOAT], U::STORAGE)?;
        id.check("guide id", &[F::R32_UINT], U::STORAGE)?;
        depth.check("guide depth", &[F::D32_SFLOAT, F::X8_D24_UNORM_PACK32], U::DEPTH_STENCIL_ATTACHMENT)?;
        let [width, height, _] = shade.size_px();
        for (name, image) in [("guide shade", shade), ("guide id", id), ("guide depth", depth)] {
            image.check_size(name, [width, height, 1])?;
        }
        if !(1..=MAX_OBJECTS).contains(&object_count) {
            return Err(Error::parameter("object_count", object_count, format!("1 to {MAX_OBJECTS}")));
        }
        Ok(GuideImages { shade: shade.clone(), id: id.clone(), depth: depth.clone(), object_count })
    }

    /// Objects of the scene; IDs go from 1 to this.
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

impl From<&GuideImages> for GuideImages {
    fn from(images: &GuideImages) -> Self {
        images.clone()
    }
}

impl From<&GuidePass> for GuideImages {
    fn from(pass: &GuidePass) -> Self {
        pass.images.clone()
    }
}

/// A mesh on the device and the images that its guides are drawn to.
pub struct GuidePass {
    mesh: MeshPass,
    images: GuideImages,
}

impl GuidePass {
    /// Prepares to draw `mesh` at `size` = (width, height) pixels.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a size that the device cannot do, [`crate::Error::Memory`] when the budget does
    /// not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, uploads: &mut Uploads, mesh: &Mesh, size: (u32, u32)) -> Result<Self> {
        let image = |name, format| Image::new(context, name, &ImageDesc::drawn(size.0, size.1, format));
        let shade = image("guide shade", vk::Format::R32_SFLOAT)?;
        let id = image("guide id", vk::Format::R32_UINT)?;
        let attribute = |format, offset| VertexAttribute { format, offset_bytes: offset as u32 };
        let vertices: Vec<Vertex> = mesh
            .positions()
            .iter()
            .zip(mesh.normals())
            .zip(mesh.object_of_vertex())
            .map(|((&position, &normal), object)| Vertex { position, normal, id: object + 1 })
            .collect();
        let desc = MeshDesc {
            shader: GUIDE,
            constants: &[],
            images: &[&shade, &id],
            attributes: &[
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position)),
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal)),
                attribute(vk::Format::R32_UINT, std::mem::offset_of!(Vertex, id)),
            ],
            vertices: &vertices,
            indices: mesh.indices(),
        };
        let object_count = mesh.objects().len();
        let mesh = MeshPass::new(context, uploads, mesh, &desc)?;
        let depth = mesh.depth().clone();
        Ok(GuidePass { mesh, images: GuideImages { shade, id, depth, object_count } })
    }

    /// Records the pass.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when the camera has no projection for this picture's shape; nothing is recorded
    /// then.
    pub fn record(&self, recorder: &mut Recorder<'_>, moment: &Moment) -> Result<()> {
        let runs = self.mesh.runs(self.mesh.size_px(recorder), moment, |_| ())?;
        let draw =
            |run: Run<()>| Draw { set: None, push: Push { to_clip: run.to_clip, light: run.light }, range: run.range };
        self.mesh.record(recorder, moment, &runs.into_iter().map(draw).collect::<Vec<_>>());
        Ok(())
    }

    /// Objects of the mesh; IDs go from 1 to this.
    pub fn object_count(&self) -> usize {
        self.images.object_count
    }

    /// Shade, R32_SFLOAT in [0, 1]; 0 where nothing is.
    pub fn shade(&self) -> &Image {
        &self.images.shade
    }

    /// Object index + 1, R32_UINT; 0 where nothing is.
    pub fn id(&self) -> &Image {
        &self.images.id
    }

    /// Depth, 0 near to 1 far; 1 where nothing is.
    pub fn depth(&self) -> &Image {
        &self.images.depth
    }
}
