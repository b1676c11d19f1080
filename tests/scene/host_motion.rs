//! A host's motion vectors as words, against a plain oracle on images made up here, and against our own motion pass.

use super::common::{Numbers, Validated};
use super::motion::{pose, teapot_on_table, texels, SHOWN};
use ash::vk::{Format as F, ImageUsageFlags as U};
use impasto::gpu::{Image, ImageDesc, Runner, Uploads};
use impasto::scene::{
    Camera, Framing, Guide, GuideImages, GuidePass, HostMotion, HostMotionParams, Lights, Mesh, Moment, MotionPass,
    Pose, Vec3,
};

const SIZE: (u32, u32) = (70, 45);

fn image(gpu: &Validated, size: (u32, u32), format: F, usage: U) -> Image {
    let desc = ImageDesc { size_px: [size.0, size.1, 1], format, usage: usage | U::TRANSFER_SRC | U::TRANSFER_DST };
    Image::new(&gpu.context, "host's", &desc).expect("an image")
}

fn camera() -> Camera {
    Camera::look_at(Vec3::Z, Vec3::ZERO, None, 30.0).expect("a camera")
}

/// What a host has drawn: object IDs, distances along the view axis, and vectors in 1/64 pixels to the previous place.
struct Frame {
    camera: Camera,
    id: Vec<u32>,
    distance: Vec<f64>,
    way: Vec<[i32; 2]>,
}

impl Frame {
    /// Patches of few objects at few distances, with ways of up to 20 pixels, some whole and some none.
    fn new(seed: u32, camera: Camera) -> Self {
        let mut numbers = Numbers(seed);
        let mut any = move |below: u32| numbers.next() / 7 % below;
        let patches: Vec<(u32, f64)> = (0..200).map(|_| (any(3), [2.0, 2.03, 2.1, 4.0][any(4) as usize])).collect();
        let patch = |i: u32| patches[(i / SIZE.0 / 6 * 12 + i % SIZE.0 / 6) as usize];
        let texels = 0..SIZE.0 * SIZE.1;
        let (id, distance) = texels.clone().map(patch).unzip();
        let mut step = move || any(40 * 64) as i32 - 20 * 64;
        let way = |i: u32| match i % 5 {
            0 => [0, 0],
            1 => [step() / 64 * 64, step() / 64 * 64],
            _ => [step(), step()],
        };
        Frame { camera, id, distance, way: texels.map(way).collect() }
    }

    /// Depths as Vulkan's perspective has them.
    fn depth(&self) -> Vec<f32> {
        let (near, far) = (f64::from(self.camera.near()), f64::from(self.camera.far()));
        self.distance.iter().map(|z| (far / (far - near) * (1.0 - near / z)) as f32).collect()
    }

    /// Vectors that times `scale` are the ways, as texels of a format.
    fn vectors(&self, format: F, scale: [f32; 2]) -> Vec<u8> {
        let vectors = self.way.iter().map(|way| [0, 1].map(|k| way[k] as f32 / 64.0 / scale[k]));
        let all: Vec<Vec<u8>> = match format {
            F::R32G32_SFLOAT => vectors.map(|v| bytemuck::cast_slice(&v).to_vec()).collect(),
            F::R16G16_SFLOAT => vectors.map(|v| bytemuck::cast_slice(&v.map(half)).to_vec()).collect(),
            _ => vectors
                .map(|[x, y]| bytemuck::cast_slice(&[half(x), half(y), half(7.0), half(-3.0)]).to_vec())
                .collect(),
        };
        all.concat()
    }

    /// The words, from what the frame before was.
    fn words(&self, then: &Frame, tolerance: f64) -> Vec<u32> {
        let word = |i: usize| {
            let way = self.way[i];
            let at = [i as i32 % SIZE.0 as i32, i as i32 / SIZE.0 as i32];
            // Halves go up.
            let [x, y] = [0, 1].map(|k| at[k] + (way[k] + 32).div_euclid(64));
            let inside = (0..SIZE.0 as i32).contains(&x) && (0..SIZE.1 as i32).contains(&y);
            let shown = inside && {
                let q = (y * SIZE.0 as i32 + x) as usize;
                then.id[q] == self.id[i] && (then.distance[q] - self.distance[i]).abs() <= tolerance * self.distance[i]
            };
            let steps = way.map(|steps| (steps + 16_384) as u32);
            if self.id[i] == 0 {
                0
            } else {
                steps[0] | steps[1] << 15 | if shown { SHOWN } else { 0 }
            }
        };
        (0..self.id.len()).map(word).collect()
    }
}

/// A number that 11 bits hold, in 16.
fn half(value: f32) -> u16 {
    let bits = value.to_bits();
    assert_eq!(bits & 0x1fff, 0, "{value} is rounded");
    if value == 0.0 {
        return 0;
    }
    ((bits >> 16 & 0x8000) | ((bits >> 23 & 0xff) - 112) << 10 | (bits >> 13 & 0x3ff)) as u16
}

#[test]
fn words_of_any_format_and_scale_equal_the_oracle() {
    let gpu = Validated::new();
    let planes = |near, far| camera().with_planes(near, far).expect("planes");
    let frames =
        [Frame::new(3, planes(0.5, 10.0)), Frame::new(5, planes(1.0, 5.0)), Frame::new(9, planes(0.01, 900.0))];
    let kept = U::SAMPLED | U::DEPTH_STENCIL_ATTACHMENT;
    let tries = [
        (F::R32G32_SFLOAT, [1.0, 1.0], 0.02),
        (F::R32G32_SFLOAT, [-32.0, 0.25], 0.6),
        (F::R16G16_SFLOAT, [64.0, -128.0], 0.02),
        (F::R16G16B16A16_SFLOAT, [0.5, 2.0], 0.08),
    ];
    let mut shown = Vec::new();
    for (format, scale, tolerance) in tries {
        let mut runner = gpu.runner();
        let shade = image(&gpu, SIZE, F::R32_SFLOAT, U::STORAGE);
        let id = image(&gpu, SIZE, F::R32_UINT, U::STORAGE);
        let depth = image(&gpu, SIZE, F::D32_SFLOAT, kept);
        let vectors = image(&gpu, SIZE, format, U::SAMPLED);
        let guides = GuideImages::new(&shade, &id, &depth, 2).expect("guides");
        let params = HostMotionParams { scale, depth_tolerance: tolerance };
        let motion = HostMotion::new(&gpu.context, guides, &vectors, &params).expect("motion");
        let mut previous: Option<&Frame> = None;
        for frame in &frames {
            let mut uploads = Uploads::default();
            let mut upload = |to: &Image, bytes: &[u8]| uploads.image(&gpu.context, to, bytes).expect("an upload");
            upload(&id, bytemuck::cast_slice(&frame.id));
            upload(&depth, bytemuck::cast_slice(&frame.depth()));
            upload(&vectors, &frame.vectors(format, scale));
            runner
                .run(|recorder| {
                    uploads.record(recorder);
                    motion.record(recorder, previous.map(|frame| &frame.camera), &frame.camera);
                    Ok(())
                })
                .expect("run");
            let words: Vec<u32> = texels(&mut runner, motion.motion());
            let none = || vec![0; words.len()];
            let expected = previous.map_or_else(none, |then| frame.words(then, f64::from(tolerance)));
            let wrong = words.iter().zip(&expected).position(|(got, want)| got != want);
            assert_eq!(
                wrong,
                None,
                "{format:?} by {scale:?}: {:x} {:x}",
                words[wrong.unwrap()],
                expected[wrong.unwrap()]
            );
            shown.push(words.iter().filter(|&&word| word >= SHOWN).count());
            previous = Some(frame);
        }
    }
    assert_eq!([shown[0], shown[3]], [0, 0], "nothing was before");
    assert!(shown[1] > 100 && shown[7] == shown[1] && shown[4] > shown[10] && shown[10] > shown[1], "{shown:?}");
}

#[test]
fn vectors_that_do_not_fit_are_refused_or_give_no_word() {
    let gpu = Validated::new();
    let guide = |size| {
        let shade = image(&gpu, size, F::R32_SFLOAT, U::STORAGE);
        let id = image(&gpu, size, F::R32_UINT, U::STORAGE);
        let depth = image(&gpu, size, F::D32_SFLOAT, U::SAMPLED | U::DEPTH_STENCIL_ATTACHMENT);
        (GuideImages::new(&shade, &id, &depth, 1).expect("guides"), id, depth)
    };
    let (guides, id, depth) = guide((4, 1));
    let vectors = |size, format, usage| image(&gpu, size, format, usage);
    let fine = HostMotionParams::default();
    let refused = |vectors: &Image, params: HostMotionParams| {
        HostMotion::new(&gpu.context, &guides, vectors, &params).map(|_| ()).expect_err("refused").to_string()
    };
    let good = vectors((4, 1), F::R32G32_SFLOAT, U::SAMPLED);
    assert!(refused(&vectors((4, 1), F::R32_SFLOAT, U::SAMPLED), fine).contains("vectors is R32_SFLOAT, but must be"));
    assert!(refused(&vectors((4, 1), F::R32G32_SFLOAT, U::STORAGE), fine).contains("vectors is made for"));
    let message = refused(&vectors((4, 2), F::R32G32_SFLOAT, U::SAMPLED), fine);
    assert_eq!(message, "vectors is 4x2, but must be 4x1");
    assert!(refused(&good, HostMotionParams { scale: [1.0, f32::NAN], ..fine }).contains("scale is NaN"));
    for depth_tolerance in [-0.1, 1.1, f32::NAN] {
        assert!(refused(&good, HostMotionParams { depth_tolerance, ..fine }).contains("depth tolerance is"));
    }
    for (near, far) in [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (f32::NAN, 1.0), (1.0, f32::INFINITY)] {
        assert!(camera().with_planes(near, far).is_err());
    }

    // 255 and 63/64 pixels to the right fit a word, 256 do not; infinitely many and no number are no way.
    let motion = HostMotion::new(&gpu.context, &guides, &good, &fine).expect("motion");
    let mut runner = gpu.runner();
    let mut uploads = Uploads::default();
    let mut upload = |to: &Image, bytes: &[u8]| uploads.image(&gpu.context, to, bytes).expect("an upload");
    upload(&id, bytemuck::cast_slice(&[1u32; 4]));
    upload(&depth, bytemuck::cast_slice(&[0.5f32; 4]));
    let most = 255.0 + 63.0 / 64.0;
    let ways = [[most, 0.0], [256.0, 0.0], [0.0, f32::INFINITY], [f32::NAN, 0.0]];
    upload(&good, bytemuck::cast_slice(ways.as_flattened()));
    runner
        .run(|recorder| {
            uploads.record(recorder);
            motion.record(recorder, None, &camera());
            motion.record(recorder, Some(&camera()), &camera());
            Ok(())
        })
        .expect("run");
    let words: Vec<u32> = texels(&mut runner, motion.motion());
    assert_eq!(words, [16_384 << 15 | 32_767, 0, 0, 0]);
}

/// Our own passes, and the host's motion by vectors that are worked out from the moments.
struct Both {
    runner: Runner,
    guides: GuidePass,
    own: MotionPass,
    vectors: Image,
    host: HostMotion,
}

const DRAWN: (u32, u32) = (240, 180);

impl Both {
    fn new(gpu: &Validated, mesh: &Mesh) -> Self {
        let (mut runner, mut uploads) = (gpu.runner(), Uploads::default());
        let guides = GuidePass::new(&gpu.context, &mut uploads, mesh, DRAWN).expect("guides");
        let own = MotionPass::new(&gpu.context, &guides).expect("motion");
        let vectors = image(gpu, DRAWN, F::R32G32_SFLOAT, U::SAMPLED);
        // In normalised device coordinates, from the previous place to this.
        let params = HostMotionParams { scale: [-120.0, -90.0], ..Default::default() };
        let host = HostMotion::new(&gpu.context, &guides, &vectors, &params).expect("motion");
        let record = |recorder: &mut impasto::gpu::Recorder<'_>| {
            uploads.record(recorder);
            Ok(())
        };
        runner.run(record).expect("run");
        Both { runner, guides, own, vectors, host }
    }

    /// The guides of `now`, and words of motion by our own pass and by the host's vectors.
    fn frame(&mut self, gpu: &Validated, then: &Moment, now: &Moment) -> (Guide, [Vec<u32>; 2]) {
        for (previous, moment) in [(None, then), (Some(then), now)] {
            let drawn = self.runner.run(|recorder| {
                self.guides.record(recorder, moment)?;
                self.own.record(recorder, previous, moment)
            });
            drawn.expect("run");
            let guide = Guide {
                width: DRAWN.0,
                height: DRAWN.1,
                shade: texels(&mut self.runner, self.guides.shade()),
                id: texels(&mut self.runner, self.guides.id()),
                depth: texels(&mut self.runner, self.guides.depth()),
            };
            let mut uploads = Uploads::default();
            let vectors = vectors(&guide, then, moment);
            uploads.image(&gpu.context, &self.vectors, bytemuck::cast_slice(&vectors)).expect("an upload");
            let followed = self.runner.run(|recorder| {
                uploads.record(recorder);
                self.host.record(recorder, previous.map(|moment| &moment.camera), &moment.camera);
                Ok(())
            });
            followed.expect("run");
            if previous.is_some() {
                let words = [self.own.motion(), self.host.motion()].map(|motion| texels(&mut self.runner, motion));
                return (guide, words);
            }
        }
        unreachable!()
    }
}

/// From the place then to the place now, in normalised device coordinates, as an engine's vertex shader has it.
fn vectors(guide: &Guide, then: &Moment, now: &Moment) -> Vec<[f32; 2]> {
    let aspect = guide.width as f32 / guide.height as f32;
    let matrix = |moment: &Moment| moment.camera.view_projection(aspect).expect("a projection").as_dmat4();
    let (to_then, from_now) = (matrix(then), matrix(now).inverse());
    let vector = |i: usize| {
        let Some(object) = (guide.id[i] as usize).checked_sub(1) else { return [0.0; 2] };
        let (x, y) = (i as u32 % guide.width, i as u32 / guide.width);
        let here =
            [(x, guide.width), (y, guide.height)].map(|(at, side)| (f64::from(at) + 0.5) / f64::from(side) * 2.0 - 1.0);
        let point = from_now.project_point3([here[0], here[1], f64::from(guide.depth[i])].into());
        let at_rest = now.pose(object).matrix().inverse().transform_point3(point);
        let there = to_then.project_point3(then.pose(object).matrix().transform_point3(at_rest));
        [(here[0] - there.x) as f32, (here[1] - there.y) as f32]
    };
    (0..guide.id.len()).map(vector).collect()
}

#[test]
fn vectors_of_a_known_scene_give_the_words_of_our_own_motion() {
    let gpu = Validated::new();
    let mesh = teapot_on_table();
    let camera = Camera::framing(&mesh, &Framing::default(), 240.0 / 180.0).expect("a camera");
    let radius = mesh.bounding_sphere().radius;
    let right = radius * camera.forward().cross(camera.up());
    let posed = |camera, poses: &[Pose]| {
        Moment { poses: poses.to_vec(), ..Moment::at_rest(camera, Lights::default()) }.fit_depth(&mesh)
    };
    let rest = posed(camera, &[]);
    let orbited = camera.orbited(3.0, Vec3::Y).expect("a camera");
    let board = pose(3.0, Vec3::ZERO, &mesh);
    let pairs = [
        ("turned table", [rest.clone(), posed(camera, &[Pose::REST, board])]),
        ("moved teapot", [rest.clone(), posed(camera, &[pose(0.0, 0.15 * right, &mesh)])]),
        ("turned and moved teapot", [rest.clone(), posed(camera, &[pose(6.0, 0.1 * right, &mesh)])]),
        ("orbit", [rest, posed(orbited, &[])]),
        (
            "enters the frame",
            [posed(camera, &[pose(0.0, 2.4 * right, &mesh)]), posed(camera, &[pose(0.0, 0.9 * right, &mesh)])],
        ),
    ];
    let mut both = Both::new(&gpu, &mesh);
    for (name, [then, now]) in &pairs {
        let (guide, [own, host]) = both.frame(&gpu, then, now);
        let all = own.len() as f64;
        let near = |(a, b): (&u32, &u32)| {
            let steps = |word: &u32, low: u32| (word >> low & 0x7fff) as i32;
            (*a == 0) == (*b == 0) && [0, 15].iter().all(|&low| (steps(a, low) - steps(b, low)).abs() <= 1)
        };
        let (known, apart) = (
            own.iter().filter(|&&word| word != 0).count() as f64,
            own.iter().zip(&host).filter(|&pair| !near(pair)).count() as f64,
        );
        let differs = own.iter().zip(&host).filter(|(a, b)| (**a >= SHOWN) != (**b >= SHOWN)).count() as f64;
        let shown = host.iter().filter(|&&word| word >= SHOWN).count() as f64;
        eprintln!("{name}: {apart} of {known} apart, {:.5} shown otherwise, {:.3} shown", differs / all, shown / all);
        assert!(known > 0.1 * all && apart <= 0.01 * known, "{name}: {apart} of {known} words apart");
        assert!(shown > 0.1 * all && differs < 0.02 * all, "{name}: {differs} of {all} shown otherwise");
        let teapot: Vec<u32> = guide.id.iter().zip(&host).filter(|(&id, _)| id == 1).map(|(_, &word)| word).collect();
        assert!(teapot.len() > 300, "{name}: {} pixels of the teapot", teapot.len());
        let seen = teapot.iter().any(|&word| word >= SHOWN);
        assert_eq!(seen, *name != "enters the frame", "{name}");
    }
}
