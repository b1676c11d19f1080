//! Quiltings of all kinds, each by every way to search.

use crate::common::{data_dir, noise};
use crate::pruned::strokes;
use crate::{difference, params, random_guide, Bench, Case, Guide};
use impasto::gpu::Uploads;
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::synthesis::params::Layout;
use impasto::synthesis::quilt::{Quilt, SampleTexels};
use impasto::synthesis::quilt_oracle::{block_hash, choice_index};

#[test]
fn free_quilting_equals_the_oracle() {
    let mut bench = Bench::of_every_search();
    for (i, (size, output, block_px, overlap_px, tolerance, tileable)) in [
        ((48, 40), (96, 80), 16, 4, 0.1, false),
        ((33, 57), (101, 67), 12, 3, 0.0, false),
        ((64, 64), (128, 96), 32, 6, 0.3, false),
        ((20, 20), (64, 64), 16, 8, 1.0, true),
        ((40, 24), (75, 49), 16, 5, 0.1, true),
        ((64, 64), (30, 200), 64, 32, 0.1, false),
        // Outputs of one pixel, and narrower than a block.
        ((48, 40), (1, 1), 16, 4, 0.1, false),
        ((48, 40), (5, 61), 16, 4, 0.1, false),
        ((48, 40), (61, 3), 16, 4, 0.1, false),
        // A sample that is one block: a single position.
        ((16, 16), (50, 40), 16, 4, 0.1, false),
        ((16, 29), (50, 40), 16, 4, 0.1, true),
        // Primes.
        ((37, 53), (89, 71), 13, 5, 0.1, false),
        ((53, 37), (97, 59), 11, 3, 0.1, true),
        // The least overlap, the least block, the largest tolerance.
        ((40, 30), (70, 50), 9, 1, 0.1, false),
        ((40, 30), (70, 50), 9, 1, 0.1, true),
        ((24, 18), (41, 31), 4, 1, 0.1, false),
        ((24, 18), (42, 30), 4, 2, 0.5, true),
        ((40, 30), (61, 47), 10, 3, 10.0, false),
        // The least tileable outputs: two blocks a side that meet themselves.
        ((40, 30), (8, 8), 8, 4, 0.1, true),
        ((40, 30), (4, 60), 8, 2, 0.1, true),
    ]
    .into_iter()
    .enumerate()
    {
        let sample = if block_px > 30 { strokes(size) } else { noise(size.0, size.1, i as u32 + 7) };
        let params = params(block_px, overlap_px, tolerance, 11 + i as u32, tileable);
        let case = Case { sample: &sample, size, output, params, guide: None };
        bench.check(&case, &format!("case {i}"));
    }
}

/// More blocks than a row of workgroups may have on every device, and more than anybody may ask for.
#[test]
fn very_many_blocks_equal_the_oracle() {
    let mut bench = Bench::new();
    let sample = noise(9, 9, 8);
    let wide = params(4, 2, 0.1, 9, false);
    let case = Case { sample: &sample, size: (9, 9), output: (2600, 60), params: wide, guide: None };
    assert!(bench.check(&case, "36,000 blocks").blocks.len() > 35_000);
    let message = wide.validate((9, 9), (16_384, 16_384)).map_err(|e| e.to_string()).expect_err("67 million blocks");
    assert!(message.contains("number of blocks"), "{message}");
}

/// The search is compiled for runs of 4, 5 and 6 texels; these are the overlaps and blocks that choose each.
#[test]
fn every_chunk_of_the_search_equals_the_oracle() {
    let mut bench = Bench::of_every_search();
    let sample = noise(61, 45, 5);
    for (block_px, overlap_px) in [(16, 4), (32, 8), (15, 5), (20, 5), (18, 6), (30, 6), (7, 2), (23, 7), (64, 31)] {
        let size = (61.max(block_px), 45);
        let size = if block_px > 45 { (70, 66) } else { size };
        let own = if block_px > 45 { strokes(size) } else { noise(size.0, size.1, 5) };
        let sample = if size == (61, 45) { &sample } else { &own };
        for tileable in [false, true] {
            let output = (2 * block_px + 9, 2 * block_px + 5);
            let params = params(block_px, overlap_px, 0.1, block_px, tileable);
            if params.validate(size, output).is_err() {
                continue;
            }
            let case = Case { sample, size, output, params, guide: None };
            bench.check(&case, &format!("block {block_px}, overlap {overlap_px}, tileable {tileable}"));
        }
    }
}

/// Where all positions are equally good, the choice alone decides, over the whole of the sample.
#[test]
fn a_constant_sample_is_chosen_from_evenly() {
    let mut bench = Bench::of_every_search();
    let sample = vec![[90, 120, 40, 255]; 50 * 38];
    let case = |seed| Case {
        sample: &sample,
        size: (50, 38),
        output: (60, 60),
        params: params(12, 4, 0.0, seed, false),
        guide: None,
    };
    let a = bench.check(&case(1), "constant");
    let b = bench.check(&case(2), "constant, another seed");
    assert_ne!(a.source, b.source, "the seed makes no difference");
}

/// The largest sample there may be. The first block of a quilting has nothing to fit, so that every position is
/// admissible and the hash alone decides: which position follows without the oracle.
#[test]
fn the_largest_sample_is_chosen_from_as_a_whole() {
    let mut bench = Bench::new();
    let side = 4096;
    let sample: Vec<[u8; 4]> = (0..side * side).map(|i| [(i % 251) as u8, (i / side % 241) as u8, 7, 255]).collect();
    let output = (8, 8);
    let context = &bench.gpu.context;
    let mut uploads = Uploads::default();
    let texels = SampleTexels::new(context, &mut uploads, &sample, (side, side)).expect("sample");
    let params = params(8, 2, 0.1, 0, false);
    let quilt = Quilt::new(context, &mut uploads, &bench.stages, &texels, output, &params, None).expect("quilt");
    let case = Case { sample: &sample, size: (side, side), output, params, guide: None };
    for seed in 0..4 {
        let recorded = bench.runner.run(|recorder| {
            uploads.record(recorder);
            quilt.record(recorder, seed, 0);
            Ok(())
        });
        recorded.expect("run");
        let got = case.read(&mut bench.runner, &quilt);
        let columns = side - 8 + 1;
        let choice = choice_index(block_hash(seed, 0, 0), columns * columns);
        let block = got.blocks[0];
        assert_eq!((block.sx, block.sy), (choice % columns, choice / columns), "seed {seed}");
        assert_eq!((block.error, block.min_error), (0, 0));
        for (i, source) in got.source.iter().enumerate() {
            let at = (block.sx as u16 + i as u16 % 8, block.sy as u16 + i as u16 / 8);
            assert_eq!(*source, Some(at), "seed {seed}, pixel {i}");
        }
    }
}

/// The errors of a wave that do not fit their memory, and a search too long for one dispatch, are cut.
#[test]
fn cut_waves_and_searches_equal_the_oracle() {
    let mut bench = Bench::new();
    // A pruned search would not be cut.
    bench.stages = bench.parts(1);
    let counts = |bench: &mut Bench| {
        let times = bench.runner.take_times();
        ["quilt_search", "quilt_place"].map(|name| times.iter().find(|t| t.name == name).map_or(0, |t| t.count))
    };
    // 5 by 3 blocks in nine waves, and 23 MB of errors a block, so that the waves of three are searched and placed in
    // two goes each. To spare the oracle the guide covers only two blocks of such a wave and one before each of them.
    let sample = noise(2400, 2400, 3);
    let output = (16, 10);
    let covered = [(11, 1), (14, 1), (4, 4), (7, 4)];
    let pixels = (0..16 * 10).map(|i| (99, u16::from(covered.contains(&(i % 16, i / 16))))).collect();
    let guide = Some(Guide { pixels, paint: 1, window_px: u32::MAX });
    let case = Case { sample: &sample, size: (2400, 2400), output, params: params(4, 1, 0.1, 5, false), guide };
    let got = bench.check(&case, "a wave cut in two");
    let placed: Vec<_> = got.blocks.iter().map(|b| (b.row, b.col)).collect();
    assert_eq!(placed, [(0, 3), (0, 4), (1, 1), (1, 2)]);
    let [_, places] = counts(&mut bench);
    assert!(places > 9, "nine waves took {places} goes: none was cut");

    // 71 groups of positions at 3.1 million comparisons each.
    let sample = noise(330, 330, 4);
    let params = params(64, 32, 0.1, 6, false);
    let case = Case { sample: &sample, size: (330, 330), output: (90, 90), params, guide: None };
    let got = bench.check(&case, "a search cut in two");
    let [searches, places] = counts(&mut bench);
    assert!(searches > places, "{searches} searches for {places} goes: none was cut");
    let stages = bench.parts(4);
    let parted = case.gpu(&mut bench.runner, &bench.gpu.context, &stages, u64::MAX);
    assert_eq!(difference(&parted, &got), Ok(()), "a search cut in two, 4 parts");
}

#[test]
fn parts_give_the_bytes_of_one_recording() {
    let mut bench = Bench::new();
    let sample = noise(48, 40, 9);
    for tileable in [false, true] {
        let case = Case {
            sample: &sample,
            size: (48, 40),
            output: (70, 52),
            params: params(16, 4, 0.1, 3, tileable),
            guide: None,
        };
        let whole = bench.check(&case, "whole");
        bench.runner.take_times();
        for comparisons in [0, 1, 500_000] {
            assert_eq!(difference(&bench.run(&case, comparisons), &whole), Ok(()), "parts of {comparisons}");
        }
    }
}

#[test]
fn guided_quilting_equals_the_oracle() {
    let mut bench = Bench::of_every_search();
    let mut skipped = 0;
    let mut placed = 0;
    // Windows of k = 0, a third, 1 and 4 blocks, and one that takes in every sample.
    for (i, (size, output, block_px, overlap_px, window_px, tileable, covered)) in [
        ((48, 40), (96, 80), 16, 4, 0, false, 128),
        ((96, 30), (83, 61), 12, 3, 4, false, 128),
        ((128, 33), (90, 70), 16, 5, 16, false, 160),
        ((128, 32), (64, 96), 8, 2, 32, true, 96),
        ((61, 47), (71, 53), 13, 6, u32::MAX, false, 128),
        ((40, 40), (80, 48), 16, 8, 7, true, 200),
        ((64, 24), (5, 90), 16, 4, 10, false, 128),
        ((64, 24), (1, 1), 16, 4, 10, false, 256),
        ((16, 16), (60, 40), 16, 4, 16, false, 60),
        ((90, 40), (99, 44), 4, 1, 1, false, 30),
    ]
    .into_iter()
    .enumerate()
    {
        let sample = noise(size.0, size.1, i as u32 + 70);
        let guide = random_guide(output, i as u32 * 77 + 5, covered, window_px);
        let params = params(block_px, overlap_px, 0.1, i as u32, tileable);
        let case = Case { sample: &sample, size, output, params, guide: Some(guide) };
        let got = bench.check(&case, &format!("guided case {i}"));
        let blocks = Layout::new(&params, output).expect("layout").placements.len();
        placed += got.blocks.len();
        skipped += blocks - got.blocks.len();
    }
    assert!(placed > 100 && skipped > 100, "{placed} blocks were placed and {skipped} skipped");
}

#[test]
fn extreme_guides_equal_the_oracle() {
    let mut bench = Bench::of_every_search();
    let sample = noise(80, 30, 8);
    let output = (50, 40);
    let run = |bench: &mut Bench, pixels: Vec<(u8, u16)>, paint, what: &str| {
        let guide = Some(Guide { pixels, paint, window_px: 3 });
        let params = params(12, 4, 0.1, 2, false);
        bench.check(&Case { sample: &sample, size: (80, 30), output, params, guide }, what)
    };
    let all = |texel| vec![texel; 50 * 40];
    let empty = run(&mut bench, all((200, 2)), 1, "nothing of this paint");
    assert!(empty.blocks.is_empty() && empty.pixels.iter().all(|p| *p == [0; 4]));
    for (shade, columns) in [(0, 0..=3), (255, 68..=68)] {
        let got = run(&mut bench, all((shade, 1)), 1, "one shade");
        assert!(got.blocks.iter().all(|b| columns.contains(&b.sx)), "shade {shade}");
    }
    let mut single = all((0, 0));
    single[50 * 39 + 49] = (128, 65_535);
    assert_eq!(run(&mut bench, single, 65_535, "one pixel of the last paint").blocks.len(), 1);
}

/// A crop of a picture's texels.
fn crop(texels: &[[u8; 4]], width: u32, (x0, y0): (u32, u32), (w, h): (u32, u32)) -> Vec<[u8; 4]> {
    let at = |i: u32| texels[((y0 + i / w) * width + x0 + i % w) as usize];
    (0..w * h).map(at).collect()
}

#[test]
fn real_paint_equals_the_oracle() {
    let Some(dir) = data_dir() else { return };
    let mut bench = Bench::of_every_search();
    for (i, name) in ["mypaint_oil_green_yellow_512x128.png", "scan_pencil_red_yellow_232x128.png"].iter().enumerate() {
        let strip = PaintSample::load(dir.join("paint").join(name)).expect("a strip");
        let trajectory = Trajectory::extract(&strip, &TrajectoryOptions::default()).expect("a trajectory");
        let texture = TextureDifference::extract(&strip, &trajectory).to_unorm8();
        let size = (120, 48);
        let at = (strip.width() / 4, 20);
        let texture = crop(&texture, strip.width(), at, size);
        let colors = crop(&strip.to_rgba8(), strip.width(), at, size);
        let output = (110, 70);
        let guide = random_guide(output, 9, 128, 24);
        let params = params(16, 5, 0.1, i as u32 + 1, false);
        for (sample, guide) in [(&texture, Some(guide.clone())), (&texture, None), (&colors, Some(guide))] {
            let case = Case { sample, size, output, params, guide };
            bench.check(&case, name);
        }
    }
}
