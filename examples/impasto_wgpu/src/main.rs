//! A program that draws with wgpu, and lets impasto paint one object of its scene, in the same frame.
//!
//! ```text
//! one frame, one submission:
//!   wgpu: floor, plinth, pillars  ->  impasto: the head, hidden by what is nearer  ->  wgpu: beads, then the picture
//!   `Scene::draw_solids`              `Painted::paint`                                 `Scene::draw_beads`, `develop`
//! ```
//!
//! [`lend`] and [`painted`] are what a host of your own needs; [`host`], [`scene`] and [`mod@view`] are this one's, and
//! know nothing of impasto. [`checks`] is what `--check` makes sure of.
//!
//! # Who does what
//!
//! **Device.** wgpu makes instance and device as it likes. impasto borrows them, asks for no extension, feature or
//! limit, and never submits. It is told which features are *enabled*, which is less than what the adapter offers.
//!
//! **Command buffers.** impasto records into a command buffer of wgpu's, which `CommandEncoder::as_hal_mut` gives. The
//! encoder must hold nothing else: wgpu keeps its own commands back until `finish`, and panics when an encoder is used
//! both ways. So a frame has three encoders, and their buffers go into one `submit`, in the order in which they were
//! recorded. What impasto has recorded is submitted, always: it goes on from it in the next frame.
//!
//! **States of textures.** wgpu follows its textures through its own encoders, and sees nothing of what happens in
//! between. Hence three rules:
//! - *Before*, wgpu must have a texture where impasto is told that it is. The last thing in the encoder before is
//!   `transition_resources`, which says it in wgpu's own words, whatever the host has drawn.
//! - *After*, impasto leaves it as it was: `Recorder::hand_over` names the same stages, accesses and layout. wgpu's
//!   next barrier starts from there. Choose a state that is written in (`COLOR_TARGET`, `DEPTH_STENCIL_WRITE`): from
//!   one reading state to the same wgpu sets no barrier at all.
//! - wgpu clears what it believes was never written. So a texture is written by wgpu first (here by the pass that
//!   clears it), or it is made by others and comes in by `create_texture_from_hal` with the state that it is in.
//!
//! **Lifetimes.** wgpu keeps alive what its own encoders use. The painted textures are used by the encoders before and
//! after, in the same submission, and the views are kept in `Scene`; a host that paints into a texture that nothing
//! else in the submission uses must keep it until the frame is done. `Context::advance` is told, before each frame is
//! recorded, its number and the last one that the device is done with, as `Device::poll` says by the submission's
//! index. impasto's objects may be dropped at any time; the context goes when the device is idle, and before the
//! device. A new size of the frame takes new textures, and so a new effect and composite.
//!
//! **Preparation** runs on a thread of its own. What of it needs the GPU is recorded in small pieces, one a frame, in
//! the same place as the painting; the host draws on meanwhile.
//!
//! **Locks.** What `Texture::as_hal` and its like give holds a lock of wgpu's: take the handle, let go, and only then
//! ask for the next. Inside of `as_hal_mut` call nothing of wgpu's.

mod checks;
mod host;
mod lend;
mod log;
mod painted;
mod scene;
mod view;

use host::{Host, Picture};
use painted::Painted;
use scene::{Scene, PICTURE};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use view::View;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Pictures on the camera's way around the head.
const VIEWS: usize = 8;

fn view(number: usize) -> View {
    View::on_orbit((number % VIEWS) as f32 / (VIEWS - 1) as f32)
}

struct Film {
    /// The host's own scene, at each view, while impasto prepares.
    plain: Vec<Picture>,
    /// With the head.
    painted: Vec<Picture>,
    /// Frames that the host drew until the head was ready.
    waited: usize,
}

/// All of it: from a new instance until that is gone.
fn film(validation: bool) -> Result<Film> {
    let mut host = Host::new(validation)?;
    let scene = Scene::new(&host.device);
    let mut painted = Painted::new(&host, &scene)?;
    let shot = shoot(&mut host, &scene, &mut painted);
    // Also after an error: the context goes when the device is idle.
    host.wait()?;
    drop(painted);
    let waited = shot?;
    let mut plain = host.pictures;
    let painted = plain.split_off(VIEWS);
    Ok(Film { plain, painted, waited })
}

fn shoot(host: &mut Host, scene: &Scene, painted: &mut Painted) -> Result<usize> {
    for number in 0..VIEWS {
        frame(host, scene, painted, &view(number), true)?;
    }
    let mut waited = VIEWS;
    while !painted.is_ready() {
        frame(host, scene, painted, &view(waited), false)?;
        waited += 1;
    }
    for number in 0..VIEWS {
        frame(host, scene, painted, &view(number), true)?;
    }
    Ok(waited)
}

/// Records a frame and submits it. The head is painted once it is ready, though not before each view was filmed
/// without.
fn frame(host: &mut Host, scene: &Scene, painted: &mut Painted, view: &View, keep: bool) -> Result<()> {
    let safe = host.begin_frame()?;
    painted.advance(host.frame, safe, host.lost.load(Ordering::Relaxed));
    scene.look(&host.queue, view);

    let mut before = host.device.create_command_encoder(&Default::default());
    scene.draw_solids(&mut before);
    lend::bring_to_attachment(&mut before, &scene.color, &scene.depth);

    let paint = match host.frame > VIEWS as u64 && painted.is_ready() {
        true => painted.paint(&host.device, view)?,
        false => painted.prepare(&host.device)?,
    };

    let mut after = host.device.create_command_encoder(&Default::default());
    scene.draw_beads(&mut after);
    scene.develop(&mut after, host.readback());
    host.submit([before.finish(), paint, after.finish()], keep);
    Ok(())
}

/// Films twice, each time on a device of its own, with the validation layer on.
fn checked() -> Result<Film> {
    checks::watch_submissions();
    checks::layer_watches()?;
    let vertices = checks::vertices(&painted::asset("head.obj"))?;
    let (film, again) = (film(true)?, film(true)?);
    let mut hidden = 0;
    for (number, (plain, painted)) in film.plain.iter().zip(&film.painted).enumerate() {
        let counts = checks::count(&view(number), plain, painted, &vertices);
        if let Some(fault) = counts.fault() {
            return Err(format!("view {number}: {fault}").into());
        }
        hidden += counts.hidden;
    }
    if hidden < 1_000 {
        return Err(format!("the pillar hides {hidden} pixels of the head only: this tests little").into());
    }
    if film.plain != again.plain || film.painted != again.painted {
        return Err("two runs made different pictures".into());
    }
    match log::take() {
        0 => Ok(film),
        count => Err(format!("{count} warnings or errors of wgpu and the validation layer; see above").into()),
    }
}

fn save(folder: &Path, name: &str, pictures: &[Picture]) -> Result<()> {
    for (number, picture) in pictures.iter().enumerate() {
        let path = folder.join(format!("{name}_{number}.png"));
        image::save_buffer(path, picture.as_flattened(), PICTURE[0], PICTURE[1], image::ColorType::Rgba8)?;
    }
    Ok(())
}

fn run() -> Result<()> {
    let (flags, names): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with('-'));
    let check = match &flags[..] {
        [] => false,
        [flag] if flag == "--check" => true,
        _ => return Err("usage: impasto_wgpu [--check] [FOLDER]".into()),
    };
    let folder = PathBuf::from(names.first().map_or("impasto_wgpu_pictures", String::as_str));
    log::install();
    let film = if check { checked()? } else { film(false)? };
    std::fs::create_dir_all(&folder)?;
    save(&folder, "plain", &film.plain)?;
    save(&folder, "painted", &film.painted)?;
    println!("{} frames until the head was ready; the pictures are in {}", film.waited, folder.display());
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("impasto_wgpu: {error}");
            ExitCode::FAILURE
        }
    }
}
