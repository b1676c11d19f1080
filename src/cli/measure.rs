//! `impasto measure`: the metrics of chapter 9, and newer ones, on any pictures of up to 4096 pixels a side.

use super::calm::{self, CalmArgs};
use super::failure::{Failure, Result};
use super::files::{check_file, Outputs};
use super::meter::{check_room, load_sample, Figures, Grid, Meter, Pair, SearchFlags, TestFlags, FIGURE_HEADERS};
use super::metric_tests::{self, MetricTestsArgs};
use super::picture::{encode, format_of};
use super::session::Session;
use super::table::Table;
use clap::{Args, Subcommand};
use impasto::metric::{flip, shading_error, similarity, FlipParams, Motion, Neighbour, Picture, Shades};
use std::path::{Path, PathBuf};

/// Flags of `impasto measure`.
#[derive(Args, Debug)]
pub struct MeasureArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand, Debug)]
enum What {
    /// How much the texture of a frame looks like the sample's (thesis 9.1), with co-occurrence error and sliced
    /// Wasserstein distance
    Similarity(SimilarityArgs),
    /// How far the texture's place in the strip is from the shade that it should show (thesis 9.2)
    Shading(ShadingArgs),
    /// How much a frame changes to the next, in the picture and on the surface (thesis 9.3), with FLIP
    Coherence(CoherenceArgs),
    /// How calm an animation is with each way of painting, and whether its strokes stay as they are
    Calm(Box<CalmArgs>),
    /// What the measure of similarity says of textures that are wrong in known ways (thesis 9.1.1 to 9.1.3)
    Tests(MetricTestsArgs),
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
    search: SearchFlags,
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
    /// The shade of each pixel, black to white, like the shade.png of `render --dump`; none where it is transparent
    #[arg(long, value_name = "SHADE.png")]
    shade: PathBuf,
    #[command(flatten)]
    search: SearchFlags,
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
    /// Where each pixel's surface has moved, for coherence in object space: 16 bits, red 32768 + 64 times the pixels to
    /// the right, green the same downwards, blue 0 where the next frame does not show it; as `compare` writes it
    #[arg(long, value_name = "MOTION.png")]
    motion: Option<PathBuf>,
    #[command(flatten)]
    common: MeasureFlags,
}

#[derive(Args, Debug)]
struct MeasureFlags {
    /// Which pixels of the frame (and of the next) belong to the object, white on black [default: those that are
    /// opaque]
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
    test: TestFlags,
}

/// Measures.
pub fn run(args: &MeasureArgs, session: &mut Session) -> Result {
    match &args.what {
        What::Similarity(args) => {
            session.parameter("measure", "similarity");
            let value = |nearest: &[Vec<Neighbour>], _: &[(u32, u32)], _: u32| similarity(nearest);
            let figures = |values: &[f64], sample: &Picture, frame: &Picture, session: &mut Session| {
                let mut figures = Figures::default();
                figures.score("similarity", values);
                figures.textures(sample, frame, session);
                figures
            };
            let paths = (&args.sample, &args.frame);
            against_sample(paths, (&args.common, &args.search), None, session, value, figures)
        }
        What::Shading(args) => {
            session.parameter("measure", "shading");
            session.parameter("shade", args.shade.display().to_string());
            let shades = Shades::load(&args.shade)?;
            let value = |nearest: &[Vec<Neighbour>], pixels: &[(u32, u32)], width: u32| {
                let wanted: Vec<f64> = pixels.iter().map(|&(x, y)| shades.at(x, y).unwrap_or_default()).collect();
                shading_error(nearest, width, &wanted).into_iter().map(f64::abs).collect()
            };
            let figures = |values: &[f64], _: &Picture, _: &Picture, _: &mut Session| {
                let mut figures = Figures::default();
                shading_figures(&mut figures, values);
                figures
            };
            let (paths, shades) = ((&args.strip, &args.frame), Some((args.shade.as_path(), &shades)));
            against_sample(paths, (&args.common, &args.search), shades, session, value, figures)
        }
        What::Coherence(args) => between_frames(args, session),
        What::Calm(args) => calm::run(args, session),
        What::Tests(args) => metric_tests::run(args, session),
    }
}

/// The two ways to read the thesis's shading error.
pub fn shading_figures(figures: &mut Figures, errors: &[f64]) {
    figures.score("shading_error_absolute", &errors.iter().map(|error| error.abs()).collect::<Vec<_>>());
    figures.score("shading_error_squared", &errors.iter().map(|error| error.powi(2)).collect::<Vec<_>>());
}

/// Measures a frame against a sample: `value` of the nearest of the tested pixels, the pixels and the sample's width,
/// and `figures` of those values. With shades only pixels that have one are tested.
fn against_sample(
    (sample_path, frame_path): (&PathBuf, &PathBuf),
    (flags, search): (&MeasureFlags, &SearchFlags),
    shades: Option<(&Path, &Shades)>,
    session: &mut Session,
    value: impl Fn(&[Vec<Neighbour>], &[(u32, u32)], u32) -> Vec<f64>,
    figures: impl Fn(&[f64], &Picture, &Picture, &mut Session) -> Figures,
) -> Result {
    session.parameter("sample", sample_path.display().to_string());
    session.parameter("frame", frame_path.display().to_string());
    flags.begin(session)?;
    search.report(session);
    let block_px = flags.test.block_size;
    let sample = load_sample(sample_path)?;
    check_room(sample_path, &sample, block_px)?;
    let frame = flags.load(frame_path)?;
    if let Some((path, shades)) = shades {
        check_size(path, shades.size(), &frame)?;
    }
    let has_shade = |x: u32, y: u32| shades.is_none_or(|(_, shades)| shades.at(x, y).is_some());
    let mut reason = flags.reason(frame_path);
    if let Some((path, _)) = shades {
        reason.push_str(&format!(" where {} has a shade", path.display()));
    }
    let pixels = flags.test.pixels(&frame, &reason, has_shade)?;
    session.phase("load");
    let mut device = session.open_device()?;
    let meter = Meter::new(search, &device)?;
    session.phase("setup");
    let strip = meter.strip(&mut device, sample_path, &sample, block_px)?;
    let nearest = meter.nearest(session, &mut device, &strip, &frame, &pixels)?;
    let figures = figures(&value(&nearest, &pixels, strip.width()), &sample, &frame, session);
    session.phase("measure");
    let mut outputs = Outputs::default();
    if let Some(map) = &flags.map {
        let grid = Grid::new(&frame, block_px, flags.map_step, has_shade)?;
        let nearest = meter.nearest(session, &mut device, &strip, &frame, grid.pixels())?;
        let picture = grid.map(&value(&nearest, grid.pixels(), strip.width()))?.picture();
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
    let block_px = flags.test.block_size;
    let pair = Pair::new(&frame, &next, block_px);
    let reason = format!("{} and of {}", flags.reason(&args.frame), args.next.display());
    let still = flags.test.pixels(&frame, &reason, |x, y| pair.place(None, x, y).is_some())?;
    let moved = match (&motion, &args.motion) {
        (Some(motion), Some(path)) => {
            let reason = format!("{reason}, moved as {} says", path.display());
            Some((motion, flags.test.pixels(&frame, &reason, |x, y| pair.place(Some(motion), x, y).is_some())?))
        }
        _ => None,
    };
    session.phase("load");
    let mut device = session.open_device()?;
    let meter = Meter::of_frames(&device)?;
    session.phase("setup");
    let mut figures = Figures::default();
    figures.score("coherence_image_space", &pair.coherence(&meter, &mut device, None, &still)?);
    if let Some((motion, pixels)) = &moved {
        figures.score("coherence_object_space", &pair.coherence(&meter, &mut device, Some(motion), pixels)?);
    }
    figures.number("flip", flip(&frame, &next, &FlipParams::default())?.mean);
    session.phase("measure");
    let mut outputs = Outputs::default();
    if let Some(map) = &flags.map {
        // On the surface, if its motion is known.
        let motion = motion.as_ref();
        let grid = Grid::new(&frame, block_px, flags.map_step, |x, y| pair.place(motion, x, y).is_some())?;
        let picture = grid.map(&pair.coherence(&meter, &mut device, motion, grid.pixels())?)?.picture();
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
        self.test.report(session);
        Ok(())
    }

    /// What an error about pixels ends with: of which frame and mask.
    fn reason(&self, frame: &Path) -> String {
        let masked = self.mask.as_ref().map(|mask| format!(" as {} masks it", mask.display()));
        format!(" of {}{}", frame.display(), masked.unwrap_or_default())
    }

    /// A frame with the mask.
    fn load(&self, path: &Path) -> Result<Picture> {
        let frame = Picture::load(path)?;
        check_room(path, &frame, self.test.block_size)?;
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
