//! Pruning of a search: positions that cannot be chosen are left out before they are compared.
//!
//! Three stages for the blocks of a wave take the place of `quilt_search`. `quilt_aim` compares a few likely positions,
//! which bounds the least error, and so the error of any admissible position, from above; it also projects what is
//! painted in a block's overlaps. `quilt_bound` compares that with the projections of the sample's strips
//! ([`super::strips`]), which bounds each position's error from below. `quilt_compare` compares what is left. All
//! admissible positions are among it, so that `quilt_place` makes the same choice among them as it would among all.

use super::params::{Layout, Placement, QuiltParams};
use super::quilt_stages::{chunk, SearchPush, Stage, Targets, GROUP};
use super::sample::SampleTexels;
use super::strips::{StripBasis, StripShape};
use crate::gpu::{
    Access, BindingKind, BindingSet, Bound, Buffer, BufferKind, ComputePipeline, Context, Image, ImageDesc, Recorder,
    Shader, Uploads,
};
use crate::Result;
use ash::vk;
use std::sync::Arc;
use std::thread::{self, ScopedJoinHandle};

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
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeWrite),
    ],
    push_bytes: size_of::<AimPush>() as u32,
};

pub(crate) const QUILT_BOUND: Shader = Shader {
    name: "quilt_bound",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_bound.comp.spv"),
    bindings: &[
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
pub(super) struct AimPush {
    pub output: [u32; 2],
    pub sample_height: u32,
    pub block_px: u32,
    pub overlap_px: u32,
    pub tileable: u32,
    pub columns: u32,
    pub rows: u32,
    pub first_block: u32,
    pub strips: u32,
    pub first_least: u32,
    pub centre_r: f32,
    pub centre_g: f32,
    pub centre_b: f32,
}

/// `Strip` of quilt_aim.comp.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct StripData {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
    pub left: u32,
    pub first: u32,
    pub directions: u32,
    pub margin: f32,
    pub step: f32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct BoundPush {
    pub position_columns: u32,
    pub position_rows: u32,
    pub first_slot: u32,
    pub slots: u32,
    pub bound_rows: u32,
    pub tolerance: u32,
    pub first_least: u32,
}

/// What a tile has that has no bound, as in tile_bounds.glsl.
const NO_BOUND: u32 = u32::MAX;
/// Words in a row of the tiles' bounds, as in tile_bounds.glsl.
const BOUND_WORDS: u32 = 1024;
/// Groups of positions that a workgroup of `quilt_compare` takes, as there.
const SPAN: u32 = 16;
/// For how many blocks an invocation of `quilt_bound` can be compiled where all are searched for everywhere, and how
/// many rows of positions it then takes.
const BLOCK_COUNTS: [u32; 2] = [5, 10];
const ROWS: u32 = 2;
/// Rows of positions that an invocation takes where each block has a window of its own.
const WINDOWED_ROWS: u32 = 1;
/// Positions of `quilt_bound`'s workgroups: across, and rows of invocations.
const BOUND_GROUP: [u32; 2] = [8, 16];
/// More bytes of coordinates are not made.
const MOST_BYTES: u64 = 256 << 20;
/// Texels of eight coordinates for the strips on one side of a block: the first that leave out no more than a share of
/// the squared lengths of strips. More coordinates cost more for every position, and leave fewer to be compared; these
/// were found by trying.
const TEXELS: [(u32, f64); 3] = [(2, 0.3), (4, 0.21), (6, 1.0)];
const MOST_TEXELS: u32 = 6;
/// A strip shorter than this is not worth coordinates of its own, pixels.
const SHORTEST_PX: u32 = 3;

/// Directions of a strip that has so many texels of coordinates: three words of 16 bits are taken by the length of what
/// is left out, and by the squared length.
fn directions(texels: u32) -> usize {
    8 * texels as usize - 3
}

/// A part of a block's overlap with its left or its upper neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Strip {
    x: u32,
    y: u32,
    shape: StripShape,
    left: bool,
    /// Whether it is the shorter of two parts; of two halves one is.
    shorter: bool,
}

impl Strip {
    /// How many texels of coordinates it has.
    fn texels(&self, split: bool, all: u32) -> u32 {
        match (split, self.shorter) {
            (true, true) => 1,
            (true, false) => (all - 1).max(2),
            (false, _) => all,
        }
    }
}

/// The strips of blocks. Those that the output cuts off have only the first part of a strip whole, so there is one that
/// ends where the output does, and another for the rest.
fn strips(params: &QuiltParams, layout: &Layout, windowed: bool) -> Vec<Strip> {
    let overlap = params.overlap_px;
    // Side by side: where they begin and end along the side.
    let parts = |from: u32, least: u32| {
        let whole = if params.tileable { least } else { params.block_px };
        let split = !windowed && least >= from + SHORTEST_PX && whole >= least + SHORTEST_PX;
        if split {
            vec![(from, least), (least, whole)]
        } else {
            vec![(from, whole)]
        }
    };
    let least = |side: fn(&Placement) -> u32| layout.placements.iter().map(side).min().unwrap_or(params.block_px);
    let strip = |(begin, end): (u32, u32), left, shorter| {
        let length = end - begin;
        let (width, height) = if left { (overlap, length) } else { (length, overlap) };
        let (x, y) = if left { (0, begin) } else { (begin, 0) };
        Strip { x, y, shape: StripShape { width, height }, left, shorter }
    };
    let side = |from, least, left| {
        let parts: Vec<(u32, u32)> = parts(from, least);
        let length = |part: (u32, u32)| part.1 - part.0;
        // Of two halves the second: coordinates have room for one longer part.
        let shorter = match parts[..] {
            [a, b] => Some(if length(a) < length(b) { a } else { b }),
            _ => None,
        };
        parts.into_iter().map(|part| strip(part, left, shorter == Some(part))).collect::<Vec<_>>()
    };
    [side(0, least(|p| p.height), true), side(overlap, least(|p| p.width), false)].concat()
}

/// The directions of each strip.
fn find_bases(sample: &SampleTexels, strips: &[Strip], windowed: bool) -> Vec<StripBasis> {
    let split = |strip: &Strip| strips.iter().filter(|other| other.left == strip.left).count() > 1;
    let components = |strip: &Strip, texels: u32| directions(strip.texels(split(strip), texels));
    let bases = |texels: u32| -> Vec<StripBasis> {
        on_threads(strips, |strip| {
            StripBasis::new(sample.texels(), sample.size(), strip.shape, components(strip, texels))
        })
    };
    let enough = |bases: &[StripBasis], (texels, most): (u32, f64)| {
        let long = || bases.iter().zip(strips).filter(|(_, strip)| !strip.shorter);
        let left_out: f64 = long().map(|(basis, strip)| basis.left_out(components(strip, texels))).sum();
        left_out <= most * long().count() as f64
    };
    let [few, ref more @ ..] = TEXELS;
    let mut found = bases(few.0);
    if !windowed && !enough(&found, few) {
        found = bases(MOST_TEXELS);
        let texels = more.iter().find(|level| enough(&found, **level)).map_or(MOST_TEXELS, |level| level.0);
        found.iter_mut().zip(strips).for_each(|(basis, strip)| basis.truncate(components(strip, texels)));
    }
    found
}

/// Maps each item on a thread of its own.
fn on_threads<T: Sync, R: Send>(items: &[T], map: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let map = &map;
    thread::scope(|scope| {
        let running: Vec<_> = items.iter().map(|item| scope.spawn(move || map(item))).collect();
        running.into_iter().map(join).collect()
    })
}

fn join<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// Pruning of one quilting's search.
pub(super) struct Prune {
    aim: Stage,
    /// For so many blocks.
    bound: Vec<(u32, Arc<ComputePipeline>)>,
    bound_set: BindingSet,
    compare: Stage,
    tile_bounds: Image,
    strips: u32,
    /// Texels of eight coordinates that a position has.
    texels: u32,
    centre: [f32; 3],
    /// Columns and rows of positions.
    positions: [u32; 2],
    windowed: bool,
    bound_rows: u32,
    first_least: u32,
}

impl Prune {
    /// Whether a search in such a sample can be pruned on this device.
    pub fn possible(context: &Context, params: &QuiltParams, sample: (u32, u32)) -> bool {
        let [columns, rows] = positions(params, sample);
        // Both sides, and two parts of each that need one more.
        let texels = 2 * (MOST_TEXELS + 1);
        let side = context.caps().max_image_2d_px;
        let fits = columns.max(BOUND_WORDS) <= side && rows * texels <= side;
        fits && u64::from(columns) * u64::from(rows) * u64::from(texels) * 16 <= MOST_BYTES
    }

    /// Blocks that may be searched for at once.
    pub fn most_blocks(context: &Context, groups_per_block: u32) -> u32 {
        context.caps().max_image_2d_px / bound_rows(groups_per_block)
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
        let (sample, stages) = (targets.sample, targets.stages);
        let positions = positions(params, sample.size());
        let strips = strips(params, layout, windowed);
        // The host has as much to do as the driver's compiler.
        let bases = thread::scope(|scope| {
            let compiling = scope.spawn(|| stages.compile_pruned(params));
            let bases = find_bases(sample, &strips, windowed);
            join(compiling).map(|()| bases)
        })?;
        let texels = bases.iter().map(|basis| basis.components as u32 + 3).sum::<u32>() / 8;
        let mut data = strip_data(&strips, &bases);
        // A bit for each texel that ends with a squared length.
        let squares = data.iter().fold(0, |bits, strip| bits | 1 << ((strip.first + strip.directions) / 8));
        let bound = |&(blocks, rows): &(u32, u32)| {
            let constants = [texels, blocks, rows, u32::from(windowed), squares];
            stages.pipeline(&QUILT_BOUND, &constants).map(|stage| (blocks, stage))
        };
        let (bound, packed) = thread::scope(|scope| {
            let compiling =
                scope.spawn(|| on_threads(bounds(windowed, batch), bound).into_iter().collect::<Result<Vec<_>>>());
            let pairs: Vec<_> = bases.iter().zip(&strips).collect();
            let packed = on_threads(&pairs, |(basis, strip)| {
                basis.packed(sample.texels(), sample.size(), (strip.x, strip.y), positions.into())
            });
            join(compiling).map(|bound| (bound, packed))
        })?;
        data.iter_mut().zip(&packed).for_each(|(data, packed)| data.step = packed.step);
        let mut picture = |name, size: (u32, u32), format, data: &[u8]| {
            let image = Image::new(context, name, &ImageDesc::storage_2d(size.0, size.1, format))?;
            uploads.image(context, &image, data)?;
            Ok::<_, crate::Error>(image)
        };
        let all: Vec<[u32; 4]> = packed.iter().flat_map(|packed| &packed.texels).copied().collect();
        let size = (positions[0], positions[1] * texels);
        let coordinates =
            picture("quilt coordinates", size, vk::Format::R32G32B32A32_UINT, bytemuck::cast_slice(&all))?;
        let (size, rows) = direction_rows(&bases, texels);
        let floats = vk::Format::R32G32B32A32_SFLOAT;
        let directions = picture("quilt directions", size, floats, bytemuck::cast_slice(&rows))?;
        let strip_buffer = Buffer::new(context, "quilt strips", BufferKind::Storage, size_of_val(&data[..]) as u64)?;
        uploads.buffer(context, &strip_buffer, bytemuck::cast_slice(&data))?;

        let bound_rows = bound_rows(groups_per_block);
        let desc = ImageDesc::storage_2d(BOUND_WORDS, bound_rows * batch, vk::Format::R32_UINT);
        let tile_bounds = Image::new(context, "quilt tile bounds", &desc)?;
        let desc = ImageDesc::storage_2d(batch, 2 * texels + 1, floats);
        let templates = Image::new(context, "quilt templates", &desc)?;

        let aim = stages.pipeline(&QUILT_AIM, &[texels])?;
        let compare = stages.pipeline(&QUILT_COMPARE, &[chunk(params)])?;

        let picked: [Bound; 2] = [targets.blocks.into(), targets.order.into()];
        let compared = [sample.image().into(), sample.squares().into(), targets.canvas.into(), (&tile_bounds).into()];
        let errors = [targets.errors.into(), targets.minima.into()];
        let pictures = [sample.image().into(), targets.canvas.into(), (&directions).into(), (&templates).into()];
        let aimed = [&pictures[..], &picked, &[(&strip_buffer).into(), targets.minima.into()]].concat();
        let bounded = [(&coordinates).into(), (&tile_bounds).into(), (&templates).into(), targets.minima.into()];
        Ok(Prune {
            aim: Stage::new(context, aim, &aimed)?,
            bound_set: BindingSet::new(context, &*bound[0].1, &bounded)?,
            bound,
            compare: Stage::new(context, compare, &[&compared[..], &picked, &errors].concat())?,
            tile_bounds,
            strips: data.len() as u32,
            texels,
            centre: bases.first().map_or([0.0; 3], |basis| basis.centre),
            positions,
            windowed,
            bound_rows,
            first_least: batch * groups_per_block,
        })
    }

    /// How many coordinates a position has.
    pub fn coordinates(&self) -> u32 {
        8 * self.texels
    }

    /// Rows of [`Prune::tile_bounds`] that a block has.
    pub fn bound_rows(&self) -> u32 {
        self.bound_rows
    }

    /// Records that no tile has a bound, as it is before each wave: `quilt_place` clears those of its block.
    pub fn record_begin(&self, recorder: &mut Recorder<'_>) {
        recorder.fill_images("quilt_clear", &[&self.tile_bounds], NO_BOUND);
    }

    /// Which tiles were compared, after [`Prune::record`].
    pub fn tile_bounds(&self) -> &Image {
        &self.tile_bounds
    }

    /// Records the search for `blocks` blocks from `order[push.first_block]` on; `columns` is how many columns of
    /// positions a block is searched at, at most.
    pub fn record(&self, recorder: &mut Recorder<'_>, push: &SearchPush, columns: u32, blocks: u32) {
        let push = SearchPush { bound_rows: self.bound_rows, first_least: self.first_least, ..*push };
        let [centre_r, centre_g, centre_b] = self.centre;
        let aim = AimPush {
            output: push.output,
            sample_height: push.sample_height,
            block_px: push.block_px,
            overlap_px: push.overlap_px,
            tileable: push.tileable,
            columns: push.columns,
            rows: push.rows,
            first_block: push.first_block,
            strips: self.strips,
            first_least: self.first_least,
            centre_r,
            centre_g,
            centre_b,
        };
        recorder.dispatch(&self.aim.pipeline, &self.aim.set, &aim, [blocks, 1, 1]);
        self.record_bound(recorder, &push, columns, blocks);
        let groups = [push.groups_per_block.div_ceil(SPAN), blocks, 1];
        recorder.dispatch(&self.compare.pipeline, &self.compare.set, &push, groups);
    }

    fn record_bound(&self, recorder: &mut Recorder<'_>, push: &SearchPush, columns: u32, blocks: u32) {
        let [position_columns, position_rows] = self.positions;
        let across = columns.div_ceil(BOUND_GROUP[0]);
        let down = |rows| position_rows.div_ceil(BOUND_GROUP[1] * rows);
        let mut first_slot = 0;
        while first_slot < blocks {
            let left = blocks - first_slot;
            let enough = self.bound.iter().find(|(count, _)| *count >= left).or(self.bound.last());
            let Some((count, stage)) = enough else { break };
            let here = if self.windowed { left } else { *count };
            let bound = BoundPush {
                position_columns,
                position_rows,
                first_slot,
                slots: blocks,
                bound_rows: self.bound_rows,
                tolerance: push.tolerance,
                first_least: self.first_least,
            };
            let groups = if self.windowed { [across, down(WINDOWED_ROWS), here] } else { [across, down(ROWS), 1] };
            recorder.dispatch(stage, &self.bound_set, &bound, groups);
            first_slot += here;
        }
    }
}

/// Columns and rows of positions at which blocks lie in the sample.
fn positions(params: &QuiltParams, (width, height): (u32, u32)) -> [u32; 2] {
    [width - params.block_px + 1, height - params.block_px + 1]
}

/// Rows of the tiles' bounds that a block needs.
fn bound_rows(groups_per_block: u32) -> u32 {
    (groups_per_block * GROUP).div_ceil(BOUND_WORDS)
}

/// For how many blocks `quilt_bound` is needed in dispatches of up to `batch`, and for how many rows of positions.
fn bounds(windowed: bool, batch: u32) -> &'static [(u32, u32)] {
    const EVERYWHERE: [(u32, u32); 2] = [(BLOCK_COUNTS[0], ROWS), (BLOCK_COUNTS[1], ROWS)];
    match windowed {
        true => &[(1, WINDOWED_ROWS)],
        false if batch <= BLOCK_COUNTS[0] => &EVERYWHERE[..1],
        false => &EVERYWHERE,
    }
}

/// The strips as `quilt_aim` reads them, but for the steps of their coordinates.
fn strip_data(strips: &[Strip], bases: &[StripBasis]) -> Vec<StripData> {
    let mut first = 0;
    let data = strips.iter().zip(bases).map(|(strip, basis)| {
        let data = StripData {
            x: strip.x,
            y: strip.y,
            width: strip.shape.width,
            height: strip.shape.height,
            left: u32::from(strip.left),
            first,
            directions: basis.components as u32,
            margin: basis.margin,
            step: 0.0,
        };
        first += data.directions + 3;
        data
    });
    data.collect()
}

/// The directions as `quilt_aim` reads them: for each coordinate a row, a texel for each pixel of its strip.
fn direction_rows(bases: &[StripBasis], texels: u32) -> ((u32, u32), Vec<[f32; 4]>) {
    let pixels = |basis: &StripBasis| (basis.shape.width * basis.shape.height) as usize;
    let width = bases.iter().map(pixels).max().unwrap_or(1);
    let none = [const { &[] as &[f32] }; 3];
    let rows = bases.iter().flat_map(|basis| basis.weights.chunks_exact(3 * pixels(basis)).chain(none));
    let mut texel_rows = vec![[0.0; 4]; width * 8 * texels as usize];
    for (to, row) in texel_rows.chunks_exact_mut(width).zip(rows) {
        for (to, from) in to.iter_mut().zip(row.chunks_exact(3)) {
            to[..3].copy_from_slice(from);
        }
    }
    ((width as u32, 8 * texels), texel_rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params(block_px: u32, overlap_px: u32, tileable: bool) -> QuiltParams {
        QuiltParams { block_px, overlap_px, tileable, ..Default::default() }
    }

    /// x, y, width, height, whether on the left, whether the shorter of two.
    type Described = (u32, u32, u32, u32, bool, bool);

    fn described(params: QuiltParams, output: (u32, u32), windowed: bool) -> Vec<Described> {
        let layout = Layout::new(&params, output).expect("layout");
        let describe = |s: &Strip| (s.x, s.y, s.shape.width, s.shape.height, s.left, s.shorter);
        strips(&params, &layout, windowed).iter().map(describe).collect()
    }

    #[test]
    fn strips_by_hand() {
        let whole = [(0, 0, 3, 12, true, false), (3, 0, 9, 3, false, false)];
        // Blocks at 0, 9, 18, 27 end at 39.
        assert_eq!(described(params(12, 3, false), (39, 39), false), whole);
        // The last column is 8 px wide, the last row 4 px high.
        let cut = [
            (0, 0, 3, 4, true, true),
            (0, 4, 3, 8, true, false),
            (3, 0, 5, 3, false, false),
            (8, 0, 4, 3, false, true),
        ];
        assert_eq!(described(params(12, 3, false), (35, 31), false), cut);
        assert_eq!(described(params(12, 3, false), (35, 31), true), whole, "windowed");
        // Parts of 2 px are not worth it: the last column lacks 2 px, or has but 2 beside the corner.
        assert_eq!(described(params(12, 3, false), (37, 37), false), whole);
        assert_eq!(described(params(12, 3, false), (32, 39), false), whole);
        // Two halves: the second counts as the shorter.
        let halves = [
            (0, 0, 4, 8, true, false),
            (0, 8, 4, 8, true, true),
            (4, 0, 6, 4, false, false),
            (10, 0, 6, 4, false, true),
        ];
        assert_eq!(described(params(16, 4, false), (22, 20), false), halves);
        // 20 px in four columns of 5, 11 px in rows of 5 and 6, and 2 px more each.
        let tileable = [(0, 0, 2, 7, true, false), (2, 0, 5, 2, false, false)];
        assert_eq!(described(params(8, 2, true), (20, 11), false), tileable);
    }

    #[test]
    fn the_coordinates_of_all_strips_have_room() {
        for (block, overlap) in [(4, 1), (8, 4), (15, 5), (16, 4), (17, 1), (32, 6), (64, 31)] {
            for (side, tileable) in (1..3 * block).flat_map(|side| [(side, false), (side, true)]) {
                let params = params(block, overlap, tileable);
                let Ok(layout) = Layout::new(&params, (side, side)) else { continue };
                let strips = strips(&params, &layout, false);
                for all in TEXELS.map(|level| level.0) {
                    let of_side = |left: bool| {
                        let here: Vec<_> = strips.iter().filter(|strip| strip.left == left).collect();
                        here.iter().map(|strip| strip.texels(here.len() > 1, all)).sum::<u32>()
                    };
                    let most = MOST_TEXELS + 1;
                    assert!(of_side(true) <= most && of_side(false) <= most, "{block} {overlap} {side} {tileable}");
                }
            }
        }
    }

    #[test]
    fn strips_and_directions_are_laid_out_as_the_shader_reads_them() {
        let sample: Vec<[u8; 4]> = (0..9 * 7u8).map(|i| [i * 3, i ^ 21, 255 - i, 255]).collect();
        let strip =
            |x, y, width, height, left| Strip { x, y, shape: StripShape { width, height }, left, shorter: false };
        let strips = [strip(0, 1, 2, 3, true), strip(2, 0, 4, 1, false)];
        let bases = [(0, 13), (1, 5)].map(|(i, k)| StripBasis::new(&sample, (9, 7), strips[i].shape, k));
        let data = strip_data(&strips, &bases);
        let fields = |d: &StripData| [d.x, d.y, d.width, d.height, d.left, d.first, d.directions];
        assert_eq!(fields(&data[0]), [0, 1, 2, 3, 1, 0, 13]);
        // After 13 directions, what they leave out and a length that takes the place of two.
        assert_eq!(fields(&data[1]), [2, 0, 4, 1, 0, 16, 5]);
        assert_eq!([data[0].margin, data[1].margin], [bases[0].margin, bases[1].margin]);

        let (size, rows) = direction_rows(&bases, 3);
        assert_eq!((size, rows.len()), ((6, 24), 6 * 24));
        let row = |row: usize| &rows[6 * row..][..6];
        let texels = |weights: &[f32]| weights.chunks(3).map(|w| [w[0], w[1], w[2], 0.0]).collect::<Vec<_>>();
        assert_eq!(row(12), texels(&bases[0].weights[12 * 18..]));
        assert_eq!(row(18)[..4], texels(&bases[1].weights[2 * 12..3 * 12]));
        for (row_index, from) in [(13, 0), (14, 0), (15, 0), (18, 4), (21, 0), (23, 0)] {
            assert!(row(row_index)[from..].iter().all(|texel| *texel == [0.0; 4]), "{row_index}");
        }
    }

    #[test]
    fn counts_by_hand() {
        assert_eq!(bounds(true, 99), [(1, 1)]);
        assert_eq!(bounds(false, 5), [(5, 2)]);
        assert_eq!(bounds(false, 6), [(5, 2), (10, 2)]);
        assert_eq!(positions(&params(16, 4, false), (20, 16)), [5, 1]);
        // 128 tiles to a group, 1,024 to a row.
        assert_eq!([1, 8, 9].map(bound_rows), [1, 1, 2]);
        assert_eq!([1, 2, 6].map(directions), [5, 13, 45]);
    }
}
