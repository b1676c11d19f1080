//! What this device can do at most, to set beside what the stages reach: see benches/README.md.
//!
//! `ROUNDS=20 cargo bench --bench ceilings` takes more rounds. A wrong result is an error.

use impasto::gpu::ceilings::{measure, Effort, Rate, What};
use impasto::gpu::{Context, ContextOptions, Runner};
use std::error::Error;
use std::time::Instant;

fn name(what: What) -> &'static str {
    match what {
        What::CopyBuffer => "buffer copied by transfer",
        What::CopyWords => "storage buffer to storage buffer",
        What::CopyTexels => "storage image to storage image",
        What::Float => "float multiply-add, no loads",
        What::SearchPath => "float multiply-add, the search's path",
        What::ProductPath => "float multiply-add, the product's path",
        What::Integer => "integer multiply-add, no loads",
        What::Dot8 => "8-bit dot product by shifts",
        What::Dot8Packed => "8-bit dot product by its instruction",
    }
}

fn text(rate: Rate) -> String {
    format!("{:.1} / {:.1}", rate.median / 1e9, rate.best / 1e9)
}

fn main() -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let context = Context::new(&ContextOptions::default())?;
    let mut runner = Runner::new(&context)?;
    let mut effort = Effort::full(&context);
    if let Some(rounds) = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()) {
        effort.rounds = rounds;
    }
    let measured = measure(&mut runner, &What::ALL, &effort)?;
    println!("{}; median / best of {} rounds", context.device_info().name, effort.rounds.max(1));
    println!("Gop: a multiply-add is 2 operations, four 8-bit products added up are 8. GB: read and written.");
    println!("| what | GPU's clock | wall clock | unit |\n|---|---|---|---|");
    for ceiling in &measured {
        let (size, unit) = match ceiling.what.is_bandwidth() {
            true => (format!(", {} MiB", ceiling.copy_bytes >> 20), "GB/s"),
            false => (String::new(), "Gop/s"),
        };
        let gpu = if ceiling.gpu_seconds.is_empty() { "none".to_owned() } else { text(ceiling.rate()) };
        println!("| {}{size} | {gpu} | {} | {unit} |", name(ceiling.what), text(ceiling.wall_rate()));
    }
    if !context.caps().integer_dot_product {
        println!("The device has no instruction for 8-bit dot products (VK_KHR_shader_integer_dot_product).");
    }
    println!("measured in {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}
