//! Image quilting on the GPU, free or guided: prepared once for a sample, an output size and parameters, then recorded
//! as often as wanted.
//!
//! Three stages, named as their shaders: `quilt_guide` says which blocks are placed and where each is searched for;
//! then, wave by wave, `quilt_search` compares the overlap of each block with every allowed position of the sample, and
//! `quilt_place` chooses one, cuts it into its neighbours and pastes it. The blocks of a wave share no pixel, so that
//! the result is that of placing them one by one (thesis 3.2.2; Efros and Freeman 2001; the oracle is
//! [`super::quilt_oracle`]).
//!
//! Technique and command line give the sample and, for guided synthesis, the guide image; they get a canvas (8-bit
//! texels) and, for each pixel, where in the sample it came from.

use super::params::{BlockRecord, Layout, QuiltParams};
use super::prune::Prune;
use super::quilt_stages::{
    BlockData, GuidePush, MatchPush, PlacePush, Rows, SearchPush, Stage, Targets, GROUP, QUILT_GUIDE, STATE_PLACED,
    TILE,
};
use crate::gpu::{Buffer, BufferKind, Context, Image, ImageDesc, Recorder, Runner, Uploads};
use crate::{Error, Result};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;

pub use super::quilt_stages::QuiltStages;
pub use super::sample::SampleTexels;
pub use super::search_path::{Pruning, SearchPath};

/// Blocks in a row of `quilt_guide`'s workgroups; every device allows more.
const GUIDE_GROUPS_X: u32 = 32_768;
/// Memory for the errors of one dispatch; longer waves are cut.
pub(super) const ERRORS_BYTES: u64 = 64 << 20;
/// What placing a block costs, measured in pixel comparisons of the search on lavapipe (0.13 ms at 2 G/s).
const PLACE_COMPARISONS: u64 = 250_000;
/// A pruned search costs about so many times less.
const PRUNED_SHARE: u64 = 4;
/// Pixel comparisons after which a step of the search is cut, so that a submission can be kept short.
const STEP_COMPARISONS: u64 = 200_000_000;

/// How blocks match the picture that was synthesised before (thesis chapter 6).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreviousWeight(
    /// How much a pixel of that picture counts against one of the overlap: 0.25 to 3 in steps of 0.25, less for blocks
    /// over 37 px.
    pub f32,
);

/// What a pixel of the overlap counts where a picture before does too, so that it may count less.
const OVERLAP_WEIGHT: u32 = 4;
/// So many weighted squared differences of colours fit into 32 bits.
const MOST_WEIGHTED_PX: u32 = u32::MAX / (3 * 255 * 255);

impl PreviousWeight {
    /// Checks that blocks of this size can be matched with it.
    ///
    /// # Errors
    /// [`Error::Parameter`] when it is out of range.
    pub fn check(self, block_px: u32) -> Result<()> {
        self.units(block_px).map(drop)
    }

    /// The weight against [`OVERLAP_WEIGHT`].
    fn units(self, block_px: u32) -> Result<u32> {
        let most = (MOST_WEIGHTED_PX / (block_px * block_px).max(1)).saturating_sub(OVERLAP_WEIGHT).min(12);
        let units = f64::from(self.0) * f64::from(OVERLAP_WEIGHT);
        if units.fract() != 0.0 || units < 1.0 || units > f64::from(most) {
            let allowed = format!("0.25 to {} in steps of 0.25 for blocks of {block_px} px", f64::from(most) / 4.0);
            return Err(Error::parameter("weight of the previous frame", self.0, allowed));
        }
        Ok(units as u32)
    }
}

/// What guides a synthesis (thesis chapter 6).
#[derive(Clone)]
pub struct QuiltGuide {
    /// R32_UINT, a texel a pixel: shade (0 to 255) in the low byte, the paint's number (from 1; 0 is background) in the
    /// high half.
    pub image: Image,
    /// The number of the paint to synthesise; pixels of other paints count as background.
    pub paint: u32,
    /// How far, in columns, a block's position may lie from x0 = L * W_sample: k times the block size.
    pub window_px: u32,
    /// Whether, and how much, each block is also to match the picture that this quilting made before, which keeps a
    /// sequence calm; [`Quilt::forget`] begins anew.
    pub previous: Option<PreviousWeight>,
}

impl QuiltGuide {
    /// A guide that is made on the host: `texels` of an output of `size` = (width, height) pixels, as
    /// [`QuiltGuide::image`] has them, for paint number 1 and without a picture before.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there are not as many texels as pixels; [`Error::Memory`] when the budget does not
    /// allow it.
    pub fn from_texels(
        context: &Context,
        uploads: &mut Uploads,
        texels: &[u32],
        size: (u32, u32),
        window_px: u32,
    ) -> Result<Self> {
        let desc = ImageDesc::storage_2d(size.0, size.1, vk::Format::R32_UINT);
        let image = Image::new(context, "guide", &desc)?;
        uploads.image(context, &image, bytemuck::cast_slice(texels))?;
        Ok(QuiltGuide { image, paint: 1, window_px, previous: None })
    }
}

#[derive(Debug, Clone)]
enum Step {
    /// Search for blocks `order[blocks]`, groups of positions `groups`.
    Search { blocks: Range<u32>, groups: Range<u32> },
    /// Place the same blocks.
    Place { blocks: Range<u32> },
}

/// What a search compares a block with.
enum Search {
    /// What is painted in its overlaps.
    Overlap(Stage),
    /// The same, without positions that cannot be chosen.
    Pruned(Box<Prune>),
    /// What is painted in its overlaps, and another picture; how much a pixel of either counts.
    Weighted { stage: Stage, weights: [u32; 2] },
}

/// Waves of blocks, and what places them in this order.
struct Waves {
    search: Search,
    place: Stage,
    /// With their cost in pixel comparisons.
    steps: Vec<(Step, u64)>,
}

/// One quilting, ready to be recorded.
pub struct Quilt {
    pub(super) stages: Arc<QuiltStages>,
    pub(super) params: QuiltParams,
    pub(super) layout: Layout,
    pub(super) sample_size: (u32, u32),
    pub(super) guide: Option<QuiltGuide>,
    canvas: Image,
    source: Image,
    /// The canvas of the synthesis before, if blocks are to match it.
    previous: Option<Image>,
    pub(super) blocks: Buffer,
    find: Stage,
    waves: Waves,
    /// Columns of positions that a block is searched at, at most.
    pub(super) columns: u32,
    groups_per_block: u32,
}

impl Quilt {
    /// Prepares to quilt `output` = (width, height) pixels from `sample`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range (see [`QuiltParams::validate`] and [`PreviousWeight`]), a guide
    /// that is not of the output's size and a guide's paint that is not 1 to 65535; [`Error::Memory`] when the budget
    /// does not allow it.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        sample: &SampleTexels,
        output: (u32, u32),
        params: &QuiltParams,
        guide: Option<QuiltGuide>,
    ) -> Result<Self> {
        params.validate(sample.size(), output)?;
        if let Some(guide) = &guide {
            if !(1..=0xffff).contains(&guide.paint) {
                return Err(Error::parameter("paint of the guide", guide.paint, "1 to 65535"));
            }
            if guide.image.size_px() != [output.0, output.1, 1] {
                let size = guide.image.size_px();
                let allowed = format!("that of the output, {}x{}", output.0, output.1);
                return Err(Error::parameter("guide size", format!("{}x{}", size[0], size[1]), allowed));
            }
        }
        let previous = guide.as_ref().and_then(|guide| guide.previous);
        let previous_weight = previous.map(|weight| weight.units(params.block_px)).transpose()?;
        let layout = Layout::new(params, output)?;
        let all_columns = sample.size().0 - params.block_px + 1;
        let columns = match &guide {
            Some(guide) => all_columns.min(guide.window_px.saturating_mul(2).saturating_add(1)),
            None => all_columns,
        };
        let rows = Rows::new(params, sample.size().1, columns, 0, 1);
        let blocks = layout.placements.len() as u64;
        let positions_down = u64::from(sample.size().1 - params.block_px + 1);
        let (groups_per_block, block_bytes) = (rows.groups, rows.block_bytes());
        let longest = layout.waves.iter().map(Vec::len).max().unwrap_or(1) as u64;
        let windowed = guide.is_some();
        let pruned = previous_weight.is_none()
            && Prune::possible(context, params, sample.size())
            && stages.path().prunes(blocks, overlap_px(params) * u64::from(columns) * positions_down);
        let most = if pruned { Prune::most_blocks(context, groups_per_block) } else { u32::MAX };
        let batch = (ERRORS_BYTES / block_bytes).min(u64::from(most)).clamp(1, longest) as u32;

        let data: Vec<BlockData> = layout
            .placements
            .iter()
            .map(|p| BlockData { x: p.x, y: p.y, width: p.width, height: p.height, ..bytemuck::Zeroable::zeroed() })
            .collect();
        let desc = ImageDesc::storage_2d(output.0, output.1, vk::Format::R32_UINT);
        // A technique may draw what stays of the last frame to it.
        let drawn = ImageDesc::drawn(output.0, output.1, vk::Format::R32_UINT);
        let canvas = Image::new(context, "quilt canvas", &ImageDesc { usage: drawn.usage | desc.usage, ..desc })?;
        let source = Image::new(context, "quilt source", &desc)?;
        let picture = |_| Image::new(context, "quilt previous", &desc);
        let previous = previous_weight.map(picture).transpose()?;
        if previous.is_some() {
            // The first synthesis matches nothing, even if nobody has said so.
            uploads.image(context, &canvas, &vec![0; 4 * canvas.texels() as usize])?;
        }
        let storage = |name, bytes| Buffer::new(context, name, BufferKind::Storage, bytes);
        let blocks = storage("quilt blocks", size_of_val(&data[..]) as u64)?;
        let errors = storage("quilt errors", block_bytes * u64::from(batch))?;
        let minima_per_block = u64::from(groups_per_block * stages.path().parts + 1);
        let minima = storage("quilt group minima", minima_per_block * u64::from(batch) * 4)?;
        uploads.buffer(context, &blocks, bytemuck::cast_slice(&data))?;
        let guide_image = guide.as_ref().map_or(sample.image(), |guide| &guide.image);
        let found = [guide_image.into(), (&blocks).into()];
        let find = Stage::new(context, stages.pipeline(&QUILT_GUIDE, &[])?, &found)?;
        let most_groups = context.caps().max_group_count_x / stages.path().parts;
        let order_list: Vec<u32> = layout.waves.iter().flatten().copied().collect();
        let order = storage("quilt order", size_of_val(&order_list[..]) as u64)?;
        uploads.buffer(context, &order, bytemuck::cast_slice(&order_list))?;
        let targets = Targets {
            stages,
            sample,
            canvas: &canvas,
            source: &source,
            blocks: &blocks,
            order: &order,
            errors: &errors,
            minima: &minima,
        };
        let search = match (&previous, previous_weight) {
            (Some(previous), Some(weight)) => {
                let stage = targets.matching(context, Some(previous))?;
                Search::Weighted { stage, weights: [OVERLAP_WEIGHT, weight] }
            }
            _ if pruned => {
                let size = (batch, groups_per_block);
                Search::Pruned(Box::new(Prune::new(context, uploads, &targets, params, &layout, size, windowed)?))
            }
            _ => Search::Overlap(targets.search(context, params)?),
        };
        let place = match &search {
            Search::Overlap(_) => targets.place(context, stages.path().parts, None)?,
            Search::Pruned(prune) => targets.place(context, 1, Some(prune.tile_bounds()))?,
            Search::Weighted { .. } => targets.place(context, 1, None)?,
        };
        let waves = Waves {
            search,
            place,
            steps: if pruned {
                let cost = group_comparisons(params) / PRUNED_SHARE;
                steps(&layout.waves, (groups_per_block, cost), batch, None)
            } else {
                steps(&layout.waves, (groups_per_block, group_comparisons(params)), batch, Some(most_groups))
            },
        };
        Ok(Quilt {
            stages: stages.clone(),
            params: *params,
            layout,
            sample_size: sample.size(),
            guide,
            canvas,
            source,
            previous,
            blocks,
            find,
            waves,
            columns,
            groups_per_block,
        })
    }

    /// The synthesised texels: R32_UINT, red in the low byte, 255 in the high byte where painted, all 0 elsewhere.
    pub fn canvas(&self) -> &Image {
        &self.canvas
    }

    /// Where in the sample each painted pixel came from: R32_UINT, x + (y << 16).
    pub fn source(&self) -> &Image {
        &self.source
    }

    /// The canvas of the synthesis before this one, where blocks match it.
    pub(crate) fn previous(&self) -> Option<&Image> {
        self.previous.as_ref()
    }

    /// What guides it.
    pub(crate) fn guide(&self) -> Option<&Image> {
        self.guide.as_ref().map(|guide| &guide.image)
    }

    /// Which tiles of eight positions were compared for the last step that was recorded, if the search is pruned:
    /// R32_UINT, 2^32 - 1 for those that were not, 1,024 tiles to a row, whole rows for each block of the step.
    pub fn tile_bounds(&self) -> Option<&Image> {
        self.pruned().map(Prune::tile_bounds)
    }

    /// How many coordinates a position of the sample has, by which its error is bounded, if the search is pruned.
    pub fn coordinates(&self) -> Option<u32> {
        self.pruned().map(Prune::coordinates)
    }

    fn pruned(&self) -> Option<&Prune> {
        match &self.waves.search {
            Search::Pruned(prune) => Some(prune),
            _ => None,
        }
    }

    /// The grid of blocks.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Pixel comparisons of the whole search, an upper bound where a guide skips blocks; of a pruned one a rough estimate
    /// of what it costs.
    pub fn comparisons(&self) -> u64 {
        self.waves.steps.iter().filter(|(step, _)| matches!(step, Step::Search { .. })).map(|(_, cost)| cost).sum()
    }

    /// Cuts the steps into parts of at most about `comparisons` pixel comparisons, to be submitted one by one.
    pub fn parts(&self, comparisons: u64) -> Vec<Range<usize>> {
        let mut parts = Vec::new();
        let (mut begin, mut sum) = (0, 0);
        for (i, (_, cost)) in self.waves.steps.iter().enumerate() {
            if sum + cost > comparisons && i > begin {
                parts.push(begin..i);
                (begin, sum) = (i, 0);
            }
            sum += cost;
        }
        parts.push(begin..self.waves.steps.len());
        parts
    }

    /// Records the whole synthesis. `seed` and `frame` enter the random choices: one prepared quilting serves any
    /// number of seeds, and frames of one seed differ. The oracle is this with [`QuiltParams::seed`] and frame 0.
    pub fn record(&self, recorder: &mut Recorder<'_>, seed: u32, frame: u32) {
        self.record_part(recorder, 0..self.waves.steps.len(), seed, frame);
    }

    /// Records some of the steps, as [`Quilt::parts`] gives them; the parts of one synthesis must be recorded in order.
    /// Steps that there are not record nothing.
    pub fn record_part(&self, recorder: &mut Recorder<'_>, part: Range<usize>, seed: u32, frame: u32) {
        if part.start == 0 {
            self.record_begin(recorder);
        }
        self.record_waves(recorder, part, seed, frame);
    }

    /// Records that the next synthesis matches no picture before it.
    pub fn forget(&self, recorder: &mut Recorder<'_>) {
        recorder.clear_images("quilt_clear", &[&self.canvas]);
    }

    /// Clears the canvas, and finds what there is to place.
    fn record_begin(&self, recorder: &mut Recorder<'_>) {
        if let Some(previous) = &self.previous {
            recorder.copy_image("quilt_previous", &self.canvas, previous);
        }
        recorder.clear_images("quilt_clear", &[&self.canvas, &self.source]);
        if let Some(prune) = self.pruned() {
            prune.record_begin(recorder);
        }
        let push = GuidePush {
            output: [self.layout.output.0, self.layout.output.1],
            sample_width: self.sample_size.0,
            block_px: self.params.block_px,
            guided: u32::from(self.guide.is_some()),
            paint: self.guide.as_ref().map_or(0, |guide| guide.paint),
            // More than a sample is wide makes no difference, and stays clear of overflow.
            window_px: self.guide.as_ref().map_or(0, |guide| guide.window_px.min(self.sample_size.0)),
        };
        recorder.dispatch(&self.find.pipeline, &self.find.set, &push, self.groups_by_block());
    }

    /// Workgroups for a stage that has one for each block.
    pub(super) fn groups_by_block(&self) -> [u32; 3] {
        let blocks = self.layout.placements.len() as u32;
        [blocks.min(GUIDE_GROUPS_X), blocks.div_ceil(GUIDE_GROUPS_X), 1]
    }

    /// What `quilt_match` is to do with `order[first_block..]`.
    pub(super) fn match_push(&self, first_block: u32, rows: Rows, weights: [u32; 2]) -> MatchPush {
        let QuiltParams { block_px, overlap_px, tileable, .. } = self.params;
        MatchPush {
            output: [self.layout.output.0, self.layout.output.1],
            sample_height: self.sample_size.1,
            block_px,
            overlap_px,
            tileable: u32::from(tileable),
            columns: self.layout.columns,
            rows: self.layout.rows,
            first_block,
            first_group: 0,
            groups_per_block: rows.groups,
            canvas_weight: weights[0],
            previous_weight: weights[1],
            first_row: rows.first,
            row_step: rows.step,
        }
    }

    /// What `quilt_place` is to do with `order[first_block..]`.
    pub(super) fn place_push(&self, first_block: u32, rows: Rows, tolerance: f32, seed: u32, frame: u32) -> PlacePush {
        let QuiltParams { block_px, overlap_px, tileable, .. } = self.params;
        PlacePush {
            output: [self.layout.output.0, self.layout.output.1],
            sample_height: self.sample_size.1,
            block_px,
            overlap_px,
            tileable: u32::from(tileable),
            first_block,
            groups_per_block: rows.groups,
            columns: self.layout.columns,
            rows: self.layout.rows,
            tolerance: QuiltParams { tolerance, ..self.params }.tolerance_e4(),
            seed,
            frame,
            first_row: rows.first,
            row_step: rows.step,
            bound_rows: 0,
        }
    }

    fn record_waves(&self, recorder: &mut Recorder<'_>, part: Range<usize>, seed: u32, frame: u32) {
        let rows = Rows { first: 0, step: 1, groups: self.groups_per_block };
        for (step, _) in self.waves.steps.get(part).unwrap_or_default() {
            match step.clone() {
                Step::Search { blocks, groups } => self.record_search(recorder, rows, blocks, groups),
                Step::Place { blocks } => {
                    let mut push = self.place_push(blocks.start, rows, self.params.tolerance, seed, frame);
                    let count = [blocks.len() as u32, 1, 1];
                    if let Some(prune) = self.pruned() {
                        push.bound_rows = prune.bound_rows();
                    }
                    recorder.dispatch(&self.waves.place.pipeline, &self.waves.place.set, &push, count);
                }
            }
        }
    }

    fn record_search(&self, recorder: &mut Recorder<'_>, rows: Rows, blocks: Range<u32>, groups: Range<u32>) {
        let params = &self.params;
        let count = [groups.len() as u32, blocks.len() as u32, 1];
        let push = SearchPush {
            output: [self.layout.output.0, self.layout.output.1],
            sample_height: self.sample_size.1,
            block_px: params.block_px,
            overlap_px: params.overlap_px,
            tileable: u32::from(params.tileable),
            columns: self.layout.columns,
            rows: self.layout.rows,
            first_block: blocks.start,
            first_group: groups.start,
            groups_per_block: self.groups_per_block,
            tolerance: params.tolerance_e4(),
            bound_rows: 0,
            first_least: 0,
        };
        match &self.waves.search {
            Search::Overlap(stage) => {
                let count = [count[0] * self.stages.path().parts, count[1], 1];
                recorder.dispatch(&stage.pipeline, &stage.set, &push, count);
            }
            Search::Pruned(prune) => prune.record(recorder, &push, self.columns, blocks.len() as u32),
            Search::Weighted { stage, weights } => {
                let push = MatchPush { first_group: groups.start, ..self.match_push(blocks.start, rows, *weights) };
                recorder.dispatch(&stage.pipeline, &stage.set, &push, count);
            }
        }
    }

    /// Reads back what was chosen, in placing order; skipped blocks are left out.
    ///
    /// # Errors
    /// Those of [`Runner::read_buffer`].
    pub fn read_records(&self, runner: &mut Runner) -> Result<Vec<BlockRecord>> {
        let bytes = runner.read_buffer(&self.blocks)?;
        let blocks: Vec<BlockData> = bytemuck::pod_collect_to_vec(&bytes);
        let last_row = self.sample_size.1 - self.params.block_px;
        let placed = self.layout.order.iter().filter_map(|&index| {
            let block = blocks.get(index as usize).filter(|block| block.state == STATE_PLACED)?;
            Some(BlockRecord {
                row: index / self.layout.columns,
                col: index % self.layout.columns,
                x: block.x,
                y: block.y,
                sx: block.sx,
                sy: block.sy,
                error: block.error,
                min_error: block.min_error,
                allowed: [block.sx0, 0, block.sx1, last_row],
            })
        });
        Ok(placed.collect())
    }
}

/// Pixels of the overlaps of a block that has neighbours to the left and above.
fn overlap_px(params: &QuiltParams) -> u64 {
    let (b, o) = (u64::from(params.block_px), u64::from(params.overlap_px));
    2 * b * o - o * o
}

/// Pixel comparisons of a group of positions.
fn group_comparisons(params: &QuiltParams) -> u64 {
    let (b, o) = (u64::from(params.block_px), u64::from(params.overlap_px));
    let pixels = if params.tileable { b * b - (b - 2 * o) * (b - 2 * o) } else { overlap_px(params) };
    u64::from(GROUP * TILE) * pixels
}

/// The steps of waves with their cost in pixel comparisons. A search of all groups for `batch` blocks is one step,
/// unless it can be cut: then a step has at most `most_groups`.
fn steps(
    waves: &[Vec<u32>],
    (groups, group_cost): (u32, u64),
    batch: u32,
    most_groups: Option<u32>,
) -> Vec<(Step, u64)> {
    let mut steps = Vec::new();
    let mut first = 0;
    for wave in waves {
        let end = first + wave.len() as u32;
        while first < end {
            let blocks = first..end.min(first + batch);
            let cost = group_cost * blocks.len() as u64;
            let enough = |most: u32| (STEP_COMPARISONS / cost).clamp(1, u64::from(most)) as u32;
            let most = most_groups.map_or(groups, enough);
            let mut group = 0;
            while group < groups {
                let range = group..groups.min(group + most);
                group = range.end;
                let cost = cost * range.len() as u64;
                steps.push((Step::Search { blocks: blocks.clone(), groups: range }, cost));
            }
            first = blocks.end;
            let cost = PLACE_COMPARISONS * blocks.len() as u64;
            steps.push((Step::Place { blocks }, cost));
        }
    }
    steps
}
