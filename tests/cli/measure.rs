//! measure and compare.

use crate::support::Place;
use serde_json::Value;

/// Small, but with a block of 32 pixels' worth of tent.
const COMPARE: &str = "compare scene.obj --paint strip.png --size 128x112 --block 16 --overlap 4 --samples 40 \
                       --level-count 4 --level-size 64 -o report";

fn mean(figures: &Value, name: &str) -> f64 {
    figures[name]["mean"].as_f64().unwrap_or_else(|| panic!("no {name} in {figures}"))
}

#[test]
fn a_comparison_is_whole_and_measuring_its_frames_gives_its_figures() {
    let place = Place::new();
    let report = place.json(&format!("{COMPARE} --validate"));
    let results = report["figures"].as_array().expect("figures");
    let names: Vec<_> = results.iter().map(|one| one["technique"].as_str().expect("a name")).collect();
    assert_eq!(names, ["object", "image", "aligned", "dependent"]);
    let parameters = &report["parameters"];
    assert_eq!((&parameters["level_count"], &parameters["repeats"]), (&4.into(), &4.0.into()));
    assert_eq!(parameters["technique"].as_array().map(Vec::len), Some(4));
    let document: Value = serde_json::from_str(&place.text("report/figures.json")).expect("JSON");
    assert_eq!(document["results"], report["figures"]);
    assert_eq!((&document["version"], &document["device"]["name"]), (&report["version"], &report["device"]["name"]));
    assert_eq!(document["thesis_table_10_1"][1]["coherence_image_space"], 0.00016);
    let csv = place.text("report/figures.csv");
    assert_eq!(csv.lines().count(), 1 + 4 * 9, "{csv}");
    let page = place.text("report/index.html");
    for outside in ["<script", "<link", "src=\"http", "href=\"http", "url(http", "@import"] {
        assert!(!page.contains(outside), "the page needs nothing but itself, and has {outside}");
    }
    assert!(page.matches("data:image/png;base64,").count() == 1 + 4 + 4 && page.contains("<svg"));
    assert!(page.contains("0.00016") && page.contains("View-aligned projection is the calmest"));

    for (technique, one) in names.iter().zip(results) {
        let figures = &one["figures"];
        let frame = format!("report/1_{technique}.png");
        let similarity = place.json(&format!("measure similarity strip.png {frame} --samples 40"));
        assert_eq!(similarity["figures"]["similarity"], figures["similarity"], "{technique}");
        assert_eq!(similarity["figures"]["cooccurrence_error"], figures["cooccurrence_error"]);
        assert_eq!(similarity["figures"]["sliced_wasserstein"], figures["sliced_wasserstein"]);
        let line = format!("measure shading strip.png {frame} --shade report/shade.png --samples 40");
        let shading = place.json(&line);
        // The file has the shade in 8 bits.
        let apart = mean(&shading["figures"], "shading_error_absolute") - mean(figures, "shading_error_absolute");
        assert!(apart.abs() < 0.003, "{technique}: {apart}");
        let line = format!(
            "measure coherence {frame} report/1_{technique}_next.png --motion report/motion.png --samples 40 --validate"
        );
        let coherence = place.json(&line);
        for name in ["coherence_image_space", "coherence_object_space", "flip"] {
            assert_eq!(coherence["figures"][name], figures[name], "{technique}: {name}");
        }
    }
}

#[test]
fn a_strip_lies_on_white_paper_wherever_it_is_measured() {
    let place = Place::new();
    let mut strip = place.picture("strip.png");
    for (x, y) in (0..6).flat_map(|y| (0..96).map(move |x| (x, y))) {
        strip.get_pixel_mut(x, y).0[3] = 0;
    }
    strip.save(place.path("torn.png")).expect("saved");
    let report = place.json(&COMPARE.replace("strip.png", "torn.png"));
    let frame = "measure similarity torn.png report/1_image.png --samples 40";
    assert_eq!(place.json(frame)["figures"]["similarity"], report["figures"][1]["figures"]["similarity"]);
    assert_eq!(
        place.json(frame)["figures"]["cooccurrence_error"],
        report["figures"][1]["figures"]["cooccurrence_error"]
    );
    // One pixel has no interval, and decides nothing.
    let one = place.json(&COMPARE.replace("--samples 40", "--samples 1"));
    let verdicts: Vec<_> = one["findings"].as_array().expect("findings").iter().map(|f| &f["holds"]).collect();
    assert!(verdicts.iter().all(|verdict| *verdict != "yes"), "{verdicts:?}");
}

#[test]
fn a_strip_is_itself_and_a_map_shows_where_a_picture_is_not() {
    let place = Place::new();
    // The strip, with a patch of another in its lower right quarter.
    let (mut frame, other) = (place.picture("strip.png"), place.picture("other.png"));
    for (x, y) in (20..40).flat_map(|y| (48..80).map(move |x| (x, y))) {
        frame.put_pixel(x, y, *other.get_pixel(x - 48, y));
    }
    frame.save(place.path("frame.png")).expect("saved");
    let same = place.json("measure similarity strip.png strip.png --nearest 1 --validate");
    assert_eq!(mean(&same["figures"], "similarity"), 0.0);
    assert_eq!(same["figures"]["cooccurrence_error"], 0.0);
    assert_eq!(same["figures"]["sliced_wasserstein"], 0.0);
    let line = "measure similarity strip.png frame.png --nearest 1 --map map.png --map-step 8 --search kdtree";
    assert!(mean(&place.json(line)["figures"], "similarity") > 0.01);
    let map = place.picture("map.png");
    // 12 x 5 cells, enlarged: dark where it is the strip itself, bright in the patch.
    let cell = map.width() / 12;
    let bright = |x: u32, y: u32| {
        let pixel = map.get_pixel(x * cell + cell / 2, y * cell + cell / 2);
        u32::from(pixel.0[1])
    };
    assert!(bright(2, 1) < 40 && bright(7, 3) > 90, "{} and {}", bright(2, 1), bright(7, 3));
    // A mask that leaves the patch out.
    let mask = image::RgbaImage::from_fn(96, 40, |x, _| image::Rgba(if x < 40 { [255; 4] } else { [0, 0, 0, 255] }));
    mask.save(place.path("mask.png")).expect("saved");
    let masked = place.json("measure similarity strip.png frame.png --nearest 1 --mask mask.png");
    assert_eq!(mean(&masked["figures"], "similarity"), 0.0);
    let seeds = |seed: u32| {
        let line = format!("measure similarity other.png frame.png --samples 20 --sample-seed {seed}");
        mean(&place.json(&line)["figures"], "similarity")
    };
    assert!(seeds(1) == seeds(1) && seeds(1) != seeds(2));
    let text = place.ok("measure coherence strip.png frame.png");
    assert!(text.contains("coherence image space") && text.contains("flip"), "{text}");
}

#[test]
fn what_cannot_be_measured_is_told() {
    let place = Place::new();
    place.picture("strip.png").save(place.path("frame.png")).expect("saved");
    image::RgbaImage::new(96, 40).save(place.path("nothing.png")).expect("saved");
    std::fs::write(place.path("text.png"), "text").expect("written");
    image::GrayImage::new(96, 40).save(place.path("black.png")).expect("saved");
    image::RgbaImage::new(6, 6).save(place.path("tiny.png")).expect("saved");
    let motion = image::ImageBuffer::<image::Rgb<u16>, _>::from_pixel(96, 40, image::Rgb([0, 0, 0]));
    motion.save(place.path("hidden.png")).expect("saved");
    place.fails("measure similarity strip.png nothing.png --map map.png", 1, &["no block of 8 x 8", "nothing.png"]);
    place.fails("measure similarity strip.png frame.png --mask black.png", 1, &["no block of 8 x 8", "black.png"]);
    place.fails("measure similarity tiny.png frame.png", 1, &["tiny.png: has 6 x 6", "--block-size 8"]);
    place.fails("measure similarity strip.png tiny.png", 1, &["tiny.png: has 6 x 6"]);
    place.fails("measure similarity tiny.png frame.png --block-size 5", 1, &["tiny.png", "is 4", "--nearest"]);
    place.fails("measure shading strip.png frame.png --shade nothing.png", 1, &["nothing.png has a shade"]);
    place.fails("measure coherence frame.png strip.png --motion hidden.png", 1, &["hidden.png", "moved"]);
    place.fails("measure coherence frame.png strip.png --motion strip.png", 1, &["strip.png", "16 bits"]);
    place.fails("compare scene.obj --technique image -o report", 2, &["--technique"]);
    place.fails("measure similarity strip.png missing.png", 1, &["missing.png"]);
    place.fails("measure similarity text.png frame.png", 1, &["text.png"]);
    place.fails("measure similarity strip.png frame.png --block-size 13", 2, &["--block-size", "4..=12"]);
    place.fails("measure similarity strip.png frame.png --nearest 0", 2, &["--nearest", "1..=32"]);
    place.fails("measure similarity strip.png frame.png --samples 0", 2, &["--samples"]);
    place.fails("measure similarity strip.png frame.png --map-step 3", 2, &["--map"]);
    place.fails("measure similarity strip.png frame.png --map nowhere/map.png", 1, &["nowhere"]);
    place.fails("measure similarity strip.png frame.png --mask other.png", 1, &["other.png", "80 x 48", "96 x 40"]);
    place.fails("measure shading strip.png frame.png", 2, &["--shade"]);
    place.fails("measure shading strip.png frame.png --shade other.png", 1, &["other.png", "80 x 48"]);
    place.fails("measure coherence frame.png other.png", 1, &["other.png", "80 x 48"]);
    place.fails("compare scene.obj --paint missing.png -o report", 1, &["--paint", "missing.png"]);
    place.fails("compare missing.obj -o report", 1, &["missing.obj"]);
    place.fails("compare scene.obj --paint strip.png -o strip.png", 1, &["strip.png"]);
    place.fails("compare scene.obj --paint strip.png -o report --block 48 --overlap 4", 1, &["strip.png", "48"]);
}
