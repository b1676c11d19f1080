//! The quilting stages against their oracle, byte for byte.

mod common;

use common::{data_dir, noise, Numbers, Validated};
use impasto::gpu::{Context, Image, ImageDesc, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::synthesis::calibrate::calibrate;
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Pruning, Quilt, QuiltGuide, QuiltStages, SampleTexels, SearchPath};
use impasto::synthesis::quilt_oracle::{block_hash, choice_index, quilt_oracle, OracleGuide, Quilted};
use std::sync::Arc;

/// What one quilting is made from.
#[derive(Clone)]
struct Case<'a> {
    sample: &'a [[u8; 4]],
    size: (u32, u32),
    output: (u32, u32),
    params: QuiltParams,
    guide: Option<Guide>,
}

/// A guide: shade and paint's number of each output pixel.
#[derive(Clone)]
struct Guide {
    pixels: Vec<(u8, u16)>,
    paint: u16,
    window_px: u32,
}

impl Guide {
    fn image(&self, context: &Context, uploads: &mut Uploads, size: (u32, u32)) -> QuiltGuide {
        let texels: Vec<u32> =
            self.pixels.iter().map(|&(shade, paint)| u32::from(shade) | u32::from(paint) << 16).collect();
        let desc = ImageDesc::storage_2d(size.0, size.1, ash::vk::Format::R32_UINT);
        let image = Image::new(context, "guide", &desc).expect("guide");
        uploads.image(context, &image, bytemuck::cast_slice(&texels)).expect("guide");
        QuiltGuide { image, paint: u32::from(self.paint), window_px: self.window_px, previous: None }
    }
}

impl Case<'_> {
    fn oracle(&self) -> Quilted {
        let (shade, covered): (Vec<u8>, Vec<bool>) = match &self.guide {
            Some(guide) => guide.pixels.iter().map(|&(shade, paint)| (shade, paint == guide.paint)).unzip(),
            None => Default::default(),
        };
        let guide = self.guide.as_ref().map(|guide| OracleGuide {
            shade: &shade,
            covered: &covered,
            window_px: guide.window_px,
        });
        quilt_oracle(self.sample, self.size, self.output, &self.params, guide.as_ref()).expect("oracle")
    }

    /// Quilts on the GPU, in submissions of at most about `comparisons`.
    fn gpu(&self, runner: &mut Runner, context: &Context, stages: &Arc<QuiltStages>, comparisons: u64) -> Quilted {
        let mut uploads = Uploads::default();
        let texels = SampleTexels::new(context, &mut uploads, self.sample, self.size).expect("sample");
        let guide = self.guide.as_ref().map(|guide| guide.image(context, &mut uploads, self.output));
        let quilt =
            Quilt::new(context, &mut uploads, stages, &texels, self.output, &self.params, guide).expect("quilt");
        for part in quilt.parts(comparisons) {
            runner
                .run(|recorder| {
                    uploads.record(recorder);
                    quilt.record_part(recorder, part, self.params.seed, 0);
                    Ok(())
                })
                .expect("run");
        }
        self.read(runner, &quilt)
    }

    fn read(&self, runner: &mut Runner, quilt: &Quilt) -> Quilted {
        let pixels: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(quilt.canvas()).expect("canvas"));
        let source: Vec<u32> = bytemuck::pod_collect_to_vec(&runner.read_image(quilt.source()).expect("source"));
        let blocks = quilt.read_records(runner).expect("records");
        let painted = source.iter().zip(&pixels);
        let source = painted.map(|(s, t)| (t[3] == 255).then_some(((s & 0xffff) as u16, (s >> 16) as u16))).collect();
        Quilted { width: self.output.0, height: self.output.1, pixels, source, blocks }
    }
}

/// The first difference of two quiltings, in words.
fn difference(gpu: &Quilted, oracle: &Quilted) -> Result<(), String> {
    if (gpu.width, gpu.height) != (oracle.width, oracle.height) {
        return Err("sizes differ".to_owned());
    }
    if let Some(i) = (0..gpu.blocks.len().max(oracle.blocks.len())).find(|&i| gpu.blocks.get(i) != oracle.blocks.get(i))
    {
        return Err(format!("block {i}: {:?}, but {:?} by the oracle", gpu.blocks.get(i), oracle.blocks.get(i)));
    }
    let width = gpu.width as usize;
    if gpu.pixels.len() != oracle.pixels.len() || gpu.source.len() != oracle.source.len() {
        return Err("numbers of pixels differ".to_owned());
    }
    if let Some(i) = (0..gpu.pixels.len()).find(|&i| gpu.pixels[i] != oracle.pixels[i]) {
        let (a, b) = (gpu.pixels[i], oracle.pixels[i]);
        return Err(format!("pixel {}, {}: {a:?}, but {b:?} by the oracle", i % width, i / width));
    }
    if let Some(i) = (0..gpu.source.len()).find(|&i| gpu.source[i] != oracle.source[i]) {
        let (a, b) = (gpu.source[i], oracle.source[i]);
        return Err(format!("source of {}, {}: {a:?}, but {b:?} by the oracle", i % width, i / width));
    }
    Ok(())
}

/// Runs cases on one validated context and compares each with the oracle.
struct Bench {
    runner: Runner,
    stages: Arc<QuiltStages>,
    /// Stages that must give the same, with the number of invocations that share a tile of positions.
    parted: Vec<(u32, Arc<QuiltStages>)>,
    gpu: Validated,
}

impl Bench {
    fn new() -> Self {
        let gpu = Validated::new();
        let stages = QuiltStages::new(&gpu.context);
        Bench { runner: gpu.runner(), stages, parted: Vec::new(), gpu }
    }

    /// Checks every case for each way to share a tile of positions, as all kinds of devices do it.
    fn of_every_part() -> Self {
        let mut bench = Bench::new();
        bench.parted = [1, 2, 4, 8].map(|parts| (parts, bench.parts(parts))).to_vec();
        bench
    }

    fn parts(&self, parts: u32) -> Arc<QuiltStages> {
        QuiltStages::with_search_parts(&self.gpu.context, parts)
    }

    fn run(&mut self, case: &Case<'_>, comparisons: u64) -> Quilted {
        case.gpu(&mut self.runner, &self.gpu.context, &self.stages, comparisons)
    }

    fn check(&mut self, case: &Case<'_>, what: &str) -> Quilted {
        let got = self.run(case, u64::MAX);
        if let Err(difference) = difference(&got, &case.oracle()) {
            panic!("{what}: {difference}");
        }
        for (parts, stages) in &self.parted {
            let parted = case.gpu(&mut self.runner, &self.gpu.context, stages, u64::MAX);
            assert_eq!(difference(&parted, &got), Ok(()), "{what}, {parts} parts");
        }
        got
    }
}

fn params(block_px: u32, overlap_px: u32, tolerance: f32, seed: u32, tileable: bool) -> QuiltParams {
    QuiltParams { block_px, overlap_px, tolerance, seed, tileable }
}

#[test]
fn free_quilting_equals_the_oracle() {
    let mut bench = Bench::of_every_part();
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
        let sample = noise(size.0, size.1, i as u32 + 7);
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
    let mut bench = Bench::of_every_part();
    let sample = noise(61, 45, 5);
    for (block_px, overlap_px) in [(16, 4), (32, 8), (15, 5), (20, 5), (18, 6), (30, 6), (7, 2), (23, 7), (64, 31)] {
        let size = (61.max(block_px), 45);
        let size = if block_px > 45 { (70, 66) } else { size };
        let own = noise(size.0, size.1, 5);
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
    let mut bench = Bench::of_every_part();
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

/// A path is a plain value that can be given by hand or found by trying; it decides which stages run, and no byte.
#[test]
fn given_and_calibrated_paths_give_the_same_bytes() {
    let mut bench = Bench::new();
    let sample = noise(64, 48, 12);
    let params = params(16, 5, 0.1, 4, false);
    let case = Case { sample: &sample, size: (64, 48), output: (90, 70), params, guide: None };
    let whole = bench.check(&case, "the device's path");
    let calibrated = calibrate(&mut bench.runner).expect("paths that agree");
    assert!(SearchPath::PARTS.contains(&calibrated.parts), "{calibrated:?}");
    let at_least = {
        let mut uploads = Uploads::default();
        let context = &bench.gpu.context;
        let texels = SampleTexels::new(context, &mut uploads, &sample, (64, 48)).expect("sample");
        let full = QuiltStages::with_pruning(context, Pruning::Off);
        Quilt::new(context, &mut uploads, &full, &texels, (90, 70), &params, None).expect("quilt").comparisons()
    };
    for (path, pruned) in [
        (calibrated, None),
        (SearchPath { parts: 8, prune_from: SearchPath::NEVER }, Some(false)),
        (SearchPath { parts: 2, prune_from: at_least + 1 }, Some(false)),
        (SearchPath { parts: 2, prune_from: at_least }, Some(true)),
        (SearchPath { parts: 4, prune_from: 0 }, Some(true)),
    ] {
        let stages = QuiltStages::with_path(&bench.gpu.context, path).expect("a path");
        assert_eq!(stages.path(), path);
        bench.runner.take_times();
        let got = case.gpu(&mut bench.runner, &bench.gpu.context, &stages, u64::MAX);
        assert_eq!(difference(&got, &whole), Ok(()), "{path:?}");
        let ran = |name: &str, times: &[impasto::gpu::PassTime]| times.iter().any(|time| time.name == name);
        let times = bench.runner.take_times();
        if let Some(pruned) = pruned {
            assert_eq!((ran("quilt_compare", &times), ran("quilt_search", &times)), (pruned, !pruned), "{path:?}");
        }
    }
    for parts in [0, 3, 16] {
        let refused = QuiltStages::with_path(&bench.gpu.context, SearchPath { parts, prune_from: 0 });
        let message = refused.err().expect("no such path").to_string();
        assert!(message.contains(&format!("parts of a search is {parts}, but must be 1, 2, 4 or 8")), "{message}");
    }
}

/// A guide with shades that run, spots of another paint, and holes; `covered` of 256 texels are painted.
fn random_guide(output: (u32, u32), seed: u32, covered: u32, window_px: u32) -> Guide {
    let mut numbers = Numbers(seed | 1);
    // Patches, so that some blocks lie wholly in a hole.
    let patches: Vec<u32> = (0..(output.0 / 11 + 1) * (output.1 / 11 + 1)).map(|_| numbers.next()).collect();
    let texel = |i: u32| {
        let (x, y) = (i % output.0, i / output.0);
        let patch = patches[(y / 11 * (output.0 / 11 + 1) + x / 11) as usize];
        let shade = (x * 255 / output.0.max(2)).wrapping_add(numbers.next() % 40).min(255) as u8;
        let paint = if patch % 256 < covered { 3 } else { (patch / 256 % 5) as u16 };
        (shade, if numbers.next().is_multiple_of(16) { 0 } else { paint })
    };
    Guide { pixels: (0..output.0 * output.1).map(texel).collect(), paint: 3, window_px }
}

#[test]
fn guided_quilting_equals_the_oracle() {
    let mut bench = Bench::of_every_part();
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
        let blocks = impasto::synthesis::params::Layout::new(&params, output).expect("layout").placements.len();
        placed += got.blocks.len();
        skipped += blocks - got.blocks.len();
    }
    assert!(placed > 100 && skipped > 100, "{placed} blocks were placed and {skipped} skipped");
}

#[test]
fn extreme_guides_equal_the_oracle() {
    let mut bench = Bench::of_every_part();
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
    let mut bench = Bench::of_every_part();
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

/// A comparison that cannot fail would prove nothing.
#[test]
fn the_comparison_notices_every_kind_of_difference() {
    let sample = noise(30, 30, 1);
    let params = params(8, 2, 0.1, 1, false);
    let case = Case { sample: &sample, size: (30, 30), output: (20, 20), params, guide: None };
    let right = case.oracle();
    assert_eq!(difference(&right, &right), Ok(()));
    let notices = |change: &dyn Fn(&mut Quilted), word: &str| {
        let mut wrong = right.clone();
        change(&mut wrong);
        let found = difference(&wrong, &right).expect_err(word);
        assert!(found.contains(word), "{found}");
    };
    notices(&|q| q.pixels[399][2] ^= 1, "pixel 19, 19");
    notices(&|q| q.pixels[7][3] = 0, "pixel 7, 0");
    notices(&|q| q.source[41] = Some((0, 0)), "source of 1, 2");
    notices(&|q| q.blocks[3].error += 1, "block 3");
    notices(&|q| q.blocks[4].allowed[2] -= 1, "block 4");
    notices(&|q| q.blocks.truncate(2), "block 2");
    notices(&|q| q.pixels.truncate(399), "numbers");
    notices(&|q| q.width = 10, "sizes");
}

/// Run by the next test in processes of their own; prints a fingerprint of what it quilted.
#[test]
fn child_quilts() {
    if !common::is_child() {
        return;
    }
    let mut bench = Bench::new();
    let sample = noise(64, 48, 2);
    let guide = random_guide((120, 90), 4, 128, 20);
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for guide in [None, Some(guide)] {
        let params = params(16, 5, 0.2, 8, false);
        let case = Case { sample: &sample, size: (64, 48), output: (120, 90), params, guide };
        for byte in bench.run(&case, u64::MAX).pixels.as_flattened() {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    println!("quilted {hash:016x}");
}

/// Lavapipe runs workgroups on as many threads as it is told.
#[test]
fn the_number_of_threads_makes_no_difference() {
    let quilted = |threads| {
        let output = common::run_child("child_quilts", &[("LP_NUM_THREADS", threads)]);
        output.lines().find_map(|line| line.split_once("quilted ").map(|(_, hash)| hash.to_owned()))
    };
    let one = quilted("1");
    assert!(one.is_some(), "the child did not quilt");
    assert_eq!(one, quilted("2"));
    assert_eq!(one, quilted("7"));
}
