//! The quilting stages against their oracle, byte for byte.

mod common;

use common::{data_dir, noise, Numbers, Validated};
use impasto::gpu::{Context, Image, ImageDesc, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Quilt, QuiltGuide, QuiltStages, SampleTexels};
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
        QuiltGuide { image, paint: u32::from(self.paint), window_px: self.window_px }
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
    gpu: Validated,
}

impl Bench {
    fn new() -> Self {
        let gpu = Validated::new();
        let stages = QuiltStages::new(&gpu.context).expect("stages");
        Bench { runner: gpu.runner(), stages, gpu }
    }

    fn run(&mut self, case: &Case<'_>, comparisons: u64) -> Quilted {
        case.gpu(&mut self.runner, &self.gpu.context, &self.stages, comparisons)
    }

    fn check(&mut self, case: &Case<'_>, what: &str) -> Quilted {
        let got = self.run(case, u64::MAX);
        if let Err(difference) = difference(&got, &case.oracle()) {
            panic!("{what}: {difference}");
        }
        got
    }
}

fn params(block_px: u32, overlap_px: u32, tolerance: f32, seed: u32, tileable: bool) -> QuiltParams {
    QuiltParams { block_px, overlap_px, tolerance, seed, tileable }
}

#[test]
fn free_quilting_equals_the_oracle() {
    let mut bench = Bench::new();
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

/// The search is compiled for runs of 4, 5 and 6 texels; these are the overlaps and blocks that choose each.
#[test]
fn every_chunk_of_the_search_equals_the_oracle() {
    let mut bench = Bench::new();
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
    let mut bench = Bench::new();
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
    for seed in 0..6 {
        let case = Case {
            sample: &sample,
            size: (side, side),
            output: (8, 8),
            params: params(8, 2, 0.1, seed, false),
            guide: None,
        };
        let got = bench.run(&case, u64::MAX);
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
