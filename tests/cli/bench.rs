//! bench: one small scene, checked; what is wrong on the command line.

use crate::support::Place;
use serde_json::Value;

/// Keys of an object, in alphabetical order.
fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

#[test]
fn a_scene_by_name_gives_all_figures_and_is_right() {
    let place = Place::new();
    let before = place.files();
    let report = place.json("bench synthesis/guided/256x256 --validate");
    assert_eq!(
        keys(&report),
        ["devices", "parameters", "schema", "seconds", "started", "system", "tool"],
        "the document of results alone"
    );
    assert_eq!(report["schema"], 1);
    assert_eq!(report["tool"]["name"], "impasto");
    assert_eq!(report["parameters"]["set"], "synthesis/guided/256x256");
    assert_eq!(report["parameters"]["seed"], 1);
    let numbers = &report["parameters"]["numbers"];
    assert!(numbers["comparisons_per_submission"].as_f64() <= Some(4e8), "no watchdog minds");
    let devices = report["devices"].as_array().expect("devices");
    assert_eq!(devices.len(), 1);
    let device = &devices[0];
    assert!(device["open_ms"].as_f64() > Some(0.0) && device["compile_ms"]["synthesis"].as_f64() > Some(0.0));
    assert!(device["error"].is_null());
    assert!(device["device"]["name"].is_string() && device["device"]["uuid"].is_string());
    let measurements = device["measurements"].as_array().expect("measurements");
    assert_eq!(measurements.len(), 1);
    let one = &measurements[0];
    assert_eq!(
        keys(one),
        [
            "check",
            "gpu",
            "id",
            "in_flight",
            "kind",
            "memory_bytes",
            "more_is_better",
            "motion",
            "round_p50",
            "scene",
            "size_px",
            "technique",
            "telemetry",
            "unit",
            "wall"
        ]
    );
    assert_eq!((&one["id"], &one["kind"]), (&"synthesis/guided/256x256".into(), &"synthesis".into()));
    assert_eq!((&one["unit"], &one["more_is_better"]), (&"blocks/s".into(), &true.into()));
    assert_eq!(one["check"]["verdict"], "ok", "the bytes of the CPU oracle");
    assert_eq!(one["check"]["hash"].as_str().map(str::len), Some(16));
    assert_eq!(keys(&one["wall"]), ["max", "min", "p50", "p90", "p95", "p99", "raw"]);
    let rounds = numbers["rounds"].as_f64().expect("a number") as usize;
    assert_eq!(one["wall"]["raw"].as_array().map(Vec::len), Some(rounds));
    assert_eq!(one["round_p50"].as_array().map(Vec::len), Some(rounds));
    assert!(one["wall"]["min"].as_f64() > Some(0.0));
    assert!(place.files() == before, "nothing was written");
}

#[test]
fn every_technique_is_measured_in_frames_that_go_on_from_each_other() {
    let place = Place::new();
    let report = place.json("bench teapot/cut/512x512 --devices 0,0 --validate");
    let devices = report["devices"].as_array().expect("devices");
    assert_eq!(devices.len(), 1, "a device that is named twice is measured once");
    let measurements = devices[0]["measurements"].as_array().expect("measurements");
    let techniques: Vec<_> = measurements.iter().map(|one| one["technique"].as_str().expect("a name")).collect();
    assert_eq!(techniques, ["object", "image", "aligned", "dependent"]);
    assert_eq!(keys(&devices[0]["compile_ms"]), ["aligned", "dependent", "image", "object"]);
    let numbers = &report["parameters"]["numbers"];
    let frames = numbers["frames"].as_f64().expect("a number") * numbers["rounds"].as_f64().expect("a number");
    for one in measurements {
        assert_eq!((&one["kind"], &one["scene"], &one["motion"]), (&"frame".into(), &"teapot".into(), &"cut".into()));
        assert_eq!(one["check"]["verdict"], "ok", "{}", one["id"]);
        assert_eq!(one["wall"]["raw"].as_array().map(Vec::len), Some(frames as usize), "{}", one["id"]);
        assert!(one["memory_bytes"].as_u64() > Some(512 * 512 * 4), "{}", one["id"]);
    }
    let hashes: std::collections::BTreeSet<_> = measurements.iter().map(|one| one["check"]["hash"].as_str()).collect();
    assert_eq!(hashes.len(), 4, "each paints in its own way");
}

#[test]
fn what_is_printed_is_what_is_written_and_can_be_compared_with() {
    let place = Place::new();
    let document = place.ok("bench synthesis/guided/256x256 --sustained --json -o kept");
    let printed: Value = serde_json::from_str(&document).expect("JSON");
    let kept: Value = serde_json::from_str(&place.text("kept/bench.json")).expect("JSON");
    assert_eq!(printed, kept);
    let one = &printed["devices"][0]["measurements"][0];
    assert_eq!(one["round_p50"].as_array().map(Vec::len), Some(30));
    assert_eq!(one["wall"]["raw"].as_array().map(Vec::len), Some(1), "the slowest round alone");
    let rounds = one["round_p50"].as_array().expect("rounds").iter().map(|rate| rate.as_f64().expect("a number"));
    assert_eq!(one["wall"]["p50"].as_f64(), rounds.min_by(f64::total_cmp));
    std::fs::write(place.path("old.json"), document).expect("a file");
    let again = place.json("bench synthesis/guided/256x256 --compare old.json");
    assert!(again["comparison"].is_object(), "{}", again["comparison"]);
    assert_eq!(again["devices"][0]["measurements"][0]["check"], one["check"], "the same bytes in another run");
}

#[test]
fn names_are_listed_and_unknown_ones_told() {
    let place = Place::new();
    let names = place.ok("bench --list");
    assert_eq!(names.lines().filter(|line| line.starts_with("frame/")).count(), 192);
    assert!(names.lines().any(|line| line == "frame/dependent/many/zoom/3840x2160"), "{names}");
    place.fails("bench teacup", 1, &["there is no scene `teacup`", "SCENE head|teapot|many", "--list"]);
    place.fails("bench head --full", 2, &["--full"]);
}

#[test]
fn devices_that_are_not_there_are_told() {
    let place = Place::new();
    place.fails("bench synthesis/free/256x256 --devices 0,99", 1, &["--devices: device 99 was not found"]);
    place.fails("bench synthesis/free/256x256 --devices nowhere", 1, &["--devices: a device named \"nowhere\""]);
    place.fails("bench synthesis/free/256x256 --devices 0,", 1, &["--devices: a place of the list is empty"]);
    place.fails("bench synthesis/free/256x256 --device nowhere", 1, &["--device: a device named \"nowhere\""]);
    place.fails("bench synthesis/free/256x256 --device 0 --devices 0", 2, &["--devices"]);
}
