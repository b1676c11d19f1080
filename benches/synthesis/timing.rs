//! How time is taken: rounds after a warm-up, their median and 95th percentile, and the device's ceilings beside them.

use crate::Result;
use impasto::gpu::ceilings::{measure as measure_ceilings, Effort, What};
use impasto::gpu::{Context, Image, Runner};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Idle GPUs run at a low clock, so each job first runs for so long, once at least.
const WARM_UP: Duration = Duration::from_millis(500);
/// A job that takes longer is not run once more to warm up: that round counts.
const LONG: Duration = Duration::from_secs(2);

/// Seconds of some rounds, in order of length.
pub struct Spread(Vec<f64>);

impl Spread {
    fn new(mut seconds: Vec<f64>) -> Self {
        seconds.sort_by(f64::total_cmp);
        Spread(seconds)
    }

    fn at(&self, share: f64) -> f64 {
        self.0[((self.0.len() - 1) as f64 * share).round() as usize]
    }

    /// Seconds.
    pub fn median(&self) -> f64 {
        self.at(0.5)
    }

    /// Median and 95th percentile.
    pub fn short(&self) -> String {
        format!("{:.2} / {:.2} ms", 1e3 * self.at(0.5), 1e3 * self.at(0.95))
    }

    pub fn text(&self) -> String {
        format!("median {:.2} ms, p95 {:.2} ms, {} rounds", 1e3 * self.at(0.5), 1e3 * self.at(0.95), self.0.len())
    }
}

/// Rounds of work on the host, or of programs, after one to warm up.
pub fn take_rounds(rounds: usize, mut job: impl FnMut() -> Result) -> Result<Spread> {
    job()?;
    let mut seconds = Vec::new();
    for _ in 0..rounds {
        let start = Instant::now();
        job()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(Spread::new(seconds))
}

/// Rounds of work on the GPU.
pub struct Measured {
    pub wall: Spread,
    /// Stages with their times in each round, by the GPU's clock; none where the queue has no timestamps.
    pub stages: Vec<(&'static str, Spread)>,
    /// What stood in the images after each round.
    pub bytes: Vec<Vec<u8>>,
}

/// Seconds of rounds so far, and of their stages.
#[derive(Default)]
struct Rounds {
    seconds: Vec<f64>,
    stages: Vec<(&'static str, Vec<f64>)>,
}

impl Rounds {
    fn take(&mut self, runner: &mut Runner, mut job: impl FnMut(&mut Runner) -> Result) -> Result {
        runner.take_times();
        let start = Instant::now();
        job(runner)?;
        self.seconds.push(start.elapsed().as_secs_f64());
        for time in runner.take_times() {
            let seconds = time.total_ns as f64 / 1e9;
            match self.stages.iter_mut().find(|(name, _)| *name == time.name) {
                Some((_, all)) => all.push(seconds),
                None => self.stages.push((time.name, vec![seconds])),
            }
        }
        Ok(())
    }
}

fn read(runner: &mut Runner, images: &[&Image]) -> Result<Vec<Vec<u8>>> {
    images.iter().map(|image| Ok(runner.read_image(image)?)).collect()
}

/// Rounds of `job`. After each, `images` are read and compared with those of the first, outside of the time.
pub fn measure(
    runner: &mut Runner,
    rounds: usize,
    images: &[&Image],
    mut job: impl FnMut(&mut Runner) -> Result,
) -> Result<Measured> {
    let start = Instant::now();
    let mut done = Rounds::default();
    done.take(runner, &mut job)?;
    let bytes = read(runner, images)?;
    if done.seconds.iter().all(|seconds| *seconds < LONG.as_secs_f64()) {
        done = Rounds::default();
        while start.elapsed() < WARM_UP {
            job(runner)?;
        }
    }
    while done.seconds.len() < rounds {
        done.take(runner, &mut job)?;
        if bytes != read(runner, images)? {
            return Err("a round gave other bytes than the first".into());
        }
    }
    let stages = done.stages.into_iter().map(|(name, seconds)| (name, Spread::new(seconds))).collect();
    Ok(Measured { wall: Spread::new(done.seconds), stages, bytes })
}

/// The program as a process, its first run (which fills the driver's cache of shaders) left out.
pub fn process(rounds: usize, arguments: &[&str]) -> Result {
    let wall = take_rounds(rounds, || {
        let output = Command::new(env!("CARGO_BIN_EXE_impasto")).args(arguments).output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        Ok(())
    })?;
    let name = |a: &&str| Path::new(*a).file_name().map_or_else(|| (*a).into(), |n| n.to_string_lossy().into_owned());
    let names: Vec<String> = arguments.iter().map(name).collect();
    println!("  process `impasto {}`: {}", names.join(" "), wall.text());
    Ok(())
}

/// Operations per second that the device can do at most: the medians, which other work on the machine slows down as it
/// does the stages.
pub struct Arithmetic(Vec<(What, f64)>);

impl Arithmetic {
    /// Measures it, and prints it beside the other ceilings of the search.
    pub fn measure(context: &Context, runner: &mut Runner) -> Result<Self> {
        let wanted = [What::Float, What::SearchPath, What::ProductPath, What::CopyWords];
        let mut rates = Vec::new();
        println!("ceilings, median / best:");
        for ceiling in measure_ceilings(runner, &wanted, &Effort::full(context))? {
            let rate = ceiling.rate();
            let (size, unit) = match ceiling.what.is_bandwidth() {
                true => (format!(", {} MiB", ceiling.copy_bytes >> 20), "GB/s"),
                false => (String::new(), "Gop/s"),
            };
            let name = format!("{:?}{size}", ceiling.what);
            println!("  {name:18} {:.1} / {:.1} {unit}", rate.median / 1e9, rate.best / 1e9);
            rates.push((ceiling.what, rate.median));
        }
        Ok(Arithmetic(rates))
    }

    /// The rate of so many operations in so many seconds, and its share of the most without loads and by `path`.
    pub fn share(&self, operations: f64, seconds: f64, path: What) -> String {
        let rate = operations / seconds;
        let share = |of: What| {
            let most = self.0.iter().find(|(what, _)| *what == of).map_or(f64::NAN, |(_, most)| *most);
            format!("{:.1} % of {of:?}", 100.0 * rate / most)
        };
        format!(", {:.2} Gop/s, {}, {}", rate / 1e9, share(path), share(What::Float))
    }
}
