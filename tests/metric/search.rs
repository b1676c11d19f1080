//! Features, and the search for the nearest.

use super::*;
use impasto::metric::{block_corner, BlockSearch, Eligible, FeatureBins, Features, Neighbour, BINS, BLOCK_PX};

/// The feature vector as section 9.1 reads, in floats and a pixel at a time.
fn plain(picture: &Picture, pixel: (u32, u32), block_px: u32) -> Features {
    let (width, height) = (picture.width() as i32, picture.height() as i32);
    let value = |x: i32, y: i32, channel: usize| {
        let (x, y) = (x.max(0).min(width - 1), y.max(0).min(height - 1));
        f64::from(picture.pixels()[(y * width + x) as usize][channel]) / 255.0
    };
    let filters = [
        [[-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]],
        [[-1.0, -1.0, -1.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
        [[0.0, 0.0, 3.0], [0.0, 0.0, 0.0], [-3.0, 0.0, 0.0]],
        [[-3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 3.0]],
    ];
    let side = block_px as i32;
    let begin = |at: u32, of: i32| (at as i32 - side / 2).max(0).min(of - side);
    let (left, top) = (begin(pixel.0, width), begin(pixel.1, height));
    let mut counts = [[0u8; BINS]; 15];
    for (y, x) in (top..top + side).flat_map(|y| (left..left + side).map(move |x| (y, x))) {
        for channel in 0..3 {
            // A hair above, so that a boundary's value falls into the upper bin whatever a float's last bits are.
            let bin = |part: f64| ((part * 10.0 + 1e-9) as usize).min(9);
            counts[5 * channel][bin(value(x, y, channel))] += 1;
            for (k, filter) in filters.iter().enumerate() {
                let mut sum = 0.0;
                for (row, dy) in filter.iter().zip(-1..) {
                    for (factor, dx) in row.iter().zip(-1..) {
                        sum += factor * value(x + dx, y + dy, channel);
                    }
                }
                counts[5 * channel + 1 + k][bin((sum + 3.0) / 6.0)] += 1;
            }
        }
    }
    Features(counts)
}

#[test]
fn features_equal_plain_code_exactly() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let search = BlockSearch::new(&gpu.context, 10).expect("a search");
    for picture in [noise_picture(37, 23, 1), part(&strip("strip_dark_red.png"), (100, 20), (90, 40))] {
        let pixels: Vec<(u32, u32)> =
            (0..picture.height()).flat_map(|y| (0..picture.width()).map(move |x| (x, y))).collect();
        for block_px in [4, 5, 8, 12] {
            let got = search.features(&mut runner, &picture, block_px, &pixels).expect("features");
            let bins = FeatureBins::new(&picture);
            let size = (picture.width(), picture.height());
            for (&pixel, got) in pixels.iter().zip(&got) {
                let want = plain(&picture, pixel, block_px);
                assert!(*got == want, "pixel {pixel:?}, block {block_px}");
                assert!(bins.features(block_corner(pixel, size, block_px), block_px) == want);
                let sum: u32 = got.0[7].iter().map(|count| u32::from(*count)).sum();
                assert_eq!(sum, block_px * block_px);
            }
            let kinds: std::collections::BTreeSet<_> = got.iter().collect();
            assert!(kinds.len() * 4 > pixels.len(), "there are features to tell apart");
        }
    }
}

#[test]
fn known_blocks_have_known_features_and_distances() {
    let gray = |values: &dyn Fn(u32, u32) -> u8| {
        let pixels = (0..64).map(|i| (i % 8, i / 8)).map(|(x, y)| [values(x, y), values(x, y), values(x, y), 255]);
        Picture::new(8, 8, pixels.collect()).expect("a picture")
    };
    let features = |picture: &Picture| FeatureBins::new(picture).features((2, 2), 4);
    // Black, and white: no edges, so all edge histograms have their 16 pixels at 0, which begins bin 5.
    let (black, white) = (features(&gray(&|_, _| 0)), features(&gray(&|_, _| 255)));
    let all_in = |bin: usize| std::array::from_fn::<u8, BINS, _>(|i| if i == bin { 16 } else { 0 });
    for channel in 0..3 {
        assert_eq!(black.0[5 * channel], all_in(0));
        assert_eq!(white.0[5 * channel], all_in(9));
        (1..5).for_each(|k| assert_eq!(black.0[5 * channel + k], all_in(5)));
    }
    // Three histograms of 16 pixels in different bins: each is the root of 16^2 + 16^2 away.
    let want = 3.0 * 512.0_f64.sqrt() / (16.0 * 15.0);
    assert!((black.distance(&white, 4) - want).abs() < 1e-12);
    // A ramp to the right by a tenth of the range a pixel: 2 * 3 * 25.5 = 153 for the first filter, one bin up.
    let ramp = features(&gray(&|x, _| (f64::from(x) * 25.5) as u8));
    // 25.5 rounds down to 25, 51, 76, 102, ...: over two pixels always 51, three rows of it are 153.
    assert_eq!(ramp.0[1], all_in(6));
    assert_eq!(ramp.0[2], all_in(5));
    // The diagonal ones: 3 * 51 again, since only x counts. The upper right less the lower left, lower right less upper
    // left.
    assert_eq!([ramp.0[3], ramp.0[4]], [all_in(6), all_in(6)]);
    // Downwards: the second filter, and the diagonals in different senses.
    let down = features(&gray(&|_, y| (f64::from(y) * 25.5) as u8));
    assert_eq!([down.0[1], down.0[2], down.0[3], down.0[4]], [all_in(5), all_in(6), all_in(4), all_in(6)]);
    // Columns 2 to 5 of the ramp have the values 51, 76, 102 and 127 of 255: bins 2, 2, 4 and 4.
    assert_eq!(ramp.0[0], [0, 0, 8, 0, 8, 0, 0, 0, 0, 0]);
    // Against black: the colours are 4, 4 rows in two bins against 16 in one; of the edges three of four move.
    let want = 3.0 * ((2.0 * 64.0 + 256.0_f64).sqrt() + 3.0 * 512.0_f64.sqrt()) / 240.0;
    assert!((ramp.distance(&black, 4) - want).abs() < 1e-12);
    assert_eq!(ramp.distance(&ramp, 4), 0.0);
}

/// The metric as section 9.1 reads: the Euclidean distance of each pair of histograms, over s * s * 15.
fn plain_distance(a: &Features, b: &Features, block_px: u32) -> f64 {
    let mut sum = 0.0;
    for histogram in 0..15 {
        let mut squares = 0.0;
        for bin in 0..BINS {
            squares += (f64::from(a.0[histogram][bin]) - f64::from(b.0[histogram][bin])).powi(2);
        }
        sum += squares.sqrt();
    }
    sum / (f64::from(block_px) * f64::from(block_px) * 15.0)
}

/// All distances, sorted.
fn brute(source: &impasto::metric::Source, tested: &Features, k: usize) -> Vec<Neighbour> {
    let mut all: Vec<Neighbour> = source
        .pixels()
        .iter()
        .map(|&pixel| Neighbour { pixel, distance: plain_distance(tested, &source.features(pixel), source.block_px()) })
        .collect();
    // Stable: of equally near ones the first in reading order stays first.
    all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    all.truncate(k);
    all
}

#[test]
fn the_nearest_are_those_of_a_plain_search() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let source = strip("strip_green_yellow.png");
    let frame = part(&strip("strip_red_yellow.png"), (60, 30), (100, 60));
    let pixels: Vec<(u32, u32)> = (0..70).map(|i| (i * 37 % 100, i * 23 % 60)).collect();
    for (block_px, k) in [(4, 1), (8, 10), (12, 32)] {
        let search = BlockSearch::new(&gpu.context, k).expect("a search");
        let prepared = search.source(&mut runner, &source, block_px).expect("a source");
        assert_eq!(prepared.pixels().len() as u32, (512 - block_px + 1) * (128 - block_px + 1));
        let tested = search.features(&mut runner, &frame, block_px, &pixels).expect("features");
        let got = search.nearest(&mut runner, &prepared, &tested).expect("nearest");
        for (tested, got) in tested.iter().zip(got).step_by(7) {
            assert_eq!(got, brute(&prepared, tested, k as usize), "block {block_px}");
        }
    }
}

#[test]
fn a_picture_against_itself_is_at_distance_0_and_a_shuffled_one_is_not() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let source = part(&strip("strip_green_yellow.png"), (0, 0), (256, 64));
    let search = BlockSearch::new(&gpu.context, 1).expect("a search");
    let prepared = search.source(&mut runner, &source, 8).expect("a source");
    let pixels: Vec<(u32, u32)> = (0..64).map(|i| (4 + i * 3, 4 + i * 29 % 57)).collect();
    let mut nearest = |picture: &Picture| {
        let tested = search.features(&mut runner, picture, 8, &pixels).expect("features");
        search.nearest(&mut runner, &prepared, &tested).expect("nearest")
    };
    for (&pixel, found) in pixels.iter().zip(nearest(&source)) {
        assert_eq!(found[0].distance, 0.0);
        assert!(found[0].pixel == pixel || prepared.features(found[0].pixel) == prepared.features(pixel));
    }
    let mut shuffled = source.pixels().to_vec();
    let count = shuffled.len();
    (0..count).for_each(|i| shuffled.swap(i, (i * 7919 + 13) % count));
    let shuffled = Picture::new(256, 64, shuffled).expect("a picture");
    assert!(nearest(&shuffled).iter().all(|found| found[0].distance > 0.02));
}

/// A source of more than one chunk, of which the last blocks are the nearest; and flat paint, where all are equally
/// near.
#[test]
fn large_and_flat_sources_are_searched_whole() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mut pixels = vec![[10, 20, 30, 255]; 700 * 200];
    let noise = noise(700, 8, 3);
    pixels[192 * 700..].copy_from_slice(&noise);
    let large = Picture::new(700, 200, pixels).expect("a picture");
    let search = BlockSearch::new(&gpu.context, 3).expect("a search");
    let source = search.source(&mut runner, &large, 8).expect("a source");
    assert!(source.pixels().len() > 1 << 17);
    let tested = search.features(&mut runner, &large, 8, &[(600, 196), (50, 50)]).expect("features");
    let got = search.nearest(&mut runner, &source, &tested).expect("nearest");
    assert_eq!((got[0][0].pixel, got[0][0].distance), ((600, 196), 0.0));
    // The first blocks of nothing but the one colour.
    assert_eq!(got[1].iter().map(|n| n.pixel).collect::<Vec<_>>(), [(4, 4), (5, 4), (6, 4)]);
}

#[test]
fn pixels_that_may_be_measured_have_their_block_inside() {
    let mut pixels = vec![[1, 2, 3, 255]; 40 * 30];
    pixels[15 * 40 + 20][3] = 254;
    let picture = Picture::new(40, 30, pixels).expect("a picture");
    for block_px in BLOCK_PX {
        let eligible = Eligible::new(&picture, block_px);
        for (x, y) in (0..30).flat_map(|y| (0..40).map(move |x| (x, y))) {
            let (left, top) = block_corner((x, y), (40, 30), block_px);
            let reaches = |at: u32, from: u32| at + 1 >= from && at <= from + block_px;
            assert_eq!(eligible.contains(x, y), !(reaches(20, left) && reaches(15, top)), "{x}, {y}, {block_px}");
        }
        assert!(!eligible.contains(40, 3) && !eligible.contains(3, 30));
    }
}

#[test]
fn wrong_use_is_told() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let refused = |result: impasto::Result<()>| result.expect_err("refused").to_string();
    assert!(refused(BlockSearch::new(&gpu.context, 0).map(|_| ())).contains("k is 0"));
    assert!(refused(BlockSearch::new(&gpu.context, 33).map(|_| ())).contains("1 to 32"));
    let search = BlockSearch::new(&gpu.context, 10).expect("a search");
    let small = noise_picture(9, 8, 1);
    let mut source = |picture: &Picture, block_px| refused(search.source(&mut runner, picture, block_px).map(|_| ()));
    assert!(source(&small, 3).contains("block_px is 3"));
    assert!(source(&small, 13).contains("4 to 12"));
    assert!(source(&small, 10).contains("9 x 8"));
    // Two blocks are not ten.
    assert!(source(&small, 8).contains("blocks of the source is 2"));
    let nothing = Picture::new(20, 20, vec![[9, 9, 9, 0]; 400]).expect("a picture");
    assert!(source(&nothing, 8).contains("blocks of the source is 0"));
    assert!(refused(search.features(&mut runner, &small, 8, &[(9, 0)]).map(|_| ())).contains("9, 0"));
    assert!(Picture::new(0, 3, vec![]).is_err() && Picture::new(2, 2, vec![[0; 4]; 3]).is_err());
}
