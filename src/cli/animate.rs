//! `impasto animate`: frame after frame, to numbered pictures, a film or an animated GIF.
//!
//! A run may be cut into parts that other machines make, and go on where it was interrupted: what a frame takes over
//! from those before it is found from the first one on, without drawing them. While the device works on a frame, other
//! threads encode and write those before it.

use super::failure::{Failure, Result};
use super::film::{Sink, Target};
use super::motion::{Frames, MotionFlags};
use super::painter::{Painter, Scene};
use super::picture::over;
use super::session::Session;
use super::shot::ShotFlags;
use clap::Args;
use impasto::technique::Show;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Flags of `impasto animate`.
#[derive(Args, Debug)]
pub struct AnimateArgs {
    /// What to write: numbered pictures like DIR/%04d.png (or .jpg, .bmp, .tiff), a film .mp4, .webm, .mkv or .mov (by
    /// the program ffmpeg), or a .gif
    #[arg(short, long, value_name = "DIR/%04d.png|FILM")]
    output: PathBuf,
    /// First and last frame
    #[arg(long, value_name = "FIRST..LAST", default_value = "0..99", allow_hyphen_values = true)]
    frames: Frames,
    /// Frames of a film in a second
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=100),
          allow_negative_numbers = true)]
    rate: u32,
    /// Only part I of N of the frames, I from 0: for many machines. All parts together are the whole
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(u32, u32)>,
    /// Leave out the numbered pictures that are there already
    #[arg(long)]
    resume: bool,
    /// Let every frame stand alone: view-aligned texture stays still in the picture instead of following the model,
    /// view-dependent texture is chosen anew instead of staying on faces that stay in sight
    #[arg(long)]
    still: bool,
    #[command(flatten)]
    motion: MotionFlags,
    #[command(flatten)]
    shot: ShotFlags,
}

/// Animates.
pub fn run(args: &AnimateArgs, session: &mut Session) -> Result {
    let target = Target::new(&args.output, args.rate)?;
    if !target.is_numbered() && (args.resume || args.shard.is_some()) {
        return Err(Failure::file(&args.output, "--resume and --shard are for numbered pictures, like DIR/%04d.png"));
    }
    let shot = args.shot.load(session)?;
    let motion = args.motion.load(shot.camera, args.shot.view.axis(), shot.lights.clone(), session)?;
    // The range of shade is that of the first frame of all, whatever part of them this is.
    let first = motion.at(args.frames.first, &shot.mesh)?;
    session.parameter("frames", args.frames.to_string());
    session.parameter("still", args.still);
    let background = args.shot.background;
    session.parameter("background", background.map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}")));
    // What makes the frames what they are; how they are shared out does not.
    let made_by = session.parameters_json();
    target.check(args.resume.then_some(&made_by))?;
    session.parameter("rate", args.rate);
    session.parameter("shard", args.shard.map(|(index, count)| format!("{index}/{count}")));
    session.parameter("resume", args.resume);
    let frames = match args.shard {
        Some((index, count)) => args.frames.part(index, count),
        None => Some(args.frames),
    };
    let numbers: Vec<u32> = frames.map_or_else(Vec::new, |frames| (frames.first..=frames.last).collect());
    let numbers: Vec<u32> = numbers.into_iter().filter(|&n| !(args.resume && target.has(n))).collect();
    session.phase("load");
    if numbers.is_empty() {
        session.result("rendered", json!({ "frames": 0 }), "nothing to do: all frames are there");
        return Ok(());
    }

    let mut device = session.open_device()?;
    device.check_size(args.shot.size)?;
    session.phase("setup");
    let scene = Scene { mesh: &shot.mesh, camera: first.0, lights: first.1, size: args.shot.size };
    let mut painter = Painter::new(session, &mut device, &scene, &shot.paints, &shot.chosen)?;
    session.phase("prepare");

    let mut sink = Sink::open(&target, args.shot.size, &made_by)?;
    let progress = session.frames("animating", numbers.len());
    let mut times = Vec::with_capacity(numbers.len());
    let mut reached = args.frames.first;
    let mut camera = scene.camera;
    for &number in &numbers {
        let started = Instant::now();
        // From the very first frame on, so that every part of a run comes to the same.
        while !args.still && reached < number {
            reached += 1;
            let next = motion.at(reached, &shot.mesh)?.0;
            painter.follow(&mut device, &camera, &next)?;
            camera = next;
        }
        painter.draw(None, &mut device, motion.at(number, &shot.mesh)?, number)?;
        let frame = painter.frame(&mut device, Show::Painted)?;
        sink.write(number, if let Some(color) = background { over(frame, color) } else { frame })?;
        times.push(started.elapsed().as_secs_f64());
        progress.step();
    }
    drop(progress);
    let written = sink.finish()?;
    session.phase("animate");
    session.take_times(&mut device.runner);
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize] * 1e3;
    let total: f64 = times.iter().sum();
    let rate = times.len() as f64 / total;
    session.result(
        "rendered",
        json!({ "frames": times.len(), "frames_per_second": rate, "median_ms": at(0.5), "p95_ms": at(0.95) }),
        format!("{} frames, {rate:.1} a second (median {:.0} ms, p95 {:.0} ms)", times.len(), at(0.5), at(0.95)),
    );
    match &written[..] {
        [one] => session.wrote(vec![one.clone()]),
        [first, .., last] => {
            session.closing_line(format!("wrote {} to {}", first.display(), last.display()));
            session.wrote(written.clone());
        }
        [] => {}
    }
    Ok(())
}

/// Reads `I/N`.
fn shard(text: &str) -> std::result::Result<(u32, u32), String> {
    let wrong = || "must be I/N with I from 0 to N - 1 and N up to 100000".to_owned();
    let (index, count) = text.split_once('/').ok_or_else(wrong)?;
    let number = |text: &str| text.parse::<u32>().map_err(|_| wrong());
    let (index, count) = (number(index)?, number(count)?);
    if index < count && count <= 100_000 {
        Ok((index, count))
    } else {
        Err(wrong())
    }
}
