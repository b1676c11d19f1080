//! `impasto bench`: measures one or all devices, checks what they compute, and writes tables and pages of it.
//!
//! ```text
//! catalogue -> cases --\
//! scenes, synthesis ----> subject, one device after the other -> Results -> outputs -+-> bench.json, csv
//! check (references) --/                                                  |         +-> report: parts -> text, ...
//!                                                     old bench.json -> compare -----------^
//! ```

mod catalogue;
mod check;
mod compare;
mod compiling;
mod csv;
mod environment;
#[cfg(test)]
mod example;
mod markdown;
mod outputs;
mod page;
mod plots;
mod previous;
mod report;
mod results;
mod rounds;
mod scenes;
mod subject;
mod synthesis;
mod tables;
mod telemetry;
mod text;
mod throughput;

use super::failure::{Failure, Result};
use super::progress::Progress;
use super::session::{Session, PART_COMPARISONS};
use catalogue::Case;
use clap::Args;
use impasto::gpu::{list_devices, DeviceChoice, DeviceInfo};
use outputs::OutputFlags;
use results::{Device, DeviceResults, Parameters, Results, System, Tool, SCHEMA};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;
use subject::{Shared, Subject};
use telemetry::{Reader, SYSFS};

/// Rounds of a sustained run.
const SUSTAINED_ROUNDS: u32 = 30;

/// Flags of `impasto bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// Only what has this in its name, like frame/object/head/zoom/1920x1080 or many/cut
    #[arg(value_name = "SCENE", conflicts_with = "full")]
    scene: Option<String>,
    /// All scenes in all sizes, with more frames [default: a part that takes a minute or two]
    #[arg(long)]
    full: bool,
    /// 30 rounds of everything, of which the slowest counts: what a device does when it has become warm
    #[arg(long)]
    sustained: bool,
    /// Several devices, one after the other: `all`, or indices, (parts of) names, UUIDs, PCI addresses like 0,2,nvidia
    #[arg(long, value_name = "LIST|all", conflicts_with = "device")]
    devices: Option<String>,
    /// List the names of all scenes, and measure nothing
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    outputs: OutputFlags,
}

/// How much is done: the same on every device.
pub struct Effort {
    /// Frames of a round that come before those that count.
    pub warm_up: u32,
    /// Frames of a round that count.
    pub frames: u32,
    /// Rounds of frames, syntheses and throughput.
    pub rounds: u32,
    /// How often a technique is prepared.
    pub preparations: u32,
    /// Frames of a round of throughput.
    pub stream_frames: u32,
    /// Whether the slowest round is what counts.
    pub sustained: bool,
    /// The seed of every synthesis.
    pub seed: u32,
}

impl Effort {
    fn new(full: bool, sustained: bool) -> Self {
        let quick = Effort {
            warm_up: 4,
            frames: 20,
            rounds: if sustained { SUSTAINED_ROUNDS } else { 3 },
            preparations: 1,
            stream_frames: 8,
            sustained,
            seed: 1,
        };
        match full {
            false => quick,
            true => Effort {
                warm_up: 16,
                frames: 120,
                rounds: quick.rounds.max(5),
                preparations: 5,
                stream_frames: 60,
                ..quick
            },
        }
    }

    fn numbers(&self) -> BTreeMap<String, f64> {
        let numbers = [
            ("warm_up_frames", self.warm_up),
            ("frames", self.frames),
            ("rounds", self.rounds),
            ("preparations", self.preparations),
            ("throughput_frames", self.stream_frames),
            ("sustained", u32::from(self.sustained)),
        ];
        let mut numbers: BTreeMap<String, f64> =
            numbers.into_iter().map(|(name, value)| (name.to_owned(), f64::from(value))).collect();
        numbers.insert("comparisons_per_submission".to_owned(), PART_COMPARISONS as f64);
        numbers
    }
}

/// Measures.
pub fn run(args: &BenchArgs, session: &mut Session) -> Result {
    let (set, cases) = match &args.scene {
        Some(name) => (name.as_str(), catalogue::named(name)?),
        None if args.full || args.list => ("full", catalogue::full()),
        None => ("quick", catalogue::quick()),
    };
    if args.list {
        let names: Vec<&str> = cases.iter().map(|case| case.id.as_str()).collect();
        session.result("scenes", json!(names), names.join("\n"));
        return Ok(());
    }
    let outputs = args.outputs.check()?;
    let devices = chosen_devices(args, session)?;
    let effort = Effort::new(args.full, args.sustained);
    let parameters = Parameters { set: set.to_owned(), seed: effort.seed, numbers: effort.numbers() };
    let (started, start) = (environment::now(), Instant::now());
    let progress = session.progress("measuring", cases.len() * devices.len());
    let mut shared = Shared::default();
    let devices = devices.iter().map(|info| measure(info, &cases, &effort, session, &mut shared, &progress)).collect();
    drop(progress);
    let (schema, seconds) = (SCHEMA, start.elapsed().as_secs_f64());
    let results = Results { schema, tool: Tool::here(), started, seconds, system: System::here(), parameters, devices };
    outputs.finish(&results, session)?;
    if let Some(wrong) = wrong(&results) {
        session.found_wrong(wrong);
    }
    Ok(())
}

/// The devices that were asked for, each once.
fn chosen_devices(args: &BenchArgs, session: &Session) -> Result<Vec<DeviceInfo>> {
    let all = list_devices()?;
    if let Some(list) = &args.devices {
        return listed_devices(list, &all).map_err(|failure| Failure::new(format!("--devices: {}", failure.0)));
    }
    let (flag, choice) = match session.device_choice() {
        Some(choice) => ("--device: ", choice),
        None => ("", DeviceChoice::Best),
    };
    let device = choice.pick(&all).map_err(|error| Failure::new(format!("{flag}{error}")))?;
    Ok(vec![device.clone()])
}

/// The devices of a list, each once. A part of a name stands for all that have it, and so does a UUID.
fn listed_devices(list: &str, all: &[DeviceInfo]) -> Result<Vec<DeviceInfo>> {
    if list.trim() == "all" && !all.is_empty() {
        return Ok(all.to_vec());
    }
    let mut chosen: Vec<DeviceInfo> = Vec::new();
    for text in list.split(',').map(str::trim) {
        if text.is_empty() {
            return Err(Failure::new("a place of the list is empty"));
        }
        let Ok(choice) = text.parse::<DeviceChoice>();
        choice.pick(all)?;
        let named = all.iter().filter(|device| choice.pick(std::slice::from_ref(*device)).is_ok());
        for device in named {
            if !chosen.contains(device) {
                chosen.push(device.clone());
            }
        }
    }
    Ok(chosen)
}

/// Opens a device and measures it. What it failed at is told; a device that is lost is given up, but not the run.
fn measure(
    info: &DeviceInfo,
    cases: &[Case],
    effort: &Effort,
    session: &Session,
    shared: &mut Shared,
    progress: &Progress,
) -> DeviceResults {
    let start = Instant::now();
    let opened = session.open_uncached(info.index);
    let mut results = DeviceResults {
        device: Device::of(info),
        open_ms: start.elapsed().as_secs_f64() * 1e3,
        compile_ms: BTreeMap::new(),
        measurements: Vec::new(),
        failures: Vec::new(),
        error: None,
    };
    match opened {
        Ok(device) => {
            let telemetry = Reader::new(device.context.device_info(), Path::new(SYSFS));
            let mut subject = Subject {
                effort,
                shared,
                progress,
                session: session.silent(),
                device,
                telemetry,
                compile_ms: BTreeMap::new(),
                measurements: Vec::new(),
                failures: Vec::new(),
                warm: Vec::new(),
                state: None,
                stream_hash: None,
            };
            results.error = subject.measure(cases).err().map(|failure| failure.0);
            (results.compile_ms, results.measurements) = (subject.compile_ms, subject.measurements);
            results.failures = subject.failures;
        }
        Err(failure) => results.error = Some(failure.0),
    }
    results
}

/// All that is wrong, device by device; none if nothing is.
fn wrong(results: &Results) -> Option<String> {
    let mut wrong = Vec::new();
    for found in &results.devices {
        let name = format!("{} (device {})", found.device.name, found.device.index);
        for one in found.measurements.iter().filter(|one| !one.check.is_ok()) {
            wrong.push(format!("{name} computes {} wrong: {}", one.id, one.check.verdict));
        }
        wrong.extend(found.failures.iter().map(|one| format!("{name} failed at {}: {}", one.id, one.error)));
        wrong.extend(found.error.iter().map(|error| format!("{name} failed: {error}")));
    }
    (!wrong.is_empty()).then(|| wrong.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::super::session::Common;
    use super::*;
    use impasto::gpu::{DeviceKind, Uuid};

    #[test]
    fn devices_are_listed_by_anything_and_each_is_taken_once() {
        let device = |index: usize, name: &str| DeviceInfo {
            index,
            name: name.to_owned(),
            kind: DeviceKind::Discrete,
            uuid: Uuid([index as u8; 16]),
            vendor_id: 0,
            device_id: 0,
            api_version: 0,
            driver_version: 0,
            pci: format!("0{index}:00.0").parse().ok(),
            driver_name: None,
            driver_info: None,
        };
        let all = [device(0, "GeForce A"), device(1, "Radeon"), device(2, "GeForce B")];
        let chosen = |list: &str| -> Vec<usize> {
            let devices = listed_devices(list, &all).expect(list);
            devices.into_iter().map(|device| device.index).collect()
        };
        assert_eq!(chosen("all"), [0, 1, 2]);
        assert_eq!(chosen("2, 0,2"), [2, 0]);
        assert_eq!(chosen("geforce"), [0, 2], "all that have the name");
        assert_eq!(chosen("01:00.0,geforce,1"), [1, 0, 2]);
        assert_eq!(chosen("02020202-0202-0202-0202-020202020202"), [2]);
        for (list, told) in
            [("", "is empty"), ("0,", "is empty"), ("0,7", "device 7 was not found"), ("all,x", "\"all\"")]
        {
            let failure = listed_devices(list, &all).expect_err(list).0;
            assert!(failure.contains(told), "{failure}");
        }
        assert!(listed_devices("all", &[]).is_err());
    }

    /// What the default device gives, with frames as few as can be.
    fn measured(cases: &[Case], seed: u32, shared: &mut Shared) -> DeviceResults {
        let session = Session::new("bench", Common { device: None, validate: false, json: false, quiet: true });
        let (warm_up, frames, rounds, preparations, stream_frames) = (1, 1, 2, 1, 3);
        let effort = Effort { warm_up, frames, rounds, preparations, stream_frames, sustained: false, seed };
        let all = list_devices().expect("devices");
        let info = DeviceChoice::Best.pick(&all).expect("a device");
        measure(info, cases, &effort, &session, shared, &session.progress("measuring", cases.len()))
    }

    #[test]
    fn what_fails_is_told_by_name_and_the_rest_is_measured() {
        let mut cases = catalogue::named("object/head/zoom/512x512").expect("a frame");
        let mut impossible = cases[0].clone();
        impossible.size.width = 1 << 24;
        impossible.id += "/far too wide";
        cases.insert(0, impossible);
        let results = measured(&cases, 1, &mut Shared::default());
        assert_eq!(results.failures.iter().map(|one| &one.id).collect::<Vec<_>>(), [&cases[0].id]);
        assert!(results.failures[0].error.contains("16777216x512"), "{}", results.failures[0].error);
        assert_eq!(results.measurements.iter().map(|one| &one.id).collect::<Vec<_>>(), [&cases[1].id]);
        assert_eq!(results.error, None, "the device is as well as before");
    }

    /// Another seed stands for a device that computes something else.
    #[test]
    fn a_device_that_computes_other_bytes_is_told() {
        let cases = catalogue::named("synthesis/free/256x256").expect("a synthesis");
        let mut shared = Shared::default();
        let verdict = |results: DeviceResults| results.measurements[0].check.verdict.clone();
        assert_eq!(verdict(measured(&cases, 1, &mut shared)), "ok");
        let told = verdict(measured(&cases, 2, &mut shared));
        assert!(told.contains("other bytes than those of the CPU oracle"), "{told}");
        assert!(told.contains("(device ") && told.contains("; other bytes than those of "), "{told}");
        assert_eq!(verdict(measured(&cases, 1, &mut shared)), "ok", "what is right stays right");
    }

    #[test]
    fn what_is_wrong_is_told_with_device_and_scene() {
        let mut results = example::example();
        let (name, one) = (&results.devices[1].device.name, &results.devices[1].measurements[0]);
        let verdict = &one.check.verdict;
        let failed = &results.devices[1].failures[0];
        let expected = format!(
            "{name} (device 1) computes {} wrong: {verdict}\n{name} (device 1) failed at {}: {}\n\
             {name} (device 1) failed: the device was lost",
            one.id, failed.id, failed.error
        );
        assert_eq!(wrong(&results), Some(expected));
        results.devices.truncate(1);
        assert_eq!(wrong(&results), None);
    }
}
