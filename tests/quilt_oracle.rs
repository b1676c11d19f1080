//! The quilting oracle against values worked by hand, against its properties, and against a second telling of the
//! method.

mod quilt_replay;

use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt_oracle::{
    block_hash, choice_index, guided_window, overlap_error, quilt_at_random, quilt_oracle, seam_cut, threshold,
    OracleGuide, Quilted,
};
use quilt_replay::{check, hash, Case};

/// Numbers that look random and are the same every time.
struct Noise(u64);

impl Noise {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }
}

fn noise_picture(width: u32, height: u32, levels: u64) -> Vec<[u8; 4]> {
    let mut noise = Noise(u64::from(width * 31 + height));
    let mut channel = || (noise.below(levels) * 255 / (levels - 1)) as u8;
    (0..width * height).map(|_| [channel(), channel(), channel(), channel()]).collect()
}

/// Broad waves with noise on them: nothing in it repeats within its size.
fn paint_like_picture(width: u32, height: u32) -> Vec<[u8; 4]> {
    let mut noise = Noise(7);
    let pixel = |i: u32| {
        let (x, y) = (f64::from(i % width), f64::from(i / width));
        let wave = 128.0 + 60.0 * (0.21 * x + 0.05 * y).sin() + 40.0 * (0.17 * y - 0.04 * x).cos();
        let [r, g, b] = [0.0, 8.0, -8.0].map(|tint| (wave + tint + noise.below(17) as f64 - 8.0) as u8);
        [r, g, b, 255]
    };
    (0..width * height).map(pixel).collect()
}

fn params(block_px: u32, overlap_px: u32, tileable: bool) -> QuiltParams {
    QuiltParams { block_px, overlap_px, tileable, ..Default::default() }
}

// The small functions.

#[test]
fn threshold_by_hand() {
    let cases = [
        ((0, 1000), 0),
        ((10_000, 1000), 11_000),
        ((9_999, 1000), 9_999 + 999),
        ((15, 1000), 16),
        ((9, 1000), 9),
        ((1_234_567, 0), 1_234_567),
        ((30_000, 12_345), 30_000 + 37_035),
        ((390_451_572, 100_000), 4_294_967_292),
        ((390_451_573, 100_000), u32::MAX),
        ((u32::MAX, u32::MAX), u32::MAX),
    ];
    for ((min_error, tolerance_e4), expected) in cases {
        assert_eq!(threshold(min_error, tolerance_e4), expected, "{min_error} {tolerance_e4}");
    }
}

#[test]
fn threshold_equals_its_form_in_quotient_and_remainder() {
    let mut noise = Noise(3);
    for _ in 0..2000 {
        let (min, t) = (noise.below(800_000_000), noise.below(100_001));
        let expected = min + min / 10_000 * t + min % 10_000 * t / 10_000;
        assert_eq!(u64::from(threshold(min as u32, t as u32)), expected.min(u64::from(u32::MAX)));
    }
}

#[test]
fn hash_values() {
    let cases = [
        ((0, 0, 0), 0x00e1_5a61),
        ((1, 0, 0), 0x3f26_07fd),
        ((1, 1, 0), 0x4dd9_0b44),
        ((1, 0, 1), 0xf1bb_4806),
        ((u32::MAX, 12_345, 7), 0x7285_6b0f),
    ];
    for ((seed, block, frame), expected) in cases {
        assert_eq!(block_hash(seed, block, frame), expected);
    }
    for i in 0..3000 {
        let counters = (i * 7919, i, i % 5);
        assert_eq!(u64::from(block_hash(counters.0, counters.1, counters.2)), hash(counters.0, counters.1, counters.2));
    }
}

#[test]
fn choice_by_hand() {
    let half = 1 << 31;
    for ((hash, count), expected) in
        [((0, 5), 0), ((u32::MAX, 5), 4), ((half, 2), 1), ((half - 1, 2), 0), ((half, 5), 2), ((u32::MAX, 1), 0)]
    {
        assert_eq!(choice_index(hash, count), expected, "{hash} of {count}");
    }
}

#[test]
fn cuts_by_hand() {
    // The least totals are 1 5 0 / 2 0 5 / 1 5 0: the cut ends right, comes from the middle, and began right.
    assert_eq!(seam_cut(&[1, 5, 0, 1, 0, 5, 1, 5, 0], 3), [2, 1, 2]);
    // Ties go left, at the end and on the way back.
    assert_eq!(seam_cut(&[0; 12], 3), [0, 0, 0, 0]);
    assert_eq!(seam_cut(&[0, 0, 0, 9, 9, 0], 3), [1, 2]);
    // It cannot jump from the cheap left column to the cheap right one: 0+9+0 against 9+0+9 in the middle.
    assert_eq!(seam_cut(&[0, 9, 9, 9, 9, 9, 9, 9, 0], 3), [0, 1, 2]);
    assert_eq!(seam_cut(&[4, 4, 4], 1), [0, 0, 0]);
    assert_eq!(seam_cut(&[], 3), []);
    assert_eq!(seam_cut(&[1, 2], 0), []);
}

#[test]
fn cuts_are_the_best_of_all_paths() {
    /// Every path down a table, each as its columns from the last row upwards.
    fn all_paths(rows: usize, strip: i64) -> Vec<Vec<i64>> {
        let mut paths: Vec<Vec<i64>> = (0..strip).map(|j| vec![j]).collect();
        for _ in 1..rows {
            let extend = |path: Vec<i64>| {
                let last = path[path.len() - 1];
                let next = (last - 1..=last + 1).filter(|j| (0..strip).contains(j));
                next.map(|j| [path.clone(), vec![j]].concat()).collect::<Vec<_>>()
            };
            paths = paths.into_iter().flat_map(extend).collect();
        }
        paths
    }
    let mut noise = Noise(11);
    for (rows, strip) in [(1, 4), (3, 2), (4, 3), (5, 4), (6, 3)] {
        for _ in 0..60 {
            let table: Vec<u32> = (0..rows * strip).map(|_| noise.below(4) as u32).collect();
            let total = |upwards: &Vec<i64>| -> u32 {
                let cells = upwards.iter().rev().enumerate();
                cells.map(|(i, &j)| table[i * strip + j as usize]).sum()
            };
            let best = all_paths(rows, strip as i64).into_iter().min_by_key(|path| (total(path), path.clone()));
            let expected: Vec<u32> = best.expect("a path").into_iter().rev().map(|j| j as u32).collect();
            assert_eq!(seam_cut(&table, strip as u32), expected, "{table:?} {strip}");
        }
    }
}

#[test]
fn overlap_error_by_hand() {
    let sample: Vec<[u8; 4]> = (0..12).map(|i| [i, 0, 0, 99]).collect();
    // A block of two columns and two rows at (1, 1) of a sample of 4 x 3 covers 5, 6 and 9, 10.
    let old = [Some([5, 0, 0]), None, Some([7, 3, 1]), Some([10, 0, 255])];
    assert_eq!(overlap_error(&sample, (4, 3), &old, 2, (1, 1)), Some(4 + 9 + 1 + 255 * 255));
    assert_eq!(overlap_error(&sample, (4, 3), &[None; 4], 2, (2, 1)), Some(0));
    for outside in [(3, 1), (2, 2), (0, u32::MAX), (u32::MAX, 0)] {
        assert_eq!(overlap_error(&sample, (4, 3), &old, 2, outside), None, "{outside:?}");
    }
    // The largest sum that any block can have still fits.
    let error = overlap_error(&[[255; 4]; 4096], (64, 64), &[Some([0; 3]); 4096], 64, (0, 0));
    assert_eq!(error, Some(799_027_200));
}

#[test]
fn guided_windows_by_hand() {
    // A sample of 100 px, blocks of 10: the last position is 90.
    let window = |sum, covered, window_px| guided_window(sum, covered, 100, 10, window_px);
    assert_eq!(window(0, 4, 15), Some((0, 15)));
    assert_eq!(window(4 * 255, 4, 15), Some((85, 90)));
    assert_eq!(window(4 * 255, 4, 5), Some((90, 90)));
    // A mean of 128: 100 * 128 / 255 = 50.2.
    assert_eq!(window(128, 1, 15), Some((35, 65)));
    // Just below and at a whole column: 51/255 is a fifth.
    assert_eq!((window(50, 1, 0), window(51, 1, 0)), (Some((19, 19)), Some((20, 20))));
    assert_eq!(window(0, 1, 0), Some((0, 0)));
    assert_eq!(window(255, 1, 0), Some((90, 90)));
    assert_eq!(window(100, 1, u32::MAX), Some((0, 90)));
    assert_eq!(window(0, 0, 15), None);
}

// Two blocks, by hand. The same pictures lying on their side try the top and bottom strips.

fn transposed<T: Copy>(pixels: &[T], width: usize) -> Vec<T> {
    (0..width).flat_map(|x| pixels.iter().skip(x).step_by(width).copied()).collect()
}

/// Quilts a sample both upright and lying on its side, and returns the sources of both, the second turned back.
fn both_ways(case: &Case, expected: &[[Option<u16>; 8]]) -> (Quilted, Quilted) {
    let upright = case.quilt();
    let (width, height) = (case.output.0 as usize, case.output.1 as usize);
    let sample = transposed(case.sample, case.size.0 as usize);
    let shade = case.guide.map(|guide| transposed(guide.shade, width));
    let covered = case.guide.map(|guide| transposed(guide.covered, width));
    let guide = shade.as_ref().zip(covered.as_ref()).map(|(shade, covered)| {
        let window_px = case.size.0;
        OracleGuide { shade, covered, window_px }
    });
    let (size, output) = ((case.size.1, case.size.0), (case.output.1, case.output.0));
    let lying = Case { sample: &sample, size, output, guide, ..*case }.quilt();
    for (y, row) in expected.iter().enumerate().take(height) {
        for (x, from) in row.iter().enumerate().take(width) {
            let source = from.map(|sx| (sx, y as u16));
            assert_eq!(upright.source[y * width + x], source, "upright ({x}, {y})");
            assert_eq!(lying.source[x * height + y], source.map(|(sx, sy)| (sy, sx)), "lying ({y}, {x})");
        }
    }
    (upright, lying)
}

#[test]
fn a_plain_quilt_of_two_blocks_by_hand() {
    // Blocks of 4 overlap by 2 in an output of 6 x 4. With seed 1 the first block takes position 0 of the two (its hash
    // is below one half), so that the second meets columns 2 and 3 of the sample: with columns 1 and 2 at position 1,
    // or with columns 0 and 1, which are far off, at position 0.
    let rows: [[u8; 5]; 4] = [[100, 0, 1, 3, 200], [100, 0, 1, 2, 201], [100, 0, 5, 6, 202], [100, 0, 5, 5, 203]];
    let sample: Vec<[u8; 4]> = rows.as_flattened().iter().map(|&v| [v, v, v, 0]).collect();
    let case = Case { sample: &sample, size: (5, 4), output: (6, 4), params: params(4, 2, false), guide: None };
    // Errors in the strip, each three times the square: 3 12 / 3 3 / 75 3 / 75 0, in all 174. Least totals: 3 12 / 6 6
    // / 81 9 / 84 9. The cut ends right, stays right, and takes the left of two sixes: 0 0 1 1.
    let new = [0, 1, 1, 2, 3, 4, 0, 0].map(Some);
    let mut kept = new;
    kept[2] = Some(2);
    let (upright, lying) = both_ways(&case, &[new, new, kept, kept]);
    for quilted in [&upright, &lying] {
        assert_eq!(quilted.blocks.len(), 2);
        assert_eq!([quilted.blocks[0].error, quilted.blocks[0].min_error], [0, 0]);
        assert_eq!([quilted.blocks[1].error, quilted.blocks[1].min_error], [174, 174]);
    }
    let first = &upright.blocks[0];
    assert_eq!(([first.x, first.y, first.sx, first.sy], first.allowed), ([0, 0, 0, 0], [0, 0, 1, 0]));
    let second = &upright.blocks[1];
    assert_eq!([second.row, second.col, second.x, second.y, second.sx, second.sy], [0, 1, 2, 0, 1, 0]);
    assert_eq!(lying.blocks[1].allowed, [0, 0, 0, 1]);
    assert_eq!(upright.pixels[2 * 6 + 2], [5, 5, 5, 255]);
}

#[test]
fn a_ring_of_two_blocks_by_hand() {
    // Blocks of 6 overlap by 2 in a ring of 8: the second one lies at 4 and meets the first on both of its sides, the
    // sample's columns 0 1 meeting 4 5 on the left and 4 5 meeting 0 1 on the right. Only the upper row of blocks is
    // covered, by one pixel each that no other block reaches. A sample of 6 x 6 has only one position.
    let mut covered = [false; 64];
    covered[2 * 8 + 2] = true;
    covered[2 * 8 + 6] = true;
    let shade = [200; 64];
    let guide = OracleGuide { shade: &shade, covered: &covered, window_px: 6 };
    // Columns 0 and 4 differ by 1, columns 1 and 5 by 2: the cut runs along the first column of each strip, where all
    // is new. So on the left nothing is kept, on the right the second column: pixel 1. The other way round the cuts run
    // along the second columns, and on the left the first column is kept, on the right nothing.
    let outer = ([10, 20, 30, 40, 11, 22], [4, 1, 2, 3, 0, 1, 2, 3]);
    let inner = ([10, 20, 30, 40, 12, 21], [4, 5, 2, 3, 4, 1, 2, 3]);
    for (row, sources) in [outer, inner] {
        let sample: Vec<[u8; 4]> = [row; 6].as_flattened().iter().map(|&v| [v, 0, 0, 255]).collect();
        let params = params(6, 2, true);
        let case = Case { sample: &sample, size: (6, 6), output: (8, 8), params, guide: Some(guide) };
        let painted = sources.map(Some);
        let mut expected = [painted; 8];
        expected[6..].fill([None; 8]);
        let (upright, lying) = both_ways(&case, &expected);
        // Six rows, two strips, 1 + 4 in each row of a strip.
        assert_eq!([upright.blocks[1].error, lying.blocks[1].error], [60, 60]);
        assert_eq!(upright.pixels[7 * 8], [0; 4]);
    }
}

// Whole quilts against their second telling.

/// Calls back with quilts of every kind: plain and tileable, clipped, guided with gaps, tolerant and strict.
fn for_every_kind(mut visit: impl FnMut(&str, &Case)) {
    let sample = noise_picture(23, 19, 3);
    let shade: Vec<u8> = (0..37 * 29).map(|i| (i % 37 * 7) as u8).collect();
    let covered: Vec<bool> = (0..37 * 29).map(|i| (i % 37 / 11 + i / 37 / 9) % 2 == 0 && i % 5 > 1).collect();
    for (block, overlap) in [(4, 2), (7, 3), (12, 4), (19, 1)] {
        for tileable in [false, true] {
            for (tolerance, seed, window_px) in [(0.0, 1, 0), (0.1, 9, 5), (3.0, 77, 40)] {
                let params = QuiltParams { tolerance, seed, ..params(block, overlap, tileable) };
                let guide = OracleGuide { shade: &shade, covered: &covered, window_px };
                for guide in [None, Some(guide)] {
                    let case = Case { sample: &sample, size: (23, 19), output: (37, 29), params, guide };
                    if params.validate(case.size, case.output).is_ok() {
                        let name = format!("{params:?}, guide {}", guide.is_some());
                        visit(&name, &case);
                    }
                }
            }
        }
    }
}

#[test]
fn quilts_of_every_kind_agree_with_their_second_telling() {
    let (mut tileable, mut skipping) = (0, 0);
    for_every_kind(|name, case| {
        let quilted = case.quilt();
        assert_eq!(check(case, &quilted), Ok(()), "{name}");
        tileable += u32::from(case.params.tileable);
        skipping += u32::from(quilted.source.contains(&None));
    });
    assert!(tileable >= 12 && skipping >= 6, "{tileable} {skipping}");
}

#[test]
fn the_second_telling_notices_every_planted_difference() {
    let sample = noise_picture(20, 16, 3);
    let case = Case { sample: &sample, size: (20, 16), output: (30, 20), params: params(8, 3, true), guide: None };
    let good = case.quilt();
    let planted: [fn(&mut Quilted); 9] = [
        |quilt| quilt.blocks[3].error += 1,
        |quilt| quilt.blocks[3].min_error += 1,
        |quilt| quilt.blocks[5].sx ^= 1,
        |quilt| quilt.blocks[5].allowed[2] -= 1,
        |quilt| quilt.blocks.swap(1, 2),
        |quilt| quilt.blocks.truncate(quilt.blocks.len() - 1),
        |quilt| quilt.blocks.push(quilt.blocks[0]),
        |quilt| quilt.pixels[40][2] ^= 1,
        |quilt| quilt.source[40] = quilt.source[41],
    ];
    for (number, plant) in planted.iter().enumerate() {
        let mut changed = good.clone();
        plant(&mut changed);
        assert!(check(&case, &changed).is_err(), "planted difference {number}");
    }
}

#[test]
fn every_pixel_is_a_copy_and_a_constant_sample_stays_constant() {
    for_every_kind(|name, case| {
        let quilted = case.quilt();
        for (pixel, source) in quilted.pixels.iter().zip(&quilted.source) {
            let copied = source.map(|(x, y)| case.sample[usize::from(y) * 23 + usize::from(x)]);
            assert_eq!(*pixel, copied.map_or([0; 4], |[r, g, b, _]| [r, g, b, 255]), "{name}");
        }
        if case.guide.is_none() {
            let constant = Case { sample: &[[9, 8, 7, 0]; 23 * 19], ..*case }.quilt();
            assert!(constant.pixels.iter().all(|pixel| *pixel == [9, 8, 7, 255]), "{name}");
        }
    });
}

#[test]
fn the_seed_decides() {
    let sample = noise_picture(24, 24, 5);
    let quilt = |seed| {
        let params = QuiltParams { seed, ..params(8, 2, false) };
        Case { sample: &sample, size: (24, 24), output: (40, 40), params, guide: None }.quilt()
    };
    assert_eq!(quilt(5), quilt(5));
    assert_ne!(quilt(5).pixels, quilt(6).pixels);
}

#[test]
fn outputs_smaller_than_a_block() {
    let sample = noise_picture(12, 10, 4);
    for output in [(1, 1), (7, 3), (8, 8), (9, 8), (1, 20)] {
        let case = Case { sample: &sample, size: (12, 10), output, params: params(8, 4, false), guide: None };
        assert_eq!(check(&case, &case.quilt()), Ok(()), "{output:?}");
    }
    let case = Case { sample: &sample, size: (12, 10), output: (1, 1), params: params(8, 4, false), guide: None };
    let quilted = case.quilt();
    let only = &quilted.blocks[0];
    // Even so the position keeps a whole block inside of the sample.
    assert_eq!((quilted.blocks.len(), only.allowed), (1, [0, 0, 4, 2]));
    assert_eq!(quilted.source, [Some((only.sx as u16, only.sy as u16))]);
}

// The guide.

#[test]
fn skipped_blocks_leave_gaps_and_are_no_neighbours() {
    // A 2 x 2 grid of blocks of 8 overlapping by 2. Only the upper left and the lower right block are covered.
    let sample = noise_picture(20, 20, 256);
    let mut covered = [false; 14 * 14];
    covered[0] = true;
    covered[14 * 14 - 1] = true;
    let guide = OracleGuide { shade: &[90; 14 * 14], covered: &covered, window_px: 0 };
    let case =
        Case { sample: &sample, size: (20, 20), output: (14, 14), params: params(8, 2, false), guide: Some(guide) };
    let quilted = case.quilt();
    assert_eq!(check(&case, &quilted), Ok(()));
    let cells: Vec<_> = quilted.blocks.iter().map(|block| (block.row, block.col)).collect();
    assert_eq!(cells, [(0, 0), (1, 1)]);
    // The corner that they share was compared, but, with no neighbour to cut against, is all the second one's.
    let second = &quilted.blocks[1];
    assert!(second.error > 0);
    for (x, y) in [(6, 6), (7, 6), (6, 7), (7, 7)] {
        let expected = Some(((second.sx + x - 6) as u16, (second.sy + y - 6) as u16));
        assert_eq!(quilted.source[(y * 14 + x) as usize], expected);
    }
    assert_eq!((quilted.pixels[13], quilted.source[13]), ([0; 4], None));
    // With nothing covered, nothing is painted.
    let nowhere = Case { guide: Some(OracleGuide { covered: &[false; 14 * 14], ..guide }), ..case }.quilt();
    assert!(nowhere.blocks.is_empty() && nowhere.pixels.iter().all(|pixel| *pixel == [0; 4]));
}

#[test]
fn the_mean_shade_of_the_covered_pixels_steers_each_block() {
    // 40 px of sample, blocks of 8: the last position is 32. The left block sees 0, the right one 255; what is not
    // covered does not count.
    let sample = noise_picture(40, 12, 256);
    let shade: Vec<u8> = (0..14 * 8).map(|i| if i % 14 < 8 { 0 } else { 255 }).collect();
    let covered: Vec<bool> = (0..14 * 8).map(|i| i % 14 < 6 || i % 14 >= 8).collect();
    for (window_px, left, right) in [(0, 0..=0, 32..=32), (8, 0..=8, 32..=32), (12, 0..=12, 28..=32)] {
        let guide = Some(OracleGuide { shade: &shade, covered: &covered, window_px });
        let case = Case { sample: &sample, size: (40, 12), output: (14, 8), params: params(8, 2, false), guide };
        let quilted = case.quilt();
        assert_eq!(check(&case, &quilted), Ok(()));
        assert_eq!(quilted.blocks[0].allowed, [*left.start(), 0, *left.end(), 4], "window {window_px}");
        assert_eq!(quilted.blocks[1].allowed, [*right.start(), 0, *right.end(), 4], "window {window_px}");
        assert!(left.contains(&quilted.blocks[0].sx) && right.contains(&quilted.blocks[1].sx));
    }
}

#[test]
fn wrong_pixel_counts_are_refused() {
    let sample = [[0; 4]; 64];
    let params = params(8, 2, false);
    let guide = OracleGuide { shade: &[0; 25], covered: &[true; 25], window_px: 0 };
    let run = |sample: &[[u8; 4]], guide: &OracleGuide| {
        quilt_oracle(sample, (8, 8), (5, 5), &params, Some(guide)).map_err(|error| error.to_string())
    };
    assert!(run(&sample, &guide).is_ok());
    let refused = [
        (run(&sample[1..], &guide), "sample is 63 pixels, but must be 8 x 8 pixels"),
        (run(&sample, &OracleGuide { shade: &[0; 26], ..guide }), "guide shade is 26 pixels, but must be 5 x 5 pixels"),
        (run(&sample, &OracleGuide { covered: &[], ..guide }), "guide covered is 0 pixels, but must be 5 x 5 pixels"),
    ];
    for (result, message) in refused {
        assert_eq!(result, Err(message.to_string()));
    }
}

// Tileable outputs.

/// How much stronger the step from the last to the first column is than the mean step between columns: a ratio of mean
/// squared differences. Then the same for rows.
fn wrap_seam(quilted: &Quilted) -> [f64; 2] {
    let (w, h) = (quilted.width as usize, quilted.height as usize);
    let ratio = |pixels: &[[u8; 4]], side: usize| {
        let step = |x: usize| -> f64 {
            let rows = pixels.chunks(side);
            let channel = |row: &[[u8; 4]], c: usize| f64::from(row[x][c]) - f64::from(row[(x + 1) % side][c]);
            rows.map(|row| (0..3).map(|c| channel(row, c).powi(2)).sum::<f64>()).sum()
        };
        let inside: f64 = (0..side - 1).map(step).sum();
        step(side - 1) * (side - 1) as f64 / inside
    };
    [ratio(&quilted.pixels, w), ratio(&transposed(&quilted.pixels, w), h)]
}

#[test]
fn a_tileable_quilt_wraps_round_without_a_stronger_seam() {
    let sample = paint_like_picture(64, 64);
    for (seed, output) in [(1, (64, 64)), (2, (100, 77)), (3, (48, 90))] {
        let tileable = QuiltParams { seed, ..params(16, 4, true) };
        let case = Case { sample: &sample, size: (64, 64), output, params: tileable, guide: None };
        let seam = wrap_seam(&case.quilt());
        assert!(seam.iter().all(|&ratio| ratio <= 1.5), "seed {seed}: {seam:?}");
        // The measure can tell: a plain quilt of the same sample does not wrap.
        let plain = Case { params: QuiltParams { tileable: false, ..tileable }, ..case }.quilt();
        let seam = wrap_seam(&plain);
        assert!(seam.iter().all(|&ratio| ratio > 1.5), "seed {seed}, plain: {seam:?}");
    }
}

// Blocks at random.

#[test]
fn blocks_at_random_take_every_allowed_position_however_it_fits() {
    // Flat on the left, where blocks fit without an error, and noise on the right, where they do not.
    let mut sample = noise_picture(32, 16, 256);
    (0..32 * 16).filter(|place| place % 32 < 16).for_each(|place| sample[place] = [90; 4]);
    let params = QuiltParams { seed: 5, ..params(4, 1, false) };
    let random = |params: &QuiltParams, allowed: [u32; 4]| {
        quilt_at_random(&sample, (32, 16), (97, 97), params, |_| allowed).map_err(|error| error.to_string())
    };
    let sources = random(&params, [0, 0, 28, 12]).expect("sources");
    assert_eq!(sources.len(), 97 * 97);
    // 4096 blocks on 29 * 13 positions: of the pixels in the block's middle, all that there are are seen.
    let seen: std::collections::BTreeSet<_> = sources.iter().filter(|(_, y)| (1..15).contains(y)).collect();
    assert!(seen.len() > 30 * 14, "{}", seen.len());
    let flat = sources.iter().filter(|(x, _)| *x < 16).count() as f64 / sources.len() as f64;
    assert!((flat - 0.5).abs() < 0.05, "{flat}");
    assert_eq!(sources, random(&params, [0, 0, 28, 12]).expect("sources"));
    assert_ne!(sources, random(&QuiltParams { seed: 6, ..params }, [0, 0, 28, 12]).expect("sources"));
    // With one position, block (row, col) begins at (3 col, 3 row), and the cut is the strip's only column.
    let fixed = random(&params, [7, 5, 7, 5]).expect("sources");
    for (place, source) in (0u16..).zip(fixed.chunks(97).take(90).flat_map(|row| &row[..90])) {
        let (x, y) = (place % 90, place / 90);
        assert_eq!(*source, (7 + x % 3, 5 + y % 3), "{x}, {y}");
    }
    for outside in [[0, 0, 29, 12], [0, 0, 28, 13], [2, 0, 1, 12], [0, 2, 28, 1]] {
        assert!(random(&params, outside).expect_err("refused").contains("within 0, 0 to 28, 12"), "{outside:?}");
    }
    assert!(random(&QuiltParams { block_px: 3, ..params }, [0; 4]).expect_err("refused").contains("block_px"));
}
