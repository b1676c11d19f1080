//! Repairs a quilting whose texture was carried from one frame to the next: blocks whose texture no longer fits are
//! synthesised anew, into what stays around them.
//!
//! Carrying gives each pixel a *place*: where in the sample its texture comes from, in 1/64 texels ([`STEPS`]).
//! `repair_fit` decides for each block whether its carried texture stays: it does unless a pixel has none, or it is
//! stretched, compressed or turned too far, or its shade now asks for another part of the sample. Then the other blocks
//! are placed as in quilting: `quilt_match` searches, and `quilt_place` chooses, cuts and pastes; here with cuts on all
//! sides on which texture stays. What stays is what a block holds that keeps its texture. Blocks are placed in four
//! rounds, by even and odd rows and columns, since no two blocks of a round share a pixel.
//!
//! The technique carries the places and draws from them; [`super::repair_oracle`] is the plain CPU twin.

use super::params::{Layout, QuiltParams};
use super::quilt::{Quilt, QuiltGuide, SampleTexels, Waves};
use crate::gpu::{Access, BindingKind, BindingSet, ComputePipeline, Context, Image, Recorder, Shader, Uploads};
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Steps of a texel in a place, and of a pixel in motion.
pub const STEPS: u32 = 64;

/// How images hold places: x and y in 16 bits to a channel, low half first.
pub const PLACES: vk::Format = vk::Format::R16G16B16A16_UINT;

/// What [`Quilt::source`] has after a repair where nothing was pasted.
pub const NOT_PASTED: u32 = u32::MAX;

pub(crate) const REPAIR_FIT: Shader = Shader {
    name: "repair_fit",
    spirv: include_bytes!("../../glsl/spirv/synthesis/repair_fit.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeReadWrite),
    ],
    push_bytes: size_of::<FitPush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct FitPush {
    pub output: [u32; 2],
    pub sample: [u32; 2],
    pub block_px: u32,
    pub overlap_px: u32,
    pub columns: u32,
    pub rows: u32,
    pub paint: u32,
    pub window_px: u32,
    pub slack: u32,
    pub least: u32,
    pub most: u32,
}

/// When carried texture no longer fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepairParams {
    /// By what factor texture may be stretched or compressed in any direction: 1.05 to 1.5.
    pub stretch: f32,
    /// How many block sizes beyond its window a block's texture may come from once the shade has changed: 0 to 100.
    pub slack: f32,
}

impl Default for RepairParams {
    fn default() -> Self {
        RepairParams { stretch: 1.25, slack: 0.5 }
    }
}

impl RepairParams {
    /// Checks every field.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field outside of its range.
    pub fn check(&self) -> Result<()> {
        if !(1.05..=1.5).contains(&self.stretch) {
            return Err(Error::parameter("stretch", self.stretch, "1.05 to 1.5"));
        }
        if !(0.0..=100.0).contains(&self.slack) {
            return Err(Error::parameter("slack", self.slack, "0 to 100 block sizes"));
        }
        Ok(())
    }

    /// The least and the most singular value of the way from screen to sample, in [`STEPS`], as the stages have them.
    pub fn limits(&self) -> (u32, u32) {
        let steps = f64::from(STEPS);
        let stretch = f64::from(self.stretch);
        ((steps / stretch).round() as u32, (steps * stretch).round() as u32)
    }

    /// The slack in texels.
    pub fn slack_px(&self, block_px: u32) -> u32 {
        (f64::from(self.slack) * f64::from(block_px)).floor() as u32
    }
}

/// The compiled stages of a repair, besides those of quilting.
pub struct RepairStages {
    fit: ComputePipeline,
}

impl RepairStages {
    /// Compiles the stages.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context) -> Result<Arc<Self>> {
        Ok(Arc::new(RepairStages { fit: ComputePipeline::new(context, &REPAIR_FIT)? }))
    }
}

/// Repairs of one quilting, ready to be recorded.
pub struct Repair {
    stages: Arc<RepairStages>,
    params: RepairParams,
    guide: QuiltGuide,
    waves: Waves,
    fit_set: BindingSet,
}

impl Repair {
    /// Prepares to repair `quilt`, which is guided and not tileable and was made of `sample`. When it is recorded,
    /// `carried` (of the output's size, in the format [`PLACES`]) has the places of the quilt's paint, x and y in steps of
    /// 32 bits, the highest bit of y set where there is one; and the canvas has the texels nearest to them.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range or a quilting that cannot be repaired; [`Error::Memory`] when
    /// the budget does not allow it.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<RepairStages>,
        quilt: &Quilt,
        sample: &SampleTexels,
        carried: &Image,
        params: &RepairParams,
    ) -> Result<Self> {
        params.check()?;
        let Some(guide) = quilt.guide.clone().filter(|_| !quilt.params.tileable) else {
            return Err(Error::parameter("quilting", "free or tileable", "guided and not tileable, to be repaired"));
        };
        let (width, height) = quilt.layout.output;
        if carried.size_px() != [width, height, 1] {
            let [w, h, _] = carried.size_px();
            return Err(Error::parameter("carried places", format!("{w}x{h}"), format!("{width}x{height}")));
        }
        let waves = quilt.repair_waves(context, uploads, sample, &rounds(&quilt.layout), &guide.image)?;
        let bound = [(&guide.image).into(), carried.into(), (&quilt.blocks).into()];
        let fit_set = BindingSet::new(context, &stages.fit, &bound)?;
        Ok(Repair { stages: stages.clone(), params: *params, guide, waves, fit_set })
    }

    /// Records the repair of `quilt`, that which this was made for. Its [`Quilt::source`] then holds where in the sample
    /// each pixel that was synthesised anew came from, and 2^32 - 1 elsewhere. `seed` and `frame` enter the random
    /// choices.
    pub fn record(&self, recorder: &mut Recorder<'_>, quilt: &Quilt, seed: u32, frame: u32) {
        let QuiltParams { block_px, overlap_px, .. } = quilt.params;
        let sample = [quilt.sample_size.0, quilt.sample_size.1];
        let Layout { columns, rows, output, .. } = quilt.layout;
        let (least, most) = self.params.limits();
        let push = FitPush {
            output: [output.0, output.1],
            sample,
            block_px,
            overlap_px,
            columns,
            rows,
            paint: self.guide.paint,
            // More than a sample is wide makes no difference, and stays clear of overflow.
            window_px: self.guide.window_px.min(sample[0]),
            slack: self.params.slack_px(block_px).min(sample[0]),
            least,
            most,
        };
        recorder.fill_images("repair_clear", &[quilt.source()], NOT_PASTED);
        recorder.dispatch(&self.stages.fit, &self.fit_set, &push, quilt.groups_by_block());
        quilt.record_waves(recorder, &self.waves, .., seed, frame);
    }
}

/// The rounds in which blocks are placed: even rows and columns, even rows and odd columns, and so on.
pub(super) fn rounds(layout: &Layout) -> Vec<Vec<u32>> {
    let mut rounds = vec![Vec::new(); 4];
    for (index, placement) in (0..).zip(&layout.placements) {
        rounds[(2 * (placement.row % 2) + placement.col % 2) as usize].push(index);
    }
    rounds.retain(|round| !round.is_empty());
    rounds
}
