//! What a device can do at most: bandwidth of memory, rates of arithmetic with and without the loads of the search.
//!
//! A stage's figure says little by itself; as a share of these ceilings it says what is left to win. [`measure`] runs
//! small kernels of known work for as long as is asked for, takes the time of each round by the GPU's clock and by the
//! wall, and compares each last result with what the host works out.
//!
//! Idle GPUs run at a low clock, so each kernel is warmed up by its own work first. That also finds how much work makes
//! a round long enough, from a first step of a few milliseconds on a slow CPU device: no submission takes long.

pub(crate) mod kernels;

use super::caps::DeviceKind;
use super::context::Context;
use super::runner::Runner;
use crate::{Error, Result};
use kernels::Kernel;
use std::time::{Duration, Instant};

/// What is measured. Rates are bytes per second for the first three and operations per second for the others, where a
/// multiplication with the addition that follows counts as two operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// One buffer copied to another by the transfer command. Bytes read and bytes written are both counted.
    CopyBuffer,
    /// One storage buffer read and another written by a compute shader, 16 bytes at a time.
    CopyWords,
    /// One `rgba32ui` storage image read and another written by a compute shader.
    CopyTexels,
    /// Multiply-adds of 32-bit floats without loads.
    Float,
    /// Multiply-adds of 32-bit floats by the path of the block search: packed RGB of 8 bits from `r32ui` storage
    /// images, 19 loads for 48 comparisons of three multiply-adds. Unpacking is not counted.
    SearchPath,
    /// Multiply-adds of 32-bit floats by the path of the pruned search's bounds, a product of matrices: 16-bit
    /// coordinates, eight to a texel of an `rgba32ui` storage image, of two positions, with 10 templates in shared
    /// memory. Unpacking is not counted.
    ProductPath,
    /// Multiply-adds of 32-bit integers without loads.
    Integer,
    /// Products of signed 8-bit integers, four at a time, added to 32 bits, without loads, by shifts. Four products
    /// with their additions count as eight operations; shifts are not counted.
    Dot8,
    /// The same by the device's instruction for it, where [`super::Caps::integer_dot_product`] is on.
    Dot8Packed,
}

impl What {
    /// All of them.
    pub const ALL: [What; 9] = [
        What::CopyBuffer,
        What::CopyWords,
        What::CopyTexels,
        What::Float,
        What::SearchPath,
        What::ProductPath,
        What::Integer,
        What::Dot8,
        What::Dot8Packed,
    ];

    /// Whether its rate is in bytes per second, rather than operations per second.
    pub fn is_bandwidth(self) -> bool {
        matches!(self, What::CopyBuffer | What::CopyWords | What::CopyTexels)
    }
}

/// How long to measure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effort {
    /// Rounds of each kernel, 1 at least.
    pub rounds: u32,
    /// How long a round should be, if the kernel can be made so long.
    pub round: Duration,
    /// How long each kernel runs before its first round.
    pub warm_up: Duration,
    /// Sizes of the buffers and images that are copied, bytes; images are square, so sizes are rounded down to what a
    /// square of a multiple of 64 texels has. Those that exceed the device's limits or a quarter of what is left of the
    /// memory budget are left out.
    pub copy_bytes: Vec<u64>,
}

impl Effort {
    /// For figures to be kept: seconds. On GPUs the larger copy is beyond all caches.
    pub fn full(context: &Context) -> Self {
        let cpu = context.device_info().kind == DeviceKind::Cpu;
        Effort {
            rounds: 7,
            round: Duration::from_millis(20),
            warm_up: Duration::from_millis(300),
            copy_bytes: if cpu { vec![4 << 20, 16 << 20] } else { vec![16 << 20, 256 << 20] },
        }
    }

    /// For a choice between ways to go: some milliseconds for each kernel, besides its compilation.
    pub fn quick() -> Self {
        let round = Duration::from_millis(2);
        Effort { rounds: 3, round, warm_up: 2 * round, copy_bytes: vec![1 << 20] }
    }
}

/// A rate, in bytes or operations per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    /// Of the median round.
    pub median: f64,
    /// Of the fastest round.
    pub best: f64,
}

/// One ceiling, as measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Ceiling {
    /// What was measured, which decides the unit.
    pub what: What,
    /// Bytes of each of the two buffers or images that were copied between; 0 for rates of arithmetic.
    pub copy_bytes: u64,
    /// Bytes moved or operations done in each round.
    pub work: u64,
    /// Seconds of each round by the GPU's clock, in order of length; empty where the queue has no timestamps.
    pub gpu_seconds: Vec<f64>,
    /// Seconds of each round from before recording until the wait was over, in order of length.
    pub wall_seconds: Vec<f64>,
}

impl Ceiling {
    /// The rate by the GPU's clock, or by the wall where there is no other.
    pub fn rate(&self) -> Rate {
        self.per_second(if self.gpu_seconds.is_empty() { &self.wall_seconds } else { &self.gpu_seconds })
    }

    /// The rate by the wall clock, with what it takes to submit and to wait.
    pub fn wall_rate(&self) -> Rate {
        self.per_second(&self.wall_seconds)
    }

    fn per_second(&self, sorted: &[f64]) -> Rate {
        let at = |i: usize| sorted.get(i).map_or(0.0, |seconds| self.work as f64 / seconds);
        Rate { median: at(sorted.len() / 2), best: at(0) }
    }
}

/// Measures each of `wanted`, in order, copies once for each size. What the device does not offer is left out.
/// The times that `runner` has taken so far are forgotten.
///
/// # Errors
/// [`Error::Device`] when a kernel gives a wrong result; those of making and running pipelines.
pub fn measure(runner: &mut Runner, wanted: &[What], effort: &Effort) -> Result<Vec<Ceiling>> {
    let context = runner.context().clone();
    let mut measured = Vec::new();
    for &what in wanted {
        if what.is_bandwidth() {
            for &bytes in effort.copy_bytes.iter().filter(|bytes| kernels::copy_fits(&context, **bytes)) {
                let kernel = kernels::copy(runner, what, bytes)?;
                measured.push(measure_kernel(runner, what, &kernel, effort)?);
            }
        } else if what != What::Dot8Packed || context.caps().integer_dot_product {
            let kernel = kernels::arithmetic(runner, what)?;
            measured.push(measure_kernel(runner, what, &kernel, effort)?);
        }
    }
    Ok(measured)
}

/// Seconds by the GPU's clock, if it has one, and by the wall.
type Seconds = (Option<f64>, f64);

fn run(runner: &mut Runner, kernel: &Kernel, steps: u32, seed: u32) -> Result<Seconds> {
    runner.take_times();
    let start = Instant::now();
    runner.run(|recorder| {
        (kernel.record)(recorder, steps, seed);
        Ok(())
    })?;
    let wall = start.elapsed().as_secs_f64();
    let gpu_ns: u64 = runner.take_times().iter().map(|time| time.total_ns).sum();
    Ok(((gpu_ns > 0).then_some(gpu_ns as f64 * 1e-9), wall))
}

fn measure_kernel(runner: &mut Runner, what: What, kernel: &Kernel, effort: &Effort) -> Result<Ceiling> {
    let mut steps = kernel.first_steps;
    // Some drivers compile at the first dispatch.
    run(runner, kernel, steps, 0)?;
    let start = Instant::now();
    loop {
        let (gpu, wall) = run(runner, kernel, steps, 0)?;
        let wanted = effort.round.as_secs_f64() / gpu.unwrap_or(wall).max(1e-9);
        let longer = (f64::from(steps) * wanted.min(8.0)).min(f64::from(kernel.max_steps)) as u32;
        if longer > steps + steps / 4 {
            steps = longer;
        } else if start.elapsed() >= effort.warm_up {
            break;
        }
    }
    let (mut gpu_seconds, mut wall_seconds) = (Vec::new(), Vec::new());
    let rounds = effort.rounds.max(1);
    for seed in 1..=rounds {
        let (gpu, wall) = run(runner, kernel, steps, seed)?;
        gpu_seconds.extend(gpu);
        wall_seconds.push(wall);
    }
    check(kernel, &(kernel.read)(runner)?, steps, rounds)?;
    gpu_seconds.sort_by(f64::total_cmp);
    wall_seconds.sort_by(f64::total_cmp);
    let work = kernel.step_work * u64::from(steps);
    Ok(Ceiling { what, copy_bytes: kernel.copy_bytes, work, gpu_seconds, wall_seconds })
}

/// Compares the words that `steps` steps with this seed have written with the host's.
fn check(kernel: &Kernel, result: &[u8], steps: u32, seed: u32) -> Result<()> {
    let count = (kernel.words)(steps);
    let words = result.chunks_exact(4).take(count).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
    let mut right = 0;
    for (i, word) in words.enumerate() {
        right += usize::from(word == (kernel.expected)(i, seed));
    }
    if right != count {
        return Err(Error::Device(format!("{}: {} of {count} words are wrong", kernel.name, count - right)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_those_of_the_median_and_the_fastest_round() {
        let (gpu_seconds, wall_seconds) = (vec![0.5, 1.0, 4.0], vec![2.0, 4.0, 8.0]);
        let mut ceiling = Ceiling { what: What::Float, copy_bytes: 0, work: 8, gpu_seconds, wall_seconds };
        assert_eq!(ceiling.rate(), Rate { median: 8.0, best: 16.0 });
        assert_eq!(ceiling.wall_rate(), Rate { median: 2.0, best: 4.0 });
        ceiling.gpu_seconds.clear();
        assert_eq!(ceiling.rate(), ceiling.wall_rate());
    }

    #[test]
    fn one_wrong_word_is_noticed() {
        let kernel = Kernel {
            name: "test",
            first_steps: 1,
            max_steps: 1,
            step_work: 1,
            copy_bytes: 0,
            words: Box::new(|steps| 2 * steps as usize),
            expected: Box::new(|i, seed| i as u32 ^ seed),
            record: Box::new(|_, _, _| ()),
            read: Box::new(|_| Ok(Vec::new())),
        };
        let bytes = |words: &[u32]| words.iter().flat_map(|word| word.to_ne_bytes()).collect::<Vec<_>>();
        assert!(check(&kernel, &bytes(&[8, 9, 10, 11, 99]), 2, 8).is_ok(), "what lies behind the result is nobody's");
        assert!(check(&kernel, &bytes(&[8, 9, 10, 12]), 2, 8).is_err());
        assert!(check(&kernel, &bytes(&[8, 9, 10, 11]), 2, 7).is_err(), "another round's");
        assert!(check(&kernel, &bytes(&[8, 9, 10]), 2, 8).is_err(), "a word is missing");
    }
}
