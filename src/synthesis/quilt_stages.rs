//! The stages that quilting and repairs are made of: their shaders, what they share with them, and what they are bound
//! to. [`super::quilt`] and [`super::repair`] say in which order they run.

use super::params::QuiltParams;
use super::prune::{AimPush, BoundPush, StripData, QUILT_COMPARE};
use super::repair::FitPush;
use super::sample::SampleTexels;
use super::search_path::{Pruning, SearchPath};
use crate::gpu::{Access, BindingKind, BindingSet, Bound, Buffer, ComputePipeline, Context, Image, Shader};
use crate::Result;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Positions that one workgroup of the search compares: GROUP invocations of TILE positions each, as in quilt.glsl.
pub(super) const GROUP: u32 = 128;
pub(super) const TILE: u32 = 8;

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
        BindingKind::Image(Access::ComputeReadWrite),
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
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
    pub sx0: u32,
    pub sx1: u32,
    pub state: u32,
    pub sx: u32,
    pub sy: u32,
    pub error: u32,
    pub min_error: u32,
}

pub(super) const STATE_PLACED: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct GuidePush {
    pub output: [u32; 2],
    pub sample_width: u32,
    pub block_px: u32,
    pub guided: u32,
    pub paint: u32,
    pub window_px: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct SearchPush {
    pub output: [u32; 2],
    pub sample_height: u32,
    pub block_px: u32,
    pub overlap_px: u32,
    pub tileable: u32,
    pub columns: u32,
    pub rows: u32,
    pub first_block: u32,
    pub first_group: u32,
    pub groups_per_block: u32,
    pub tolerance: u32,
    pub bound_rows: u32,
    pub first_least: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct MatchPush {
    pub output: [u32; 2],
    pub sample_height: u32,
    pub block_px: u32,
    pub overlap_px: u32,
    pub tileable: u32,
    pub columns: u32,
    pub rows: u32,
    pub first_block: u32,
    pub first_group: u32,
    pub groups_per_block: u32,
    pub canvas_weight: u32,
    pub previous_weight: u32,
    pub first_row: u32,
    pub row_step: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct PlacePush {
    pub output: [u32; 2],
    pub sample_height: u32,
    pub block_px: u32,
    pub overlap_px: u32,
    pub tileable: u32,
    pub first_block: u32,
    pub groups_per_block: u32,
    pub columns: u32,
    pub rows: u32,
    pub tolerance: u32,
    pub seed: u32,
    pub frame: u32,
    pub first_row: u32,
    pub row_step: u32,
    pub bound_rows: u32,
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
        shared!("synthesis/search_push.glsl", "uniform Push", SearchPush,
            output sample_height block_px overlap_px tileable columns rows first_block first_group groups_per_block
            tolerance bound_rows first_least),
        shared!("synthesis/quilt_aim.comp", "uniform Push", AimPush,
            output sample_height block_px overlap_px tileable columns rows first_block strips first_least centre_r
            centre_g centre_b),
        shared!("synthesis/quilt_aim.comp", "struct Strip", StripData,
            x y width height left first directions margin step),
        shared!("synthesis/quilt_bound.comp", "uniform Push", BoundPush,
            position_columns position_rows first_slot slots bound_rows tolerance first_least),
        shared!("synthesis/quilt_match.comp", "uniform Push", MatchPush,
            output sample_height block_px overlap_px tileable columns rows first_block first_group groups_per_block
            canvas_weight previous_weight first_row row_step),
        shared!("synthesis/repair_fit.comp", "uniform Push", FitPush,
            sample_width block_px overlap_px columns rows paint window_px slack capacity band_rows),
        shared!("synthesis/quilt_place.comp", "uniform Push", PlacePush,
            output sample_height block_px overlap_px tileable first_block groups_per_block columns rows tolerance seed
            frame first_row row_step bound_rows),
    ]
}

/// The compiled stages; one for a context serves every quilting. A stage is compiled when a quilting that needs it is
/// made, and kept.
pub struct QuiltStages {
    context: Context,
    path: SearchPath,
    compiled: Mutex<HashMap<StageKey, Arc<ComputePipeline>>>,
}

/// A shader's name, and its specialisation constants.
type StageKey = (&'static str, Vec<u32>);

impl QuiltStages {
    /// For searches by the path that is expected to be fast on a device of this kind.
    pub fn new(context: &Context) -> Arc<Self> {
        Self::with_pruning(context, Pruning::Auto)
    }

    /// For searches by this path.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when its parts are not 1, 2, 4 or 8.
    pub fn with_path(context: &Context, path: SearchPath) -> Result<Arc<Self>> {
        path.check()?;
        Ok(Self::with(context, path))
    }

    /// For searches that are pruned or not.
    pub fn with_pruning(context: &Context, pruning: Pruning) -> Arc<Self> {
        Self::with(context, SearchPath::for_device(context).with_pruning(pruning))
    }

    /// For full searches with so many invocations (1, 2, 4 or 8) to a tile. Only for tests: the texture is the same.
    #[doc(hidden)]
    pub fn with_search_parts(context: &Context, parts: u32) -> Arc<Self> {
        Self::with(context, SearchPath { parts, prune_from: SearchPath::NEVER })
    }

    fn with(context: &Context, path: SearchPath) -> Arc<Self> {
        Arc::new(QuiltStages { context: context.clone(), path, compiled: Mutex::default() })
    }

    /// The path of their searches.
    pub fn path(&self) -> SearchPath {
        self.path
    }

    /// Compiles what a quilting with these parameters may need, so that making one takes less long.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] when a call fails.
    pub fn compile(&self, params: &QuiltParams) -> Result<()> {
        if self.path.may_prune() {
            self.compile_pruned(params)?;
        }
        if self.path.prune_from > 0 {
            self.pipeline(&QUILT_GUIDE, &[])?;
            self.pipeline(&QUILT_PLACE, &[0, self.path.parts])?;
            self.pipeline(&QUILT_SEARCH, &[chunk(params), self.path.parts])?;
        }
        Ok(())
    }

    /// Compiles what a pruned quilting needs whatever its sample is.
    pub(super) fn compile_pruned(&self, params: &QuiltParams) -> Result<()> {
        self.pipeline(&QUILT_GUIDE, &[])?;
        self.pipeline(&QUILT_PLACE, &[1, 1])?;
        self.pipeline(&QUILT_COMPARE, &[chunk(params)]).map(drop)
    }

    /// The pipeline of a shader with these specialisation constants.
    pub(super) fn pipeline(&self, shader: &Shader, constants: &[u32]) -> Result<Arc<ComputePipeline>> {
        let compiled = || self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (shader.name, constants.to_vec());
        if let Some(pipeline) = compiled().get(&key) {
            return Ok(pipeline.clone());
        }
        // Not under the lock, so that threads compile side by side.
        let pipeline = Arc::new(ComputePipeline::specialized(&self.context, shader, constants)?);
        Ok(compiled().entry(key).or_insert(pipeline).clone())
    }
}

/// Which size of chunk (4, 5 or 6 texels) wastes least at the ends of the runs of an L: rows as wide as the block, and
/// rows as wide as the overlap.
pub(super) fn chunk(params: &QuiltParams) -> u32 {
    let (block, overlap) = (params.block_px, params.overlap_px);
    let padded = |run: u32, chunk: u32| run.div_ceil(chunk) * chunk;
    let work = |&chunk: &u32| overlap * padded(block, chunk) + (block - overlap) * padded(overlap, chunk);
    (4..=6).min_by_key(work).unwrap_or(4)
}

/// A pipeline and what it is bound to.
pub(super) struct Stage {
    pub pipeline: Arc<ComputePipeline>,
    pub set: BindingSet,
}

impl Stage {
    pub fn new(context: &Context, pipeline: Arc<ComputePipeline>, bound: &[Bound]) -> Result<Self> {
        Ok(Stage { set: BindingSet::new(context, &*pipeline, bound)?, pipeline })
    }
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

    pub fn search(&self, context: &Context, params: &QuiltParams) -> Result<Stage> {
        let images = [self.sample.image().into(), self.sample.squares().into(), self.canvas.into()];
        let pipeline = self.stages.pipeline(&QUILT_SEARCH, &[chunk(params), self.stages.path.parts])?;
        Stage::new(context, pipeline, &[&images[..], &self.buffers()].concat())
    }

    /// A search that matches `previous` too, if there is one.
    pub fn matching(&self, context: &Context, previous: Option<&Image>) -> Result<Stage> {
        // Without one nothing is read, but the binding must have an image.
        let images = [self.sample.image().into(), self.canvas.into(), previous.unwrap_or(self.canvas).into()];
        let pipeline = self.stages.pipeline(&QUILT_MATCH, &[u32::from(previous.is_some())])?;
        Stage::new(context, pipeline, &[&images[..], &self.buffers()].concat())
    }

    /// `minima` are those of a group, `tile_bounds` those of a pruned search.
    pub fn place(&self, context: &Context, minima: u32, tile_bounds: Option<&Image>) -> Result<Stage> {
        // After a full search there are none, but the binding must have an image that is used as they are.
        let bounds = tile_bounds.unwrap_or(self.canvas);
        let images = [self.sample.image().into(), self.canvas.into(), self.source.into(), bounds.into()];
        let pipeline = self.stages.pipeline(&QUILT_PLACE, &[u32::from(tile_bounds.is_some()), minima])?;
        Stage::new(context, pipeline, &[&images[..], &self.buffers()].concat())
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
