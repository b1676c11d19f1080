//! The quilting stages against their oracle, byte for byte.

mod common;

use common::{noise, Validated};
use impasto::gpu::Uploads;
use impasto::synthesis::params::{BlockRecord, QuiltParams};
use impasto::synthesis::quilt::{Quilt, QuiltStages, SampleTexels};
use impasto::synthesis::quilt_oracle::{quilt_oracle, Quilted};

/// Quilts on the GPU; pixels, sources and records as the oracle gives them.
fn quilt_gpu(
    gpu: &Validated,
    sample: &[[u8; 4]],
    size: (u32, u32),
    output: (u32, u32),
    params: &QuiltParams,
) -> Quilted {
    let mut runner = gpu.runner();
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context).expect("stages");
    let texels = SampleTexels::new(&gpu.context, &mut uploads, sample, size).expect("sample");
    let quilt = Quilt::new(&gpu.context, &mut uploads, &stages, &texels, output, params, None).expect("quilt");
    runner
        .run(|recorder| {
            uploads.record(recorder);
            quilt.record(recorder, params.seed, 0);
            Ok(())
        })
        .expect("run");
    read(&mut runner, &quilt, output)
}

fn read(runner: &mut impasto::gpu::Runner, quilt: &Quilt, output: (u32, u32)) -> Quilted {
    let canvas: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(quilt.canvas()).expect("canvas"));
    let source: Vec<u32> = bytemuck::pod_collect_to_vec(&runner.read_image(quilt.source()).expect("source"));
    let blocks: Vec<BlockRecord> = quilt.read_records(runner).expect("records");
    let source = source
        .iter()
        .zip(&canvas)
        .map(|(s, texel)| (texel[3] == 255).then_some(((s & 0xffff) as u16, (s >> 16) as u16)))
        .collect();
    Quilted { width: output.0, height: output.1, pixels: canvas, source, blocks }
}

fn assert_same(gpu: &Quilted, oracle: &Quilted, what: &str) {
    assert_eq!(gpu.blocks.len(), oracle.blocks.len(), "{what}: blocks");
    for (i, (a, b)) in gpu.blocks.iter().zip(&oracle.blocks).enumerate() {
        assert_eq!(a, b, "{what}: block {i}");
    }
    assert!(gpu.pixels == oracle.pixels, "{what}: pixels differ");
    assert!(gpu.source == oracle.source, "{what}: sources differ");
}

#[test]
fn free_quilting_equals_the_oracle() {
    let gpu = Validated::new();
    for (i, (size, output, block_px, overlap_px, tolerance, tileable)) in [
        ((48, 40), (96, 80), 16, 4, 0.1, false),
        ((33, 57), (101, 67), 12, 3, 0.0, false),
        ((64, 64), (128, 96), 32, 6, 0.3, false),
        ((20, 20), (64, 64), 16, 8, 1.0, true),
        ((40, 24), (75, 49), 16, 5, 0.1, true),
        ((64, 64), (30, 200), 64, 32, 0.1, false),
    ]
    .into_iter()
    .enumerate()
    {
        let sample = noise(size.0, size.1, i as u32 + 7);
        let params = QuiltParams { block_px, overlap_px, tolerance, seed: 11 + i as u32, tileable };
        let oracle = quilt_oracle(&sample, size, output, &params, None).expect("oracle");
        let got = quilt_gpu(&gpu, &sample, size, output, &params);
        assert_same(&got, &oracle, &format!("case {i}"));
    }
}
