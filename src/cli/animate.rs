//! `impasto animate`: frame after frame, to numbered pictures, a film, an animated PNG or an animated GIF.
//!
//! A frame depends on those since the last keyframe and on nothing else: the first frame, a cut, or every N-th frame
//! (`--keyframes`). A run may be cut into parts that other machines make, and go on where it was interrupted: what a
//! frame takes over from those before it is gone through again, from the last keyframe on. While the device works on a
//! frame, other threads encode and write those before it.

use super::failure::{Failure, Result};
use super::film::{Sink, Target};
use super::frames::Frames;
use super::image_frames::{CoherenceFlags, NextFrame};
use super::meter::quantile;
use super::motion::MotionFlags;
use super::painter::{Painter, Scene};
use super::picture::over;
use super::session::Session;
use super::shot::{LookFlags, ShotFlags};
use super::techniques::{Technique, TechniqueName};
use clap::Args;
use impasto::technique::Show;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Flags of `impasto animate`.
#[derive(Args, Debug)]
pub struct AnimateArgs {
    /// What to write: numbered pictures like DIR/%04d.png (or .jpg, .bmp, .tiff), a film .mp4, .webm, .mkv or .mov (by
    /// the program ffmpeg), an animated .png, or a .gif
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
    /// Let every frame stand for itself: texture neither follows the model nor stays on its faces
    #[arg(long)]
    still: bool,
    /// Begin anew every N frames, as at a cut, so that parts of a run need not go through all frames before them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000),
          allow_negative_numbers = true)]
    keyframes: Option<u32>,
    #[command(flatten)]
    motion: MotionFlags,
    #[command(flatten)]
    coherence: CoherenceFlags,
    #[command(flatten)]
    look: LookFlags,
    #[command(flatten)]
    shot: ShotFlags,
}

/// Animates.
pub fn run(args: &AnimateArgs, session: &mut Session) -> Result {
    let target = Target::new(&args.output, args.rate)?;
    if !target.is_numbered() && (args.resume || args.shard.is_some()) {
        return Err(Failure::file(&args.output, "--resume and --shard are for numbered pictures, like DIR/%04d.png"));
    }
    let shot = args.shot.load(&[args.look.technique], session)?;
    let mut chosen = args.shot.choose(args.look.technique, &shot)?;
    if args.look.technique == TechniqueName::Image && !args.still {
        chosen.technique = Technique::Image(args.coherence.continuity(args.shot.quilting.block, session)?);
    }
    let motion = args.motion.load(&shot, args.shot.view.axis(), args.frames, session)?;
    // The range of shade is that of the first frame of all, whatever part of them this is.
    let first = motion.at(args.frames.first, &shot.mesh)?;
    session.parameter("frames", args.frames.to_string());
    session.parameter("still", args.still);
    session.parameter("keyframe_every", args.keyframes);
    let background = args.look.background;
    session.parameter("background", background.map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}")));
    // Frames that have nothing to do with those before them.
    let is_fresh = |number: u32| {
        let every = args.keyframes.is_some_and(|every| (number - args.frames.first).is_multiple_of(every));
        args.still || number == args.frames.first || every || motion.is_cut(number)
    };
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
        session.result("rendered", json!({ "frames": 0, "replayed": 0 }), "nothing to do: all frames are there");
        return Ok(());
    }

    let mut device = session.open_device()?;
    device.check_size(args.shot.size)?;
    session.phase("setup");
    let scene = Scene { mesh: &shot.mesh, moment: first, size: args.shot.size };
    let mut painter = Painter::new(session, &mut device, &scene, &shot.paints, &chosen)?;
    session.phase("prepare");

    let mut sink = Sink::open(&target, args.shot.size, numbers.len(), &made_by)?;
    let progress = session.frames("animating", numbers.len());
    let mut times = Vec::with_capacity(numbers.len());
    let mut next = args.frames.first;
    let mut replayed = 0;
    for &number in &numbers {
        let started = Instant::now();
        // From the last frame that stands for itself, so that every part of a run comes to the same.
        let from = if painter.has_memory() { (next..=number).rev().find(|&step| is_fresh(step)) } else { Some(number) };
        for step in from.unwrap_or(next)..=number {
            let moment = motion.at(step, &shot.mesh)?;
            let ahead = |to: u32| motion.ahead(step, to.min(args.frames.last), &shot.mesh);
            let (fresh, shown) = (is_fresh(step), step == number);
            let frame = NextFrame { moment: &moment, number: step, fresh, shown, ahead: &ahead };
            painter.advance(None, &mut device, &frame)?;
            replayed += u32::from(!shown);
        }
        next = number + 1;
        let frame = painter.frame(&mut device, Show::Painted)?;
        sink.write(number, if let Some(color) = background { over(frame, color) } else { frame })?;
        times.push(started.elapsed().as_secs_f64());
        progress.step();
    }
    drop(progress);
    let written = sink.finish()?;
    session.phase("animate");
    session.take_times(&mut device.runner);
    let at = |share: f64| quantile(&times, share).unwrap_or_default() * 1e3;
    let total: f64 = times.iter().sum();
    let rate = times.len() as f64 / total;
    session.result(
        "rendered",
        json!({
            "frames": times.len(), "replayed": replayed, "frames_per_second": rate,
            "median_ms": at(0.5), "p95_ms": at(0.95),
            "cuts": numbers.iter().filter(|&&number| motion.is_cut(number)).collect::<Vec<_>>(),
        }),
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
