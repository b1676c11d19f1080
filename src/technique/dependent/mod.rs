//! View-dependent interpolation (thesis chapter 8): important views have textures of their own, all others blend them.
//!
//! Prepared once: [`ViewCoverage`] draws the model from the important views and finds out which faces each of them
//! shows whole, with further views until every face is shown by some; [`DependentTechnique`] then synthesises a texture
//! for each view by guided quilting, as the image-based technique does for a picture, and stacks them into one 3D
//! image. A face's place in a slice is where the slice's view shows it. Drawn for every frame: which slices faces take,
//! each by the direction that it carries from frame to frame ([`Carry`]); a render pass over the mesh, for shade,
//! corner and distance of every pixel; and a pass over its pixels, which finds the surface's point by the distance and
//! blends the slices. So what is dear is done once for a pixel, however small the triangles are and however many lie
//! behind one another.
//!
//! At most [`MAX_BLENDED`] slices are blended for a face ([`blend_weights`]), with the contrast given back that
//! averaging takes, as in [`super::aligned`]. Neighbouring faces may have different slices: each fades out towards the
//! faces that it does not show, so that no seam is seen where it ends.

mod blend;
mod carry;
mod coverage;
mod faces;
mod geometry;
mod views;

pub use blend::{blend_weights, MAX_BLENDED};
pub use carry::Carry;
pub(crate) use carry::DEPENDENT_CARRY;
pub(crate) use coverage::check_views;
pub use coverage::{default_views, Coverage, CoverageReport, Covered, Round, Slice, View, MAX_SLICES, MAX_VIEWS};
pub use views::ViewCoverage;

use super::colors::ColorTable;
use super::image::{GuidePush, IMAGE_GUIDE};
use super::picture_pass::{frame_for, PicturePass, PICTURE};
use super::{check_paints, paint_picture, Paint, ShadeRange, Show};
use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Draw, Image, ImageDesc, RasterShader, Recorder, Sampler,
    Shader, Uploads, VertexAttribute,
};
use crate::paint::Trajectory;
use crate::scene::{Camera, Lights, Mesh, MeshDesc, MeshPass, Moment, ObjectRows, Pose, Run, Vec3};
use crate::synthesis::params::QuiltParams;
use crate::synthesis::quilt::{Quilt, QuiltGuide, QuiltStages, SampleTexels};
use crate::synthesis::volume::{SliceCopy, Volume};
use crate::technique::image::ImageParams;
use crate::{Error, Result};
use ash::vk;
use carry::CarryPass;
use faces::FacePass;
pub(crate) use faces::FACES;
use geometry::{face_corners, Vertex};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

pub(crate) const DEPENDENT_FEATHER: Shader = Shader {
    name: "dependent_feather",
    spirv: include_bytes!("../../../glsl/spirv/technique/dependent_feather.comp.spv"),
    bindings: &[BindingKind::Image(Access::ComputeRead), BindingKind::Image(Access::ComputeWrite)],
    push_bytes: size_of::<FeatherPush>() as u32,
};

pub(crate) const DEPENDENT_MESH: RasterShader = RasterShader {
    name: "dependent_mesh",
    vertex_spirv: include_bytes!("../../../glsl/spirv/technique/dependent_mesh.vert.spv"),
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/dependent_mesh.frag.spv"),
    bindings: &[],
    push_bytes: size_of::<MeshPush>() as u32,
};

pub(crate) const DEPENDENT: RasterShader = RasterShader {
    name: "dependent",
    vertex_spirv: PICTURE,
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/dependent.frag.spv"),
    bindings: &[
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Sampled(Access::FragmentSampled),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
    ],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct FeatherPush {
    columns: u32,
    radius: i32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct MeshPush {
    to_clip: [f32; 16],
    light: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    rays: [[f32; 4]; 4],
    range: [f32; 2],
    slices: u32,
    show: u32,
    keep_contrast: u32,
}

/// How far a slice fades out towards faces that it does not show, as a part of its side: 12 pixels of 512.
const FEATHER: u32 = 42;

/// How the views' textures are synthesised, and how they are blended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DependentParams {
    /// How to quilt; `tileable` must be false.
    pub quilt: QuiltParams,
    /// How far a block's place in the strip may be from its shade's, as [`ImageParams::k`].
    pub k: Option<f32>,
    /// Give back the contrast that blending takes. Off is the plain weighted mean.
    pub keep_contrast: bool,
    /// The range of shade that is spread over the strip.
    pub range: ShadeRange,
    /// By how many degrees, from a frame to the [`Carry::Next`], the direction that a face's texture was chosen by
    /// follows the camera's while the face is in sight: 0 to 180. It follows faster where marks would be stretched.
    /// With 180 every frame stands alone.
    pub follow_deg: f32,
}

impl Default for DependentParams {
    fn default() -> Self {
        DependentParams {
            quilt: QuiltParams::default(),
            k: None,
            keep_contrast: true,
            range: ShadeRange::default(),
            follow_deg: 0.25,
        }
    }
}

impl DependentParams {
    /// # Errors
    /// [`Error::Parameter`] for a tileable quilting, and an angle out of range.
    pub fn check(&self) -> Result<()> {
        if self.quilt.tileable {
            return Err(Error::parameter("tileable", true, "false for a view's texture: a view does not repeat"));
        }
        if !(0.0..=180.0).contains(&self.follow_deg) {
            return Err(Error::parameter("follow_deg", self.follow_deg, "0 to 180 degrees"));
        }
        Ok(())
    }
}

/// A part of the preparation, small enough for one submission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ViewPart {
    slice: usize,
    step: ViewStep,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum ViewStep {
    /// Draw what the view sees.
    Guide,
    /// Some steps of a paint's quilting.
    Quilt(usize, Range<usize>),
    /// Put all paints into the slice.
    Copy,
}

/// What only the preparation needs.
struct Preparation {
    faces: FacePass,
    /// Where each slice's faces lie in the pass's list.
    lists: Vec<Range<u32>>,
    cameras: Vec<Camera>,
    lights: Lights,
    guide_stage: ComputePipeline,
    guide_set: BindingSet,
    feather_stage: ComputePipeline,
    /// Along rows, and then along columns.
    feather_sets: [BindingSet; 2],
    quilts: Vec<Quilt>,
    /// For each slice, a copy for each paint.
    copies: Vec<Vec<SliceCopy>>,
}

/// The technique, prepared for a mesh, its views and its paints.
pub struct DependentTechnique {
    params: DependentParams,
    preparation: Option<Preparation>,
    volume: Volume,
    colors: ColorTable,
    carry: CarryPass,
    /// For each object the rows that take world space to the mesh's.
    objects: ObjectRows<3>,
    mesh: MeshPass,
    /// With all objects where the mesh has them, and with any elsewhere.
    passes: [PicturePass; 2],
    frame: Image,
    set: BindingSet,
}

impl DependentTechnique {
    /// Prepares to paint `mesh` at `size` = (width, height) pixels, with a texture of `view_px` pixels a side for every
    /// slice of `covered`, synthesised for the shades that `lights` give. Object i is painted with
    /// `paints[paint_of_object[i]]`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range, a tileable quilting, a strip smaller than a block, no paint,
    /// or an object without one; [`Error::Device`] when the device's 3D images are too small; [`Error::Memory`] when
    /// the budget does not allow it.
    #[allow(clippy::too_many_arguments)] // the device, the scene, the paints, the way
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        mesh: &Mesh,
        lights: &Lights,
        covered: &Covered,
        view_px: u32,
        size: (u32, u32),
        paints: &[Paint<'_>],
        paint_of_object: &[u32],
        params: &DependentParams,
    ) -> Result<Self> {
        check_paints(paints.len(), paint_of_object, mesh.objects().len())?;
        params.check()?;
        let slices = covered.slices.len() as u32;
        let volume = Volume::new(context, "views", (view_px, view_px), slices)?;
        let preparation = Preparation::new(
            context,
            uploads,
            stages,
            mesh,
            lights,
            covered,
            view_px,
            &volume,
            paints,
            paint_of_object,
            params,
        )?;
        let colors = ColorTable::new(context, uploads, paints.iter().map(|paint| paint.trajectory))?;

        let (set_of_face, sets) = sets_by_object(mesh, covered);
        let (corners, vertices, list) = face_corners(mesh, &set_of_face);
        let carry =
            CarryPass::new(context, uploads, mesh, &corners, &sets, paint_of_object, covered, params.follow_deg)?;
        let mut rows: Vec<[f32; 4]> = Vec::with_capacity(3 * covered.slices.len());
        for slice in &covered.slices {
            let projection = slice.camera.view_projection(1.0)?;
            rows.extend([0, 1, 3].map(|row| projection.row(row).to_array()));
        }
        let desc = ImageDesc::storage_2d(3, slices, vk::Format::R32G32B32A32_SFLOAT);
        let projections = Image::new(context, "projections", &desc)?;
        uploads.image(context, &projections, bytemuck::cast_slice(&rows))?;
        let objects = ObjectRows::new(context, "dependent_objects", mesh.objects().len())?;
        let attribute = |format, offset| VertexAttribute { format, offset_bytes: offset as u32 };
        let image = |name, format| Image::new(context, name, &ImageDesc::drawn(size.0, size.1, format));
        let shade = image("dependent shade", vk::Format::R32_SFLOAT)?;
        let corner = image("dependent corner", vk::Format::R32_UINT)?;
        let along = image("dependent distance", vk::Format::R32_SFLOAT)?;
        let desc = MeshDesc {
            shader: DEPENDENT_MESH,
            constants: &[],
            images: &[&shade, &corner, &along],
            attributes: &[
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position)),
                attribute(vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal)),
                attribute(vk::Format::R32_UINT, std::mem::offset_of!(Vertex, corner)),
            ],
            vertices: &vertices,
            indices: &list,
        };
        let mesh_pass = MeshPass::new(context, uploads, mesh, &desc)?;
        let frame = frame_for(context, DEPENDENT.name, mesh_pass.depth())?;
        let pass = |moved| PicturePass::new(context, DEPENDENT, &[moved], &[&frame], mesh_pass.depth());
        let passes = [pass(0)?, pass(1)?];
        let sampler = Sampler::linear(context, [vk::SamplerAddressMode::CLAMP_TO_EDGE; 3])?;
        let bound = [
            (&shade).into(),
            (&corner).into(),
            (&along).into(),
            carry.blends().into(),
            (&projections).into(),
            (volume.image(), &sampler).into(),
            colors.image().into(),
            objects.image().into(),
        ];
        let set = BindingSet::new(context, passes[0].pipeline(), &bound)?;
        Ok(DependentTechnique {
            params: *params,
            preparation: Some(preparation),
            volume,
            colors,
            carry,
            objects,
            mesh: mesh_pass,
            passes,
            frame,
            set,
        })
    }

    /// Cuts the preparation into parts of at most about `comparisons` pixel comparisons, to be submitted one by one, in
    /// order.
    pub fn preparation_parts(&self, comparisons: u64) -> Vec<ViewPart> {
        let Some(preparation) = &self.preparation else { return Vec::new() };
        let mut parts = Vec::new();
        for slice in 0..preparation.cameras.len() {
            parts.push(ViewPart { slice, step: ViewStep::Guide });
            for (paint, quilt) in preparation.quilts.iter().enumerate() {
                let steps = quilt.parts(comparisons).into_iter().map(|steps| ViewStep::Quilt(paint, steps));
                parts.extend(steps.map(|step| ViewPart { slice, step }));
            }
            parts.push(ViewPart { slice, step: ViewStep::Copy });
        }
        parts
    }

    /// Records a part of the preparation. `seed` plus the slice's number is the seed of its quilting.
    ///
    /// # Errors
    /// None for parts of [`DependentTechnique::preparation_parts`].
    pub fn record_preparation(&self, recorder: &mut Recorder<'_>, part: &ViewPart, seed: u32) -> Result<()> {
        let Some(preparation) = &self.preparation else { return Ok(()) };
        let slice = part.slice;
        let (Some(camera), Some(list)) = (preparation.cameras.get(slice), preparation.lists.get(slice)) else {
            return Ok(());
        };
        match &part.step {
            ViewStep::Guide => {
                let faces = &preparation.faces;
                faces.record(recorder, camera, &preparation.lights, list.clone())?;
                let [width, height, _] = faces.shade.size_px();
                let groups = [width.div_ceil(16), height.div_ceil(8), 1];
                let push = GuidePush { range: self.params.range.to_array() };
                recorder.dispatch(&preparation.guide_stage, &preparation.guide_set, &push, groups);
                for (columns, set) in (0..).zip(&preparation.feather_sets) {
                    let push = FeatherPush { columns, radius: (width / FEATHER).max(1) as i32 };
                    recorder.dispatch(&preparation.feather_stage, set, &push, groups);
                }
            }
            ViewStep::Quilt(paint, steps) => {
                if let Some(quilt) = preparation.quilts.get(*paint) {
                    quilt.record_part(recorder, steps.clone(), seed.wrapping_add(slice as u32), 0);
                }
            }
            ViewStep::Copy => {
                // The copies of other paints keep what those before have written: in order, a pass each.
                for copy in preparation.copies.get(slice).into_iter().flatten() {
                    self.volume.record(recorder, copy);
                }
            }
        }
        Ok(())
    }

    /// Lets go of what only the preparation needs, once all of it is recorded.
    pub fn finish_preparation(&mut self) {
        self.preparation = None;
    }

    /// Records a frame that stands alone: [`DependentTechnique::record_carry`] with [`Carry::Cut`], and the picture.
    ///
    /// # Errors
    /// Those of [`DependentTechnique::record_picture`].
    pub fn record(&self, recorder: &mut Recorder<'_>, moment: &Moment, show: Show) -> Result<()> {
        self.record_carry(recorder, moment, Carry::Cut);
        self.record_picture(recorder, moment, show)
    }

    /// Records which texture faces take in a frame, without drawing it. Pictures of frames in between may be left out:
    /// those of later ones stay the same as long as this is recorded for every frame from the cut on.
    pub fn record_carry(&self, recorder: &mut Recorder<'_>, moment: &Moment, carry: Carry) {
        self.carry.record(recorder, moment, carry);
    }

    /// Records a picture of faces with the texture that was recorded last.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the camera has no projection for this picture's shape; nothing is recorded then.
    pub fn record_picture(&self, recorder: &mut Recorder<'_>, moment: &Moment, show: Show) -> Result<()> {
        let size_px = self.mesh.size_px(recorder);
        let runs = self.mesh.runs(size_px, moment, |_| ())?;
        let rays = rays(&moment.camera, size_px)?;
        self.objects.record(recorder, |object| {
            let to_object = moment.pose(object).matrix().inverse().as_mat4();
            [0, 1, 2].map(|row| to_object.row(row).to_array())
        });
        let draw = |run: Run<()>| Draw {
            set: None,
            push: MeshPush { to_clip: run.to_clip, light: run.light },
            range: run.range,
        };
        self.mesh.record(recorder, moment, &runs.into_iter().map(draw).collect::<Vec<_>>());
        let push = Push {
            rays,
            range: self.params.range.to_array(),
            slices: self.volume.image().size_px()[2],
            show: show as u32,
            keep_contrast: u32::from(self.params.keep_contrast),
        };
        let moved = moment.poses.iter().any(|pose| *pose != Pose::REST);
        self.passes[usize::from(moved)].record(recorder, &[(&self.set, push)]);
        Ok(())
    }

    /// Stages other colours for one of the paints. Texture stays as it is.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is no such paint, [`Error::Memory`] when the budget does not allow it.
    pub fn set_trajectory(
        &mut self,
        context: &Context,
        uploads: &mut Uploads,
        paint: usize,
        trajectory: &Trajectory,
    ) -> Result<()> {
        self.colors.set(context, uploads, paint, trajectory)
    }

    /// The views' textures: R8G8B8A8_UNORM, 3D, a slice for each view (one more, empty, where there is only one), the
    /// difference from [-1, 1] mapped to [0, 1]. Alpha is how far inside the slice's faces a texel lies: with d pixels
    /// to the next texel that shows none of them, and R a 42nd of the side, (d / R)^2 in 255ths rounded down, 255 at
    /// most. A slice's weight ([`blend_weights`]) is multiplied by it, at least by 1/255, before the weights are
    /// normalised.
    pub fn slices(&self) -> &Image {
        self.volume.image()
    }

    /// The guide of the slice that was prepared last, as [`QuiltGuide::image`]; `None` once the preparation is
    /// finished.
    pub fn guide(&self) -> Option<&Image> {
        self.preparation.as_ref().and_then(|preparation| preparation.quilts.first()).and_then(Quilt::guide)
    }

    /// What is carried, for each vertex in which faces of one set of slices begin, one after the other in rows: the
    /// direction that they take their texture by, a unit vector from the middle of the model as their object has it,
    /// and the cosine of the angle between the vertex's normal and the way from the eye: R32G32B32A32_SFLOAT.
    pub fn carried(&self) -> &Image {
        self.carry.carried()
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

/// The set and object of every face as one number, and what each number stands for. Objects share none, for each may be
/// turned in a way of its own and so be seen from another side.
fn sets_by_object(mesh: &Mesh, covered: &Covered) -> (Vec<u32>, Vec<(u32, u32)>) {
    let mut sets: Vec<(u32, u32)> = Vec::new();
    let mut numbers: HashMap<(u32, u32), u32> = HashMap::new();
    let objects = (0..).zip(mesh.objects());
    let object_of_face =
        objects.flat_map(|(number, object)| std::iter::repeat_n(number, object.index_count as usize / 3));
    let number = |(&set, object): (&u32, u32)| {
        *numbers.entry((set, object)).or_insert_with(|| {
            sets.push((set, object));
            sets.len() as u32 - 1
        })
    };
    let of_face = covered.set_of_face.iter().zip(object_of_face).map(number).collect();
    (of_face, sets)
}

/// The eye, and the rays through the pixels: pixel (x, y) sees along [1] + x [2] + y [3], which is 1 long along the
/// view axis; x and y are 0.5 at the centre of the upper left pixel.
fn rays(camera: &Camera, [width, height]: [u32; 2]) -> Result<[[f32; 4]; 4]> {
    let projection = camera.projection(width as f32 / height as f32)?;
    // From the view's axes to the world's.
    let turned = camera.view().transpose();
    let across = turned.transform_vector3(Vec3::X / projection.x_axis.x);
    let down = turned.transform_vector3(Vec3::Y / projection.y_axis.y);
    let corner = camera.forward() - across - down;
    let (across, down) = (2.0 / width as f32 * across, 2.0 / height as f32 * down);
    Ok([camera.eye(), corner, across, down].map(|v| v.extend(0.0).to_array()))
}

impl Preparation {
    #[allow(clippy::too_many_arguments)] // as DependentTechnique::new
    fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        mesh: &Mesh,
        lights: &Lights,
        covered: &Covered,
        view_px: u32,
        volume: &Volume,
        paints: &[Paint<'_>],
        paint_of_object: &[u32],
        params: &DependentParams,
    ) -> Result<Self> {
        let lists = covered.slices.iter().flat_map(|slice| slice.faces.iter().copied());
        let faces = FacePass::new(context, uploads, mesh, view_px, lists)?;
        let mut end = 0;
        let lists = covered.slices.iter().map(|slice| {
            let begin = end;
            end += slice.faces.len() as u32;
            begin..end
        });
        let lists = lists.collect();
        let image = |name, format| Image::new(context, name, &ImageDesc::storage_2d(view_px, view_px, format));
        let tone = image("view tone", vk::Format::R32_SFLOAT)?;
        let guide = image("view guide", vk::Format::R32_UINT)?;
        let objects = paint_picture(context, uploads, paint_of_object)?;
        let guide_stage = ComputePipeline::new(context, &IMAGE_GUIDE)?;
        let bound = [(&faces.shade).into(), (&faces.id).into(), (&objects).into(), (&tone).into(), (&guide).into()];
        let guide_set = BindingSet::new(context, &guide_stage, &bound)?;
        let rows = image("view feather rows", vk::Format::R32_UINT)?;
        let feather = image("view feather", vk::Format::R32_UINT)?;
        let feather_stage = ComputePipeline::new(context, &DEPENDENT_FEATHER)?;
        let feather_sets = [
            BindingSet::new(context, &feather_stage, &[(&guide).into(), (&rows).into()])?,
            BindingSet::new(context, &feather_stage, &[(&rows).into(), (&feather).into()])?,
        ];
        let window = ImageParams { quilt: params.quilt, k: params.k, ..ImageParams::default() };
        let mut quilts = Vec::with_capacity(paints.len());
        for (number, paint) in (1..).zip(paints) {
            let size = (paint.texture.width(), paint.texture.height());
            let sample = SampleTexels::new(context, uploads, &paint.texture.to_unorm8(), size)?;
            let quilt_guide = QuiltGuide {
                image: guide.clone(),
                paint: number,
                window_px: window.window_px(size.0)?,
                previous: None,
            };
            let output = (view_px, view_px);
            quilts.push(Quilt::new(context, uploads, stages, &sample, output, &params.quilt, Some(quilt_guide))?);
        }
        let mut copies = Vec::with_capacity(covered.slices.len());
        for slice in 0..covered.slices.len() as u32 {
            let mut of_slice = Vec::with_capacity(quilts.len());
            for (number, quilt) in (1..).zip(&quilts) {
                of_slice.push(volume.copy_guided(context, quilt, [&guide, &feather], number, slice, number == 1)?);
            }
            copies.push(of_slice);
        }
        let cameras = covered.slices.iter().map(|slice| slice.camera).collect();
        Ok(Preparation {
            faces,
            lists,
            cameras,
            lights: lights.clone(),
            guide_stage,
            guide_set,
            feather_stage,
            feather_sets,
            quilts,
            copies,
        })
    }
}
