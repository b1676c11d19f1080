//! Searches that leave out positions: the same bytes for samples, outputs and orders of recording that try the bounds,
//! and what they leave out.

use crate::common::{noise, Numbers, Validated};
use crate::{difference, params, random_guide, Bench, Case};
use impasto::gpu::{Context, ContextOptions, Uploads};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Pruning, Quilt, QuiltStages, SampleTexels};
use impasto::Error;
use std::ops::Range;

/// What a tile has in `Quilt::tile_bounds` that was not compared, and words in a row of it.
const NO_BOUND: u32 = u32::MAX;
const BOUND_WORDS: usize = 1024;

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
///
/// Pruning takes long to prepare for large blocks of noise, which has many directions; these are as good there.
pub fn strokes(size: (u32, u32)) -> Vec<Texel> {
    let mut numbers = Numbers(5);
    let grain: Vec<u32> = (0..size.0 * size.1).map(|_| numbers.next() >> 9 & 15).collect();
    picture(size, |x, y| {
        let (x_px, y_px) = (f64::from(x), f64::from(y));
        let waves = (x_px * 0.13 + y_px * 0.41).sin() + (x_px * 0.07 - y_px * 0.19).cos();
        let light = (120.0 + 50.0 * waves) as u32 + grain[(y * size.0 + x) as usize];
        [light, light / 2 + 40, 200 - light / 2]
    })
}

/// The last row and column of blocks lack 1, 2, 3 ... pixels, so that strips are whole, in two parts, or of no use
/// there.
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

/// Halves of one length on both sides, and noise that needs all the coordinates that there may be.
#[test]
fn strips_in_two_halves_equal_the_oracle() {
    let mut bench = Bench::of_a_pruned_search();
    let sample = black_and_white((48, 40));
    for output in [(22, 20), (22, 28), (28, 20)] {
        let params = params(16, 4, 0.1, 1, false);
        let case = Case { sample: &sample, size: (48, 40), output, params, guide: None };
        bench.check(&case, &format!("{output:?}"));
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

impl Bench {
    /// A bench whose searches are all pruned.
    fn pruned() -> Self {
        let mut bench = Bench::new();
        bench.stages = QuiltStages::with_pruning(&bench.gpu.context, Pruning::On);
        bench
    }

    fn prepare(&mut self, case: &Case<'_>) -> Quilt {
        let mut uploads = Uploads::default();
        let quilt = case.quilt(&self.gpu.context, &mut uploads, &self.stages);
        let uploaded = self.runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        });
        uploaded.expect("uploads");
        quilt
    }

    /// Records a part of a synthesis, so many times in one submission.
    fn record(&mut self, quilt: &Quilt, part: &Range<usize>, seed: u32, times: usize) {
        let recorded = self.runner.run(|recorder| {
            (0..times).for_each(|_| quilt.record_part(recorder, part.clone(), seed, 0));
            Ok(())
        });
        recorded.expect("run");
    }

    fn bounds(&mut self, quilt: &Quilt) -> Vec<u32> {
        let image = quilt.tile_bounds().expect("a pruned search");
        bytemuck::pod_collect_to_vec(&self.runner.read_image(image).expect("bounds"))
    }
}

fn with_seed<'a>(case: &Case<'a>, seed: u32) -> Case<'a> {
    Case { params: QuiltParams { seed, ..case.params }, ..case.clone() }
}

/// A case of a few waves of several blocks, free or guided.
fn some_case(sample: &[Texel], guided: bool) -> Case<'_> {
    let output = (120, 90);
    let guide = guided.then(|| random_guide(output, 41, 170, 30));
    Case { sample, size: (96, 48), output, params: params(16, 4, 0.1, 1, false), guide }
}

#[test]
fn every_synthesis_of_one_quilting_equals_the_oracle() {
    let mut bench = Bench::pruned();
    let sample = strokes((96, 48));
    for guided in [false, true] {
        let case = some_case(&sample, guided);
        let quilt = bench.prepare(&case);
        let expect = |bench: &mut Bench, seed, what: &str| {
            let got = case.read(&mut bench.runner, &quilt);
            assert_eq!(difference(&got, &with_seed(&case, seed).oracle()), Ok(()), "{what}, guided {guided}");
        };
        let steps = quilt.parts(0);
        let whole = 0..steps.len();
        bench.record(&quilt, &whole, 7, 1);
        expect(&mut bench, 7, "the first");
        bench.record(&quilt, &whole, 8, 2);
        expect(&mut bench, 8, "twice in a row");
        bench.record(&quilt, &whole, 9, 1);
        expect(&mut bench, 9, "another seed");
        // An odd number: a search without its placing, so that bounds are left.
        for steps in [1, 7, 11] {
            bench.record(&quilt, &(0..steps), 10, 1);
            bench.record(&quilt, &whole, 11, 1);
            expect(&mut bench, 11, "after one that was abandoned");
        }
        for step in steps {
            bench.record(&quilt, &step, 12, 1);
        }
        expect(&mut bench, 12, "step by step");
    }
}

/// The share of tiles that are compared for all blocks that have something to fit, where a block is searched for at
/// `columns` by `rows` positions at most.
fn share_compared(bench: &mut Bench, case: &Case<'_>, columns: u32) -> f64 {
    let quilt = bench.prepare(case);
    let tiles = (columns.div_ceil(8) * (case.size.1 - case.params.block_px + 1)) as usize;
    let words = tiles.next_multiple_of(BOUND_WORDS);
    let (mut compared, mut all) = (0, 0);
    let waves = quilt.layout().waves.clone();
    let parts = quilt.parts(0);
    assert_eq!(parts.len(), 2 * waves.len(), "a search and a placing for each wave");
    for (wave, step) in waves.iter().zip(parts.chunks(2)) {
        bench.record(&quilt, &step[0], 1, 1);
        let bounds = bench.bounds(&quilt);
        assert!(bounds[wave.len() * words..].iter().all(|b| *b == NO_BOUND), "bounds of blocks that there are not");
        if wave[0] != 0 {
            compared += bounds.iter().filter(|bound| **bound != NO_BOUND).count();
            all += wave.len() * tiles;
        }
        bench.record(&quilt, &step[1], 1, 1);
        assert!(bench.bounds(&quilt).iter().all(|b| *b == NO_BOUND), "placed blocks leave bounds to the next wave");
    }
    compared as f64 / all as f64
}

/// Seven in a hundred or fewer, by trying: a tenth leaves room for devices that round otherwise, and is well below the
/// quarter that a pruned search is expected to cost at most.
#[test]
fn few_tiles_of_a_textured_sample_are_compared() {
    let mut bench = Bench::pruned();
    let sample = strokes((96, 48));
    let free = share_compared(&mut bench, &some_case(&sample, false), 81);
    let mut case = some_case(&sample, false);
    case.params.tileable = true;
    let tileable = share_compared(&mut bench, &case, 81);
    let mut guided = some_case(&sample, true);
    guided.guide.as_mut().expect("a guide").pixels.fill((128, 3));
    let guided = share_compared(&mut bench, &guided, 61);
    for (what, share) in [("free", free), ("tileable", tileable), ("guided", guided)] {
        assert!(share < 0.1, "{what}: {share}");
    }
}

/// 14 texels of 16 bytes for each position must fit into 256 MiB, and for 1,095 squared positions they do not.
#[test]
fn a_sample_too_large_for_pruning_is_searched_in_full() {
    let mut bench = Bench::pruned();
    let side = 1095 + 7;
    let sample = noise(side, side, 4);
    let params = params(8, 2, 0.1, 1, false);
    let case = Case { sample: &sample, size: (side, side), output: (13, 8), params, guide: None };
    assert!(bench.prepare(&case).tile_bounds().is_none());
    bench.check(&case, "too large");
}

#[test]
fn too_little_memory_for_pruning_is_an_error() {
    let sample = strokes((96, 48));
    let prepared = |context: &Context| {
        let mut uploads = Uploads::default();
        let stages = QuiltStages::with_pruning(context, Pruning::On);
        let texels = SampleTexels::new(context, &mut uploads, &sample, (96, 48))?;
        let case = some_case(&sample, false);
        let quilt = Quilt::new(context, &mut uploads, &stages, &texels, case.output, &case.params, None)?;
        Ok::<_, Error>((quilt, texels, uploads, context.allocated_bytes()))
    };
    let bytes = prepared(&Validated::new().context).expect("enough memory").3;
    for share in 0..8 {
        let memory_budget = Some(bytes * share / 8);
        let gpu = Validated::with(ContextOptions { memory_budget, ..Default::default() });
        let refused = prepared(&gpu.context).err();
        assert!(matches!(refused, Some(Error::Memory { .. })), "{share} eighths: {refused:?}");
    }
    let gpu = Validated::with(ContextOptions { memory_budget: Some(bytes), ..Default::default() });
    assert!(prepared(&gpu.context).is_ok());
}
