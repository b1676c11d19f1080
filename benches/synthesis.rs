//! Throughput of the quilting stages; temporary form.
use impasto::gpu::{Context, ContextOptions, Runner, Uploads};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Quilt, QuiltStages, SampleTexels};
use std::time::Instant;

fn main() {
    let context = Context::new(&ContextOptions::default()).unwrap();
    let mut runner = Runner::new(&context).unwrap();
    let stages = QuiltStages::new(&context).unwrap();
    let (w, h) = (192u32, 192u32);
    let mut s = 1u32;
    let texels: Vec<[u8; 4]> = (0..w * h)
        .map(|i| {
            s ^= s << 13;
            s ^= s >> 17;
            s ^= s << 5;
            [(s & 63) as u8 + (i % w) as u8 / 2, (s >> 8 & 63) as u8, (s >> 16 & 63) as u8 + (i / w) as u8 / 2, 255]
        })
        .collect();
    let params = QuiltParams { block_px: 32, overlap_px: 5, ..Default::default() };
    for round in 0..6 {
        let mut uploads = Uploads::default();
        let sample = SampleTexels::new(&context, &mut uploads, &texels, (w, h)).unwrap();
        let quilt = Quilt::new(&context, &mut uploads, &stages, &sample, (512, 512), &params, None).unwrap();
        runner.run(|r| Ok(uploads.record(r))).unwrap();
        let start = Instant::now();
        let cpu0 = cpu();
        for part in quilt.parts(500_000_000) {
            runner.run(|r| Ok(quilt.record_part(r, part, 1, 0))).unwrap();
        }
        let t = start.elapsed().as_secs_f64();
        let c = quilt.comparisons();
        let cpu = cpu() - cpu0;
        println!(
            "round {round}: {t:.3} s, cpu {cpu:.2} s, {:.2} G comparisons, {:.2} G/s",
            c as f64 / 1e9,
            c as f64 / 1e9 / t
        );
        for time in runner.take_times() {
            println!("    {:12} {:5} {:8.2} ms", time.name, time.count, time.total_ns as f64 / 1e6);
        }
    }
}

fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}
