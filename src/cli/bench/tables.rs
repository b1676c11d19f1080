//! The tables of a run, for terminal, Markdown and page: by kind of measurement, and devices side by side.

use super::super::table::{Cell, Table};
use super::results::{DeviceResults, Kind, Measurement, Results, Samples, Telemetry};
use std::collections::BTreeSet;

/// All kinds, in the order of the tables, with their headings.
pub const KINDS: [(Kind, &str); 5] = [
    (Kind::Frame, "Frames"),
    (Kind::Sustained, "Frames for a long time"),
    (Kind::Throughput, "Frames in flight"),
    (Kind::Synthesis, "Synthesis"),
    (Kind::Preparation, "Preparation"),
];

/// By which clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// The device's timestamps.
    Gpu,
    /// The host's clock.
    Wall,
}

impl Clock {
    /// What people read.
    pub fn word(self) -> &'static str {
        match self {
            Clock::Gpu => "GPU",
            Clock::Wall => "wall",
        }
    }

    /// What was measured by it.
    pub fn of(self, one: &Measurement) -> Option<&Samples> {
        match self {
            Clock::Gpu => one.gpu.as_ref(),
            Clock::Wall => one.wall.as_ref(),
        }
    }

    /// The one by which all can be compared: the device's, if all have it.
    pub fn common<'a>(mut all: impl Iterator<Item = &'a Measurement>) -> Self {
        if all.all(|one| one.gpu.is_some()) {
            Clock::Gpu
        } else {
            Clock::Wall
        }
    }
}

/// What a device is called in a table of several.
pub fn short_name(device: &DeviceResults) -> String {
    format!("D{}", device.device.index)
}

/// A device's measurements, a table for each kind that there is.
pub fn by_kind(device: &DeviceResults) -> Vec<(&'static str, Table)> {
    let table = |(kind, heading)| {
        let rows: Vec<&Measurement> = device.measurements.iter().filter(|one| one.kind == kind).collect();
        (!rows.is_empty()).then(|| (heading, measured(&rows)))
    };
    KINDS.into_iter().filter_map(table).collect()
}

/// What a device could not be measured in, and why.
pub fn failed(device: &DeviceResults) -> Table {
    let mut table = Table::new(["measurement", "why"]);
    for failure in &device.failures {
        table.row([failure.id.as_str().into(), failure.error.as_str().into()]);
    }
    table
}

/// Rows of one kind. What is not the median is on the bad side of it: high for times, low for rates.
fn measured(rows: &[&Measurement]) -> Table {
    type Column = (&'static str, Clock, fn(&Samples) -> f64);
    const TIMES: &[Column] = &[
        ("GPU p50", Clock::Gpu, |all| all.p50),
        ("p95", Clock::Gpu, |all| all.p95),
        ("wall p50", Clock::Wall, |all| all.p50),
        ("p95", Clock::Wall, |all| all.p95),
        ("max", Clock::Wall, |all| all.max),
    ];
    const RATES: &[Column] = &[
        ("GPU p50", Clock::Gpu, |all| all.p50),
        ("min", Clock::Gpu, |all| all.min),
        ("wall p50", Clock::Wall, |all| all.p50),
        ("min", Clock::Wall, |all| all.min),
    ];
    let columns = if rows.iter().all(|one| one.more_is_better) { RATES } else { TIMES };
    let headers = std::iter::once("measurement").chain(columns.iter().map(|(header, ..)| *header));
    let mut table = Table::new(headers.chain(["unit", "MiB", "check"]));
    for one in rows {
        let figures = columns.iter().map(|(_, clock, of)| figure(clock.of(one).map(of)));
        let mebibytes = Cell::Number(one.memory_bytes as f64 / f64::from(1 << 20), 1);
        let end = [one.unit.as_str().into(), mebibytes, one.check.verdict.as_str().into()];
        table.row(std::iter::once(one.id.as_str().into()).chain(figures).chain(end));
    }
    table
}

/// The median of every measurement on each device, and how many times that of the first device it is; a table for each
/// clock that was read.
pub fn side_by_side(results: &Results) -> Vec<(String, Table)> {
    if results.devices.len() < 2 {
        return Vec::new();
    }
    [Clock::Gpu, Clock::Wall].into_iter().filter_map(|clock| side_by(clock, &results.devices)).collect()
}

fn side_by(clock: Clock, devices: &[DeviceResults]) -> Option<(String, Table)> {
    let (first, others) = devices.split_first()?;
    let name = short_name(first);
    let ratios = others.iter().map(short_name).flat_map(|other| [other.clone(), format!("{other} / {name}")]);
    let mut table = Table::new(["measurement".to_owned(), "unit".to_owned(), name.clone()].into_iter().chain(ratios));
    let mut shown = BTreeSet::new();
    for one in devices.iter().flat_map(|device| &device.measurements) {
        let median = |device| Some(clock.of(find(device, &one.id)?)?.p50);
        let medians: Vec<Option<f64>> = devices.iter().map(median).collect();
        if medians.iter().any(Option::is_some) && shown.insert(&one.id) {
            let rest = medians[1..].iter().flat_map(|value| [figure(*value), ratio(value.zip(medians[0]))]);
            table.row([one.id.as_str().into(), one.unit.as_str().into(), figure(medians[0])].into_iter().chain(rest));
        }
    }
    (!shown.is_empty()).then(|| (format!("Medians by the {} clock, side by side", clock.word()), table))
}

/// A measurement of a device by its name.
pub fn find<'a>(device: &'a DeviceResults, id: &str) -> Option<&'a Measurement> {
    device.measurements.iter().find(|one| one.id == id)
}

/// How the driver compiled, slowest first.
pub fn compiled(device: &DeviceResults) -> Table {
    let mut rows: Vec<(&String, &f64)> = device.compile_ms.iter().collect();
    rows.sort_by(|a, b| b.1.total_cmp(a.1));
    let mut table = Table::new(["prepared", "ms"]);
    for (name, ms) in rows {
        table.row([name.as_str().into(), figure(Some(*ms))]);
    }
    table
}

/// How the device was, where its driver tells.
pub fn telemetry(device: &DeviceResults) -> Table {
    let mut table = Table::new(["measurement", "core MHz", "memory MHz", "degrees C", "W"]);
    for one in &device.measurements {
        let Some(Telemetry { core_mhz, memory_mhz, celsius, watts }) = one.telemetry else { continue };
        let cells = [core_mhz, memory_mhz, celsius, watts].map(figure);
        table.row(std::iter::once(Cell::from(one.id.as_str())).chain(cells));
    }
    table
}

/// A number with about four digits that mean something.
pub fn figure(value: Option<f64>) -> Cell {
    let Some(value) = value else { return Cell::Missing };
    let decimals = match value.abs() {
        size if size < 10.0 => 3,
        size if size < 100.0 => 2,
        size if size < 1000.0 => 1,
        _ => 0,
    };
    Cell::Number(value, decimals)
}

/// How many times the second the first is.
pub fn ratio(pair: Option<(f64, f64)>) -> Cell {
    match pair {
        Some((value, base)) if base > 0.0 => Cell::Number(value / base, 2),
        _ => Cell::Missing,
    }
}

#[cfg(test)]
mod tests {
    use super::super::example::example;
    use super::*;

    #[test]
    fn a_device_has_a_table_for_each_kind() {
        let tables = by_kind(&example().devices[0]);
        assert_eq!(tables.iter().map(|(heading, _)| *heading).collect::<Vec<_>>(), KINDS.map(|(_, heading)| heading));
        let text = tables[0].1.text();
        assert_eq!(text.lines().count(), 1 + 6, "{text}");
        let row = "frame/aligned/head/light-orbit/1920x1080    2.074  2.592     2.574  3.092  3.092  ms    48.0  ok";
        assert!(text.contains(row), "{text}");
    }

    #[test]
    fn beside_the_median_stands_the_bad_side_of_it() {
        let mut device = example().devices.remove(0);
        device.measurements.retain(|one| one.kind == Kind::Throughput);
        device.measurements[0].wall = Samples::of(vec![100.0, 90.0, 110.0]);
        let rates = by_kind(&device).remove(0).1.text();
        let lines: Vec<Vec<&str>> = rates.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(lines[0][1..], ["GPU", "p50", "min", "wall", "p50", "min", "unit", "MiB", "check"], "{rates}");
        assert_eq!(lines[1][1..], ["-", "-", "100.0", "90.00", "frames/s", "48.0", "ok"], "{rates}");
    }

    #[test]
    fn what_failed_is_told_with_its_reason() {
        let text = failed(&example().devices[1]).text();
        assert!(text.contains("frame/image/head/cut/3840x2160  canvas needs 5 bytes, but 4 | are left"), "{text}");
        assert_eq!(failed(&example().devices[0]).rows().count(), 0);
    }

    #[test]
    fn devices_side_by_side_have_a_row_for_each_name_and_ratios_to_the_first() {
        let mut results = example();
        results.devices[0].measurements.remove(1);
        results.devices[1].measurements[3].gpu = None;
        let tables = side_by_side(&results);
        assert_eq!(tables.len(), 2);
        let (gpu, wall) = (tables[0].1.text(), tables[1].1.text());
        assert!(gpu.lines().next().is_some_and(|line| line.ends_with("unit     D0     D1  D1 / D0")), "{gpu}");
        assert!(gpu.contains("frame/image/head/light-orbit/640x360           ms    0.922  2.304     2.50"), "{gpu}");
        assert!(gpu.contains("frame/image/head/light-orbit/1280x720          ms        -  9.216        -"), "{gpu}");
        assert!(gpu.contains("frame/aligned/head/light-orbit/640x360         ms    0.230      -        -"), "{gpu}");
        assert!(!gpu.contains("frames/s") && wall.contains("frames/s"), "rates go by the host's clock\n{gpu}{wall}");
        assert_eq!(wall.lines().count(), 1 + 12, "{wall}");
        results.devices.truncate(1);
        assert!(side_by_side(&results).is_empty());
    }

    #[test]
    fn the_ratio_to_nothing_is_missing() {
        assert_eq!(ratio(Some((1.0, 0.0))), Cell::Missing);
        assert_eq!(ratio(Some((1.0, 4.0))), Cell::Number(0.25, 2));
    }
}
