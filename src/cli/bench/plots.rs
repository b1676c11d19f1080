//! The plots of a run: frame times by size, long runs round by round, rates by frames in flight.

use super::super::plot::{Plot, Point, Series};
use super::results::{DeviceResults, Kind, Measurement, Results};
use super::tables::{short_name, Clock};

type On<'a> = (&'a DeviceResults, &'a Measurement);

/// All plots that have something to show, each with its caption.
pub fn plots(results: &Results) -> Vec<(Plot, String)> {
    let mut plots = Vec::new();
    for (name, group) in grouped(of_kind(results, Kind::Frame), |one| joined([&one.scene, &one.motion])) {
        plots.extend(by_size(results, &name, &group));
    }
    for (name, group) in grouped(of_kind(results, Kind::Sustained), |one| one.id.clone()) {
        plots.extend(by_round(results, &name, &group));
    }
    plots.extend(by_frames_in_flight(results, &of_kind(results, Kind::Throughput)));
    plots
}

/// Frame times of each technique on each device over the size of the frame.
fn by_size(results: &Results, name: &str, group: &[On]) -> Option<(Plot, String)> {
    let clock = Clock::common(group.iter().map(|(_, one)| *one));
    let megapixels = |one: &Measurement| one.size_px.map(f64::from).iter().product::<f64>() / 1e6;
    let series =
        lines(results, group, |one| joined([&one.technique]), |one| Some((megapixels(one), clock.of(one)?.p50)));
    let plot = Plot {
        title: format!("Time of a frame by its size: {name}"),
        x_label: "size / megapixels".into(),
        y_label: format!("{} p50 / {}", clock.word(), unit(group)),
        series,
    };
    let shows = plot.series.iter().any(|line| line.points.len() > 1);
    shows.then(|| (plot, "Half of the frames took no longer.".to_owned()))
}

/// A long run, round by round.
fn by_round(results: &Results, name: &str, group: &[On]) -> Option<(Plot, String)> {
    let line = |(device, one): &On| Series {
        name: on_device(results, device, "median"),
        points: (1..).zip(&one.round_p50).map(|(round, median)| point(f64::from(round), *median)).collect(),
    };
    let plot = Plot {
        title: format!("Time of a frame, round by round: {name}"),
        x_label: "round".into(),
        y_label: format!("{} p50 / {}", Clock::Wall.word(), unit(group)),
        series: group.iter().map(line).collect(),
    };
    let shows = plot.series.iter().any(|line| line.points.len() > 1);
    shows.then(|| (plot, "Half of a round's frames took no longer.".to_owned()))
}

/// Rates over the number of frames that a device has at a time.
fn by_frames_in_flight(results: &Results, group: &[On]) -> Option<(Plot, String)> {
    let what = |one: &Measurement| {
        let [width, height] = one.size_px;
        format!("{} {width}x{height}", joined([&one.technique, &one.scene, &one.motion])).trim_start().to_owned()
    };
    let series = lines(results, group, what, |one| Some((f64::from(one.in_flight?), one.wall.as_ref()?.p50)));
    let plot = Plot {
        title: "Throughput by frames in flight".into(),
        x_label: "frames in flight".into(),
        y_label: format!("rate / ({})", unit(group)),
        series,
    };
    (!plot.series.is_empty()).then(|| (plot, String::new()))
}

/// A line for each name on each device, from left to right.
fn lines(
    results: &Results,
    group: &[On],
    name: impl Fn(&Measurement) -> String,
    place: impl Fn(&Measurement) -> Option<(f64, f64)>,
) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for (device, one) in group {
        let Some((x, y)) = place(one) else { continue };
        let name = on_device(results, device, &name(one));
        match series.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(point(x, y)),
            None => series.push(Series { name, points: vec![point(x, y)] }),
        }
    }
    for line in &mut series {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    series
}

fn of_kind(results: &Results, kind: Kind) -> Vec<On<'_>> {
    let all = results.devices.iter().flat_map(|device| device.measurements.iter().map(move |one| (device, one)));
    all.filter(|(_, one)| one.kind == kind).collect()
}

/// Those of one name together, in the order in which the names come up.
fn grouped<'a>(all: Vec<On<'a>>, name: impl Fn(&Measurement) -> String) -> Vec<(String, Vec<On<'a>>)> {
    let mut groups: Vec<(String, Vec<On>)> = Vec::new();
    for on in all {
        let name = name(on.1);
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, group)) => group.push(on),
            None => groups.push((name, vec![on])),
        }
    }
    groups
}

/// What a line is called: its device is told where there are several.
fn on_device(results: &Results, device: &DeviceResults, what: &str) -> String {
    match results.devices.len() {
        1 => what.to_owned(),
        _ => format!("{what}, {}: {}", short_name(device), device.device.name),
    }
}

fn joined<const N: usize>(words: [&Option<String>; N]) -> String {
    words.into_iter().flatten().map(String::as_str).collect::<Vec<_>>().join(" ")
}

fn unit<'a>(group: &[On<'a>]) -> &'a str {
    group.first().map_or("", |(_, one)| one.unit.as_str())
}

fn point(x: f64, y: f64) -> Point {
    Point { x, y, half_width: None }
}

#[cfg(test)]
mod tests {
    use super::super::example::example;
    use super::*;

    fn points(line: &Series) -> Vec<(f64, f64)> {
        line.points.iter().map(|point| (point.x, point.y)).collect()
    }

    #[test]
    fn frame_times_have_a_line_for_each_technique_on_each_device() {
        let mut results = example();
        results.devices[0].measurements.swap(0, 2);
        let plots = plots(&results);
        let plot = &plots[0].0;
        assert_eq!(plot.title, "Time of a frame by its size: head light-orbit");
        assert_eq!(plot.y_label, "GPU p50 / ms");
        let names: Vec<&str> = plot.series.iter().map(|line| line.name.as_str()).collect();
        let (fast, slow) = ("D0: A Fast GPU", "D1: A <Slow> \"GPU\", | old");
        let expected = [("image", fast), ("aligned", fast), ("image", slow), ("aligned", slow)];
        assert_eq!(names, expected.map(|(technique, device)| format!("{technique}, {device}")));
        assert_eq!(points(&plot.series[0]), [(0.2304, 0.9216), (0.9216, 3.6864), (2.0736, 8.2944)]);
    }

    #[test]
    fn one_device_without_timestamps_makes_all_go_by_the_wall_clock() {
        let mut results = example();
        results.devices[1].measurements[0].gpu = None;
        let plot = &plots(&results)[0].0;
        assert_eq!(plot.y_label, "wall p50 / ms");
        assert_eq!(points(&plot.series[0])[0], (0.2304, 1.4216));
    }

    #[test]
    fn a_long_run_is_drawn_round_by_round() {
        let mut results = example();
        results.devices.truncate(1);
        results.devices[0].measurements.retain(|one| one.kind == Kind::Sustained);
        results.devices[0].measurements[0].round_p50 = vec![1.0, 3.0, 2.0];
        let (plot, _) = plots(&results).remove(0);
        assert_eq!(plot.series.iter().map(|line| line.name.as_str()).collect::<Vec<_>>(), ["median"]);
        assert_eq!(points(&plot.series[0]), [(1.0, 1.0), (2.0, 3.0), (3.0, 2.0)]);
        results.devices[0].measurements[0].round_p50.truncate(1);
        assert!(plots(&results).is_empty(), "a single round shows nothing");
    }

    #[test]
    fn rates_go_by_frames_in_flight() {
        let plots = plots(&example());
        let (plot, _) = plots.last().expect("a plot");
        assert_eq!(plot.y_label, "rate / (frames/s)");
        assert!(plot.series[0].name.starts_with("image head light-orbit 512x512, D0"), "{}", plot.series[0].name);
        assert_eq!(points(&plot.series[0]).iter().map(|point| point.0).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn nothing_is_drawn_of_a_single_size() {
        let mut results = example();
        for device in &mut results.devices {
            device.measurements.retain(|one| one.kind == Kind::Frame && one.size_px == [640, 360]);
        }
        assert!(plots(&results).is_empty());
    }
}
