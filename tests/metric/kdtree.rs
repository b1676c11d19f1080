//! The k-d tree: exact by its own distance, and how far that is from the metric.

use super::*;
use impasto::gpu::Runner;
use impasto::metric::{choose, similarity, BlockSearch, Eligible, Features, KdTree, Neighbour, Score, Source};

/// The Euclidean distance over the 150 counts, squared.
fn squared(a: &Features, b: &Features) -> u32 {
    a.0.as_flattened().iter().zip(b.0.as_flattened()).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum()
}

/// All blocks compared, one after the other.
fn brute(source: &Source, blocks: &[Features], tested: &Features, k: usize) -> Vec<Neighbour> {
    let mut all: Vec<(u32, usize)> = blocks.iter().map(|block| squared(block, tested)).zip(0..).collect();
    all.sort();
    all.truncate(k);
    let neighbour = |&(_, i): &(u32, usize)| {
        let distance = tested.distance(&blocks[i], source.block_px());
        (i, Neighbour { pixel: source.pixels()[i], distance })
    };
    let mut nearest: Vec<(usize, Neighbour)> = all.iter().map(neighbour).collect();
    nearest.sort_by(|a, b| a.1.distance.total_cmp(&b.1.distance).then(a.0.cmp(&b.0)));
    nearest.into_iter().map(|(_, neighbour)| neighbour).collect()
}

struct Gpu {
    runner: Runner,
    search: BlockSearch,
    /// Last, since it is dropped after the others, and then looks at all messages.
    _validated: Validated,
}

/// A source, its features, and those of some of another picture's blocks.
struct Case {
    source: Source,
    blocks: Vec<Features>,
    tested: Vec<Features>,
}

impl Gpu {
    fn new(k: u32) -> Self {
        let validated = Validated::new();
        let (runner, search) = (validated.runner(), BlockSearch::new(&validated.context, k).expect("a search"));
        Gpu { runner, search, _validated: validated }
    }

    fn case(&mut self, source: &Picture, frame: &Picture, block_px: u32, count: usize) -> Case {
        let source = self.search.source(&mut self.runner, source, block_px).expect("a source");
        let pixels = choose(Eligible::new(frame, block_px).all(|_, _| true), count, 5);
        let tested = self.search.features(&mut self.runner, frame, block_px, &pixels).expect("features");
        let blocks = source.pixels().iter().map(|&pixel| source.features(pixel)).collect();
        Case { source, blocks, tested }
    }
}

/// Compares the tree with comparing all; returns how many different blocks there are.
fn check(case: &Case, k: u32) -> usize {
    let tree = KdTree::new(&case.source).expect("a tree");
    let got = tree.nearest(&case.tested, k).expect("nearest");
    assert_eq!(got.len(), case.tested.len());
    for (got, tested) in got.iter().zip(&case.tested) {
        assert_eq!(*got, brute(&case.source, &case.blocks, tested, k as usize));
    }
    tree.kinds()
}

/// Pixels of two colours, by a function of the place.
fn two_colors(width: u32, height: u32, second: impl Fn(u32, u32) -> bool) -> Picture {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let color = |(x, y)| if second(x, y) { [200, 30, 90, 255] } else { [20, 120, 60, 255] };
    Picture::new(width, height, pixels.map(color).collect()).expect("a picture")
}

#[test]
fn the_nearest_are_those_of_comparing_all_150_counts() {
    let mut gpu = Gpu::new(1);
    let frame = strip("strip_red_yellow.png");
    for (name, block_px, k) in [("strip_green_yellow.png", 8, 10), ("strip_red_yellow.png", 12, 32)] {
        let case = gpu.case(&strip(name), &frame, block_px, 12);
        assert!(check(&case, k) > 40_000, "there are blocks to tell apart");
    }
    // Few different blocks of 4x4 pixels, and distances of small integers: many are equally near.
    let small = part(&strip("strip_dark_red.png"), (60, 10), (90, 50));
    let case = gpu.case(&small, &small, 4, 200);
    check(&case, 1);
    check(&case, 7);
    check(&case, 32);
}

#[test]
fn flat_paint_and_paint_of_two_colours_are_searched_like_any_other() {
    let mut gpu = Gpu::new(1);
    let strip = part(&strip("strip_red_yellow.png"), (0, 0), (80, 60));
    let flat = two_colors(200, 100, |_, _| false);
    for frame in [&flat, &strip] {
        let case = gpu.case(&flat, frame, 8, 20);
        assert_eq!(check(&case, 10), 1);
        let nearest = KdTree::new(&case.source).expect("a tree").nearest(&case.tested, 3).expect("nearest");
        let pixels: Vec<_> = nearest[7].iter().map(|near| near.pixel).collect();
        assert_eq!(pixels, [(4, 4), (5, 4), (6, 4)], "the first in reading order");
    }
    let halves = two_colors(200, 100, |x, _| x >= 100);
    let values = super::noise(200, 100, 3);
    let spots = two_colors(200, 100, |x, y| values[(y * 200 + x) as usize][0] > 250);
    let chess = two_colors(120, 80, |x, y| (x / 3 + y / 3) % 2 == 1);
    let noise = noise_picture(120, 60, 9);
    // Nearly all of it flat, the blocks at its end all different.
    let mut pixels = flat.pixels().to_vec();
    pixels[90 * 200..].copy_from_slice(&super::noise(200, 10, 3));
    let mixed = Picture::new(200, 100, pixels).expect("a picture");
    for source in [&halves, &spots, &chess, &noise, &mixed] {
        for frame in [&spots, &strip] {
            for (block_px, k) in [(4, 3), (8, 32)] {
                check(&gpu.case(source, frame, block_px, 10), k);
            }
        }
    }
}

#[test]
fn its_blocks_are_never_nearer_by_the_metric_than_those_of_the_exact_search() {
    let mut gpu = Gpu::new(10);
    let case = gpu.case(&strip("strip_green_yellow.png"), &strip("strip_red_yellow.png"), 8, 60);
    let exact = gpu.search.nearest(&mut gpu.runner, &case.source, &case.tested).expect("nearest");
    let tree = KdTree::new(&case.source).expect("a tree").nearest(&case.tested, 10).expect("nearest");
    let (exact, tree) = (similarity(&exact), similarity(&tree));
    for (exact, tree) in exact.iter().zip(&tree) {
        assert!(*tree >= exact - 1e-12, "{tree} is below {exact}");
    }
    let mean = |values: &[f64]| Score::of(values).expect("values").mean;
    println!(
        "mean distance {:.5} exact, {:.5} by the tree: {:.4}",
        mean(&exact),
        mean(&tree),
        mean(&tree) / mean(&exact)
    );
}

#[test]
fn wrong_use_is_told() {
    let mut gpu = Gpu::new(5);
    let refused = |result: impasto::Result<()>| result.expect_err("refused").to_string();
    // 5 blocks.
    let few = gpu.case(&noise_picture(12, 8, 1), &noise_picture(12, 8, 2), 8, 2);
    let tree = KdTree::new(&few.source).expect("a tree");
    assert!(refused(tree.nearest(&few.tested, 0).map(|_| ())).contains("k is 0, but must be 1 to 5"));
    assert!(refused(tree.nearest(&few.tested, 6).map(|_| ())).contains("1 to 5"));
    assert_eq!(tree.nearest(&few.tested, 5).expect("all").iter().map(Vec::len).collect::<Vec<_>>(), [5, 5]);
    assert!(tree.nearest(&[], 5).expect("nothing").is_empty());
    let more = gpu.case(&noise_picture(40, 40, 1), &noise_picture(12, 8, 2), 8, 2);
    let tree = KdTree::new(&more.source).expect("a tree");
    assert!(refused(tree.nearest(&more.tested, 33).map(|_| ())).contains("1 to 32"));
    // Some more than 2^20 blocks of noise, all different.
    let large = gpu.search.source(&mut gpu.runner, &noise_picture(1030, 1030, 4), 4).expect("a source");
    assert!(refused(KdTree::new(&large).map(|_| ())).contains("at most 1048576"));
}
