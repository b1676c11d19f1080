//! The three real-time techniques on the GPU against plain oracles: prepared textures exactly, frames to a tolerance.

mod common;

use common::{noise, Validated};
use glam::Vec4;
use impasto::gpu::{Image, Runner, Uploads};
use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, DirectionalLight, Framing, GuidePass, Lights, Mesh, MeshOptions, Vec3};
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
fn assert_golden(name: &str, pixels: &[[u8; 4]], side: u32, share: f64) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"));
    if std::env::var_os("IMPASTO_BLESS").is_some() {
        let picture = image::RgbaImage::from_raw(side, side, pixels.concat()).expect("a picture");
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
    let stages = QuiltStages::new(&gpu.context).expect("stages");
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

#[test]
fn levels_equal_the_oracles_exactly() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let textures = [strip("strip_dark_red.png").0, noise_strip(60, 33)];
    let sources = textures.each_ref().map(LevelSource::Strip);
    for tileable in [Tileable::Wrap, Tileable::Mask] {
        let params = LevelParams { tileable, ..LEVELS };
        let volume = levels(&gpu, &mut runner, &sources, &params, 7);
        let got = rgba(&mut runner, volume.image());
        let size = (params.size_px, params.size_px);
        let texels = (size.0 * size.1) as usize;
        for (paint, texture) in textures.iter().enumerate() {
            for level in 0..params.levels {
                let (sample, sample_size) = params.sample(texture, level);
                let wrap = tileable == Tileable::Wrap;
                let quilt = QuiltParams { tileable: wrap, seed: 7 + level, ..params.quilt };
                let quilted = quilt_oracle(&sample, sample_size, size, &quilt, None).expect("oracle").pixels;
                let want = if wrap { quilted } else { tile_oracle(&quilted, size) };
                let at = (paint * params.levels as usize + level as usize) * texels;
                assert!(got[at..at + texels] == want[..], "paint {paint}, level {level}, {tileable:?}");
            }
        }
        // A level's mean is no difference before it is quilted.
        let (sample, _) = params.sample(&textures[0], 1);
        let mean = sample.iter().map(|p| f64::from(p[0])).sum::<f64>() / sample.len() as f64;
        assert!((mean - 127.5).abs() < 0.6, "{mean}");
        // What was prepared is the same when it is taken from a file.
        let (_, trajectory) = strip("strip_dark_red.png");
        let file = volume.read(&mut runner, 1, &trajectory).expect("levels");
        let again = levels(&gpu, &mut runner, &[LevelSource::Prepared(&file)], &params, 0);
        assert!(again.parts(u64::MAX).is_empty());
        assert!(rgba(&mut runner, again.image()) == got[3 * texels..6 * texels]);
    }
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
            pass.record(recorder, camera, lights)
        })
        .expect("run");
    let shade = bytemuck::pod_collect_to_vec(&runner.read_image(pass.shade()).expect("shade"));
    let id = bytemuck::pod_collect_to_vec(&runner.read_image(pass.id()).expect("id"));
    (pass, shade, id)
}

/// View-aligned projection as it reads in chapter 7, a pixel at a time.
struct Aligned<'a> {
    volume: &'a [[u8; 4]],
    params: LevelParams,
    trajectories: &'a [&'a Trajectory],
    frame: AlignedFrame,
}

impl Aligned<'_> {
    fn texel(&self, slice: usize, x: i64, y: i64) -> Vec4 {
        let side = i64::from(self.params.size_px);
        let at = slice as i64 * side * side + y.rem_euclid(side) * side + x.rem_euclid(side);
        let texel = self.volume[at as usize].map(f32::from);
        Vec4::from(texel) / 255.0 * 2.0 - 1.0
    }

    fn bilinear(&self, slice: usize, x: f32, y: f32) -> Vec4 {
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let row = |y| self.texel(slice, x, y).lerp(self.texel(slice, x + 1, y), fx);
        row(y).lerp(row(y + 1), fy)
    }

    fn pixel(&self, x: u32, y: u32, shade: f32, paint: usize) -> [u8; 4] {
        let ShadeRange { low, high } = self.frame.range;
        let tone = ((shade - low) / (high - low)).clamp(0.0, 1.0);
        let place = tone * (self.params.levels - 1) as f32;
        let level = (place as usize).min(self.params.levels as usize - 1);
        let above = (level + 1).min(self.params.levels as usize - 1);
        let f = place - level as f32;
        let at = |p: u32, k: usize| (p as f32 + 0.5 + self.frame.offset_px[k]) * self.frame.density;
        let first = paint * self.params.levels as usize;
        let [a, b] = [level, above].map(|level| self.bilinear(first + level, at(x, 0), at(y, 1)));
        let mut difference = a.lerp(b, f);
        if self.frame.blend == LevelBlend::Contrast {
            difference /= (f * f + (1.0 - f) * (1.0 - f)).sqrt();
        }
        let color = self.trajectories[paint].at(tone);
        let value = |k: usize| match self.frame.show {
            Show::Painted => color[k] + difference[k],
            Show::Color => color[k],
            Show::Texture => 0.5 + 0.5 * difference[k],
        };
        let byte = |k| (value(k).clamp(0.0, 1.0) * 255.0).round() as u8;
        [byte(0), byte(1), byte(2), 255]
    }
}

#[test]
fn aligned_frames_equal_a_plain_oracle() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let (camera, lights) = (Camera::framing(&mesh, &Framing::default(), 1.2).expect("a camera"), Lights::default());
    let size = (120, 100);
    let (pass, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, &lights, size);
    let strips = [strip("strip_dark_red.png"), strip("strip_green_yellow.png")];
    let sources = strips.each_ref().map(|(texture, _)| LevelSource::Strip(texture));
    let volume = levels(&gpu, &mut runner, &sources, &LEVELS, 3);
    let texels = rgba(&mut runner, volume.image());
    let trajectories = strips.each_ref().map(|(_, trajectory)| trajectory);
    let mut uploads = Uploads::default();
    let technique =
        AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &trajectories, &[1, 0]).expect("new");
    let plain = AlignedFrame::default();
    let frames = [
        plain,
        AlignedFrame { density: 0.7, offset_px: [13.25, -40.5], blend: LevelBlend::Linear, ..plain },
        AlignedFrame { range: ShadeRange { low: 0.2, high: 0.7 }, density: 1.5, ..plain },
        AlignedFrame { show: Show::Color, ..plain },
        AlignedFrame { show: Show::Texture, density: 2.0, ..plain },
    ];
    for frame in frames {
        runner
            .run(|recorder| {
                uploads.record(recorder);
                technique.record(recorder, &frame)
            })
            .expect("run");
        let got = rgba(&mut runner, technique.frame());
        let oracle = Aligned { volume: &texels, params: LEVELS, trajectories: &trajectories, frame };
        let want: Vec<[u8; 4]> = (0..size.0 * size.1)
            .map(|i| match id[i as usize] {
                0 => [0; 4],
                object => oracle.pixel(i % size.0, i / size.0, shade[i as usize], 2 - object as usize),
            })
            .collect();
        // The hardware's filter has 8 bits for its weights, and trilinear ones of 8-bit texels may be 1.7/255 off, which
        // the differences' range doubles and contrast may raise by the root of 2.
        let off = share_off(&got, &want, 5);
        eprintln!("{frame:?}: {off:.5} off, {:.5} by more than 2", share_off(&got, &want, 2));
        assert!(off < 0.0005, "{frame:?}: {off} of the pixels are off");
        let swapped: Vec<[u8; 4]> = want.iter().map(|&[r, g, b, a]| [g, b, r, a]).collect();
        assert!(share_off(&got, &swapped, 5) > 0.05 || frame.show == Show::Texture, "a wrong picture is noticed");
    }
    let wrong = AlignedFrame { density: 9.0, ..plain };
    let refused = runner.run(|recorder| technique.record(recorder, &wrong)).expect_err("refused").to_string();
    assert!(refused.contains("density is 9"), "{refused}");
}

/// A flat square that fills the picture, at one shade: what is seen is the texture itself.
#[test]
fn aligned_texture_repeats_without_a_seam_and_keeps_its_contrast_between_levels() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let quad = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";
    let mesh = Mesh::parse(quad.as_bytes(), "quad", &MeshOptions::default()).expect("a mesh").mesh;
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, None, 60.0).expect("a camera").fit_depth(&mesh);
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let volume = levels(&gpu, &mut runner, &[LevelSource::Strip(&texture)], &LevelParams { levels: 8, ..LEVELS }, 2);
    let lit = |shade: f32| {
        let cos = 2.0 * shade - 1.0;
        Lights::from(DirectionalLight::new(Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos), 1.0).expect("a light"))
    };
    let (pass, ..) = guide(&gpu, &mut runner, &mesh, &camera, &lit(0.5), (128, 128));
    let mut uploads = Uploads::default();
    let technique =
        AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &[&trajectory], &[0]).expect("new");
    let mut texture_at = |shade: f32, blend| {
        let frame = AlignedFrame { show: Show::Texture, blend, ..Default::default() };
        runner
            .run(|recorder| {
                uploads.record(recorder);
                pass.record(recorder, &camera, &lit(shade))?;
                technique.record(recorder, &frame)
            })
            .expect("run");
        rgba(&mut runner, technique.frame())
    };
    let on = texture_at(4.0 / 7.0, LevelBlend::Linear);
    assert!(on.iter().all(|pixel| pixel[3] == 255), "the square fills the picture");
    let change =
        |a: usize, b: usize| (0..128).map(|y| f64::from(on[y * 128 + a][0].abs_diff(on[y * 128 + b][0]))).sum::<f64>();
    let inside = (8..56).map(|x| change(x, x + 1)).sum::<f64>() / 48.0;
    assert!(change(63, 64) < 1.6 * inside, "{} at the repeat, {inside} inside", change(63, 64));
    assert!((0..64).all(|x| change(x, x + 64) < 128.0), "it does repeat");
    let spread = |pixels: &[[u8; 4]]| deviation(pixels.iter().map(|p| f64::from(p[0])));
    let next = texture_at(5.0 / 7.0, LevelBlend::Linear);
    let level = (spread(&on) + spread(&next)) / 2.0;
    let linear = spread(&texture_at(4.5 / 7.0, LevelBlend::Linear)) / level;
    let kept = spread(&texture_at(4.5 / 7.0, LevelBlend::Contrast)) / level;
    eprintln!("between levels: {linear:.3} of the contrast, {kept:.3} kept");
    assert!(linear < 0.85 && (0.9..1.12).contains(&kept), "{linear} {kept}");
}

/// The technique, its frame and whatever else a test looks at.
fn object_frame(
    gpu: &Validated,
    runner: &mut Runner,
    mesh: &Mesh,
    paints: &[Paint<'_>],
    of_object: &[u32],
    params: &ObjectParams,
    shots: &[(Lights, Show)],
) -> Vec<Vec<[u8; 4]>> {
    let camera = Camera::framing(mesh, &Framing::default(), 1.0).expect("a camera");
    let mut uploads = Uploads::default();
    let technique =
        ObjectTechnique::new(&gpu.context, &mut uploads, mesh, (200, 200), paints, of_object, params).expect("new");
    shots
        .iter()
        .map(|(lights, show)| {
            runner
                .run(|recorder| {
                    uploads.record(recorder);
                    technique.record(recorder, &camera, lights, ShadeRange::default(), *show)
                })
                .expect("run");
            rgba(runner, technique.frame())
        })
        .collect()
}

#[test]
fn object_colour_follows_light_and_texture_stays_on_its_lines() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("head.obj");
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let (_, trajectory) = strip("strip_green_yellow.png");
    // A texture that depends on the row alone does not see the light.
    let rows = (0..64 * 32).map(|i| [((i / 64) as f32 * std::f32::consts::TAU / 32.0).sin() * 0.4; 3]).collect();
    let striped = TextureDifference::from_pixels(64, 32, rows).expect("a difference");
    let lights = [Lights::default(), DirectionalLight::new(Vec3::new(0.7, 0.2, 0.6), 1.0).expect("a light").into()];
    let paints = [Paint { texture: &striped, trajectory: &trajectory }];
    let params = ObjectParams { keep_paint: false, repeat: StripRepeat::Mirror, ..Default::default() };
    let shots: Vec<_> = lights.iter().flat_map(|l| [(l.clone(), Show::Color), (l.clone(), Show::Texture)]).collect();
    let frames = object_frame(&gpu, &mut runner, &mesh, &paints, &[0], &params, &shots);
    for (lights, frame) in lights.iter().zip([&frames[0], &frames[2]]) {
        let (_, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, lights, (200, 200));
        let want: Vec<[u8; 4]> = shade
            .iter()
            .zip(&id)
            .map(|(shade, id)| {
                let [r, g, b] = trajectory.at(*shade).map(|value| (value * 255.0).round() as u8);
                if *id == 0 {
                    [0; 4]
                } else {
                    [r, g, b, 255]
                }
            })
            .collect();
        let off = share_off(frame, &want, 2);
        assert!(off < 0.003, "{off} of the colours are off");
    }
    assert!(share_off(&frames[0], &frames[2], 20) > 0.2, "the light has moved");
    assert!(share_off(&frames[1], &frames[3], 2) < 0.003, "t has not");
    let texture = |frame: &[[u8; 4]]| deviation(frame.iter().filter(|p| p[3] == 255).map(|p| f64::from(p[0])));
    assert!(texture(&frames[1]) > 20.0, "there are stripes");
    assert_golden_object(&gpu, &mut runner, &mesh);
}

fn assert_golden_object(gpu: &Validated, runner: &mut Runner, mesh: &Mesh) {
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let shots = [(Lights::default(), Show::Painted)];
    let frame = &object_frame(gpu, runner, mesh, &paints, &[0], &ObjectParams::default(), &shots)[0];
    assert_golden("object_head", frame, 200, 0.03);
    let mut planted = frame.clone();
    planted.iter_mut().for_each(|pixel| pixel[0] = 255 - pixel[0]);
    if std::env::var_os("IMPASTO_BLESS").is_none() {
        assert!(std::panic::catch_unwind(|| assert_golden("object_head", &planted, 200, 0.03)).is_err());
    }
}

#[test]
fn object_paint_is_lost_on_the_table_unless_it_is_kept() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let (_, _, id) = guide(&gpu, &mut runner, &mesh, &camera, &Lights::default(), (200, 200));
    let table = mesh.object_index("table").expect("a table") as u32 + 1;
    let strips = [strip("strip_green_yellow.png"), strip("strip_dark_red.png")];
    let paints = strips.each_ref().map(|(texture, trajectory)| Paint { texture, trajectory });
    let spread = |frame: &[[u8; 4]]| {
        deviation(frame.iter().zip(&id).filter(|(p, id)| **id == table && p[3] == 255).map(|(p, _)| f64::from(p[1])))
    };
    let shots = [(Lights::default(), Show::Texture)];
    let mut draw = |keep_paint| {
        // A little of variation must not save it.
        let coordinates = CoordinateParams { variation: 0.0, ..Default::default() };
        let params = ObjectParams { keep_paint, coordinates, ..Default::default() };
        object_frame(&gpu, &mut runner, &mesh, &paints, &[0, 1], &params, &shots).remove(0)
    };
    let (lost, kept) = (spread(&draw(false)), spread(&draw(true)));
    eprintln!("texture on the table: {lost:.2} lost, {kept:.2} kept");
    assert!(lost < 0.5, "one texel spreads over the table, but its texture has {lost}");
    assert!(kept > 3.0, "the table keeps some texture, but it is {kept}");
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
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let mut uploads = Uploads::default();
    let object = ObjectTechnique::new(&gpu.context, &mut uploads, &mesh, size, &paints, &[0], &ObjectParams::default());
    let object = object.expect("object");
    let volume = levels(&gpu, &mut runner, &[LevelSource::Strip(&texture)], &LevelParams { levels: 8, ..LEVELS }, 1);
    let aligned = AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &[&trajectory], &[0]).expect("new");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &VIEWS, 512).expect("covered");
    let params = DependentParams { k: Some(0.25), ..Default::default() };
    let views = dependent(&gpu, &mut runner, &mesh, &covered, size, &paints, &[0], &params);
    for part in views.preparation_parts(400_000_000) {
        runner.run(|recorder| views.record_preparation(recorder, &part, 1)).expect("run");
    }
    runner
        .run(|recorder| {
            uploads.record(recorder);
            object.record(recorder, &camera, &lights, ShadeRange::default(), Show::Painted)?;
            aligned.record(recorder, &AlignedFrame::default())?;
            views.record(recorder, &camera, &lights, Show::Painted)
        })
        .expect("run");
    for (name, frame) in [("object", object.frame()), ("aligned", aligned.frame()), ("dependent", views.frame())] {
        let light = luminance_by_shade(&rgba(&mut runner, frame), &shade, &id);
        assert!(light.len() >= 7 && light.windows(2).all(|pair| pair[0] < pair[1]), "{name}: {light:?}");
    }
}

const VIEWS: [View; 3] = [
    View { yaw_deg: 0.0, pitch_deg: 0.0 },
    View { yaw_deg: 120.0, pitch_deg: 20.0 },
    View { yaw_deg: 240.0, pitch_deg: -30.0 },
];

#[allow(clippy::too_many_arguments)] // as DependentTechnique::new
fn dependent(
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
    let stages = QuiltStages::new(&gpu.context).expect("stages");
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
fn textures_of_views_equal_the_oracle_exactly() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &VIEWS, 512).expect("covered");
    let textures = [noise_strip(180, 90), noise_strip(150, 80)];
    let (_, trajectory) = strip("strip_dark_red.png");
    let paints = textures.each_ref().map(|texture| Paint { texture, trajectory: &trajectory });
    let quilt = QuiltParams { block_px: 64, overlap_px: 8, ..Default::default() };
    let params = DependentParams { quilt, k: Some(0.5), ..Default::default() };
    let technique = dependent(&gpu, &mut runner, &mesh, &covered, (64, 64), &paints, &[0, 1], &params);
    let texels = 512 * 512;
    let mut guides: Vec<Vec<u32>> = Vec::new();
    let per_slice = technique.preparation_parts(u64::MAX).len() / covered.slices.len();
    for (i, part) in technique.preparation_parts(u64::MAX).into_iter().enumerate() {
        if i / per_slice > 1 && i / per_slice + 1 < covered.slices.len() {
            continue; // The first two and the last one will do.
        }
        runner.run(|recorder| technique.record_preparation(recorder, &part, 11)).expect("run");
        if i % per_slice + 1 == per_slice {
            let guide = runner.read_image(technique.guide().expect("a guide")).expect("guide");
            guides.push(bytemuck::pod_collect_to_vec(&guide));
        }
    }
    let got = rgba(&mut runner, technique.slices());
    let window = ImageParams { quilt, k: Some(0.5), levels: false };
    for (guide, slice) in guides.iter().zip([0, 1, covered.slices.len() - 1]) {
        let mut want = vec![[128, 128, 128, 255]; texels];
        for (number, texture) in (1..).zip(&textures) {
            let size = (texture.width(), texture.height());
            let shade: Vec<u8> = guide.iter().map(|texel| *texel as u8).collect();
            let ours: Vec<bool> = guide.iter().map(|texel| texel >> 16 == number).collect();
            let window_px = window.window_px(size.0).expect("a window");
            let oracle_guide = OracleGuide { shade: &shade, covered: &ours, window_px };
            let quilt = QuiltParams { seed: 11 + slice as u32, ..quilt };
            let quilted =
                quilt_oracle(&texture.to_unorm8(), size, (512, 512), &quilt, Some(&oracle_guide)).expect("oracle");
            for ((to, from), texel) in want.iter_mut().zip(&quilted.pixels).zip(guide) {
                if from[3] != 0 && (texel >> 16 == number || texel >> 16 == 0) {
                    *to = *from;
                }
            }
        }
        assert!(guide.iter().filter(|texel| **texel != 0).count() > 500, "slice {slice} shows something");
        assert!(got[slice * texels..(slice + 1) * texels] == want[..], "slice {slice}");
    }
}

#[test]
fn dependent_frames_have_no_gaps_and_move_without_a_jump() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("head.obj");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &default_views(), 512).expect("covered");
    assert_eq!(covered.report.covered + covered.report.forced, mesh.indices().len() / 3);
    let (texture, trajectory) = strip("strip_dark_red.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let params = DependentParams { k: Some(0.25), ..Default::default() };
    let technique = dependent(&gpu, &mut runner, &mesh, &covered, (160, 160), &paints, &[0], &params);
    for part in technique.preparation_parts(400_000_000) {
        runner.run(|recorder| technique.record_preparation(recorder, &part, 1)).expect("run");
    }
    let lights = Lights::default();
    for (yaw_deg, pitch_deg) in [(25.0, 12.0), (100.0, -70.0), (200.0, 40.0), (0.0, 0.0)] {
        let camera =
            Camera::framing(&mesh, &Framing { yaw_deg, pitch_deg, ..Default::default() }, 1.0).expect("a camera");
        let (_, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, &lights, (160, 160));
        runner.run(|recorder| technique.record(recorder, &camera, &lights, Show::Color)).expect("run");
        let want: Vec<[u8; 4]> = shade
            .iter()
            .zip(&id)
            .map(|(shade, id)| {
                let [r, g, b] = trajectory.at(*shade).map(|value| (value * 255.0).round() as u8);
                if *id == 0 {
                    [0; 4]
                } else {
                    [r, g, b, 255]
                }
            })
            .collect();
        let off = share_off(&rgba(&mut runner, technique.frame()), &want, 2);
        assert!(off < 0.003, "{yaw_deg}, {pitch_deg}: {off} of the pixels are off, or missing");
        runner.run(|recorder| technique.record(recorder, &camera, &lights, Show::Texture)).expect("run");
        let frame = rgba(&mut runner, technique.frame());
        let spread = deviation(frame.iter().filter(|p| p[3] == 255).map(|p| f64::from(p[1])));
        // From below most of it is dark, where the strip is quiet.
        assert!(spread > 2.0, "{yaw_deg}, {pitch_deg}: the texture has {spread}");
    }
    // From step to step the texture changes about alike: nothing enters or leaves at once.
    let mut before: Option<Vec<[u8; 4]>> = None;
    let mut changes = Vec::new();
    for step in 0..120 {
        let framing = Framing { yaw_deg: step as f32 * 0.5, distance: Some(4.5), ..Default::default() };
        let camera = Camera::framing(&mesh, &framing, 1.0).expect("a camera");
        runner.run(|recorder| technique.record(recorder, &camera, &lights, Show::Texture)).expect("run");
        let frame = rgba(&mut runner, technique.frame());
        if let Some(before) = before.replace(frame.clone()) {
            let both = before.iter().zip(&frame).filter(|(a, b)| a[3] == 255 && b[3] == 255);
            let sum: f64 = both.clone().map(|(a, b)| f64::from(a[1].abs_diff(b[1]))).sum();
            changes.push(sum / both.count() as f64);
        }
    }
    changes.sort_by(f64::total_cmp);
    let (median, most) = (changes[changes.len() / 2], changes[changes.len() - 1]);
    eprintln!("mean change of a step: median {median:.2}, most {most:.2}");
    assert!(most < 2.0 * median, "a step of {most} among steps of {median}");
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    runner.run(|recorder| technique.record(recorder, &camera, &lights, Show::Painted)).expect("run");
    assert_golden("dependent_head", &rgba(&mut runner, technique.frame()), 160, 0.1);
    // Where one slice has nearly all, as from its own direction, blending is nearly that slice alone.
    let directions: Vec<Vec3> = covered.slices.iter().map(|slice| slice.direction).collect();
    let set = covered.sets.iter().find(|set| set.contains(&0)).expect("a set");
    assert!(blend_weights(&directions, set, directions[0])[0].1 > 0.99);
}

#[test]
fn wrong_use_is_told() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let (texture, trajectory) = strip("strip_dark_red.png");
    let paint = Paint { texture: &texture, trajectory: &trajectory };
    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(&gpu.context).expect("stages");
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
    assert!(view(&[], &[0, 0], &DependentParams::default()).contains("paints is 0"));
    assert!(view(&[paint], &[0, 3], &DependentParams::default()).contains("below the 1 paints"));
}
