//! Wrong input: a clear error, the right exit status, and no file changed.

use crate::support::{strip, Place};
use std::fs;

#[test]
fn wrong_command_lines_are_refused_with_status_2() {
    let place = Place::new();
    let quilt = "quilt strip.png -o out.png";
    let render = "render scene.obj --paint strip.png -o out.png";
    let cases = [
        ("polish strip.png", "polish"),
        ("quilt strip.png", "--output"),
        ("render scene.obj -o out.png", "--paint"),
        (&format!("{quilt} --size 0x5"), "--size"),
        (&format!("{quilt} --size 16385x5"), "16384"),
        (&format!("{quilt} --size 99999999999x5"), "16384"),
        (&format!("{quilt} --size 12"), "WIDTHxHEIGHT"),
        (&format!("{quilt} --size -3x4"), "--size"),
        (&format!("{quilt} --block many"), "--block"),
        (&format!("{quilt} --seed -1"), "-1"),
        (&format!("{quilt} --seed 4294967296"), "--seed"),
        (&format!("{quilt} --tileable round"), "wrap"),
        (&format!("{quilt} --quilt-search quick"), "auto, full, pruned, calibrate"),
        (&format!("{render} --light 0,0,0"), "--light"),
        (&format!("{render} --light 1,2"), "X,Y,Z"),
        (&format!("{render} --light NaN,0,1"), "--light"),
        (&format!("{render} --light 0,0,1@-2"), "--light"),
        (&format!("{render} --yaw inf"), "--yaw"),
        (&format!("{render} --eye 1,2"), "--eye"),
        (&format!("{render} --target 1,2,3"), "--eye"),
        (&format!("{render} --eye 1,2,3 --yaw 4"), "--yaw"),
        (&format!("{render} --background white"), "#ff8800"),
        (&format!("{render} --technique watercolour"), "image"),
        (&format!("{render} --timing slow"), "stretch"),
        (&format!("{render} --speed 0.5"), "--speed"),
        (&format!("{render} --speed 0.5:0.5,0.4:0.6"), "--speed"),
        ("paint strip.png -o out --speed 2:1", "--speed"),
        ("measure tests --block-sizes 4,13", "4..=12"),
        ("measure tests --block-sizes 8,", "--block-sizes"),
        ("measure tests --samples 1", "2..=10000"),
        ("measure tests --nearest 33", "1..=32"),
    ];
    for (line, part) in cases {
        place.fails(line, 2, &[part]);
    }
}

#[test]
fn wrong_files_and_values_are_named() {
    let place = Place::new();
    fs::create_dir(place.path("folder")).expect("made");
    fs::write(place.path("empty.obj"), "").expect("written");
    fs::write(place.path("text.png"), "no picture").expect("written");
    strip(40, 12, [0; 3], [255; 3]).save(place.path("low.png")).expect("saved");
    let quilt = "quilt strip.png -o out.png --size 64x64";
    let render = "render scene.obj --paint strip.png -o out.png --block 16 --overlap 4 --k 1";
    // A strip of the default block's size; that many blocks are allowed, but the guides alone fill the memory budget.
    let huge = "render scene.obj --paint strip.png -o out.png --block 32 --overlap 6 --k 1 --size 16384x16384";
    let nan = "render scene.obj --paint strip.png -o out.png --block 16 --overlap 4 --k NaN".to_owned();
    let cases: Vec<(String, Vec<&str>)> = vec![
        ("quilt missing.png -o out.png".into(), vec!["missing.png", "No such file"]),
        ("quilt folder -o out.png".into(), vec!["folder", "directory"]),
        ("quilt text.png -o out.png".into(), vec!["text.png", "not a PNG"]),
        ("quilt low.png -o out.png".into(), vec!["low.png: 40x12 pixels", "--block 32 needs 32x32"]),
        (format!("{quilt} --block 3"), vec!["--block is 3", "4 to 64"]),
        (format!("{quilt} --block 65"), vec!["--block is 65", "4 to 64"]),
        (format!("{quilt} --overlap 17"), vec!["--overlap is 17", "1 to 16 (half of --block)"]),
        (format!("{quilt} --overlap 0"), vec!["--overlap is 0"]),
        (format!("{quilt} --tolerance NaN"), vec!["--tolerance is NaN", "0 to 10"]),
        (format!("{quilt} --tolerance -0.1"), vec!["--tolerance is -0.1", "0 to 10"]),
        (format!("{quilt} --tolerance inf"), vec!["--tolerance is inf"]),
        ("quilt strip.png -o out.png --size 5x64 --tileable wrap".into(), vec!["--size", "the width is 5"]),
        (format!("{quilt} --device 77"), vec!["--device", "device 77 was not found", "0: "]),
        (format!("{quilt} --device Voodoo"), vec!["--device", "Voodoo"]),
        ("tile missing.png -o out.png".into(), vec!["missing.png"]),
        ("tile text.png -o out.png".into(), vec!["text.png"]),
        ("paint missing.png -o out".into(), vec!["missing.png"]),
        ("paint strip.png -o out --search-scale -1".into(), vec!["--search-scale is -1", "0 or more"]),
        ("paint strip.png -o out --search-scale NaN".into(), vec!["--search-scale is NaN"]),
        ("paint strip.png -o out --gradient missing.png".into(), vec!["--gradient", "missing.png"]),
        ("paint strip.png -o out --gradient 0:#12,1:#ffffff".into(), vec!["--gradient is 0:#12"]),
        ("paint strip.png -o out --gradient 0:#000000,2:#ffffff".into(), vec!["--gradient is 2", "0 to 1"]),
        ("paint strip.png -o out --gradient 0.5:#000000,0:#ffffff".into(), vec!["--gradient", "ascending"]),
        ("render missing.obj --paint strip.png -o out.png".into(), vec!["missing.obj", "No such file"]),
        // The device is opened meanwhile; what is wrong with it is told after what is wrong with the input.
        ("render missing.obj --paint strip.png -o out.png --device Voodoo".into(), vec!["error: missing.obj"]),
        (format!("{render} --device Voodoo"), vec!["error: --device", "Voodoo"]),
        ("render folder --paint strip.png -o out.png".into(), vec!["folder", "is a folder"]),
        ("render empty.obj --paint strip.png -o out.png".into(), vec!["empty.obj"]),
        ("render strip.png --paint strip.png -o out.png".into(), vec!["strip.png"]),
        ("render scene.obj --paint missing.png -o out.png".into(), vec!["--paint", "missing.png"]),
        (format!("{render} --paint other.png"), vec!["--paint", "strip.png", "other.png"]),
        (format!("{render} --paint roof=other.png"), vec!["--paint roof=other.png", "`tent`", "`floor`"]),
        (format!("{render} --paint 2=other.png"), vec!["--paint 2=other.png", "0 to 1"]),
        (format!("{render} --gradient 9=other.png"), vec!["--gradient 9=other.png"]),
        ("render scene.obj --paint tent=strip.png -o out.png".into(), vec!["--paint", "`floor` has no paint"]),
        ("render scene.obj --paint low.png -o out.png".into(), vec!["low.png: 40x12", "--block 32"]),
        (nan, vec!["--k is NaN", "0 to 1000"]),
        (format!("{render} --pitch 91"), vec!["--pitch is 91", "90"]),
        (format!("{render} --fov 0.5"), vec!["--fov is 0.5", "150"]),
        (format!("{render} --distance 0"), vec!["--distance is 0"]),
        (format!("{render} --size 16384x1"), vec!["--size", "width over height"]),
        (format!("{render} --eye 0,0,0 --target 0,0,0"), vec!["eye"]),
        (format!("{render} --size 16384x16384"), vec!["number of blocks", "a larger --block"]),
        (huge.into(), vec!["bytes of GPU memory", "a smaller picture needs less"]),
        (format!("{render} {}", "--light 0,0,1 ".repeat(9)), vec!["error: --light: the number of lights is 9", "8"]),
    ];
    for (line, parts) in cases {
        place.fails(&line, 1, &parts);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_any_work() {
    let place = Place::new();
    fs::create_dir(place.path("folder.png")).expect("made");
    fs::write(place.path("file"), "a file").expect("written");
    let long = "x".repeat(300);
    // The inputs do not exist: the output is looked at first.
    let cases = [
        ("out", "must end in one of .png"),
        ("out.gif", "must end in one of .png"),
        ("missing/out.png", "missing"),
        ("file/out.png", "file"),
        ("folder.png", "is a folder"),
        ("/proc/out.png", "/proc/out.png"),
        (&format!("{long}.png"), "too long"),
    ];
    for (output, part) in cases {
        place.fails(&format!("quilt no.png -o {output}"), 1, &[part]);
        place.fails(&format!("tile no.png -o {output}"), 1, &[part]);
        place.fails(&format!("render no.obj --paint no.png -o {output}"), 1, &[part]);
    }
    place.fails("paint no.png -o file", 1, &["file: file is not a folder"]);
    place.fails("paint no.png -o file/deeper", 1, &["file/deeper"]);
    place.fails("paint no.png -o /proc/out", 1, &["/proc/out"]);
    place.fails("demo -o file", 1, &["file"]);
    place.fails("quilt no.png -o out.png --dump file", 1, &["file is not a folder"]);
    place.fails("render no.obj --paint no.png -o out.png --dump file/d", 1, &["file/d"]);
    fs::create_dir(place.path("d")).expect("made");
    place.fails("quilt no.png -o d/texture.png --dump d", 1, &["d/texture.png", "--dump"]);
    place.fails("render no.obj --paint no.png -o d/trajectory_2.png --dump d", 1, &["d/trajectory_2.png", "--dump"]);
    // These come past that check, to the inputs that are missing.
    place.fails("render no.obj --paint no.png -o d/id_card.png --dump d", 1, &["no.obj"]);
    place.fails("quilt no.png -o d/texture.bmp --dump d", 1, &["no.png"]);
    place.fails_words(&["tile", "no.png", "-o", ""], 2, &["--output"]);
    fs::create_dir(place.path("sealed")).expect("made");
    let sealed = std::os::unix::fs::PermissionsExt::from_mode(0o500);
    fs::set_permissions(place.path("sealed"), sealed).expect("set");
    // A superuser may write there all the same.
    if fs::write(place.path("sealed/probe"), "").is_err() {
        place.fails("quilt no.png -o sealed/out.png", 1, &["sealed/out.png", "ermission denied"]);
        place.fails("paint no.png -o sealed/out", 1, &["sealed", "ermission denied"]);
    }
}

#[test]
fn devices_cannot_be_validated() {
    Place::new().fails("devices --validate", 1, &["--validate", "opens no device"]);
}

#[test]
fn a_failure_leaves_the_old_output() {
    let place = Place::new();
    fs::write(place.path("out.png"), "old").expect("written");
    place.fails("quilt strip.png -o out.png --block 64 --overlap 8", 1, &["strip.png: 96x40"]);
    place.fails("tile missing.png -o out.png", 1, &["missing.png"]);
    place.fails("render scene.obj --paint missing.png -o out.png --dump d", 1, &["missing.png"]);
    place.fails("demo -o new/deep --device Voodoo", 1, &["impasto render head.obj", "--device", "Voodoo"]);
    // One of several files cannot be written: the others must not be replaced either.
    fs::create_dir_all(place.path("d/blocks.json")).expect("made");
    place.fails(
        "quilt strip.png -o out.png --size 32x32 --block 16 --overlap 4 --dump d",
        1,
        &["d/blocks.json", "is a folder"],
    );
    assert_eq!(place.text("out.png"), "old");
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let place = Place::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_impasto"))
        .args(["paint", "strip.png", "-o", "out"])
        .current_dir(place.dir.path())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let done = child.wait_with_output().expect("the program ends");
    assert_eq!((done.status.code(), String::from_utf8_lossy(&done.stderr).as_ref()), (Some(0), ""));
}
