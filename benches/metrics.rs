//! What the thesis's metric costs: features, and the search for the 10 nearest among all blocks of a strip.
//!
//! `make bench` prints wall times for the 100 pixels of a measurement and for a map of 64x64, with the comparisons and
//! their rate, beside the same search in plain code on one core and in a k-d tree. Every round must find what the first
//! found.

use impasto::gpu::{Context, ContextOptions, Runner};
use impasto::metric::{BlockSearch, Eligible, Features, Neighbour, Picture};
use impasto::paint::PaintSample;
use std::error::Error;
use std::time::Instant;

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

const BLOCK_PX: u32 = 8;
const K: u32 = 10;

fn picture(name: &str) -> Result<Picture> {
    let sample = PaintSample::load(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name))?;
    Ok(Picture::new(sample.width(), sample.height(), sample.to_rgba8())?)
}

fn median_and_p95(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    format!("median {:8.1} ms, p95 {:8.1} ms", at(0.5) * 1e3, at(0.95) * 1e3)
}

fn main() -> Result {
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(5);
    let strip = picture("strip_green_yellow.png")?;
    // Another strip stands for a painted picture: every block is looked for among strangers.
    let frame = picture("strip_red_yellow.png")?;
    let eligible = Eligible::new(&frame, BLOCK_PX).all(|_, _| true);
    let context = Context::new(&ContextOptions::default())?;
    let info = context.device_info();
    println!("device: {} ({}), driver {:#x}", info.name, info.kind, info.driver_version);
    println!("strip {}x{}, block {BLOCK_PX}, k {K}, {rounds} rounds", strip.width(), strip.height());
    let mut runner = Runner::new(&context)?;
    let search = BlockSearch::new(&context, K)?;
    let mut source = search.source(&mut runner, &strip, BLOCK_PX)?;
    for count in [100, 64 * 64] {
        let pixels = impasto::metric::choose(eligible.clone(), count, 1);
        let mut times = Vec::new();
        let mut first: Option<Vec<Vec<Neighbour>>> = None;
        for round in 0..=rounds {
            let start = Instant::now();
            source = search.source(&mut runner, &strip, BLOCK_PX)?;
            let tested = search.features(&mut runner, &frame, BLOCK_PX, &pixels)?;
            let found = search.nearest(&mut runner, &source, &tested)?;
            if round > 0 {
                times.push(start.elapsed().as_secs_f64());
            }
            if *first.get_or_insert_with(|| found.clone()) != found {
                return Err("a round found other blocks than the first".into());
            }
        }
        let comparisons = (count * source.pixels().len()) as f64;
        let fastest = times.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "  GPU, {count:4} pixels: {}; {:.0} M comparisons, {:.0} M/s at best",
            median_and_p95(times),
            comparisons / 1e6,
            comparisons / 1e6 / fastest
        );
        for pass in runner.take_times() {
            println!("    {:18} {:8.1} ms a round", pass.name, pass.total_ns as f64 / 1e6 / (rounds + 1) as f64);
        }
    }
    // Plain code, 10 pixels, for the same distances.
    let pixels = impasto::metric::choose(eligible, 10, 1);
    let tested = search.features(&mut runner, &frame, BLOCK_PX, &pixels)?;
    let all: Vec<Features> = source.pixels().iter().map(|&pixel| source.features(pixel)).collect();
    let mut times = Vec::new();
    for _ in 0..rounds {
        let start = Instant::now();
        for tested in &tested {
            let mut distances: Vec<f64> = all.iter().map(|features| tested.distance(features, BLOCK_PX)).collect();
            distances.sort_by(f64::total_cmp);
            std::hint::black_box(&distances[..K as usize]);
        }
        times.push(start.elapsed().as_secs_f64());
    }
    println!("  plain code, 10 pixels, one core, without features: {}", median_and_p95(times));
    Ok(())
}
