//! `impasto paint`: a strip taken apart into colour and texture, and put together again (thesis chapter 4).

use super::failure::Result;
use super::files::{check_folder, Outputs};
use super::picture::png;
use super::report::number;
use super::session::Session;
use super::strips::{trajectory_picture, StripFlags};
use clap::Args;
use impasto::paint::PaintSample;
use serde_json::{json, Map, Value};
use std::path::PathBuf;

/// Flags of `impasto paint`.
#[derive(Args, Debug)]
pub struct PaintArgs {
    /// Paint strip, dark on the left and light on the right
    #[arg(value_name = "STRIP.png")]
    strip: PathBuf,
    /// Folder for trajectory.png, trajectory.csv (s,r,g,b), texture.png (difference mapped to 0..1), recombined.png
    /// and, with --gradient, gradient.png
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Colours to put the texture together with: another strip's, or stops like 0:#102030,0.5:#ff8800,1:#ffffff
    /// [default: the strip's own]
    #[arg(long, value_name = "STRIP2.png|STOPS")]
    gradient: Option<String>,
    #[command(flatten)]
    flags: StripFlags,
}

/// Takes the strip apart. No device is needed.
pub fn run(args: &PaintArgs, session: &mut Session) -> Result {
    check_folder(&args.output)?;
    let sample = PaintSample::load(&args.strip)?;
    session.parameter("strip", args.strip.display().to_string());
    session.parameter("gradient", args.gradient.clone());
    args.flags.report(session);
    session.phase("load");

    let strip = args.flags.separate(sample, &args.strip.display().to_string(), session)?;
    let gradient = match &args.gradient {
        Some(text) => Some(args.flags.gradient(text, strip.trajectory.len())?),
        None => None,
    };
    let recombined = strip.texture.recombine(gradient.as_ref().unwrap_or(&strip.trajectory));
    let mut residuals = Map::new();
    let mut lines = Vec::new();
    for (name, residual) in args.flags.residuals(&strip.sample)? {
        residuals.insert(name.to_owned(), json!({ "rms": number(residual.rms), "max": number(residual.max) }));
        lines.push(format!("residual of timing {name:7}: rms {:.4}, largest {:.4}", residual.rms, residual.max));
    }
    session.result("residuals", Value::Object(residuals), lines.join("\n"));
    let (kept, columns) = (strip.trajectory.kept_columns().len(), strip.sample.width());
    session.result("kept_columns", kept, format!("{kept} of {columns} columns make up the trajectory"));
    session.phase("prepare");

    let mut outputs = Outputs::default();
    let file = |name: &str| args.output.join(name);
    outputs.add(file("trajectory.png"), png(trajectory_picture(&strip.trajectory))?);
    outputs.add(file("trajectory.csv"), strip.trajectory.to_csv());
    outputs.add(file("texture.png"), png(strip.texture.to_image())?);
    outputs.add(file("recombined.png"), png(recombined.to_image())?);
    if let Some(gradient) = &gradient {
        outputs.add(file("gradient.png"), png(trajectory_picture(gradient))?);
    }
    session.wrote(outputs.commit()?);
    session.phase("write");
    Ok(())
}
