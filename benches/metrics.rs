//! What the thesis's metric costs: features, and the search for the 10 nearest among all blocks of a strip.
//!
//! `make bench` prints wall and CPU times, median / p95, for the 100 pixels of a measurement and for a map of 64x64,
//! with the comparisons and their rate. Beside them, for the same 100 blocks, stand the same search in plain code on
//! the host, which must find the same distances, and the k-d tree's, which searches by another distance, so that its
//! answer is compared with the exact one. Every round must find what the first found.

use impasto::gpu::{Context, ContextOptions, Runner};
use impasto::metric::{choose, similarity, BlockSearch, Eligible, Features, KdTree, Neighbour, Picture, Score, Source};
use impasto::metric::{BINS, HISTOGRAMS};
use impasto::paint::PaintSample;
use std::error::Error;
use std::time::Instant;

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;
type Nearest = Vec<Vec<Neighbour>>;

const BLOCK_PX: u32 = 8;
const K: u32 = 10;
/// Pixels that all of the searches look for.
const PIXELS: usize = 100;

fn picture(name: &str) -> Result<Picture> {
    let sample = PaintSample::load(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name))?;
    Ok(Picture::new(sample.width(), sample.height(), sample.to_rgba8())?)
}

/// Milliseconds of each round.
#[derive(Default)]
struct Times {
    wall: Vec<f64>,
    cpu: Vec<f64>,
}

impl Times {
    fn text(&self) -> String {
        let cpu = if self.cpu.is_empty() { "unknown".to_owned() } else { median_and_p95(&self.cpu) };
        format!("wall {}; CPU {cpu}", median_and_p95(&self.wall))
    }
}

fn median_and_p95(values: &[f64]) -> String {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    format!("{:.0} / {:.0} ms", at(0.5), at(0.95))
}

/// CPU time of this process, all threads, milliseconds in steps of 10. Linux only. Where other work shares the cores,
/// or the device is the CPU itself, this compares better than wall time.
fn cpu_ms() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Fields 14 and 15 of proc(5); the name before them may hold spaces, but ends with the last bracket.
    let mut fields = stat.rsplit_once(')')?.1.split_ascii_whitespace().skip(11);
    Some((fields.next()?.parse::<f64>().ok()? + fields.next()?.parse::<f64>().ok()?) * 10.0)
}

/// Runs a job once to warm up and then `rounds` times. Returns what it gives, which must be the same every time.
fn measured<T: PartialEq>(rounds: usize, mut job: impl FnMut() -> Result<T>) -> Result<(T, Times)> {
    let first = job()?;
    let mut times = Times::default();
    for _ in 0..rounds {
        let (cpu, start) = (cpu_ms(), Instant::now());
        let found = job()?;
        times.wall.push(start.elapsed().as_secs_f64() * 1e3);
        times.cpu.extend(cpu.zip(cpu_ms()).map(|(before, after)| after - before));
        if found != first {
            return Err("a round found other blocks than the first".into());
        }
    }
    Ok((first, times))
}

/// The exact search on the host, written so that the compiler can use vectors: each histogram padded to 16 counts,
/// their squares added in integers, the roots in 32 bits; then, as on the device, the best and some more again in 64
/// bits.
struct Plain {
    padded: Vec<[[u8; 16]; HISTOGRAMS]>,
    blocks: Vec<(Features, (u32, u32))>,
}

fn padded(features: &Features) -> [[u8; 16]; HISTOGRAMS] {
    features.0.map(|counts| std::array::from_fn(|bin| if bin < BINS { counts[bin] } else { 0 }))
}

impl Plain {
    fn new(source: &Source) -> Self {
        let blocks: Vec<_> = source.pixels().iter().map(|&pixel| (source.features(pixel), pixel)).collect();
        Plain { padded: blocks.iter().map(|(features, _)| padded(features)).collect(), blocks }
    }

    fn nearest(&self, tested: &[Features]) -> Nearest {
        let mut distances: Vec<(f32, usize)> = Vec::with_capacity(self.blocks.len());
        let mut of_block = |tested: &Features| {
            let query = padded(tested).map(|counts| counts.map(i16::from));
            let distance = |block: &[[u8; 16]; HISTOGRAMS]| {
                let mut squares = [0.0f32; HISTOGRAMS + 1];
                for ((sum, counts), query) in squares.iter_mut().zip(block).zip(&query) {
                    let difference: [i32; 16] = std::array::from_fn(|i| i32::from(i16::from(counts[i]) - query[i]));
                    *sum = difference.iter().map(|d| d * d).sum::<i32>() as f32;
                }
                let roots = squares.map(f32::sqrt);
                roots.iter().sum::<f32>()
            };
            distances.clear();
            distances.extend(self.padded.iter().map(distance).zip(0..));
            let kept = (K as usize + 6).min(distances.len());
            distances.select_nth_unstable_by(kept - 1, |a, b| a.0.total_cmp(&b.0));
            let exact = |&(_, i): &(f32, usize)| (tested.distance(&self.blocks[i].0, BLOCK_PX), i);
            let mut best: Vec<(f64, usize)> = distances[..kept].iter().map(exact).collect();
            best.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            best.truncate(K as usize);
            best.into_iter().map(|(distance, i)| Neighbour { pixel: self.blocks[i].1, distance }).collect()
        };
        tested.iter().map(&mut of_block).collect()
    }
}

/// How the tree's answer differs from the exact one.
fn compare(exact: &Nearest, tree: &Nearest) -> Result {
    let shared = |(exact, tree): (&Vec<Neighbour>, &Vec<Neighbour>)| {
        exact.iter().filter(|near| tree.iter().any(|other| other.pixel == near.pixel)).count()
    };
    let shared: Vec<usize> = exact.iter().zip(tree).map(shared).collect();
    let all = shared.iter().filter(|count| **count == K as usize).count();
    let blocks = shared.iter().sum::<usize>() as f64 / (exact.len() * K as usize) as f64;
    let mean = |nearest: &Nearest| Score::of(&similarity(nearest)).map(|score| score.mean).ok_or("nothing was found");
    let (exact_mean, tree_mean) = (mean(exact)?, mean(tree)?);
    println!(
        "    of {} pixels {all} have the same {K} nearest; {:.0} % of the blocks are the same; mean similarity {tree_mean:.4}, \
         exact {exact_mean:.4}, {:.3} times",
        exact.len(),
        blocks * 100.0,
        tree_mean / exact_mean
    );
    Ok(())
}

fn main() -> Result {
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(5);
    let strip = picture("strip_green_yellow.png")?;
    // Another strip stands for a painted picture: every block is looked for among strangers.
    let frame = picture("strip_red_yellow.png")?;
    let context = Context::new(&ContextOptions::default())?;
    let info = context.device_info();
    println!("device: {} ({}), driver {:#x}", info.name, info.kind, info.driver_version);
    println!("strip {}x{}, block {BLOCK_PX}, k {K}, {rounds} rounds", strip.width(), strip.height());
    let mut runner = Runner::new(&context)?;
    let search = BlockSearch::new(&context, K)?;
    let blocks = search.source(&mut runner, &strip, BLOCK_PX)?.pixels().len();
    runner.take_times();
    let eligible = Eligible::new(&frame, BLOCK_PX).all(|_, _| true);
    for count in [PIXELS, 64 * 64] {
        let pixels = choose(eligible.clone(), count, 1);
        let (_, times) = measured(rounds, || {
            let source = search.source(&mut runner, &strip, BLOCK_PX)?;
            let tested = search.features(&mut runner, &frame, BLOCK_PX, &pixels)?;
            Ok(search.nearest(&mut runner, &source, &tested)?)
        })?;
        let millions = (count * blocks) as f64 / 1e6;
        let fastest = times.wall.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "  GPU, {count:4} pixels, with preparing: {}; {millions:.0} M comparisons, {:.0} M/s at best",
            times.text(),
            millions / fastest * 1e3
        );
        for pass in runner.take_times() {
            println!("    {:18} {:8.1} ms a round", pass.name, pass.total_ns as f64 / 1e6 / (rounds + 1) as f64);
        }
    }
    let source = search.source(&mut runner, &strip, BLOCK_PX)?;
    // A tree can leave out more for a block like those that it holds, so it is also asked for the strip's own.
    for (name, painted) in [("another strip", &frame), ("the strip itself", &strip)] {
        println!("{PIXELS} blocks of {name}, features given");
        let pixels = choose(Eligible::new(painted, BLOCK_PX).all(|_, _| true), PIXELS, 1);
        let tested = search.features(&mut runner, painted, BLOCK_PX, &pixels)?;
        let (exact, times) = measured(rounds, || Ok(search.nearest(&mut runner, &source, &tested)?))?;
        println!("  GPU, with the source's features: {}", times.text());
        in_plain_code(rounds, &source, &tested, &exact)?;
        in_a_tree(rounds, &source, &tested, &exact)?;
    }
    Ok(())
}

fn in_plain_code(rounds: usize, source: &Source, tested: &[Features], exact: &Nearest) -> Result {
    let (_, times) = measured(rounds, || Ok(Plain::new(source).blocks.len()))?;
    println!("  plain code, one core, the source's features: {}", times.text());
    let plain = Plain::new(source);
    let (found, times) = measured(rounds, || Ok(plain.nearest(tested)))?;
    println!("  plain code, one core, the search: {}", times.text());
    let differ = |(a, b): (&Neighbour, &Neighbour)| (a.distance - b.distance).abs() > 1e-5 * b.distance;
    if found.iter().flatten().zip(exact.iter().flatten()).any(differ) {
        return Err("plain code found other distances than the device".into());
    }
    Ok(())
}

fn in_a_tree(rounds: usize, source: &Source, tested: &[Features], exact: &Nearest) -> Result {
    let (kinds, times) = measured(rounds, || Ok(KdTree::new(source)?.kinds()))?;
    println!("  k-d tree, one core, building with features, {kinds} different blocks: {}", times.text());
    let tree = KdTree::new(source)?;
    let (found, times) = measured(rounds, || Ok(tree.nearest(tested, K)?))?;
    println!("  k-d tree, one core, the search: {}", times.text());
    compare(exact, &found)
}
