//! The library inside a host that it knows nothing of: the host's device, queue and command buffers, its own
//! submissions and waits, and its own copies of what was made.

mod common;
mod host;

use ash::vk;
use common::{noise, Numbers, Validated};
use host::{calls, Host, HostImage};
use impasto::gpu::{
    Buffer, BufferKind, Context, HostDevice, Image, ImageDesc, Recorder, ResourceState, Runner, Uploads,
};
use impasto::paint::{TextureDifference, Trajectory};
use impasto::scene::{
    Camera, Framing, GuideImages, GuidePass, HostMotion, HostMotionParams, Lights, Mesh, MeshOptions, Moment,
    MotionPass, Pose, Vec3,
};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Quilt, QuiltGuide, QuiltStages, SampleTexels};
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide};
use impasto::synthesis::repair::RepairParams;
use impasto::technique::aligned::{AlignedFrame, AlignedTechnique, LevelParams, LevelSource, LevelVolume};
use impasto::technique::dependent::{DependentParams, DependentTechnique, View, ViewCoverage};
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::object::{ObjectParams, ObjectTechnique};
use impasto::technique::{Paint, ShadeRange, Show};

const SAMPLE: (u32, u32) = (64, 40);
const OUTPUT: (u32, u32) = (90, 70);
const PARAMS: QuiltParams = QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.1, seed: 5, tileable: false };
const PAINT: u32 = 2;
const WINDOW_PX: u32 = 12;

fn sample() -> Vec<[u8; 4]> {
    noise(SAMPLE.0, SAMPLE.1, 21)
}

/// Shade from left to right, a hole, and another paint in a corner.
fn guide_texels() -> Vec<u32> {
    let mut numbers = Numbers(77);
    let texel = |i: u32| {
        let (x, y) = (i % OUTPUT.0, i / OUTPUT.0);
        let paint = match (x, y) {
            (30..60, 20..60) => 0,
            (70.., 50..) => 1,
            _ => PAINT,
        };
        (x * 230 / OUTPUT.0 + numbers.next() % 20) | paint << 16
    };
    (0..OUTPUT.0 * OUTPUT.1).map(texel).collect()
}

/// The canvas by the oracle.
fn oracle(guided: bool) -> Vec<u8> {
    let texels = guide_texels();
    let shade: Vec<u8> = texels.iter().map(|t| *t as u8).collect();
    let covered: Vec<bool> = texels.iter().map(|t| t >> 16 == PAINT).collect();
    let guide = OracleGuide { shade: &shade, covered: &covered, window_px: WINDOW_PX };
    let quilted = quilt_oracle(&sample(), SAMPLE, OUTPUT, &PARAMS, guided.then_some(&guide)).expect("oracle");
    quilted.pixels.into_flattened()
}

/// The canvas by the library's own runner on a device of its own.
fn by_runner(guided: bool) -> Vec<u8> {
    let gpu = Validated::new();
    let mut uploads = Uploads::default();
    let guide = guided.then(|| {
        let desc = ImageDesc::storage_2d(OUTPUT.0, OUTPUT.1, vk::Format::R32_UINT);
        let image = Image::new(&gpu.context, "guide", &desc).expect("guide");
        uploads.image(&gpu.context, &image, bytemuck::cast_slice(&guide_texels())).expect("guide");
        QuiltGuide { image, paint: PAINT, window_px: WINDOW_PX, previous: None }
    });
    let quilt = quilting(&gpu.context, &mut uploads, guide);
    let mut runner = gpu.runner();
    runner
        .run(|recorder| {
            uploads.record(recorder);
            quilt.record(recorder, PARAMS.seed, 0);
            Ok(())
        })
        .expect("run");
    runner.read_image(quilt.canvas()).expect("canvas")
}

fn quilting(context: &Context, uploads: &mut Uploads, guide: Option<QuiltGuide>) -> Quilt {
    let stages = QuiltStages::new(context);
    let texels = SampleTexels::new(context, uploads, &sample(), SAMPLE).expect("sample");
    Quilt::new(context, uploads, &stages, &texels, OUTPUT, &PARAMS, guide).expect("quilt")
}

/// A context on the host's device.
fn borrow(device: HostDevice) -> Context {
    // SAFETY: the tests drop the context before the host's device, when all work is done.
    unsafe { Context::from_host(device) }.expect("a context")
}

/// A recorder into a command buffer of the host's.
fn recorder(context: &Context, commands: vk::CommandBuffer) -> Recorder<'_> {
    // SAFETY: the host's command buffers are begun, submitted in order and waited for.
    unsafe { Recorder::new(context, commands, None) }
}

/// How [`Host::write_image`] leaves an image.
fn written() -> ResourceState {
    ResourceState::from_host(
        vk::PipelineStageFlags::TRANSFER,
        vk::AccessFlags::TRANSFER_WRITE,
        vk::ImageLayout::TRANSFER_DST_OPTIMAL,
    )
}

/// The host's image as the library sees it: just written.
fn wrapped(context: &Context, image: &HostImage) -> Image {
    let desc = ImageDesc { size_px: [image.size.0, image.size.1, 1], format: image.format, usage: image.usage };
    // SAFETY: the host's image outlives the context, and was left in this state.
    unsafe { Image::from_host(context, image.image, image.view, &desc, written()) }
}

fn assert_silent(messages: &[String]) {
    assert!(messages.is_empty(), "validation: {}", messages.join("\n"));
}

/// Quilts in the host's command buffer; the canvas by the host's own copy.
fn by_host(host: &Host, device: HostDevice, guide: Option<&HostImage>) -> Vec<u8> {
    let context = borrow(device);
    let mut uploads = Uploads::default();
    let guide = guide.map(|image| QuiltGuide {
        image: wrapped(&context, image),
        paint: PAINT,
        window_px: WINDOW_PX,
        previous: None,
    });
    let quilt = quilting(&context, &mut uploads, guide);
    host.run(|commands| {
        let mut recorder = recorder(&context, commands);
        uploads.record(&mut recorder);
        quilt.record(&mut recorder, PARAMS.seed, 0);
    });
    assert_eq!(quilt.canvas().layout(), vk::ImageLayout::GENERAL);
    host.read_image(quilt.canvas().handle(), quilt.canvas().layout(), OUTPUT)
}

#[test]
fn a_foreign_host_gets_the_same_bytes() {
    let host = Host::new();
    let free = oracle(false);
    assert!(by_runner(false) == free, "the runner's canvas is not the oracle's");
    assert!(by_host(&host, host.lent(), None) == free, "the host's canvas is not the oracle's");
    assert!(by_host(&host, host.lent_raw(), None) == free, "the canvas through raw handles is not the oracle's");
    assert_silent(&host.destroy());
}

#[test]
fn a_foreign_host_guides_with_an_image_of_its_own() {
    let host = Host::new();
    let texels = guide_texels();
    let guided = oracle(true);
    assert!(guided.chunks(4).any(|p| p[3] == 0) && guided.chunks(4).any(|p| p[3] == 255));
    assert!(by_runner(true) == guided, "the runner's canvas is not the oracle's");
    for device in [host.lent(), host.lent_raw()] {
        let guide = host.image(vk::Format::R32_UINT, host::usage(), OUTPUT);
        host.write_image(&guide, bytemuck::cast_slice(&texels));
        assert!(by_host(&host, device, Some(&guide)) == guided, "the host's canvas is not the oracle's");
        // The context is gone; the host's image is still there, in the layout that reading shaders want.
        let left = host.read_image(guide.image, vk::ImageLayout::GENERAL, OUTPUT);
        assert_eq!(bytemuck::pod_collect_to_vec::<u8, u32>(&left), texels);
        host.destroy_image(guide);
    }
    assert_silent(&host.destroy());
}

/// What is recorded for a frame of guides: shade and object of each pixel.
fn guide_pass(context: &Context, uploads: &mut Uploads) -> (GuidePass, Moment) {
    let asset = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/head.obj");
    let mesh = Mesh::load(asset, &MeshOptions::default()).expect("a mesh").mesh;
    let camera = Camera::framing(&mesh, &Framing::default(), 9.0 / 7.0).expect("a camera");
    (GuidePass::new(context, uploads, &mesh, OUTPUT).expect("a guide pass"), Moment::at_rest(camera, Lights::default()))
}

#[test]
fn a_foreign_host_draws_the_same_guides() {
    let host = Host::new();
    let gpu = Validated::new();
    let mut uploads = Uploads::default();
    let (pass, moment) = guide_pass(&gpu.context, &mut uploads);
    let mut runner = gpu.runner();
    let drawn = runner.run(|recorder| {
        uploads.record(recorder);
        pass.record(recorder, &moment)
    });
    drawn.expect("run");
    let mut expected = |image: &Image| runner.read_image(image).expect("an image");
    let expected = [expected(pass.shade()), expected(pass.id())];
    assert!(expected[1].chunks(4).filter(|id| id[0] == 1).count() > 500, "hardly anything was drawn");
    for device in [host.lent(), host.lent_raw()] {
        let context = borrow(device);
        let mut uploads = Uploads::default();
        let (pass, moment) = guide_pass(&context, &mut uploads);
        host.run(|commands| {
            let mut recorder = recorder(&context, commands);
            uploads.record(&mut recorder);
            pass.record(&mut recorder, &moment).expect("a picture's shape");
        });
        for (image, expected) in [pass.shade(), pass.id()].into_iter().zip(&expected) {
            assert!(&host.read_image(image.handle(), image.layout(), OUTPUT) == expected);
        }
    }
    assert_silent(&host.destroy());
}

/// What the library asks for is what the host's device was made with: nothing but a queue that draws and computes.
#[test]
fn a_host_knows_what_is_needed_before_it_makes_its_device() {
    let host = Host::new();
    let needs = impasto::gpu::requirements();
    assert_eq!(needs.api_version, vk::API_VERSION_1_1);
    assert!(needs.instance_extensions.is_empty() && needs.device_extensions.is_empty());
    assert!(!format!("{:?}", needs.features).contains(": 1"), "a feature is needed: {:?}", needs.features);
    // SAFETY: the host's instance is live, and so is its device.
    let check = |family| unsafe { needs.check(&host.instance, host.physical, family) };
    check(host.family).expect("the host's device");
    let error = check(99).expect_err("no such family").to_string();
    assert!(error.ends_with("cannot be used: it has no queue family of that number"), "{error}");
    let lent = HostDevice { queue_family: 99, ..host.lent() };
    // SAFETY: refused before anything is done with it.
    let refused = unsafe { Context::from_host(lent) }.map(|_| ()).expect_err("no such family");
    assert_eq!(refused.to_string(), error);
    assert_silent(&host.destroy());
}

#[test]
fn only_the_host_submits() {
    let host = Host::new();
    let context = borrow(host.lent());
    let refused = Runner::new(&context).map(|_| ()).expect_err("a runner on a borrowed device");
    assert!(refused.to_string().contains("host"), "{refused}");
    drop(context);
    assert_silent(&host.destroy());
}

#[test]
fn recording_a_frame_only_records() {
    let host = Host::new();
    let context = borrow(host.lent());
    let mut uploads = Uploads::default();
    calls::take();
    let quilt = quilting(&context, &mut uploads, None);
    let (pass, moment) = guide_pass(&context, &mut uploads);
    // Preparing does allocate and compile, and the counting sees it; it does not submit or wait.
    let prepared = calls::take();
    for name in [
        "vkAllocateMemory",
        "vkCreateBuffer",
        "vkCreateImage",
        "vkCreateImageView",
        "vkCreateShaderModule",
        "vkCreateComputePipelines",
        "vkCreateGraphicsPipelines",
        "vkCreateRenderPass",
        "vkCreateFramebuffer",
        "vkCreatePipelineLayout",
        "vkCreateDescriptorSetLayout",
        "vkCreateDescriptorPool",
        "vkAllocateDescriptorSets",
        "vkUpdateDescriptorSets",
    ] {
        assert!(prepared.contains_key(name), "{name} is not counted: {prepared:?}");
    }
    for name in ["vkQueueSubmit", "vkWaitForFences", "vkQueueWaitIdle", "vkDeviceWaitIdle", "vkBeginCommandBuffer"] {
        assert!(!prepared.contains_key(name), "preparing calls {name}");
    }
    host.run(|commands| uploads.record(&mut recorder(&context, commands)));
    let run = calls::take();
    assert!(run.contains_key("vkQueueSubmit") && run.contains_key("vkWaitForFences"), "{run:?}");

    let commands = host.begin();
    host.end(commands);
    let mut frames = std::collections::BTreeSet::new();
    for frame in 0..100 {
        host.begin_again(commands);
        calls::take();
        let mut recorder = recorder(&context, commands);
        pass.record(&mut recorder, &moment).expect("a picture's shape");
        quilt.record(&mut recorder, PARAMS.seed, frame);
        context.advance(u64::from(frame) + 2, u64::from(frame));
        let recorded = calls::take();
        host.end(commands);
        let names: Vec<_> = recorded.keys().copied().collect();
        // The first frame may free what was staged for the uploads, which have run by now.
        let freed = |name: &&str| ["vkDestroyBuffer", "vkFreeMemory"].contains(name);
        let names: Vec<_> = names.into_iter().filter(|name| frame > 1 || !freed(name)).collect();
        assert_eq!(names, ["vkCmdDispatch", "vkCmdDrawIndexed"], "frame {frame}: {recorded:?}");
        host.submit(&[commands]);
        host.wait();
        if frame % 25 == 0 {
            frames.insert(host.read_image(quilt.canvas().handle(), quilt.canvas().layout(), OUTPUT));
        }
    }
    assert_eq!(frames.len(), 4, "frames of one seed are alike");
    drop((quilt, pass, uploads, context));
    assert_silent(&host.destroy());
}

/// Runs what is recorded by what it is given.
type Run<'a> = &'a mut dyn FnMut(&mut dyn FnMut(&mut Recorder<'_>));

/// The real-time techniques as any device draws them: prepared part by part, then frames.
struct RealTime {
    guides: GuidePass,
    motion: MotionPass,
    object: ObjectTechnique,
    aligned: AlignedTechnique,
    dependent: DependentTechnique,
    moment: Moment,
}

impl RealTime {
    fn new(context: &Context, mesh: &Mesh, run: Run<'_>) -> Self {
        let mut uploads = Uploads::default();
        let camera = Camera::framing(mesh, &Framing::default(), 9.0 / 7.0).expect("a camera");
        let pixels = noise(96, 64, 4).iter().map(|p| [0, 1, 2].map(|k| f32::from(p[k]) / 255.0 - 0.5)).collect();
        let texture = TextureDifference::from_pixels(96, 64, pixels).expect("a difference");
        let trajectory = Trajectory::from_colors(vec![[0.1, 0.2, 0.3], [0.9, 0.8, 0.6]]).expect("a trajectory");
        let paints = [Paint { texture: &texture, trajectory: &trajectory }];
        let quilt = QuiltParams { block_px: 32, overlap_px: 4, ..PARAMS };
        let stages = QuiltStages::new(context);
        let guides = GuidePass::new(context, &mut uploads, mesh, OUTPUT).expect("guides");
        let motion = MotionPass::new(context, &guides).expect("motion");
        let params = ObjectParams::default();
        let object = ObjectTechnique::new(context, &mut uploads, mesh, OUTPUT, &paints, &[0], &params).expect("object");
        let params = LevelParams { levels: 3, size_px: 64, quilt, ..LevelParams::default() };
        let sources = [LevelSource::Strip(&texture)];
        let levels = LevelVolume::new(context, &mut uploads, &stages, &sources, &params).expect("levels");
        let aligned = AlignedTechnique::new(context, &mut uploads, &guides, levels, &[&trajectory], &[0]);
        let mut aligned = aligned.expect("aligned");
        let views = [View { yaw_deg: 20.0, pitch_deg: 10.0 }, View { yaw_deg: 200.0, pitch_deg: 0.0 }];
        let mut coverage = ViewCoverage::new(context, &mut uploads, mesh, &views, 512).expect("views");
        loop {
            run(&mut |recorder| {
                uploads.record(recorder);
                coverage.record(recorder).expect("cameras");
            });
            if !coverage.advance(context, &mut uploads).expect("memory") {
                break;
            }
        }
        let (covered, lights) = (coverage.finish(), Lights::default());
        let params = DependentParams { quilt, ..DependentParams::default() };
        let mut dependent = DependentTechnique::new(
            context,
            &mut uploads,
            &stages,
            mesh,
            &lights,
            &covered,
            512,
            OUTPUT,
            &paints,
            &[0],
            &params,
        )
        .expect("dependent");
        run(&mut |recorder| {
            uploads.record(recorder);
            for part in aligned.levels().parts(u64::MAX) {
                aligned.levels().record_part(recorder, &part, 3);
            }
            for part in dependent.preparation_parts(u64::MAX) {
                dependent.record_preparation(recorder, &part, 3).expect("a part");
            }
        });
        aligned.levels_mut().finish();
        dependent.finish_preparation();
        RealTime { guides, motion, object, aligned, dependent, moment: Moment::at_rest(camera, Lights::default()) }
    }

    fn record(&self, recorder: &mut Recorder<'_>) {
        let turn = Pose::new(3.0, Vec3::Y, Vec3::ZERO, Vec3::ZERO).expect("a pose");
        let turned = Moment { poses: vec![turn], ..self.moment.clone() };
        for (previous, now) in [(None, &turned), (Some(&turned), &self.moment)] {
            self.guides.record(recorder, now).expect("a picture's shape");
            self.motion.record(recorder, previous, now).expect("a picture's shape");
        }
        self.object.record(recorder, &self.moment, ShadeRange::default(), Show::Painted).expect("a picture's shape");
        self.aligned.record(recorder, &AlignedFrame::default(), &[]).expect("a frame in range");
        self.dependent.record(recorder, &self.moment, Show::Painted).expect("a picture's shape");
    }

    fn frames(&self) -> [&Image; 4] {
        [self.object.frame(), self.aligned.frame(), self.dependent.frame(), self.motion.motion()]
    }
}

#[test]
fn the_real_time_techniques_give_the_same_bytes_and_only_record() {
    let asset = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/head.obj");
    let mesh = Mesh::load(asset, &MeshOptions::default()).expect("a mesh").mesh;
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let own = RealTime::new(&gpu.context, &mesh, &mut |record| {
        runner
            .run(|recorder| {
                record(recorder);
                Ok(())
            })
            .expect("run");
    });
    runner
        .run(|recorder| {
            own.record(recorder);
            Ok(())
        })
        .expect("run");
    let expected = own.frames().map(|frame| runner.read_image(frame).expect("a frame"));
    let (frames, motion) = (&expected[..3], &expected[3]);
    assert!(frames.iter().all(|frame| frame.chunks(4).filter(|pixel| pixel[3] == 255).count() > 500));
    assert!(motion.chunks(4).filter(|word| **word != [0; 4]).count() > 500);

    let host = Host::new();
    let context = borrow(host.lent());
    let lent = RealTime::new(&context, &mesh, &mut |record| {
        host.run(|commands| record(&mut recorder(&context, commands)));
    });
    // What was staged and what only the preparation needed goes here.
    context.advance(2, 1);
    let commands = host.begin();
    calls::take();
    lent.record(&mut recorder(&context, commands));
    let recorded = calls::take();
    host.end(commands);
    host.submit(&[commands]);
    host.wait();
    let names: Vec<_> = recorded.keys().copied().collect();
    assert_eq!(names, ["vkCmdDispatch", "vkCmdDrawIndexed"], "{recorded:?}");
    for (frame, expected) in lent.frames().into_iter().zip(&expected) {
        assert!(&host.read_image(frame.handle(), frame.layout(), OUTPUT) == expected);
    }
    drop((lent, context));
    assert_silent(&host.destroy());
}

/// A board whose normals are those of a ball, so that it has all shades, moved by a few pixels from frame to frame.
struct Board {
    mesh: Mesh,
    moments: [Moment; 3],
    texture: TextureDifference,
    trajectory: Trajectory,
}

impl Board {
    fn new() -> Self {
        let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
                    vn -0.7 -0.7 0.5\nvn 0.7 -0.7 0.5\nvn 0.7 0.7 0.5\nvn -0.7 0.7 0.5\n\
                    f 1//1 2//2 3//3 4//4\n";
        let mesh = Mesh::parse(text.as_bytes(), "board.obj", &MeshOptions::default()).expect("a mesh").mesh;
        let camera = Camera::look_at(5.0 * Vec3::Z, Vec3::ZERO, None, 30.0).expect("a camera");
        let moment = |way: Vec3| {
            let pose = Pose::new(0.0, Vec3::Y, Vec3::ZERO, way).expect("a pose");
            Moment { poses: vec![pose], ..Moment::at_rest(camera, Lights::default()) }.fit_depth(&mesh)
        };
        // A unit is 26 pixels.
        let moments = [Vec3::ZERO, Vec3::new(0.2, 0.1, 0.0), Vec3::new(0.33, -0.1, 0.0)].map(moment);
        let pixels = noise(96, 64, 4).iter().map(|p| [0, 1, 2].map(|k| f32::from(p[k]) / 255.0 - 0.5)).collect();
        let texture = TextureDifference::from_pixels(96, 64, pixels).expect("a difference");
        let trajectory = Trajectory::from_colors(vec![[0.1, 0.2, 0.3], [0.9, 0.8, 0.6]]).expect("a trajectory");
        Board { mesh, moments, texture, trajectory }
    }

    /// Image-based painting that is carried by `motion`.
    fn technique(
        &self,
        context: &Context,
        uploads: &mut Uploads,
        guides: GuideImages,
        motion: &Image,
    ) -> ImageTechnique {
        let stages = QuiltStages::new(context);
        let paints = [Paint { texture: &self.texture, trajectory: &self.trajectory }];
        let params = ImageParams { quilt: PARAMS, ..ImageParams::default() };
        let technique = ImageTechnique::new(context, uploads, &stages, &guides, &paints, &[0], &params);
        let mut technique = technique.expect("a technique");
        technique.carry(context, uploads, &guides, &paints, motion, &RepairParams::default()).expect("carrying");
        technique
    }
}

/// The first frame of a sequence by itself, and the others from the one before.
fn record_carried(technique: &ImageTechnique, recorder: &mut Recorder<'_>, frame: u32) {
    match frame {
        0 => technique.record(recorder, PARAMS.seed, frame),
        _ => technique.record_next(recorder, PARAMS.seed, frame),
    }
}

/// The bytes of a frame's images.
struct Content {
    shade: Vec<u8>,
    id: Vec<u8>,
    depth: Vec<u8>,
    motion: Vec<u8>,
    frame: Vec<u8>,
}

impl Content {
    fn words(&self) -> Vec<u32> {
        bytemuck::pod_collect_to_vec(&self.motion)
    }

    /// Motion as engines have it: R32G32_SFLOAT, here in pixels from the previous place to this, y up.
    fn vectors(&self) -> Vec<u8> {
        let way = |word: u32, low: u32| ((word >> low & 0x7fff) as f32 - 16_384.0) / 64.0;
        let vector = |word: u32| if word == 0 { [0.0; 2] } else { [-way(word, 0), way(word, 15)] };
        bytemuck::cast_slice(self.words().into_iter().map(vector).collect::<Vec<_>>().as_flattened()).to_vec()
    }
}

/// The sequence over our own passes.
fn carried_by_runner(board: &Board) -> Vec<Content> {
    let gpu = Validated::new();
    let (context, mut runner, mut uploads) = (&gpu.context, gpu.runner(), Uploads::default());
    let guides = GuidePass::new(context, &mut uploads, &board.mesh, OUTPUT).expect("guides");
    let motion = MotionPass::new(context, &guides).expect("motion");
    let technique = board.technique(context, &mut uploads, (&guides).into(), motion.motion());
    let mut previous = None;
    let frames = (0..).zip(&board.moments).map(|(frame, moment)| {
        let drawn = runner.run(|recorder| {
            uploads.record(recorder);
            guides.record(recorder, moment)?;
            motion.record(recorder, previous.replace(moment), moment)?;
            record_carried(&technique, recorder, frame);
            Ok(())
        });
        drawn.expect("run");
        let images = [guides.shade(), guides.id(), guides.depth(), motion.motion(), technique.frame()];
        let [shade, id, depth, motion, frame] = images.map(|image| runner.read_image(image).expect("an image"));
        Content { shade, id, depth, motion, frame }
    });
    frames.collect()
}

#[test]
fn a_foreign_host_carries_texture_over_its_own_guides_and_motion() {
    use vk::{Format as F, ImageUsageFlags as U};
    let board = Board::new();
    let expected = carried_by_runner(&board);
    let shown = |content: &Content| content.words().iter().filter(|&&word| word >> 31 == 1).count();
    assert_eq!(shown(&expected[0]), 0);
    assert!(expected[1..].iter().all(|content| shown(content) > 1000), "hardly anything is carried");
    assert!(expected.iter().all(|content| content.frame.chunks(4).filter(|pixel| pixel[3] == 255).count() > 2000));

    let host = Host::new();
    for by_words in [true, false] {
        let context = borrow(host.lent());
        let shade = host.image(F::R32_SFLOAT, U::STORAGE | U::TRANSFER_DST, OUTPUT);
        let id = host.image(F::R32_UINT, host::usage(), OUTPUT);
        let depth_usage = U::DEPTH_STENCIL_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let depth = host.image(F::D32_SFLOAT, depth_usage, OUTPUT);
        let words = host.image(F::R32_UINT, host::usage(), OUTPUT);
        let vectors = host.image(F::R32G32_SFLOAT, U::SAMPLED | U::TRANSFER_DST, OUTPUT);
        let images = [&shade, &id, &depth, &words, &vectors];
        let lent = images.map(|image| wrapped(&context, image));
        let guides = GuideImages::new(&lent[0], &lent[1], &lent[2], 1).expect("guides");
        let params = HostMotionParams { scale: [-1.0, 1.0], ..HostMotionParams::default() };
        let motion = HostMotion::new(&context, &guides, &lent[4], &params).expect("motion");
        let mut uploads = Uploads::default();
        let carried_by = if by_words { &lent[3] } else { motion.motion() };
        let technique = board.technique(&context, &mut uploads, guides, carried_by);
        host.run(|commands| uploads.record(&mut recorder(&context, commands)));
        // What was staged goes here.
        context.advance(2, 1);
        let mut previous = None;
        for (frame, (moment, content)) in (0..).zip(board.moments.iter().zip(&expected)) {
            let vectors = content.vectors();
            let drawn = [&content.shade, &content.id, &content.depth, &content.motion, &vectors];
            for ((to, lent), bytes) in images.into_iter().zip(&lent).zip(drawn) {
                host.write_image(to, bytes);
                // SAFETY: so the host has left it.
                unsafe { lent.set_state(written()) };
            }
            let commands = host.begin();
            calls::take();
            let mut recorder = recorder(&context, commands);
            motion.record(&mut recorder, previous.replace(&moment.camera), &moment.camera);
            record_carried(&technique, &mut recorder, frame);
            let recorded = calls::take();
            host.end(commands);
            host.submit(&[commands]);
            host.wait();
            assert_eq!(recorded.keys().copied().collect::<Vec<_>>(), ["vkCmdDispatch"], "frame {frame}: {recorded:?}");
            let read = |image: &Image| host.read_image(image.handle(), image.layout(), OUTPUT);
            assert!(read(motion.motion()) == content.motion, "frame {frame}: the words of the host's vectors");
            assert!(read(technique.frame()) == content.frame, "frame {frame}, by words: {by_words}");
        }
        drop((technique, motion, lent, uploads, context));
        [shade, id, depth, words, vectors].into_iter().for_each(|image| host.destroy_image(image));
    }
    assert_silent(&host.destroy());
}

/// What the frame in flight uses may be dropped; it is destroyed when the host says that the frame is done.
#[test]
fn objects_dropped_in_flight_live_until_their_frame_is_safe() {
    let host = Host::new();
    let context = borrow(host.lent());
    let submit = |frame: u64| {
        context.advance(frame, frame - 1);
        let mut uploads = Uploads::default();
        let quilt = quilting(&context, &mut uploads, None);
        let commands = host.begin();
        let mut recorder = recorder(&context, commands);
        uploads.record(&mut recorder);
        quilt.record(&mut recorder, PARAMS.seed, 0);
        let done = host.flag_when_done(commands);
        host.end(commands);
        host.submit(&[commands]);
        // Here quilt, pipelines, descriptor sets, sample and staging memory are dropped.
        done
    };
    let destroyed = ["vkDestroyBuffer", "vkDestroyImage", "vkDestroyPipeline", "vkDestroyDescriptorPool"];
    let none = |what: &str| {
        let calls = calls::take();
        assert!(destroyed.iter().all(|name| !calls.contains_key(name)), "{what}: {calls:?}");
    };
    let done = submit(1);
    none("dropped in flight");
    assert!(context.allocated_bytes() > 0);
    context.advance(2, 0);
    none("frame 1 is not safe");
    host.wait();
    assert!(done.is_set(&host));
    done.destroy(&host);
    calls::take();
    context.advance(3, 1);
    let calls = calls::take();
    assert!(destroyed.iter().all(|name| calls.contains_key(name)), "frame 1 is safe: {calls:?}");
    assert_eq!(context.allocated_bytes(), 0);
    assert_silent(&host.take_messages());

    // The same with a host that says so too early: validation must notice, or the silence above proves nothing. It goes
    // by what the host has waited for; the work itself is over, so that nothing is pulled from under it in truth.
    let done = submit(4);
    while !done.is_set(&host) {
        std::thread::yield_now();
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    context.advance(5, 4);
    let messages = host.take_messages();
    assert!(messages.iter().any(|m| m.contains("VUID-vkDestroyBuffer-buffer-00922")), "{messages:?}");
    host.wait();
    done.destroy(&host);
    drop(context);
    assert_silent(&host.destroy());
}

#[test]
fn a_leak_is_noticed() {
    let host = Host::new();
    let context = borrow(host.lent());
    let buffer = Buffer::new(&context, "left over", BufferKind::Storage, 1000).expect("a buffer");
    // Keeps the context too: neither is dropped any more.
    std::mem::forget(buffer);
    drop(context);
    let messages = host.destroy();
    assert!(messages.iter().any(|m| m.contains("VkBuffer") && m.contains("has not been destroyed")), "{messages:?}");
}

const QUEUE_SUBMIT: (&str, &str) =
    ("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT");

/// Run by the next test in a process of its own.
#[test]
fn child_submits_every_step_in_a_command_buffer_of_its_own() {
    if !common::is_child() {
        return;
    }
    let host = Host::new();
    let context = borrow(host.lent());
    let mut uploads = Uploads::default();
    let quilt = quilting(&context, &mut uploads, None);
    let steps = quilt.parts(0).last().map_or(0, |part| part.end);
    let submit = |uploads: &mut Uploads, first: usize, omit: bool| {
        let commands: Vec<_> = (first..steps)
            .map(|step| {
                let commands = host.begin();
                let mut recorder = recorder(&context, commands);
                uploads.record(&mut recorder);
                if omit {
                    recorder.omit_barriers();
                }
                quilt.record_part(&mut recorder, step..step + 1, PARAMS.seed, 0);
                host.end(commands);
                commands
            })
            .collect();
        host.submit(&commands);
        host.wait();
    };
    submit(&mut uploads, 0, false);
    let canvas = host.read_image(quilt.canvas().handle(), quilt.canvas().layout(), OUTPUT);
    assert!(canvas == oracle(false), "the canvas is not the oracle's");
    assert_silent(&host.take_messages());
    // Without barriers the steps after the first write and read the same memory at once.
    submit(&mut uploads, 1, true);
    let messages = host.take_messages();
    let kinds = ["READ_AFTER_WRITE", "WRITE_AFTER_READ", "WRITE_AFTER_WRITE"];
    for kind in kinds {
        println!("{kind}: {}", messages.iter().filter(|m| m.contains(kind)).count());
    }
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD")), "{messages:?}");
    drop((quilt, uploads, context));
    assert_silent(&host.destroy());
}

#[test]
fn barriers_hold_between_command_buffers_too() {
    let output = common::run_child("child_submits_every_step_in_a_command_buffer_of_its_own", &[QUEUE_SUBMIT]);
    eprintln!("{output}");
}
