//! A run as comma-separated values: a row for each measurement of each device. Raw samples are only in the JSON.

use super::super::table::{Cell, Table};
use super::results::{Device, Kind, Measurement, Results, Samples};

/// Columns before the percentiles, and after them.
const BEFORE: [&str; 14] = [
    "device_index",
    "device",
    "uuid",
    "driver",
    "id",
    "kind",
    "technique",
    "scene",
    "motion",
    "width_px",
    "height_px",
    "in_flight",
    "unit",
    "more_is_better",
];
const PERCENTILES: [&str; 7] = ["p50", "p90", "p95", "p99", "min", "max", "samples"];
const AFTER: [&str; 7] = ["memory_bytes", "hash", "check", "core_mhz", "memory_mhz", "celsius", "watts"];

/// The file's text.
pub fn csv(results: &Results) -> String {
    let clock = |name| PERCENTILES.map(move |percentile| format!("{name}_{percentile}"));
    let headers = BEFORE.map(str::to_owned).into_iter().chain(clock("gpu")).chain(clock("wall"));
    let mut table = Table::new(headers.chain(AFTER.map(str::to_owned)));
    for device in &results.devices {
        for one in &device.measurements {
            let clocks = [&one.gpu, &one.wall].into_iter().flat_map(|samples| percentiles(samples.as_ref()));
            table.row(before(&device.device, one).into_iter().chain(clocks).chain(after(one)));
        }
    }
    table.csv()
}

fn before(device: &Device, one: &Measurement) -> [Cell; BEFORE.len()] {
    [
        whole(device.index as f64),
        device.name.as_str().into(),
        device.uuid.as_str().into(),
        device.driver().into(),
        one.id.as_str().into(),
        word(one.kind).into(),
        text(&one.technique),
        text(&one.scene),
        text(&one.motion),
        whole(f64::from(one.size_px[0])),
        whole(f64::from(one.size_px[1])),
        one.in_flight.map_or(Cell::Missing, |frames| whole(f64::from(frames))),
        one.unit.as_str().into(),
        one.more_is_better.to_string().into(),
    ]
}

fn percentiles(samples: Option<&Samples>) -> [Cell; PERCENTILES.len()] {
    let Some(Samples { p50, p90, p95, p99, min, max, raw }) = samples else { return [const { Cell::Missing }; 7] };
    [*p50, *p90, *p95, *p99, *min, *max, raw.len() as f64].map(whole)
}

fn after(one: &Measurement) -> [Cell; AFTER.len()] {
    let number = |value: Option<f64>| value.map_or(Cell::Missing, whole);
    let telemetry = one.telemetry.clone().unwrap_or_default();
    [
        whole(one.memory_bytes as f64),
        one.check.hash.as_str().into(),
        one.check.verdict.as_str().into(),
        number(telemetry.core_mhz),
        number(telemetry.memory_mhz),
        number(telemetry.celsius),
        number(telemetry.watts),
    ]
}

/// The same word as in the JSON.
fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Frame => "frame",
        Kind::Synthesis => "synthesis",
        Kind::Preparation => "preparation",
        Kind::Throughput => "throughput",
        Kind::Sustained => "sustained",
    }
}

fn text(text: &Option<String>) -> Cell {
    text.as_deref().map_or(Cell::Missing, Cell::from)
}

/// A file has all digits of a number.
fn whole(value: f64) -> Cell {
    Cell::Number(value, 0)
}

#[cfg(test)]
mod tests {
    use super::super::example::example;
    use super::*;

    #[test]
    fn there_is_a_row_for_each_measurement_of_each_device_and_a_cell_for_each_column() {
        let results = example();
        let csv = csv(&results);
        assert_eq!(
            csv.lines().count(),
            1 + results.devices.iter().map(|device| device.measurements.len()).sum::<usize>()
        );
        let columns = BEFORE.len() + 2 * PERCENTILES.len() + AFTER.len();
        // No text of the first device holds a comma.
        assert!(csv.lines().take(13).all(|line| line.split(',').count() == columns), "{csv}");
        let first =
            "0,A Fast GPU,0000-0,a driver 1.2.3,frame/image/head/light-orbit/640x360,frame,image,head,light-orbit,\
                     640,360,,ms,false,0.9216,";
        assert!(csv.lines().nth(1).is_some_and(|line| line.starts_with(first)), "{csv}");
        assert!(
            csv.lines().nth(1).is_some_and(|line| line.ends_with(",3,50331648,00ff,ok,1980,2619,41,305.5")),
            "{csv}"
        );
    }

    #[test]
    fn names_are_quoted_where_they_must_be_and_what_is_missing_is_empty() {
        let csv = csv(&example());
        assert!(csv.contains("\n1,\"A <Slow> \"\"GPU\"\", | old\",0000-1,"), "{csv}");
        assert!(csv.contains(",synthesis/512x512,synthesis,,,,512,512,,blocks/s,true,,,,,,,,25000,26000,"), "{csv}");
    }

    #[test]
    fn kinds_have_the_words_of_the_json() {
        for (kind, _) in super::super::tables::KINDS {
            assert_eq!(serde_json::to_value(kind).expect("JSON"), word(kind));
        }
    }
}
