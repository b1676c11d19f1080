//! Image-based texture synthesis (thesis chapter 6): the best single frames of the four techniques.
//!
//! For each pixel the colour comes from the trajectory at its shade, and the texture from guided quilting of the
//! paint's *difference* image; both are added and clipped. Colour is therefore right at every pixel however coarse the
//! blocks, and a new colour gradient needs no new synthesis. The background stays transparent.
//!
//! Stages: `image_guide` packs the guide, the quilting stages run once for each paint, `image_recombine` draws the
//! frame.
//!
//! Frames of a sequence that are synthesised each for itself flicker: the model looks as if it was seen through a
//! shower door. Two things help: [`ImageParams::previous`] as the thesis has it, and [`ImageTechnique::carry`] beyond
//! it.

use super::colors::ColorTable;
use super::picture_pass::frame_for;
use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Shader, Uploads,
};
use crate::paint::Trajectory;
use crate::scene::GuideImages;
use crate::synthesis::params::QuiltParams;
use crate::synthesis::quilt::{PreviousWeight, Quilt, QuiltGuide, QuiltStages, SampleTexels};
use crate::synthesis::repair::RepairParams;
use crate::technique::{check_paints, paint_picture, Paint, ShadeRange, Show};
use crate::{Error, Result};
use ash::vk;
use carry::Carry;
use std::ops::Range;
use std::sync::Arc;

mod carry;

pub(crate) use carry::{IMAGE_CARRY, IMAGE_SETTLE};

/// Block sizes that a position may lie from its place; more than any sample is wide.
const MAX_K: f32 = 1000.0;

pub(crate) const IMAGE_GUIDE: Shader = Shader {
    name: "image_guide",
    spirv: include_bytes!("../../../glsl/spirv/technique/image_guide.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<GuidePush>() as u32,
};

pub(crate) const IMAGE_RECOMBINE: Shader = Shader {
    name: "image_recombine",
    spirv: include_bytes!("../../../glsl/spirv/technique/image_recombine.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<RecombinePush>() as u32,
};

pub(crate) const IMAGE_BLEND: Shader = Shader {
    name: "image_blend",
    spirv: include_bytes!("../../../glsl/spirv/technique/image_blend.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<BlendPush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct BlendPush {
    paint: u32,
    show: u32,
    blend: f32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct GuidePush {
    /// What becomes 0 and 1.
    pub range: [f32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct RecombinePush {
    paint: u32,
    show: u32,
}

/// How to paint a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImageParams {
    /// How to quilt; `tileable` must be false.
    pub quilt: QuiltParams,
    /// How many block sizes a block's position may lie from x0 = L * W_sample: 0 to 1,000, fractions allowed. The
    /// thesis found 4 to work best; on a strip that is not much longer than eight blocks that spans most of it, the
    /// quietest part of the strip spreads over the model, and marks of one shade bring their hue into another. `None`
    /// takes 1/16 of the strip's width to either side, but no less than 1 block size and no more than 4.
    pub k: Option<f32>,
    /// The range of shade that is spread over the whole strip; all of it is the thesis's plain mapping.
    pub range: ShadeRange,
    /// How much each block is required to match the last frame (thesis chapter 6), if at all. It takes away most of the
    /// flicker where things move little; [`ImageTechnique::carry`] does more.
    pub previous: Option<PreviousWeight>,
}

impl ImageParams {
    /// How far, in columns, a block's position may lie from its place on a strip of this width: floor(k * block size).
    ///
    /// # Errors
    /// [`Error::Parameter`] when k is out of range.
    pub fn window_px(&self, strip_width_px: u32) -> Result<u32> {
        let block_px = f64::from(self.quilt.block_px);
        let window = match self.k {
            Some(k) if !(0.0..=MAX_K).contains(&k) => {
                return Err(Error::parameter("k", k, format!("0 to {MAX_K} block sizes")));
            }
            // A decimal fraction that f32 holds a little too low must not lose a column.
            Some(k) => f64::from(k) * block_px + 1e-4,
            None => (f64::from(strip_width_px) / 16.0).clamp(block_px, 4.0 * block_px),
        };
        Ok(window.floor() as u32)
    }
}

/// A part of a frame's work, small enough for one submission; see [`ImageTechnique::parts`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImagePart(Part);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Guide,
    Quilt(usize, Range<usize>),
    Recombine,
}

struct Layer {
    sample: SampleTexels,
    quilt: Quilt,
    recombine_set: BindingSet,
    /// With [`ImageParams::previous`] only.
    blend_set: Option<BindingSet>,
}

/// The technique, prepared for a scene's guides and its paints.
pub struct ImageTechnique {
    params: ImageParams,
    guide_stage: ComputePipeline,
    recombine_stage: ComputePipeline,
    blend_stage: ComputePipeline,
    guide_set: BindingSet,
    tone: Image,
    guide: Image,
    frame: Image,
    colors: ColorTable,
    layers: Vec<Layer>,
    carry: Option<Carry>,
}

impl ImageTechnique {
    /// Prepares to paint what `guides` draws. Object i is painted with `paints[paint_of_object[i]]`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range, a tileable quilting, a strip smaller than a block, no paint, or
    /// an object without one; [`Error::Memory`] when the budget does not allow it.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        guides: impl Into<GuideImages>,
        paints: &[Paint<'_>],
        paint_of_object: &[u32],
        params: &ImageParams,
    ) -> Result<Self> {
        let guides = guides.into();
        if params.quilt.tileable {
            return Err(Error::parameter("tileable", true, "false for image-based synthesis: a frame does not repeat"));
        }
        check_paints(paints.len(), paint_of_object, guides.object_count())?;
        let [width, height, _] = guides.shade().size_px();
        let image = |name, format| Image::new(context, name, &ImageDesc::storage_2d(width, height, format));
        let tone = image("image tone", vk::Format::R32_SFLOAT)?;
        let guide = image("image guide", vk::Format::R32_UINT)?;
        let frame = frame_for(context, "image frame", guides.depth())?;
        let colors = ColorTable::new(context, uploads, paints.iter().map(|paint| paint.trajectory))?;
        let objects = paint_picture(context, uploads, paint_of_object)?;
        let guide_stage = ComputePipeline::new(context, &IMAGE_GUIDE)?;
        let recombine_stage = ComputePipeline::new(context, &IMAGE_RECOMBINE)?;
        let blend_stage = ComputePipeline::new(context, &IMAGE_BLEND)?;
        let (shade, id) = (guides.shade(), guides.id());
        let bind = |stage, bound: &[_]| BindingSet::new(context, stage, bound);
        let guide_set =
            bind(&guide_stage, &[shade.into(), id.into(), (&objects).into(), (&tone).into(), (&guide).into()])?;
        let mut layers = Vec::with_capacity(paints.len());
        for (number, paint) in (1..).zip(paints) {
            let size = (paint.texture.width(), paint.texture.height());
            let sample = SampleTexels::new(context, uploads, &paint.texture.to_unorm8(), size)?;
            let window_px = params.window_px(size.0)?;
            let quilt_guide = QuiltGuide { image: guide.clone(), paint: number, window_px, previous: params.previous };
            let quilt =
                Quilt::new(context, uploads, stages, &sample, (width, height), &params.quilt, Some(quilt_guide))?;
            let desc = ImageDesc::storage_2d(size.0, size.1, vk::Format::R32G32B32A32_SFLOAT);
            let difference = Image::new(context, "texture difference", &desc)?;
            let texels: Vec<[f32; 4]> = paint.texture.pixels().iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
            uploads.image(context, &difference, bytemuck::cast_slice(&texels))?;
            let recombine_set = bind(
                &recombine_stage,
                &[
                    (&tone).into(),
                    (&guide).into(),
                    quilt.source().into(),
                    (&difference).into(),
                    colors.image().into(),
                    (&frame).into(),
                ],
            )?;
            let blend = |previous: &Image| {
                let images = [&tone, &guide, previous, quilt.canvas(), colors.image(), &frame];
                BindingSet::new(context, &blend_stage, &images.map(Into::into))
            };
            let blend_set = quilt.previous().map(blend).transpose()?;
            layers.push(Layer { sample, quilt, recombine_set, blend_set });
        }
        Ok(ImageTechnique {
            params: *params,
            guide_stage,
            recombine_stage,
            blend_stage,
            guide_set,
            tone,
            guide,
            frame,
            colors,
            layers,
            carry: None,
        })
    }

    /// Cuts a frame's work into parts of at most about `comparisons` pixel comparisons, to be submitted one by one.
    pub fn parts(&self, comparisons: u64) -> Vec<ImagePart> {
        let mut parts = vec![ImagePart(Part::Guide)];
        for (i, layer) in self.layers.iter().enumerate() {
            parts.extend(layer.quilt.parts(comparisons).into_iter().map(|part| ImagePart(Part::Quilt(i, part))));
        }
        parts.push(ImagePart(Part::Recombine));
        parts
    }

    /// Lets texture follow the surface from frame to frame, as `motion` says (see [`crate::scene::MotionPass`] for its
    /// format; R32_UINT, of the guides' size): [`ImageTechnique::record_next`] then draws frames that go on from the
    /// last.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range or a picture of another size or format; [`Error::Memory`] when the
    /// budget does not allow it.
    pub fn carry(
        &mut self,
        context: &Context,
        uploads: &mut Uploads,
        guides: impl Into<GuideImages>,
        paints: &[Paint<'_>],
        motion: &Image,
        params: &RepairParams,
    ) -> Result<()> {
        self.carry = Some(Carry::new(context, uploads, self, &guides.into(), paints, motion, params)?);
        Ok(())
    }

    /// Records that the next frame need not match the last one, for sequences with [`ImageParams::previous`].
    pub fn forget(&self, recorder: &mut Recorder<'_>) {
        self.layers.iter().for_each(|layer| layer.quilt.forget(recorder));
    }

    /// Records a frame that goes on from the last one, after [`ImageTechnique::carry`]: texture is carried along, and
    /// synthesised anew only where it no longer fits. Guides and motion must have been recorded before, and some frame
    /// by [`ImageTechnique::record`] or its parts. Without carrying, a frame is that of [`ImageTechnique::record`].
    pub fn record_next(&self, recorder: &mut Recorder<'_>, seed: u32, frame: u32) {
        let Some(carry) = &self.carry else {
            return self.record(recorder, seed, frame);
        };
        self.record_guide(recorder);
        carry.record(recorder, self.quilts(), seed, frame);
        self.record_recombine(recorder, Show::Painted);
    }

    /// Records a whole frame; the guides must have been recorded before. `seed` and `frame` enter the random choices.
    pub fn record(&self, recorder: &mut Recorder<'_>, seed: u32, frame: u32) {
        for part in self.parts(u64::MAX) {
            self.record_part(recorder, &part, seed, frame);
        }
    }

    /// Records one part; the parts of a frame must be recorded in order.
    pub fn record_part(&self, recorder: &mut Recorder<'_>, part: &ImagePart, seed: u32, frame: u32) {
        match &part.0 {
            Part::Guide => self.record_guide(recorder),
            Part::Quilt(layer, steps) => {
                if let Some(layer) = self.layers.get(*layer) {
                    layer.quilt.record_part(recorder, steps.clone(), seed, frame);
                }
            }
            Part::Recombine => self.record_recombine(recorder, Show::Painted),
        }
    }

    /// Records the first stage alone, for a frame that is drawn by [`ImageTechnique::record_blend`].
    pub fn record_guide(&self, recorder: &mut Recorder<'_>) {
        let [width, height, _] = self.tone.size_px();
        let push = GuidePush { range: self.params.range.to_array() };
        recorder.dispatch(&self.guide_stage, &self.guide_set, &push, [width.div_ceil(16), height.div_ceil(8), 1]);
    }

    /// Records a frame between the last two textures that were synthesised, with colours by the guide that was recorded
    /// last (thesis chapter 6: new texture for every n-th frame, blended in between); `blend` is 0 for the earlier and
    /// 1 for the later. For techniques with [`ImageParams::previous`].
    ///
    /// # Errors
    /// [`Error::Parameter`] without it, or for a blend outside of 0..=1; nothing is recorded then.
    pub fn record_blend(&self, recorder: &mut Recorder<'_>, blend: f32, show: Show) -> Result<()> {
        if !(0.0..=1.0).contains(&blend) {
            return Err(Error::parameter("blend", blend, "0 to 1"));
        }
        let [width, height, _] = self.tone.size_px();
        for (number, layer) in (1..).zip(&self.layers) {
            let Some(set) = &layer.blend_set else {
                return Err(Error::parameter("previous", "none", "a weight, for blending to know the texture before"));
            };
            let push = BlendPush { paint: number, show: show as u32, blend };
            recorder.dispatch(&self.blend_stage, set, &push, [width.div_ceil(16), height.div_ceil(8), 1]);
        }
        Ok(())
    }

    /// Records the frame's drawing alone: enough after [`ImageTechnique::set_trajectory`], and to see colour or texture
    /// by itself.
    pub fn record_recombine(&self, recorder: &mut Recorder<'_>, show: Show) {
        if let Some(carry) = &self.carry {
            carry.settle(recorder, show);
            return;
        }
        let [width, height, _] = self.tone.size_px();
        let groups = [width.div_ceil(16), height.div_ceil(8), 1];
        for (number, layer) in (1..).zip(&self.layers) {
            let push = RecombinePush { paint: number, show: show as u32 };
            recorder.dispatch(&self.recombine_stage, &layer.recombine_set, &push, groups);
        }
    }

    /// Stages another trajectory for one of the paints. Texture stays as it is.
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

    /// The frame: R8G8B8A8_UNORM, straight alpha, background 0.
    pub fn frame(&self) -> &Image {
        &self.frame
    }

    /// The shade in use, after levels: R32_SFLOAT in [0, 1], 0 on the background.
    pub fn shade(&self) -> &Image {
        &self.tone
    }

    /// After [`ImageTechnique::carry`], the last frame's places and what was carried to it for each paint. For tests.
    #[doc(hidden)]
    pub fn carried(&self) -> Option<(&Image, Vec<&Image>)> {
        self.carry.as_ref().map(Carry::images)
    }

    /// The synthesis of each paint.
    pub fn quilts(&self) -> impl Iterator<Item = &Quilt> {
        self.layers.iter().map(|layer| &layer.quilt)
    }
}
