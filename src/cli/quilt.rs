//! `impasto quilt`: a texture of any size from a sample of it (Efros and Freeman's image quilting).

use super::blocks;
use super::failure::Result;
use super::files::{check_apart, check_file, check_folder, Outputs};
use super::picture::{encode, format_of, from_texels, png};
use super::quilting::{quilt, Quilting};
use super::session::Session;
use super::tile::tile;
use super::values::Size;
use clap::{Args, ValueEnum};
use impasto::paint::PaintSample;
use std::path::PathBuf;

/// Flags of `impasto quilt`.
#[derive(Args, Debug)]
pub struct QuiltArgs {
    /// Picture to make more of; a side may have 4096 pixels
    #[arg(value_name = "SAMPLE.png")]
    sample: PathBuf,
    /// Picture to write: .png, .jpg, .bmp or .tiff
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Its size in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "512x512", allow_hyphen_values = true)]
    size: Size,
    #[command(flatten)]
    quilting: Quilting,
    /// Make a picture that repeats without a seam
    #[arg(long, value_name = "HOW")]
    tileable: Option<Tileable>,
    /// Folder for the intermediates: texture.png (before tiling by mask) and blocks.json
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
}

/// Ways to make a picture tileable.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum Tileable {
    /// Blend the quilt with itself under a circular mask
    Mask,
    /// Quilt blocks around the edges as well
    Wrap,
}

/// Quilts.
pub fn run(args: &QuiltArgs, session: &mut Session) -> Result {
    let format = format_of(&args.output)?;
    check_file(&args.output)?;
    if let Some(dir) = &args.dump {
        check_folder(dir)?;
        check_apart(&args.output, dir)?;
    }
    let wrap = args.tileable == Some(Tileable::Wrap);
    let sample = PaintSample::load(&args.sample)?;
    let sample_size = (sample.width(), sample.height());
    args.quilting.check(&args.sample, sample_size, args.size, wrap)?;
    session.parameter("sample", args.sample.display().to_string());
    session.parameter("size", args.size.to_string());
    let tileable = args.tileable.map(|how| format!("{how:?}").to_lowercase());
    session.parameter("tileable", tileable);
    args.quilting.report(session);
    session.phase("load");

    let mut device = session.open_device()?;
    device.check_size(args.size)?;
    session.phase("setup");
    let quilted = quilt(session, &mut device, &sample.to_rgba8(), sample_size, args.size, (&args.quilting, wrap))?;

    let mut outputs = Outputs::default();
    let texture = from_texels(quilted.texels, args.size.pair())?;
    if let Some(dir) = &args.dump {
        outputs.add(dir.join("texture.png"), png(texture.clone())?);
        outputs.add(dir.join("blocks.json"), blocks::json(&args.quilting, &quilted.blocks));
    }
    let picture = match args.tileable {
        Some(Tileable::Mask) => {
            let texels: Vec<[u8; 4]> = texture.pixels().map(|pixel| pixel.0).collect();
            tile(session, &mut device, &texels, args.size.pair())?
        }
        _ => texture,
    };
    outputs.add(&args.output, encode(picture, format)?);
    session.wrote(outputs.commit()?);
    session.phase("write");
    Ok(())
}
