//! What the C program must get, by the Rust library on a device of its own; as files that it reads.

use ash::vk;
use impasto::embed::{Composite, Effect, EffectDesc, EffectFrame, EffectPaint, HostDepth, Inputs, Method};
use impasto::embed::{Target, TargetColor};
use impasto::gpu::{Context, ContextOptions, Image, ImageDesc, Runner, Uploads};
use impasto::paint::PaintSample;
use impasto::scene::{
    Camera, DirectionalLight, Framing, GuideImages, GuidePass, HostMotionParams, Lights, Mat4, Mesh, MeshOptions,
    Moment, Pose, Vec3,
};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::repair::RepairParams;
use impasto::technique::aligned::{AlignedFrame, LevelParams};
use impasto::technique::dependent::{DependentParams, View};
use impasto::technique::image::ImageParams;
use impasto::technique::object::ObjectParams;
use impasto::technique::ShadeRange;
use std::path::Path;
use std::sync::Arc;

const SIZE: (u32, u32) = (96, 80);
const QUILT: QuiltParams = QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.1, seed: 1, tileable: false };

struct Scene<'a> {
    folder: &'a Path,
    context: &'a Context,
    runner: Runner,
    mesh: Arc<Mesh>,
    paints: Vec<EffectPaint>,
    view: Mat4,
    projection: Mat4,
    pose: Mat4,
}

/// Writes all files.
pub fn write(assets: &Path, folder: &Path) {
    // Without validation: other tests watch the same, and C's program watches itself.
    let context = Context::new(&ContextOptions::default()).expect("a Vulkan device");
    let mesh = Mesh::load(assets.join("teapot_on_table.obj"), &MeshOptions::default()).expect("a mesh").mesh;
    let strips = ["strip_red_yellow.png", "strip_green_yellow.png"].map(|name| cropped(&assets.join(name), folder));
    let paints = strips.iter().map(|strip| EffectPaint::extract(strip).expect("a paint")).collect();
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let camera = Camera::framing(&mesh, &Framing::default(), aspect).expect("a camera");
    let (view, projection) = (camera.view(), camera.projection(aspect).expect("a projection"));
    let pose = Pose::new(6.0, Vec3::Y, Vec3::ZERO, Vec3::ZERO).expect("a pose").matrix().as_mat4();
    let runner = Runner::new(&context).expect("a runner");
    let mut scene = Scene { folder, context: &context, runner, mesh: Arc::new(mesh), paints, view, projection, pose };
    scene.write_given(&strips[0]);
    let params = ImageParams { quilt: QUILT, ..ImageParams::default() };
    let image = Method::Image { params, carry: Some(RepairParams::default()) };
    let levels = LevelParams { levels: 3, size_px: 64, quilt: QUILT, ..LevelParams::default() };
    let aligned = Method::Aligned { levels, frame: AlignedFrame::default(), follow: true };
    let dependent = Method::Dependent {
        views: vec![View { yaw_deg: 20.0, pitch_deg: 10.0 }, View { yaw_deg: 200.0, pitch_deg: 0.0 }],
        view_px: 512,
        lights: Lights::default(),
        params: DependentParams { quilt: QUILT, ..DependentParams::default() },
    };
    scene.frames("object", Method::Object { params: ObjectParams::default(), range: ShadeRange::default() });
    scene.frames("image", image.clone());
    scene.frames("dependent", dependent);
    let effect = scene.frames("aligned", aligned);
    scene.composite(&effect);
    scene.over_guides(image);
}

/// A part of a strip, as a file too: synthesis from all of it takes long.
fn cropped(path: &Path, folder: &Path) -> PaintSample {
    let file = folder.join(path.file_name().expect("a name"));
    let strip = image::open(path).expect("a strip").into_rgb8();
    image::imageops::resize(&strip, 128, 32, image::imageops::FilterType::Triangle).save(&file).expect("a strip");
    PaintSample::load(file).expect("a strip")
}

/// Numbers as the C program reads them.
fn bytes<T: bytemuck::NoUninit>(values: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(values).to_vec()
}

impl Scene<'_> {
    fn file(&self, name: &str, content: &[u8]) {
        std::fs::write(self.folder.join(name), content).expect("a file");
    }

    /// What the C program gives to the library itself.
    fn write_given(&self, strip: &PaintSample) {
        let mesh = &self.mesh;
        let numbers = [self.view, self.projection, self.pose].map(|matrix| matrix.to_cols_array());
        self.file("matrices", &bytes(numbers.as_flattened()));
        self.file("positions", &bytes(mesh.positions().as_flattened()));
        self.file("normals", &bytes(mesh.normals().as_flattened()));
        self.file("indices", &bytes(mesh.indices()));
        let mut counts = vec![mesh.positions().len() as u32, mesh.indices().len() as u32, mesh.objects().len() as u32];
        counts.extend(mesh.objects().iter().map(|object| object.index_count));
        self.file("counts", &bytes(&counts));
        self.file("strip_size", &bytes(&[strip.width(), strip.height()]));
        let byte = |value: f32| (value * 255.0).round() as u8;
        let pixels = strip.pixels().iter().flat_map(|&[r, g, b]| [byte(r), byte(g), byte(b), 7]);
        self.file("strip", &pixels.collect::<Vec<u8>>());
    }

    fn desc(&self, method: Method) -> EffectDesc {
        let desc = EffectDesc::new(self.mesh.clone(), self.paints[0].clone(), method, SIZE);
        EffectDesc { paints: self.paints.clone(), paint_of_object: vec![0, 1], seed: 3, piece: 2_000_000, ..desc }
    }

    fn moment(&self, turned: bool) -> Moment {
        let camera = Camera::from_matrices(&self.view, &self.projection).expect("a camera");
        let light = |direction, intensity| DirectionalLight::new(direction, intensity).expect("a light");
        let lights = Lights::new([light(Vec3::new(-0.8, 0.5, 0.35), 1.0), light(Vec3::ONE, 0.25)]).expect("lights");
        let pose = Pose::from_matrix(&self.pose).expect("a pose");
        Moment { camera, lights, poses: if turned { vec![pose] } else { Vec::new() } }
    }

    fn prepared(&mut self, desc: EffectDesc) -> Effect {
        let mut effect = Effect::new(self.context, desc).expect("an effect");
        while !effect.progress().ready {
            self.runner.run(|recorder| effect.prepare(recorder)).expect("a preparation");
        }
        effect
    }

    fn record(&mut self, effect: &mut Effect, moment: &Moment, name: &str) {
        let frame = EffectFrame { seed: 5, ..EffectFrame::next(moment) };
        self.runner.run(|recorder| effect.record(recorder, &frame)).expect("a frame");
        let picture = self.runner.read_image(effect.picture().expect("a picture")).expect("its bytes");
        assert!(picture.chunks(4).filter(|pixel| pixel[3] == 255).count() > 1000, "{name}: hardly anything is painted");
        self.file(name, &picture);
    }

    /// Two frames, in the second of which an object has turned.
    fn frames(&mut self, name: &str, method: Method) -> Effect {
        let mut effect = self.prepared(self.desc(method));
        for (number, turned) in [false, true].into_iter().enumerate() {
            let moment = self.moment(turned);
            self.record(&mut effect, &moment, &format!("{name}.{number}"));
        }
        effect
    }

    /// An image that holds these texels.
    fn image(&mut self, format: vk::Format, usage: vk::ImageUsageFlags, texels: &[u8]) -> Image {
        let usage = usage | vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
        let desc = ImageDesc { size_px: [SIZE.0, SIZE.1, 1], format, usage };
        let image = Image::new(self.context, "input", &desc).expect("an image");
        let mut uploads = Uploads::default();
        uploads.image(self.context, &image, texels).expect("an upload");
        let uploaded = self.runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        });
        uploaded.expect("an upload");
        image
    }

    /// The last frame over an image, behind a wall in its left half.
    fn composite(&mut self, effect: &Effect) {
        use vk::ImageUsageFlags as U;
        let camera = effect.camera().expect("a camera");
        let depth = HostDepth::from_projection(&self.projection).expect("a perspective");
        let wall = depth.a + depth.b / (0.5 * (camera.near() + camera.far()));
        let texels = SIZE.0 * SIZE.1;
        let under: Vec<u8> = (0..texels).flat_map(|i| [60, (i % 251) as u8, 80, 255]).collect();
        let under_depth: Vec<f32> = (0..texels).map(|i| if i % SIZE.0 < SIZE.0 / 2 { wall } else { 1.0 }).collect();
        let color = self.image(vk::Format::R8G8B8A8_UNORM, U::COLOR_ATTACHMENT, &under);
        let target_depth = self.image(vk::Format::D32_SFLOAT, U::DEPTH_STENCIL_ATTACHMENT, &bytes(&under_depth));
        let target = Target { color: color.clone(), depth: Some(target_depth) };
        let composite = Composite::new(effect, &[target], TargetColor::ByFormat, false).expect("a composite");
        self.runner.run(|recorder| composite.record(recorder, effect, 0, (0, 0), &depth)).expect("a frame");
        let laid = self.runner.read_image(&color).expect("its bytes");
        assert!(laid != under && laid.chunks(4).zip(under.chunks(4)).any(|(a, b)| a == b));
        self.file("under", &under);
        self.file("under_depth", &bytes(&under_depth));
        self.file("composite", &laid);
    }

    /// Two frames over guides, without any motion.
    fn over_guides(&mut self, method: Method) {
        use vk::ImageUsageFlags as U;
        let (moment, mut uploads) = (self.moment(false), Uploads::default());
        let pass = GuidePass::new(self.context, &mut uploads, &self.mesh, SIZE).expect("guides");
        let drawn = self.runner.run(|recorder| {
            uploads.record(recorder);
            pass.record(recorder, &moment)
        });
        drawn.expect("guides");
        let mut guides = Vec::new();
        let depth_usage = U::DEPTH_STENCIL_ATTACHMENT | U::SAMPLED;
        for (name, image, usage) in
            [("shade", pass.shade(), U::STORAGE), ("id", pass.id(), U::STORAGE), ("depth", pass.depth(), depth_usage)]
        {
            let texels = self.runner.read_image(image).expect("its bytes");
            self.file(name, &texels);
            guides.push(self.image(image.format(), usage, &texels));
        }
        let none = vec![0; (SIZE.0 * SIZE.1 * 4) as usize];
        self.file("vectors", &none);
        let vectors = self.image(vk::Format::R16G16_SFLOAT, U::SAMPLED, &none);
        let guides = GuideImages::new(&guides[0], &guides[1], &guides[2], pass.object_count()).expect("guides");
        let inputs = Inputs { guides: Some(guides), vectors: Some((vectors, HostMotionParams::default())) };
        let mut effect = self.prepared(EffectDesc { inputs, ..self.desc(method) });
        for number in 0..2 {
            self.record(&mut effect, &moment, &format!("over_guides.{number}"));
        }
    }
}
