//! The results for a terminal: a table for each device.

use super::results::{DeviceResults, Measurement, Results, Samples};
use crate::cli::table::{Cell, Table};

/// The tables of all devices, without a line end at the end.
pub fn text(results: &Results) -> String {
    let tables: Vec<String> = results.devices.iter().map(device).collect();
    tables.join("\n")
}

fn device(found: &DeviceResults) -> String {
    let device = &found.device;
    let mut text =
        format!("device {}: {} ({}), Vulkan {}\n", device.index, device.name, device.kind, device.api_version);
    let compiled: Vec<String> = found.compile_ms.iter().map(|(name, ms)| format!("{name} {ms:.0}")).collect();
    text += &format!("opened in {:.0} ms; pipelines compiled in ms: {}\n", found.open_ms, compiled.join(", "));
    let mut table = Table::new(["scene", "unit", "GPU p50", "GPU p95", "wall p50", "wall p95", "check"]);
    for one in &found.measurements {
        table.row(row(one));
    }
    text += table.text().trim_end();
    if let Some(error) = &found.error {
        text += &format!("\ngiven up: {error}");
    }
    text
}

fn row(one: &Measurement) -> Vec<Cell> {
    let decimals = if one.unit == "ms" { 2 } else { 1 };
    let number = |of: &Option<Samples>, which: fn(&Samples) -> f64| {
        of.as_ref().map_or(Cell::Missing, |samples| Cell::Number(which(samples), decimals))
    };
    vec![
        one.id.as_str().into(),
        one.unit.as_str().into(),
        number(&one.gpu, |samples| samples.p50),
        number(&one.gpu, |samples| samples.p95),
        number(&one.wall, |samples| samples.p50),
        number(&one.wall, |samples| samples.p95),
        one.check.verdict.as_str().into(),
    ]
}
