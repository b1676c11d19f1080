//! The commands of the program, one file each, and what they share.
//!
//! Every command goes the same way: read the flags, find out whether the outputs can be written, load and check all
//! inputs, and only then open the device and work; at last, write all files at once ([`files`]).
//!
//! ```text
//! clap -> Cli -> command::run(args, &mut Session) -> Outputs::commit -> Session::close (report)
//! ```

mod blocks;
mod devices;
mod failure;
mod files;
mod image_painter;
mod paint;
mod paints;
mod picture;
mod progress;
mod quilt;
mod quilting;
mod render;
mod report;
mod session;
mod strips;
mod tile;
mod values;
mod view;

use clap::{Parser, Subcommand};
use failure::Result;
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
    /// Shade a model with paint
    Render(Box<render::RenderArgs>),
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
    let session = |command| Session::new(command, cli.common.clone());
    match &cli.command {
        Command::Devices => with(session("devices"), devices::run),
        Command::Paint(args) => with(session("paint"), |session| paint::run(args, session)),
        Command::Quilt(args) => with(session("quilt"), |session| quilt::run(args, session)),
        Command::Tile(args) => with(session("tile"), |session| tile::run(args, session)),
        Command::Render(args) => with(session("render"), |session| render::run(args, session)),
    }
}

/// Runs a command and closes its session.
fn with(mut session: Session, command: impl FnOnce(&mut Session) -> Result) -> Result {
    let result = command(&mut session);
    session.close(result)
}
