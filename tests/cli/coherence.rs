//! animate, frames that go on from those before: cuts, kills, objects that come and go, light that moves.

use crate::support::{strip, Place};
use image::RgbaImage;
use std::fs;
use std::time::{Duration, Instant};

/// Every way in which a frame goes on from those before it.
const WAYS: [&str; 5] = [
    "image --coherence carry",
    "image --coherence match",
    "image --coherence match --blend-over 3",
    "aligned",
    "dependent --views 30:20,60:20",
];
const SCENE: &str = "scene.obj --paint strip.png --paint floor=other.png --size 64x48 --block 16 --overlap 4 --k 1 \
                     --level-count 4 --level-size 64";

fn animate(way: &str, frames: &str, folder: &str) -> String {
    format!("animate {SCENE} --technique {way} --frames {frames} -o {folder}/%d.png")
}

fn frame(place: &Place, folder: &str, number: u32) -> RgbaImage {
    place.picture(&format!("{folder}/{number}.png"))
}

#[test]
fn sequences_are_the_same_for_any_number_of_threads() {
    let [none, one, two] = ["0", "1", "2"].map(|threads| Place::new().with_variable("LP_NUM_THREADS", threads));
    for (way, folder) in [(WAYS[0], "carry"), (WAYS[2], "match")] {
        let line = animate(way, "0..4", folder) + " --orbit 6 --light-orbit 9";
        for place in [&none, &one, &two] {
            place.ok(&line);
        }
        two.ok(&line.replace("/%d", "/again%d"));
        for number in 0..=4 {
            let name = format!("{folder}/{number}.png");
            let bytes = two.bytes(&name);
            assert!(bytes == two.bytes(&format!("{folder}/again{number}.png")), "{way}: {name}, again");
            assert!(bytes == one.bytes(&name) && bytes == none.bytes(&name), "{way}: {name}");
        }
        assert!(frame(&two, folder, 3) != frame(&two, folder, 4), "{way}: it moves");
    }
}

#[test]
fn a_run_that_was_killed_goes_on_where_it_was() {
    let place = Place::new();
    let line = |folder: &str| animate(WAYS[0], "0..59", folder) + " --orbit 3";
    let path = |folder: &str, number: u32| place.path(&format!("{folder}/{number}.png"));
    let finished = || (0..60).filter(|&number| path("out", number).exists()).collect::<Vec<_>>();
    let mut child = place.start(&line("out"));
    let started = Instant::now();
    while finished().len() < 3 {
        assert!(child.try_wait().expect("a child").is_none() && started.elapsed() < Duration::from_secs(300));
        std::thread::sleep(Duration::from_millis(1));
    }
    // SIGKILL, which nothing can be done about.
    child.kill().expect("killed");
    child.wait().expect("it has ended");
    let there = finished();
    assert!(there.len() < 60, "it was killed in the middle");
    let modified = |number: u32| fs::metadata(path("out", number)).and_then(|data| data.modified()).expect("a time");
    let before: Vec<_> = there.iter().map(|&number| modified(number)).collect();

    place.ok(&line("whole"));
    let same =
        |number: u32| fs::read(path("out", number)).expect("a frame") == fs::read(path("whole", number)).expect("one");
    assert!(there.iter().all(|&number| same(number)), "what has its name is whole");
    let report = place.json(&(line("out") + " --resume"));
    let count = |name: &str| report["rendered"][name].as_u64().unwrap_or_else(|| panic!("{name} in {report}"));
    assert_eq!((count("frames"), count("replayed")), (60 - there.len() as u64, there.len() as u64));
    assert!((0..60).all(same), "all of it as if nothing had happened");
    assert!(place.bytes("out/animation.json") == place.bytes("whole/animation.json"));
    assert_eq!(
        there.iter().map(|&number| modified(number)).collect::<Vec<_>>(),
        before,
        "finished ones are left alone"
    );
}

#[test]
fn after_a_cut_frames_are_those_of_a_run_that_begins_there() {
    let place = Place::new();
    // The jump is not called a cut: the camera tells.
    let jump = r#"{"camera": [{"frame": 0}, {"frame": 3, "orbit": 9}, {"frame": 4, "orbit": 130},
                              {"frame": 7, "orbit": 139}]}"#;
    let called = r#"{"camera": [{"frame": 0}, {"frame": 7, "orbit": 21}], "cuts": [4]}"#;
    for (name, motion) in [("jump", jump), ("called", called)] {
        fs::write(place.path(&format!("{name}.json")), motion).expect("written");
    }
    let ways = WAYS.map(|way| (way, "jump")).into_iter().chain([(WAYS[0], "called")]);
    for (index, (way, name)) in ways.enumerate() {
        let line = |frames: &str, part: &str| {
            animate(way, frames, &format!("{index}/{part}")) + &format!(" --motion {name}.json")
        };
        let report = place.json(&line("0..7", "all"));
        assert_eq!(report["rendered"]["cuts"], serde_json::json!([4]));
        place.ok(&line("4..7", "shot"));
        place.ok(&line("3..3", "middle"));
        let same = |part: &str, number: u32| {
            frame(&place, &format!("{index}/all"), number) == frame(&place, &format!("{index}/{part}"), number)
        };
        assert!((4..=7).all(|number| same("shot", number)), "{way}, {name}");
        assert!(!same("middle", 3), "{way}, {name}: without a cut it matters what was before");
    }
}

#[test]
fn texture_is_blended_towards_frames_of_the_same_shot_only() {
    let place = Place::new();
    let line = |over: u32, frames: &str, folder: &str, more: &str| {
        animate(&format!("image --coherence match --blend-over {over}"), frames, folder) + more
    };
    // Far beyond the last frame there is no camera any more.
    place.ok(&line(1000, "0..3", "zoom", " --zoom 0.9"));
    // The frame that the first ones are blended towards would be the one after the cut.
    let cut = r#"{"camera": [{"frame": 0}, {"frame": 2, "orbit": 6}, {"frame": 3, "orbit": 180}]}"#;
    fs::write(place.path("cut.json"), cut).expect("written");
    place.ok(&line(3, "0..2", "short", " --motion cut.json"));
    place.ok(&line(3, "0..4", "long", " --motion cut.json"));
    assert!((0..=2).all(|number| frame(&place, "short", number) == frame(&place, "long", number)));
}

#[test]
fn objects_may_leave_the_picture_and_come_back() {
    let place = Place::new();
    let one = r#"{"objects": {"tent": [{"frame": 0}, {"frame": 2, "move": [60, 0, 0]}, {"frame": 5}]}}"#;
    let all = r#"{"objects": {"all": [{"frame": 0}, {"frame": 2, "move": [0, 0, 500]}, {"frame": 5}]}}"#;
    let alpha = |folder: &str, number: u32| -> Vec<u8> {
        frame(&place, folder, number).pixels().map(|pixel| pixel.0[3]).collect()
    };
    for (name, motion) in [("one", one), ("all", all)] {
        fs::write(place.path(&format!("{name}.json")), motion).expect("written");
        let line = |way: &str, folder: &str| {
            animate(way, "0..5", &format!("{name}/{folder}")) + &format!(" --motion {name}.json")
        };
        place.ok(&line("image --coherence anew", "anew"));
        let anew = |number: u32| alpha(&format!("{name}/anew"), number);
        let covered = |number: u32| anew(number).iter().filter(|&&alpha| alpha == 255).count();
        assert!(covered(0) > 200 && covered(2) < covered(0) && covered(5) == covered(0), "{name}");
        assert_eq!(covered(2) == 0, name == "all");
        for (index, way) in WAYS.iter().enumerate() {
            place.ok(&line(way, &index.to_string()));
            for number in 0..=5 {
                assert!(alpha(&format!("{name}/{index}"), number) == anew(number), "{name}, {way}: frame {number}");
            }
        }
    }
}

#[test]
fn texture_stays_under_a_light_that_moves_until_it_no_longer_fits() {
    let place = Place::new();
    let line = |way: &str, folder: &str| animate(&format!("image {way}"), "0..11", folder) + " --light-orbit 8";
    place.ok(&line("--coherence carry", "carry"));
    place.ok(&line("--coherence carry --slack 100", "never"));
    place.ok(&line("--coherence anew", "anew"));
    let change = |folder: &str| -> u64 {
        let pair = |number: u32| (frame(&place, folder, number), frame(&place, folder, number + 1));
        let sum = |(a, b): (RgbaImage, RgbaImage)| -> u64 {
            a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum()
        };
        (0..11).map(|number| sum(pair(number))).sum()
    };
    let (carry, never, anew) = (change("carry"), change("never"), change("anew"));
    assert!(2 * carry < anew && never <= carry, "{carry} {never} {anew}");
    let replaced = |number: u32| frame(&place, "carry", number) != frame(&place, "never", number);
    assert!(!replaced(0) && !replaced(1) && replaced(11), "shade that leaves its window takes other texture");
}

#[test]
fn what_is_wrong_with_coherence_is_told() {
    let place = Place::new();
    strip(100, 70, [0; 3], [255; 3]).save(place.path("strip.png")).expect("a strip for large blocks");
    let line = "animate scene.obj --paint strip.png --size 32x32 -o out/%d.png";
    for (flags, code, parts) in [
        ("--coherence glue", 2, vec!["--coherence", "carry, match, anew"]),
        ("--stretch 1", 1, vec!["--stretch is 1,", "1.05 to 1.5"]),
        ("--stretch 1.6", 1, vec!["--stretch is 1.6", "1.05 to 1.5"]),
        ("--stretch NaN", 2, vec!["--stretch", "a number"]),
        ("--slack -1", 1, vec!["--slack is -1", "0 to 100"]),
        ("--slack 101", 1, vec!["--slack is 101", "0 to 100"]),
        ("--slack inf", 2, vec!["--slack", "a number"]),
        ("--repair-tolerance -0.1", 1, vec!["--repair-tolerance is -0.1", "0 to 10"]),
        ("--repair-tolerance 11", 1, vec!["--repair-tolerance is 11", "0 to 10"]),
        ("--repair-tolerance", 2, vec!["--repair-tolerance <T>"]),
        ("--coherence match --match-weight 0", 1, vec!["--match-weight is 0", "0.25 to 3 in steps of 0.25"]),
        ("--coherence match --match-weight 0.3", 1, vec!["--match-weight is 0.3", "0.25 to 3 in steps of 0.25"]),
        ("--coherence match --match-weight 3.25", 1, vec!["--match-weight is 3.25", "0.25 to 3 in steps of 0.25"]),
        ("--coherence match --match-weight -1", 1, vec!["--match-weight is -1"]),
        ("--coherence match --match-weight much", 2, vec!["--match-weight", "a number"]),
        ("--coherence match --block 48 --match-weight 1.5", 1, vec!["--match-weight is 1.5", "1.25", "48 px"]),
        ("--coherence match --block 64 --match-weight 0.5", 1, vec!["--match-weight is 0.5", "0.25 for", "64 px"]),
        ("--coherence match --blend-over 0", 2, vec!["--blend-over", "1..=1000"]),
        ("--coherence match --blend-over -3", 2, vec!["--blend-over", "1..=1000"]),
        ("--coherence match --blend-over 1001", 2, vec!["--blend-over", "1..=1000"]),
        ("--keyframes 0", 2, vec!["--keyframes", "1..=1000000"]),
        ("--keyframes -1", 2, vec!["--keyframes", "1..=1000000"]),
        ("--keyframes 1000001", 2, vec!["--keyframes", "1..=1000000"]),
        ("--keyframes some", 2, vec!["--keyframes", "some"]),
    ] {
        place.fails(&format!("{line} {flags}"), code, &parts);
    }
}
