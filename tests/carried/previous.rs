//! Blocks that match the previous frame (thesis chapter 6), against the quilting's oracle.

use crate::common::{noise, Validated};
use crate::quilt;
use impasto::gpu::{Image, ImageDesc, Runner, Uploads};
use impasto::synthesis::params::{BlockRecord, QuiltParams};
use impasto::synthesis::quilt::{PreviousWeight, Quilt, QuiltGuide, QuiltStages, SampleTexels};
use impasto::synthesis::quilt_oracle::{quilt_oracle_after, OracleGuide, OraclePrevious, Quilted};
use impasto::Result;

/// A guided quilting whose guide may change from frame to frame.
struct Frames {
    gpu: Validated,
    runner: Runner,
    texels: Vec<[u8; 4]>,
    sample_size: (u32, u32),
    output: (u32, u32),
    params: QuiltParams,
    window_px: u32,
    guide: Image,
    quilt: Quilt,
}

/// One frame: the canvas, and what was chosen.
#[derive(PartialEq)]
struct Frame {
    pixels: Vec<[u8; 4]>,
    blocks: Vec<BlockRecord>,
}

impl From<Quilted> for Frame {
    fn from(quilted: Quilted) -> Self {
        Frame { pixels: quilted.pixels, blocks: quilted.blocks }
    }
}

fn prepare(
    gpu: &Validated,
    texels: &[[u8; 4]],
    sample_size: (u32, u32),
    output: (u32, u32),
    params: &QuiltParams,
    window_px: u32,
    weight: f32,
) -> Result<(Quilt, Image, Uploads)> {
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context);
    let sample = SampleTexels::new(&gpu.context, &mut uploads, texels, sample_size)?;
    let desc = ImageDesc::storage_2d(output.0, output.1, ash::vk::Format::R32_UINT);
    let image = Image::new(&gpu.context, "guide", &desc)?;
    let previous = Some(PreviousWeight(weight));
    let guide = QuiltGuide { image: image.clone(), paint: 1, window_px, previous };
    let quilt = Quilt::new(&gpu.context, &mut uploads, &stages, &sample, output, params, Some(guide))?;
    Ok((quilt, image, uploads))
}

impl Frames {
    fn new(sample_size: (u32, u32), output: (u32, u32), params: QuiltParams, window_px: u32, weight: f32) -> Self {
        let gpu = Validated::new();
        let mut runner = gpu.runner();
        let texels = noise(sample_size.0, sample_size.1, 21);
        let (quilt, guide, mut uploads) =
            prepare(&gpu, &texels, sample_size, output, &params, window_px, weight).expect("a quilting");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                quilt.forget(recorder);
                Ok(())
            })
            .expect("run");
        Frames { gpu, runner, texels, sample_size, output, params, window_px, guide, quilt }
    }

    /// Shades and coverage: a disc that grows brighter to the right, shifted by `by`.
    fn disc(&self, by: f32) -> (Vec<u8>, Vec<bool>) {
        let (width, height) = (self.output.0 as f32, self.output.1 as f32);
        let pixels = (0..self.output.1).flat_map(|y| (0..self.output.0).map(move |x| (x as f32, y as f32)));
        let at = |(x, y): (f32, f32)| {
            let (dx, dy) = (2.0 * (x - by) / width - 1.0, 2.0 * y / height - 1.0);
            (((dx + 1.0) * 100.0).clamp(0.0, 255.0) as u8, dx * dx + dy * dy < 1.1)
        };
        pixels.map(at).unzip()
    }

    fn paint(&mut self, (shade, covered): &(Vec<u8>, Vec<bool>), frame: u32, forget: bool) -> Frame {
        let words: Vec<u32> = shade.iter().zip(covered).map(|(s, &c)| u32::from(*s) | u32::from(c) << 16).collect();
        let mut uploads = Uploads::default();
        uploads.image(&self.gpu.context, &self.guide, bytemuck::cast_slice(&words)).expect("guide");
        let (quilt, seed) = (&self.quilt, self.params.seed);
        // In parts, since only the first one may take the previous picture.
        for part in quilt.parts(2_000_000) {
            self.runner
                .run(|recorder| {
                    uploads.record(recorder);
                    if forget && part.start == 0 {
                        quilt.forget(recorder);
                    }
                    quilt.record_part(recorder, part.clone(), seed, frame);
                    Ok(())
                })
                .expect("run");
        }
        let pixels = bytemuck::pod_collect_to_vec(&self.runner.read_image(self.quilt.canvas()).expect("canvas"));
        Frame { pixels, blocks: self.quilt.read_records(&mut self.runner).expect("records") }
    }

    /// The same frame by the oracle; `weight` is in quarters.
    fn oracle(&self, (shade, covered): &(Vec<u8>, Vec<bool>), frame: u32, before: &[[u8; 4]], weight: u32) -> Frame {
        let guide = OracleGuide { shade, covered, window_px: self.window_px };
        let previous = OraclePrevious { pixels: before, weight };
        quilt_oracle_after(&self.texels, self.sample_size, self.output, &self.params, &guide, frame, &previous)
            .expect("oracle")
            .into()
    }
}

/// The first difference of two frames, in words.
fn difference(got: &Frame, want: &Frame) -> std::result::Result<(), String> {
    if got.blocks.len() != want.blocks.len() {
        return Err(format!("{} blocks, but {} by the oracle", got.blocks.len(), want.blocks.len()));
    }
    if let Some((a, b)) = got.blocks.iter().zip(&want.blocks).find(|(a, b)| a != b) {
        return Err(format!("{a:?}, but {b:?} by the oracle"));
    }
    let off = (0..got.pixels.len()).find(|&i| got.pixels[i] != want.pixels[i]);
    off.map_or(Ok(()), |i| Err(format!("pixel {i}: {:?}, but {:?} by the oracle", got.pixels[i], want.pixels[i])))
}

#[test]
fn blocks_that_match_the_previous_frame_equal_the_oracle() {
    for (sample_size, output, params, window_px, weight) in [
        ((120, 40), (75, 61), quilt(16, 4), 20, 0.25),
        ((90, 50), (60, 70), QuiltParams { tolerance: 0.0, ..quilt(9, 3) }, 500, 1.5),
        ((100, 64), (90, 80), quilt(37, 12), 9, 3.0),
        ((128, 70), (100, 90), quilt(64, 32), 30, 0.25),
    ] {
        let mut frames = Frames::new(sample_size, output, params, window_px, weight);
        let units = (4.0 * weight) as u32;
        let mut before = vec![[0; 4]; (output.0 * output.1) as usize];
        for number in 0..4 {
            let guide = frames.disc(7.0 * number as f32);
            let got = frames.paint(&guide, number, false);
            let want = frames.oracle(&guide, number, &before, units);
            assert_eq!(difference(&got, &want), Ok(()), "{params:?}, frame {number}");
            let nothing = vec![[0; 4]; before.len()];
            let others = if number == 0 {
                vec![frames.oracle(&guide, number + 1, &before, units)]
            } else {
                vec![frames.oracle(&guide, number, &before, units + 1), frames.oracle(&guide, number, &nothing, units)]
            };
            assert!(others.iter().all(|other| difference(&got, other).is_err()), "planted faults are noticed");
            before = got.pixels;
        }
    }
}

/// Each block finds where it was again, since its own pixels fit there and nowhere else.
#[test]
fn a_large_weight_repeats_what_does_not_change() {
    for output in [(16, 16), (70, 60)] {
        let mut frames = Frames::new((100, 50), output, quilt(16, 4), 30, 3.0);
        let guide = frames.disc(0.0);
        let first = frames.paint(&guide, 0, false);
        let second = frames.paint(&guide, 1, false);
        let positions = |frame: &Frame| frame.blocks.iter().map(|block| (block.sx, block.sy)).collect::<Vec<_>>();
        assert_eq!(positions(&first), positions(&second));
        assert!(first.pixels == second.pixels);
        if output == (16, 16) {
            assert_eq!((second.blocks.len(), second.blocks[0].error), (1, 0));
        }
        // Without the picture before, the frame's number alone makes another one.
        let forgotten = frames.paint(&guide, 1, true);
        assert_ne!(positions(&first), positions(&forgotten));
    }
}

#[test]
fn what_is_forgotten_makes_no_difference() {
    let new = || Frames::new((100, 50), (70, 60), quilt(16, 4), 30, 2.0);
    let mut frames = new();
    let guides = [frames.disc(0.0), frames.disc(9.0)];
    frames.paint(&guides[0], 0, false);
    frames.paint(&guides[1], 1, false);
    let kept = frames.paint(&guides[0], 2, false);
    let forgotten = frames.paint(&guides[0], 2, true);
    let alone = new().paint(&guides[0], 2, false);
    assert_eq!(difference(&forgotten, &alone), Ok(()));
    assert!(difference(&kept, &alone).is_err());
}

#[test]
fn weights_that_cannot_be_counted_with_are_refused() {
    let gpu = Validated::new();
    let texels = noise(80, 70, 2);
    let make = |block_px, weight| {
        prepare(&gpu, &texels, (80, 70), (50, 40), &quilt(block_px, 4), 10, weight)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    for (block_px, weight) in [(16, 0.25), (16, 3.0), (37, 3.0), (64, 0.25)] {
        assert_eq!(make(block_px, weight), Ok(()), "{block_px} {weight}");
    }
    for (block_px, weight) in
        [(16, 0.0), (16, 0.1), (16, 3.25), (16, -1.0), (16, f32::NAN), (16, f32::INFINITY), (38, 3.0), (64, 0.5)]
    {
        let message = make(block_px, weight).expect_err("must be refused");
        assert!(message.contains("weight of the previous frame is"), "{message}");
        assert!(message.contains(&format!("in steps of 0.25 for blocks of {block_px} px")), "{message}");
    }
}
