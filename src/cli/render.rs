//! `impasto render`: a model, shaded with paint.

use super::blocks;
use super::failure::Result;
use super::files::{check_apart, check_file, check_folder, Outputs};
use super::image_frames::NextFrame;
use super::painter::{Painter, Scene};
use super::paints::Paints;
use super::picture::{encode, format_of, gray_png, over, png};
use super::quilting::Quilting;
use super::session::{Device, Session};
use super::shot::{LookFlags, ShotFlags};
use super::strips::trajectory_picture;
use super::techniques::TechniqueName;
use clap::Args;
use impasto::scene::Moment;
use impasto::technique::dependent::CoverageReport;
use impasto::technique::Show;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Flags of `impasto render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    /// Picture to write: .png, .bmp or .tiff with a transparent background, or .jpg
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Folder for the intermediates: shade.png, id.png, color.png, texture.png, trajectory.png, trajectory.csv, with
    /// the technique image blocks.json, and with dependent coverage.json; those of a second paint are trajectory_2.png
    /// and so on
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    #[command(flatten)]
    look: LookFlags,
    #[command(flatten)]
    shot: ShotFlags,
}

/// Renders.
pub fn run(args: &RenderArgs, session: &mut Session) -> Result {
    let format = format_of(&args.output)?;
    check_file(&args.output)?;
    if let Some(dir) = &args.dump {
        check_folder(dir)?;
        check_apart(&args.output, dir)?;
    }
    let technique = args.look.technique;
    let quilting = (technique != TechniqueName::Object).then_some(&args.shot.quilting);
    let ((shot, chosen), mut device) = session.load_and_open(quilting, |session| {
        let shot = args.shot.load(&[technique], session)?;
        let chosen = args.shot.choose(technique, &shot)?;
        Ok((shot, chosen))
    })?;
    device.check_size(args.shot.size)?;
    let moment = Moment::at_rest(shot.camera, shot.lights);
    let scene = Scene { mesh: &shot.mesh, moment: moment.clone(), size: args.shot.size };
    let mut painter = Painter::new(session, &mut device, &scene, &shot.paints, &chosen)?;
    painter.advance(Some(session), &mut device, &NextFrame::alone(&moment, 0))?;
    session.phase("synthesis");

    let mut outputs = Outputs::default();
    let mut frame = painter.frame(&mut device, Show::Painted)?;
    if let Some(background) = args.look.background {
        frame = over(frame, background);
    }
    if let Some(report) = painter.coverage() {
        session.attach("coverage", coverage_json(report));
    }
    if let Some(dir) = &args.dump {
        dump(dir, &args.shot.quilting, &shot.paints, &mut painter, &mut device, &mut outputs)?;
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

/// Adds the intermediates to the outputs.
fn dump(
    dir: &Path,
    quilting: &Quilting,
    paints: &Paints,
    painter: &mut Painter<'_>,
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
