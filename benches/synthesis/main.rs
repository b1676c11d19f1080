//! How fast synthesis is: the main jobs with pruning and without, how their cost grows, and what share of the device's
//! ceilings they reach.
//!
//! `cargo bench --bench synthesis` prints all of it; `cargo bench --bench synthesis -- quilt curves` prints only these
//! parts: `quilt` (stages, synthesis and preparation of free quilting), `counts` (what pruning leaves; with `quilt`
//! too), `process` (the whole program), `cpu` (the plain CPU search, the peer), `curves` (cost by the numbers of blocks
//! and of positions) and `render` (guided quilting). `ROUNDS=20` takes more rounds.
//!
//! Every time is median and 95th percentile of several rounds after a warm-up. Every round must give the bytes of the
//! first, and a full search those of a pruned one: other bytes are an error. Nothing passes or fails by time. The
//! preparation of view-aligned levels is in `benches/techniques.rs`.

mod counts;
mod plain_cpu;
mod quilting;
mod render;
mod textures;
mod timing;

use impasto::gpu::{Context, ContextOptions, Runner};
use quilting::{Effort, Job};
use std::error::Error;
use std::path::PathBuf;
use textures::TEXTURES;
use timing::Arithmetic;

pub type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

/// Pixel comparisons in a submission, as the program has it.
pub const PART: u64 = 400_000_000;

const PARTS: [&str; 6] = ["quilt", "counts", "process", "cpu", "curves", "render"];

/// What all parts need.
pub struct Bench {
    pub context: Context,
    pub runner: Runner,
    pub rounds: usize,
    /// For files, until the end.
    pub folder: PathBuf,
    /// What was asked for; nothing is everything.
    parts: Vec<String>,
    pub arithmetic: Arithmetic,
}

impl Bench {
    pub fn wants(&self, part: &str) -> bool {
        self.parts.is_empty() || self.parts.iter().any(|wanted| wanted == part)
    }

    fn wants_any(&self, parts: &[&str]) -> bool {
        parts.iter().any(|part| self.wants(part))
    }
}

fn main() -> Result {
    // Cargo adds --bench.
    let parts: Vec<String> = std::env::args().skip(1).filter(|part| part != "--bench").collect();
    if let Some(part) = parts.iter().find(|part| !PARTS.contains(&part.as_str())) {
        return Err(format!("there is no part {part}, only {}", PARTS.join(", ")).into());
    }
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(5).max(1);
    let context = Context::new(&ContextOptions::default())?;
    let info = context.device_info();
    let (api, driver) = (info.api_version_text(), info.driver_version);
    println!("device: {} ({}), Vulkan {api}, driver {driver:#x}", info.name, info.kind);
    println!("cores: {}", std::thread::available_parallelism()?);
    let mut runner = Runner::new(&context)?;
    let arithmetic = Arithmetic::measure(&context, &mut runner)?;
    let folder = std::env::temp_dir().join(format!("impasto-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let done = run(&mut Bench { context, runner, rounds, folder: folder.clone(), parts, arithmetic });
    std::fs::remove_dir_all(&folder)?;
    done
}

fn run(bench: &mut Bench) -> Result {
    let (all, some) = (bench.rounds, bench.rounds.div_ceil(3));
    // For the large ones a full search takes seconds, and the plain one on the CPU minutes.
    let small = Effort { rounds: all, full_rounds: all, plain_cpu: true };
    let large = Effort { rounds: some, full_rounds: 1, plain_cpu: false };
    for (side, to, effort) in [(192, 512, small), (256, 1024, large)] {
        if bench.wants_any(&["quilt", "counts", "process"]) || (bench.wants("cpu") && effort.plain_cpu) {
            for (name, texture) in TEXTURES {
                Job { name, texels: texture(side as i32), side, to }.run(bench, effort)?;
            }
        }
    }
    if bench.wants("curves") {
        quilting::curves(bench)?;
    }
    if bench.wants_any(&["render", "process"]) {
        render::run(bench)?;
    }
    Ok(())
}
