//! Guided quilting: a frame of image-based synthesis, with pruning and without.

use crate::timing::{measure, process, Measured};
use crate::{Bench, Result, PART};
use impasto::gpu::Uploads;
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, Framing, GuidePass, Lights, Mesh, MeshOptions, Moment};
use impasto::synthesis::quilt::{Pruning, QuiltStages};
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::Paint;
use std::path::{Path, PathBuf};

const SIZE: (u32, u32) = (1024, 1024);

/// The skull where the sample data is at hand, and the built-in head otherwise; k of the thesis and k by default.
pub fn run(bench: &mut Bench) -> Result {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("IMPASTO_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let skull = data.join("models/skull.obj");
    let model = if skull.is_file() { skull } else { root.join("assets/head.obj") };
    let strip = root.join("assets/strip_green_yellow.png");
    for k in [Some(4.0), None] {
        frames(bench, &model, &strip, k)?;
        if bench.wants("process") {
            let out = bench.folder.join("out.png");
            let (model, strip, out) = (model.to_string_lossy(), strip.to_string_lossy(), out.to_string_lossy());
            let mut arguments = vec!["render", &model, "--paint", &strip, "-o", &out];
            if k.is_some() {
                arguments.extend(["--k", "4"]);
            }
            process(bench.rounds, &arguments)?;
        }
    }
    Ok(())
}

fn frames(bench: &mut Bench, model: &Path, strip: &Path, k: Option<f32>) -> Result {
    let mesh = Mesh::load(model, &MeshOptions::default())?.mesh;
    let sample = PaintSample::load(strip)?;
    println!(
        "\nrender {} ({} triangles) {}x{} with {}x{} strip, k {}",
        model.file_name().unwrap_or_default().to_string_lossy(),
        mesh.indices().len() / 3,
        SIZE.0,
        SIZE.1,
        sample.width(),
        sample.height(),
        k.map_or("by default".to_owned(), |k| k.to_string())
    );
    if !bench.wants("render") {
        return Ok(());
    }
    let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default())?;
    let texture = TextureDifference::extract(&sample, &trajectory);
    let paint = Paint { texture: &texture, trajectory: &trajectory };
    let pruned = frame(bench, &mesh, paint, k, ("pruned", Pruning::On))?;
    if pruned.bytes != frame(bench, &mesh, paint, k, ("full", Pruning::Off))?.bytes {
        return Err("render: a full search gives other bytes than a pruned one".into());
    }
    println!("  the full search gave the bytes of the pruned one");
    Ok(())
}

fn frame(
    bench: &mut Bench,
    mesh: &Mesh,
    paint: Paint<'_>,
    k: Option<f32>,
    (name, pruning): (&str, Pruning),
) -> Result<Measured> {
    let Bench { context, runner, rounds, .. } = bench;
    let moment = Moment::at_rest(Camera::framing(mesh, &Framing::default(), 1.0)?, Lights::default());
    let mut uploads = Uploads::default();
    let guides = GuidePass::new(context, &mut uploads, mesh, SIZE)?;
    let stages = QuiltStages::with_pruning(context, pruning);
    let objects = vec![0; mesh.objects().len()];
    let params = ImageParams { k, ..Default::default() };
    let technique = ImageTechnique::new(context, &mut uploads, &stages, &guides, &[paint], &objects, &params)?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    let measured = measure(runner, *rounds, &[technique.frame()], |runner| {
        runner.run(|recorder| guides.record(recorder, &moment))?;
        for part in technique.parts(PART) {
            runner.run(|recorder| {
                technique.record_part(recorder, &part, 1, 0);
                Ok(())
            })?;
        }
        Ok(())
    })?;
    println!("  {name} search: frame with its guide {}", measured.wall.text());
    for (stage, spread) in &measured.stages {
        println!("    {stage:15} {:>22}", spread.short());
    }
    Ok(measured)
}
