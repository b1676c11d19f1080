//! Which path of the search is the fastest on a device, found by trying.
//!
//! [`SearchPath::for_device`] goes by the kind of the device. [`calibrate`] times short quiltings of a made-up texture
//! by every path instead, and gives a value for [`super::quilt::QuiltStages::with_path`]. All paths give the same
//! bytes, so that a measurement disturbed by other work costs time, and nothing else.

use super::params::QuiltParams;
use super::quilt::{Quilt, QuiltStages, SampleTexels, SearchPath};
use crate::gpu::{Context, Runner, Uploads};
use crate::{random, Error, Result};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Sides of sample and output of the trials, pixels. On CPU devices pruning pays from somewhere in between on.
const SIZES: [(u32, u32); 2] = [(64, 128), (128, 192)];
/// A search shorter than this tells little of how invocations share a tile.
const LONG: Duration = Duration::from_millis(4);
/// How long a search is repeated first: idle GPUs run at a low clock.
const WARM_UP: Duration = Duration::from_millis(15);
/// Rounds of each trial, of which the shortest counts: whatever else the machine does only adds time.
const ROUNDS: usize = 3;
/// Lines through two measurements are not trusted beyond so many times the larger one.
const FARTHEST: u64 = 8;
const SEED: u32 = 1;

/// Finds the path that is the fastest on the runner's device.
///
/// A program calls it once, at its start or when it is installed, and keeps the value for each device and driver.
/// Nothing global is kept. It takes a second or two on a CPU device of two cores, besides the compilation of all paths
/// at the first time. A build that is not optimised takes far longer, and finds that pruning does not pay for its work
/// on the host.
///
/// The number of parts is that of the shortest search. Pruned searches and full ones are timed at two sizes with their
/// preparation, on the host and on the device; from a line through what pruning saves at each follows from how many
/// comparisons on it pays. On a host's own device, which has no runner, use what was found in a context of its own on
/// the same device.
///
/// # Errors
/// [`Error::Device`] when two paths give different bytes, so that one of them is wrong; those of making and running a
/// quilting.
pub fn calibrate(runner: &mut Runner) -> Result<SearchPath> {
    let context = runner.context().clone();
    let trials = SIZES.map(|(side, to)| Trial::new(side, to));
    let full = SearchPath::PARTS.map(|parts| SearchPath { parts, prune_from: SearchPath::NEVER });
    let stages = full.map(|path| QuiltStages::with_path(&context, path));
    let stages = stages.into_iter().collect::<Result<Vec<_>>>()?;
    let mut fastest = 0;
    for trial in &trials {
        let costs = trial.costs(runner, &stages)?;
        fastest = (0..costs.len()).min_by_key(|&i| costs[i].search).unwrap_or_default();
        if costs.get(fastest).is_some_and(|cost| cost.search >= LONG) {
            break;
        }
    }
    let full = &stages[fastest];
    let parts = full.path().parts;
    let pruned = QuiltStages::with_path(&context, SearchPath { parts, prune_from: 0 })?;
    let mut comparisons = [0; SIZES.len()];
    let mut saved = [0.0; SIZES.len()];
    for (trial, (comparisons, saved)) in trials.iter().zip(comparisons.iter_mut().zip(&mut saved)) {
        let costs = trial.costs(runner, &[full.clone(), pruned.clone()])?;
        let [full, pruned] = [&costs[0], &costs[1]];
        *comparisons = full.comparisons;
        *saved = full.whole.as_secs_f64() - pruned.whole.as_secs_f64();
    }
    Ok(SearchPath { parts, prune_from: pays_from(comparisons, saved) })
}

/// From how many comparisons on pruning saves time that saves so much at two sizes, the smaller one first.
fn pays_from(comparisons: [u64; 2], saved: [f64; 2]) -> u64 {
    let [small, large] = comparisons.map(|count| count as f64);
    let rate = (saved[1] - saved[0]) / (large - small);
    if rate > 0.0 {
        let from = (small - saved[0] / rate) as u64;
        return if from <= FARTHEST.saturating_mul(comparisons[1]) { from } else { SearchPath::NEVER };
    }
    // It saves no more where there is more to save; what it saves, it saves everywhere.
    if saved[1] > 0.0 {
        0
    } else {
        SearchPath::NEVER
    }
}

/// What a quilting costs by one path.
#[derive(Clone, Copy)]
struct Cost {
    /// Its search and placing alone.
    search: Duration,
    /// The same with its preparation.
    whole: Duration,
    comparisons: u64,
}

/// A quilting to be timed.
struct Trial {
    texels: Vec<[u8; 4]>,
    side: u32,
    to: u32,
}

impl Trial {
    fn new(side: u32, to: u32) -> Self {
        Trial { texels: texture(side), side, to }
    }

    /// The least cost by each of these paths. Their bytes are compared first.
    fn costs(&self, runner: &mut Runner, stages: &[Arc<QuiltStages>]) -> Result<Vec<Cost>> {
        let mut bytes: Option<[Vec<u8>; 2]> = None;
        for stages in stages {
            let quilt = self.run(runner, stages)?.0;
            let got = [runner.read_image(quilt.canvas())?, runner.read_image(quilt.source())?];
            if *bytes.get_or_insert_with(|| got.clone()) != got {
                return Err(other_bytes(runner.context(), stages.path()));
            }
        }
        let started = Instant::now();
        while started.elapsed() < WARM_UP {
            let Some(stages) = stages.first() else { break };
            self.run(runner, stages)?;
        }
        let mut rounds = vec![Vec::with_capacity(ROUNDS); stages.len()];
        // By turns, so that all have a share in whatever else the machine does.
        for _ in 0..ROUNDS {
            for (rounds, stages) in rounds.iter_mut().zip(stages) {
                rounds.push(self.run(runner, stages)?.1);
            }
        }
        Ok(rounds.iter().map(|rounds| least(rounds)).collect())
    }

    fn run(&self, runner: &mut Runner, stages: &Arc<QuiltStages>) -> Result<(Quilt, Cost)> {
        let context = runner.context().clone();
        let mut uploads = Uploads::default();
        let sample = SampleTexels::new(&context, &mut uploads, &self.texels, (self.side, self.side))?;
        let started = Instant::now();
        let params = QuiltParams::default();
        let quilt = Quilt::new(&context, &mut uploads, stages, &sample, (self.to, self.to), &params, None)?;
        runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        })?;
        let prepared = started.elapsed();
        runner.run(|recorder| {
            quilt.record(recorder, SEED, 0);
            Ok(())
        })?;
        let whole = started.elapsed();
        let cost = Cost { search: whole - prepared, whole, comparisons: quilt.comparisons() };
        Ok((quilt, cost))
    }
}

/// The least of each time.
fn least(rounds: &[Cost]) -> Cost {
    let least = |of: fn(&Cost) -> Duration| rounds.iter().map(of).min().unwrap_or_default();
    let comparisons = rounds.first().map_or(0, |cost| cost.comparisons);
    Cost { search: least(|cost| cost.search), whole: least(|cost| cost.whole), comparisons }
}

fn other_bytes(context: &Context, path: SearchPath) -> Error {
    let name = &context.device_info().name;
    let search = match path.may_prune() {
        true => "a pruned search".to_owned(),
        false => format!("a full search by {} invocations to a tile", path.parts),
    };
    Error::Device(format!("{name}: {search} gives other bytes than the other paths do"))
}

/// Something like paint: short strokes of many shades one over the other, and grain.
fn texture(side: u32) -> Vec<[u8; 4]> {
    let mut shades = vec![60; (side * side) as usize];
    for stroke in 0..side * side / 12 {
        let below = |limit, purpose| random::bits(SEED, stroke, purpose) % limit;
        let (x, y, shade, length) = (below(side, 0), below(side, 1), below(110, 2), 8 + below(20, 3));
        for (along, across) in (0..length).flat_map(|along| (0..4).map(move |across| (along, across))) {
            let (x, y) = ((x + along) % side, (y + along / 2 + across) % side);
            shades[(y * side + x) as usize] = 60 + shade;
        }
    }
    let texel = |(i, shade): (u32, u32)| {
        let shade = shade + random::bits(SEED, i, 4) % 12;
        [shade + 40, shade, shade - 30, 255].map(|value| value as u8)
    };
    (0..).zip(shades).map(texel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pruning_pays_from_where_it_saves_time() {
        // Full 1 s and 5 s, pruned 2 s and 3 s: 1 + (c - 100) / 100 meets 2 + (c - 100) / 400.
        assert_eq!(pays_from([100, 500], [1.0 - 2.0, 5.0 - 3.0]), 233);
        // Saved at the smaller size already, but not everything.
        assert_eq!(pays_from([100, 500], [1.0, 9.0]), 50);
        assert_eq!(pays_from([100, 500], [1.0, 4.0]), 0, "the line crosses below nothing");
        // Beyond both sizes.
        assert_eq!(pays_from([100, 500], [-3.0, -1.0]), 700);
    }

    #[test]
    fn pruning_that_saves_no_more_of_more_pays_never_or_always() {
        let never = SearchPath::NEVER;
        assert_eq!(pays_from([100, 500], [-1.0, -2.0]), never);
        assert_eq!(pays_from([100, 500], [1.0, -2.0]), never);
        assert_eq!(pays_from([100, 500], [-1.0, -1.0]), never);
        assert_eq!(pays_from([100, 500], [2.0, 1.0]), 0);
        assert_eq!(pays_from([100, 500], [f64::NAN, f64::NAN]), never);
    }

    #[test]
    fn a_crossing_far_beyond_what_was_measured_is_none() {
        assert_eq!(pays_from([100, 500], [-3.5, -3.1]), 3600, "within eight times the larger size");
        assert_eq!(pays_from([100, 500], [-4.0, -3.9]), SearchPath::NEVER);
    }

    #[test]
    fn the_least_of_rounds_is_taken_of_each_time() {
        let ms = Duration::from_millis;
        let cost = |search, whole| Cost { search: ms(search), whole: ms(whole), comparisons: 7 };
        let least = least(&[cost(9, 11), cost(1, 90), cost(3, 20)]);
        assert_eq!((least.search, least.whole, least.comparisons), (ms(1), ms(11), 7));
    }

    #[test]
    fn the_texture_has_grain_and_strokes() {
        let texels = texture(64);
        assert_eq!(texels.len(), 64 * 64);
        let (least, most) = (texels.iter().map(|t| t[1]).min(), texels.iter().map(|t| t[1]).max());
        assert!(least < Some(80) && most > Some(150), "{least:?} to {most:?}");
    }
}
