//! `impasto tile`: an existing picture made tileable, by blending it with itself under a circular mask (thesis 3.2.3).

use super::failure::Result;
use super::files::{check_file, Outputs};
use super::picture::{encode, format_of, from_texels};
use super::session::{Device, Session};
use clap::Args;
use image::RgbaImage;
use impasto::gpu::Uploads;
use impasto::paint::PaintSample;
use impasto::synthesis::tile_mask::TileMask;
use std::path::PathBuf;

/// Flags of `impasto tile`.
#[derive(Args, Debug)]
pub struct TileArgs {
    /// Picture to make tileable
    #[arg(value_name = "PICTURE.png")]
    picture: PathBuf,
    /// Picture to write: .png, .jpg, .bmp or .tiff
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
}

/// Tiles.
pub fn run(args: &TileArgs, session: &mut Session) -> Result {
    let format = format_of(&args.output)?;
    check_file(&args.output)?;
    let picture = PaintSample::load(&args.picture)?;
    session.parameter("picture", args.picture.display().to_string());
    session.parameter("size", format!("{}x{}", picture.width(), picture.height()));
    session.phase("load");
    let mut device = session.open_device()?;
    session.phase("setup");
    let tiled = tile(session, &mut device, &picture.to_rgba8(), (picture.width(), picture.height()))?;
    let mut outputs = Outputs::default();
    outputs.add(&args.output, encode(tiled, format)?);
    session.wrote(outputs.commit()?);
    session.phase("write");
    Ok(())
}

/// Makes a picture tileable.
pub fn tile(session: &mut Session, device: &mut Device, texels: &[[u8; 4]], size: (u32, u32)) -> Result<RgbaImage> {
    let mut uploads = Uploads::default();
    let mask = TileMask::new(&device.context, &mut uploads, texels, size)?;
    session.phase("prepare");
    device.runner.run(|recorder| {
        uploads.record(recorder);
        mask.record(recorder);
        Ok(())
    })?;
    let bytes = device.runner.read_image(mask.image())?;
    session.take_times(&mut device.runner);
    session.phase("synthesis");
    from_texels(bytes, size)
}
