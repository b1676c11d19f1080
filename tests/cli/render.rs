//! render: the picture, its intermediates, camera, lights and paints.

use crate::support::Place;
use serde_json::Value;
use std::collections::BTreeSet;

const RENDER: &str = "render scene.obj --paint strip.png --size 96x72 --block 16 --overlap 4 --k 1";

#[test]
fn intermediates_add_up_to_the_picture() {
    let place = Place::new();
    place.ok(&format!("{RENDER} -o out.png --paint floor=other.png --dump d --validate"));
    let names = ["shade.png", "id.png", "color.png", "texture.png", "trajectory.png", "trajectory.csv", "blocks.json"];
    for name in names.iter().chain(&["trajectory_2.png", "trajectory_2.csv", "blocks_2.json"]) {
        assert!(place.path("d").join(name).is_file(), "{name}");
    }
    let [out, shade, id, color, texture] =
        ["out.png", "d/shade.png", "d/id.png", "d/color.png", "d/texture.png"].map(|name| place.picture(name));
    assert!(matches!(image::open(place.path("d/shade.png")), Ok(image::DynamicImage::ImageLumaA8(_))));
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = place.text(name);
        text.lines().skip(1).map(|line| line.split(',').map(|n| n.parse().expect("number")).collect()).collect()
    };
    let colors = [rows("d/trajectory.csv"), rows("d/trajectory_2.csv")];
    assert_eq!((colors[0].len(), colors[1].len()), (96, 80), "the plain paint is the first");
    let ids: BTreeSet<[u8; 4]> = id.pixels().map(|pixel| pixel.0).collect();
    assert_eq!(ids.len(), 3, "background, tent and floor");
    let tent = id.get_pixel(48, 30).0;
    let mut seen = [0, 0];
    for (x, y, pixel) in out.enumerate_pixels() {
        let object = id.get_pixel(x, y).0;
        if object[3] == 0 {
            assert_eq!((pixel.0, shade.get_pixel(x, y).0[3]), ([0; 4], 0), "{x},{y}");
            continue;
        }
        assert_eq!((pixel.0[3], shade.get_pixel(x, y).0[3]), (255, 255));
        let paint = usize::from(object != tent);
        seen[paint] += 1;
        let path = &colors[paint];
        let place = f64::from(shade.get_pixel(x, y).0[0]) / 255.0 * (path.len() - 1) as f64;
        for k in 0..3 {
            let c = f64::from(color.get_pixel(x, y).0[k]);
            let t = f64::from(texture.get_pixel(x, y).0[k]) * 2.0 - 255.0;
            let sum = (c + t).clamp(0.0, 255.0);
            assert!((f64::from(pixel.0[k]) - sum).abs() <= 2.0, "{x},{y}: {c} + {t} is not {}", pixel.0[k]);
            // Between the two colours beside the shade, which is known to half a step only.
            let near = (place - 0.3).floor().max(0.0) as usize..=((place + 0.3).ceil() as usize).min(path.len() - 1);
            let all: Vec<f64> = near.map(|i| path[i][k + 1] * 255.0).collect();
            let (low, high) = (all.iter().copied().fold(f64::MAX, f64::min), all.iter().copied().fold(0.0, f64::max));
            assert!(c >= low - 1.0 && c <= high + 1.0, "{x},{y}: {c} is not in {low}..{high}");
        }
    }
    assert!(seen[0] > 200 && seen[1] > 200, "{seen:?}");
    // Floor and tent each have blocks, within the windows that their shades allow.
    for (name, width) in [("d/blocks.json", 96), ("d/blocks_2.json", 80)] {
        let dump: Value = serde_json::from_str(&place.text(name)).expect("JSON");
        let blocks = dump["blocks"].as_array().expect("blocks");
        assert!(!blocks.is_empty() && blocks.len() < 48, "blocks that meet no pixel of the paint are left out");
        for block in blocks {
            let allowed: Vec<u64> = block["allowed"].as_array().expect("4").iter().filter_map(Value::as_u64).collect();
            let sx = block["sx"].as_u64().expect("sx");
            assert!(allowed[0] <= sx && sx <= allowed[2] && allowed[2] <= width - 16 && allowed[2] - allowed[0] <= 32);
        }
    }
}

#[test]
fn light_levels_and_background_do_what_they_say() {
    let place = Place::new();
    let shade = |name: &str, more: &str| {
        place.ok(&format!("{RENDER} -o {name}.png --yaw 0 --pitch 10 --dump {name} {more}"));
        place.picture(&format!("{name}/shade.png"))
    };
    let [left, right] = [("left", "--light -1,0.2,0.3"), ("right", "--light 1,0.2,0.3")].map(|(n, m)| shade(n, m));
    // The scene is its own mirror image, up to where the mesh is cut into triangles and pixels round.
    let mirrored = image::imageops::flip_horizontal(&left);
    let differ = mirrored.pixels().zip(right.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 1).count();
    assert!(differ < 96, "{differ} pixels are not mirrored");
    assert_ne!(left, right);
    // Two lights of equal weight make the mean; a weight of next to nothing changes nothing.
    let both = shade("both", "--light -1,0.2,0.3 --light 1,0.2,0.3");
    let weighted = shade("weighted", "--light -1,0.2,0.3 --light 1,0.2,0.3@1e-6");
    assert_eq!(weighted, left);
    for ((a, b), c) in left.pixels().zip(right.pixels()).zip(both.pixels()) {
        assert!((i32::from(a.0[0]) + i32::from(b.0[0]) - 2 * i32::from(c.0[0])).abs() <= 2);
    }
    let range = |picture: &image::RgbaImage| {
        let values = picture.pixels().filter(|pixel| pixel.0[3] == 255).map(|pixel| pixel.0[0]);
        values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
    };
    let spread = shade("spread", "--light 0,0.1,1 --levels");
    assert_eq!(range(&spread), 255);
    assert!(range(&shade("plain", "--light 0,0.1,1")) < 230);
    place.ok(&format!("{RENDER} -o white.png --yaw 0 --pitch 10 --light -1,0.2,0.3 --background #102030"));
    for (a, b) in place.picture("left.png").pixels().zip(place.picture("white.png").pixels()) {
        assert_eq!(b.0, if a.0[3] == 0 { [16, 32, 48, 255] } else { a.0 });
    }
}

#[test]
fn the_camera_is_placed_by_angles_or_by_points() {
    let place = Place::new();
    let covered = |name: &str, more: &str| {
        place.ok(&format!("{RENDER} -o {name}.png {more}"));
        place.picture(&format!("{name}.png")).pixels().filter(|pixel| pixel.0[3] == 255).count()
    };
    let fitted = covered("a", "--yaw -30 --pitch -5.5");
    let far = covered("b", "--yaw -30 --pitch -5.5 --distance 12");
    assert!(fitted > 3 * far && far > 0, "{fitted} {far}");
    let eye = covered("c", "--eye -3,4,-6");
    assert!(eye > 500);
    assert_eq!(covered("d", "--eye -3,4,-6 --target -9,9,-12 --fov 20"), 0, "looks away");
    assert!(covered("e", "--eye 0,9,0.01 --target 0,0,0 --up 0,0,-1 --fov 40") > 500);
}

#[test]
fn a_gradient_changes_colours_and_not_texture() {
    let place = Place::new();
    place.ok(&format!("{RENDER} -o own.png --dump own"));
    place.ok(&format!("{RENDER} -o red.png --dump red --gradient 0:#c80000,1:#c80000"));
    place.ok(&format!("{RENDER} -o strip.png.png --dump strip --gradient other.png"));
    place.ok(&format!("{RENDER} -o floor.png --dump floor --gradient floor=0:#00c800,1:#00c800"));
    for folder in ["red", "strip"] {
        assert_eq!(place.bytes(&format!("{folder}/texture.png")), place.bytes("own/texture.png"));
        assert_eq!(place.bytes(&format!("{folder}/blocks.json")), place.bytes("own/blocks.json"));
        assert_ne!(place.bytes(&format!("{folder}/color.png")), place.bytes("own/color.png"));
    }
    let colors = |name: &str| -> BTreeSet<[u8; 4]> {
        place.picture(name).pixels().map(|pixel| pixel.0).filter(|pixel| pixel[3] == 255).collect()
    };
    assert_eq!(colors("red/color.png"), BTreeSet::from([[200, 0, 0, 255]]));
    let mixed = colors("floor/color.png");
    assert!(mixed.contains(&[0, 200, 0, 255]) && mixed.len() > 2, "{mixed:?}");
}

#[test]
fn paints_go_to_objects_by_name_and_by_index() {
    let place = Place::new();
    let scene = "render scene.obj --size 64x48 --block 16 --overlap 4 --k 1 -o";
    place.ok(&format!("{scene} name.png --paint strip.png --paint floor=other.png"));
    place.ok(&format!("{scene} index.png --paint 1=other.png --paint tent=strip.png"));
    place.ok(&format!("{scene} plain.png --paint strip.png"));
    assert_eq!(place.bytes("name.png"), place.bytes("index.png"));
    assert_ne!(place.bytes("name.png"), place.bytes("plain.png"));
    // A file may have an equals sign in its name.
    std::fs::copy(place.path("strip.png"), place.path("floor=other.png")).expect("copied");
    place.ok(&format!("{scene} file.png --paint floor=other.png"));
    assert_eq!(place.bytes("file.png"), place.bytes("plain.png"));
}

#[test]
fn objects_with_the_same_paint_share_one_synthesis() {
    let place = Place::new();
    let stops = "0:#100000,1:#ffffff";
    let scene = "render scene.obj --size 64x48 --block 16 --overlap 4 --k 1";
    let run = |name: &str, paints: &str| {
        let report = place.json(&format!("{scene} -o {name}.png --dump {name} {paints}"));
        let passes = report["passes"].as_array().expect("passes");
        let search = passes.iter().find(|pass| pass["name"] == "quilt_search").expect("the search is timed");
        let blocks = report["outputs"].as_array().expect("outputs").iter().filter_map(Value::as_str);
        (search["count"].clone(), blocks.filter(|file| file.contains("/blocks")).count())
    };
    let once = run("once", "--paint strip.png");
    assert_eq!(once.1, 1);
    assert_eq!(run("each", "--paint tent=strip.png --paint floor=strip.png"), once);
    assert_eq!(run("default", "--paint strip.png --paint floor=strip.png"), once);
    let gradients = format!("--paint strip.png --gradient tent={stops} --gradient floor={stops}");
    assert_eq!(run("gradients", &gradients).1, 1);
    for name in ["each", "default"] {
        assert_eq!(place.bytes(&format!("{name}.png")), place.bytes("once.png"), "{name}");
    }
    // Another paint, or the same strip in other colours, is a synthesis of its own.
    assert_eq!(run("two", "--paint tent=strip.png --paint floor=other.png").1, 2);
    assert_eq!(run("recolored", &format!("--paint strip.png --gradient floor={stops}")).1, 2);
}

#[test]
fn wide_windows_and_flawed_models_are_told() {
    let place = Place::new();
    // 2 * floor(k * 16) + 1 of 96 columns: 47 are less than half of them, 49 more.
    let line = "render scene.obj --paint strip.png --size 48x48 --block 16 --overlap 4 -o out.png --k";
    place.ok(&format!("{line} 1.45"));
    let ran = place.run(&format!("{line} 1.5"));
    assert_eq!(ran.code, Some(0));
    assert!(ran.stderr.contains("warning: strip.png: --k 1.5 with --block 16 searches 49 of"), "{}", ran.stderr);
    let model = place.text("scene.obj") + "f 6 6 7\nl 1 2\n";
    std::fs::write(place.path("flawed.obj"), model).expect("written");
    let ran = place.run("render flawed.obj --paint strip.png --size 48x48 --block 16 --overlap 4 -o out.png --k 1");
    assert_eq!(ran.code, Some(0));
    assert!(ran.stderr.contains("warning: flawed.obj: dropped 1 triangle of zero area"), "{}", ran.stderr);
}

#[test]
fn renders_are_the_same_for_any_number_of_threads_and_differ_by_seed() {
    let [one, two] = ["1", "2"].map(|threads| Place::new().with_variable("LP_NUM_THREADS", threads));
    one.ok(&format!("{RENDER} -o a.png"));
    two.ok(&format!("{RENDER} -o a.png"));
    two.ok(&format!("{RENDER} -o b.png --seed 9"));
    assert_eq!(one.bytes("a.png"), two.bytes("a.png"));
    assert_ne!(two.bytes("a.png"), two.bytes("b.png"));
}

#[test]
fn json_tells_the_scene() {
    let place = Place::new();
    let report = place.json(&format!("{RENDER} -o out.png --light 0,0,-2@3"));
    assert_eq!(
        report["parameters"]["lights"],
        serde_json::json!([{ "direction": [0.0, 0.0, -1.0], "intensity": 3.0 }])
    );
    assert_eq!(report["parameters"]["camera"]["eye"].as_array().map(Vec::len), Some(3));
    let passes: Vec<&str> =
        report["passes"].as_array().expect("passes").iter().filter_map(|p| p["name"].as_str()).collect();
    for pass in ["guide", "image_guide", "quilt_search", "quilt_place", "image_recombine"] {
        assert!(passes.contains(&pass), "{pass}");
    }
}
