//! animate: frames, parts of them on many machines, going on after an interruption, films.

use crate::support::Place;
use image::AnimationDecoder;
use std::fs;

const SCENE: &str = "scene.obj --paint strip.png --paint floor=other.png --size 64x48 --block 16 --overlap 4 --k 1 \
                     --level-count 4 --level-size 64 --orbit 7 --light-orbit 5 --zoom 0.99 --levels";

fn animate(technique: &str, frames: &str, output: &str) -> String {
    format!("animate {SCENE} --technique {technique} --frames {frames} -o {output}")
}

#[test]
fn parts_made_by_several_processes_are_the_whole() {
    let place = Place::new();
    let (carry, matching, blend) = ("image", "image --coherence match", "image --coherence match --blend-over 3");
    // Each part goes through the frames from the last keyframe before it on.
    let (all, keys) = ([0, 3, 6], [0, 3, 2]);
    let ways = [carry, matching, blend, "aligned", "dependent --views 30:20,60:20"];
    let runs = ways.map(|way| (way.to_owned(), all)).into_iter();
    let runs = runs.chain(ways.map(|way| (format!("{way} --keyframes 4"), keys)));
    let runs = runs.chain(["object", "image --coherence anew"].map(|way| (way.to_owned(), [0; 3])));
    for (index, (way, replayed)) in runs.enumerate() {
        let line = |folder: &str| animate(&way, "3..11", &format!("{index}/{folder}/%02d.png"));
        let report = place.json(&(line("whole") + " --validate"));
        assert_eq!((&report["rendered"]["frames"], &report["rendered"]["replayed"]), (&9.into(), &0.into()), "{way}");
        std::thread::scope(|scope| {
            for (shard, replayed) in replayed.into_iter().enumerate() {
                let (line, way, place) = (format!("{} --shard {shard}/3", line("parts")), &way, &place);
                scope.spawn(move || assert_eq!(place.json(&line)["rendered"]["replayed"], replayed, "{way}: {shard}"));
            }
        });
        let mut frames = Vec::new();
        for number in 3..=11 {
            let read = |folder: &str| place.bytes(&format!("{index}/{folder}/{number:02}.png"));
            let whole = read("whole");
            assert!(whole == read("parts"), "{way}: frame {number}");
            frames.push(whole);
        }
        assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "{way}: it moves");
        assert!(!place.path(&format!("{index}/whole/12.png")).exists());
    }
}

#[test]
fn view_dependent_texture_stays_on_the_faces_unless_frames_stand_alone() {
    let place = Place::new();
    let line = |flags: &str, folder: &str| animate("dependent", "0..3", &format!("{folder}/%d.png")) + flags;
    place.ok(&line("", "carried"));
    place.ok(&line(" --still", "alone"));
    place.ok(&line(" --follow 180", "at_once"));
    let same = |a: &str, b: &str, frame: u32| {
        place.bytes(&format!("{a}/{frame}.png")) == place.bytes(&format!("{b}/{frame}.png"))
    };
    for frame in 0..=3 {
        assert!(same("alone", "at_once", frame), "frame {frame}");
        assert_eq!(same("carried", "alone", frame), frame == 0, "frame {frame}");
    }
}

#[test]
fn an_interrupted_run_goes_on_and_leaves_what_is_finished() {
    let place = Place::new();
    let line = animate("object", "0..5", "out/f%03d.png");
    place.ok(&line);
    let whole = place.files();
    let path = |number: u32| place.path(&format!("out/f{number:03}.png"));
    fs::remove_file(path(2)).expect("removed");
    fs::remove_file(path(5)).expect("removed");
    // A finished one is not touched, whatever is in it.
    fs::write(path(0), "mine").expect("written");
    let report = place.json(&format!("{line} --resume"));
    assert_eq!(report["rendered"]["frames"], 2);
    assert_eq!(fs::read(path(0)).expect("a frame"), b"mine");
    fs::remove_file(path(0)).expect("removed");
    place.ok(&format!("{line} --resume"));
    assert!(place.files() == whole, "all of it as if nothing had happened");
    assert!(place.ok(&format!("{line} --resume")).contains("nothing to do"));
    let other = animate("aligned", "0..5", "out/f%03d.png") + " --resume";
    place.fails(&other, 1, &["animation.json", "other parameters"]);
    place.ok(&animate("aligned", "0..5", "out/f%03d.png"));
    assert!(place.files() != whole);
}

#[test]
fn pictures_of_other_keyframes_are_not_taken_for_finished() {
    let place = Place::new();
    let line = "animate scene.obj --paint strip.png --size 32x32 --technique object --frames 0..1 -o out/%d.png \
                --motion keys.json --resume";
    fs::write(place.path("keys.json"), r#"{"camera": [{"frame": 1, "orbit": 5}]}"#).expect("written");
    place.ok(line);
    assert!(place.ok(line).contains("nothing to do"));
    fs::write(place.path("keys.json"), r#"{"camera": [{"frame": 1, "orbit": 6}]}"#).expect("written");
    place.fails(line, 1, &["animation.json", "other parameters"]);
}

#[test]
fn keyframes_say_where_camera_and_light_are() {
    let place = Place::new();
    let keys = r#"{"camera": [{"frame": 0, "orbit": 0}, {"frame": 4, "orbit": 28, "distance": 1}],
                   "light": [{"frame": 0}, {"frame": 4, "orbit": 20}]}"#;
    fs::write(place.path("motion.json"), keys).expect("written");
    let base = "animate scene.obj --paint strip.png --size 64x48 --technique object --frames 0..4";
    place.ok(&format!("{base} -o keys/%d.png --motion motion.json"));
    place.ok(&format!("{base} -o flags/%d.png --orbit 7 --light-orbit 5"));
    for number in 0..=4 {
        let frame = |folder: &str| place.picture(&format!("{folder}/{number}.png"));
        assert!(frame("keys") == frame("flags"), "frame {number}");
    }
    place.ok("render scene.obj --paint strip.png --size 64x48 --technique object -o still.png");
    let (still, first) = (place.picture("still.png"), place.picture("keys/0.png"));
    let off = still.pixels().zip(first.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 2));
    assert!(off.count() < 30, "the first frame is the still");
}

#[test]
fn aligned_texture_follows_the_model_unless_it_is_to_stand_still() {
    let place = Place::new();
    // The light moves with nothing, so that the texture alone tells.
    let base = "animate scene.obj --paint strip.png --size 128x96 --technique aligned --level-count 4 --level-size 64 \
                --block 16 --overlap 4 --orbit 1 --frames 0..4";
    place.ok(&format!("{base} -o follows/%d.png"));
    place.ok(&format!("{base} -o still/%d.png --still"));
    let change = |folder: &str| {
        let (a, b) = (place.picture(&format!("{folder}/0.png")), place.picture(&format!("{folder}/4.png")));
        let both = a.pixels().zip(b.pixels()).filter(|(a, b)| a.0[3] == 255 && b.0[3] == 255);
        both.map(|(a, b)| u32::from(a.0[1].abs_diff(b.0[1]))).sum::<u32>()
    };
    let (follows, still) = (change("follows"), change("still"));
    assert!(follows > still, "what follows changes more at a pixel: {follows} and {still}");
    assert!(place.picture("follows/0.png") == place.picture("still/0.png"));
}

#[test]
fn films_are_whole_or_not_there() {
    let place = Place::new();
    place.ok(&(animate("object", "0..3", "film.gif") + " --rate 10"));
    let file = std::io::BufReader::new(fs::File::open(place.path("film.gif")).expect("a file"));
    let frames = image::codecs::gif::GifDecoder::new(file).expect("a GIF").into_frames().collect_frames();
    let frames = frames.expect("frames");
    assert_eq!((frames.len(), frames[0].delay().numer_denom_ms()), (4, (100, 1)));
    assert!(frames[0].buffer() != frames[3].buffer());

    // A stand-in for ffmpeg that keeps what it is sent, and one that fails.
    let program = |folder: &str, body: &str| {
        fs::create_dir(place.path(folder)).expect("a folder");
        let path = place.path(folder).join("ffmpeg");
        fs::write(&path, format!("#!/bin/sh\n[ \"$1\" = -version ] && exit 0\n{body}\n")).expect("written");
        let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        fs::set_permissions(&path, executable).expect("executable");
        format!("{}:/usr/bin:/bin", place.path(folder).display())
    };
    let good = program("good", "for last; do :; done; cat >\"$last\"");
    let bad = program("bad", "echo no such codec >&2; exit 3");
    let film = animate("object", "0..3", "film.mp4");
    let run = |path: String| place.run_with("PATH", &path, &film);
    assert_eq!(run(good).code, Some(0));
    assert_eq!(fs::metadata(place.path("film.mp4")).expect("a film").len(), 4 * 64 * 48 * 4);
    let before = place.files();
    let failed = run(bad);
    assert!(failed.code == Some(1) && failed.stderr.contains("film.mp4: ffmpeg: no such codec"), "{}", failed.stderr);
    let missing = run("/nowhere".to_owned());
    assert!(missing.code == Some(1) && missing.stderr.contains("takes the program ffmpeg"), "{}", missing.stderr);
    assert!(place.files() == before, "the old film is still there, and nothing else");
}

#[test]
fn an_animated_png_has_the_pixels_of_numbered_pictures() {
    let place = Place::new();
    place.ok(&(animate("object", "0..3", "film.png") + " --rate 10"));
    place.ok(&animate("object", "0..3", "out/%d.png"));
    let open = |name: &str| {
        let file = std::io::BufReader::new(fs::File::open(place.path(name)).expect("a file"));
        image::codecs::png::PngDecoder::new(file).expect("a PNG")
    };
    let film = open("film.png").apng().expect("an animated PNG");
    assert!(matches!(film.loop_count(), image::metadata::LoopCount::Infinite));
    let frames = film.into_frames().collect_frames().expect("frames");
    assert_eq!((frames.len(), frames[0].delay().numer_denom_ms()), (4, (100, 1)));
    for (number, frame) in frames.iter().enumerate() {
        assert!(*frame.buffer() == place.picture(&format!("out/{number}.png")), "frame {number}");
    }
    assert!(frames[0].buffer() != frames[3].buffer() && frames[0].buffer().pixels().any(|pixel| pixel.0[3] == 0));
    assert!(place.picture("film.png") == *frames[0].buffer(), "who knows no animation sees the first frame");

    place.ok(&animate("object", "0..0", "film.png"));
    assert!(!open("film.png").is_apng().expect("a PNG"), "one frame is a plain picture");
    assert!(place.picture("film.png") == *frames[0].buffer());
}

#[test]
fn a_motion_file_moves_camera_light_and_objects() {
    let place = Place::new();
    let motion = r#"{"smooth": true, "cuts": [2],
        "camera": [{"frame": 0, "eye": [5, 3, 5], "target": [0, 0.5, 0]},
                   {"frame": 2, "eye": [-5, 3, 5], "target": [0, 0.5, 0], "fov": 40},
                   {"frame": 4, "eye": [-5, 4, 5], "target": [0, 0.5, 0], "fov": 40}],
        "light": [{"frame": 0, "direction": [1, 1, 0]}, {"frame": 4, "direction": [0, 1, 1]}],
        "objects": {"tent": [{"frame": 0}, {"frame": 4, "turn": 60, "move": [0, 0.5, 0]}]}}"#;
    fs::write(place.path("motion.json"), motion).expect("written");
    let base = "scene.obj --paint strip.png --size 64x48 --technique object";
    let line = format!("animate {base} --frames 0..4 -o out/%d.png --motion motion.json --validate");
    let report = place.json(&line);
    assert_eq!(report["rendered"]["cuts"], serde_json::json!([2]));
    assert_eq!(report["parameters"]["keyframes"]["objects"]["tent"][1]["turn"], 60);
    // The first frame is what `render` shows from there.
    let view = "--eye 5,3,5 --target 0,0.5,0";
    place.ok(&format!("render {base} {view} --light 1,1,0 -o still.png"));
    let alpha = |name: &str| place.picture(name).pixels().map(|pixel| pixel.0[3]).collect::<Vec<_>>();
    assert!(place.picture("out/0.png") == place.picture("still.png"));
    assert!(alpha("out/1.png") != alpha("out/2.png") && alpha("out/2.png") != alpha("out/3.png"));
    place.json(&format!("animate {base} --frames 0..1 -o turn/%d.png --turn tent=5 --turn all=-2.5"));
    assert!(place.path("turn/1.png").exists());
}

#[test]
fn what_cannot_be_animated_is_told() {
    let place = Place::new();
    let roof = r#"{"objects": {"roof": [{"frame": 5, "turn": 3}]}}"#;
    fs::write(place.path("roof.json"), roof).expect("written");
    fs::write(place.path("falling.json"), r#"{"camera": [{"frame": 5}, {"frame": 5}]}"#).expect("written");
    fs::write(place.path("unknown.json"), r#"{"camera": [{"frame": 5, "roll": 3}]}"#).expect("written");
    fs::write(place.path("far.json"), r#"{"camera": [{"frame": 5, "distance": 1e9}]}"#).expect("written");
    let base = "animate scene.obj --paint strip.png --size 32x32 --technique object";
    for (flags, code, parts) in [
        ("-o out.jpg", 1, vec!["out.jpg", "%04d", ".gif"]),
        ("-o out.png --resume", 1, vec!["out.png", "--resume"]),
        ("-o none/out.png", 1, vec!["none"]),
        ("-o out/%x.png", 1, vec!["%04d"]),
        ("-o out/%04d%d.png", 1, vec!["%04d"]),
        ("-o out/%04d.pdf", 1, vec![".png"]),
        ("-o %d.png --frames 9..3", 2, vec!["FIRST..LAST"]),
        ("-o %d.png --frames 0..1000000", 2, vec!["999999"]),
        ("-o %d.png --shard 3/3", 2, vec!["I/N"]),
        ("-o %d.png --rate 0", 2, vec!["--rate"]),
        ("-o %d.png --zoom 3", 1, vec!["--zoom", "0.5 to 2"]),
        ("-o out.gif --resume", 1, vec!["out.gif", "--resume"]),
        ("-o out.gif --shard 0/2", 1, vec!["--shard"]),
        ("-o strip.png/%d.png", 1, vec!["strip.png"]),
        ("-o %d.png --motion missing.json", 1, vec!["missing.json"]),
        ("-o %d.png --motion scene.obj", 1, vec!["scene.obj", "line 1"]),
        ("-o %d.png --motion falling.json", 1, vec!["falling.json", "camera must rise"]),
        ("-o %d.png --motion unknown.json", 1, vec!["unknown.json", "roll"]),
        ("-o %d.png --motion far.json", 1, vec!["far.json", "frame 5", "1000000000", "0.001 to 1000"]),
        ("-o %d.png --motion far.json --orbit 3", 2, vec!["--orbit"]),
        ("-o %d.png --motion roof.json", 1, vec!["roof.json", "`tent`, `floor`"]),
        ("-o %d.png --motion roof.json --turn tent=3", 2, vec!["--turn"]),
        ("-o %d.png --turn roof=3", 1, vec!["roof", "`tent`, `floor`"]),
        ("-o %d.png --turn tent", 2, vec!["OBJECT=DEGREES"]),
        ("-o %d.png --turn 0=3 --turn tent=2", 1, vec!["`tent` is given twice"]),
    ] {
        place.fails(&format!("{base} {flags}"), code, &parts);
    }
}
