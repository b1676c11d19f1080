//! Pruning of a search: positions that cannot be chosen are left out before they are compared.
//!
//! Four stages for the blocks of a wave take the place of `quilt_search`. `quilt_aim` compares a few likely positions,
//! which bounds the least error, and so the error of any admissible position, from above. `quilt_template` projects what
//! is painted in a block's overlaps, and `quilt_bound` compares that with the projections of the sample's strips
//! ([`super::strips`]), which bounds each position's error from below. `quilt_compare` compares what is left. All
//! admissible positions are among it, so that `quilt_place` makes the same choice among them as it would among all.

use super::params::{Layout, QuiltParams};
use super::quilt_stages::{chunk, SearchPush, Targets, GROUP};
use super::strips::{StripBasis, StripShape};
use crate::gpu::{
    Access, BindingKind, BindingSet, Bound, Buffer, BufferKind, ComputePipeline, Context, Image, ImageDesc, Recorder,
    Shader, Uploads,
};
use crate::Result;
use ash::vk;

pub(crate) const QUILT_AIM: Shader = Shader {
    name: "quilt_aim",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_aim.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeWrite),
    ],
    push_bytes: size_of::<SearchPush>() as u32,
};

pub(crate) const QUILT_TEMPLATE: Shader = Shader {
    name: "quilt_template",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_template.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
    ],
    push_bytes: size_of::<TemplatePush>() as u32,
};

pub(crate) const QUILT_BOUND: Shader = Shader {
    name: "quilt_bound",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_bound.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeReadWrite),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
    ],
    push_bytes: size_of::<BoundPush>() as u32,
};

pub(crate) const QUILT_COMPARE: Shader = Shader {
    name: "quilt_compare",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_compare.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeReadWrite),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeReadWrite),
    ],
    push_bytes: size_of::<SearchPush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct TemplatePush {
    pub output: [u32; 2],
    pub block_px: u32,
    pub overlap_px: u32,
    pub tileable: u32,
    pub columns: u32,
    pub rows: u32,
    pub first_block: u32,
    pub vertical_px: u32,
    pub horizontal_px: u32,
    pub centre_r: f32,
    pub centre_g: f32,
    pub centre_b: f32,
    pub left_margin: f32,
    pub top_margin: f32,
    pub left_step: f32,
    pub top_step: f32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct BoundPush {
    pub position_columns: u32,
    pub position_rows: u32,
    pub first_slot: u32,
    pub bound_rows: u32,
    pub tolerance: u32,
    pub first_least: u32,
}

/// Strips of a block, as in prune.glsl.
const STRIPS: u32 = 2;
/// Directions that strips are projected to; a strip's coordinates are those, and two more.
const DIRECTIONS: u32 = 29;
/// Layers of four coordinates.
const LAYERS: u32 = (DIRECTIONS + 3) / 4;
/// Words in a row of the tiles' bounds, as in tile_bounds.glsl.
const BOUND_WORDS: u32 = 1024;
/// Groups of positions that a workgroup of `quilt_compare` takes, as there.
const SPAN: u32 = 16;
/// Blocks that an invocation of `quilt_bound` takes, where all are searched for everywhere; and for how many of them
/// there are pipelines.
const BLOCKS: u32 = 8;
const BLOCK_COUNTS: [u32; 3] = [2, 4, 8];
/// Rows of positions that an invocation takes, where blocks have windows of their own.
const WINDOWED_ROWS: u32 = 4;
/// Positions of `quilt_bound`'s workgroups: across, and rows of invocations.
const BOUND_GROUP: [u32; 2] = [8, 16];
/// More bytes of coordinates are not made.
const MOST_BYTES: u64 = 256 << 20;

/// The compiled stages of a pruned search.
pub(super) struct PruneStages {
    aim: [ComputePipeline; 3],
    template: ComputePipeline,
    bound: [ComputePipeline; 3],
    bound_windowed: ComputePipeline,
    compare: [ComputePipeline; 3],
}

impl PruneStages {
    pub fn new(context: &Context) -> Result<Self> {
        let by_chunk = |shader: &Shader| {
            let pipeline = |chunk| ComputePipeline::specialized(context, shader, &[chunk]);
            Ok::<_, crate::Error>([pipeline(4)?, pipeline(5)?, pipeline(6)?])
        };
        let bound = |blocks, rows, windowed| {
            ComputePipeline::specialized(context, &QUILT_BOUND, &[LAYERS, blocks, rows, windowed])
        };
        let [a, b, c] = BLOCK_COUNTS;
        Ok(PruneStages {
            aim: by_chunk(&QUILT_AIM)?,
            template: ComputePipeline::specialized(context, &QUILT_TEMPLATE, &[LAYERS])?,
            bound: [bound(a, 2, 0)?, bound(b, 2, 0)?, bound(c, 2, 0)?],
            bound_windowed: bound(1, WINDOWED_ROWS, 1)?,
            compare: by_chunk(&QUILT_COMPARE)?,
        })
    }
}

/// What is projected: the shapes of a block's left and top strips.
fn shapes(params: &QuiltParams, layout: &Layout) -> [StripShape; 2] {
    // All blocks but those that the output cuts off, or the smallest of a ring.
    let (width, height) = if params.tileable {
        let least = |side: fn(&super::params::Placement) -> u32| layout.placements.iter().map(side).min();
        (least(|p| p.width), least(|p| p.height))
    } else {
        (None, None)
    };
    let (width, height) = (width.unwrap_or(params.block_px), height.unwrap_or(params.block_px));
    let overlap = params.overlap_px;
    [StripShape { width: overlap, height }, StripShape { width: width - overlap, height: overlap }]
}

/// Pruning of one quilting's search.
pub(super) struct Prune {
    shapes: [StripShape; 2],
    bases: [StripBasis; 2],
    /// What the coordinates are in.
    steps: [f32; 2],
    /// Columns and rows of positions.
    positions: [u32; 2],
    windowed: bool,
    bound_rows: u32,
    first_least: u32,
    aim_set: BindingSet,
    template_set: BindingSet,
    bound_set: BindingSet,
    compare_set: BindingSet,
    tile_bounds: Image,
}

impl Prune {
    /// Whether a search for so many blocks with so many groups of positions each can be pruned on this device.
    pub fn possible(context: &Context, params: &QuiltParams, sample: (u32, u32)) -> bool {
        let [columns, rows] = positions(params, sample);
                let texels = u64::from(columns) * u64::from(rows) * u64::from(LAYERS / 2);
        let side = context.caps().max_image_2d_px;
        columns.max(BOUND_WORDS) <= side && rows * LAYERS / 2 <= side && texels * 16 * u64::from(STRIPS) <= MOST_BYTES
    }

    /// Blocks that may be searched for at once.
    pub fn most_blocks(context: &Context, groups_per_block: u32) -> u32 {
        let side = context.caps().max_image_2d_px;
        (side / bound_rows(groups_per_block)).min(side / BLOCKS * BLOCKS)
    }

    /// Prepares pruning for dispatches of up to `batch` blocks, which have windows of their own or are searched for
    /// everywhere.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        targets: &Targets<'_>,
        params: &QuiltParams,
        layout: &Layout,
        (batch, groups_per_block): (u32, u32),
        windowed: bool,
    ) -> Result<Self> {
        let sample = targets.sample;
        let shapes = shapes(params, layout);
        let [columns, rows] = positions(params, sample.size());
        let basis = |shape| StripBasis::new(sample.texels(), sample.size(), shape, DIRECTIONS as usize);
        let bases = [basis(shapes[0]), basis(shapes[1])];
        let mut picture = |name, size: (u32, u32), format, data: &[u8]| {
            let image = Image::new(context, name, &ImageDesc::storage_2d(size.0, size.1, format))?;
            uploads.image(context, &image, data)?;
            Ok::<_, crate::Error>(image)
        };
        let mut strips = |name, basis: &StripBasis, first| {
            let packed = basis.packed(sample.texels(), sample.size(), first, (columns, rows));
            let size = (columns, rows * LAYERS / 2);
            Ok::<_, crate::Error>((picture(name, size, vk::Format::R32G32B32A32_UINT, bytemuck::cast_slice(&packed.texels))?, packed.step))
        };
        let (left, left_step) = strips("quilt left strips", &bases[0], (0, 0))?;
        let (top, top_step) = strips("quilt top strips", &bases[1], (params.overlap_px, 0))?;
        let (size, texels) = directions(&bases);
        let format = vk::Format::R32G32B32A32_SFLOAT;
        let directions = picture("quilt directions", size, format, bytemuck::cast_slice(&texels))?;

        let bound_rows = bound_rows(groups_per_block);
        let desc = ImageDesc::storage_2d(BOUND_WORDS, bound_rows * batch, vk::Format::R32_UINT);
        let tile_bounds = Image::new(context, "quilt tile_bounds", &desc)?;
        // A column each, and room for those that a chunk lacks.
        let columns_of = batch.next_multiple_of(BLOCKS);
        let desc = ImageDesc::storage_2d(columns_of, STRIPS * LAYERS + 1, vk::Format::R32G32B32A32_SFLOAT);
        let templates = Image::new(context, "quilt templates", &desc)?;

        let at = chunk(params);
        let stages = &targets.stages.prune;
        let picked: [Bound; 2] = [targets.blocks.into(), targets.order.into()];
        let compared = [sample.image().into(), sample.squares().into(), targets.canvas.into(), (&tile_bounds).into()];
        let aimed = [&compared[..], &picked, &[targets.minima.into()]].concat();
        let errors = [targets.errors.into(), targets.minima.into()];
        let projected = [targets.canvas.into(), (&directions).into(), (&templates).into()];
        let projected = [&projected[..], &picked].concat();
        let bounded: [Bound; 5] =
            [(&left).into(), (&top).into(), (&tile_bounds).into(), (&templates).into(), targets.minima.into()];
        Ok(Prune {
            positions: [columns, rows],
            windowed,
            bound_rows,
            first_least: batch * groups_per_block,
            aim_set: BindingSet::new(context, &stages.aim[at], &aimed)?,
            template_set: BindingSet::new(context, &stages.template, &projected)?,
            bound_set: BindingSet::new(context, &stages.bound_windowed, &bounded)?,
            compare_set: BindingSet::new(context, &stages.compare[at], &[&compared[..], &picked, &errors].concat())?,
            tile_bounds,
            shapes,
            bases,
            steps: [left_step, top_step],
        })
    }

    /// Rows of [`Prune::tile_bounds`] that a block has.
    pub fn bound_rows(&self) -> u32 {
        self.bound_rows
    }

    /// Which positions are left after [`Prune::record`].
    pub fn tile_bounds(&self) -> &Image {
        &self.tile_bounds
    }

    /// Records the search for `blocks` blocks from `order[push.first_block]` on; `columns` is how many columns of
    /// positions a block is searched at, at most.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        stages: &PruneStages,
        (push, chunk): (&SearchPush, usize),
        columns: u32,
        blocks: u32,
    ) {
        let push = SearchPush { bound_rows: self.bound_rows, first_least: self.first_least, ..*push };
        let [centre_r, centre_g, centre_b] = self.bases[0].centre;
        let template = TemplatePush {
            output: push.output,
            block_px: push.block_px,
            overlap_px: push.overlap_px,
            tileable: push.tileable,
            columns: push.columns,
            rows: push.rows,
            first_block: push.first_block,
            vertical_px: self.shapes[0].height,
            horizontal_px: self.shapes[1].width,
            centre_r,
            centre_g,
            centre_b,
            left_margin: self.bases[0].margin,
            top_margin: self.bases[1].margin,
            left_step: self.steps[0],
            top_step: self.steps[1],
        };
        recorder.dispatch(&stages.aim[chunk], &self.aim_set, &push, [blocks, 1, 1]);
        recorder.dispatch(&stages.template, &self.template_set, &template, [blocks, 1, 1]);
        let [position_columns, position_rows] = self.positions;
        let bound = |first_slot| BoundPush {
            position_columns,
            position_rows,
            first_slot,
            bound_rows: self.bound_rows,
            tolerance: push.tolerance,
            first_least: self.first_least,
        };
        let groups = |rows, blocks| [columns.div_ceil(BOUND_GROUP[0]), position_rows.div_ceil(BOUND_GROUP[1] * rows), blocks];
        if self.windowed {
            let groups = groups(WINDOWED_ROWS, blocks);
            recorder.dispatch(&stages.bound_windowed, &self.bound_set, &bound(0), groups);
        } else {
            for first in (0..blocks).step_by(BLOCKS as usize) {
                let here = (blocks - first).min(BLOCKS);
                let at = BLOCK_COUNTS.iter().position(|&most| here <= most).unwrap_or(BLOCK_COUNTS.len() - 1);
                recorder.dispatch(&stages.bound[at], &self.bound_set, &bound(first), groups(2, 1));
            }
        }
        let groups = [push.groups_per_block.div_ceil(SPAN), blocks, 1];
        recorder.dispatch(&stages.compare[chunk], &self.compare_set, &push, groups);
    }
}

/// Columns and rows of positions at which blocks lie in the sample.
fn positions(params: &QuiltParams, (width, height): (u32, u32)) -> [u32; 2] {
    [width - params.block_px + 1, height - params.block_px + 1]
}

/// Rows of tile_bounds that a block needs.
fn bound_rows(groups_per_block: u32) -> u32 {
    (groups_per_block * GROUP).div_ceil(BOUND_WORDS)
}

/// The directions as `quilt_template` reads them: a row each, a texel for each pixel of the strip.
fn directions(bases: &[StripBasis; 2]) -> ((u32, u32), Vec<[f32; 4]>) {
    let width = bases.iter().map(|basis| basis.shape.width * basis.shape.height).max().unwrap_or(1) as usize;
    let mut texels = vec![[0.0; 4]; width * (STRIPS * DIRECTIONS) as usize];
    let rows = bases.iter().flat_map(|basis| {
        let pixels = (basis.shape.width * basis.shape.height) as usize;
        basis.weights.chunks_exact(3 * pixels)
    });
    for (to, row) in texels.chunks_exact_mut(width).zip(rows) {
        for (to, from) in to.iter_mut().zip(row.chunks_exact(3)) {
            to[..3].copy_from_slice(from);
        }
    }
    ((width as u32, STRIPS * DIRECTIONS), texels)
}
