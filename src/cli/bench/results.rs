//! What a run of `impasto bench` finds: the document that goes to JSON, and that all other outputs are made from.
//!
//! It is the whole truth of a run: every sample that was taken, and all that is needed to take them again. A later
//! program reads it for `--compare`; [`SCHEMA`] grows when a field changes its meaning or goes.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of the document's form.
pub const SCHEMA: u32 = 1;

/// A run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Results {
    /// [`SCHEMA`] of the program that wrote it.
    pub schema: u32,
    /// What measured.
    pub tool: Tool,
    /// When it began, UTC, as `YYYY-MM-DDThh:mm:ssZ`.
    pub started: String,
    /// How long it took in all, seconds.
    pub seconds: f64,
    /// The machine.
    pub system: System,
    /// What was asked for.
    pub parameters: Parameters,
    /// A device after the other, in the order in which they were measured.
    pub devices: Vec<DeviceResults>,
}

/// The program.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Tool {
    /// `impasto`.
    pub name: String,
    /// The crate's version.
    pub version: String,
    /// The commit that it was built from, where the build could find it out, with `+` if files had been changed.
    pub commit: Option<String>,
    /// `release` or `debug`.
    pub profile: String,
}

/// The machine.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct System {
    /// The operating system and its version.
    pub os: String,
    /// The architecture.
    pub arch: String,
    /// The processor's name, where the system tells.
    pub cpu: Option<String>,
    /// Threads that can run at a time.
    pub cores: usize,
}

/// How the run went about it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// `quick`, `full`, or the name of the one scene.
    pub set: String,
    /// The seed of every synthesis.
    pub seed: u32,
    /// All others by name: frames, warm-up frames, rounds, comparisons of a submission, ...
    pub numbers: BTreeMap<String, f64>,
}

/// What one device did.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DeviceResults {
    /// Which device.
    pub device: Device,
    /// Milliseconds to open it: instance, device, memory allocator.
    pub open_ms: f64,
    /// Milliseconds that its driver took to compile the pipelines of each technique, and of `synthesis` by itself, which
    /// was first: making them, and what the first frame took more than the second. Times of preparations are without
    /// making pipelines. Drivers may keep what they have compiled from run to run, out of anyone's reach.
    pub compile_ms: BTreeMap<String, f64>,
    /// What was measured, in order.
    pub measurements: Vec<Measurement>,
    /// What could not be measured, in order.
    #[serde(default)]
    pub failures: Vec<FailedMeasurement>,
    /// Why the device was given up, if it was.
    pub error: Option<String>,
}

/// What could not be measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FailedMeasurement {
    /// Its name, as that of a [`Measurement`].
    pub id: String,
    /// Why.
    pub error: String,
}

/// A device, as Vulkan tells of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Device {
    /// Its place in Vulkan's enumeration.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: String,
    /// Its UUID.
    pub uuid: String,
    /// `domain:bus:device.function` in hexadecimal, where it has such an address.
    pub pci: Option<String>,
    /// PCI vendor.
    pub vendor_id: u32,
    /// PCI device.
    pub device_id: u32,
    /// The Vulkan version that it offers.
    pub api_version: String,
    /// The driver's version, in the driver's own encoding.
    pub driver_version: u32,
    /// The driver's name, where it tells.
    pub driver_name: Option<String>,
    /// The driver's version in its own words, where it tells.
    pub driver_info: Option<String>,
}

impl Device {
    /// The driver in its own words, as far as it tells, or else its number.
    pub fn driver(&self) -> String {
        let words: Vec<&str> =
            [&self.driver_name, &self.driver_info].into_iter().flatten().map(String::as_str).collect();
        match words.is_empty() {
            true => format!("{:#x}", self.driver_version),
            false => words.join(" "),
        }
    }
}

/// What a measurement is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A frame of a technique: milliseconds.
    Frame,
    /// A synthesis: blocks a second.
    Synthesis,
    /// What a technique prepares: milliseconds.
    Preparation,
    /// Per-frame synthesis with frames in flight: frames a second.
    Throughput,
    /// Frames of a technique for many rounds, the slowest of which counts: milliseconds.
    Sustained,
}

/// One row of the table.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measurement {
    /// Names it among all, the same in every run: `frame/object/head/light-orbit/1920x1080`, or `sustained/...` for a
    /// sustained run's frames.
    pub id: String,
    /// What it is of.
    pub kind: Kind,
    /// `object`, `image`, `aligned` or `dependent`, where it is of one.
    pub technique: Option<String>,
    /// `head`, `teapot` or `many`, where it is of one.
    pub scene: Option<String>,
    /// `light-orbit`, `camera-orbit`, `zoom` or `cut`, where something moves.
    pub motion: Option<String>,
    /// Width and height of picture or texture, pixels.
    pub size_px: [u32; 2],
    /// How many frames the device had at a time, for [`Kind::Throughput`].
    pub in_flight: Option<u32>,
    /// What the samples are in: `ms`, `blocks/s` or `frames/s`.
    pub unit: String,
    /// Whether more is better.
    pub more_is_better: bool,
    /// By timestamps on the device; `None` where the queue has none, or where they mean nothing.
    pub gpu: Option<Samples>,
    /// By the host's clock, from the begin of recording to the end of the wait.
    pub wall: Option<Samples>,
    /// The median of each round by the host's clock, in order. In a sustained run the samples above are those of the
    /// slowest round, else of all rounds.
    pub round_p50: Vec<f64>,
    /// Bytes of GPU memory that the context held.
    pub memory_bytes: u64,
    /// What came out, and whether it is right.
    pub check: Check,
    /// How the device was at the end of the measurement, where its driver tells.
    pub telemetry: Option<Telemetry>,
}

/// Numbers, and what they come to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    /// Half are no larger.
    pub p50: f64,
    /// 90 % are no larger.
    pub p90: f64,
    /// 95 % are no larger.
    pub p95: f64,
    /// 99 % are no larger.
    pub p99: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
    /// All of them, in the order in which they were taken.
    pub raw: Vec<f64>,
}

impl Samples {
    /// The figures of some numbers, by the nearest rank; `None` of no numbers.
    pub fn of(raw: Vec<f64>) -> Option<Self> {
        let mut sorted = raw.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |percent: usize| sorted.get((sorted.len() * percent).div_ceil(100).max(1) - 1).copied();
        Some(Samples { p50: at(50)?, p90: at(90)?, p95: at(95)?, p99: at(99)?, min: at(0)?, max: at(100)?, raw })
    }
}

/// Whether a measurement's result is right.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Check {
    /// A hash of the bytes that came out, in hexadecimal.
    pub hash: String,
    /// `ok`, or what is wrong: bytes that change from round to round, bytes that are not the right ones, or a picture
    /// further from the first device's than is allowed.
    pub verdict: String,
}

impl Check {
    /// Nothing is wrong.
    pub fn is_ok(&self) -> bool {
        self.verdict == "ok"
    }
}

/// How a device is doing; what its driver does not tell is null.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// Clock of the shader cores, MHz.
    pub core_mhz: Option<f64>,
    /// Clock of the memory, MHz.
    pub memory_mhz: Option<f64>,
    /// Temperature, degrees Celsius.
    pub celsius: Option<f64>,
    /// Power, watts.
    pub watts: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_samples_by_the_nearest_rank() {
        let samples = Samples::of((1..=200).rev().map(f64::from).collect()).expect("numbers");
        assert_eq!((samples.p50, samples.p90, samples.p95, samples.p99), (100.0, 180.0, 190.0, 198.0));
        assert_eq!((samples.min, samples.max, samples.raw[0]), (1.0, 200.0, 200.0));
        let one = Samples::of(vec![3.5]).expect("a number");
        assert_eq!((one.min, one.p50, one.p99, one.max), (3.5, 3.5, 3.5, 3.5));
        assert_eq!(Samples::of(Vec::new()), None);
    }
}
