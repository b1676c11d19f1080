//! The quilting stages against their oracle, byte for byte.

mod cases;
#[path = "../common/mod.rs"]
mod common;
mod paths;
mod pruned;

use common::{noise, Numbers, Validated};
use impasto::gpu::{Context, Image, ImageDesc, Runner, Uploads};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Pruning, Quilt, QuiltGuide, QuiltStages, SampleTexels};
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide, Quilted};
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

    /// Prepares it on the GPU.
    fn quilt(&self, context: &Context, uploads: &mut Uploads, stages: &Arc<QuiltStages>) -> Quilt {
        let texels = SampleTexels::new(context, uploads, self.sample, self.size).expect("sample");
        let guide = self.guide.as_ref().map(|guide| guide.image(context, uploads, self.output));
        Quilt::new(context, uploads, stages, &texels, self.output, &self.params, guide).expect("quilt")
    }

    /// Quilts on the GPU, in submissions of at most about `comparisons`.
    fn gpu(&self, runner: &mut Runner, context: &Context, stages: &Arc<QuiltStages>, comparisons: u64) -> Quilted {
        let mut uploads = Uploads::default();
        let quilt = self.quilt(context, &mut uploads, stages);
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
    /// Stages that must give the same, with what they are.
    others: Vec<(&'static str, Arc<QuiltStages>)>,
    gpu: Validated,
}

impl Bench {
    fn new() -> Self {
        let gpu = Validated::new();
        let stages = QuiltStages::new(&gpu.context);
        Bench { runner: gpu.runner(), stages, others: Vec::new(), gpu }
    }

    /// Checks every case for a pruned search too, and for each way to share a tile of positions, as all kinds of
    /// devices do it.
    fn of_every_search() -> Self {
        let mut bench = Bench::of_a_pruned_search();
        let parted = [("1 part", 1), ("2 parts", 2), ("4 parts", 4), ("8 parts", 8)];
        bench.others.extend(parted.map(|(what, parts)| (what, bench.parts(parts))));
        bench
    }

    /// Checks every case for a pruned search too.
    fn of_a_pruned_search() -> Self {
        let mut bench = Bench::new();
        bench.others = vec![("pruned", QuiltStages::with_pruning(&bench.gpu.context, Pruning::On))];
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
        for (search, stages) in &self.others {
            let other = case.gpu(&mut self.runner, &self.gpu.context, stages, u64::MAX);
            assert_eq!(difference(&other, &got), Ok(()), "{what}, {search}");
        }
        got
    }
}

fn params(block_px: u32, overlap_px: u32, tolerance: f32, seed: u32, tileable: bool) -> QuiltParams {
    QuiltParams { block_px, overlap_px, tolerance, seed, tileable }
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
