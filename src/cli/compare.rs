//! `impasto compare`: all techniques, still and moving, measured alike, and one report (thesis chapter 10).

use super::builtin::{builtin_model, builtin_strip};
use super::compare_page::{self, Report};
use super::error_map::ErrorMap;
use super::failure::{Failure, Result};
use super::files::{check_folder, Outputs};
use super::image_frames::NextFrame;
use super::measure::shading_figures;
use super::meter::{
    check_room, frame_picture, sample_picture, Figures, Grid, Meter, Pair, SearchFlags, Seen, Strip as Source,
    TestFlags,
};
use super::painter::{Painter, Scene};
use super::paints::Paints;
use super::picture::{gray_png, over, png, png16};
use super::quilting::Quilting;
use super::session::{Device, Session};
use super::shot::load_model;
use super::strips::{Strip, StripFlags};
use super::techniques::{TechniqueName, TechniqueOptions};
use super::values::{finite, Size};
use super::view::ViewFlags;
use clap::Args;
use impasto::metric::{flip, shading_error, similarity, FlipParams, Motion, Picture, BLOCK_PX};
use impasto::paint::PaintSample;
use impasto::scene::{Mesh, Moment};
use impasto::technique::Show;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The strips that are compared where none is given.
const STRIPS: [&str; 3] = ["strip_green_yellow.png", "strip_dark_red.png", "strip_red_yellow.png"];
const MODEL: &str = "head.obj";
/// All techniques, in the thesis's order.
pub const TECHNIQUES: [TechniqueName; 4] =
    [TechniqueName::Object, TechniqueName::Image, TechniqueName::Aligned, TechniqueName::Dependent];
/// Block sizes of the plot.
pub const PLOTTED: [u32; 3] = [4, 8, 12];

/// Flags of `impasto compare`.
#[derive(Args, Debug)]
pub struct CompareArgs {
    /// Wavefront OBJ model [default: a built-in head]
    #[arg(value_name = "MODEL.obj")]
    model: Option<PathBuf>,
    /// Folder for the report: index.html, figures.csv, figures.json, the frames, shade and motion
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Paint strip; may be repeated [default: three built-in ones]
    #[arg(long = "paint", value_name = "STRIP.png")]
    paints: Vec<PathBuf>,
    /// Size of the frames
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "512x512", allow_hyphen_values = true)]
    size: Size,
    /// How far the camera turns around the model from a frame to the next, in degrees
    #[arg(long, value_name = "DEGREES", value_parser = finite, default_value_t = 1.0, allow_hyphen_values = true)]
    turn: f32,
    #[command(flatten)]
    test: TestFlags,
    #[command(flatten)]
    search: SearchFlags,
    #[command(flatten)]
    strip: StripFlags,
    #[command(flatten)]
    quilting: Quilting,
    #[command(flatten)]
    technique: TechniqueOptions,
    #[command(flatten)]
    view: ViewFlags,
}

/// What all paints are measured with.
struct Stage<'a> {
    args: &'a CompareArgs,
    mesh: &'a Mesh,
    moments: [Moment; 2],
    motion: Motion,
    meter: Meter,
}

/// A paint, ready to be searched.
struct Searched {
    number: usize,
    picture: Picture,
    strip: Source,
    /// At other block sizes, for the plot.
    plotted: Vec<(u32, Source)>,
}

/// One technique with one paint.
pub struct Measured {
    pub paint: usize,
    pub technique: TechniqueName,
    pub figures: Figures,
    /// Similarity at the plotted block sizes.
    pub by_block: Vec<(u32, Vec<f64>)>,
    pub frame: Vec<u8>,
    pub map: ErrorMap,
}

/// Compares.
pub fn run(args: &CompareArgs, session: &mut Session) -> Result {
    check_folder(&args.output)?;
    let lights = args.view.lights()?;
    let (model, mesh) = match &args.model {
        Some(path) => (path.display().to_string(), load_model(path, session)?),
        None => (MODEL.to_owned(), builtin_model(MODEL)?),
    };
    let camera = args.view.camera(&mesh, args.size.aspect())?;
    let cameras = [camera, camera.orbited(args.turn, args.view.axis())?.fit_depth(&mesh)];
    let strips = args.strips(session)?;
    for (name, strip) in &strips {
        let size = (strip.sample.width(), strip.sample.height());
        args.quilting.check(Path::new(name), size, args.size, false)?;
        check_room(Path::new(name), &sample_picture(&strip.sample)?, *BLOCK_PX.end())?;
    }
    for technique in TECHNIQUES {
        args.technique.report(technique, session);
    }
    session.parameter("technique", TECHNIQUES.map(compare_page::word).to_vec());
    args.strip.report(session);
    session.parameter("model", model.clone());
    session.parameter("paint", strips.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>());
    session.parameter("size", args.size.to_string());
    session.parameter("turn", super::report::number(args.turn));
    args.test.report(session);
    args.search.report(session);
    args.quilting.report(session);
    args.view.report(&camera, &lights, session);
    session.phase("load");

    let mut device = session.open_device()?;
    device.check_size(args.size)?;
    session.phase("setup");
    let moments = cameras.map(|camera| Moment::at_rest(camera, lights.clone()));
    let seen = |moment: &Moment| Seen::new(&mesh, moment, args.size);
    let motion = seen(&moments[0])?.motion_to(&seen(&moments[1])?)?;
    let meter = Meter::new(&args.search, &device)?;
    let stage = Stage { args, mesh: &mesh, moments, motion, meter };
    let mut outputs = Outputs::default();
    let (width, height) = args.size.pair();
    outputs.add(args.output.join("motion.png"), png16(width, height, &stage.motion.to_rgb16())?);
    let mut measured = Vec::new();
    let names = names(&strips.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>());
    let pictures = strips.iter().map(|(_, strip)| png(strip.sample.to_image())).collect::<Result<Vec<_>>>()?;
    for (number, (name, strip)) in strips.into_iter().enumerate() {
        let path = PathBuf::from(name);
        let searched = stage.searched(&mut device, number, &path, sample_picture(&strip.sample)?)?;
        let paints = Paints::single(strip, path, &mesh);
        for technique in TECHNIQUES {
            measured.push(stage.measure(session, &mut device, &mut outputs, &paints, &searched, technique)?);
        }
    }
    // One scale for all maps.
    let top = measured.iter().map(|one: &Measured| one.map.top()).fold(0.0, f32::max);
    let mut maps = Vec::with_capacity(measured.len());
    for one in &measured {
        let map = png(one.map.clone().with_top(top).picture())?;
        let name = format!("{}_map.png", file_name(one.paint, one.technique));
        outputs.add(args.output.join(name), map.clone());
        maps.push(map);
    }
    let report = Report {
        model: &model,
        turn_deg: args.turn,
        paints: &names,
        strips: &pictures,
        measured: &measured,
        maps: &maps,
    };
    let parameters = session.parameters_json();
    let device_info = session.device_json();
    outputs.add(args.output.join("figures.csv"), compare_page::csv(&report));
    outputs.add(args.output.join("figures.json"), compare_page::json(&report, &device_info, &parameters));
    let page = compare_page::html(&report, &device_info, &parameters)?;
    outputs.add(args.output.join("index.html"), page);
    session.take_times(&mut device.runner);
    session.attach("findings", compare_page::findings_json(&report));
    session.result("figures", compare_page::figures_json(&report), compare_page::text(&report));
    session.wrote(outputs.commit()?);
    session.phase("write");
    session.closing_line(format!("open {}", args.output.join("index.html").display()));
    Ok(())
}

impl CompareArgs {
    fn strips(&self, session: &mut Session) -> Result<Vec<(String, Strip)>> {
        let mut samples = Vec::new();
        for path in &self.paints {
            let sample = PaintSample::load(path).map_err(|error| Failure::new(format!("--paint: {error}")))?;
            samples.push((path.display().to_string(), sample));
        }
        if samples.is_empty() {
            for name in STRIPS {
                samples.push((name.to_owned(), builtin_strip(name)?));
            }
        }
        let separate = |(name, sample): (String, PaintSample)| {
            let strip = self.strip.separate(sample, &name, session)?;
            Ok((name, strip))
        };
        samples.into_iter().map(separate).collect()
    }
}

impl Stage<'_> {
    fn searched(&self, device: &mut Device, number: usize, path: &Path, picture: Picture) -> Result<Searched> {
        let block_px = self.args.test.block_size;
        let strip = self.meter.strip(device, path, &picture, block_px)?;
        let mut plotted = Vec::new();
        for other in PLOTTED.into_iter().filter(|other| *other != block_px) {
            plotted.push((other, self.meter.strip(device, path, &picture, other)?));
        }
        Ok(Searched { number, picture, strip, plotted })
    }

    fn measure(
        &self,
        session: &mut Session,
        device: &mut Device,
        outputs: &mut Outputs,
        paints: &Paints,
        paint: &Searched,
        technique: TechniqueName,
    ) -> Result<Measured> {
        let args = self.args;
        let chosen = args.technique.choose(technique, &args.quilting, self.mesh, None)?;
        let scene = Scene { mesh: self.mesh, moment: self.moments[0].clone(), size: args.size };
        let started = Instant::now();
        let mut painter = Painter::new(session, device, &scene, paints, &chosen)?;
        painter.advance(Some(session), device, &NextFrame::alone(&self.moments[0], 0))?;
        let first = painter.frame(device, Show::Painted)?;
        let prepared = started.elapsed();
        let shades = painter.shades(device)?;
        if paint.number == 0 && technique == TechniqueName::Image {
            outputs.add(args.output.join("shade.png"), gray_png(painter.shade(device)?)?);
        }
        painter.advance(Some(session), device, &NextFrame::alone(&self.moments[1], 1))?;
        let second = painter.frame(device, Show::Painted)?;
        session.phase("paint");
        let (frame, next) = (frame_picture(&first)?, frame_picture(&second)?);

        let mut figures = Figures::default();
        let block_px = args.test.block_size;
        let pixels = args.test.pixels(&frame, "", |_, _| true)?;
        let nearest = self.meter.nearest(session, device, &paint.strip, &frame, &pixels)?;
        let values = similarity(&nearest);
        figures.score("similarity", &values);
        let shade = |&(x, y): &(u32, u32)| f64::from(shades[(y * args.size.width + x) as usize]);
        let wanted: Vec<f64> = pixels.iter().map(shade).collect();
        shading_figures(&mut figures, &shading_error(&nearest, paint.strip.width(), &wanted));
        let pair = Pair::new(&frame, &next, block_px);
        let motion = Some(&self.motion);
        for (name, motion) in [("coherence_image_space", None), ("coherence_object_space", motion)] {
            let pixels = args.test.pixels(&frame, " of both frames", |x, y| pair.place(motion, x, y).is_some())?;
            figures.score(name, &pair.coherence(&self.meter, device, motion, &pixels)?);
        }
        figures.textures(&paint.picture, &frame, session);
        figures.number("flip", flip(&frame, &next, &FlipParams::default())?.mean);
        figures.number("first_frame_seconds", prepared.as_secs_f64());

        let mut by_block = vec![(block_px, values)];
        for (other, strip) in &paint.plotted {
            let test = TestFlags { block_size: *other, ..args.test.clone() };
            let pixels = test.pixels(&frame, "", |_, _| true)?;
            by_block.push((*other, similarity(&self.meter.nearest(session, device, strip, &frame, &pixels)?)));
        }
        by_block.sort_by_key(|(block, _)| *block);
        let grid = Grid::new(&frame, block_px, None, |_, _| true)?;
        let nearest = self.meter.nearest(session, device, &paint.strip, &frame, grid.pixels())?;
        let map = grid.map(&similarity(&nearest))?;
        session.phase("measure");

        let name = file_name(paint.number, technique);
        outputs.add(args.output.join(format!("{name}.png")), png(first.clone())?);
        outputs.add(args.output.join(format!("{name}_next.png")), png(second)?);
        let frame = png(over(first, [255; 3]))?;
        Ok(Measured { paint: paint.number, technique, figures, by_block, frame, map })
    }
}

fn file_name(paint: usize, technique: TechniqueName) -> String {
    format!("{}_{}", paint + 1, compare_page::word(technique))
}

/// What the paints are called: their files' names without folder and extension, or all of it where two would be the
/// same.
fn names(files: &[&str]) -> Vec<String> {
    let short = |file: &str| {
        let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let bare = stem.strip_prefix("strip_").filter(|rest| !rest.is_empty()).unwrap_or(&stem);
        bare.replace('_', " ")
    };
    let all: Vec<String> = files.iter().map(|file| short(file)).collect();
    let name = |(file, name): (&&str, &String)| match all.iter().filter(|other| *other == name).count() {
        1 => name.clone(),
        _ => (*file).to_owned(),
    };
    files.iter().zip(&all).map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paints_have_names_that_tell_them_apart() {
        assert_eq!(names(&["a/strip_dark_red.png", "b/strip_.png"]), ["dark red", "strip "]);
        assert_eq!(names(&["a/oil.png", "b/oil.png", "oil_2.png"]), ["a/oil.png", "b/oil.png", "oil 2"]);
    }
}
