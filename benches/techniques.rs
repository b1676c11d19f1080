//! What a frame of each real-time technique costs, and what its preparation takes.
//!
//! `make bench` prints, for the 100,000-triangle skull where the sample data is at hand and the built-in head
//! otherwise: the time of preparing, and for a 1024x1024 frame (or SIZE=1920x1080) the CPU time of the whole process
//! (both cores and the driver's threads, from /proc), the time on the GPU and the wall time, beside the guide pass
//! alone; then frames a second of a model that turns, by every technique, beside image-based synthesis of every frame
//! anew. Nothing passes or fails by time; every round must give the bytes of the first.

use impasto::gpu::{Context, ContextOptions, Image, Recorder, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, Framing, GuidePass, Lights, Mesh, MeshOptions, Moment, MotionPass, Vec3};
use impasto::synthesis::quilt::{PreviousWeight, QuiltStages};
use impasto::synthesis::repair::RepairParams;
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
    let (mut cpu, mut gpu, mut wall) = (Vec::new(), Vec::new(), Vec::new());
    let mut first: Option<Vec<u8>> = None;
    for round in 0..=rounds {
        runner.take_times();
        let (cpu_before, start) = (cpu_ms(), Instant::now());
        for _ in 0..FRAMES {
            runner.run(&record)?;
        }
        // The first round is to warm up.
        if round > 0 {
            let ns: u64 = runner.take_times().iter().map(|time| time.total_ns).sum();
            gpu.push(ns as f64 / 1e6 / f64::from(FRAMES));
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
    println!("  frame, {name:22} CPU {cpu}; GPU {}; wall {}", median_and_p95(gpu), median_and_p95(wall));
    Ok(())
}

/// `SIZE=WIDTHxHEIGHT`, or 1024x1024.
fn size_of_frames() -> Result<(u32, u32)> {
    let Ok(text) = std::env::var("SIZE") else { return Ok((1024, 1024)) };
    let (width, height) = text.split_once('x').ok_or("SIZE is not WIDTHxHEIGHT")?;
    Ok((width.parse()?, height.parse()?))
}

fn main() -> Result {
    let size = size_of_frames()?;
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(5);
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("IMPASTO_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let skull = data.join("models/skull.obj");
    let model = if skull.is_file() { skull } else { root.join("assets/head.obj") };
    let mesh = Mesh::load(&model, &MeshOptions::default())?.mesh;
    let strip = PaintSample::load(root.join("assets/strip_green_yellow.png"))?;
    let trajectory = Trajectory::extract(&strip, &TrajectoryOptions::default())?;
    let texture = TextureDifference::extract(&strip, &trajectory);
    let moment =
        Moment::at_rest(Camera::framing(&mesh, &Framing::default(), size.0 as f32 / size.1 as f32)?, Lights::default());
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let of_object = vec![0; mesh.objects().len()];

    let context = Context::new(&ContextOptions::default())?;
    let info = context.device_info();
    println!("device: {} ({}), driver {:#x}", info.name, info.kind, info.driver_version);
    println!("cores: {}", std::thread::available_parallelism()?);
    let triangles = mesh.indices().len() / 3;
    println!("{}, {triangles} triangles, {}x{}, strip 512x128", model.display(), size.0, size.1);
    let mut runner = Runner::new(&context)?;
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&context);
    let level_params = LevelParams::default();
    stages.compile(&level_params.quilt)?;
    let guides = GuidePass::new(&context, &mut uploads, &mesh, size)?;
    let seconds = |start: Instant| start.elapsed().as_secs_f64();

    let start = Instant::now();
    let object =
        ObjectTechnique::new(&context, &mut uploads, &mesh, size, &paints, &of_object, &ObjectParams::default())?;
    println!("  preparing object-based: {:.3} s", seconds(start));
    let params = ObjectParams { keep_paint: false, ..Default::default() };
    let lose = ObjectTechnique::new(&context, &mut uploads, &mesh, size, &paints, &of_object, &params)?;

    let start = Instant::now();
    let sources = [LevelSource::Strip(&texture)];
    let levels = LevelVolume::new(&context, &mut uploads, &stages, &sources, &level_params)?;
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
        size,
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
    // What a host does for every frame when the texture follows the objects.
    let next = Moment { camera: moment.camera.orbited(1.0, Vec3::Y)?, ..moment.clone() };
    let moments = [&moment, &next];
    let mut wall = Vec::new();
    for _ in 0..20 * rounds {
        let start = Instant::now();
        std::hint::black_box(screen_displacements(&mesh, moments, size)?);
        wall.push(seconds(start) * 1e3);
    }
    let vertices = mesh.positions().len();
    println!("  way of {vertices} vertices, on one core: {}", median_and_p95(wall));

    let mut orbit = Vec::new();
    for number in 0..=FRAMES {
        let camera = moment.camera.orbited(number as f32, Vec3::Y)?.fit_depth(&mesh);
        orbit.push(Moment { camera, ..moment.clone() });
    }
    println!("turning by a degree from frame to frame, after the first:");
    let turn = |name, steps: usize| Turn { name, rounds, moments: &orbit[..=steps] };
    let all = FRAMES as usize;
    turn("object-based", all).run(&mut runner, object.frame(), |runner, now, _| {
        runner.run(|recorder| object.record(recorder, &orbit[now], range, Show::Painted))
    })?;
    let offsets = std::cell::RefCell::new(vec![[0.0; 2]; mesh.objects().len()]);
    turn("view-aligned", all).run(&mut runner, aligned.frame(), |runner, now, fresh| {
        let mut offsets = offsets.borrow_mut();
        if fresh {
            offsets.fill([0.0; 2]);
        } else {
            let ways = screen_displacements(&mesh, [&orbit[now - 1], &orbit[now]], size)?;
            for (offset, way) in offsets.iter_mut().zip(ways) {
                *offset = [0, 1].map(|axis| offset[axis] - f64::from(way[axis]));
            }
        }
        runner.run(|recorder| {
            guides.record(recorder, &orbit[now])?;
            aligned.record(recorder, &AlignedFrame::default(), &offsets)
        })
    })?;
    turn("view-dependent", all).run(&mut runner, dependent.frame(), |runner, now, fresh| {
        let carry = if fresh { Carry::Cut } else { Carry::Next };
        runner.run(|recorder| {
            dependent.record_carry(recorder, &orbit[now], carry);
            dependent.record_picture(recorder, &orbit[now], Show::Painted)
        })
    })?;
    let mut sequence = |previous, carried| -> impasto::Result<ImageTechnique> {
        let params = ImageParams { previous, ..Default::default() };
        let mut image = ImageTechnique::new(&context, &mut uploads, &stages, &guides, &paints, &of_object, &params)?;
        if carried {
            let repair = RepairParams::default();
            image.carry(&context, &mut uploads, &guides, &paints, motion.motion(), &repair)?;
        }
        runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        })?;
        Ok(image)
    };
    let carried = sequence(None, true)?;
    let matched = sequence(Some(PreviousWeight(1.0)), false)?;
    let anew = sequence(None, false)?;
    turn("image-based, carried", all).run(&mut runner, carried.frame(), |runner, now, fresh| {
        let before = (!fresh).then(|| &orbit[now - 1]);
        runner.run(|recorder| {
            guides.record(recorder, &orbit[now])?;
            motion.record(recorder, before, &orbit[now])?;
            match before {
                Some(_) => carried.record_next(recorder, 1, now as u32),
                None => carried.record(recorder, 1, now as u32),
            }
            Ok(())
        })
    })?;
    for (name, image) in [("image-based, matched", &matched), ("image-based, anew", &anew)] {
        turn(name, 3).run(&mut runner, image.frame(), |runner, now, fresh| {
            runner.run(|recorder| {
                guides.record(recorder, &orbit[now])?;
                if fresh {
                    image.forget(recorder);
                }
                Ok(())
            })?;
            for part in image.parts(PART) {
                runner.run(|recorder| {
                    image.record_part(recorder, &part, 1, now as u32);
                    Ok(())
                })?;
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// A sequence whose first frame is drawn before time is taken.
struct Turn<'a> {
    name: &'static str,
    rounds: usize,
    moments: &'a [Moment],
}

impl Turn<'_> {
    /// Draws it, a few rounds. `draw` draws a frame, and is told whether it is the first.
    fn run(
        &self,
        runner: &mut Runner,
        image: &Image,
        draw: impl Fn(&mut Runner, usize, bool) -> impasto::Result<()>,
    ) -> Result {
        let (mut cpu, mut wall) = (Vec::new(), Vec::new());
        let mut last: Option<Vec<u8>> = None;
        let frames = (self.moments.len() - 1) as f64;
        for _ in 0..self.rounds {
            draw(runner, 0, true)?;
            let (cpu_before, start) = (cpu_ms(), Instant::now());
            for now in 1..self.moments.len() {
                draw(runner, now, false)?;
            }
            wall.push(start.elapsed().as_secs_f64() * 1e3 / frames);
            cpu.extend(cpu_before.zip(cpu_ms()).map(|(before, after)| (after - before) / frames));
            let bytes = runner.read_image(image)?;
            if *last.get_or_insert_with(|| bytes.clone()) != bytes {
                return Err(format!("{}: a round gave other bytes than the first", self.name).into());
            }
        }
        let mean = wall.iter().sum::<f64>() / wall.len() as f64;
        let cpu = if cpu.is_empty() { "unknown".to_owned() } else { median_and_p95(cpu) };
        println!("  {:28} CPU {cpu}; wall {}; {:.1} frames/s", self.name, median_and_p95(wall), 1e3 / mean);
        Ok(())
    }
}
