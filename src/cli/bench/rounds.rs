//! Times of rounds, by the device's clock and by the host's.

use super::results::Samples;
use crate::cli::failure::Result;
use crate::cli::session::Device;
use std::time::Instant;

/// Milliseconds of one job.
#[derive(Debug, Clone, Copy)]
pub struct Time {
    /// All passes together, by timestamps; 0 where the queue has none.
    pub gpu_ms: f64,
    /// From the begin of recording to the end of the wait.
    pub wall_ms: f64,
}

impl Time {
    /// Does a job, and takes its time.
    pub fn of<T>(device: &mut Device, job: impl FnOnce(&mut Device) -> Result<T>) -> Result<(T, Time)> {
        device.runner.take_times();
        let start = Instant::now();
        let done = job(device)?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok((done, Time::new(device, wall_ms)))
    }

    /// What the host's clock says, with what the device's says of all passes since [`Runner::take_times`].
    ///
    /// [`Runner::take_times`]: impasto::gpu::Runner::take_times
    pub fn new(device: &mut Device, wall_ms: f64) -> Self {
        let gpu_ns = device.runner.take_times().iter().fold(0, |sum: u64, time| sum.saturating_add(time.total_ns));
        Time { gpu_ms: believable(gpu_ns as f64 / 1e6, wall_ms), wall_ms }
    }

    /// How often it goes into a second, `count` times over, by both clocks.
    pub fn rate(self, count: usize) -> Self {
        let rate = |ms: f64| if ms > 0.0 { count as f64 * 1e3 / ms } else { 0.0 };
        Time { gpu_ms: rate(self.gpu_ms), wall_ms: rate(self.wall_ms) }
    }
}

/// The device's time, or 0 if it cannot be: passes do not overlap and the host waits for them, so that all of them take
/// no longer than it waited, but for two clocks that do not go at quite the same rate.
fn believable(gpu_ms: f64, wall_ms: f64) -> f64 {
    if gpu_ms <= 1.02 * wall_ms {
        gpu_ms
    } else {
        0.0
    }
}

/// What the rounds of a measurement took, in its unit.
#[derive(Default)]
pub struct Rounds(Vec<Vec<Time>>);

/// What they come to.
#[derive(Debug)]
pub struct Figures {
    /// By timestamps, if there are any.
    pub gpu: Option<Samples>,
    /// By the host's clock.
    pub wall: Option<Samples>,
    /// The median of each round, by the host's clock.
    pub round_p50: Vec<f64>,
}

impl Rounds {
    /// Adds a round.
    pub fn add(&mut self, times: Vec<Time>) {
        self.0.push(times);
    }

    /// The figures of all rounds or, if `sustained`, of the slowest by its median on the host's clock.
    pub fn figures(mut self, sustained: bool, more_is_better: bool) -> Figures {
        let wall = |round: &[Time]| Samples::of(round.iter().map(|time| time.wall_ms).collect());
        let round_p50: Vec<f64> = self.0.iter().filter_map(|round| wall(round)).map(|samples| samples.p50).collect();
        if sustained {
            let slowness = |number: &usize| if more_is_better { -round_p50[*number] } else { round_p50[*number] };
            let slowest = (0..round_p50.len()).max_by(|a, b| slowness(a).total_cmp(&slowness(b)));
            self.0 = slowest.map(|number| self.0.swap_remove(number)).into_iter().collect();
        }
        let times = self.0.concat();
        let gpu: Vec<f64> = times.iter().map(|time| time.gpu_ms).collect();
        // A clock that stands still is none.
        let gpu = if gpu.iter().all(|ms| *ms > 0.0) { Samples::of(gpu) } else { None };
        Figures { gpu, wall: wall(&times), round_p50 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounds(walls: &[&[f64]], gpu_ms: f64) -> Rounds {
        let round = |walls: &&[f64]| walls.iter().map(|&wall_ms| Time { gpu_ms, wall_ms }).collect();
        Rounds(walls.iter().map(round).collect())
    }

    #[test]
    fn all_samples_count_unless_it_is_the_slowest_round_that_does() {
        let walls: [&[f64]; 3] = [&[1.0, 2.0, 3.0], &[5.0, 4.0, 6.0], &[1.0, 1.0, 9.0]];
        let all = rounds(&walls, 0.5).figures(false, false);
        assert_eq!(all.wall.map(|wall| wall.raw), Some(walls.concat()));
        assert_eq!(all.gpu.map(|gpu| gpu.raw.len()), Some(9));
        assert_eq!(all.round_p50, [2.0, 5.0, 1.0]);
        for (more_is_better, slowest) in [(false, walls[1]), (true, walls[2])] {
            let figures = rounds(&walls, 0.5).figures(true, more_is_better);
            assert_eq!(figures.wall.map(|wall| wall.raw), Some(slowest.to_vec()));
            assert_eq!(figures.round_p50, [2.0, 5.0, 1.0]);
        }
    }

    #[test]
    fn without_timestamps_there_is_no_time_of_the_device() {
        assert!(rounds(&[&[1.0]], 0.0).figures(false, false).gpu.is_none());
        assert!(Rounds::default().figures(true, false).wall.is_none());
    }

    #[test]
    fn a_device_that_takes_longer_than_one_waits_for_it_has_no_clock() {
        assert_eq!([believable(3.0, 5.0), believable(5.05, 5.0), believable(6.0, 5.0)], [3.0, 5.05, 0.0]);
        let rounds = Rounds(vec![vec![Time { gpu_ms: 3.0, wall_ms: 5.0 }, Time { gpu_ms: 0.0, wall_ms: 5.0 }]]);
        assert!(rounds.figures(false, false).gpu.is_none(), "one such time is enough");
    }

    #[test]
    fn rates_are_by_the_second() {
        let rate = Time { gpu_ms: 0.0, wall_ms: 500.0 }.rate(100);
        assert_eq!((rate.gpu_ms, rate.wall_ms), (0.0, 200.0));
    }
}
