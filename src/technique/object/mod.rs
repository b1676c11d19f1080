//! Object-based texture mapping (thesis chapter 5): the quickest technique, with paint that is pinned to the surface.
//!
//! Prepared once: a coordinate t for every vertex ([`texture_coordinates`]), spread over the surface from neighbour to
//! neighbour, and the strip's texture, made to repeat along t. Drawn for every frame: one render pass over the mesh,
//! with the light's shade as s; so lights and objects may move, and marks stay on their lines of t.
//!
//! # Where the paint is lost, and what keeps it
//!
//! s and t place a point on the strip, and where they hardly change over the surface one texel spreads over all of it:
//! on flat faces, which have one shade (figure 5.3), and where the light falls along the direction of t, so that s and
//! t change together (figure 5.2). That is the thesis's failure; [`ObjectParams::keep_paint`] off shows it. With it on,
//! each pixel compares the texels that the mapping spreads over a piece of surface with those that `repeats` asks for.
//! Where it is less than a tenth, the texture is faded over to one that does not depend on the shade's slope: the strip
//! laid on the plane of two world axes that the face lies flattest on, with columns running to and fro in a window of
//! an eighth of the strip around the pixel's shade. Colour comes from the shade in any case.

mod coordinates;
mod nearest;

pub use coordinates::{density, texture_coordinates, CoordinateParams, Orientation, SeamPolicy};

use super::colors::ColorTable;
use super::{check_paints, Paint, ShadeRange, Show};
use crate::gpu::{
    Access, BindingKind, BindingSet, Context, Draw, Image, ImageDesc, RasterShader, Recorder, Sampler, Uploads,
    VertexAttribute,
};
use crate::paint::{TextureDifference, Trajectory};
use crate::scene::{Mesh, MeshDesc, MeshPass, Moment, Run};
use crate::Result;
use ash::vk;

pub(crate) const OBJECT: RasterShader = RasterShader {
    name: "object",
    vertex_spirv: include_bytes!("../../../glsl/spirv/technique/object.vert.spv"),
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/object.frag.spv"),
    bindings: &[BindingKind::Sampled(Access::FragmentSampled), BindingKind::Image(Access::FragmentRead)],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    to_clip: [f32; 16],
    light: [f32; 4],
    range: [f32; 2],
    density: f32,
    paint: u32,
    show: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    t: f32,
}

/// How the strip goes on above and below itself, along t.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StripRepeat {
    /// Its upper edge is cut into its lower one, where the difference shows least
    /// ([`TextureDifference::tileable_rows`]).
    #[default]
    Wrap,
    /// Every other repeat is mirrored.
    Mirror,
}

/// How to paint a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectParams {
    /// How t is spread over the surface.
    pub coordinates: CoordinateParams,
    /// How the strip repeats along t.
    pub repeat: StripRepeat,
    /// Keep the paint visible where the mapping loses it; see the module's documentation. Off is the thesis's.
    pub keep_paint: bool,
}

impl Default for ObjectParams {
    fn default() -> Self {
        ObjectParams { coordinates: CoordinateParams::default(), repeat: StripRepeat::default(), keep_paint: true }
    }
}

/// The technique, prepared for a mesh and its paints.
pub struct ObjectTechnique {
    density: f32,
    mesh: MeshPass,
    frame: Image,
    colors: ColorTable,
    /// The resources of each paint.
    sets: Vec<BindingSet>,
    paint_of_object: Vec<u32>,
}

impl ObjectTechnique {
    /// Prepares to paint `mesh` at `size` = (width, height) pixels. Object i is painted with
    /// `paints[paint_of_object[i]]`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for parameters out of range, no paint, or an object without one;
    /// [`crate::Error::Memory`] when the budget does not allow it.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        mesh: &Mesh,
        size: (u32, u32),
        paints: &[Paint<'_>],
        paint_of_object: &[u32],
        params: &ObjectParams,
    ) -> Result<Self> {
        check_paints(paints.len(), paint_of_object, mesh.objects().len())?;
        let t = texture_coordinates(mesh, &params.coordinates)?;
        let data: Vec<Vertex> = mesh
            .positions()
            .iter()
            .zip(mesh.normals())
            .zip(t)
            .map(|((&position, &normal), t)| Vertex { position, normal, t })
            .collect();
        let attribute = |format, offset| VertexAttribute { format, offset_bytes: offset as u32 };
        let attributes = [
            attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position)),
            attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal)),
            attribute(vk::Format::R32_SFLOAT, std::mem::offset_of!(Vertex, t)),
        ];
        let frame = Image::new(context, OBJECT.name, &ImageDesc::frame(size.0, size.1))?;
        let desc = MeshDesc {
            shader: OBJECT,
            constants: &[u32::from(params.keep_paint)],
            images: &[&frame],
            attributes: &attributes,
            vertices: &data,
            indices: mesh.indices(),
        };
        let pass = MeshPass::new(context, uploads, mesh, &desc)?;
        let colors = ColorTable::new(context, uploads, paints.iter().map(|paint| paint.trajectory))?;
        let along = match params.repeat {
            StripRepeat::Wrap => vk::SamplerAddressMode::REPEAT,
            StripRepeat::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
        };
        let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let sampler = Sampler::linear(context, [edge, along, edge])?;
        let mut sets = Vec::with_capacity(paints.len());
        for paint in paints {
            let strip = match params.repeat {
                StripRepeat::Wrap => strip_image(context, uploads, &paint.texture.tileable_rows())?,
                StripRepeat::Mirror => strip_image(context, uploads, paint.texture)?,
            };
            let bound = [(&strip, &sampler).into(), colors.image().into()];
            sets.push(BindingSet::new(context, pass.pipeline(), &bound)?);
        }
        Ok(ObjectTechnique {
            density: density(mesh, &params.coordinates)?,
            paint_of_object: paint_of_object.to_vec(),
            mesh: pass,
            frame,
            colors,
            sets,
        })
    }

    /// Records a frame.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when the camera has no projection for this picture's shape; nothing is recorded then.
    pub fn record(&self, recorder: &mut Recorder<'_>, moment: &Moment, range: ShadeRange, show: Show) -> Result<()> {
        let paint_of = |object| self.paint_of_object.get(object).copied().unwrap_or_default();
        let runs = self.mesh.runs(self.mesh.size_px(recorder), moment, paint_of)?;
        let draw = |run: Run<u32>| Draw {
            set: self.sets.get(run.kind as usize),
            push: Push {
                to_clip: run.to_clip,
                light: run.light,
                range: range.to_array(),
                density: self.density,
                paint: run.kind,
                show: show as u32,
            },
            range: run.range,
        };
        self.mesh.record(recorder, moment, &runs.into_iter().map(draw).collect::<Vec<_>>());
        Ok(())
    }

    /// Stages other colours for one of the paints. Texture stays as it is.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when there is no such paint, [`crate::Error::Memory`] when the budget does not allow
    /// it.
    pub fn set_trajectory(
        &mut self,
        context: &Context,
        uploads: &mut Uploads,
        paint: usize,
        trajectory: &Trajectory,
    ) -> Result<()> {
        self.colors.set(context, uploads, paint, trajectory)
    }

    /// Depth, 0 near to 1 far; 1 where nothing is.
    pub fn depth(&self) -> &Image {
        self.mesh.depth()
    }

    /// The frame: R8G8B8A8_UNORM, straight alpha, background 0.
    pub fn frame(&self) -> &Image {
        &self.frame
    }
}

fn strip_image(context: &Context, uploads: &mut Uploads, texture: &TextureDifference) -> Result<Image> {
    let desc = ImageDesc::sampled([texture.width(), texture.height(), 1], vk::Format::R8G8B8A8_UNORM);
    let image = Image::new(context, "strip", &desc)?;
    uploads.image(context, &image, bytemuck::cast_slice(&texture.to_unorm8()))?;
    Ok(image)
}
