//! Texture that follows the surface, for image-based sequences beyond the thesis: the quality of synthesis with the calm of
//! texture that is pinned to the model.
//!
//! Each pixel has a *place*: where in the strip its texture comes from. `image_carry` brings the places of the last frame
//! to where their surface is now, the repair stages of [`crate::synthesis::repair`] synthesise anew what no longer fits,
//! and `image_settle` writes the places of the new frame and draws it from the strip itself. Colours are looked up once
//! from the strip and never from a frame, so no blur builds up, however long the sequence.

use super::{ImageTechnique, RecombinePush};
use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Shader, Uploads,
};
use crate::synthesis::quilt::Quilt;
use crate::synthesis::repair::{Repair, RepairParams, RepairStages};
use crate::{Error, Result};
use ash::vk;

pub(crate) const IMAGE_CARRY: Shader = Shader {
    name: "image_carry",
    spirv: include_bytes!("../../../glsl/spirv/technique/image_carry.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: 0,
};

pub(crate) const IMAGE_SETTLE: Shader = Shader {
    name: "image_settle",
    spirv: include_bytes!("../../../glsl/spirv/technique/image_settle.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<RecombinePush>() as u32,
};

/// What carrying needs for all paints.
pub(super) struct Carry {
    carry_stage: ComputePipeline,
    settle_stage: ComputePipeline,
    carry_set: BindingSet,
    /// A repair and the last stage for each paint.
    layers: Vec<(Repair, BindingSet)>,
    carried: Image,
}

impl Carry {
    /// Prepares to carry what `technique` paints.
    pub(super) fn new(
        context: &Context,
        uploads: &mut Uploads,
        technique: &ImageTechnique,
        motion: &Image,
        params: &RepairParams,
    ) -> Result<Self> {
        let size = technique.tone.size_px();
        if motion.size_px() != size {
            let shown = |[width, height, _]: [u32; 3]| format!("{width}x{height}");
            return Err(Error::parameter("motion", shown(motion.size_px()), shown(size)));
        }
        let image = |name| Image::new(context, name, &ImageDesc::storage_2d(size[0], size[1], vk::Format::R32G32_UINT));
        let (places, carried) = (image("image places")?, image("image carried")?);
        let carry_stage = ComputePipeline::new(context, &IMAGE_CARRY)?;
        let settle_stage = ComputePipeline::new(context, &IMAGE_SETTLE)?;
        let carry_set = BindingSet::new(
            context,
            &carry_stage,
            &[motion.into(), (&technique.guide).into(), (&places).into(), (&carried).into()],
        )?;
        let stages = RepairStages::new(context)?;
        let mut layers = Vec::with_capacity(technique.layers.len());
        for layer in &technique.layers {
            let repair = Repair::new(context, uploads, &stages, &layer.quilt, &layer.sample, &carried, params)?;
            let bound = [
                (&technique.tone).into(),
                (&technique.guide).into(),
                layer.quilt.source().into(),
                (&carried).into(),
                (&layer.difference).into(),
                (&layer.colors).into(),
                (&places).into(),
                (&technique.frame).into(),
            ];
            layers.push((repair, BindingSet::new(context, &settle_stage, &bound)?));
        }
        Ok(Carry { carry_stage, settle_stage, carry_set, layers, carried })
    }

    /// Records carrying and repairs, from the guide on; `quilts` are those of the technique.
    pub(super) fn record<'q>(
        &self,
        recorder: &mut Recorder<'_>,
        quilts: impl Iterator<Item = &'q Quilt>,
        seed: u32,
        frame: u32,
    ) {
        let [width, height, _] = self.carried.size_px();
        let groups = [width.div_ceil(16), height.div_ceil(8), 1];
        recorder.dispatch(&self.carry_stage, &self.carry_set, &(), groups);
        for ((repair, _), quilt) in self.layers.iter().zip(quilts) {
            repair.record(recorder, quilt, seed, frame);
        }
    }

    /// Records the last stage for a paint.
    pub(super) fn settle(&self, recorder: &mut Recorder<'_>, layer: usize, push: &RecombinePush, groups: [u32; 3]) {
        if let Some((_, set)) = self.layers.get(layer) {
            recorder.dispatch(&self.settle_stage, set, push, groups);
        }
    }
}
