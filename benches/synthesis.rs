//! How long the main jobs take, beside a plain CPU search in the same run.
//!
//! `make bench` prints median and 95th percentile of several rounds, the device, the size of the problem and the rate.
//! Three views of each job: the search's time on the GPU by timestamps, the synthesis by wall clock (preparation done,
//! everything warm), and the whole program as a process. Results are verified once: every round must give the bytes of
//! the first. Nothing here passes or fails by time.

use impasto::gpu::{Context, ContextOptions, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, Framing, GuidePass, Lights, Mesh, MeshOptions, Moment};
use impasto::synthesis::params::{Layout, QuiltParams};
use impasto::synthesis::quilt::{Quilt, QuiltStages, SampleTexels};
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::Paint;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

/// Pixel comparisons in a submission, as the program has it.
const PART: u64 = 400_000_000;

/// Median and 95th percentile, in seconds.
fn spread(mut times: Vec<f64>) -> String {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
    format!("median {:.3} s, p95 {:.3} s, {} rounds", at(0.5), at(0.95), times.len())
}

fn seconds(rounds: usize, mut job: impl FnMut() -> Result) -> Result<Vec<f64>> {
    job()?; // A round to warm up.
    (0..rounds)
        .map(|_| {
            let start = Instant::now();
            job()?;
            Ok(start.elapsed().as_secs_f64())
        })
        .collect()
}

/// Numbers for made-up textures (xorshift32).
struct Numbers(u32);

impl Numbers {
    fn below(&mut self, limit: i32) -> i32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 % limit as u32) as i32
    }
}

fn texture(side: i32, mut value: impl FnMut(i32, i32) -> [i32; 3]) -> Vec<[u8; 4]> {
    let pixels = (0..side * side).map(|i| value(i % side, i / side));
    pixels.map(|c| [c[0].clamp(0, 255) as u8, c[1].clamp(0, 255) as u8, c[2].clamp(0, 255) as u8, 255]).collect()
}

/// Courses of bricks with mortar between them and a little noise: few positions fit an overlap.
fn bricks(side: i32) -> Vec<[u8; 4]> {
    let mut numbers = Numbers(1);
    texture(side, |x, y| {
        let course = y / 16;
        let mortar = y % 16 < 2 || (x + 20 * (course % 2)) % 40 < 2;
        let n = numbers.below(24);
        if mortar {
            [170 + n, 165 + n, 160 + n]
        } else {
            [140 + n + 10 * (course % 3), 60 + n, 45 + n]
        }
    })
}

/// Short slanted strokes of many shades, one over the other: many positions fit about equally well.
fn brush(side: i32) -> Vec<[u8; 4]> {
    let mut numbers = Numbers(2);
    let mut pixels = texture(side, |_, _| [120, 90, 60]);
    for _ in 0..side * side / 12 {
        let (x, y, shade, length) =
            (numbers.below(side), numbers.below(side), numbers.below(110), 8 + numbers.below(20));
        for i in 0..length {
            for width in 0..4 {
                let (x, y) = ((x + i).rem_euclid(side), (y + i / 2 + width).rem_euclid(side));
                let value = |base: i32| (base + shade + numbers_at(x, y) % 12) as u8;
                pixels[(y * side + x) as usize] = [value(100), value(50), value(20), 255];
            }
        }
    }
    pixels
}

fn numbers_at(x: i32, y: i32) -> i32 {
    (x * 7919 + y * 104_729) & 0xff
}

/// The peer: for every block in raster order the overlap error at every position, plain loops on one core that the
/// compiler may vectorise; the best position is pasted without a cut.
fn plain_cpu_quilt(sample: &[[u8; 4]], side: usize, params: &QuiltParams, layout: &Layout) -> Vec<[u8; 4]> {
    let (width, height) = (layout.output.0 as usize, layout.output.1 as usize);
    let planes: Vec<Vec<i32>> = (0..3).map(|c| sample.iter().map(|p| i32::from(p[c])).collect()).collect();
    let mut out = vec![vec![0i32; width * height]; 3];
    let overlap = params.overlap_px as usize;
    let last = side - params.block_px as usize;
    for block in &layout.placements {
        let (x, y) = (block.x as usize, block.y as usize);
        let (w, h) = (block.width as usize, block.height as usize);
        let mut best = (i32::MAX, 0, 0);
        for sy in 0..=last {
            for sx in 0..=last {
                let mut error = 0;
                for dy in 0..h {
                    let run = if dy < overlap && y > 0 {
                        w
                    } else if x > 0 {
                        overlap.min(w)
                    } else {
                        0
                    };
                    for (plane, out) in planes.iter().zip(&out) {
                        let a = &plane[(sy + dy) * side + sx..][..run];
                        let b = &out[(y + dy) * width + x..][..run];
                        error += a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<i32>();
                    }
                }
                if error < best.0 {
                    best = (error, sx, sy);
                }
            }
        }
        for dy in 0..h {
            for (plane, out) in planes.iter().zip(&mut out) {
                let from = &plane[(best.2 + dy) * side + best.1..][..w];
                out[(y + dy) * width + x..][..w].copy_from_slice(from);
            }
        }
    }
    (0..width * height).map(|i| [out[0][i] as u8, out[1][i] as u8, out[2][i] as u8, 255]).collect()
}

fn quilting(
    context: &Context,
    runner: &mut Runner,
    rounds: usize,
    name: &str,
    texels: &[[u8; 4]],
    side: u32,
    to: u32,
) -> Result {
    let stages = QuiltStages::new(context);
    let params = QuiltParams { block_px: 32, overlap_px: 5, ..Default::default() };
    let mut uploads = Uploads::default();
    let sample = SampleTexels::new(context, &mut uploads, texels, (side, side))?;
    let quilt = Quilt::new(context, &mut uploads, &stages, &sample, (to, to), &params, None)?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    let billions = quilt.comparisons() as f64 / 1e9;
    println!("\nquilt {name} {side}x{side} -> {to}x{to}, block 32, overlap 5: {billions:.2} G pixel comparisons");
    let mut first = None;
    runner.take_times();
    let wall = seconds(rounds, || {
        for part in quilt.parts(PART) {
            runner.run(|recorder| {
                quilt.record_part(recorder, part, 1, 0);
                Ok(())
            })?;
        }
        let pixels = runner.read_image(quilt.canvas())?;
        if *first.get_or_insert_with(|| pixels.clone()) != pixels {
            return Err("a round gave other bytes than the first".into());
        }
        Ok(())
    })?;
    for time in runner.take_times().iter().filter(|time| time.name.starts_with("quilt_")) {
        let each = time.total_ns as f64 / 1e9 / (rounds + 1) as f64;
        let rate = if time.name == "quilt_search" {
            format!(", {:.2} G comparisons/s", billions / each)
        } else {
            String::new()
        };
        println!("  {:13} {:8.2} ms{rate}", time.name, each * 1e3);
    }
    println!("  synthesis     {}", spread(wall));
    Ok(())
}

fn plain_cpu(name: &str, texels: &[[u8; 4]], side: u32, to: u32) -> Result {
    let params = QuiltParams { block_px: 32, overlap_px: 5, ..Default::default() };
    let layout = Layout::new(&params, (to, to))?;
    let start = Instant::now();
    let pixels = plain_cpu_quilt(texels, side as usize, &params, &layout);
    let time = start.elapsed().as_secs_f64();
    let sum: u64 = pixels.iter().map(|p| u64::from(p[0])).sum();
    println!("  plain CPU search, one core, {name}: {time:.3} s, 1 round (checksum {sum})");
    Ok(())
}

fn render(context: &Context, runner: &mut Runner, rounds: usize, model: &Path, strip: &Path, k: Option<f32>) -> Result {
    let mesh = Mesh::load(model, &MeshOptions::default())?.mesh;
    let sample = PaintSample::load(strip)?;
    let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default())?;
    let texture = TextureDifference::extract(&sample, &trajectory);
    let moment = Moment::at_rest(Camera::framing(&mesh, &Framing::default(), 1.0)?, Lights::default());
    let mut uploads = Uploads::default();
    let guides = GuidePass::new(context, &mut uploads, &mesh, (1024, 1024))?;
    let stages = QuiltStages::new(context);
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let objects = vec![0; mesh.objects().len()];
    let params = ImageParams { k, ..Default::default() };
    let technique = ImageTechnique::new(context, &mut uploads, &stages, &guides, &paints, &objects, &params)?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    println!(
        "\nrender {} ({} triangles) 1024x1024 with {}x{} strip, k {k:?}",
        model.file_name().unwrap_or_default().to_string_lossy(),
        mesh.indices().len() / 3,
        sample.width(),
        sample.height()
    );
    runner.take_times();
    let wall = seconds(rounds, || {
        runner.run(|recorder| guides.record(recorder, &moment))?;
        for part in technique.parts(PART) {
            runner.run(|recorder| {
                technique.record_part(recorder, &part, 1, 0);
                Ok(())
            })?;
        }
        Ok(())
    })?;
    for time in runner.take_times() {
        println!("  {:15} {:8.2} ms", time.name, time.total_ns as f64 / 1e6 / (rounds + 1) as f64);
    }
    println!("  frame           {}", spread(wall));
    Ok(())
}

/// The program as a process, its first run (which fills the driver's cache of shaders) left out.
fn process(rounds: usize, arguments: &[&str]) -> Result {
    let wall = seconds(rounds, || {
        let output = Command::new(env!("CARGO_BIN_EXE_impasto")).args(arguments).output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        Ok(())
    })?;
    let names: Vec<_> = arguments
        .iter()
        .map(|a| Path::new(a).file_name().map_or_else(|| (*a).into(), |n| n.to_string_lossy()))
        .collect();
    println!("  process `impasto {}`: {}", names.join(" "), spread(wall));
    Ok(())
}

fn main() -> Result {
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(5);
    let context = Context::new(&ContextOptions::default())?;
    let info = context.device_info();
    println!(
        "device: {} ({}), Vulkan {}, driver {:#x}",
        info.name,
        info.kind,
        info.api_version_text(),
        info.driver_version
    );
    println!("cores: {}", std::thread::available_parallelism()?);
    let mut runner = Runner::new(&context)?;
    let folder = std::env::temp_dir().join(format!("impasto-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let out = folder.join("out.png").to_string_lossy().into_owned();
    for (name, texels) in [("bricks", bricks(192)), ("brush", brush(192))] {
        quilting(&context, &mut runner, rounds, name, &texels, 192, 512)?;
        let file = folder.join(format!("{name}.png"));
        image::RgbaImage::from_raw(192, 192, texels.concat()).ok_or("a texture of that size")?.save(&file)?;
        let file = file.to_string_lossy();
        process(rounds, &["quilt", &file, "--size", "512x512", "--overlap", "5", "-o", &out])?;
        plain_cpu(name, &texels, 192, 512)?;
    }
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("IMPASTO_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let skull = data.join("models/skull.obj");
    let model = if skull.is_file() { skull } else { root.join("assets/head.obj") };
    let strip = root.join("assets/strip_green_yellow.png");
    for k in [Some(4.0), None] {
        render(&context, &mut runner, rounds, &model, &strip, k)?;
        let (model, strip) = (model.to_string_lossy(), strip.to_string_lossy());
        let mut arguments = vec!["render", &model, "--paint", &strip, "-o", &out];
        if k.is_some() {
            arguments.extend(["--k", "4"]);
        }
        process(rounds, &arguments)?;
    }
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
