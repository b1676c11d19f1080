//! Searches that leave out positions: the same bytes for samples, outputs and orders of recording that try the bounds,
//! and what they leave out.

use crate::common::{noise, Numbers};
use crate::{params, random_guide, Bench, Case};

type Texel = [u8; 4];

fn picture((width, height): (u32, u32), colour: impl Fn(u32, u32) -> [u32; 3]) -> Vec<Texel> {
    let texel = |i| colour(i % width, i / width).map(|c| c.min(255) as u8);
    (0..width * height).map(texel).map(|[r, g, b]| [r, g, b, 255]).collect()
}

/// Black or white, pixel by pixel: the largest errors there are, and no direction better than another.
fn black_and_white(size: (u32, u32)) -> Vec<Texel> {
    let mut numbers = Numbers(77);
    let values: Vec<u32> = (0..size.0 * size.1).map(|_| 255 * (numbers.next() >> 7 & 1)).collect();
    picture(size, |x, y| [values[(y * size.0 + x) as usize]; 3])
}

/// Few directions hold all of it, and neighbouring positions have errors of a few units: the bounds are as close to
/// them as rounding allows.
fn gradient(size: (u32, u32)) -> Vec<Texel> {
    picture(size, |x, y| [x + y / 2, 250 - x, 60 + y])
}

/// Slanted waves with a little grain, as brush strokes have.
fn strokes(size: (u32, u32)) -> Vec<Texel> {
    let mut numbers = Numbers(5);
    let grain: Vec<u32> = (0..size.0 * size.1).map(|_| numbers.next() >> 9 & 15).collect();
    picture(size, |x, y| {
        let (x_px, y_px) = (f64::from(x), f64::from(y));
        let waves = (x_px * 0.13 + y_px * 0.41).sin() + (x_px * 0.07 - y_px * 0.19).cos();
        let light = (120.0 + 50.0 * waves) as u32 + grain[(y * size.0 + x) as usize];
        [light, light / 2 + 40, 200 - light / 2]
    })
}

/// The last row and column of blocks lack 1, 2, 3 ... pixels, so that strips are whole, in two parts, or of no use there.
#[test]
fn blocks_that_the_output_cuts_off_equal_the_oracle() {
    let mut bench = Bench::of_a_pruned_search();
    let size = (40, 31);
    let sample = noise(40, 31, 12);
    for cut in 0..9 {
        let output = (39 - cut, 30 - (cut * 4 + 1) % 9);
        let params = params(12, 3, 0.1, cut, false);
        bench.check(&Case { sample: &sample, size, output, params, guide: None }, &format!("{output:?}"));
    }
}

#[test]
fn samples_that_try_the_bounds_equal_the_oracle() {
    let mut bench = Bench::of_a_pruned_search();
    let size = (44, 32);
    let flat = picture(size, |_, _| [200, 30, 7]);
    // One texel differs: nearly all positions are equally good, and all directions but a few are missing.
    let spot = picture(size, |x, y| if (x, y) == (20, 15) { [255, 0, 255] } else { [12, 13, 14] });
    let halves = picture(size, |x, _| [255 * (x / 22); 3]);
    let samples = [
        ("black and white", black_and_white(size)),
        ("gradient", gradient(size)),
        ("strokes", strokes(size)),
        ("flat", flat),
        ("spot", spot),
        ("halves", halves),
    ];
    for (name, sample) in &samples {
        for (tolerance, tileable, window_px) in
            [(0.0, false, None), (10.0, false, None), (0.1, true, None), (0.0, true, None), (0.1, false, Some(9))]
        {
            let output = (45, 40);
            let guide = window_px.map(|window_px| random_guide(output, 33, 190, window_px));
            let params = params(12, 4, tolerance, 3, tileable);
            let what = format!("{name}, tolerance {tolerance}, tileable {tileable}, window {window_px:?}");
            bench.check(&Case { sample, size, output, params, guide }, &what);
        }
    }
}

#[test]
fn blocks_of_every_size_equal_the_oracle() {
    let mut bench = Bench::of_a_pruned_search();
    for (block_px, overlap_px) in [(4, 1), (4, 2), (7, 3), (16, 8), (31, 1), (48, 24), (64, 1), (64, 32)] {
        for (tileable, sample_of) in [(false, gradient as fn((u32, u32)) -> Vec<Texel>), (true, strokes)] {
            let size = (block_px + 11, block_px + 6);
            let sample = sample_of(size);
            let output = (2 * block_px + if tileable { 0 } else { 3 }, 2 * block_px);
            let params = params(block_px, overlap_px, 0.0, block_px, tileable);
            let what = format!("block {block_px}, overlap {overlap_px}, tileable {tileable}");
            bench.check(&Case { sample: &sample, size, output, params, guide: None }, &what);
        }
    }
}

#[test]
fn few_positions_equal_the_oracle() {
    let mut bench = Bench::of_a_pruned_search();
    for size in [(16, 16), (17, 16), (16, 17), (90, 16), (16, 90), (23, 18), (24, 48)] {
        let sample = strokes(size);
        for window_px in [None, Some(2)] {
            let output = (50, 41);
            let guide = window_px.map(|window_px| random_guide(output, 3, 200, window_px));
            let params = params(16, 5, 0.05, 2, false);
            bench.check(&Case { sample: &sample, size, output, params, guide }, &format!("{size:?} {window_px:?}"));
        }
    }
}

/// Several steps, and several paints of one guide.
#[test]
fn each_paint_of_a_guide_equals_the_oracle() {
    let mut bench = Bench::of_a_pruned_search();
    let size = (90, 30);
    let sample = strokes(size);
    let output = (100, 70);
    let mut placed = [0; 3];
    for (i, paint) in [3, 1, 4].into_iter().enumerate() {
        for tileable in [false, true] {
            let mut guide = random_guide(output, 19, 100, 20);
            guide.paint = paint;
            let params = params(12, 4, 0.1, 2, tileable);
            let case = Case { sample: &sample, size, output, params, guide: Some(guide) };
            placed[i] += bench.check(&case, &format!("paint {paint}, tileable {tileable}")).blocks.len();
        }
    }
    assert!(placed.iter().all(|placed| *placed > 10), "{placed:?}");
}
