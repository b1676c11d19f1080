//! A run against an earlier one: devices and measurements that both have, and all that may make them differ.

use super::results::{Device, DeviceResults, Measurement, Results};
use super::tables::{find, Clock};
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A change of no more than this part is called the same. It says nothing of noise: only a second run does.
const SAME: f64 = 0.02;

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// What differs in program, machine and parameters, and devices that only one run has.
    pub notes: Vec<String>,
    /// Devices that both have.
    pub devices: Vec<DeviceComparison>,
}

/// A device in both runs.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceComparison {
    /// Its place in Vulkan's enumeration in the new run.
    pub index: usize,
    /// Its name there.
    pub name: String,
    /// What differs in device and driver, and measurements that only one run has or that cannot be compared.
    pub notes: Vec<String>,
    /// Measurements that both have.
    pub rows: Vec<Row>,
}

/// A measurement in both runs.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Which.
    pub id: String,
    /// What the medians are in.
    pub unit: String,
    /// By the device's clock.
    pub gpu: Option<Change>,
    /// By the host's clock.
    pub wall: Option<Change>,
    /// Whether the same bytes came out, where both runs tell.
    pub same_bytes: Option<bool>,
}

/// Two medians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Of the earlier run.
    pub old: f64,
    /// Of this run.
    pub new: f64,
    /// How many times as fast the new one is, whether more or less is better; `None` if one of them is 0.
    pub speed: Option<f64>,
    /// What that means.
    pub verdict: Verdict,
}

/// Whether it got better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Less time, or a higher rate.
    Faster,
    /// More time, or a lower rate.
    Slower,
    /// Within [`SAME`].
    Same,
}

impl Verdict {
    /// What people read.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Faster => "faster",
            Verdict::Slower => "slower",
            Verdict::Same => "same",
        }
    }
}

impl Comparison {
    /// Compares.
    pub fn new(old: &Results, new: &Results) -> Self {
        let mut notes = differences("tool", &old.tool, &new.tool);
        notes.extend(differences("system", &old.system, &new.system));
        notes.extend(differences("parameters", &old.parameters, &new.parameters));
        let pairs = pairs(&old.devices, &new.devices);
        let alone = |devices: &[DeviceResults], paired: &[&DeviceResults], whose: &str| -> Vec<String> {
            let alone = devices.iter().filter(|one| !paired.iter().any(|other| std::ptr::eq(*other, *one)));
            alone.map(|one| format!("only the {whose} run has the device {}", one.device.name)).collect()
        };
        let (olds, news): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        notes.extend(alone(&old.devices, &olds, "earlier"));
        notes.extend(alone(&new.devices, &news, "new"));
        Comparison { notes, devices: pairs.into_iter().map(|(old, new)| DeviceComparison::new(old, new)).collect() }
    }
}

impl DeviceComparison {
    fn new(old: &DeviceResults, new: &DeviceResults) -> Self {
        let mut notes = differences("device", &old.device, &new.device);
        for (one, whose) in [(old, "earlier"), (new, "new")] {
            let failed = one.failures.iter().map(|one| format!("failed in the {whose} run: {}: {}", one.id, one.error));
            notes.extend(failed);
            notes.extend(one.error.iter().map(|error| format!("the {whose} run gave the device up: {error}")));
            let wrong = one.measurements.iter().filter(|one| !one.check.is_ok());
            notes.extend(wrong.map(|wrong| format!("wrong in the {whose} run: {}: {}", wrong.id, wrong.check.verdict)));
        }
        let mut rows = Vec::new();
        for one in &new.measurements {
            match find(old, &one.id) {
                None => notes.push(format!("only in the new run: {}", one.id)),
                Some(earlier) if (&earlier.unit, earlier.more_is_better) != (&one.unit, one.more_is_better) => {
                    notes.push(format!("not compared: {}, then in {}, now in {}", one.id, earlier.unit, one.unit));
                }
                Some(earlier) => rows.push(Row::new(earlier, one)),
            }
        }
        let gone = old.measurements.iter().filter(|one| find(new, &one.id).is_none());
        notes.extend(gone.map(|one| format!("only in the earlier run: {}", one.id)));
        DeviceComparison { index: new.device.index, name: new.device.name.clone(), notes, rows }
    }

    /// How many changed, and by how much on the whole, by one clock; `None` if it was not read.
    pub fn summary(&self, clock: Clock) -> Option<String> {
        let changes: Vec<&Change> = self.rows.iter().filter_map(|row| row.change(clock)).collect();
        let count = |verdict| changes.iter().filter(|change| change.verdict == verdict).count();
        let speeds: Vec<f64> = changes.iter().filter_map(|change| change.speed).collect();
        let mean = (speeds.iter().map(|speed| speed.ln()).sum::<f64>() / speeds.len() as f64).exp();
        let counts =
            [Verdict::Faster, Verdict::Slower, Verdict::Same].map(|one| format!("{} {}", count(one), one.word()));
        (!speeds.is_empty()).then(|| {
            let counts = counts.join(", ");
            format!("{} medians: {counts}; in the geometric mean {mean:.2} times as fast", clock.word())
        })
    }

    /// Measurements of which other bytes came out.
    pub fn changed_bytes(&self) -> Vec<&str> {
        let changed = self.rows.iter().filter(|row| row.same_bytes == Some(false));
        changed.map(|row| row.id.as_str()).collect()
    }
}

impl Row {
    fn new(old: &Measurement, new: &Measurement) -> Self {
        let change = |clock: Clock| Some(Change::new(clock.of(old)?.p50, clock.of(new)?.p50, new.more_is_better));
        let known = !old.check.hash.is_empty() && !new.check.hash.is_empty();
        Row {
            id: new.id.clone(),
            unit: new.unit.clone(),
            gpu: change(Clock::Gpu),
            wall: change(Clock::Wall),
            same_bytes: known.then(|| old.check.hash == new.check.hash),
        }
    }

    /// By one clock.
    pub fn change(&self, clock: Clock) -> Option<&Change> {
        match clock {
            Clock::Gpu => self.gpu.as_ref(),
            Clock::Wall => self.wall.as_ref(),
        }
    }
}

impl Change {
    fn new(old: f64, new: f64, more_is_better: bool) -> Self {
        let speed = if more_is_better { new / old } else { old / new };
        let speed = Some(speed).filter(|speed| speed.is_finite() && *speed > 0.0);
        let verdict = match speed {
            Some(speed) if speed > 1.0 + SAME => Verdict::Faster,
            Some(speed) if speed < 1.0 / (1.0 + SAME) => Verdict::Slower,
            _ => Verdict::Same,
        };
        Change { old, new, speed, verdict }
    }
}

/// Which device was which: by UUID, then by name; and where each run has just one device, these.
fn pairs<'a>(old: &'a [DeviceResults], new: &'a [DeviceResults]) -> Vec<(&'a DeviceResults, &'a DeviceResults)> {
    let names: [fn(&Device) -> &str; 2] = [|device| &device.uuid, |device| &device.name];
    let mut free: Vec<&DeviceResults> = old.iter().collect();
    let mut found: Vec<Option<&DeviceResults>> = vec![None; new.len()];
    for name in names {
        for (place, one) in found.iter_mut().zip(new).filter(|(place, _)| place.is_none()) {
            *place = free.iter().position(|other| name(&other.device) == name(&one.device)).map(|at| free.remove(at));
        }
    }
    if let ([only], [place]) = (old, &mut found[..]) {
        place.get_or_insert(only);
    }
    found.into_iter().zip(new).filter_map(|(old, new)| Some((old?, new))).collect()
}

/// Every field in which two parts of a document differ, but for a device's place in the list.
fn differences(what: &str, old: &impl Serialize, new: &impl Serialize) -> Vec<String> {
    let (old, new) = (leaves(what, old), leaves(what, new));
    let names: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let told = |fields: &BTreeMap<String, String>, name| fields.get(name).map_or("nothing", String::as_str).to_owned();
    let differing = names.into_iter().filter(|name| old.get(*name) != new.get(*name) && *name != "device.index");
    differing.map(|name| format!("{name} differs: then {}, now {}", told(&old, name), told(&new, name))).collect()
}

fn leaves(what: &str, part: &impl Serialize) -> BTreeMap<String, String> {
    fn walk(name: String, value: &Value, into: &mut BTreeMap<String, String>) {
        match value {
            Value::Object(fields) => fields.iter().for_each(|(key, value)| walk(format!("{name}.{key}"), value, into)),
            Value::Null => {}
            Value::String(text) => drop(into.insert(name, text.clone())),
            other => drop(into.insert(name, other.to_string())),
        }
    }
    let mut all = BTreeMap::new();
    walk(what.to_owned(), &serde_json::to_value(part).unwrap_or_default(), &mut all);
    all
}

#[cfg(test)]
mod tests {
    use super::super::example::example;
    use super::super::results::Samples;
    use super::*;

    #[test]
    fn a_run_is_the_same_as_itself() {
        let comparison = Comparison::new(&example(), &example());
        assert!(comparison.notes.is_empty(), "{:?}", comparison.notes);
        assert_eq!(comparison.devices.len(), 2);
        for device in &comparison.devices {
            assert_eq!(device.rows.len(), 12);
            let changes = device.rows.iter().flat_map(|row| row.gpu.iter().chain(&row.wall));
            assert!(changes.into_iter().all(|change| change.speed == Some(1.0) && change.verdict == Verdict::Same));
            assert!(device.changed_bytes().is_empty());
        }
        assert!(comparison.devices[0].notes.is_empty());
        assert_eq!(comparison.devices[1].notes.len(), 6, "failed, given up and wrong, in both runs");
    }

    #[test]
    fn less_time_and_a_higher_rate_are_faster() {
        let change = |old, new, more_is_better| {
            let change = Change::new(old, new, more_is_better);
            (change.speed, change.verdict)
        };
        assert_eq!(change(2.0, 1.0, false), (Some(2.0), Verdict::Faster));
        assert_eq!(change(2.0, 1.0, true), (Some(0.5), Verdict::Slower));
        assert_eq!(change(1.0, 4.0, false), (Some(0.25), Verdict::Slower));
        assert_eq!(change(1.0, 4.0, true), (Some(4.0), Verdict::Faster));
        assert_eq!(change(100.0, 101.0, false).1, Verdict::Same);
        assert_eq!(change(0.0, 1.0, false), (None, Verdict::Same));
        assert_eq!(change(1.0, 0.0, false), (None, Verdict::Same));
        assert_eq!(change(0.0, 0.0, true), (None, Verdict::Same));
    }

    #[test]
    fn what_changed_is_summed_up_by_each_clock() {
        let mut new = example();
        for one in &mut new.devices[0].measurements {
            let scale = if one.more_is_better { 0.5 } else { 0.25 };
            one.gpu = one.gpu.take().and_then(|gpu| Samples::of(gpu.raw.iter().map(|value| value * scale).collect()));
        }
        new.devices[0].measurements[2].check.hash = "1234".into();
        let device = &Comparison::new(&example(), &new).devices[0];
        let expected = "GPU medians: 8 faster, 0 slower, 0 same; in the geometric mean 4.00 times as fast";
        assert_eq!(device.summary(Clock::Gpu).as_deref(), Some(expected));
        assert!(device.summary(Clock::Wall).is_some_and(|text| text.contains("0 faster, 0 slower, 12 same")));
        assert_eq!(device.changed_bytes(), ["frame/image/head/light-orbit/1920x1080"]);
    }

    #[test]
    fn runs_that_differ_say_in_what() {
        let (old, mut new) = (example(), example());
        new.tool.version = "0.2.0".into();
        new.tool.commit = None;
        new.parameters.numbers.insert("frames".into(), 50.0);
        new.parameters.numbers.insert("rounds".into(), 3.0);
        new.devices[0].device.driver_info = Some("1.2.4".into());
        new.devices[0].measurements[0].id = "frame/new".into();
        new.devices[0].measurements[1].unit = "s".into();
        let comparison = Comparison::new(&old, &new);
        let expected = [
            "tool.commit differs: then 1234abc+, now nothing",
            "tool.version differs: then 0.1.0, now 0.2.0",
            "parameters.numbers.frames differs: then 200.0, now 50.0",
            "parameters.numbers.rounds differs: then nothing, now 3.0",
        ];
        assert_eq!(comparison.notes, expected);
        let expected = [
            "device.driver_info differs: then 1.2.3, now 1.2.4",
            "only in the new run: frame/new",
            "not compared: frame/image/head/light-orbit/1280x720, then in ms, now in s",
            "only in the earlier run: frame/image/head/light-orbit/640x360",
        ];
        assert_eq!(comparison.devices[0].notes, expected);
        assert_eq!(comparison.devices[0].rows.len(), 10);
    }

    #[test]
    fn devices_are_found_again_by_uuid_then_by_name_then_as_the_only_one() {
        let old = example();
        let mut new = example();
        // Another order, and one that has a UUID of its own now.
        new.devices.reverse();
        new.devices[0].device.uuid = "another".into();
        let names: Vec<String> = Comparison::new(&old, &new).devices.into_iter().map(|device| device.name).collect();
        assert_eq!(names, [old.devices[1].device.name.clone(), old.devices[0].device.name.clone()]);
        // Twins swapped places: the UUID decides, not the name.
        let twins = |uuids: [&str; 2]| {
            let mut twins = example();
            twins.devices[1].device.name = twins.devices[0].device.name.clone();
            for (device, uuid) in twins.devices.iter_mut().zip(uuids) {
                device.device.uuid = uuid.into();
            }
            twins
        };
        let (old, new) = (twins(["a", "b"]), twins(["b", "a"]));
        let found: Vec<_> = pairs(&old.devices, &new.devices).iter().map(|(old, _)| old.device.uuid.clone()).collect();
        assert_eq!(found, ["b", "a"]);
        // Strangers are only compared if there is no choice.
        let (mut old, mut new) = (example(), example());
        (old.devices[0].device.uuid, old.devices[0].device.name) = ("x".into(), "Other".into());
        let comparison = Comparison::new(&old, &new);
        assert_eq!(comparison.devices.len(), 1);
        let expected = ["only the earlier run has the device Other", "only the new run has the device A Fast GPU"];
        assert_eq!(comparison.notes, expected);
        old.devices.truncate(1);
        new.devices.truncate(1);
        let comparison = Comparison::new(&old, &new);
        let note = "device.name differs: then Other, now A Fast GPU";
        assert!(comparison.devices[0].notes.contains(&note.to_owned()), "{comparison:?}");
    }
}
