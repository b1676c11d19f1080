//! The flags of image quilting, and running one with a progress bar.

use super::failure::{Failure, Result};
use super::report::number;
use super::session::{Device, Session, PART_COMPARISONS};
use super::values::Size;
use clap::{Args, ValueEnum};
use impasto::gpu::{Context, Runner, Uploads};
use impasto::synthesis::calibrate::calibrate;
use impasto::synthesis::params::{BlockRecord, QuiltParams};
use impasto::synthesis::quilt::{Pruning, Quilt, QuiltStages, SampleTexels};
use std::path::Path;
use std::sync::Arc;

/// How to quilt.
#[derive(Args, Debug, Clone)]
pub struct Quilting {
    /// Side of the square blocks in pixels, 4 to 64
    #[arg(long, value_name = "PX", default_value_t = 32, allow_negative_numbers = true)]
    pub block: u32,
    /// By how many pixels neighbouring blocks overlap, 1 to half a block
    #[arg(long, value_name = "PX", default_value_t = 6, allow_negative_numbers = true)]
    pub overlap: u32,
    /// How much worse than the best a position may fit and still be chosen, as a fraction: 0 to 10
    #[arg(long, value_name = "FRACTION", default_value_t = 0.1, allow_negative_numbers = true)]
    pub tolerance: f32,
    /// Picks among the positions that fit; the same seed gives the same picture
    #[arg(long, value_name = "NUMBER", default_value_t = 1, allow_negative_numbers = true)]
    pub seed: u32,
    /// How the positions for a block are searched through, which changes how long it takes and never the picture
    #[arg(long = "quilt-search", id = "quilt_search", value_name = "HOW", value_enum, default_value_t)]
    pub search: SearchFlag,
}

/// How to search.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[value(rename_all = "lower")]
pub enum SearchFlag {
    /// As is expected to be fast on this kind of device
    #[default]
    Auto,
    /// Compare every position
    Full,
    /// Leave out positions that cannot be chosen
    Pruned,
    /// As is found to be the fastest by trying, a second or two
    Calibrate,
}

impl SearchFlag {
    /// Stages that search so.
    pub fn stages(self, context: &Context) -> Result<Arc<QuiltStages>> {
        Ok(match self {
            SearchFlag::Auto => QuiltStages::with_pruning(context, Pruning::Auto),
            SearchFlag::Full => QuiltStages::with_pruning(context, Pruning::Off),
            SearchFlag::Pruned => QuiltStages::with_pruning(context, Pruning::On),
            // A runner of its own, so that its passes are not among the command's times.
            SearchFlag::Calibrate => QuiltStages::with_path(context, calibrate(&mut Runner::new(context)?)?)?,
        })
    }
}

impl Quilting {
    /// The library's parameters.
    pub fn params(&self, tileable: bool) -> QuiltParams {
        QuiltParams {
            block_px: self.block,
            overlap_px: self.overlap,
            tolerance: self.tolerance,
            seed: self.seed,
            tileable,
        }
    }

    /// Checks the flags, then that blocks can be cut from the sample in `file`.
    pub fn check(&self, file: &Path, sample: (u32, u32), size: Size, tileable: bool) -> Result {
        let params = self.params(tileable);
        // With a sample that fits, only the flags can be wrong.
        params.validate((64, 64), size.pair())?;
        let (width, height) = sample;
        if width.min(height) < self.block {
            let block = self.block;
            return Err(Failure::file(
                file,
                format!("{width}x{height} pixels, but --block {block} needs {block}x{block} at least"),
            ));
        }
        Ok(params.validate(sample, size.pair())?)
    }

    /// Adds the flags to the report.
    pub fn report(&self, session: &mut Session) {
        session.parameter("block", self.block);
        session.parameter("overlap", self.overlap);
        session.parameter("tolerance", number(self.tolerance));
        session.parameter("seed", self.seed);
    }
}

/// What a quilting gives.
pub struct Quilted {
    /// RGBA texels, row by row from the top.
    pub texels: Vec<u8>,
    /// What was chosen, block by block.
    pub blocks: Vec<BlockRecord>,
}

/// Quilts a texture freely, without a guide.
pub fn quilt(
    session: &mut Session,
    device: &mut Device,
    texels: &[[u8; 4]],
    sample: (u32, u32),
    size: Size,
    (quilting, tileable): (&Quilting, bool),
) -> Result<Quilted> {
    let mut uploads = Uploads::default();
    let params = &quilting.params(tileable);
    let stages = session.quilt_stages(device, quilting.search)?;
    let sample = SampleTexels::new(&device.context, &mut uploads, texels, sample)?;
    let quilt = Quilt::new(&device.context, &mut uploads, &stages, &sample, size.pair(), params, None)?;
    device.upload(&mut uploads)?;
    session.phase("prepare");
    let parts = quilt.parts(PART_COMPARISONS);
    let progress = session.progress("quilting", parts.len());
    for part in parts {
        device.runner.run(|recorder| {
            quilt.record_part(recorder, part, params.seed, 0);
            Ok(())
        })?;
        progress.step();
    }
    drop(progress);
    let texels = device.runner.read_image(quilt.canvas())?;
    let blocks = quilt.read_records(&mut device.runner)?;
    session.phase("synthesis");
    session.take_times(&mut device.runner);
    Ok(Quilted { texels, blocks })
}
