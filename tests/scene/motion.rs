//! Motion on the GPU against the plain one, from now to then.

use super::common::Validated;
use impasto::gpu::{Image, ImageDesc, Runner, Uploads};
use impasto::metric::Motion;
use impasto::scene::{
    Camera, Framing, Guide, GuideImages, GuideOracle, GuidePass, Lights, Mesh, Moment, MotionPass, Pose, Vec3,
    MAX_OBJECTS,
};

const SIZE: (u32, u32) = (240, 180);
const ASPECT: f32 = 240.0 / 180.0;
/// No motion, of what the frame before showed.
const STILL: u32 = SHOWN | 16_384 << 15 | 16_384;
pub(super) const SHOWN: u32 = 1 << 31;

pub(super) fn teapot_on_table() -> Mesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/teapot_on_table.obj");
    super::mesh(&std::fs::read_to_string(path).expect("the model"))
}

pub(super) fn texels<T: bytemuck::AnyBitPattern + bytemuck::NoUninit>(runner: &mut Runner, image: &Image) -> Vec<T> {
    bytemuck::pod_collect_to_vec(&runner.read_image(image).expect("an image"))
}

/// The passes, and what they drew.
struct Drawn<'a> {
    runner: Runner,
    guides: GuidePass,
    motion: MotionPass,
    _gpu: &'a Validated,
}

impl<'a> Drawn<'a> {
    fn new(gpu: &'a Validated, mesh: &Mesh) -> Self {
        let mut runner = gpu.runner();
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(&gpu.context, &mut uploads, mesh, SIZE).expect("a guide pass");
        let motion = MotionPass::new(&gpu.context, &guides).expect("a motion pass");
        runner
            .run(|recorder| {
                uploads.record(recorder);
                Ok(())
            })
            .expect("run");
        Drawn { runner, guides, motion, _gpu: gpu }
    }

    /// A frame's guides and motion.
    fn frame(&mut self, previous: Option<&Moment>, now: &Moment) -> (Guide, Vec<u32>) {
        self.runner
            .run(|recorder| {
                self.guides.record(recorder, now)?;
                self.motion.record(recorder, previous, now)
            })
            .expect("run");
        let guide = Guide {
            width: SIZE.0,
            height: SIZE.1,
            shade: texels(&mut self.runner, self.guides.shade()),
            id: texels(&mut self.runner, self.guides.id()),
            depth: texels(&mut self.runner, self.guides.depth()),
        };
        (guide, texels(&mut self.runner, self.motion.motion()))
    }
}

/// How two motions differ: the share of pixels that one shows and the other does not, that of ways more than a step
/// apart among all others, and the most steps.
fn difference(got: &[u32], want: &Motion) -> (f64, f64, i64) {
    let (mut hidden, mut apart, mut most) = (0, 0, 0);
    for (&word, [x, y, shown]) in got.iter().zip(want.to_rgb16()) {
        // The file has 16 bits where the word has 15.
        let [x, y] = [x, y].map(|way| i64::from(way) - 16_384);
        let far = [x, y].iter().any(|way| !(0..32_768).contains(way));
        if (word >= SHOWN) != (shown != 0 && !far) {
            hidden += 1;
        } else if word >= SHOWN {
            let steps = [(word & 0x7fff, x), (word >> 15 & 0x7fff, y)].map(|(a, b)| (i64::from(a) - b).abs());
            let steps = steps[0].max(steps[1]);
            most = most.max(steps);
            apart += usize::from(steps > 1);
        }
    }
    let share = |count: usize| count as f64 / got.len() as f64;
    (share(hidden), share(apart), most)
}

pub(super) fn pose(degrees: f32, way: Vec3, mesh: &Mesh) -> Pose {
    Pose::new(degrees, Vec3::new(0.2, 1.0, 0.1), mesh.bounding_sphere().center, way).expect("a pose")
}

/// Pairs of moments, then and now.
fn pairs(mesh: &Mesh) -> Vec<(&'static str, [Moment; 2])> {
    let camera = Camera::framing(mesh, &Framing::default(), ASPECT).expect("a camera");
    let radius = mesh.bounding_sphere().radius;
    let rest = |camera| Moment::at_rest(camera, Lights::default()).fit_depth(mesh);
    let posed = |camera, poses: &[Pose]| Moment { poses: poses.to_vec(), ..rest(camera) }.fit_depth(mesh);
    let still = Pose::REST;
    let small = pose(7.0, 0.1 * radius * Vec3::new(1.0, 0.2, -0.5), mesh);
    let outside = pose(0.0, 2.4 * radius * camera.forward().cross(camera.up()), mesh);
    let at_edge = pose(20.0, 0.9 * radius * camera.forward().cross(camera.up()), mesh);
    let orbited = camera.orbited(4.0, Vec3::Y).expect("a camera");
    // Close above the table, so that the far plane is thousands of times as far as the near one.
    let low = camera.target() + radius * Vec3::new(-0.7, 0.0, 0.7);
    let close = |way: f32| {
        let eye = low + 0.01 * way * radius * Vec3::X;
        rest(Camera::look_at(eye, camera.target(), None, 60.0).expect("a camera"))
    };
    vec![
        ("orbit", [rest(camera), rest(orbited)]),
        ("quarter orbit", [rest(camera), rest(camera.orbited(90.0, Vec3::Y).expect("a camera"))]),
        ("zoom", [rest(camera), rest(camera.moved_away(0.93).expect("a camera"))]),
        ("turned teapot", [rest(camera), posed(camera, &[small])]),
        ("turned teapot and orbit", [posed(camera, &[small]), rest(orbited)]),
        ("turned table", [rest(camera), posed(camera, &[still, small])]),
        ("all turned", [posed(camera, &[small; 2]), posed(orbited, &[at_edge; 2])]),
        ("enters the frame", [posed(camera, &[outside]), posed(camera, &[at_edge])]),
        ("moves at the edge", [posed(camera, &[at_edge]), posed(camera, &[small])]),
        ("close", [close(0.0), close(1.0)]),
    ]
}

#[test]
fn motion_equals_the_oracle() {
    let gpu = Validated::new();
    let mesh = teapot_on_table();
    let mut drawn = Drawn::new(&gpu, &mesh);
    for (name, [then, now]) in pairs(&mesh) {
        let (guide_then, first) = drawn.frame(None, &then);
        assert!(first.iter().all(|&word| word == 0), "{name}: nothing was before");
        let (guide_now, words) = drawn.frame(Some(&then), &now);
        let exact = Motion::between([&now, &then], [&guide_now, &guide_then]).expect("a motion");
        let (hidden, apart, most) = difference(&words, &exact);
        let plain = [&now, &then].map(|m| GuideOracle::render(&mesh, m, SIZE.0, SIZE.1).expect("a guide"));
        let plain = Motion::between([&now, &then], [&plain[0], &plain[1]]).expect("a motion");
        let all = difference(&words, &plain);
        let shown = words.iter().filter(|&&word| word >= SHOWN).count() as f64 / words.len() as f64;
        eprintln!("{name}: {shown:.3} shown; of one depth: {hidden:.5} {apart:.5} {most}; of the oracle's: {all:?}");
        // Of the same depths only the last bits of the place differ.
        assert!(hidden < 0.0005 && most <= 1, "{name}: {hidden} shown or not, {most} steps");
        assert!(all.0 <= 0.005 && all.1 <= 0.005, "{name}: {all:?}");
        let entered = name == "enters the frame";
        assert!(shown > 0.1, "{name}: {shown} is worth comparing");
        assert!(!entered || guide_now.id.iter().zip(&words).all(|(&id, &word)| id != 1 || word < SHOWN), "{name}");
        assert!(entered || guide_now.id.iter().zip(&words).any(|(&id, &word)| id == 1 && word >= SHOWN), "{name}");
    }
}

#[test]
fn what_stands_still_stays_and_each_frame_is_kept_for_the_next() {
    let gpu = Validated::new();
    let mesh = teapot_on_table();
    let mut drawn = Drawn::new(&gpu, &mesh);
    let camera = Camera::framing(&mesh, &Framing::default(), ASPECT).expect("a camera");
    let moment = |degrees| Moment {
        poses: vec![pose(degrees, Vec3::ZERO, &mesh)],
        ..Moment::at_rest(camera, Lights::default())
    };
    let (a, b) = (moment(0.0), moment(5.0));
    drawn.frame(None, &a);
    let (guide, words) = drawn.frame(Some(&a), &b);
    let moved = guide.id.iter().zip(&words).filter(|(&id, &word)| id == 1 && word != STILL).count();
    let of_teapot = guide.id.iter().filter(|&&id| id == 1).count();
    assert!(moved * 10 > of_teapot * 9, "{moved} of {of_teapot} pixels move");
    assert!(
        guide.id.iter().zip(&words).all(|(&id, &word)| id != 2 || word == STILL || word < SHOWN),
        "the table stands"
    );
    let (guide, words) = drawn.frame(Some(&b), &b);
    let stay = |(&id, &word): (&u32, &u32)| word == if id == 0 { 0 } else { STILL };
    assert!(guide.id.iter().zip(&words).all(stay), "nothing has moved since");
}

#[test]
fn a_way_that_does_not_fit_is_none() {
    let gpu = Validated::new();
    // A board that faces the camera: 40 pixels see 2 * 5 * tan(15 degrees), so one unit is 15 of them.
    let mesh = super::mesh("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, None, 30.0).expect("a camera");
    let mut runner = gpu.runner();
    let mut uploads = Uploads::default();
    let guides = GuidePass::new(&gpu.context, &mut uploads, &mesh, (1600, 40)).expect("a guide pass");
    let motion = MotionPass::new(&gpu.context, &guides).expect("a motion pass");
    let moment = |x: f32| {
        let pose = Pose::new(0.0, Vec3::Y, Vec3::ZERO, x * Vec3::X).expect("a pose");
        Moment { poses: vec![pose], ..Moment::at_rest(camera, Lights::default()) }
    };
    let mut words = |x: f32| {
        let (then, now) = (moment(-x), moment(x));
        runner
            .run(|recorder| {
                uploads.record(recorder);
                guides.record(recorder, &then)?;
                motion.record(recorder, None, &then)?;
                guides.record(recorder, &now)?;
                motion.record(recorder, Some(&then), &now)
            })
            .expect("run");
        let id: Vec<u32> = texels(&mut runner, guides.id());
        let words: Vec<u32> = texels(&mut runner, motion.motion());
        let count = |words: &[u32], least: u32| words.iter().filter(|&&word| word >= least).count();
        (count(&id, 1), count(&words, SHOWN))
    };
    let (there, shown) = words(8.5);
    assert!(there > 800 && shown == there, "254 pixels: {shown} of {there}");
    let (there, shown) = words(8.75);
    assert!(there > 800 && shown == 0, "261 pixels: {shown} of {there}");
}

#[test]
fn images_that_are_no_guides_are_refused() {
    let gpu = Validated::new();
    let image = |size: u32, format: ash::vk::Format, usage: ash::vk::ImageUsageFlags| {
        let desc = ImageDesc { size_px: [size, size, 1], format, usage };
        Image::new(&gpu.context, "test", &desc).expect("an image")
    };
    use ash::vk::{Format as F, ImageUsageFlags as U};
    let shade = |size| image(size, F::R32_SFLOAT, U::STORAGE);
    let id = |usage| image(8, F::R32_UINT, usage);
    let depth = |size, usage| image(size, gpu.context.caps().depth_format, U::DEPTH_STENCIL_ATTACHMENT | usage);
    let kept = U::SAMPLED | U::TRANSFER_SRC;
    let (good_id, good_depth) = (id(U::STORAGE | U::TRANSFER_SRC), depth(8, kept));
    let refused = |shade: &Image, id: &Image, depth: &Image, objects: usize| {
        GuideImages::new(shade, id, depth, objects).map(|_| ()).expect_err("refused").to_string()
    };
    let message = refused(&good_id, &good_id, &good_depth, 1);
    assert_eq!(message, "guide shade is R32_UINT, but must be R32_SFLOAT");
    assert_eq!(refused(&shade(8), &shade(8), &good_depth, 1), "guide id is R32_SFLOAT, but must be R32_UINT");
    assert!(refused(&shade(8), &good_id, &good_id, 1).contains("guide depth is R32_UINT, but must be D32_SFLOAT or"));
    let message = refused(&shade(8), &id(U::SAMPLED), &good_depth, 1);
    assert_eq!(message, "guide id is made for SAMPLED, but must be made for STORAGE");
    assert_eq!(refused(&shade(8), &good_id, &depth(9, kept), 1), "guide depth is 9x9, but must be 8x8");
    assert_eq!(refused(&shade(9), &good_id, &good_depth, 1), "guide id is 8x8, but must be 9x9");
    for objects in [0, MAX_OBJECTS + 1] {
        assert!(refused(&shade(8), &good_id, &good_depth, objects).contains("object_count is"));
    }
    let guides = |id: &Image, depth: &Image| GuideImages::new(&shade(8), id, depth, MAX_OBJECTS).expect("guides");
    // What is not followed need not be sampled or copied from.
    let unkept = |id: &Image, depth: &Image| {
        let guides = guides(id, depth);
        MotionPass::new(&gpu.context, &guides).map(|_| ()).expect_err("refused").to_string()
    };
    assert!(unkept(&id(U::STORAGE), &good_depth).contains("guide id is made for STORAGE"));
    assert!(unkept(&good_id, &depth(8, U::TRANSFER_SRC)).contains("guide depth is made for"));
    assert!(MotionPass::new(&gpu.context, guides(&good_id, &good_depth)).is_ok());
}
