//! `impasto measure`: the metrics of chapter 9, and newer ones, on any pictures.

use super::failure::{Failure, Result};
use super::files::{check_file, Outputs};
use super::meter::{Figures, Grid, Meter, MeterFlags, FIGURE_HEADERS};
use super::picture::{encode, format_of};
use super::session::Session;
use super::table::Table;
use clap::{Args, Subcommand};
use impasto::metric::{
    coherence, flip, shading_error, similarity, Eligible, FlipParams, Motion, Neighbour, Picture, Shades,
};
use std::path::{Path, PathBuf};

/// Flags of `impasto measure`.
#[derive(Args, Debug)]
pub struct MeasureArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand, Debug)]
enum What {
    /// How much the texture of a frame looks like the sample's (thesis 9.1), with co-occurrence error and sliced Wasserstein
    /// distance
    Similarity(SimilarityArgs),
    /// How far the texture's place in the strip is from the shade that it should show (thesis 9.2)
    Shading(ShadingArgs),
    /// How much a frame changes to the next, in the picture and on the surface (thesis 9.3), with FLIP
    Coherence(CoherenceArgs),
}

#[derive(Args, Debug)]
struct SimilarityArgs {
    /// The paint strip, or any sample
    #[arg(value_name = "SAMPLE.png")]
    sample: PathBuf,
    /// The picture that was painted with it; transparent pixels do not count
    #[arg(value_name = "FRAME.png")]
    frame: PathBuf,
    #[command(flatten)]
    common: MeasureFlags,
}

#[derive(Args, Debug)]
struct ShadingArgs {
    /// The paint strip, dark on the left
    #[arg(value_name = "STRIP.png")]
    strip: PathBuf,
    /// The picture that was painted with it; transparent pixels do not count
    #[arg(value_name = "FRAME.png")]
    frame: PathBuf,
    /// The shade of each pixel, black to white, like the shade.png of `render --dump`
    #[arg(long, value_name = "SHADE.png")]
    shade: PathBuf,
    #[command(flatten)]
    common: MeasureFlags,
}

#[derive(Args, Debug)]
struct CoherenceArgs {
    /// A frame; transparent pixels do not count
    #[arg(value_name = "FRAME.png")]
    frame: PathBuf,
    /// The frame after it
    #[arg(value_name = "NEXT.png")]
    next: PathBuf,
    /// Where each pixel's surface has moved, for coherence in object space: 16 bits, red 32768 + 64 times the pixels to the
    /// right, green the same downwards, blue 0 where the next frame does not show it; as `compare` writes it
    #[arg(long, value_name = "MOTION.png")]
    motion: Option<PathBuf>,
    #[command(flatten)]
    common: MeasureFlags,
}

#[derive(Args, Debug)]
struct MeasureFlags {
    /// Which pixels of the frame (and of the next) belong to the object, white on black [default: those that are opaque]
    #[arg(long, value_name = "MASK.png")]
    mask: Option<PathBuf>,
    /// Picture of where the error is, to be written: .png, .jpg, .bmp or .tiff
    #[arg(long, value_name = "OUT.png")]
    map: Option<PathBuf>,
    /// Pixels between two that the map has [default: so that it has 64 across or down]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(1..=1024), requires = "map",
          allow_negative_numbers = true)]
    map_step: Option<u32>,
    #[command(flatten)]
    meter: MeterFlags,
}

/// Measures.
pub fn run(args: &MeasureArgs, session: &mut Session) -> Result {
    match &args.what {
        What::Similarity(args) => {
            session.parameter("measure", "similarity");
            session.parameter("sample", args.sample.display().to_string());
            let value = |nearest: &[Vec<Neighbour>], _: &[(u32, u32)]| similarity(nearest);
            let figures = |values: &[f64], sample: &Picture, frame: &Picture| {
                let mut figures = Figures::default();
                figures.score("similarity", values);
                figures.textures(sample, frame)?;
                Ok(figures)
            };
            against_sample(&args.sample, &args.frame, &args.common, session, |_| Ok(()), value, figures)
        }
        What::Shading(args) => {
            session.parameter("measure", "shading");
            session.parameter("sample", args.strip.display().to_string());
            session.parameter("shade", args.shade.display().to_string());
            let shades = Shades::load(&args.shade)?;
            let width = Picture::load(&args.strip)?.width();
            let fits = |frame: &Picture| check_size(&args.shade, shades.size(), frame);
            let value = |nearest: &[Vec<Neighbour>], pixels: &[(u32, u32)]| {
                let wanted: Vec<f64> = pixels.iter().map(|&(x, y)| shades.at(x, y)).collect();
                shading_error(nearest, width, &wanted).into_iter().map(f64::abs).collect()
            };
            let figures = |values: &[f64], _: &Picture, _: &Picture| {
                let mut figures = Figures::default();
                shading_figures(&mut figures, values);
                Ok(figures)
            };
            against_sample(&args.strip, &args.frame, &args.common, session, fits, value, figures)
        }
        What::Coherence(args) => between_frames(args, session),
    }
}

/// The two ways to read the thesis's shading error.
pub fn shading_figures(figures: &mut Figures, errors: &[f64]) {
    figures.score("shading_error_absolute", &errors.iter().map(|error| error.abs()).collect::<Vec<_>>());
    figures.score("shading_error_squared", &errors.iter().map(|error| error.powi(2)).collect::<Vec<_>>());
}

/// Measures a frame against a sample: `value` of the tested pixels and their nearest, `figures` of those values.
fn against_sample(
    sample: &Path,
    frame: &Path,
    flags: &MeasureFlags,
    session: &mut Session,
    fits: impl Fn(&Picture) -> Result,
    value: impl Fn(&[Vec<Neighbour>], &[(u32, u32)]) -> Vec<f64>,
    figures: impl Fn(&[f64], &Picture, &Picture) -> Result<Figures>,
) -> Result {
    flags.begin(session)?;
    let sample = Picture::load(sample)?;
    session.parameter("frame", frame.display().to_string());
    let frame = flags.load(frame)?;
    fits(&frame)?;
    let pixels = flags.meter.pixels(&frame, |_, _| true)?;
    session.phase("load");
    let mut device = session.open_device()?;
    let meter = Meter::new(&flags.meter, &device)?;
    session.phase("setup");
    let source = meter.source(&mut device, &sample)?;
    let nearest = meter.nearest(session, &mut device, &source, &frame, &pixels)?;
    let figures = figures(&value(&nearest, &pixels), &sample, &frame)?;
    session.phase("measure");
    let mut outputs = Outputs::default();
    if let Some(map) = &flags.map {
        let grid = Grid::new(&frame, flags.meter.block_size, flags.map_step, |_, _| true);
        let nearest = meter.nearest(session, &mut device, &source, &frame, grid.pixels())?;
        let picture = grid.map(&value(&nearest, grid.pixels()))?.picture();
        outputs.add(map, encode(picture, format_of(map)?)?);
        session.phase("map");
    }
    session.take_times(&mut device.runner);
    finish(session, outputs, &figures)
}

fn between_frames(args: &CoherenceArgs, session: &mut Session) -> Result {
    let flags = &args.common;
    session.parameter("measure", "coherence");
    session.parameter("frame", args.frame.display().to_string());
    session.parameter("next", args.next.display().to_string());
    flags.begin(session)?;
    let frame = flags.load(&args.frame)?;
    let next = flags.load(&args.next)?;
    check_size(&args.next, (next.width(), next.height()), &frame)?;
    let motion = args.motion.as_ref().map(Motion::load).transpose()?;
    if let (Some(motion), Some(path)) = (&motion, &args.motion) {
        session.parameter("motion", path.display().to_string());
        check_size(path, motion.size(), &frame)?;
    }
    session.phase("load");
    let mut device = session.open_device()?;
    let meter = Meter::new(&flags.meter, &device)?;
    session.phase("setup");
    let mut figures = Figures::default();
    let block_px = flags.meter.block_size;
    let in_next = Eligible::new(&next, block_px);
    let still = |x: u32, y: u32| in_next.contains(x, y).then_some((x, y));
    let moved =
        |x: u32, y: u32| motion.as_ref().and_then(|motion| motion.pixel(x, y)).filter(|&(x, y)| in_next.contains(x, y));
    let measure = |device: &mut _, pixels: &[(u32, u32)], to: &dyn Fn(u32, u32) -> Option<(u32, u32)>| {
        let there: Vec<(u32, u32)> = pixels.iter().filter_map(|&(x, y)| to(x, y)).collect();
        let (first, second) = (meter.features(device, &frame, pixels)?, meter.features(device, &next, &there)?);
        Ok::<_, Failure>(coherence(&first, &second, block_px))
    };
    let pixels = flags.meter.pixels(&frame, |x, y| still(x, y).is_some())?;
    figures.score("coherence_image_space", &measure(&mut device, &pixels, &still)?);
    if motion.is_some() {
        let pixels = flags.meter.pixels(&frame, |x, y| moved(x, y).is_some())?;
        figures.score("coherence_object_space", &measure(&mut device, &pixels, &moved)?);
    }
    figures.number("flip", flip(&frame, &next, &FlipParams::default())?.mean);
    session.phase("measure");
    let mut outputs = Outputs::default();
    if let Some(map) = &flags.map {
        // On the surface, if its motion is known.
        let to: &dyn Fn(u32, u32) -> Option<(u32, u32)> = if motion.is_some() { &moved } else { &still };
        let grid = Grid::new(&frame, block_px, flags.map_step, |x, y| to(x, y).is_some());
        let picture = grid.map(&measure(&mut device, grid.pixels(), to)?)?.picture();
        outputs.add(map, encode(picture, format_of(map)?)?);
        session.phase("map");
    }
    session.take_times(&mut device.runner);
    finish(session, outputs, &figures)
}

fn finish(session: &mut Session, outputs: Outputs, figures: &Figures) -> Result {
    let mut table = Table::new(FIGURE_HEADERS);
    figures.rows(&mut table);
    session.result("figures", figures.json(), table.text().trim_end().to_owned());
    session.wrote(outputs.commit()?);
    session.phase("write");
    Ok(())
}

impl MeasureFlags {
    /// Checks the outputs, and reports the flags.
    fn begin(&self, session: &mut Session) -> Result {
        if let Some(map) = &self.map {
            format_of(map)?;
            check_file(map)?;
        }
        session.parameter("mask", self.mask.as_ref().map(|path| path.display().to_string()));
        self.meter.report(session);
        Ok(())
    }

    /// A frame with the mask.
    fn load(&self, path: &Path) -> Result<Picture> {
        let frame = Picture::load(path)?;
        let Some(mask) = &self.mask else { return Ok(frame) };
        let picture = Picture::load(mask)?;
        check_size(mask, (picture.width(), picture.height()), &frame)?;
        Ok(frame.masked(&picture)?)
    }
}

fn check_size(path: &Path, (width, height): (u32, u32), frame: &Picture) -> Result {
    if (width, height) == (frame.width(), frame.height()) {
        return Ok(());
    }
    let text = format!("has {width} x {height} pixels, but the frame has {} x {}", frame.width(), frame.height());
    Err(Failure::file(path, text))
}
