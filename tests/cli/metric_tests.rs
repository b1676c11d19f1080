//! measure tests: that the texture metric answers to known faults as the thesis says (9.1.1 to 9.1.3), and what is
//! written.

use crate::support::{strip, Place};
use serde_json::Value;

/// The curve of these names, as pairs of what changes and the error.
fn curve(report: &Value, test: &str, texture: &str, direction: Option<&str>, block_px: u32) -> Vec<(f64, f64)> {
    let is_it = |curve: &&Value| {
        (curve["test"] == test && curve["texture"] == texture && curve["block_px"] == block_px)
            && curve["direction"].as_str() == direction
    };
    let found: Vec<&Value> = report["curves"].as_array().expect("curves").iter().filter(is_it).collect();
    assert_eq!(found.len(), 1, "{test} {texture} {direction:?} {block_px}");
    let variable = match test {
        "rotation" => "angle_deg",
        "scale" => "factor",
        _ => "pasted_block_px",
    };
    let number = |value: &Value| value.as_f64().expect("a number");
    let points = found[0]["points"].as_array().expect("points").iter();
    points.map(|point| (number(&point[variable]), number(&point["error"]))).collect()
}

fn errors(points: &[(f64, f64)]) -> Vec<f64> {
    points.iter().map(|point| point.1).collect()
}

fn most(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

/// Spearman's rank correlation of errors with their order: 1 where they only grow, -1 where they only fall.
fn trend(errors: &[f64]) -> f64 {
    let rank = |error: f64| errors.iter().filter(|other| **other < error).count() as f64;
    let count = errors.len() as f64;
    let squares: f64 = (0..).zip(errors).map(|(place, error)| (rank(*error) - f64::from(place)).powi(2)).sum();
    1.0 - 6.0 * squares / (count * (count * count - 1.0))
}

#[test]
fn the_metric_answers_to_known_faults_as_the_thesis_says() {
    let place = Place::new();
    // The thesis's 100 pixels leave an error uncertain by 0.003 or so, as much as what lies between the factors of 0.5
    // and 0.6: two such points now and then change places.
    let report = place.json("measure tests -o tests --samples 500");
    assert_eq!(report["curves"].as_array().map(Vec::len), Some(3 * 3 + 3 + 3));
    let turned = |texture, block_px| errors(&curve(&report, "rotation", texture, None, block_px));
    for block_px in [4, 8, 12] {
        // Angles are 15 degrees apart: the seventh is a right one, the last half a turn.
        let (diagonal, symmetric) = (turned("diagonal", block_px), turned("symmetric", block_px));
        let peak = most(&diagonal);
        assert_eq!((diagonal.len(), diagonal[6]), (13, peak), "{block_px}: {diagonal:?}");
        assert!(diagonal[0] < peak / 5.0 && diagonal[12] < peak / 5.0, "{block_px}: {diagonal:?}");
        assert!(trend(&diagonal[..7]) > 0.9 && trend(&diagonal[6..]) < -0.9, "{block_px}: {diagonal:?}");
        assert!(most(&symmetric) < peak / 2.0, "{block_px}: {symmetric:?} and {peak}");
        assert!((symmetric[6] - symmetric[0]).abs() < 1e-3 && (symmetric[12] - symmetric[0]).abs() < 1e-3);
        // Noise has no direction: what it loses is being compared with itself, and from then on all angles are alike.
        let random = turned("random", block_px);
        let (least, greatest) = (random[4..].iter().copied().fold(1.0, f64::min), most(&random[4..]));
        assert!(random[0] < least && greatest < 1.15 * least && greatest < peak, "{block_px}: {random:?}");
    }
    for direction in ["x", "y", "both"] {
        let points = curve(&report, "scale", "random", Some(direction), 8);
        assert_eq!((points.len(), points[0].0, points[4].0, points[8].0), (9, 0.5, 1.0, 2.0));
        let errors = errors(&points);
        assert!(errors[0] > 1.5 * errors[4] && errors[8] > 1.5 * errors[4], "{direction}: {errors:?}");
        assert!(
            errors[..5].is_sorted_by(|a, b| a > b) && errors[4..].is_sorted_by(|a, b| a < b),
            "{direction}: {errors:?}"
        );
    }
    let sampled = |block_px| errors(&curve(&report, "sampling", "random", None, block_px));
    for block_px in [4, 8, 12] {
        let errors = sampled(block_px);
        assert!(errors.len() == 8 && errors[0] > 1.3 * errors[7], "{block_px}: {errors:?}");
        assert!(trend(&errors) < -0.9, "{block_px}: {errors:?}");
    }
    // Larger blocks of the metric, smaller errors in all.
    let total = |errors: Vec<f64>| errors.iter().sum::<f64>();
    let shrinks = |of: &dyn Fn(u32) -> f64| of(4) > 1.1 * of(8) && of(8) > 1.1 * of(12);
    for texture in ["random", "diagonal", "symmetric"] {
        assert!(shrinks(&|block_px| total(turned(texture, block_px))), "{texture}");
    }
    assert!(shrinks(&|block_px| total(sampled(block_px))));
}

#[test]
fn a_texture_of_ones_own_is_tested_and_all_is_written() {
    let place = Place::new();
    strip(72, 72, [20, 30, 80], [250, 240, 160]).save(place.path("own.png")).expect("a texture");
    let words = "measure tests --texture own.png --block-sizes 6,5,6 --samples 12 --nearest 3 --seed 9";
    let report = place.json(&format!("{words} -o a/b"));
    let own = |test, direction, block_px| curve(&report, test, "own", direction, block_px).len();
    assert_eq!((own("rotation", None, 5), own("scale", Some("both"), 8), own("sampling", None, 6)), (13, 9, 8));
    assert_eq!(report["parameters"]["block_sizes"], serde_json::json!([5, 6]));
    let mut written: Vec<String> = place.files().into_keys().map(|path| path.display().to_string()).collect();
    written.retain(|path| path.contains("a/b/"));
    let names =
        ["index.html", "rotation_5.svg", "rotation_6.svg", "sampling.svg", "scale.svg", "tests.csv", "tests.json"];
    assert!(written.iter().zip(names).all(|(path, name)| path.ends_with(&format!("a/b/{name}"))), "{written:?}");
    assert_eq!((written.len(), report["outputs"].as_array().map(Vec::len)), (names.len(), Some(names.len())));

    let document: Value = serde_json::from_str(&place.text("a/b/tests.json")).expect("JSON");
    for part in ["tool", "version", "device", "parameters", "curves"] {
        assert_eq!(document[part], report[part], "{part}");
    }
    let points = document["curves"].as_array().expect("curves").iter().flat_map(|curve| curve["points"].as_array());
    let points: Vec<&Value> = points.flatten().collect();
    assert!(points.iter().all(|point| point["samples"] == 12 && point["half_width"].is_number()));
    let csv = place.text("a/b/tests.csv");
    assert_eq!(csv.lines().count(), 1 + points.len());
    assert!(
        csv.starts_with("test,texture,direction,block_px,variable,value,error,half_width,samples\nrotation,random,,5,")
    );
    let page = place.text("a/b/index.html");
    assert_eq!(page.matches("<svg ").count(), 4);
    // Four textures, two turns of each; two textures, stretched three times and sampled three times.
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 4 + 8 + 6 + 6);
    assert!(page.contains(report["device"]["name"].as_str().expect("a name")) && page.contains("own.png"));

    let again = place.ok(&format!("{words} -o again"));
    assert_eq!(place.text("again/tests.csv"), csv);
    assert!(again.contains("see again/index.html") && again.contains("sampling"), "{again}");
    let other = place.json("measure tests --block-sizes 5 --samples 12 --nearest 3 --seed 10 -o other --validate");
    assert_ne!(curve(&other, "rotation", "random", None, 5), curve(&report, "rotation", "random", None, 5));
}

#[test]
fn textures_that_cannot_be_tested_are_refused_before_the_work() {
    let place = Place::new();
    for (name, width, height) in [("flat.png", 96, 64), ("small.png", 63, 63), ("large.png", 513, 513)] {
        strip(width, height, [0; 3], [255; 3]).save(place.path(name)).expect("a texture");
        place.fails(&format!("measure tests --texture {name}"), 1, &[name, "a square with sides of 64 to 512 pixels"]);
    }
    place.fails("measure tests --texture none.png", 1, &["none.png"]);
    place.fails("measure tests -o strip.png", 1, &["strip.png"]);
}
