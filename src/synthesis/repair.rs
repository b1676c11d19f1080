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
use super::quilt::{Quilt, QuiltGuide, SampleTexels, ERRORS_BYTES};
use super::quilt_stages::{Rows, Stage, Targets};
use crate::gpu::{
    Access, BindingKind, BindingSet, Buffer, BufferKind, ComputePipeline, Context, Image, Recorder, Shader,
};
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Steps of a texel in a place, and of a pixel in motion.
pub const STEPS: u32 = 64;

/// How images hold places: x and y in 16 bits to a channel, low half first.
pub const PLACES: vk::Format = vk::Format::R16G16B16A16_UINT;

/// What [`Quilt::source`] has after a repair where nothing was pasted.
pub const NOT_PASTED: u32 = u32::MAX;

/// About how many positions a block is compared at: where there are more, every second row of them, or every third, and
/// so on, other ones in each frame. A frame's repairs must not cost more than the frame.
const POSITIONS: u32 = 2048;

/// Bytes of a round's two numbers of workgroups.
const COUNT_BYTES: u64 = 24;

pub(crate) const REPAIR_FIT: Shader = Shader {
    name: "repair_fit",
    spirv: include_bytes!("../../glsl/spirv/synthesis/repair_fit.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeReadWrite),
        BindingKind::Buffer(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeReadWrite),
    ],
    push_bytes: size_of::<FitPush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct FitPush {
    pub sample_width: u32,
    pub block_px: u32,
    pub overlap_px: u32,
    pub columns: u32,
    pub rows: u32,
    pub paint: u32,
    pub window_px: u32,
    pub slack: u32,
    pub capacity: u32,
    pub band_rows: u32,
}

/// When carried texture no longer fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepairParams {
    /// By what factor texture may be stretched or compressed in any direction: 1.05 to 1.5.
    pub stretch: f32,
    /// How much worse than the best position a position may fit and still be chosen, as [`QuiltParams::tolerance`].
    pub tolerance: f32,
    /// How many block sizes beyond its window a block's texture may come from once the shade has changed: 0 to 100.
    pub slack: f32,
}

impl Default for RepairParams {
    fn default() -> Self {
        RepairParams { stretch: 1.25, tolerance: 0.1, slack: 0.5 }
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
        if !(0.0..=10.0).contains(&self.tolerance) {
            return Err(Error::parameter("repair tolerance", self.tolerance, "0 to 10"));
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
    rounds: Rounds,
    /// Every how many rows of positions are compared.
    row_step: u32,
    /// For each round the workgroups of search and placing, three words each: written by `repair_fit`.
    counts: Buffer,
    fit_set: BindingSet,
    matching: Stage,
    place: Stage,
}

impl Repair {
    /// Prepares to repair `quilt`, which is guided and not tileable and was made of `sample`. When it is recorded,
    /// `carried` (of the output's size, in the format [`PLACES`]) has the places of the quilt's paint, x and y in steps
    /// of 32 bits, the highest bit of y set where there is one and the next where it no longer looks like the sample;
    /// and the canvas has the texels nearest to them.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range or a quilting that cannot be repaired; [`Error::Memory`] when
    /// the budget does not allow it.
    pub fn new(
        context: &Context,
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
        carried.check_size("carried places", quilt.canvas().size_px())?;
        let sample_height = quilt.sample_size.1;
        let all_rows = sample_height - quilt.params.block_px + 1;
        let row_step = (all_rows * quilt.columns / POSITIONS).clamp(1, all_rows);
        let rows = Rows::new(&quilt.params, sample_height, quilt.columns, 0, row_step);
        let rounds = Rounds::new(&quilt.layout, (ERRORS_BYTES / rows.block_bytes()).min(65_535) as u32);
        let storage = |name, bytes| Buffer::new(context, name, BufferKind::Storage, bytes);
        let capacity = u64::from(rounds.capacity);
        let order = storage("repair order", u64::from(rounds.count) * capacity * 4)?;
        let counts = storage("repair counts", u64::from(rounds.count) * COUNT_BYTES)?;
        let errors = storage("repair errors", rows.block_bytes() * capacity)?;
        let minima = storage("repair group minima", u64::from(rows.groups) * capacity * 4)?;
        let bound = [(&guide.image).into(), carried.into(), (&quilt.blocks).into(), (&order).into(), (&counts).into()];
        let fit_set = BindingSet::new(context, &stages.fit, &bound)?;
        let targets = Targets {
            stages: &quilt.stages,
            sample,
            canvas: quilt.canvas(),
            source: quilt.source(),
            blocks: &quilt.blocks,
            order: &order,
            errors: &errors,
            minima: &minima,
        };
        let matching = targets.matching(context, None)?;
        let place = targets.place(context, 1, None)?;
        let params = *params;
        Ok(Repair { stages: stages.clone(), params, guide, rounds, row_step, counts, fit_set, matching, place })
    }

    /// Records the repair of `quilt`, that which this was made for. Its [`Quilt::source`] then holds where in the
    /// sample each pixel that was synthesised anew came from, and [`NOT_PASTED`] elsewhere. `seed` and `frame` enter
    /// the random choices.
    pub fn record(&self, recorder: &mut Recorder<'_>, quilt: &Quilt, seed: u32, frame: u32) {
        let QuiltParams { block_px, overlap_px, .. } = quilt.params;
        let Layout { columns, rows, .. } = quilt.layout;
        let sample = quilt.sample_size;
        let push = FitPush {
            sample_width: sample.0,
            block_px,
            overlap_px,
            columns,
            rows,
            paint: self.guide.paint,
            // More than a sample is wide makes no difference, and stays clear of overflow.
            window_px: self.guide.window_px.min(sample.0),
            slack: self.params.slack_px(block_px).min(sample.0),
            capacity: self.rounds.capacity,
            band_rows: self.rounds.band_rows,
        };
        // Every row has its turn.
        let rows = Rows::new(&quilt.params, sample.1, quilt.columns, frame % self.row_step, self.row_step);
        let counts = [rows.groups, 0, 1, 0, 1, 1].repeat(self.rounds.count as usize);
        recorder.fill_images("repair_clear", &[quilt.source()], NOT_PASTED);
        recorder.update_buffer("repair_clear", &self.counts, bytemuck::cast_slice(&counts));
        recorder.dispatch(&self.stages.fit, &self.fit_set, &push, quilt.groups_by_block());
        for round in 0..self.rounds.count {
            let (first, offset) = (round * self.rounds.capacity, u64::from(round) * COUNT_BYTES);
            let push = quilt.match_push(first, rows, [1, 0]);
            let groups = (&self.counts, offset);
            recorder.dispatch_indirect(&self.matching.pipeline, &self.matching.set, &push, groups);
            let push = quilt.place_push(first, rows, self.params.tolerance, seed, frame);
            let groups = (&self.counts, offset + COUNT_BYTES / 2);
            recorder.dispatch_indirect(&self.place.pipeline, &self.place.set, &push, groups);
        }
    }
}

/// How blocks are put into rounds: those of even rows and columns of the grid, those of even rows and odd columns, and
/// so on; and by bands of rows, where these would be too many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rounds {
    /// Rows of a band; even.
    pub band_rows: u32,
    /// Blocks of a round, at most.
    pub capacity: u32,
    pub count: u32,
}

impl Rounds {
    /// Rounds of at most about `most` blocks.
    fn new(layout: &Layout, most: u32) -> Self {
        let across = layout.columns.div_ceil(2);
        let pairs = (most / across).clamp(1, layout.rows.div_ceil(2));
        let count = 4 * layout.rows.div_ceil(2 * pairs);
        Rounds { band_rows: 2 * pairs, capacity: across * pairs, count }
    }
}
