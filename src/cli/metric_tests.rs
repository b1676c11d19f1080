//! `impasto measure tests`: what the texture metric says of textures that are wrong in known ways (thesis 9.1.1 to
//! 9.1.3).
//!
//! Each [`Curve`] takes one texture, makes copies of it that are more and more turned, stretched or badly put together,
//! and measures every copy against the texture itself. The curves go to files, to a page and into the report.

use super::failure::{Failure, Result};
use super::files::{check_folder, Outputs};
use super::meter::sample_picture;
use super::metric_tests_page as page;
use super::session::{device_json, Device, Session};
use clap::Args;
use impasto::metric::series::{poorly_sampled, rotated, scaled, TestTexture};
use impasto::metric::{choose, similarity, BlockSearch, Eligible, Picture, Score, Source};
use impasto::paint::PaintSample;
use serde_json::{json, Value};
use std::path::{Path, PathBuf};

/// Side of the program's own textures, which are searched quickly.
const SIDE_PX: u32 = 128;
/// Sides that a texture from a file may have: half of it still holds a block, and its search stays quick.
const OWN_SIDE_PX: std::ops::RangeInclusive<u32> = 64..=512;
/// The thesis shows stretching for this block size only.
const SCALE_BLOCK_PX: u32 = 8;

/// Flags of `impasto measure tests`.
#[derive(Args, Debug)]
pub struct MetricTestsArgs {
    /// Folder for index.html, the plots, tests.csv and tests.json
    #[arg(short, long, value_name = "DIR", default_value = "metric-tests")]
    output: PathBuf,
    /// Square picture to test with as well, with sides of 64 to 512 pixels
    #[arg(long, value_name = "FILE")]
    texture: Option<PathBuf>,
    /// Sides of the metric's blocks in pixels, 4 to 12
    #[arg(long, value_name = "PX,PX", value_delimiter = ',', default_value = "4,8,12",
          value_parser = clap::value_parser!(u32).range(4..=12))]
    block_sizes: Vec<u32>,
    /// How many pixels of each copy are measured, 2 to 10000, or all if it has fewer
    #[arg(long, value_name = "NUMBER", default_value_t = 100, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    samples: u32,
    /// Over how many of the nearest source pixels a pixel's error is the mean, 1 to 32
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=32))]
    nearest: u32,
    /// Makes the textures, chooses pixels and blocks; the same seed gives the same numbers
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    seed: u32,
}

/// In which way the copies of a texture are wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Test {
    /// Turned, by degrees (9.1.1).
    Rotation,
    /// Stretched, by a factor (9.1.2).
    Scale(Direction),
    /// Put together of blocks, of a side in pixels (9.1.3).
    Sampling,
}

/// What is stretched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Rows.
    X,
    /// Columns.
    Y,
    /// Both alike.
    Both,
}

/// A texture.
pub struct Subject {
    /// What it is called.
    pub name: &'static str,
    /// Its pixels.
    pub picture: Picture,
    /// Whether it is stretched and badly sampled, too: as in the thesis the random one, and the one that was given.
    pub in_all_tests: bool,
}

/// How a texture's error grows.
pub struct Curve {
    /// With what.
    pub test: Test,
    /// Which texture's.
    pub texture: &'static str,
    /// Side of the metric's blocks.
    pub block_px: u32,
    /// Values of what changes, and the error there.
    pub points: Vec<(f64, Score)>,
}

impl Test {
    /// Its name, that of what changes, and the stretched direction.
    pub fn words(self) -> (&'static str, &'static str, Option<&'static str>) {
        match self {
            Test::Rotation => ("rotation", "angle_deg", None),
            Test::Scale(Direction::X) => ("scale", "factor", Some("x")),
            Test::Scale(Direction::Y) => ("scale", "factor", Some("y")),
            Test::Scale(Direction::Both) => ("scale", "factor", Some("both")),
            Test::Sampling => ("sampling", "pasted_block_px", None),
        }
    }

    /// Of what copies are made: every 15 degrees of half a turn; every quarter of an octave from half to twice; 8
    /// sizes.
    fn values(self) -> Vec<f64> {
        match self {
            Test::Rotation => (0..=12).map(|step| f64::from(step * 15)).collect(),
            Test::Scale(_) => (-4..=4).map(|step| (f64::from(step) / 4.0).exp2()).collect(),
            Test::Sampling => (1..=8).map(|step| f64::from(step * 4)).collect(),
        }
    }

    /// The copy for one value.
    pub fn copy(self, picture: &Picture, value: f64, seed: u32) -> Result<Picture> {
        Ok(match self {
            Test::Rotation => rotated(picture, value.to_radians()),
            Test::Scale(Direction::X) => scaled(picture, value, 1.0)?,
            Test::Scale(Direction::Y) => scaled(picture, 1.0, value)?,
            Test::Scale(Direction::Both) => scaled(picture, value, value)?,
            Test::Sampling => poorly_sampled(picture, value as u32, seed)?,
        })
    }
}

/// Tests.
pub fn run(args: &MetricTestsArgs, session: &mut Session) -> Result {
    check_folder(&args.output)?;
    let subjects = subjects(args)?;
    let mut block_sizes = args.block_sizes.clone();
    block_sizes.sort_unstable();
    block_sizes.dedup();
    let parameters = json!({
        "measure": "tests",
        "texture": args.texture.as_ref().map(|path| path.display().to_string()),
        "texture_px": SIDE_PX,
        "block_sizes": block_sizes,
        "samples": args.samples,
        "nearest": args.nearest,
        "seed": args.seed,
    });
    for (name, value) in parameters.as_object().into_iter().flatten() {
        session.parameter(name, value.clone());
    }
    session.phase("load");
    let mut device = session.open_device()?;
    let search = BlockSearch::new(&device.context, args.nearest)?;
    session.phase("setup");

    let mut curves = planned(&subjects, &block_sizes);
    let progress = session.progress("measuring", curves.iter().map(|(_, curve)| curve.test.values().len()).sum());
    for (subject, curve) in &mut curves {
        let source = search.source(&mut device.runner, &subject.picture, curve.block_px)?;
        for value in curve.test.values() {
            let copy = curve.test.copy(&subject.picture, value, args.seed)?;
            curve.points.push((value, measure(args, &mut device, &search, &source, &copy)?));
            progress.step();
        }
    }
    drop(progress);
    session.take_times(&mut device.runner);
    session.phase("measure");

    let curves: Vec<Curve> = curves.into_iter().map(|(_, curve)| curve).collect();
    let info = device.context.device_info();
    let found: Vec<Value> = curves.iter().map(curve_json).collect();
    let document = json!({
        "tool": "impasto",
        "version": env!("CARGO_PKG_VERSION"),
        "device": device_json(info),
        "parameters": parameters,
        "curves": found,
    });
    let mut outputs = Outputs::default();
    let place = |name: &str| args.output.join(name);
    outputs.add(place("tests.json"), format!("{document:#}\n"));
    outputs.add(place("tests.csv"), page::table(&curves).csv());
    let plots = page::plots(&curves, args.nearest)?;
    for plot in &plots {
        outputs.add(place(&plot.file), plot.svg.as_str());
    }
    let definitions = page::definitions(&parameters, &info.name);
    outputs.add(place("index.html"), page::html(&subjects, &curves, &plots, &definitions, args.seed)?);
    session.result("curves", found, page::summary(&curves).text().trim_end());
    session.wrote(outputs.commit()?);
    session.closing_line(format!("see {}", place("index.html").display()));
    session.phase("write");
    Ok(())
}

/// The three textures, and the one that was given.
fn subjects(args: &MetricTestsArgs) -> Result<Vec<Subject>> {
    let mut subjects = Vec::new();
    for texture in TestTexture::ALL {
        let picture = texture.picture(SIDE_PX, args.seed)?;
        subjects.push(Subject { name: texture.name(), picture, in_all_tests: texture == TestTexture::Random });
    }
    if let Some(path) = &args.texture {
        subjects.push(Subject { name: "own", picture: load(path)?, in_all_tests: true });
    }
    Ok(subjects)
}

fn load(path: &Path) -> Result<Picture> {
    let sample = PaintSample::load(path)?;
    let (width, height) = (sample.width(), sample.height());
    if width != height || !OWN_SIDE_PX.contains(&width) {
        let (least, most) = OWN_SIDE_PX.into_inner();
        let reason = format!("{width}x{height} pixels, but must be a square with sides of {least} to {most} pixels");
        return Err(Failure::file(path, reason));
    }
    sample_picture(&sample)
}

/// All curves, still without points.
fn planned<'a>(subjects: &'a [Subject], block_sizes: &[u32]) -> Vec<(&'a Subject, Curve)> {
    let mut planned = Vec::new();
    let mut plan = |test, subject: &'a Subject, block_px| {
        planned.push((subject, Curve { test, texture: subject.name, block_px, points: Vec::new() }));
    };
    for subject in subjects {
        block_sizes.iter().for_each(|&block_px| plan(Test::Rotation, subject, block_px));
    }
    for subject in subjects.iter().filter(|subject| subject.in_all_tests) {
        for direction in [Direction::X, Direction::Y, Direction::Both] {
            plan(Test::Scale(direction), subject, SCALE_BLOCK_PX);
        }
        block_sizes.iter().for_each(|&block_px| plan(Test::Sampling, subject, block_px));
    }
    planned
}

/// The mean error of some of a copy's pixels (section 9.1).
fn measure(
    args: &MetricTestsArgs,
    device: &mut Device,
    search: &BlockSearch,
    source: &Source,
    copy: &Picture,
) -> Result<Score> {
    let eligible = Eligible::new(copy, source.block_px()).all(|_, _| true);
    let pixels = choose(eligible, args.samples as usize, args.seed);
    let tested = search.features(&mut device.runner, copy, source.block_px(), &pixels)?;
    let nearest = search.nearest(&mut device.runner, source, &tested)?;
    Score::of(&similarity(&nearest)).ok_or_else(|| Failure::new("no pixel of a copy can be measured"))
}

fn curve_json(curve: &Curve) -> Value {
    let (test, variable, direction) = curve.test.words();
    let point = |(value, score): &(f64, Score)| json!({ variable: value, "error": score.mean, "half_width": score.half_width, "samples": score.count });
    let points: Vec<Value> = curve.points.iter().map(point).collect();
    let mut whole = json!({ "test": test, "texture": curve.texture, "block_px": curve.block_px, "points": points });
    if let Some(direction) = direction {
        whole["direction"] = direction.into();
    }
    whole
}
