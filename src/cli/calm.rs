//! `impasto measure calm`: one short animation, painted in every way, and how calm it is in each.
//!
//! ```text
//! frame by frame: Seen -> Motion; each Row draws -> frame_difference to its frame before
//! first and last frame: texture alone -> sharpness, stroke_size; last frame: similarity
//! ```
//!
//! All ways go through the frames side by side, so that no more than two frames of each are kept.

use super::compare::TECHNIQUES;
use super::failure::{Failure, Result};
use super::frames::Frames;
use super::image_frames::{CoherenceLimits, Continuity, NextFrame};
use super::meter::{check_room, frame_picture, quantile, sample_picture, Figures, Meter, SearchFlags, Seen, TestFlags};
use super::motion::MotionFlags;
use super::painter::{Painter, Scene};
use super::session::{Device, Session};
use super::shot::{Shot, ShotFlags};
use super::table::{Cell, Table};
use super::techniques::{Technique, TechniqueName};
use clap::Args;
use impasto::metric::{frame_difference, sharpness, similarity, stroke_size, Motion, Picture, Score};
use impasto::technique::Show;
use serde_json::{json, Value};
use std::path::PathBuf;
use std::time::Instant;

/// A way to paint an animation.
#[derive(Debug)]
struct Way {
    name: &'static str,
    technique: TechniqueName,
    /// Whether texture follows the model, where the technique can do that.
    follows: bool,
    /// How image-based frames keep to the one before, if those are they.
    image: fn(&CoherenceLimits) -> Continuity,
}

/// All of them.
static WAYS: [Way; 9] = [
    Way::new("object", TechniqueName::Object),
    Way::image(ANEW, |_| Continuity::Anew),
    Way::image("image match", |limits| limits.matching(1)),
    Way::image("image match, blend 4", |limits| limits.matching(4)),
    Way::image("image carry", CoherenceLimits::carrying),
    Way::new("aligned following", TechniqueName::Aligned),
    Way { follows: false, ..Way::new("aligned still", TechniqueName::Aligned) },
    Way::new("dependent", TechniqueName::Dependent),
    Way { follows: false, ..Way::new("dependent, chosen anew", TechniqueName::Dependent) },
];

impl Way {
    const fn new(name: &'static str, technique: TechniqueName) -> Self {
        Way { name, technique, follows: true, image: |_| Continuity::Anew }
    }

    const fn image(name: &'static str, image: fn(&CoherenceLimits) -> Continuity) -> Self {
        Way { image, ..Way::new(name, TechniqueName::Image) }
    }
}

/// The way without any coherence, synthesised for every frame alone: what the others are compared with.
const ANEW: &str = "image anew";

/// The columns beside the way's name: header, figure, decimals.
const COLUMNS: [(&str, &str, usize); 12] = [
    ("nearest", "difference_nearest", 4),
    ("of anew", "difference_nearest_of_anew", 3),
    ("bilinear", "difference_bilinear", 4),
    ("of anew", "difference_bilinear_of_anew", 3),
    ("sharp first", "sharpness_first", 4),
    ("last", "sharpness_last", 4),
    ("ratio", "sharpness_ratio", 3),
    ("stroke first", "stroke_px_first", 2),
    ("last", "stroke_px_last", 2),
    ("ratio", "stroke_px_ratio", 3),
    ("similarity", "similarity", 4),
    ("ms a frame", "median_ms", 1),
];

/// Flags of `impasto measure calm`.
#[derive(Args, Debug)]
#[command(mut_arg("orbit", |arg| arg.default_value("1")), mut_arg("size", |arg| arg.default_value("512x512")))]
pub struct CalmArgs {
    /// First and last frame, two at least
    #[arg(long, value_name = "FIRST..LAST", default_value = "0..11", allow_hyphen_values = true)]
    frames: Frames,
    /// Only this way of painting, by its name in the table; repeat for more
    #[arg(long = "way", value_name = "NAME", value_parser = way)]
    ways: Vec<&'static Way>,
    #[command(flatten)]
    motion: MotionFlags,
    #[command(flatten)]
    limits: CoherenceLimits,
    #[command(flatten)]
    test: TestFlags,
    #[command(flatten)]
    search: SearchFlags,
    #[command(flatten)]
    shot: ShotFlags,
}

/// Reads the name of a way.
fn way(text: &str) -> std::result::Result<&'static Way, String> {
    let named = || WAYS.iter().map(|way| format!("'{}'", way.name)).collect::<Vec<_>>().join(", ");
    WAYS.iter().find(|way| way.name == text).ok_or_else(|| format!("must be one of {}", named()))
}

/// A way at work, and what was measured of it so far.
struct Row<'a> {
    way: &'static Way,
    painter: Painter<'a>,
    frame: Option<Picture>,
    /// Difference of each two frames at the same surface points: to the nearest pixel, and bilinear.
    differences: [Vec<f64>; 2],
    /// Sharpness of the first and the last frame, and size of strokes.
    textures: Vec<(f64, Option<f64>)>,
    seconds: Vec<f64>,
    similarity: Vec<f64>,
}

/// Measures.
pub fn run(args: &CalmArgs, session: &mut Session) -> Result {
    if args.frames.count() < 2 {
        return Err(Failure::new(format!("--frames is {}, but must have two frames at least", args.frames)));
    }
    let shot = args.shot.load(&TECHNIQUES, session)?;
    let sample = args.sample(&shot, session)?;
    let moves = args.motion.load(&shot, args.shot.view.axis(), args.frames, session)?;
    let at = |number: u32| moves.at(number, &shot.mesh);
    session.parameter("measure", "calm");
    session.parameter("way", args.ways.iter().map(|way| way.name).collect::<Vec<_>>());
    session.parameter("frames", args.frames.to_string());
    args.test.report(session);
    args.search.report(session);
    for way in args.chosen_ways() {
        (way.image)(&args.limits).check(args.shot.quilting.block, session)?;
    }
    session.phase("load");

    let mut device = session.open_device()?;
    device.check_size(args.shot.size)?;
    session.phase("setup");
    let scene = Scene { mesh: &shot.mesh, moment: at(args.frames.first)?, size: args.shot.size };
    let mut rows = Vec::with_capacity(WAYS.len());
    for way in args.chosen_ways() {
        let mut chosen = args.shot.choose(way.technique, &shot)?;
        if let Technique::Image(continuity) = &mut chosen.technique {
            *continuity = (way.image)(&args.limits);
        }
        rows.push(Row::new(way, Painter::new(session, &mut device, &scene, &shot.paints, &chosen)?));
    }
    session.phase("prepare");

    let progress = session.frames("painting", args.frames.count() as usize * rows.len());
    let mut before: Option<Seen> = None;
    for number in args.frames.first..=args.frames.last {
        let moment = at(number)?;
        let ahead = |to: u32| moves.ahead(number, to.min(args.frames.last), &shot.mesh);
        let cut = number == args.frames.first || moves.is_cut(number);
        let seen = Seen::new(&shot.mesh, &moment, args.shot.size)?;
        let motion = before.as_ref().filter(|_| !cut).map(|before| before.motion_to(&seen)).transpose()?;
        for row in &mut rows {
            let fresh = cut || !row.way.follows;
            let next = NextFrame { moment: &moment, number, fresh, shown: true, ahead: &ahead };
            let frame = row.draw(&mut device, &next)?;
            row.take(frame, motion.as_ref())?;
            if number == args.frames.first || number == args.frames.last {
                row.look_at_texture(seen.objects(), &mut device)?;
            }
            progress.step();
        }
        before = Some(seen);
    }
    drop(progress);
    session.phase("paint");

    if let Some((path, sample)) = &sample {
        let meter = Meter::new(&args.search, &device)?;
        let strip = meter.strip(&mut device, path, sample, args.test.block_size)?;
        for row in &mut rows {
            let Some(frame) = &row.frame else { continue };
            let pixels = args.test.pixels(frame, "", |_, _| true)?;
            row.similarity = similarity(&meter.nearest(session, &mut device, &strip, frame, &pixels)?);
        }
    }
    session.phase("measure");
    session.take_times(&mut device.runner);
    report(&rows, session);
    Ok(())
}

impl CalmArgs {
    /// The ways to measure, in the order of the table.
    fn chosen_ways(&self) -> impl Iterator<Item = &'static Way> + '_ {
        WAYS.iter().filter(|way| self.ways.is_empty() || self.ways.iter().any(|one| one.name == way.name))
    }

    /// The strip that similarity is measured against, with its file; none where there are several.
    fn sample(&self, shot: &Shot, session: &mut Session) -> Result<Option<(PathBuf, Picture)>> {
        let mut strips = shot.paints.strips();
        let (Some((path, strip)), None) = (strips.next(), strips.next()) else {
            session.warn("similarity is left out: it takes one strip for all objects");
            return Ok(None);
        };
        let sample = sample_picture(&strip.sample)?;
        check_room(path, &sample, self.test.block_size)?;
        Ok(Some((path.to_owned(), sample)))
    }
}

impl<'a> Row<'a> {
    fn new(way: &'static Way, painter: Painter<'a>) -> Self {
        let (differences, textures) = Default::default();
        Row { way, painter, frame: None, differences, textures, seconds: Vec::new(), similarity: Vec::new() }
    }

    /// Goes on to the next frame, and takes its time.
    fn draw(&mut self, device: &mut Device, next: &NextFrame<'_>) -> Result<Picture> {
        let started = Instant::now();
        self.painter.advance(None, device, next)?;
        let frame = self.painter.frame(device, Show::Painted)?;
        self.seconds.push(started.elapsed().as_secs_f64());
        frame_picture(&frame)
    }

    /// Compares the next frame with the one before it, which `motion` leads from.
    fn take(&mut self, next: Picture, motion: Option<&Motion>) -> Result {
        if let (Some(frame), Some(motion)) = (&self.frame, motion) {
            let found = frame_difference(frame, &next, motion)?;
            self.differences[0].push(found.nearest);
            self.differences[1].push(found.bilinear);
        }
        self.frame = Some(next);
        Ok(())
    }

    fn look_at_texture(&mut self, objects: &[u32], device: &mut Device) -> Result {
        let texture = frame_picture(&self.painter.frame(device, Show::Texture)?)?;
        self.textures.push((sharpness(&texture, objects)?, stroke_size(&texture, objects)?));
        Ok(())
    }

    /// What was measured; `anew` are the mean differences of frames without any coherence.
    fn figures(&self, anew: [Option<f64>; 2]) -> Figures {
        let mut figures = Figures::default();
        let mut number = |name: &str, value: Option<f64>| {
            if let Some(value) = value {
                figures.number(name, value);
            }
        };
        let names = ["difference_nearest", "difference_bilinear"];
        for ((name, mean), anew) in names.into_iter().zip(self.mean_differences()).zip(anew) {
            number(name, mean);
            number(&format!("{name}_of_anew"), ratio(mean, anew));
        }
        let (first, last) = (self.textures.first(), self.textures.last());
        let sharp = [first, last].map(|texture| texture.map(|texture| texture.0));
        let stroke = [first, last].map(|texture| texture.and_then(|texture| texture.1));
        for (name, [first, last]) in [("sharpness", sharp), ("stroke_px", stroke)] {
            number(&format!("{name}_first"), first);
            number(&format!("{name}_last"), last);
            number(&format!("{name}_ratio"), ratio(last, first));
        }
        number("median_ms", quantile(&self.seconds, 0.5).map(|seconds| seconds * 1e3));
        figures.score("similarity", &self.similarity);
        figures
    }

    fn mean_differences(&self) -> [Option<f64>; 2] {
        self.differences.each_ref().map(|values| Score::of(values).map(|score| score.mean))
    }
}

/// How large a value is in the other; none where that is nothing.
fn ratio(value: Option<f64>, of: Option<f64>) -> Option<f64> {
    Some(value? / of.filter(|of| *of > 0.0)?)
}

fn report(rows: &[Row], session: &mut Session) {
    let anew = rows.iter().find(|row| row.way.name == ANEW);
    let anew = anew.map_or([None; 2], Row::mean_differences);
    let mut table = Table::new(std::iter::once("way").chain(COLUMNS.map(|(header, ..)| header)));
    let mut found: Vec<Value> = Vec::new();
    for row in rows {
        let figures = row.figures(anew);
        let cell = |(_, name, decimals): (&str, &str, usize)| {
            figures.get(name).map_or(Cell::Missing, |value| Cell::Number(value, decimals))
        };
        table.row(std::iter::once(row.way.name.into()).chain(COLUMNS.map(cell)));
        found.push(json!({ "technique": row.way.name, "figures": figures.json() }));
    }
    session.result("figures", found, table.text().trim_end());
}
