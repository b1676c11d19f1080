//! Free quilting: stages, synthesis, preparation and the whole program, with pruning and without.

use crate::counts::Counts;
use crate::textures::{brush, Texels};
use crate::timing::{measure, process, take_rounds, Arithmetic, Measured, Spread};
use crate::{plain_cpu, Bench, Result, PART};
use impasto::gpu::ceilings::What;
use impasto::gpu::{Context, Runner, Uploads};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Pruning, Quilt, QuiltStages, SampleTexels};
use std::sync::Arc;

/// Quilting of one texture, `side` pixels wide and high, to `to` pixels wide and high.
pub struct Job {
    pub name: &'static str,
    pub texels: Texels,
    pub side: u32,
    pub to: u32,
}

/// How much to measure.
#[derive(Clone, Copy)]
pub struct Effort {
    pub rounds: usize,
    /// Without pruning.
    pub full_rounds: usize,
    /// Whether the plain CPU search may take part.
    pub plain_cpu: bool,
}

fn params() -> QuiltParams {
    QuiltParams { block_px: 32, overlap_px: 5, ..Default::default() }
}

impl Job {
    /// All that is done once for a sample and an output size, but for compiling the stages.
    fn prepare(&self, context: &Context, runner: &mut Runner, stages: &Arc<QuiltStages>) -> Result<Quilt> {
        let mut uploads = Uploads::default();
        let Job { side, to, .. } = *self;
        let sample = SampleTexels::new(context, &mut uploads, &self.texels, (side, side))?;
        let quilt = Quilt::new(context, &mut uploads, stages, &sample, (to, to), &params(), None)?;
        runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        })?;
        Ok(quilt)
    }

    /// Prepares several times; the last one, and how long they took.
    fn preparation(&self, bench: &mut Bench, stages: &Arc<QuiltStages>, count: usize) -> Result<(Quilt, Spread)> {
        let mut quilt = self.prepare(&bench.context, &mut bench.runner, stages)?;
        let spread = take_rounds(count, || {
            quilt = self.prepare(&bench.context, &mut bench.runner, stages)?;
            Ok(())
        })?;
        Ok((quilt, spread))
    }

    /// What is asked for of this job.
    pub fn run(&self, bench: &mut Bench, effort: Effort) -> Result {
        let Job { name, side, to, .. } = *self;
        println!("\nquilt {name} {side}x{side} -> {to}x{to}, block 32, overlap 5");
        let stages = QuiltStages::with_pruning(&bench.context, Pruning::On);
        if bench.wants("quilt") || bench.wants("counts") {
            let quilt = self.prepare(&bench.context, &mut bench.runner, &stages)?;
            let counts = Counts::of_pruned_search(&mut bench.runner, &quilt, &params(), side)?;
            match &counts {
                Some(counts) => counts.print(),
                None => println!("  this device cannot prune it"),
            }
            if bench.wants("quilt") {
                let counts = counts.unwrap_or_else(|| Counts::of_full_search(&quilt, &params(), side));
                drop(quilt);
                let full = QuiltStages::with_pruning(&bench.context, Pruning::Off);
                let pruned = self.synthesis(bench, "pruned", &stages, &counts, effort.rounds)?;
                if pruned.bytes != self.synthesis(bench, "full", &full, &counts, effort.full_rounds)?.bytes {
                    return Err(format!("{name}: a full search gives other bytes than a pruned one").into());
                }
                println!("  the full search gave the bytes of the pruned one");
            }
        }
        if bench.wants("process") {
            let (sample, out) = (bench.folder.join(format!("{name}.png")), bench.folder.join("out.png"));
            image::RgbaImage::from_raw(side, side, self.texels.concat()).ok_or("a texture")?.save(&sample)?;
            let (sample, out) = (sample.to_string_lossy(), out.to_string_lossy());
            process(effort.rounds, &["quilt", &sample, "--size", &format!("{to}x{to}"), "--overlap", "5", "-o", &out])?;
        }
        if bench.wants("cpu") && effort.plain_cpu {
            plain_cpu::report(&self.texels, side, to, &params())?;
        }
        Ok(())
    }

    fn synthesis(
        &self,
        bench: &mut Bench,
        name: &str,
        stages: &Arc<QuiltStages>,
        counts: &Counts,
        count: usize,
    ) -> Result<Measured> {
        let (quilt, preparation) = self.preparation(bench, stages, count)?;
        let measured = synthesise(&mut bench.runner, &quilt, count)?;
        println!("  {name} search: synthesis {}; preparation {}", measured.wall.text(), preparation.short());
        for (stage, spread) in measured.stages.iter().filter(|(stage, _)| stage.starts_with("quilt_")) {
            let rate = rate(&bench.arithmetic, stage, spread.median(), counts);
            println!("    {stage:15} {:>22}{rate}", spread.short());
        }
        Ok(measured)
    }
}

/// The rate of a stage whose operations are known. A pixel comparison is three multiplications and three additions.
fn rate(arithmetic: &Arithmetic, stage: &str, seconds: f64, counts: &Counts) -> String {
    let (operations, path) = match stage {
        "quilt_search" => (6.0 * counts.comparisons as f64, What::SearchPath),
        "quilt_bound" => (counts.bound_operations(), What::ProductPath),
        "quilt_compare" => (6.0 * counts.comparisons_left as f64, What::SearchPath),
        _ => return String::new(),
    };
    arithmetic.share(operations, seconds, path)
}

fn synthesise(runner: &mut Runner, quilt: &Quilt, count: usize) -> Result<Measured> {
    measure(runner, count, &[quilt.canvas(), quilt.source()], |runner| {
        for part in quilt.parts(PART) {
            runner.run(|recorder| {
                quilt.record_part(recorder, part, 1, 0);
                Ok(())
            })?;
        }
        Ok(())
    })
}

/// How the cost of a pruned quilting grows with the number of blocks, and with the number of positions.
pub fn curves(bench: &mut Bench) -> Result {
    const ROUNDS: usize = 3;
    let stages = QuiltStages::with_pruning(&bench.context, Pruning::On);
    let mut curve = |what: &str, sizes: &[(u32, u32)], x: fn(&Counts) -> u64| -> Result {
        println!("\ncost by number of {what}: brush, block 32, overlap 5, pruned; median / p95 of {ROUNDS} rounds");
        println!("| sample | output | positions | blocks | synthesis | preparation | synthesis / {what} |");
        println!("|---|---|---|---|---|---|---|");
        let (mut synthesis, mut both) = (Vec::new(), Vec::new());
        for &(side, to) in sizes {
            let job = Job { name: "brush", texels: brush(side as i32), side, to };
            let (quilt, preparation) = job.preparation(bench, &stages, ROUNDS)?;
            let wall = synthesise(&mut bench.runner, &quilt, ROUNDS)?.wall;
            let counts = Counts::of_full_search(&quilt, &params(), side);
            let (all, time) = (x(&counts) as f64, wall.median());
            println!(
                "| {side}x{side} | {to}x{to} | {} | {} | {} | {} | {:.3} us |",
                counts.positions,
                counts.blocks,
                wall.short(),
                preparation.short(),
                1e6 * time / all
            );
            synthesis.push((all, time));
            both.push((all, time + preparation.median()));
        }
        println!(
            "time grows as {what} to the power of {:.2}; with preparation, {:.2}",
            exponent(&synthesis),
            exponent(&both)
        );
        Ok(())
    };
    curve("blocks", &[256, 384, 512, 768, 1024].map(|to| (192, to)), |counts| counts.blocks)?;
    curve("positions", &[64, 96, 128, 192, 256, 384, 512].map(|side| (side, 512)), |counts| counts.positions)
}

/// The slope of the least-squares line through the logarithms of points.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let slope = |of: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(|p| (p.0 - mx) * of(p)).sum::<f64>();
    slope(&|p| p.1 - my) / slope(&|p| p.0 - mx)
}
