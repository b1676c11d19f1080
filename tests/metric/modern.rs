//! Textures against each other: co-occurrence and sliced Wasserstein distance, by values worked by hand and by what
//! must hold of any such measure.

use impasto::metric::{cooccurrence_error, sliced_wasserstein, CooccurrenceParams, Picture, WassersteinParams};

const OUTSIDE: [u8; 4] = [90, 10, 200, 0];

fn picture(width: u32, height: u32, color: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
    let pixels = (0..width * height).map(|i| color(i % width, i / width)).collect();
    Picture::new(width, height, pixels).expect("a picture")
}

fn gray(value: u8) -> [u8; 4] {
    [value, value, value, 255]
}

/// Slanted waves of colour that repeat every four pixels in both directions.
fn waves(x: u32, y: u32) -> [u8; 4] {
    let steps = [20, 90, 240, 150];
    [steps[(x % 4) as usize], steps[((x + y) % 4) as usize], steps[(y % 4) as usize], 255]
}

/// A number that looks random, below `limit`.
fn noise(number: u32, limit: u32) -> u32 {
    let mixed = u64::from(number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) % u64::from(limit)) as u32
}

/// The same pixels in another order.
fn shuffled(of: &Picture) -> Picture {
    let mut pixels = of.pixels().to_vec();
    for i in (1..pixels.len()).rev() {
        pixels.swap(i, noise(i as u32, i as u32 + 1) as usize);
    }
    Picture::new(of.width(), of.height(), pixels).expect("a picture")
}

/// Waves of which so many in a hundred pixels are noise; those of less noise stay noise when there is more.
fn disturbed(percent: u32) -> Picture {
    picture(34, 34, |x, y| {
        let number = y * 34 + x;
        let channel = |k| noise(10_000 + 3 * number + k, 256) as u8;
        if noise(number, 100) < percent {
            [channel(0), channel(1), channel(2), 255]
        } else {
            waves(x, y)
        }
    })
}

fn near(levels: u32) -> CooccurrenceParams {
    CooccurrenceParams { levels, distances_px: vec![1] }
}

fn cooccurrence(sample: &Picture, frame: &Picture, params: &CooccurrenceParams) -> f64 {
    cooccurrence_error(sample, frame, params).expect("pairs of pixels")
}

/// All patches of 3 x 3 pixels.
const SMALL: WassersteinParams = WassersteinParams { patch_px: 3, directions: 64, patches: 65_536, seed: 1 };

fn wasserstein(sample: &Picture, frame: &Picture, params: &WassersteinParams) -> f64 {
    sliced_wasserstein(sample, frame, params).expect("patches")
}

#[test]
fn cooccurrence_by_hand() {
    let black = picture(2, 2, |_, _| gray(0));
    // 0 1
    // 0 1: along the row and both diagonals no pair is (0, 0); along the columns one of two is.
    let halves = |x, _| gray(if x == 0 { 0 } else { 255 });
    assert_eq!(cooccurrence(&black, &picture(2, 2, halves), &near(2)), (1.0 + 1.0 + 0.5 + 1.0) / 4.0);
    // What is outside is in no pair.
    let framed = picture(3, 3, |x, y| if x == 2 || y == 2 { OUTSIDE } else { halves(x, y) });
    assert_eq!(cooccurrence(&black, &framed, &near(2)), 0.875);
    // Rows against columns: only down to the right is the one as the other, from dark to light.
    let rows = picture(2, 2, |_, y| gray(if y == 0 { 0 } else { 255 }));
    assert_eq!(cooccurrence(&rows, &picture(2, 2, halves), &near(2)), (1.0 + 0.0 + 1.0 + 1.0) / 4.0);
}

#[test]
fn levels_have_equal_width_and_follow_brightness() {
    let flat = |color| picture(2, 2, move |_, _| color);
    let error = |a, b, levels| cooccurrence(&flat(a), &flat(b), &near(levels));
    assert_eq!((error(gray(0), gray(127), 2), error(gray(127), gray(128), 2)), (0.0, 1.0));
    assert_eq!((error(gray(31), gray(32), 8), error(gray(224), gray(255), 8)), (1.0, 0.0));
    // 0.587 of white is above the middle, 0.299 + 0.114 below it.
    assert_eq!(error(gray(255), [0, 255, 0, 255], 2), 0.0);
    assert_eq!(error(gray(0), [255, 0, 255, 255], 2), 0.0);
}

#[test]
fn cooccurrence_sees_order_but_not_place() {
    let params = CooccurrenceParams::default();
    let here = picture(64, 64, waves);
    let there = picture(50, 70, |x, y| waves(x + 2, y + 1));
    assert_eq!(cooccurrence(&here, &here, &params), 0.0);
    let (moved, mixed) = (cooccurrence(&here, &there, &params), cooccurrence(&here, &shuffled(&here), &params));
    assert!(moved < 0.03 && mixed > 0.4, "{moved} {mixed}");
    assert_eq!(moved, cooccurrence(&there, &here, &params));
}

#[test]
fn more_distortion_is_more_error() {
    let clean = disturbed(0);
    let values = [5, 15, 30, 60, 100].map(|percent| {
        let frame = disturbed(percent);
        (cooccurrence(&clean, &frame, &CooccurrenceParams::default()), wasserstein(&clean, &frame, &SMALL))
    });
    assert!(values[0].0 > 0.02 && values[0].1 > 0.005, "{values:?}");
    assert!(values.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1), "{values:?}");
}

#[test]
fn wasserstein_is_in_units_of_colour() {
    let flat = |value| picture(20, 20, move |_, _| gray(value));
    let params = WassersteinParams::default();
    let half = wasserstein(&flat(0), &flat(50), &params);
    // 0.7 / sqrt(256) is the deviation from seed to seed: 3 of these.
    assert!((half / (50.0 / 255.0) - 1.0).abs() < 0.13, "{half}");
    assert!((wasserstein(&flat(150), &flat(50), &params) - 2.0 * half).abs() < 1e-6);

    // One patch, of which one value differs: a step of length 1 in 27 dimensions, of which a direction sees 1/27 of the
    // square.
    let one = picture(3, 3, |x, y| if (x, y) == (1, 2) { [255, 0, 0, 255] } else { gray(0) });
    let many = WassersteinParams { directions: 4096, ..SMALL };
    let distance = wasserstein(&picture(3, 3, |_, _| gray(0)), &one, &many);
    assert!((distance * 27f64.sqrt() - 1.0).abs() < 0.04, "{distance}");
}

#[test]
fn wasserstein_sees_patches_but_not_their_place() {
    // Patches of 3 pixels stand at 16 places in each direction: four whole waves, whatever they begin with.
    let here = picture(18, 18, waves);
    let there = picture(18, 18, |x, y| waves(x + 1, y + 3));
    assert_ne!(here, there);
    assert_eq!(wasserstein(&here, &there, &SMALL), 0.0);
    // Each patch twice as often.
    assert_eq!(wasserstein(&here, &picture(34, 18, waves), &SMALL), 0.0);
    let mixed = wasserstein(&here, &shuffled(&here), &SMALL);
    assert!(mixed > 0.05, "{mixed}");
    assert_eq!(mixed, wasserstein(&shuffled(&here), &here, &SMALL));
}

#[test]
fn the_seed_decides_which_patches_are_drawn() {
    let (here, there) = (disturbed(10), disturbed(60));
    let few = |patches| WassersteinParams { directions: 1024, patches, ..SMALL };
    assert_eq!(wasserstein(&here, &here, &few(30)), 0.0);
    let (some, all) = (wasserstein(&here, &there, &few(500)), wasserstein(&here, &there, &few(65_536)));
    assert!((some / all - 1.0).abs() < 0.15 && some != all, "{some} of {all}");
    assert_eq!(some, wasserstein(&here, &there, &few(500)));

    // Eight flat patches apart from each other. Against black, the drawn one is to white as its gray.
    let flat = |value| picture(3, 3, move |_, _| gray(value));
    let eight = picture(32, 3, |x, _| if x % 4 == 3 { OUTSIDE } else { gray((x / 4) as u8 * 30) });
    let mut drawn = [false; 8];
    for seed in 0..80 {
        let params = WassersteinParams { patches: 1, seed, ..SMALL };
        let to = |frame| wasserstein(&flat(0), frame, &params);
        let number = to(&eight) / to(&flat(255)) * 255.0 / 30.0;
        assert!((number - number.round()).abs() < 1e-4, "{number}");
        drawn[number.round() as usize] = true;
    }
    assert_eq!(drawn, [true; 8]);
}

#[test]
fn patches_are_wholly_inside() {
    let with_hole =
        |hole: (u32, u32), color: [u8; 4]| picture(5, 5, move |x, y| if (x, y) == hole { color } else { waves(x, y) });
    let told = sliced_wasserstein(&with_hole((4, 4), OUTSIDE), &with_hole((2, 2), OUTSIDE), &SMALL);
    let told = told.expect_err("no patch").to_string();
    assert_eq!(told, "number of patches inside the frame is 0, but must be at least 1 of 3 x 3 pixels");
    // What is outside has no colour.
    assert_eq!(wasserstein(&with_hole((4, 4), OUTSIDE), &with_hole((4, 4), [0; 4]), &SMALL), 0.0);
    assert_ne!(wasserstein(&with_hole((4, 4), OUTSIDE), &with_hole((9, 9), OUTSIDE), &SMALL), 0.0);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let (fine, nothing) = (picture(9, 9, waves), picture(9, 9, |_, _| OUTSIDE));
    let told = cooccurrence_error(&nothing, &fine, &near(8)).expect_err("no pair").to_string();
    assert!(told.contains("pairs inside the sample is 0") && told.contains("(1, 0) px"), "{told}");
    let told = cooccurrence_error(&fine, &picture(9, 8, waves), &CooccurrenceParams::default());
    let told = told.expect_err("8 rows have no pair 8 apart").to_string();
    assert!(told.contains("pairs inside the frame is 0") && told.contains("(8, 8) px"), "{told}");
    for (levels, distances_px) in [(1, vec![1]), (65, vec![1]), (8, vec![]), (8, vec![1, 0]), (8, vec![257])] {
        let params = CooccurrenceParams { levels, distances_px };
        assert!(cooccurrence_error(&fine, &fine, &params).is_err(), "{params:?}");
    }
    for (patch_px, directions, patches) in [(2, 1, 1), (17, 1, 1), (3, 0, 1), (3, 4097, 1), (3, 1, 0), (3, 1, 65_537)] {
        let params = WassersteinParams { patch_px, directions, patches, seed: 1 };
        assert!(sliced_wasserstein(&fine, &fine, &params).is_err(), "{params:?}");
    }
}
