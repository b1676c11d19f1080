//! devices, paint, quilt and tile: what they write when all is well.

use crate::support::{strip, Place};
use serde_json::Value;
use std::collections::BTreeSet;

#[test]
fn help_names_every_command_and_flag() {
    let place = Place::new();
    let help = place.ok("--help");
    for command in [
        "devices",
        "paint",
        "quilt",
        "tile",
        "render",
        "animate",
        "measure",
        "compare",
        "demo",
        "--device",
        "--validate",
        "--json",
    ] {
        assert!(help.contains(command), "{command}");
    }
    let flags = [
        ("devices", vec!["--json"]),
        ("paint", vec!["--gradient", "--search-scale", "--timing", "--speed", "-o"]),
        (
            "quilt",
            vec![
                "--size",
                "--block",
                "--overlap",
                "--tolerance",
                "--seed",
                "--quilt-search",
                "--tileable",
                "--dump",
                "-o",
            ],
        ),
        ("tile", vec!["-o"]),
        (
            "render",
            vec![
                "--paint",
                "--size",
                "--technique",
                "--block",
                "--overlap",
                "--k",
                "--tolerance",
                "--seed",
                "--light",
                "--yaw",
                "--pitch",
                "--distance",
                "--eye",
                "--target",
                "--gradient",
                "--levels",
                "--dump",
                "--timing",
                "--background",
                "-o",
            ],
        ),
        ("measure tests", vec!["--texture", "--block-sizes", "--samples", "--nearest", "--seed", "-o"]),
        ("measure coherence", vec!["--motion", "--mask", "--map", "--map-step", "--samples", "--block-size"]),
        ("compare", vec!["--paint", "--turn", "--nearest", "--search", "-o"]),
        (
            "animate",
            vec![
                "--frames",
                "--orbit",
                "--light-orbit",
                "--zoom",
                "--motion",
                "--turn",
                "--shard",
                "--resume",
                "--still",
                "--keyframes",
                "--coherence",
                "--stretch",
                "--slack",
                "--repair-tolerance",
                "--match-weight",
                "--blend-over",
                "\nMotion:",
                "\nCoherence of image-based frames:",
                "\nPicture and paint:",
                "\nCamera and light:",
            ],
        ),
        ("measure calm", vec!["--way", "--frames", "--stretch", "--match-weight", "--orbit"]),
        ("demo", vec!["-o", "--size"]),
    ];
    for (command, flags) in flags {
        let help = place.ok(&format!("{command} --help"));
        for flag in flags {
            assert!(help.contains(flag), "{command}: {flag}");
        }
    }
    assert!(place.ok("--version").starts_with("impasto "));
}

#[test]
fn devices_can_be_taken_by_index_name_and_uuid() {
    let place = Place::new();
    let listed = place.json("devices");
    let device = &listed["devices"][0];
    let (name, uuid) = (device["name"].as_str().expect("name"), device["uuid"].as_str().expect("uuid"));
    let shown = place.ok("devices");
    assert!(shown.contains(uuid));
    // What a driver does not tell is null, and left out.
    for key in ["driver_name", "driver_info", "pci"] {
        let told = device.get(key).expect(key);
        assert!(told.is_null() || told.as_str().is_some_and(|text| shown.contains(text)), "{key}: {told}");
    }
    for choice in ["0", name, uuid] {
        let words = ["tile", "strip.png", "-o", "out.png", "--json", "--device", choice];
        let ran = place.run_words(&words);
        let report: Value = serde_json::from_str(&ran.stdout).expect("JSON");
        assert_eq!((ran.code, &report["device"]["uuid"]), (Some(0), &device["uuid"]), "{choice}");
    }
}

#[test]
fn paint_takes_a_strip_apart_and_puts_it_together() {
    let place = Place::new();
    let report = place.json("paint strip.png -o deep/out");
    let residual = |timing: &str| report["residuals"][timing]["rms"].as_f64().expect("rms");
    assert!(residual("fit") < 0.1 && residual("stretch") < 0.2);
    let csv = place.text("deep/out/trajectory.csv");
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|number| number.parse().expect("a number")).collect())
        .collect();
    assert_eq!((csv.lines().next(), rows.len()), (Some("s,r,g,b"), 96));
    assert_eq!((rows[0][0], rows[95][0]), (0.0, 1.0));
    let (sample, trajectory) = (place.picture("strip.png"), place.picture("deep/out/trajectory.png"));
    let (texture, whole) = (place.picture("deep/out/texture.png"), place.picture("deep/out/recombined.png"));
    assert_eq!((texture.dimensions(), trajectory.width()), ((96, 40), 96));
    for (x, y, pixel) in sample.enumerate_pixels() {
        assert_eq!(whole.get_pixel(x, y), pixel, "strip = trajectory + texture");
        for k in 0..3 {
            let color = rows[x as usize][k + 1] * 255.0;
            assert!((f64::from(trajectory.get_pixel(x, 0).0[k]) - color).abs() < 0.51);
            let difference = f64::from(texture.get_pixel(x, y).0[k]) * 2.0 - 255.0;
            assert!((f64::from(pixel.0[k]) - color - difference).abs() < 1.1, "{x},{y}");
        }
    }
}

#[test]
fn paint_recombines_with_stops_and_with_another_strip() {
    let place = Place::new();
    place.ok("paint strip.png -o own");
    place.ok("paint strip.png -o stops --gradient 0:#ff0000,1:#ff0000");
    place.ok("paint strip.png -o strip --gradient other.png --timing stretch --search-scale 1.5 --speed 0.5:0.3");
    assert_eq!(place.bytes("own/texture.png"), place.bytes("stops/texture.png"));
    assert_eq!(place.bytes("own/trajectory.csv"), place.bytes("stops/trajectory.csv"));
    assert_ne!(place.bytes("own/trajectory.csv"), place.bytes("strip/trajectory.csv"));
    assert!(place.picture("stops/gradient.png").pixels().all(|pixel| pixel.0 == [255, 0, 0, 255]));
    // Red stays full but for the texture's share; own colours begin at a dark blue.
    assert!(place.picture("stops/recombined.png").get_pixel(0, 0).0[0] > 200);
    assert!(place.picture("own/recombined.png").get_pixel(0, 0).0[0] < 60);
    assert!(place.picture("strip/recombined.png").get_pixel(95, 5).0[0] > 200);
}

#[test]
fn a_strip_the_wrong_way_round_is_told() {
    let place = Place::new();
    image::imageops::flip_horizontal(&place.picture("strip.png")).save(place.path("flip.png")).expect("saved");
    let ran = place.run("paint flip.png -o out");
    assert_eq!(ran.code, Some(0));
    assert!(ran.stderr.starts_with("impasto: warning: flip.png: the strip grows darker"), "{}", ran.stderr);
    let quiet = place.run("paint flip.png -o out --quiet");
    assert_eq!((quiet.code, quiet.stderr + &quiet.stdout), (Some(0), String::new()));
    let json: Value = serde_json::from_str(&place.run("paint flip.png -o out --json").stdout).expect("JSON");
    assert_eq!(json["warnings"].as_array().map(Vec::len), Some(1));
}

#[test]
fn quilt_copies_blocks_from_where_it_says() {
    let place = Place::new();
    place.ok("quilt strip.png -o out.png --size 70x51 --block 16 --overlap 4 --seed 5 --tolerance 0.25 --dump d");
    let (sample, out) = (place.picture("strip.png"), place.picture("out.png"));
    assert_eq!(out.dimensions(), (70, 51));
    assert_eq!(place.bytes("d/texture.png"), place.bytes("out.png"));
    let dump: Value = serde_json::from_str(&place.text("d/blocks.json")).expect("JSON");
    assert_eq!((&dump["block"], &dump["overlap"], &dump["seed"]), (&16.into(), &4.into(), &5.into()));
    assert_eq!(dump["tolerance"].as_f64(), Some(0.25));
    let blocks = dump["blocks"].as_array().expect("blocks");
    // Steps of 12 px: 6 columns (5 * 12 + 16 >= 70) by 4 rows.
    assert_eq!(blocks.len(), 24);
    for block in blocks {
        let get = |name: &str| block[name].as_u64().unwrap_or_else(|| panic!("{name} in {block}")) as u32;
        let (x, y, sx, sy) = (get("x"), get("y"), get("sx"), get("sy"));
        assert_eq!((x, y), (get("col") * 12, get("row") * 12));
        assert_eq!(block["allowed"], serde_json::json!([0, 0, 80, 24]));
        assert!(sx <= 80 && sy <= 24 && get("error") >= get("min_error"));
        // The middle of a block, clear of all overlaps, is a plain copy.
        for (dx, dy) in (4..12).flat_map(|dx| (4..12).map(move |dy| (dx, dy))) {
            if x + dx < 70 && y + dy < 51 {
                assert_eq!(out.get_pixel(x + dx, y + dy), sample.get_pixel(sx + dx, sy + dy));
            }
        }
    }
}

#[test]
fn seeds_and_threads_make_the_difference_that_they_should() {
    let line = "quilt strip.png --size 64x64 --block 16 --overlap 4 -o";
    let one = Place::new().with_variable("LP_NUM_THREADS", "1");
    let two = Place::new().with_variable("LP_NUM_THREADS", "2");
    one.ok(&format!("{line} a.png"));
    two.ok(&format!("{line} a.png"));
    two.ok(&format!("{line} b.png"));
    two.ok(&format!("{line} c.png --seed 2"));
    assert_eq!(two.bytes("a.png"), two.bytes("b.png"));
    assert_ne!(two.bytes("a.png"), two.bytes("c.png"));
    assert_eq!(one.bytes("a.png"), two.bytes("a.png"));
}

#[test]
fn tileable_quilts_are_of_two_kinds() {
    let place = Place::new();
    let line = "quilt strip.png --size 64x64 --block 16 --overlap 4";
    place.ok(&format!("{line} -o plain.png"));
    place.ok(&format!("{line} -o mask.png --tileable mask --dump d"));
    place.ok(&format!("{line} -o wrap.png --tileable wrap"));
    let names = ["plain.png", "mask.png", "wrap.png"];
    assert_eq!(names.iter().map(|name| place.bytes(name)).collect::<BTreeSet<_>>().len(), 3);
    assert_eq!(place.bytes("d/texture.png"), place.bytes("plain.png"), "the dump is what there was before the mask");
    place.ok("tile plain.png -o tiled.png");
    assert_eq!(place.bytes("tiled.png"), place.bytes("mask.png"));
    // The strip runs from dark to light; what is tiled must not show that at its edges.
    place.ok("tile strip.png -o strip_tiled.png");
    let jump = |picture: &image::RgbaImage| -> u32 {
        let (w, h) = picture.dimensions();
        (0..h).map(|y| u32::from(picture.get_pixel(0, y).0[0].abs_diff(picture.get_pixel(w - 1, y).0[0]))).sum::<u32>()
            / h
    };
    assert!(jump(&place.picture("strip.png")) > 150);
    assert!(jump(&place.picture("strip_tiled.png")) < 30);
}

#[test]
fn the_extension_decides_on_the_format() {
    let place = Place::new();
    let kinds: [(&str, &[u8]); 6] = [
        ("a.png", b"\x89PNG"),
        ("a.jpg", b"\xff\xd8\xff"),
        ("b.JPEG", b"\xff\xd8\xff"),
        ("a.bmp", b"BM"),
        ("a.tif", b"II*\0"),
        ("a.tiff", b"II*\0"),
    ];
    for (name, magic) in kinds {
        place.ok(&format!("tile strip.png -o {name}"));
        assert!(place.bytes(name).starts_with(magic), "{name}");
        assert_eq!(place.picture(name).dimensions(), (96, 40));
    }
}

#[test]
fn json_tells_of_device_passes_phases_and_files() {
    let place = Place::new();
    let report = place.json("quilt strip.png -o out.png --size 64x48 --block 16 --overlap 4 --dump d");
    assert_eq!(report["command"], "quilt");
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    for key in ["name", "uuid", "kind", "api_version", "driver_version"] {
        assert!(!report["device"][key].is_null(), "{key}");
    }
    let search = report["passes"].as_array().and_then(|all| all.iter().find(|pass| pass["name"] == "quilt_search"));
    let search = search.expect("the search is timed");
    assert!(search["count"].as_u64() > Some(0) && search["gpu_ms"].as_f64() > Some(0.0));
    let wall = |phase: &str| report["wall_ms"][phase].as_f64().unwrap_or_else(|| panic!("{phase}"));
    let parts = ["setup", "load", "prepare", "synthesis", "write"].map(wall);
    assert!(parts.iter().sum::<f64>() <= wall("total"));
    assert_eq!(report["outputs"], serde_json::json!(["d/texture.png", "d/blocks.json", "out.png"]));
    let parameters = &report["parameters"];
    assert_eq!((&parameters["size"], &parameters["tolerance"]), (&"64x48".into(), &0.1.into()));
    assert_eq!(report["warnings"], serde_json::json!([]));
}

#[test]
fn the_path_of_the_search_is_told_and_changes_no_byte() {
    let place = Place::new();
    let line = "quilt strip.png --size 70x60 --block 16 --overlap 4";
    place.ok(&format!("{line} -o out.png"));
    let ran = |report: &Value, name: &str| {
        report["passes"].as_array().is_some_and(|passes| passes.iter().any(|pass| pass["name"] == name))
    };
    for (how, pruned) in [("auto", None), ("full", Some(false)), ("pruned", Some(true)), ("calibrate", None)] {
        let report = place.json(&format!("{line} -o {how}.png --quilt-search {how}"));
        assert!(place.bytes(&format!("{how}.png")) == place.bytes("out.png"), "{how}");
        let search = &report["quilt_search"];
        assert_eq!(search["chosen"], how);
        assert!([1, 2, 4, 8].map(Some).contains(&search["parts"].as_u64()), "{search}");
        let (compares, searches) = (ran(&report, "quilt_compare"), ran(&report, "quilt_search"));
        assert!(compares != searches, "{how}: the command's own passes and no others are timed");
        match pruned {
            Some(true) => assert!(search["prune_from"] == 0 && compares, "{search}"),
            Some(false) => assert!(search["prune_from"].is_null() && searches, "{search}"),
            None => {}
        }
    }
    let render = "render scene.obj --paint strip.png --size 48x48 --block 16 --overlap 4 --k 1";
    place.ok(&format!("{render} -o out.png"));
    for how in ["full", "pruned"] {
        let report = place.json(&format!("{render} -o {how}.png --quilt-search {how}"));
        assert!(place.bytes(&format!("{how}.png")) == place.bytes("out.png"), "{how}");
        assert_eq!(ran(&report, "quilt_compare"), how == "pruned");
    }
}

#[test]
fn outputs_are_replaced_and_links_are_followed() {
    let place = Place::new();
    std::fs::write(place.path("out.png"), "old").expect("written");
    place.ok("tile strip.png -o out.png");
    assert_eq!(place.picture("out.png").dimensions(), (96, 40));
    std::fs::create_dir(place.path("real")).expect("made");
    std::fs::write(place.path("real/target.png"), "old").expect("written");
    std::os::unix::fs::symlink("real/target.png", place.path("link.png")).expect("linked");
    place.ok("tile strip.png -o link.png");
    assert!(place.path("link.png").is_symlink());
    assert_eq!(place.bytes("real/target.png"), place.bytes("out.png"));
    // The input may be the output.
    place.ok("tile strip.png -o strip.png");
    assert_eq!(place.bytes("strip.png"), place.bytes("out.png"));
    let hidden = |path: &std::path::PathBuf| path.to_string_lossy().contains(".impasto");
    assert!(!place.files().keys().any(hidden), "no temporary file is left");
}

#[test]
fn a_sample_is_any_picture() {
    let place = Place::new();
    strip(16, 16, [0, 0, 0], [9, 9, 9]).save(place.path("block.bmp")).expect("saved");
    // A sample of exactly one block, and a picture smaller than that.
    place.ok("quilt block.bmp -o out.png --size 5x3 --block 16 --overlap 8");
    assert_eq!(place.picture("out.png").dimensions(), (5, 3));
}
