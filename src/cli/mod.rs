//! The commands of the program, one file each, and what they share.
//!
//! Every command goes the same way: read the flags, find out whether the outputs can be written, load and check all
//! inputs, and only then open the device (`render` opens it meanwhile) and work; at last, write all files at once
//! ([`files`]).
//!
//! ```text
//! clap -> Cli -> command::run(args, &mut Session) -> Outputs::commit -> Session::close (report)
//! ```

mod animate;
mod bench;
mod blocks;
mod builtin;
mod calm;
mod compare;
mod compare_page;
mod demo;
mod demo_page;
mod devices;
mod error_map;
mod failure;
mod files;
mod film;
mod frames;
mod image_frames;
mod keyframes;
mod measure;
mod meter;
mod metric_tests;
mod metric_tests_page;
mod motion;
mod motion_file;
mod paint;
mod painter;
mod paints;
mod picture;
mod plot;
mod prepare;
mod progress;
mod quilt;
mod quilting;
mod render;
mod report;
mod report_page;
mod session;
mod shot;
mod strips;
mod table;
mod techniques;
mod tile;
mod values;
mod view;

use clap::{Parser, Subcommand};
use failure::{Failure, Result};
use session::{Common, Session};
use std::process::ExitCode;

/// Shade 3D models with real paint
///
/// An artist paints one strip, dark on the left to light on the right; impasto takes the strip and a 3D model and makes
/// the model look painted with it.
#[derive(Parser, Debug)]
#[command(name = "impasto", version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// List the Vulkan devices
    Devices,
    /// Take a paint strip apart: its colour trajectory, its brush texture, and both put together again
    Paint(paint::PaintArgs),
    /// Make a texture of any size from a sample of it
    Quilt(quilt::QuiltArgs),
    /// Make an existing picture tileable
    Tile(tile::TileArgs),
    /// Prepare a strip for view-aligned projection, for `render --technique aligned` and for games
    Prepare(prepare::PrepareArgs),
    /// Shade a model with paint
    Render(Box<render::RenderArgs>),
    /// Shade a model with paint, frame after frame
    Animate(Box<animate::AnimateArgs>),
    /// Measure how good a picture is, and how calm a sequence
    Measure(measure::MeasureArgs),
    /// Paint a model with every technique, still and moving, measure them all alike, and write one report
    Compare(Box<compare::CompareArgs>),
    /// Measure how fast the devices are, and whether they compute what they should
    Bench(bench::BenchArgs),
    /// Show what the program can do, without any file: a page with pictures of everything
    Demo(demo::DemoArgs),
}

/// Parses the command line and runs the command. Exit status: 0, 1 for a failure, 2 for a wrong command line.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            report::error_on_stderr(&failure.0);
            ExitCode::FAILURE
        }
    }
}

fn run(cli: Cli) -> Result {
    let mut session = Session::new(cli.command.name(), cli.common);
    let result = cli.command.run(&mut session);
    session.close(result)
}

/// Runs a command line within another command: its device, times and warnings become those of `session`.
fn run_words(line: &str, session: &mut Session) -> Result {
    let cli = Cli::try_parse_from(line.split_whitespace()).map_err(|error| Failure::new(error.to_string()))?;
    let mut inner = session.inner(cli.command.name());
    let result = cli.command.run(&mut inner);
    session.adopt(inner);
    result
}

impl Command {
    fn name(&self) -> &'static str {
        match self {
            Command::Devices => "devices",
            Command::Paint(_) => "paint",
            Command::Quilt(_) => "quilt",
            Command::Tile(_) => "tile",
            Command::Prepare(_) => "prepare",
            Command::Render(_) => "render",
            Command::Animate(_) => "animate",
            Command::Measure(_) => "measure",
            Command::Compare(_) => "compare",
            Command::Bench(_) => "bench",
            Command::Demo(_) => "demo",
        }
    }

    fn run(&self, session: &mut Session) -> Result {
        match self {
            Command::Devices => devices::run(session),
            Command::Paint(args) => paint::run(args, session),
            Command::Quilt(args) => quilt::run(args, session),
            Command::Tile(args) => tile::run(args, session),
            Command::Prepare(args) => prepare::run(args, session),
            Command::Render(args) => render::run(args, session),
            Command::Animate(args) => animate::run(args, session),
            Command::Measure(args) => measure::run(args, session),
            Command::Compare(args) => compare::run(args, session),
            Command::Bench(args) => bench::run(args, session),
            Command::Demo(args) => demo::run(args, session),
        }
    }
}
