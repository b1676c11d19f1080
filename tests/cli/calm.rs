//! measure calm.

use crate::support::Place;
use serde_json::Value;

const WAYS: [&str; 9] = [
    "object",
    "image anew",
    "image match",
    "image match, blend 4",
    "image carry",
    "aligned following",
    "aligned still",
    "dependent",
    "dependent, chosen anew",
];
const CALM: &str = "measure calm scene.obj --paint strip.png --size 112x96 --block 16 --overlap 4 --k 1 --samples 20 \
                    --level-count 4 --level-size 64 --frames 0..2";

fn figure(report: &Value, way: &str, name: &str) -> f64 {
    let rows = report["figures"].as_array().expect("figures");
    let row = rows.iter().find(|row| row["technique"] == way).unwrap_or_else(|| panic!("no {way} in {report}"));
    row["figures"][name].as_f64().unwrap_or_else(|| panic!("no {name} in {row}"))
}

#[test]
fn every_way_is_measured_against_frames_without_coherence() {
    let place = Place::new();
    let report = place.json(&format!("{CALM} --validate"));
    let parameters = &report["parameters"];
    assert_eq!((&parameters["orbit"], &parameters["frames"]), (&1.0.into(), &"0..2".into()));
    let names: Vec<_> = report["figures"].as_array().expect("figures").iter().map(|row| &row["technique"]).collect();
    assert_eq!(names, WAYS);
    let limits = ["stretch", "slack", "repair_tolerance", "match_weight"];
    assert!(limits.iter().all(|name| parameters[name].is_f64()), "{parameters}");
    let of = |way: &str, name: &str| figure(&report, way, name);
    for way in WAYS {
        for kind in ["difference_nearest", "difference_bilinear"] {
            let (value, anew) = (of(way, kind), of("image anew", kind));
            assert!(value > 0.0 && (of(way, &format!("{kind}_of_anew")) - value / anew).abs() < 1e-9, "{way}: {kind}");
        }
        for kind in ["sharpness", "stroke_px"] {
            let [first, last, ratio] = ["first", "last", "ratio"].map(|part| of(way, &format!("{kind}_{part}")));
            assert!(first > 0.0 && (ratio - last / first).abs() < 1e-9, "{way}: {kind}");
        }
        assert!(of(way, "median_ms") > 0.0);
    }
    assert_eq!(of("image anew", "difference_nearest_of_anew"), 1.0);
    assert!(of("object", "difference_nearest_of_anew") < 0.9, "paint that lies on the model moves with it");
    let text = place.ok(CALM);
    assert!(WAYS.iter().all(|way| text.lines().any(|line| line.starts_with(way))), "{text}");
}

#[test]
fn similarity_is_that_of_the_last_frame() {
    let place = Place::new();
    let report = place.json(CALM);
    place.ok("animate scene.obj --paint strip.png --size 112x96 --block 16 --overlap 4 --orbit 1 --frames 0..2 \
              --technique object -o frames/%d.png");
    let last = place.json("measure similarity strip.png frames/2.png --samples 20");
    let row = report["figures"].as_array().expect("figures").iter().find(|row| row["technique"] == "object");
    assert_eq!(row.expect("a row")["figures"]["similarity"], last["figures"]["similarity"]);
}

#[test]
fn a_scene_that_stands_still_is_perfectly_calm_unless_it_is_painted_anew() {
    let place = Place::new();
    let report = place.json(&format!("{CALM} --orbit 0"));
    for way in WAYS {
        let value = figure(&report, way, "difference_nearest");
        assert!(value == figure(&report, way, "difference_bilinear"), "{way}: no pixel moves");
        assert!((value == 0.0) == (way != "image anew"), "{way}: {value}");
    }
}

#[test]
fn some_ways_can_be_chosen_by_name() {
    let place = Place::new();
    let words: Vec<&str> = CALM.split_whitespace().collect();
    let ran = place.run_words(&[&words[..], &["--way", "image match, blend 4", "--way", "object"]].concat());
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    // In the order of the table; and without frames made anew there is nothing to compare with.
    let rows = ran.stdout.lines().filter(|line| WAYS.iter().any(|way| line.starts_with(way))).collect::<Vec<_>>();
    assert!(rows.len() == 2 && rows[0].starts_with("object") && rows[1].starts_with(WAYS[3]), "{}", ran.stdout);
    let mut told = vec!["--way"];
    told.extend(WAYS);
    place.fails("measure calm scene.obj --paint strip.png --way nonsense", 2, &told);
}

#[test]
fn nothing_is_carried_nor_compared_across_a_cut() {
    let place = Place::new();
    let motion = r#"{"camera": [{"frame": 0}, {"frame": 2, "orbit": 2}, {"frame": 3, "orbit": 170}]}"#;
    std::fs::write(place.path("cut.json"), motion).expect("written");
    let line =
        |frames: &str| CALM.replace("0..2", frames) + " --way object --way dependent --views 30:20 --motion cut.json";
    let [before, over, only] = ["0..2", "0..3", "2..3"].map(|frames| place.json(&line(frames)));
    for way in ["object", "dependent"] {
        let of = |report: &Value| figure(report, way, "difference_nearest");
        assert_eq!(of(&before), of(&over), "{way}");
    }
    assert!(only["figures"][0]["figures"]["difference_nearest"].is_null(), "{only}");
}

#[test]
fn what_cannot_be_measured_is_told() {
    let place = Place::new();
    for (flags, code, parts) in [
        ("--stretch 1.6", 1, ["--stretch is 1.6", "1.05 to 1.5"]),
        ("--slack -1", 1, ["--slack is -1", "0 to 100"]),
        ("--repair-tolerance 11", 1, ["--repair-tolerance is 11", "0 to 10"]),
        ("--match-weight 3.5", 1, ["--match-weight is 3.5", "0.25 to 3"]),
        // What the ways decide.
        ("--coherence carry", 2, ["unexpected", "--coherence"]),
        ("--blend-over 3", 2, ["unexpected", "--blend-over"]),
    ] {
        place.fails(&format!("measure calm scene.obj --paint strip.png {flags}"), code, &parts);
    }
    place.fails("measure calm scene.obj --paint strip.png --frames 4..4", 1, &["--frames", "4..4", "two frames"]);
    place.fails("measure calm scene.obj --paint strip.png --technique image", 2, &["--technique"]);
    place.fails("measure calm scene.obj", 2, &["--paint"]);
    place.fails("measure calm scene.obj --paint strip.png --block 48 --overlap 4", 1, &["strip.png", "48"]);
    let ran = place.run(&format!("{CALM} --paint floor=other.png --json"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.contains("similarity is left out") && !ran.stdout.contains("\"similarity\""), "{}", ran.stderr);
}
