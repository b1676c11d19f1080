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
use super::repair::FitPush;
use crate::gpu::{
    Access, BindingKind, BindingSet, Bound, Buffer, BufferKind, ComputePipeline, Context, Image, ImageDesc, Recorder,
    Runner, Shader, Uploads,
};
use crate::{Error, Result};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;

/// Positions that one workgroup of the search compares: GROUP invocations of TILE positions each, as in quilt.glsl.
const GROUP: u32 = 128;
const TILE: u32 = 8;
/// Texels that a search may read beyond the right edge of a sample.
const PADDING: u32 = TILE + 6;
/// Blocks in a row of `quilt_guide`'s workgroups; every device allows more.
const GUIDE_GROUPS_X: u32 = 32_768;
/// Memory for the errors of one dispatch; longer waves are cut.
pub(super) const ERRORS_BYTES: u64 = 64 << 20;
/// What placing a block costs, measured in pixel comparisons of the search on lavapipe (0.13 ms at 2 G/s).
const PLACE_COMPARISONS: u64 = 250_000;
/// Pixel comparisons after which a step of the search is cut, so that a submission can be kept short.
const STEP_COMPARISONS: u64 = 200_000_000;

pub(crate) const QUILT_GUIDE: Shader = Shader {
    name: "quilt_guide",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_guide.comp.spv"),
    bindings: &[BindingKind::Image(Access::ComputeRead), BindingKind::Buffer(Access::ComputeReadWrite)],
    push_bytes: size_of::<GuidePush>() as u32,
};

pub(crate) const QUILT_SEARCH: Shader = Shader {
    name: "quilt_search",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_search.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeWrite),
    ],
    push_bytes: size_of::<SearchPush>() as u32,
};

pub(crate) const QUILT_MATCH: Shader = Shader {
    name: "quilt_match",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_match.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeWrite),
    ],
    push_bytes: size_of::<MatchPush>() as u32,
};

pub(crate) const QUILT_PLACE: Shader = Shader {
    name: "quilt_place",
    spirv: include_bytes!("../../glsl/spirv/synthesis/quilt_place.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeReadWrite),
        BindingKind::Image(Access::ComputeWrite),
        BindingKind::Buffer(Access::ComputeReadWrite),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
    ],
    push_bytes: size_of::<PlacePush>() as u32,
};

/// `Block` of quilt.glsl.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct BlockData {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    sx0: u32,
    sx1: u32,
    state: u32,
    sx: u32,
    sy: u32,
    error: u32,
    min_error: u32,
}

const STATE_PLACED: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct GuidePush {
    output: [u32; 2],
    sample_width: u32,
    block_px: u32,
    guided: u32,
    paint: u32,
    window_px: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct SearchPush {
    output: [u32; 2],
    sample_height: u32,
    block_px: u32,
    overlap_px: u32,
    tileable: u32,
    columns: u32,
    rows: u32,
    first_block: u32,
    first_group: u32,
    groups_per_block: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct MatchPush {
    output: [u32; 2],
    sample_height: u32,
    block_px: u32,
    overlap_px: u32,
    tileable: u32,
    columns: u32,
    rows: u32,
    first_block: u32,
    first_group: u32,
    groups_per_block: u32,
    canvas_weight: u32,
    previous_weight: u32,
    first_row: u32,
    row_step: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct PlacePush {
    output: [u32; 2],
    sample_height: u32,
    block_px: u32,
    overlap_px: u32,
    tileable: u32,
    first_block: u32,
    groups_per_block: u32,
    columns: u32,
    rows: u32,
    tolerance: u32,
    seed: u32,
    frame: u32,
    first_row: u32,
    row_step: u32,
}

/// A structure that Rust and GLSL share: its file below glsl/, its name there, its size, and Rust's fields with their
/// offsets. Only for the test that compares the two.
#[doc(hidden)]
pub type SharedStruct = (&'static str, &'static str, usize, Vec<(&'static str, usize)>);

/// The structures that the stages share with their shaders.
#[doc(hidden)]
pub fn shared_structs() -> Vec<SharedStruct> {
    macro_rules! shared {
        ($file:literal, $glsl:literal, $rust:ty, $($field:ident)*) => {
            ($file, $glsl, size_of::<$rust>(), vec![$((stringify!($field), std::mem::offset_of!($rust, $field))),*])
        };
    }
    vec![
        shared!("synthesis/quilt.glsl", "struct Block", BlockData,
            x y width height sx0 sx1 state sx sy error min_error),
        shared!("synthesis/quilt_guide.comp", "uniform Push", GuidePush,
            output sample_width block_px guided paint window_px),
        shared!("synthesis/quilt_search.comp", "uniform Push", SearchPush,
            output sample_height block_px overlap_px tileable columns rows first_block first_group groups_per_block),
        shared!("synthesis/quilt_match.comp", "uniform Push", MatchPush,
            output sample_height block_px overlap_px tileable columns rows first_block first_group groups_per_block
            canvas_weight previous_weight first_row row_step),
        shared!("synthesis/repair_fit.comp", "uniform Push", FitPush,
            sample_width block_px overlap_px columns rows paint window_px slack capacity band_rows),
        shared!("synthesis/quilt_place.comp", "uniform Push", PlacePush,
            output sample_height block_px overlap_px tileable first_block groups_per_block columns rows tolerance seed
            frame first_row row_step),
    ]
}

/// The compiled stages; one for a context serves every quilting.
pub struct QuiltStages {
    guide: ComputePipeline,
    /// One for each size of chunk, 4, 5 and 6.
    search: [ComputePipeline; 3],
    /// Without and with another picture to match.
    pub(super) matching: [ComputePipeline; 2],
    pub(super) place: ComputePipeline,
}

impl QuiltStages {
    /// Compiles the stages.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context) -> Result<Arc<Self>> {
        let search = |chunk| ComputePipeline::specialized(context, &QUILT_SEARCH, &[chunk]);
        let matching = |previous| ComputePipeline::specialized(context, &QUILT_MATCH, &[previous]);
        Ok(Arc::new(QuiltStages {
            guide: ComputePipeline::new(context, &QUILT_GUIDE)?,
            search: [search(4)?, search(5)?, search(6)?],
            matching: [matching(0)?, matching(1)?],
            place: ComputePipeline::new(context, &QUILT_PLACE)?,
        }))
    }
}

/// A sample's 8-bit texels on the device, and the summed-area table of their squares.
pub struct SampleTexels {
    image: Image,
    squares: Image,
    size: (u32, u32),
}

impl SampleTexels {
    /// Stages `texels` (RGBA, row by row; alpha is ignored) for upload.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the texels are not `size.0 * size.1`, or a side is over 4,096 px.
    pub fn new(context: &Context, uploads: &mut Uploads, texels: &[[u8; 4]], size: (u32, u32)) -> Result<Self> {
        // The summed-area table is the largest image that is made.
        let limit = super::params::MAX_SAMPLE_PX.min(context.caps().max_image_2d_px.saturating_sub(PADDING + 1));
        if size.0 == 0 || size.1 == 0 || size.0 > limit || size.1 > limit {
            return Err(Error::parameter(
                "sample size",
                format!("{}x{}", size.0, size.1),
                format!("1 to {limit} px a side"),
            ));
        }
        if texels.len() as u64 != u64::from(size.0) * u64::from(size.1) {
            return Err(Error::parameter("sample texels", texels.len(), format!("{} x {}", size.0, size.1)));
        }
        // A tile of positions at the right edge reads beyond it; what it reads is there, and unused.
        let (width, height) = (size.0 as usize, size.1 as usize);
        let padded_width = width + PADDING as usize;
        let mut padded = vec![[0u8; 4]; padded_width * height];
        for (to, from) in padded.chunks_exact_mut(padded_width).zip(texels.chunks_exact(width)) {
            to[..width].copy_from_slice(from);
        }
        let squares = summed_squares(&padded, padded_width, height);
        let image = |name, width: usize, height: usize, data: &[u8], uploads: &mut Uploads| {
            let desc = ImageDesc::storage_2d(width as u32, height as u32, vk::Format::R32_UINT);
            let image = Image::new(context, name, &desc)?;
            uploads.image(context, &image, data)?;
            Ok::<_, Error>(image)
        };
        let texels = image("quilt sample", padded_width, height, bytemuck::cast_slice(&padded), uploads)?;
        let squares =
            image("quilt sample squares", padded_width + 1, height + 1, bytemuck::cast_slice(&squares), uploads)?;
        Ok(SampleTexels { image: texels, squares, size })
    }

    pub(crate) fn image(&self) -> &Image {
        &self.image
    }

    /// Width and height of the sample, pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }
}

/// The summed-area table of |rgb|^2 with a row and a column of zeros first. It wraps around; differences do not care.
fn summed_squares(texels: &[[u8; 4]], width: usize, height: usize) -> Vec<u32> {
    let mut table = vec![0u32; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0u32;
        for x in 0..width {
            let [r, g, b, _] = texels[y * width + x].map(u32::from);
            row = row.wrapping_add(r * r + g * g + b * b);
            table[(y + 1) * (width + 1) + x + 1] = table[y * (width + 1) + x + 1].wrapping_add(row);
        }
    }
    table
}

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
    Overlap(BindingSet),
    /// What is painted in its overlaps, and another picture; how much a pixel of either counts.
    Weighted { set: BindingSet, weights: [u32; 2] },
}

/// Waves of blocks, and what places them in this order.
struct Waves {
    search: Search,
    place_set: BindingSet,
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
    guide_set: BindingSet,
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
        params.validate(sample.size, output)?;
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
        let all_columns = sample.size.0 - params.block_px + 1;
        let columns = match &guide {
            Some(guide) => all_columns.min(guide.window_px.saturating_mul(2).saturating_add(1)),
            None => all_columns,
        };
        let rows = Rows::new(params, sample.size.1, columns, 0, 1);
        let (groups_per_block, block_bytes) = (rows.groups, rows.block_bytes());
        let longest = layout.waves.iter().map(Vec::len).max().unwrap_or(1) as u64;
        let batch = (ERRORS_BYTES / block_bytes).clamp(1, longest) as u32;

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
        let minima = storage("quilt group minima", u64::from(groups_per_block) * u64::from(batch) * 4)?;
        uploads.buffer(context, &blocks, bytemuck::cast_slice(&data))?;
        let guide_image = guide.as_ref().map_or(&sample.image, |guide| &guide.image);
        let guide_set = BindingSet::new(context, &stages.guide, &[guide_image.into(), (&blocks).into()])?;
        let most_groups = context.caps().max_group_count_x;
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
                Search::Weighted { set: targets.match_set(context, previous)?, weights: [OVERLAP_WEIGHT, weight] }
            }
            _ => Search::Overlap(targets.search_set(context, chunk(params))?),
        };
        let waves = Waves {
            search,
            place_set: targets.place_set(context)?,
            steps: steps(params, &layout.waves, groups_per_block, batch, most_groups),
        };
        Ok(Quilt {
            stages: stages.clone(),
            params: *params,
            layout,
            sample_size: sample.size,
            guide,
            canvas,
            source,
            previous,
            blocks,
            guide_set,
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

    /// The grid of blocks.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Pixel comparisons of the whole search, an upper bound where a guide skips blocks.
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
        let push = GuidePush {
            output: [self.layout.output.0, self.layout.output.1],
            sample_width: self.sample_size.0,
            block_px: self.params.block_px,
            guided: u32::from(self.guide.is_some()),
            paint: self.guide.as_ref().map_or(0, |guide| guide.paint),
            // More than a sample is wide makes no difference, and stays clear of overflow.
            window_px: self.guide.as_ref().map_or(0, |guide| guide.window_px.min(self.sample_size.0)),
        };
        recorder.dispatch(&self.stages.guide, &self.guide_set, &push, self.groups_by_block());
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
        }
    }

    fn record_waves(&self, recorder: &mut Recorder<'_>, part: Range<usize>, seed: u32, frame: u32) {
        let rows = Rows { first: 0, step: 1, groups: self.groups_per_block };
        for (step, _) in self.waves.steps.get(part).unwrap_or_default() {
            match step.clone() {
                Step::Search { blocks, groups } => self.record_search(recorder, rows, blocks, groups),
                Step::Place { blocks } => {
                    let push = self.place_push(blocks.start, rows, self.params.tolerance, seed, frame);
                    let count = [blocks.len() as u32, 1, 1];
                    recorder.dispatch(&self.stages.place, &self.waves.place_set, &push, count);
                }
            }
        }
    }

    fn record_search(&self, recorder: &mut Recorder<'_>, rows: Rows, blocks: Range<u32>, groups: Range<u32>) {
        let params = &self.params;
        let count = [groups.len() as u32, blocks.len() as u32, 1];
        match &self.waves.search {
            Search::Overlap(set) => {
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
                };
                recorder.dispatch(&self.stages.search[chunk(params)], set, &push, count);
            }
            Search::Weighted { set, weights } => {
                let push = MatchPush { first_group: groups.start, ..self.match_push(blocks.start, rows, *weights) };
                recorder.dispatch(&self.stages.matching[1], set, &push, count);
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

/// Which size of chunk (4, 5 or 6 texels) wastes least at the ends of the runs of an L: rows as wide as the block, and
/// rows as wide as the overlap.
fn chunk(params: &QuiltParams) -> usize {
    let (block, overlap) = (params.block_px, params.overlap_px);
    let padded = |run: u32, chunk: u32| run.div_ceil(chunk) * chunk;
    let work = |i: &usize| {
        let chunk = 4 + *i as u32;
        overlap * padded(block, chunk) + (block - overlap) * padded(overlap, chunk)
    };
    (0..3).min_by_key(work).unwrap_or_default()
}

/// What the stages that place blocks are bound to.
pub(super) struct Targets<'a> {
    pub stages: &'a QuiltStages,
    pub sample: &'a SampleTexels,
    pub canvas: &'a Image,
    pub source: &'a Image,
    pub blocks: &'a Buffer,
    pub order: &'a Buffer,
    pub errors: &'a Buffer,
    pub minima: &'a Buffer,
}

impl Targets<'_> {
    fn buffers(&self) -> [Bound; 4] {
        [self.blocks.into(), self.order.into(), self.errors.into(), self.minima.into()]
    }

    fn search_set(&self, context: &Context, chunk: usize) -> Result<BindingSet> {
        let images = [(&self.sample.image).into(), (&self.sample.squares).into(), self.canvas.into()];
        BindingSet::new(context, &self.stages.search[chunk], &[&images[..], &self.buffers()].concat())
    }

    /// For a search that matches `previous` too, if it does.
    pub fn match_set(&self, context: &Context, previous: &Image) -> Result<BindingSet> {
        let images = [(&self.sample.image).into(), self.canvas.into(), previous.into()];
        BindingSet::new(context, &self.stages.matching[0], &[&images[..], &self.buffers()].concat())
    }

    pub fn place_set(&self, context: &Context) -> Result<BindingSet> {
        let images = [(&self.sample.image).into(), self.canvas.into(), self.source.into()];
        BindingSet::new(context, &self.stages.place, &[&images[..], &self.buffers()].concat())
    }
}

/// Which rows of positions are compared, and how many groups of positions that makes for a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    pub first: u32,
    pub step: u32,
    pub groups: u32,
}

impl Rows {
    /// Every `step`th row of a sample, from `first` on, for blocks that are searched at up to `columns` columns.
    pub fn new(params: &QuiltParams, sample_height: u32, columns: u32, first: u32, step: u32) -> Self {
        let rows = (sample_height - params.block_px - first) / step + 1;
        Rows { first, step, groups: (columns.div_ceil(TILE) * rows).div_ceil(GROUP) }
    }

    /// Bytes of the errors of a block.
    pub fn block_bytes(&self) -> u64 {
        u64::from(self.groups) * u64::from(GROUP * TILE) * 4
    }
}

/// The steps of waves with their cost in pixel comparisons.
fn steps(params: &QuiltParams, waves: &[Vec<u32>], groups: u32, batch: u32, most_groups: u32) -> Vec<(Step, u64)> {
    let (b, o) = (u64::from(params.block_px), u64::from(params.overlap_px));
    let overlap_px = if params.tileable { b * b - (b - 2 * o) * (b - 2 * o) } else { 2 * b * o - o * o };
    let group_cost = u64::from(GROUP * TILE) * overlap_px;
    let mut steps = Vec::new();
    let mut first = 0;
    for wave in waves {
        let end = first + wave.len() as u32;
        while first < end {
            let blocks = first..end.min(first + batch);
            let cost = group_cost * blocks.len() as u64;
            let most = (STEP_COMPARISONS / cost).clamp(1, u64::from(most_groups)) as u32;
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
