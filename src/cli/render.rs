//! `impasto render`: a model, shaded with paint.

use super::blocks;
use super::failure::Result;
use super::files::{check_apart, check_file, check_folder, Outputs};
use super::painter::{Painter, Scene};
use super::paints::{PaintFlags, Paints};
use super::picture::{encode, format_of, gray_png, over, png};
use super::quilting::Quilting;
use super::session::{Device, Session};
use super::strips::trajectory_picture;
use super::techniques::{TechniqueFlags, TechniqueName};
use super::values::{color, Size};
use super::view::ViewFlags;
use clap::Args;
use impasto::scene::{Mesh, MeshOptions};
use impasto::technique::dependent::CoverageReport;
use impasto::technique::image::ImageParams;
use impasto::technique::Show;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Flags of `impasto render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    /// Wavefront OBJ model
    #[arg(value_name = "MODEL.obj")]
    model: PathBuf,
    /// Picture to write: .png, .bmp or .tiff with a transparent background, or .jpg
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Its size in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1024x1024", allow_hyphen_values = true)]
    size: Size,
    #[command(flatten)]
    paints: PaintFlags,
    #[command(flatten)]
    quilting: Quilting,
    #[command(flatten)]
    technique: TechniqueFlags,
    #[command(flatten)]
    view: ViewFlags,
    /// Colour behind the model, like #ffffff [default: transparent]
    #[arg(long, value_name = "COLOR", value_parser = color)]
    background: Option<[u8; 3]>,
    /// Folder for the intermediates: shade.png, id.png, color.png, texture.png, trajectory.png, trajectory.csv, with the
    /// technique image blocks.json, and with dependent coverage.json; those of a second paint are trajectory_2.png and so
    /// on
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
}

/// Renders.
pub fn run(args: &RenderArgs, session: &mut Session) -> Result {
    let format = format_of(&args.output)?;
    check_file(&args.output)?;
    if let Some(dir) = &args.dump {
        check_folder(dir)?;
        check_apart(&args.output, dir)?;
    }
    let lights = args.view.lights()?;
    let mesh = load_model(&args.model, session)?;
    let camera = args.view.camera(&mesh, args.size.aspect())?;
    let name = args.technique.technique;
    let paints = args.paints.load(&mesh, name == TechniqueName::Aligned, session)?;
    let chosen = args.technique.choose(&args.quilting, &mesh, paints.prepared()?)?;
    let window = ImageParams { quilt: chosen.quilt, k: chosen.k, levels: chosen.levels };
    // A k out of range is told before any work.
    window.window_px(1)?;
    for (file, strip) in paints.strips() {
        let size = (strip.sample.width(), strip.sample.height());
        if name != TechniqueName::Object {
            args.quilting.check(file, size, args.size, false)?;
        }
        if matches!(name, TechniqueName::Image | TechniqueName::Dependent) {
            warn_of_wide_window(file, size.0, &window, session)?;
        }
    }
    session.parameter("model", args.model.display().to_string());
    session.parameter("size", args.size.to_string());
    args.technique.report(session);
    args.quilting.report(session);
    args.view.report(&camera, &lights, session);
    session.phase("load");

    let mut device = session.open_device()?;
    device.check_size(args.size)?;
    session.phase("setup");
    let scene = Scene { mesh: &mesh, camera, lights, size: args.size };
    let painter = Painter::new(session, &mut device, &scene, &paints, &chosen)?;
    session.phase("synthesis");

    let mut outputs = Outputs::default();
    let mut frame = painter.frame(&mut device, Show::Painted)?;
    if let Some(background) = args.background {
        frame = over(frame, background);
    }
    if let Some(report) = painter.coverage() {
        session.attach("coverage", coverage_json(report));
    }
    if let Some(dir) = &args.dump {
        dump(dir, &args.quilting, &paints, &painter, &mut device, &mut outputs)?;
    }
    outputs.add(&args.output, encode(frame, format)?);
    session.take_times(&mut device.runner);
    session.wrote(outputs.commit()?);
    session.phase("write");
    Ok(())
}

/// What the search for views came to.
fn coverage_json(report: &CoverageReport) -> serde_json::Value {
    json!({
        "views": report.views, "rounds": report.rounds, "slices": report.slices, "faces": report.faces,
        "covered": report.covered, "forced": report.forced,
    })
}

/// Loads a model and tells what was wrong with it.
pub fn load_model(path: &Path, session: &mut Session) -> Result<Mesh> {
    let loaded = Mesh::load(path, &MeshOptions::default())?;
    for warning in loaded.warnings {
        session.warn(format!("{}: {warning}", path.display()));
    }
    Ok(loaded.mesh)
}

/// A window that takes in most of the strip brings marks of one shade into another.
fn warn_of_wide_window(file: &Path, width: u32, params: &ImageParams, session: &mut Session) -> Result {
    let block = params.quilt.block_px;
    let positions = (width + 1).saturating_sub(block);
    let window = params.window_px(width)?.saturating_mul(2).saturating_add(1).min(positions);
    if window.saturating_mul(2) > width {
        session.warn(format!(
            "{}: --k{} with --block {block} searches {window} of the strip's {width} columns, more than half of it, \
             for every shade; a smaller --k keeps the marks of one shade out of another",
            file.display(),
            params.k.map_or_else(|| " left to itself".to_owned(), |k| format!(" {k}"))
        ));
    }
    Ok(())
}

/// Adds the intermediates to the outputs.
fn dump(
    dir: &Path,
    quilting: &Quilting,
    paints: &Paints,
    painter: &Painter<'_>,
    device: &mut Device,
    outputs: &mut Outputs,
) -> Result {
    outputs.add(dir.join("shade.png"), gray_png(painter.shade(device)?)?);
    outputs.add(dir.join("id.png"), png(painter.id(device)?)?);
    outputs.add(dir.join("color.png"), png(painter.frame(device, Show::Color)?)?);
    outputs.add(dir.join("texture.png"), png(painter.frame(device, Show::Texture)?)?);
    let blocks = painter.blocks(device)?;
    for (number, trajectory) in (1..).zip(paints.trajectories()) {
        let suffix = if number == 1 { String::new() } else { format!("_{number}") };
        let file = |name: &str, extension: &str| dir.join(format!("{name}{suffix}.{extension}"));
        outputs.add(file("trajectory", "png"), png(trajectory_picture(trajectory))?);
        outputs.add(file("trajectory", "csv"), trajectory.to_csv());
        if let Some(records) = blocks.get(number - 1) {
            outputs.add(file("blocks", "json"), blocks::json(quilting, records));
        }
    }
    if let Some(report) = painter.coverage() {
        outputs.add(dir.join("coverage.json"), format!("{:#}\n", coverage_json(report)));
    }
    Ok(())
}
