//! What a frame of each real-time technique costs, and what its preparation takes.
//!
//! `make bench` prints, for the 100,000-triangle skull where the sample data is at hand and the built-in head
//! otherwise: the time of preparing, and for a 1024x1024 frame the CPU time of the whole process (both cores and the
//! driver's threads, from /proc) and the wall time, beside the guide pass alone and beside image-based synthesis of the
//! same frame. Nothing passes or fails by time; every round must give the bytes of the first.

use impasto::gpu::{Context, ContextOptions, Image, Recorder, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, Framing, GuidePass, Lights, Mesh, MeshOptions, Moment, MotionPass, Vec3};
use impasto::synthesis::quilt::QuiltStages;
use impasto::technique::aligned::{
    screen_displacements, AlignedFrame, AlignedTechnique, LevelParams, LevelSource, LevelVolume,
};
use impasto::technique::dependent::{default_views, Carry, DependentParams, DependentTechnique, ViewCoverage};
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::object::{ObjectParams, ObjectTechnique};
use impasto::technique::{Paint, ShadeRange, Show};
use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

const SIZE: (u32, u32) = (1024, 1024);
/// Pixel comparisons in a submission, as the program has it.
const PART: u64 = 400_000_000;
/// Frames of a round: /proc counts in hundredths of a second.
const FRAMES: u32 = 20;

/// User and system time of this process so far, in milliseconds; `None` where there is no /proc.
fn cpu_ms() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at).and_then(|text| text.parse::<f64>().ok());
    Some((ticks(11)? + ticks(12)?) * 10.0)
}

fn median_and_p95(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    format!("median {:6.2} ms, p95 {:6.2} ms", at(0.5), at(0.95))
}

fn frames(
    runner: &mut Runner,
    rounds: usize,
    name: &str,
    image: Option<&Image>,
    record: impl Fn(&mut Recorder<'_>) -> impasto::Result<()>,
) -> Result {
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    let mut first: Option<Vec<u8>> = None;
    for round in 0..=rounds {
        let (cpu_before, start) = (cpu_ms(), Instant::now());
        for _ in 0..FRAMES {
            runner.run(&record)?;
        }
        // The first round is to warm up.
        if round > 0 {
            wall.push(start.elapsed().as_secs_f64() * 1e3 / f64::from(FRAMES));
            if let (Some(before), Some(after)) = (cpu_before, cpu_ms()) {
                cpu.push((after - before) / f64::from(FRAMES));
            }
        }
        if let Some(image) = image {
            let bytes = runner.read_image(image)?;
            if *first.get_or_insert_with(|| bytes.clone()) != bytes {
                return Err(format!("{name}: a round gave other bytes than the first").into());
            }
        }
    }
    let cpu = if cpu.is_empty() { "unknown".to_owned() } else { median_and_p95(cpu) };
    println!("  frame, {name:22} CPU {cpu}; wall {}", median_and_p95(wall));
    Ok(())
}

fn main() -> Result {
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(5);
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("IMPASTO_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let skull = data.join("models/skull.obj");
    let model = if skull.is_file() { skull } else { root.join("assets/head.obj") };
    let mesh = Mesh::load(&model, &MeshOptions::default())?.mesh;
    let strip = PaintSample::load(root.join("assets/strip_green_yellow.png"))?;
    let trajectory = Trajectory::extract(&strip, &TrajectoryOptions::default())?;
    let texture = TextureDifference::extract(&strip, &trajectory);
    let moment = Moment::at_rest(Camera::framing(&mesh, &Framing::default(), 1.0)?, Lights::default());
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let of_object = vec![0; mesh.objects().len()];

    let context = Context::new(&ContextOptions::default())?;
    let info = context.device_info();
    println!("device: {} ({}), driver {:#x}", info.name, info.kind, info.driver_version);
    println!("cores: {}", std::thread::available_parallelism()?);
    let triangles = mesh.indices().len() / 3;
    println!("{}, {triangles} triangles, {}x{}, strip 512x128", model.display(), SIZE.0, SIZE.1);
    let mut runner = Runner::new(&context)?;
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&context)?;
    let guides = GuidePass::new(&context, &mut uploads, &mesh, SIZE)?;
    let seconds = |start: Instant| start.elapsed().as_secs_f64();

    let start = Instant::now();
    let object =
        ObjectTechnique::new(&context, &mut uploads, &mesh, SIZE, &paints, &of_object, &ObjectParams::default())?;
    println!("  preparing object-based: {:.3} s", seconds(start));
    let params = ObjectParams { keep_paint: false, ..Default::default() };
    let lose = ObjectTechnique::new(&context, &mut uploads, &mesh, SIZE, &paints, &of_object, &params)?;

    let start = Instant::now();
    let sources = [LevelSource::Strip(&texture)];
    let levels = LevelVolume::new(&context, &mut uploads, &stages, &sources, &LevelParams::default())?;
    let aligned = AlignedTechnique::new(&context, &mut uploads, &guides, levels, &[&trajectory], &of_object)?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    for part in aligned.levels().parts(PART) {
        runner.run(|recorder| {
            aligned.levels().record_part(recorder, &part, 1);
            Ok(())
        })?;
    }
    println!("  preparing view-aligned, 8 levels of 512x512, block 32: {:.3} s", seconds(start));

    let start = Instant::now();
    let covered = ViewCoverage::run(&context, &mut runner, &mesh, &default_views(), 512)?;
    println!("  views of view-dependent: {:.3} s, {:?}", seconds(start), covered.report);
    let params = DependentParams::default();
    let dependent = DependentTechnique::new(
        &context,
        &mut uploads,
        &stages,
        &mesh,
        &moment.lights,
        &covered,
        512,
        SIZE,
        &paints,
        &of_object,
        &params,
    )?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    for part in dependent.preparation_parts(PART) {
        runner.run(|recorder| dependent.record_preparation(recorder, &part, 1))?;
    }
    println!("  preparing view-dependent, with the views: {:.3} s", seconds(start));

    frames(&mut runner, rounds, "guide pass alone", None, |recorder| guides.record(recorder, &moment))?;
    let motion = MotionPass::new(&context, &guides)?;
    frames(&mut runner, rounds, "motion", Some(motion.motion()), |recorder| {
        motion.record(recorder, Some(&moment), &moment)
    })?;
    let range = ShadeRange::default();
    frames(&mut runner, rounds, "object-based", Some(object.frame()), |recorder| {
        object.record(recorder, &moment, range, Show::Painted)
    })?;
    frames(&mut runner, rounds, "object-based, lost", Some(lose.frame()), |recorder| {
        lose.record(recorder, &moment, range, Show::Painted)
    })?;
    frames(&mut runner, rounds, "view-aligned, guided", Some(aligned.frame()), |recorder| {
        guides.record(recorder, &moment)?;
        aligned.record(recorder, &AlignedFrame::default(), &[])
    })?;
    frames(&mut runner, rounds, "view-dependent", Some(dependent.frame()), |recorder| {
        dependent.record(recorder, &moment, Show::Painted)
    })?;
    // By two eyes in turn, so that every direction follows one of them in every frame.
    let aside =
        Camera::framing(&mesh, &Framing { yaw_deg: Framing::default().yaw_deg + 90.0, ..Default::default() }, 1.0)?;
    let aside = Moment::at_rest(aside, Lights::default());
    let turn = std::cell::Cell::new(false);
    frames(&mut runner, rounds, "view-dependent, carried", None, |recorder| {
        turn.set(!turn.get());
        let seen = if turn.get() { &aside } else { &moment };
        dependent.record_carry(recorder, seen, Carry::Next);
        dependent.record_picture(recorder, &moment, Show::Painted)
    })?;

    // What a host does for every frame when the texture follows the objects.
    let next = Moment { camera: moment.camera.orbited(1.0, Vec3::Y)?, ..moment.clone() };
    let moments = [&moment, &next];
    let mut wall = Vec::new();
    for _ in 0..20 * rounds {
        let start = Instant::now();
        std::hint::black_box(screen_displacements(&mesh, moments, SIZE)?);
        wall.push(seconds(start) * 1e3);
    }
    let vertices = mesh.positions().len();
    println!("  way of {vertices} vertices, on one core: {}", median_and_p95(wall));

    // The alternative: the frame synthesised anew.
    let params = ImageParams::default();
    let image = ImageTechnique::new(&context, &mut uploads, &stages, &guides, &paints, &of_object, &params)?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    for round in 0..=rounds {
        let (before, start) = (cpu_ms(), Instant::now());
        for part in image.parts(PART) {
            runner.run(|recorder| {
                image.record_part(recorder, &part, 1, 0);
                Ok(())
            })?;
        }
        if round > 0 {
            wall.push(seconds(start) * 1e3);
            cpu.extend(before.zip(cpu_ms()).map(|(before, after)| after - before));
        }
    }
    let cpu = if cpu.is_empty() { "unknown".to_owned() } else { median_and_p95(cpu) };
    println!("  frame, {:22} CPU {cpu}; wall {}", "image-based, anew", median_and_p95(wall));
    Ok(())
}
