//! `impasto prepare`: the levels of a strip for view-aligned projection, in a file (thesis chapter 7).

use super::failure::{Failure, Result};
use super::files::{check_file, Outputs};
use super::painter::prepare_levels;
use super::quilting::Quilting;
use super::session::Session;
use super::strips::StripFlags;
use super::techniques::LevelFlags;
use super::values::Size;
use clap::Args;
use impasto::gpu::Uploads;
use impasto::paint::PaintSample;
use impasto::technique::aligned::{LevelSource, LevelVolume};
use std::path::PathBuf;

/// Flags of `impasto prepare`.
#[derive(Args, Debug)]
pub struct PrepareArgs {
    /// Paint strip, dark on the left and light on the right
    #[arg(value_name = "STRIP.png")]
    strip: PathBuf,
    /// File to write, a KTX2 texture
    #[arg(short, long, value_name = "OUT.ktx2")]
    output: PathBuf,
    /// Other colours for the strip's texture: another strip's, or stops like 0:#102030,0.5:#ff8800,1:#ffffff
    #[arg(long, value_name = "STRIP2.png|STOPS")]
    gradient: Option<String>,
    #[command(flatten)]
    strips: StripFlags,
    #[command(flatten)]
    quilting: Quilting,
    #[command(flatten)]
    levels: LevelFlags,
}

/// Prepares.
pub fn run(args: &PrepareArgs, session: &mut Session) -> Result {
    if args.output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("ktx2")) {
        return Err(Failure::file(&args.output, "the name of a prepared paint must end in .ktx2"));
    }
    check_file(&args.output)?;
    let params = args.levels.params(args.quilting.params(false), None)?;
    let sample = PaintSample::load(&args.strip)?;
    let name = args.strip.display().to_string();
    let strip = args.strips.separate(sample, &name, session)?;
    let size = Size { width: params.size_px, height: params.size_px };
    args.quilting.check(&args.strip, (strip.sample.width(), strip.sample.height()), size, false)?;
    let gradient = args.gradient.as_ref().map(|text| args.strips.gradient(text, strip.trajectory.len()));
    let trajectory = gradient.transpose()?.unwrap_or(strip.trajectory);
    session.parameter("strip", name);
    session.parameter("gradient", args.gradient.clone());
    args.strips.report(session);
    args.quilting.report(session);
    args.levels.report(session);
    session.phase("load");

    let mut device = session.open_device()?;
    session.phase("setup");
    let mut uploads = Uploads::default();
    let stages = session.quilt_stages(&mut device, args.quilting.search)?;
    let sources = [LevelSource::Strip(&strip.texture)];
    let levels = LevelVolume::new(&device.context, &mut uploads, &stages, &sources, &params)?;
    device.upload(&mut uploads)?;
    session.phase("prepare");
    prepare_levels(session, &mut device, &levels, args.quilting.seed)?;
    session.phase("synthesis");
    let texture = levels.read(&mut device.runner, 0, &trajectory)?;
    session.take_times(&mut device.runner);
    let mut outputs = Outputs::default();
    outputs.add(&args.output, texture.to_ktx2());
    session.wrote(outputs.commit()?);
    session.phase("write");
    Ok(())
}
