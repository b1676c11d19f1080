//! The three real-time techniques on the GPU against plain oracles: prepared textures exactly, frames to a tolerance.

mod aligned;
mod carry;
#[path = "../common/mod.rs"]
mod common;
mod dependent;
mod object;

use common::{noise, Validated};
use glam::Vec4;
use impasto::gpu::{Image, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, DirectionalLight, Framing, GuidePass, Lights, Mesh, MeshOptions, Moment, Pose, Vec3};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::QuiltStages;
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide};
use impasto::synthesis::tile_oracle::tile_oracle;
use impasto::technique::aligned::{
    AlignedFrame, AlignedTechnique, LevelBlend, LevelParams, LevelSource, LevelVolume, Tileable,
};
use impasto::technique::dependent::{
    blend_weights, default_views, Covered, DependentParams, DependentTechnique, View, ViewCoverage,
};
use impasto::technique::image::ImageParams;
use impasto::technique::object::{CoordinateParams, ObjectParams, ObjectTechnique, StripRepeat};
use impasto::technique::{Paint, ShadeRange, Show};

fn builtin(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)).expect("an asset")
}

fn model(name: &str) -> Mesh {
    Mesh::parse(&builtin(name)[..], name, &MeshOptions::default()).expect("a mesh").mesh
}

fn strip(name: &str) -> (TextureDifference, Trajectory) {
    let sample = PaintSample::decode(&builtin(name), name.as_ref()).expect("a strip");
    let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default()).expect("a trajectory");
    (TextureDifference::extract(&sample, &trajectory), trajectory)
}

/// A strip of noise, small and quick to quilt.
fn noise_strip(width: u32, height: u32) -> TextureDifference {
    let pixels = noise(width, height, 5).iter().map(|p| [0, 1, 2].map(|k| f32::from(p[k]) / 255.0 - 0.5)).collect();
    TextureDifference::from_pixels(width, height, pixels).expect("a difference")
}

fn rgba(runner: &mut Runner, image: &Image) -> Vec<[u8; 4]> {
    bytemuck::pod_collect_to_vec(&runner.read_image(image).expect("an image"))
}

/// The share of values that are more than `most` off, alpha included.
fn share_off(a: &[[u8; 4]], b: &[[u8; 4]], most: u8) -> f64 {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > most)).count();
    off as f64 / a.len() as f64
}

fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Compares with tests/golden/NAME.png, a picture looked at by a person; IMPASTO_BLESS=1 writes it anew.
fn assert_golden(name: &str, pixels: &[[u8; 4]], size: (u32, u32), share: f64) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"));
    if std::env::var_os("IMPASTO_BLESS").is_some() {
        let picture = image::RgbaImage::from_raw(size.0, size.1, pixels.concat()).expect("a picture");
        picture.save(&path).expect("a golden picture written");
    }
    let golden = image::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).to_rgba8();
    let golden: Vec<[u8; 4]> = golden.pixels().map(|pixel| pixel.0).collect();
    let off = share_off(pixels, &golden, 4);
    assert!(off <= share, "{name}: {off:.4} of the pixels are off");
}

const LEVELS: LevelParams = LevelParams {
    levels: 3,
    size_px: 64,
    tileable: Tileable::Wrap,
    quilt: QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.1, seed: 1, tileable: false },
};

/// Prepares and reads levels.
fn levels(
    gpu: &Validated,
    runner: &mut Runner,
    paints: &[LevelSource<'_>],
    params: &LevelParams,
    seed: u32,
) -> LevelVolume {
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context);
    let volume = LevelVolume::new(&gpu.context, &mut uploads, &stages, paints, params).expect("levels");
    runner
        .run(|recorder| {
            uploads.record(recorder);
            Ok(())
        })
        .expect("run");
    for part in volume.parts(20_000_000) {
        runner
            .run(|recorder| {
                volume.record_part(recorder, &part, seed);
                Ok(())
            })
            .expect("run");
    }
    volume
}

/// A guide pass drawn, with its shade and ID.
fn guide(
    gpu: &Validated,
    runner: &mut Runner,
    mesh: &Mesh,
    camera: &Camera,
    lights: &Lights,
    size: (u32, u32),
) -> (GuidePass, Vec<f32>, Vec<u32>) {
    let mut uploads = Uploads::default();
    let pass = GuidePass::new(&gpu.context, &mut uploads, mesh, size).expect("a guide pass");
    runner
        .run(|recorder| {
            uploads.record(recorder);
            pass.record(recorder, &Moment::at_rest(*camera, lights.clone()))
        })
        .expect("run");
    let shade = bytemuck::pod_collect_to_vec(&runner.read_image(pass.shade()).expect("shade"));
    let id = bytemuck::pod_collect_to_vec(&runner.read_image(pass.id()).expect("id"));
    (pass, shade, id)
}

/// What a frame shows where colour is all: the trajectory at each pixel's shade.
fn coloured(trajectory: &Trajectory, shade: &[f32], id: &[u32]) -> Vec<[u8; 4]> {
    let pixel = |(shade, id): (&f32, &u32)| {
        let [r, g, b] = trajectory.at(*shade).map(|value| (value * 255.0).round() as u8);
        if *id == 0 {
            [0; 4]
        } else {
            [r, g, b, 255]
        }
    };
    shade.iter().zip(id).map(pixel).collect()
}

/// Mean luminance of the pixels of each eighth of the range of shade.
fn luminance_by_shade(frame: &[[u8; 4]], shade: &[f32], id: &[u32]) -> Vec<f64> {
    let mut bins = vec![(0.0, 0u32); 8];
    for ((p, s), _) in frame.iter().zip(shade).zip(id).filter(|((p, _), id)| **id != 0 && p[3] == 255) {
        let bin = &mut bins[((s * 8.0) as usize).min(7)];
        bin.0 += 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
        bin.1 += 1;
    }
    bins.into_iter().filter(|(_, count)| *count > 50).map(|(sum, count)| sum / f64::from(count)).collect()
}

#[test]
fn every_technique_keeps_the_order_of_shades() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("head.obj");
    let size = (160, 160);
    let (camera, lights) = (Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera"), Lights::default());
    let (pass, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, &lights, size);
    let moment = Moment::at_rest(camera, lights);
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let mut uploads = Uploads::default();
    let object = ObjectTechnique::new(&gpu.context, &mut uploads, &mesh, size, &paints, &[0], &ObjectParams::default());
    let object = object.expect("object");
    let volume = levels(&gpu, &mut runner, &[LevelSource::Strip(&texture)], &LevelParams { levels: 8, ..LEVELS }, 1);
    let aligned = AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &[&trajectory], &[0]).expect("new");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &VIEWS, 512).expect("covered");
    let params = DependentParams { k: Some(0.25), ..Default::default() };
    let views = dependent_technique(&gpu, &mut runner, &mesh, &covered, size, &paints, &[0], &params);
    for part in views.preparation_parts(400_000_000) {
        runner.run(|recorder| views.record_preparation(recorder, &part, 1)).expect("run");
    }
    runner
        .run(|recorder| {
            uploads.record(recorder);
            object.record(recorder, &moment, ShadeRange::default(), Show::Painted)?;
            aligned.record(recorder, &AlignedFrame::default(), &[])?;
            views.record(recorder, &moment, Show::Painted)
        })
        .expect("run");
    for (name, frame) in [("object", object.frame()), ("aligned", aligned.frame()), ("dependent", views.frame())] {
        let light = luminance_by_shade(&rgba(&mut runner, frame), &shade, &id);
        assert!(light.len() >= 7 && light.windows(2).all(|pair| pair[0] < pair[1]), "{name}: {light:?}");
    }
}

#[test]
fn paint_goes_with_an_object_that_turns() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let size = (160, 120);
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let (_, other) = strip("strip_green_yellow.png");
    let paints =
        [Paint { texture: &texture, trajectory: &trajectory }, Paint { texture: &texture, trajectory: &other }];
    let mut uploads = Uploads::default();
    let guides = GuidePass::new(&gpu.context, &mut uploads, &mesh, size).expect("guides");
    let params = ObjectParams::default();
    let object = ObjectTechnique::new(&gpu.context, &mut uploads, &mesh, size, &paints, &[0, 1], &params).expect("new");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &VIEWS, 512).expect("covered");
    let params = DependentParams { k: Some(0.5), ..Default::default() };
    let views = dependent_technique(&gpu, &mut runner, &mesh, &covered, size, &paints, &[0, 1], &params);
    for part in views.preparation_parts(400_000_000) {
        runner.run(|recorder| views.record_preparation(recorder, &part, 1)).expect("run");
    }
    let mut draw = |moment: &Moment| {
        runner
            .run(|recorder| {
                uploads.record(recorder);
                guides.record(recorder, moment)?;
                object.record(recorder, moment, ShadeRange::default(), Show::Painted)?;
                views.record(recorder, moment, Show::Painted)
            })
            .expect("run");
        let id: Vec<u32> = bytemuck::pod_collect_to_vec(&runner.read_image(guides.id()).expect("id"));
        let depth: Vec<f32> = bytemuck::pod_collect_to_vec(&runner.read_image(guides.depth()).expect("depth"));
        (id, depth, [rgba(&mut runner, object.frame()), rgba(&mut runner, views.frame())])
    };

    // All of it turned, and eye and light with it, is the same picture.
    let center = mesh.bounding_sphere().center;
    let (axis, way) = (Vec3::new(0.2, 1.0, -0.1), Vec3::new(0.3, -0.2, 0.5));
    let pose = Pose::new(70.0, axis, center, way).expect("a pose");
    let moved = |p: Vec3| pose.matrix().as_mat4().transform_point3(p);
    let turned = |d: Vec3| pose.matrix().as_mat4().transform_vector3(d);
    let aspect = size.0 as f32 / size.1 as f32;
    let camera = Camera::framing(&mesh, &Framing::default(), aspect).expect("a camera");
    let with_it = Camera::look_at(moved(camera.eye()), moved(camera.target()), Some(turned(camera.up())), 30.0);
    let light = turned(Lights::default().mean_direction());
    let lights = Lights::new([DirectionalLight::new(light, 1.0).expect("a light")]).expect("lights");
    let still = draw(&Moment::at_rest(camera, Lights::default()));
    let moment =
        Moment { poses: vec![pose; 2], ..Moment::at_rest(with_it.expect("a camera"), lights) }.fit_depth(&mesh);
    let all = draw(&moment);
    for (name, (a, b)) in ["object", "dependent"].iter().zip(still.2.iter().zip(&all.2)) {
        let off = share_off(a, b, 4);
        assert!(off < 0.01, "{name}: {off} of the pixels differ");
    }
    assert!(share_off(&all.2[0], &all.2[1], 4) > 0.1, "the paint is worth comparing");

    // One turned and the other not: each is as where both do what it does.
    let camera = camera.moved_away(1.5).expect("a camera");
    let camera = Moment { poses: vec![pose], ..Moment::at_rest(camera, Lights::default()) }.fit_depth(&mesh).camera;
    let at = |poses: &[Pose]| Moment { poses: poses.to_vec(), ..Moment::at_rest(camera, Lights::default()) };
    let [rest, both, one] = [at(&[]), at(&[pose; 2]), at(&[pose])].map(|moment| draw(&moment));
    let pixels = size.0 as usize * size.1 as usize;
    for (id, from) in [(1, &both), (2, &rest)] {
        let same: Vec<usize> =
            (0..pixels).filter(|&i| one.0[i] == id && from.0[i] == id && one.1[i] == from.1[i]).collect();
        assert!(same.len() > 300, "{} pixels of object {id}", same.len());
        for technique in 0..2 {
            assert!(same.iter().all(|&i| one.2[technique][i] == from.2[technique][i]), "{id}, {technique}");
        }
    }
}

const VIEWS: [View; 3] = [
    View { yaw_deg: 0.0, pitch_deg: 0.0 },
    View { yaw_deg: 120.0, pitch_deg: 20.0 },
    View { yaw_deg: 240.0, pitch_deg: -30.0 },
];

#[allow(clippy::too_many_arguments)] // as DependentTechnique::new
fn dependent_technique(
    gpu: &Validated,
    runner: &mut Runner,
    mesh: &Mesh,
    covered: &Covered,
    size: (u32, u32),
    paints: &[Paint<'_>],
    of_object: &[u32],
    params: &DependentParams,
) -> DependentTechnique {
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context);
    let technique = DependentTechnique::new(
        &gpu.context,
        &mut uploads,
        &stages,
        mesh,
        &Lights::default(),
        covered,
        512,
        size,
        paints,
        of_object,
        params,
    )
    .expect("new");
    runner
        .run(|recorder| {
            uploads.record(recorder);
            Ok(())
        })
        .expect("run");
    technique
}

#[test]
fn wrong_use_is_told() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let (texture, trajectory) = strip("strip_dark_red.png");
    let paint = Paint { texture: &texture, trajectory: &trajectory };
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context);
    let mut prepare = |params: LevelParams| {
        let sources = [LevelSource::Strip(&texture)];
        LevelVolume::new(&gpu.context, &mut uploads, &stages, &sources, &params)
            .map(|_| ())
            .expect_err("refused")
            .to_string()
    };
    assert!(prepare(LevelParams { levels: 0, ..LEVELS }).contains("levels is 0"));
    assert!(prepare(LevelParams { size_px: 8, ..LEVELS }).contains("size_px is 8"));
    let block_px = QuiltParams { block_px: 3, ..LEVELS.quilt };
    assert!(prepare(LevelParams { quilt: block_px, ..LEVELS }).contains("block_px is 3"));
    let mut uploads = Uploads::default();
    let mut object = |paints: &[Paint<'_>], of_object: &[u32], params: ObjectParams| {
        ObjectTechnique::new(&gpu.context, &mut uploads, &mesh, (8, 8), paints, of_object, &params)
            .map(|_| ())
            .expect_err("refused")
            .to_string()
    };
    assert!(object(&[], &[0, 0], ObjectParams::default()).contains("paints is 0"));
    assert!(object(&[paint], &[0], ObjectParams::default()).contains("2 objects"));
    let repeats = CoordinateParams { repeats: -1.0, ..Default::default() };
    assert!(object(&[paint], &[0, 0], ObjectParams { coordinates: repeats, ..Default::default() })
        .contains("repeats is -1"));
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &VIEWS, 512).expect("covered");
    let tileable =
        DependentParams { quilt: QuiltParams { tileable: true, ..Default::default() }, ..Default::default() };
    let mut uploads = Uploads::default();
    let mut view = |paints: &[Paint<'_>], of_object: &[u32], params: &DependentParams| {
        DependentTechnique::new(
            &gpu.context,
            &mut uploads,
            &stages,
            &mesh,
            &Lights::default(),
            &covered,
            512,
            (8, 8),
            paints,
            of_object,
            params,
        )
        .map(|_| ())
        .expect_err("refused")
        .to_string()
    };
    assert!(view(&[paint], &[0, 0], &tileable).contains("tileable"));
    for follow_deg in [-1.0, 181.0, f32::NAN] {
        let params = DependentParams { follow_deg, ..Default::default() };
        assert!(view(&[paint], &[0, 0], &params).contains("0 to 180 degrees"));
    }
    assert!(view(&[], &[0, 0], &DependentParams::default()).contains("paints is 0"));
    assert!(view(&[paint], &[0, 3], &DependentParams::default()).contains("below the 1 paints"));
}
