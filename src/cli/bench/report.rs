//! What terminal, Markdown and page all say of a run, as parts in order; each writes them in its own way.

use super::super::plot::Plot;
use super::super::table::{Cell, Table};
use super::compare::{Change, Comparison, DeviceComparison};
use super::plots;
use super::results::{DeviceResults, Results};
use super::tables::{self, figure, short_name, Clock};
use std::path::Path;

/// A part of a report.
#[derive(Debug)]
pub enum Part {
    /// Begins a section.
    Heading(String),
    /// A sentence.
    Note(String),
    /// Names with what they stand for.
    Facts(Vec<(String, String)>),
    /// A table with its caption.
    Table(String, Table),
    /// A table that the terminal leaves out, and Markdown folds.
    Detail(String, Table),
    /// A plot with its caption, for the page, which puts a heading above the first.
    Plot(Plot, String),
}

/// What every report is called.
pub const TITLE: &str = "impasto bench";

/// All that is to say of a run, and of how it compares with the one in a file.
pub fn parts(results: &Results, compared: Option<(&Path, &Comparison)>) -> Vec<Part> {
    let mut parts = vec![Part::Facts(run_facts(results)), Part::Note(checks(results))];
    for device in &results.devices {
        add_device(&mut parts, device);
    }
    let side_by_side = tables::side_by_side(results);
    if !side_by_side.is_empty() {
        parts.push(Part::Heading("Devices side by side".into()));
        parts.extend(side_by_side.into_iter().map(|(caption, table)| Part::Table(caption, table)));
    }
    parts.extend(plots::plots(results).into_iter().map(|(plot, caption)| Part::Plot(plot, caption)));
    if let Some((path, comparison)) = compared {
        add_comparison(&mut parts, path, comparison);
    }
    parts
}

fn fact(name: &str, value: impl Into<String>) -> (String, String) {
    (name.to_owned(), value.into())
}

fn run_facts(results: &Results) -> Vec<(String, String)> {
    let Results { tool, system, parameters, .. } = results;
    let commit = tool.commit.as_ref().map_or(String::new(), |commit| format!(", commit {commit}"));
    let cpu = system.cpu.as_deref().unwrap_or("unknown processor");
    let numbers = parameters.numbers.iter().map(|(name, value)| format!(", {} {value}", name.replace('_', " ")));
    vec![
        fact("program", format!("{} {}{commit}, {} build", tool.name, tool.version, tool.profile)),
        fact("begun", format!("{}, took {:.1} s", results.started, results.seconds)),
        fact("system", format!("{}, {}", system.os, system.arch)),
        fact("processor", format!("{cpu}, {} threads", system.cores)),
        fact("parameters", format!("{}, seed {}{}", parameters.set, parameters.seed, numbers.collect::<String>())),
    ]
}

/// Whether all results are right, in words.
fn checks(results: &Results) -> String {
    let all = || results.devices.iter().flat_map(|device| device.measurements.iter().map(move |one| (device, one)));
    let wrong: Vec<String> = all()
        .filter(|(_, one)| !one.check.is_ok())
        .map(|(device, one)| format!("{} {} ({})", short_name(device), one.id, one.check.verdict))
        .collect();
    let failed: usize = results.devices.iter().map(|device| device.failures.len()).sum();
    let failed = if failed > 0 { format!(" {failed} could not be measured.") } else { String::new() };
    match (wrong.len(), all().count()) {
        (0, 0) => format!("There are no results.{failed}"),
        (0, all) => format!("All {all} results are right.{failed}"),
        (count, all) => format!("{count} of {all} results are WRONG: {}.{failed}", wrong.join("; ")),
    }
}

fn add_device(parts: &mut Vec<Part>, one: &DeviceResults) {
    let device = &one.device;
    parts.push(Part::Heading(format!("{}: {}", short_name(one), device.name)));
    let driver = format!("{}, Vulkan {}", device.driver(), device.api_version);
    let address = device.pci.as_ref().map_or(String::new(), |pci| format!(", at {pci}"));
    let ids = format!("{:04x}:{:04x}", device.vendor_id, device.device_id);
    let compile: f64 = one.compile_ms.values().sum();
    parts.push(Part::Facts(vec![
        fact("driver", driver),
        fact("device", format!("{}, {ids}{address}, UUID {}", device.kind, device.uuid)),
        fact("opened in", format!("{:.1} ms; its driver first compiled pipelines for {compile:.1} ms", one.open_ms)),
    ]));
    parts.extend(one.error.iter().map(|error| Part::Note(format!("The device was given up: {error}"))));
    if !one.failures.is_empty() {
        parts.push(Part::Table("What could not be measured".to_owned(), tables::failed(one)));
    }
    let tables = tables::by_kind(one).into_iter();
    parts.extend(tables.map(|(heading, table)| Part::Table(heading.to_owned(), table)));
    let details = [
        ("Milliseconds that the driver took to compile pipelines for the first time", tables::compiled(one)),
        ("The device at the end of each measurement", tables::telemetry(one)),
    ];
    let told = details.into_iter().filter(|(_, table)| table.rows().next().is_some());
    parts.extend(told.map(|(caption, table)| Part::Detail(caption.to_owned(), table)));
}

fn add_comparison(parts: &mut Vec<Part>, path: &Path, comparison: &Comparison) {
    parts.push(Part::Heading(format!("Compared with {}", path.display())));
    parts.extend(comparison.notes.iter().map(|note| Part::Note(note.clone())));
    for device in &comparison.devices {
        parts.push(Part::Heading(format!("D{}: {}, then and now", device.index, device.name)));
        parts.extend(device.notes.iter().map(|note| Part::Note(note.clone())));
        let changed = device.changed_bytes();
        if !changed.is_empty() {
            let (count, all) = (changed.len(), device.rows.len());
            parts.push(Part::Note(format!("other bytes came out of {count} of {all}: {}", changed.join(", "))));
        }
        let summaries = [Clock::Gpu, Clock::Wall].into_iter().filter_map(|clock| device.summary(clock));
        parts.extend(summaries.map(Part::Note));
        if !device.rows.is_empty() {
            parts.push(Part::Table("Medians".into(), compared(device)));
        }
    }
}

fn compared(device: &DeviceComparison) -> Table {
    let clock = |clock: Clock| {
        let word = clock.word();
        [format!("{word} then"), "now".into(), "now / then".into(), "is".into()]
    };
    let headers = std::iter::once("measurement".to_owned()).chain(clock(Clock::Gpu)).chain(clock(Clock::Wall));
    let mut table = Table::new(headers.chain(["unit".into(), "bytes".into()]));
    for row in &device.rows {
        let bytes = row.same_bytes.map_or(Cell::Missing, |same| if same { "same" } else { "changed" }.into());
        let changes = [&row.gpu, &row.wall].into_iter().flat_map(|change| change_cells(change.as_ref()));
        let end = [row.unit.as_str().into(), bytes];
        table.row(std::iter::once(row.id.as_str().into()).chain(changes).chain(end));
    }
    table
}

fn change_cells(change: Option<&Change>) -> [Cell; 4] {
    let Some(Change { old, new, verdict, .. }) = change else { return [const { Cell::Missing }; 4] };
    [figure(Some(*old)), figure(Some(*new)), tables::ratio(Some((*new, *old))), verdict.word().into()]
}

#[cfg(test)]
pub mod tests {
    use super::super::example::example;
    use super::*;

    /// All parts of the example against a run that was twice as slow by the device's clock, with one change of bytes.
    pub fn example_parts() -> Vec<Part> {
        let mut old = example();
        old.tool.commit = Some("0000000".into());
        for one in old.devices.iter_mut().flat_map(|device| &mut device.measurements) {
            if let Some(gpu) = &mut one.gpu {
                gpu.p50 *= 2.0;
            }
        }
        old.devices[0].measurements[0].check.hash = "other".into();
        parts(&example(), Some((Path::new("old/bench.json"), &Comparison::new(&old, &example()))))
    }

    fn notes() -> Vec<String> {
        let notes = example_parts().into_iter().filter_map(|part| match part {
            Part::Note(text) => Some(text),
            _ => None,
        });
        notes.collect()
    }

    #[test]
    fn wrong_results_are_told_first() {
        let wrong = "1 of 24 results are WRONG: D1 frame/image/head/light-orbit/640x360 \
                     (bytes change from round to round | twice). 1 could not be measured.";
        assert_eq!(notes()[0], wrong);
        let mut results = example();
        results.devices.truncate(1);
        assert_eq!(checks(&results), "All 12 results are right.");
        results.devices[0].measurements.clear();
        assert_eq!(checks(&results), "There are no results.");
    }

    #[test]
    fn a_comparison_tells_ratios_and_what_changed() {
        let notes = notes();
        for note in [
            "tool.commit differs: then 0000000, now 1234abc+",
            "other bytes came out of 1 of 12: frame/image/head/light-orbit/640x360",
            "GPU medians: 8 faster, 0 slower, 0 same; in the geometric mean 2.00 times as fast",
        ] {
            assert!(notes.iter().any(|one| one == note), "{note} in {notes:#?}");
        }
        let tables: Vec<String> = example_parts()
            .into_iter()
            .filter_map(|part| match part {
                Part::Table(caption, table) if caption == "Medians" => Some(table.csv()),
                _ => None,
            })
            .collect();
        let row = "frame/image/head/light-orbit/640x360,1.8432,0.9216,0.5,faster,1.4216,1.4216,1,same,ms,changed\n";
        assert!(tables.len() == 2 && tables[0].contains(row), "{tables:?}");
    }

    #[test]
    fn a_device_alone_has_nothing_beside_it() {
        let mut results = example();
        results.devices.truncate(1);
        let headings: Vec<String> = parts(&results, None)
            .into_iter()
            .filter_map(|part| match part {
                Part::Heading(text) => Some(text),
                _ => None,
            })
            .collect();
        assert_eq!(headings, ["D0: A Fast GPU"]);
    }
}
