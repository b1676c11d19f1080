//! `impasto render`: a model, shaded with paint.

use super::blocks;
use super::failure::Result;
use super::files::{check_apart, check_file, check_folder, Outputs};
use super::image_painter::ImagePainter;
use super::paints::{PaintFlags, Paints};
use super::picture::{encode, format_of, gray_png, over, png};
use super::quilting::Quilting;
use super::report::number;
use super::session::{Device, Session};
use super::strips::trajectory_picture;
use super::values::{color, Size};
use super::view::ViewFlags;
use clap::{Args, ValueEnum};
use impasto::scene::{Mesh, MeshOptions};
use impasto::technique::image::ImageParams;
use impasto::technique::Show;
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
    /// Way of painting
    #[arg(long, value_enum, default_value_t)]
    technique: Technique,
    #[command(flatten)]
    paints: PaintFlags,
    #[command(flatten)]
    quilting: Quilting,
    /// How far a block's place in the strip may be from its shade's, in blocks; fractions allowed [default: 1/16 of the
    /// strip's width, 1 to 4 blocks; the thesis: 4]
    #[arg(long, value_name = "BLOCKS", allow_negative_numbers = true)]
    k: Option<f32>,
    /// Spread the model's own range of shade over the whole strip
    #[arg(long)]
    levels: bool,
    #[command(flatten)]
    view: ViewFlags,
    /// Colour behind the model, like #ffffff [default: transparent]
    #[arg(long, value_name = "COLOR", value_parser = color)]
    background: Option<[u8; 3]>,
    /// Folder for the intermediates: shade.png, id.png, color.png, texture.png, trajectory.png, trajectory.csv and
    /// blocks.json; those of a second paint are trajectory_2.png and so on
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
}

/// Ways of painting.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Technique {
    /// Texture synthesised over the picture, colour by shade: best for stills
    #[default]
    Image,
}

/// Renders.
pub fn run(args: &RenderArgs, session: &mut Session) -> Result {
    let format = format_of(&args.output)?;
    check_file(&args.output)?;
    if let Some(dir) = &args.dump {
        check_folder(dir)?;
        check_apart(&args.output, dir)?;
    }
    let params = ImageParams { quilt: args.quilting.params(false), k: args.k, levels: args.levels };
    // A k out of range is told before any work.
    params.window_px(1)?;
    let lights = args.view.lights()?;
    let mesh = load_model(&args.model, session)?;
    let camera = args.view.camera(&mesh, args.size.aspect())?;
    let paints = args.paints.load(&mesh, session)?;
    for (file, strip) in paints.strips() {
        let size = (strip.sample.width(), strip.sample.height());
        args.quilting.check(file, size, args.size, false)?;
        warn_of_wide_window(file, size.0, &params, session)?;
    }
    session.parameter("model", args.model.display().to_string());
    session.parameter("size", args.size.to_string());
    session.parameter("technique", "image");
    args.quilting.report(session);
    session.parameter("k", args.k.map_or(serde_json::Value::Null, number));
    session.parameter("levels", args.levels);
    args.view.report(&camera, &lights, session);
    session.phase("load");

    let mut device = session.open_device()?;
    device.check_size(args.size)?;
    session.phase("setup");
    let painter = ImagePainter::new(&mut device, &mesh, &camera, &lights, &paints, &params, args.size)?;
    session.phase("prepare");
    painter.paint(session, &mut device)?;
    session.phase("synthesis");

    let mut outputs = Outputs::default();
    let mut frame = painter.frame(&mut device, Show::Painted)?;
    if let Some(background) = args.background {
        frame = over(frame, background);
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

/// Loads a model and tells what was wrong with it.
fn load_model(path: &Path, session: &mut Session) -> Result<Mesh> {
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
    painter: &ImagePainter,
    device: &mut Device,
    outputs: &mut Outputs,
) -> Result {
    outputs.add(dir.join("shade.png"), gray_png(painter.shade(device)?)?);
    outputs.add(dir.join("id.png"), png(painter.id(device)?)?);
    outputs.add(dir.join("color.png"), png(painter.frame(device, Show::Color)?)?);
    outputs.add(dir.join("texture.png"), png(painter.frame(device, Show::Texture)?)?);
    for (number, (paint, records)) in (1..).zip(paints.all().iter().zip(painter.blocks(device)?)) {
        let suffix = if number == 1 { String::new() } else { format!("_{number}") };
        let file = |name: &str, extension: &str| dir.join(format!("{name}{suffix}.{extension}"));
        outputs.add(file("trajectory", "png"), png(trajectory_picture(paint.trajectory))?);
        outputs.add(file("trajectory", "csv"), paint.trajectory.to_csv());
        outputs.add(file("blocks", "json"), blocks::json(quilting, &records));
    }
    Ok(())
}
