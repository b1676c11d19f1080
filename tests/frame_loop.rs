//! The host with frames in flight: the same bytes as one that waits for each, and nothing freed that is in use.

mod common;

use common::{noise, Validated};
use impasto::gpu::{Buffer, BufferKind, FrameLoop, Recorder, Uploads};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{PreviousWeight, Quilt, QuiltGuide, QuiltStages, SampleTexels};
use impasto::Error;

const SAMPLE: (u32, u32) = (40, 40);
const OUTPUT: (u32, u32) = (60, 60);
const PARAMS: QuiltParams = QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.3, seed: 3, tileable: false };
const FRAMES: u32 = 9;

/// A quilting each frame of which matches the one before, so that the last depends on all and on their order.
fn sequence(gpu: &Validated) -> Quilt {
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context);
    let texels = SampleTexels::new(&gpu.context, &mut uploads, &noise(SAMPLE.0, SAMPLE.1, 31), SAMPLE).expect("sample");
    let guide: Vec<u32> = (0..OUTPUT.0 * OUTPUT.1).map(|i| (1 << 16) | (i % 256)).collect();
    let guide = QuiltGuide::from_texels(&gpu.context, &mut uploads, &guide, OUTPUT, 20).expect("guide");
    let guide = QuiltGuide { previous: Some(PreviousWeight(0.5)), ..guide };
    let quilt = Quilt::new(&gpu.context, &mut uploads, &stages, &texels, OUTPUT, &PARAMS, Some(guide)).expect("quilt");
    let run = gpu.runner().run(|recorder| {
        uploads.record(recorder);
        quilt.forget(recorder);
        Ok(())
    });
    run.expect("run");
    quilt
}

fn record(quilt: &Quilt, recorder: &mut Recorder<'_>, frame: u32) -> impasto::Result<()> {
    quilt.record(recorder, PARAMS.seed, frame);
    Ok(())
}

#[test]
fn frames_in_flight_give_the_bytes_of_frames_one_by_one() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let quilt = sequence(&gpu);
    let mut all = Vec::new();
    for frame in 0..FRAMES {
        runner.run(|recorder| record(&quilt, recorder, frame)).expect("run");
        all.push(runner.read_image(quilt.canvas()).expect("canvas"));
    }
    assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "frames must differ");
    for in_flight in [1, 2, 3, 20] {
        let quilt = sequence(&gpu);
        let mut frames = FrameLoop::new(&gpu.context, in_flight).expect("a loop");
        for frame in 0..FRAMES {
            frames.run(|recorder| record(&quilt, recorder, frame)).expect("run");
        }
        frames.finish().expect("finish");
        let last = runner.read_image(quilt.canvas()).expect("canvas");
        assert!(Some(&last) == all.last(), "{in_flight} in flight");
    }
}

#[test]
fn what_is_dropped_goes_when_its_frame_has_run() {
    let gpu = Validated::new();
    let quilt = sequence(&gpu);
    gpu.runner().run(|_| Ok(())).expect("run");
    let mut frames = FrameLoop::new(&gpu.context, 2).expect("a loop");
    let mut next = 0..;
    let mut run = |frames: &mut FrameLoop| {
        frames.run(|recorder| record(&quilt, recorder, next.next().unwrap_or_default())).expect("run");
    };
    run(&mut frames);
    let without = gpu.context.allocated_bytes();
    let buffer = Buffer::new(&gpu.context, "buffer", BufferKind::Storage, 5000).expect("a buffer");
    let with = gpu.context.allocated_bytes();
    assert!(with > without);
    // It belongs to the frame that is recorded next, and with two in flight that has run when the fourth is recorded.
    drop(buffer);
    for _ in 0..2 {
        run(&mut frames);
        assert_eq!(gpu.context.allocated_bytes(), with);
    }
    run(&mut frames);
    assert_eq!(gpu.context.allocated_bytes(), without);

    let buffer = Buffer::new(&gpu.context, "buffer", BufferKind::Storage, 5000).expect("a buffer");
    drop(buffer);
    run(&mut frames);
    assert_eq!(gpu.context.allocated_bytes(), with);
    frames.finish().expect("finish");
    assert_eq!(gpu.context.allocated_bytes(), without);
    frames.finish().expect("nothing is left to wait for");
}

#[test]
fn dropping_waits_for_what_is_in_flight() {
    let gpu = Validated::new();
    let quilt = sequence(&gpu);
    let mut frames = FrameLoop::new(&gpu.context, 3).expect("a loop");
    for frame in 0..3 {
        frames.run(|recorder| record(&quilt, recorder, frame)).expect("run");
    }
    // Validation would tell of a pool or a fence that is in use, and of the quilt's images.
    drop(frames);
    drop(quilt);
    gpu.context.advance(1000, 999);
}

#[test]
fn a_recording_that_fails_is_told_and_the_next_one_runs() {
    let gpu = Validated::new();
    let quilt = sequence(&gpu);
    let mut frames = FrameLoop::new(&gpu.context, 2).expect("a loop");
    let failed: impasto::Result<()> = frames.run(|recorder| {
        record(&quilt, recorder, 0)?;
        Err(Error::Device("as planned".to_owned()))
    });
    assert!(failed.is_err_and(|error| error.to_string().contains("as planned")));
    frames.run(|recorder| record(&quilt, recorder, 1)).expect("run");
    frames.finish().expect("finish");
    let last = gpu.runner().read_image(quilt.canvas()).expect("canvas");

    let again = sequence(&gpu);
    let mut runner = gpu.runner();
    for frame in 0..2 {
        runner.run(|recorder| record(&again, recorder, frame)).expect("run");
    }
    assert!(runner.read_image(again.canvas()).expect("canvas") == last, "what was recorded before was run");
}

#[test]
fn numbers_of_frames_out_of_range_are_refused() {
    let gpu = Validated::new();
    for number in [0, 257] {
        let refused = FrameLoop::new(&gpu.context, number).map(|_| ());
        assert!(matches!(refused, Err(Error::Parameter { .. })), "{number}");
    }
}
