//! The guide pass, the image-based technique and mask tiling against their oracles.

mod common;

use common::{data_dir, noise, Validated};
use impasto::gpu::{Runner, Uploads};
use impasto::paint::{ColorStop, PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, Framing, Guide, GuideOracle, GuidePass, Lights, Mesh, MeshOptions, Moment, Pose, Vec3};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{PreviousWeight, QuiltStages};
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide};
use impasto::synthesis::tile_mask::TileMask;
use impasto::synthesis::tile_oracle::tile_oracle;
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::{Paint, ShadeRange, Show};

/// Two boxes, the second one behind and above the first.
const BOXES: &str = "
o near\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 -2\nv 1 -1 -2\nv 1 1 -2\nv -1 1 -2
f 1 2 3 4\nf 6 5 8 7\nf 2 6 7 3\nf 5 1 4 8\nf 4 3 7 8\nf 5 6 2 1
o far\nv 0 0 -4\nv 3 0 -4\nv 3 3 -4\nv 0 3 -4\nf 9 10 11 12\n";

fn load(bytes: &[u8]) -> Mesh {
    Mesh::parse(bytes, "test", &MeshOptions::default()).expect("a mesh").mesh
}

fn builtin(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)).expect("an asset")
}

fn strip(name: &str) -> (TextureDifference, Trajectory) {
    let sample = PaintSample::decode(&builtin(name), name.as_ref()).expect("a strip");
    let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default()).expect("a trajectory");
    (TextureDifference::extract(&sample, &trajectory), trajectory)
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytemuck::pod_collect_to_vec(bytes)
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(bytes)
}

/// Draws the guides on the GPU.
fn guides(gpu: &Validated, runner: &mut Runner, mesh: &Mesh, moment: &Moment, size: (u32, u32)) -> (GuidePass, Guide) {
    let mut uploads = Uploads::default();
    let pass = GuidePass::new(&gpu.context, &mut uploads, mesh, size).expect("a guide pass");
    runner
        .run(|recorder| {
            uploads.record(recorder);
            pass.record(recorder, moment)
        })
        .expect("run");
    let guide = Guide {
        width: size.0,
        height: size.1,
        shade: floats(&runner.read_image(pass.shade()).expect("shade")),
        id: words(&runner.read_image(pass.id()).expect("id")),
        depth: floats(&runner.read_image(pass.depth()).expect("depth")),
    };
    (pass, guide)
}

/// Every object but the last turned and moved in a way of its own.
fn poses(mesh: &Mesh) -> Vec<Pose> {
    let sphere = mesh.bounding_sphere();
    let pose = |i: usize| {
        let (i, step) = (i as f32, 0.1 * sphere.radius);
        Pose::new(40.0 + 25.0 * i, Vec3::new(0.3, 1.0, 0.2 * i), sphere.center, step * Vec3::new(1.0 - i, 0.5, i))
    };
    (0..mesh.objects().len().max(2) - 1).map(|i| pose(i).expect("a pose")).collect()
}

/// The share of pixels whose object differs, and the largest differences of shade and depth where it does not.
fn compare(a: &Guide, b: &Guide) -> (f64, f32, f32) {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let mut other = 0usize;
    let (mut shade, mut depth) = (Vec::new(), 0f32);
    for i in 0..a.id.len() {
        if a.id[i] != b.id[i] {
            other += 1;
        } else {
            shade.push((a.shade[i] - b.shade[i]).abs());
            depth = depth.max((a.depth[i] - b.depth[i]).abs());
        }
    }
    // Where two faces meet, rounding of a corner's place may show the one or the other.
    shade.sort_by(f32::total_cmp);
    let most = shade.get(shade.len() * 998 / 1000).copied().unwrap_or_default();
    (other as f64 / a.id.len() as f64, most, depth)
}

#[test]
fn guide_pass_equals_the_oracle() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let models = [BOXES.as_bytes().to_vec(), builtin("head.obj"), builtin("teapot_on_table.obj")];
    for (model, size) in models.iter().flat_map(|model| [(model, (160, 120)), (model, (97, 131))]) {
        let mesh = load(model);
        let aspect = size.0 as f32 / size.1 as f32;
        let camera = Camera::framing(&mesh, &Framing::default(), aspect).expect("a camera");
        let at_rest = Moment::at_rest(camera, Lights::default());
        let apart = Moment { poses: poses(&mesh), ..at_rest.clone() }.fit_depth(&mesh);
        let wanted = [&at_rest, &apart].map(|m| GuideOracle::render(&mesh, m, size.0, size.1).expect("oracle"));
        assert!(compare(&wanted[0], &wanted[1]).0 > 0.01, "the objects have moved");
        for (moment, want) in [at_rest, apart].iter().zip(&wanted) {
            let (_, got) = guides(&gpu, &mut runner, &mesh, moment, size);
            let (other, shade, depth) = compare(&got, want);
            eprintln!("{size:?}: {other:.5} other objects, shade {shade:.5}, depth {depth:.6}");
            assert!(other < 0.001, "{other} of the pixels show another object");
            assert!(shade < 0.002, "shade differs by {shade}");
            assert!(depth < 0.002, "depth differs by {depth}");
            // The comparison itself must notice a wrong light.
            let wrong = Guide { shade: got.shade.iter().map(|s| 1.0 - s).collect(), ..got };
            assert!(compare(&wrong, want).1 > 0.1);
        }
    }
}

/// Compares with tests/golden/NAME.png, a picture looked at by a person; IMPASTO_BLESS=1 writes it anew.
fn assert_golden(name: &str, pixels: &[[u8; 4]], size: (u32, u32), shares_off: f64) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"));
    if std::env::var_os("IMPASTO_BLESS").is_some() {
        let picture = image::RgbaImage::from_raw(size.0, size.1, pixels.concat()).expect("a picture");
        picture.save(&path).expect("a golden picture written");
    }
    let golden = image::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).to_rgba8();
    assert_eq!(golden.dimensions(), size, "{name}");
    let off = golden.pixels().zip(pixels).filter(|(a, b)| a.0.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 3));
    let share = off.count() as f64 / pixels.len() as f64;
    assert!(share <= shares_off, "{name}: {share:.4} of the pixels are off");
}

#[test]
fn pictures_equal_the_golden_ones() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let size = (72, 72);
    for model in ["head", "teapot_on_table"] {
        let mesh = load(&builtin(&format!("{model}.obj")));
        let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
        let (pass, guide) = guides(&gpu, &mut runner, &mesh, &Moment::at_rest(camera, Lights::default()), size);
        let shade: Vec<[u8; 4]> = guide
            .shade
            .iter()
            .zip(&guide.id)
            .map(|(s, &id)| [(s * 255.0 + 0.5) as u8, 60 * id as u8, 0, 255])
            .collect();
        assert_golden(&format!("guide_{model}"), &shade, size, 0.005);
        let (texture, trajectory) = strip("strip_red_yellow.png");
        let mut uploads = Uploads::default();
        let stages = QuiltStages::new(&gpu.context);
        let paints = [Paint { texture: &texture, trajectory: &trajectory }];
        let objects = vec![0; mesh.objects().len()];
        let quilt = QuiltParams { block_px: 16, overlap_px: 4, ..Default::default() };
        let params = ImageParams { quilt, ..Default::default() };
        let technique =
            ImageTechnique::new(&gpu.context, &mut uploads, &stages, &pass, &paints, &objects, &params).expect("new");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                technique.record(recorder, 1, 0);
                Ok(())
            })
            .expect("run");
        let frame: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(technique.frame()).expect("frame"));
        // A pixel of the guide that rounds the other way may change a block's choice, and with it that block.
        assert_golden(&format!("painted_{model}"), &frame, size, 0.1);
        let mut planted = frame.clone();
        planted.iter_mut().for_each(|pixel| pixel[0] = 255 - pixel[0]);
        if std::env::var_os("IMPASTO_BLESS").is_none() {
            let caught = std::panic::catch_unwind(|| assert_golden(&format!("painted_{model}"), &planted, size, 0.1));
            assert!(caught.is_err(), "a wrong picture must be noticed");
        }
    }
}

/// Normals that cancel between the corners of a face must not become a shade that is no number.
#[test]
fn normals_that_cancel_face_no_light() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nvn 0 0 -1\nf 1//1 2//2 3//2 4//1\n";
    let mesh = load(quad.as_bytes());
    let camera = Camera::framing(&mesh, &Framing { yaw_deg: 0.0, pitch_deg: 0.0, ..Default::default() }, 1.0);
    let (_, guide) =
        guides(&gpu, &mut runner, &mesh, &Moment::at_rest(camera.expect("a camera"), Lights::default()), (65, 65));
    assert!(guide.shade.iter().all(|shade| (0.0..=1.0).contains(shade)), "a shade is out of range");
    let middle = guide.shade[32 * 65 + 32];
    assert!((middle - 0.5).abs() < 0.2, "the middle's shade is {middle}");
}

#[test]
fn wrong_use_is_told() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = load(BOXES.as_bytes());
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let (pass, _) = guides(&gpu, &mut runner, &mesh, &Moment::at_rest(camera, Lights::default()), (40, 40));
    let (texture, trajectory) = strip("strip_dark_red.png");
    let paint = Paint { texture: &texture, trajectory: &trajectory };
    let stages = QuiltStages::new(&gpu.context);
    let prepare = |paints: &[Paint<'_>], objects: &[u32], params: ImageParams| {
        let mut uploads = Uploads::default();
        ImageTechnique::new(&gpu.context, &mut uploads, &stages, &pass, paints, objects, &params)
            .map(|_| ())
            .map_err(|e| e.to_string())
            .expect_err("must be refused")
    };
    let plain = ImageParams::default();
    assert!(prepare(&[], &[], plain).contains("paints"));
    assert!(prepare(&[paint], &[0], plain).contains("2 objects"), "an object without a paint");
    assert!(prepare(&[paint], &[0, 1], plain).contains("below the 1 paints"));
    assert!(prepare(&[paint], &[0, 0], ImageParams { k: Some(-1.0), ..plain }).contains("k is -1"));
    let tileable = QuiltParams { tileable: true, ..Default::default() };
    assert!(prepare(&[paint], &[0, 0], ImageParams { quilt: tileable, ..plain }).contains("tileable"));
}

/// A recording that fails half-way is run as far as it went, and the runner goes on.
#[test]
fn a_failed_recording_leaves_resources_as_they_remember() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = load(BOXES.as_bytes());
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let mut uploads = Uploads::default();
    let pass = GuidePass::new(&gpu.context, &mut uploads, &mesh, (40, 40)).expect("a guide pass");
    let failed: impasto::Result<()> = runner.run(|recorder| {
        uploads.record(recorder);
        Err(impasto::Error::parameter("test", 1, "2"))
    });
    assert!(failed.is_err());
    runner.run(|recorder| pass.record(recorder, &Moment::at_rest(camera, Lights::default()))).expect("run");
    let ids = words(&runner.read_image(pass.id()).expect("id"));
    assert!(ids.iter().filter(|&&id| id == 1).count() > 100, "the uploaded mesh is there");
}

/// One frame from the GPU's own guides, by the plain oracles.
struct OracleFrame {
    tone: Vec<f32>,
    pixels: Vec<[u8; 4]>,
}

fn oracle_frame(
    guide: &Guide,
    paints: &[Paint<'_>],
    paint_of_object: &[u32],
    params: &ImageParams,
    levels: bool,
) -> OracleFrame {
    let mut tone = guide.shade.clone();
    let covered: Vec<bool> = guide.id.iter().map(|&id| id != 0).collect();
    if levels {
        let mut bins: Vec<u32> =
            tone.iter().zip(&covered).filter(|(_, c)| **c).map(|(s, _)| (s * 1023.0 + 0.5) as u32).collect();
        bins.sort_unstable();
        let cut = bins.len() / 200;
        let (low, high) = (bins[cut] as f32 / 1023.0, bins[bins.len() - 1 - cut] as f32 / 1023.0);
        for s in &mut tone {
            *s = ((*s - low) / (high - low)).clamp(0.0, 1.0);
        }
    }
    let shade: Vec<u8> = tone.iter().map(|s| (s * 255.0 + 0.5) as u8).collect();
    let mut pixels = vec![[0u8; 4]; tone.len()];
    for (number, paint) in paints.iter().enumerate() {
        let mine: Vec<bool> =
            guide.id.iter().map(|&id| id != 0 && paint_of_object[id as usize - 1] as usize == number).collect();
        let size = (paint.texture.width(), paint.texture.height());
        let oracle_guide =
            OracleGuide { shade: &shade, covered: &mine, window_px: params.window_px(size.0).expect("k in range") };
        let texels = paint.texture.to_unorm8();
        let quilted = quilt_oracle(&texels, size, (guide.width, guide.height), &params.quilt, Some(&oracle_guide))
            .expect("oracle");
        for i in 0..tone.len() {
            if let (true, Some((x, y))) = (mine[i], quilted.source[i]) {
                let color = paint.trajectory.at(tone[i]);
                let difference = paint.texture.pixel(u32::from(x), u32::from(y));
                let value = |c: usize| ((color[c] + difference[c]).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                pixels[i] = [value(0), value(1), value(2), 255];
            }
        }
    }
    OracleFrame { tone, pixels }
}

fn largest_difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> u8 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).flat_map(|(a, b)| (0..4).map(move |c| a[c].abs_diff(b[c]))).max().unwrap_or_default()
}

#[test]
fn image_technique_equals_the_oracle() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = load(&builtin("teapot_on_table.obj"));
    let size = (200, 150);
    let camera = Camera::framing(&mesh, &Framing::default(), 200.0 / 150.0).expect("a camera");
    let (pass, guide) = guides(&gpu, &mut runner, &mesh, &Moment::at_rest(camera, Lights::default()), size);
    let strips = [strip("strip_green_yellow.png"), strip("strip_dark_red.png")];
    let paints: Vec<Paint<'_>> = strips.iter().map(|(texture, trajectory)| Paint { texture, trajectory }).collect();
    for levels in [false, true] {
        let quilt = QuiltParams { block_px: 16, overlap_px: 4, seed: 5, ..Default::default() };
        let range = if levels { ShadeRange::of_guide(&guide.shade, &guide.id) } else { ShadeRange::default() };
        let params = ImageParams { quilt, k: Some(1.5), range, previous: None };
        let mut uploads = Uploads::default();
        let stages = QuiltStages::new(&gpu.context);
        let mut technique = ImageTechnique::new(&gpu.context, &mut uploads, &stages, &pass, &paints, &[0, 1], &params)
            .expect("a technique");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                technique.record(recorder, 5, 0);
                Ok(())
            })
            .expect("run");
        let want = oracle_frame(&guide, &paints, &[0, 1], &params, levels);
        let tone = floats(&runner.read_image(technique.shade()).expect("tone"));
        let off = tone.iter().zip(&want.tone).zip(&guide.id).filter(|(_, id)| **id != 0);
        assert!(off.clone().count() > 3000);
        assert!(off.map(|((a, b), _)| (a - b).abs()).fold(0.0, f32::max) < 1e-5);
        let got: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(technique.frame()).expect("frame"));
        let worst = largest_difference(&got, &want.pixels);
        assert!(worst <= 1, "levels {levels}: frames differ by {worst}");
        let mut planted = got.clone();
        planted[size.0 as usize * 75 + 100][1] ^= 0x40;
        assert!(largest_difference(&planted, &want.pixels) > 1);

        // Colour and texture add up to the painted frame; another gradient changes colours alone.
        let mut show = |show| {
            runner
                .run(|recorder| {
                    technique.record_recombine(recorder, show);
                    Ok(())
                })
                .expect("run");
            bytemuck::pod_collect_to_vec::<u8, [u8; 4]>(&runner.read_image(technique.frame()).expect("frame"))
        };
        let (color, texture) = (show(Show::Color), show(Show::Texture));
        for i in 0..got.len() {
            for c in 0..3 {
                let sum = i32::from(color[i][c]) + 2 * i32::from(texture[i][c]) - 255;
                let sum = if got[i][3] == 0 { 0 } else { sum.clamp(0, 255) };
                assert!((i32::from(got[i][c]) - sum).abs() <= 3, "pixel {i} channel {c}");
            }
        }
        let blues = ColorStop::parse_list("0:#000000,1:#0000ff").expect("stops");
        let gradient = Trajectory::from_stops(&blues, 64).expect("a gradient");
        let mut uploads = Uploads::default();
        technique.set_trajectory(&gpu.context, &mut uploads, 0, &gradient).expect("set");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                technique.record_recombine(recorder, Show::Color);
                Ok(())
            })
            .expect("run");
        let blue: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(technique.frame()).expect("frame"));
        for ((pixel, id), tone) in blue.iter().zip(&guide.id).zip(&want.tone) {
            if *id == 1 {
                assert_eq!((pixel[0], pixel[1]), (0, 0));
                assert!((f32::from(pixel[2]) - tone * 255.0).abs() <= 1.0);
            }
        }
        assert!(blue.iter().zip(&guide.id).any(|(pixel, id)| *id == 2 && pixel[0] > 0), "the table keeps its red");
    }
}

#[test]
fn a_frame_between_two_textures_equals_the_oracle() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = load(&builtin("teapot_on_table.obj"));
    let size = (120, 90);
    let (texture, trajectory) = strip("strip_green_yellow.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let moment = |yaw_deg| {
        let framing = Framing { yaw_deg, ..Framing::default() };
        Moment::at_rest(Camera::framing(&mesh, &framing, 120.0 / 90.0).expect("a camera"), Lights::default())
    };
    let mut uploads = Uploads::default();
    let guides = GuidePass::new(&gpu.context, &mut uploads, &mesh, size).expect("a guide pass");
    let stages = QuiltStages::new(&gpu.context);
    let quilt = QuiltParams { block_px: 16, overlap_px: 4, ..Default::default() };
    let params = ImageParams { quilt, previous: Some(PreviousWeight(1.0)), ..Default::default() };
    let technique = ImageTechnique::new(&gpu.context, &mut uploads, &stages, &guides, &paints, &[0, 0], &params)
        .expect("a technique");
    runner
        .run(|recorder| {
            uploads.record(recorder);
            assert!(technique.record_blend(recorder, 1.5, Show::Painted).is_err(), "a blend out of range");
            Ok(())
        })
        .expect("run");
    // Two textures from either side, and a frame between, which shows what neither has.
    let canvases = [(0, 15.0), (1, 35.0)].map(|(number, yaw)| {
        runner
            .run(|recorder| {
                guides.record(recorder, &moment(yaw))?;
                technique.record(recorder, 3, number);
                Ok(())
            })
            .expect("run");
        let quilt = technique.quilts().next().expect("a quilting");
        let texels: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(quilt.canvas()).expect("canvas"));
        texels
    });
    for blend in [0.0, 0.25, 1.0] {
        runner
            .run(|recorder| {
                guides.record(recorder, &moment(20.0))?;
                technique.record_guide(recorder);
                technique.record_blend(recorder, blend, Show::Painted)
            })
            .expect("run");
        let tone = floats(&runner.read_image(technique.shade()).expect("tone"));
        let id = words(&runner.read_image(guides.id()).expect("id"));
        let got: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(technique.frame()).expect("frame"));
        let mut kinds = [0; 4];
        let want: Vec<[u8; 4]> = (0..got.len())
            .map(|i| {
                let (a, b) = (canvases[0][i], canvases[1][i]);
                let (there, blend) = ([a[3] != 0, b[3] != 0], f64::from(blend));
                let weights = match there {
                    [true, true] if a == b => [1.0, 0.0],
                    [true, true] => [1.0 - blend, blend],
                    [first, second] => [f64::from(u8::from(first)), f64::from(u8::from(second))],
                };
                let kept = weights.iter().map(|w| w * w).sum::<f64>().sqrt().max(1e-9);
                let color = trajectory.at(tone[i]);
                let value = |c: usize| {
                    let difference = |texel: [u8; 4]| 2.0 * f64::from(texel[c]) / 255.0 - 1.0;
                    let blended = (weights[0] * difference(a) + weights[1] * difference(b)) / kept;
                    ((f64::from(color[c]) + blended).clamp(0.0, 1.0) * 255.0).round() as u8
                };
                if id[i] == 0 {
                    return [0; 4];
                }
                kinds[usize::from(there[0]) + 2 * usize::from(there[1])] += 1;
                [value(0), value(1), value(2), 255]
            })
            .collect();
        assert!(kinds[3] > 1000 && kinds[1] + kinds[2] > 10, "what there is: {kinds:?}");
        let worst = largest_difference(&got, &want);
        assert!(worst <= 2, "blend {blend}: frames differ by {worst}");
    }
}

#[test]
fn real_models_and_paint_give_the_oracles_frame() {
    let Some(data) = data_dir() else { return };
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    for (model, paint) in
        [("skull_low.obj", "scan_graphite_400x144.png"), ("spot.obj", "scan_pencil_red_yellow_232x128.png")]
    {
        let mesh = Mesh::load(data.join("models").join(model), &MeshOptions::default()).expect("a model").mesh;
        let sample = PaintSample::load(data.join("paint").join(paint)).expect("a strip");
        let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default()).expect("a trajectory");
        let texture = TextureDifference::extract(&sample, &trajectory);
        let paints = [Paint { texture: &texture, trajectory: &trajectory }];
        let size = (128, 128);
        let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
        let (pass, guide) = guides(&gpu, &mut runner, &mesh, &Moment::at_rest(camera, Lights::default()), size);
        let params = ImageParams::default();
        let mut uploads = Uploads::default();
        let stages = QuiltStages::new(&gpu.context);
        let objects = vec![0; mesh.objects().len()];
        let technique =
            ImageTechnique::new(&gpu.context, &mut uploads, &stages, &pass, &paints, &objects, &params).expect("new");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                technique.record(recorder, params.quilt.seed, 0);
                Ok(())
            })
            .expect("run");
        let got: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(technique.frame()).expect("frame"));
        let want = oracle_frame(&guide, &paints, &objects, &params, false);
        assert!(largest_difference(&got, &want.pixels) <= 1, "{model} with {paint}");
    }
}

#[test]
fn mask_tiling_equals_the_oracle() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    for size in [(64, 64), (37, 53), (1, 1), (2, 3), (130, 20)] {
        let pixels = noise(size.0, size.1, size.0 * 3 + size.1);
        let mut uploads = Uploads::default();
        let tile = TileMask::new(&gpu.context, &mut uploads, &pixels, size).expect("tile");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                tile.record(recorder);
                Ok(())
            })
            .expect("run");
        let got: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&runner.read_image(tile.image()).expect("image"));
        assert!(got == tile_oracle(&pixels, size), "{size:?}");
    }
}
