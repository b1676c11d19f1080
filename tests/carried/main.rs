//! What keeps an image-based sequence calm, against plain oracles: texture that is carried and repaired, and blocks
//! that match the previous frame. Places, sources and choices exactly; drawn frames to a tolerance.

#[path = "../common/mod.rs"]
mod common;
mod oracles;
mod previous;
mod repair_by_hand;
mod sequence;

use common::{noise, Numbers, Validated};
use impasto::gpu::{Image, ImageDesc, Uploads};
use impasto::paint::{ColorStop, PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, DirectionalLight, Framing, GuidePass, Lights, Mesh, MeshOptions, Vec3};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::QuiltStages;
use impasto::synthesis::repair::{RepairParams, NOT_PASTED};
use impasto::technique::image::{ImageParams, ImageTechnique};
use sequence::{Expected, Model, Painted, Sequence, Strip};

/// Two boxes, the second one behind and above the first.
const BOXES: &str = "
o near\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 -2\nv 1 -1 -2\nv 1 1 -2\nv -1 1 -2
f 1 2 3 4\nf 6 5 8 7\nf 2 6 7 3\nf 5 1 4 8\nf 4 3 7 8\nf 5 6 2 1
o far\nv 0 0 -4\nv 3 0 -4\nv 3 3 -4\nv 0 3 -4\nf 9 10 11 12\n";

/// A wall that fills the picture, of one shade all over.
const WALL: &str = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";

fn builtin(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)).expect("an asset")
}

fn load(bytes: &[u8]) -> Mesh {
    Mesh::parse(bytes, "test", &MeshOptions::default()).expect("a mesh").mesh
}

fn strip(name: &str) -> Strip {
    let sample = PaintSample::decode(&builtin(name), name.as_ref()).expect("a strip");
    let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default()).expect("a trajectory");
    Strip { texture: TextureDifference::extract(&sample, &trajectory), trajectory }
}

/// A strip of noise, on which every texel tells where it is from.
fn noise_strip(width: u32, height: u32, seed: u32) -> Strip {
    let unit = |value: u8| f32::from(value) / 255.0 * 1.2 - 0.6;
    let pixels = noise(width, height, seed).iter().map(|&[r, g, b, _]| [r, g, b].map(unit)).collect();
    let stops = ColorStop::parse_list("0:#405060,1:#b0a090").expect("stops");
    let trajectory = Trajectory::from_stops(&stops, 64).expect("a trajectory");
    Strip { texture: TextureDifference::from_pixels(width, height, pixels).expect("a texture"), trajectory }
}

fn quilt(block_px: u32, overlap_px: u32) -> QuiltParams {
    QuiltParams { block_px, overlap_px, seed: 7, ..Default::default() }
}

fn framed(mesh: &Mesh, size: (u32, u32), yaw_deg: f32) -> Camera {
    let framing = Framing { yaw_deg, ..Default::default() };
    Camera::framing(mesh, &framing, size.0 as f32 / size.1 as f32).expect("a camera")
}

/// Looks straight at the [`WALL`] from near.
fn before_the_wall(mesh: &Mesh) -> Camera {
    let framing = Framing { yaw_deg: 0.0, pitch_deg: 0.0, distance: Some(0.3), ..Default::default() };
    Camera::framing(mesh, &framing, 1.0).expect("a camera")
}

/// Light that falls on the [`WALL`] at this cosine: 1 straight, -1 from behind, which leaves it dark.
fn light(cosine: f32) -> Lights {
    let direction = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    Lights::new(vec![DirectionalLight::new(direction, 1.0).expect("a light")]).expect("lights")
}

/// What motion has where the surface was in sight.
const SHOWN: u32 = 1 << 31;

/// A motion picture: `way` leads from each pixel to where its surface was; none where that was not in sight.
fn motion(size: (u32, u32), way: impl Fn(f64, f64) -> Option<(f64, f64)>) -> Vec<u32> {
    let bits = |px: f64| (16_384.0 + (64.0 * px).round()) as u32;
    let word = |(dx, dy)| SHOWN | bits(dx) | bits(dy) << 15;
    let pixels = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (f64::from(x), f64::from(y))));
    pixels.map(|(x, y)| way(x, y).map_or(0, word)).collect()
}

/// The motion of a picture that is turned and enlarged about its middle, and then shifted.
fn turned(size: (u32, u32), degrees: f64, zoom: f64, shift: (f64, f64)) -> Vec<u32> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (mx, my) = (f64::from(size.0) / 2.0, f64::from(size.1) / 2.0);
    motion(size, |x, y| {
        let (dx, dy) = ((x - mx) / zoom, (y - my) / zoom);
        Some((mx + cos * dx + sin * dy + shift.0 - x, my - sin * dx + cos * dy + shift.1 - y))
    })
}

/// Motion in which some squares come into sight, moving in a known way or not, and others move each for itself.
fn torn(size: (u32, u32), seed: u32) -> Vec<u32> {
    let mut numbers = Numbers(seed);
    let squares: Vec<u32> = (0..400).map(|_| numbers.next()).collect();
    let number_at = |x: usize, y: usize| squares[(x / 11 + 20 * (y / 11)) % 400];
    let mut words = motion(size, |x, y| {
        let number = number_at(x as usize, y as usize);
        let far = |bits: u32| f64::from(bits % 512) / 32.0 - 8.0;
        match number % 5 {
            0 => None,
            1 => Some((far(number >> 8), far(number >> 17))),
            _ => Some((0.0, 0.0)),
        }
    });
    for (i, word) in words.iter_mut().enumerate() {
        let hidden = number_at(i % size.0 as usize, i / size.0 as usize) % 7 == 3;
        *word &= if hidden { !SHOWN } else { u32::MAX };
    }
    words
}

fn at_rest(size: (u32, u32)) -> Vec<u32> {
    motion(size, |_, _| Some((0.0, 0.0)))
}

/// Paints frames of a sequence and compares each with the oracle; what was painted and what was expected of the last.
fn check(sequence: &mut Sequence, what: &str, frames: &[(Camera, Lights, Vec<u32>)]) -> Vec<(Painted, Expected)> {
    let mut checked = Vec::new();
    for (number, (camera, lights, motion)) in (1..).zip(frames) {
        let painted = sequence.next(camera, lights, motion, number);
        let expected = sequence.expect(&painted, motion, number);
        if let Err(difference) = painted.difference(&expected) {
            panic!("{what}, frame {number}: {difference}");
        }
        sequence.places = expected.places.clone();
        checked.push((painted, expected));
    }
    checked
}

/// How many pixels were synthesised anew in a frame, for all paints.
fn pasted(painted: &Painted) -> usize {
    painted.sources.iter().flatten().filter(|&&from| from != NOT_PASTED).count()
}

/// Motions of every kind, one after the other.
fn motions(size: (u32, u32)) -> Vec<Vec<u32>> {
    vec![
        at_rest(size),
        turned(size, 0.0, 1.0, (3.0, -2.0)),
        turned(size, 0.0, 1.0, (0.3, -1.7)),
        turned(size, 3.0, 1.02, (0.0, 0.0)),
        turned(size, 4.0, 1.03, (-0.5, 0.5)),
        turned(size, -2.0, 0.9, (-6.4, 0.1)),
        torn(size, 77),
        turned(size, 40.0, 1.0, (0.0, 0.0)),
        at_rest(size),
        turned(size, 0.0, 1.6, (0.0, 0.0)),
        turned(size, 1.0, 1.0, (40.0, 25.0)),
        torn(size, 5),
        at_rest(size),
    ]
}

#[test]
fn frames_of_two_paints_equal_the_oracle() {
    let gpu = Validated::new();
    let mesh = load(BOXES.as_bytes());
    for (size, quilt, k, repair) in [
        ((97, 83), quilt(16, 4), Some(1.0), RepairParams::default()),
        ((80, 75), quilt(16, 4), Some(4.0), RepairParams::default()),
        ((64, 70), quilt(9, 3), None, RepairParams { stretch: 1.05, tolerance: 0.1, slack: 0.0 }),
        (
            (90, 50),
            QuiltParams { tolerance: 0.5, ..quilt(24, 12) },
            Some(0.3),
            RepairParams { stretch: 1.5, tolerance: 2.0, slack: 3.0 },
        ),
    ] {
        let strips = [noise_strip(180, 110, 3), noise_strip(77, 60, 4)];
        let params = ImageParams { quilt, k, ..Default::default() };
        let model = Model { mesh: &mesh, strips: &strips, objects: &[0, 1] };
        let mut sequence = Sequence::new(&gpu, &model, size, &params, &repair);
        let (first, lights) = (framed(&mesh, size, 25.0), Lights::default());
        sequence.start(&first, &lights);
        // The camera turns, so that outlines move and shades change.
        let turns = (0..).map(|i| framed(&mesh, size, 25.0 + 1.5 * i as f32));
        let frames: Vec<_> =
            turns.zip(motions(size)).map(|(camera, motion)| (camera, lights.clone(), motion)).collect();
        let checked = check(&mut sequence, &format!("{size:?}"), &frames);
        // The sequence must be of use: something stays, something is repaired, something is a misfit.
        let kept = |painted: &Painted| painted.sources.iter().flatten().filter(|&&from| from == NOT_PASTED).count();
        assert!(checked.iter().any(|(painted, _)| pasted(painted) > 200 && kept(painted) > 200), "{size:?}");
        let misfits = checked.iter().flat_map(|(painted, _)| &painted.carried).flatten();
        assert!(misfits.filter(|place| place[3] & 0x4000 != 0).count() > 50, "{size:?}");
    }
}

#[test]
fn frames_of_a_model_and_real_paint_equal_the_oracle() {
    let gpu = Validated::new();
    let mesh = load(&builtin("teapot_on_table.obj"));
    let size = (160, 120);
    let strips = [strip("strip_green_yellow.png"), strip("strip_dark_red.png")];
    let params = ImageParams { quilt: quilt(32, 6), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0, 1] };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams::default());
    sequence.start(&framed(&mesh, size, 25.0), &Lights::default());
    let turns = (0..5).map(|i| framed(&mesh, size, 25.0 + 2.0 * i as f32));
    let motions = (0..5).map(|i| turned(size, 0.5, 1.01, (0.25 * f64::from(i), 0.1)));
    let frames: Vec<_> = turns.zip(motions).map(|(camera, motion)| (camera, Lights::default(), motion)).collect();
    check(&mut sequence, "teapot", &frames);
}

/// Texture follows the shade: where that changes much, it comes from another part of the strip.
#[test]
fn a_change_of_light_asks_for_other_texture() {
    let gpu = Validated::new();
    let mesh = load(WALL.as_bytes());
    let size = (60, 60);
    let strips = [noise_strip(200, 64, 9)];
    let params = ImageParams { quilt: quilt(16, 4), k: Some(1.0), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0] };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams::default());
    let camera = before_the_wall(&mesh);
    sequence.start(&camera, &light(0.2));
    let cosines = [0.2, 0.22, 0.8, 0.8, 0.3];
    let frames: Vec<_> = cosines.iter().map(|&cosine| (camera, light(cosine), at_rest(size))).collect();
    let pixels = size.0 as usize * size.1 as usize;
    let pasted: Vec<usize> =
        check(&mut sequence, "light", &frames).iter().map(|(painted, _)| pasted(painted)).collect();
    assert_eq!([pasted[0], pasted[1], pasted[3]], [0; 3], "what fits stays");
    assert!(pasted[2] > pixels * 9 / 10 && pasted[4] > pixels * 9 / 10, "{pasted:?}");
}

/// Where there are many positions, a frame compares every fifth row of them, and the next frame the rows below.
#[test]
fn rows_of_positions_take_turns() {
    let gpu = Validated::new();
    let mesh = load(WALL.as_bytes());
    let size = (60, 60);
    let strips = [noise_strip(180, 110, 9)];
    let params = ImageParams { quilt: quilt(16, 4), k: Some(4.0), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0] };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams::default());
    let camera = before_the_wall(&mesh);
    sequence.start(&camera, &light(0.2));
    let nothing = vec![0; size.0 as usize * size.1 as usize];
    let frames: Vec<_> = (0..6).map(|_| (camera, light(0.2), nothing.clone())).collect();
    for (number, (painted, _)) in (1..).zip(check(&mut sequence, "rows", &frames)) {
        // 95 rows of 129 positions are five times 2,048, and some.
        let rows: Vec<u32> = painted.records[0].iter().map(|block| block.sy % 5).collect();
        assert_eq!(rows, [number % 5; 25], "frame {number}");
    }
}

/// So many blocks that a round does not hold all of a parity's.
#[test]
fn bands_of_rounds_equal_the_oracle() {
    let gpu = Validated::new();
    let mesh = load(WALL.as_bytes());
    let size = (360, 200);
    let strips = [noise_strip(20, 2200, 1)];
    let params = ImageParams { quilt: quilt(4, 1), k: Some(0.0), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0] };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams::default());
    // 2,197 rows of positions, padded to 8 columns each, are 18 groups of 1,024 positions; 64 MiB hold the errors of
    // 910 blocks. A round has 60 blocks in each second row.
    sequence.band_rows = 2 * (910 / 60);
    let camera = before_the_wall(&mesh);
    sequence.start(&camera, &light(0.5));
    let motion = torn(size, 3);
    let painted = sequence.next(&camera, &light(0.5), &motion, 1);
    assert!(pasted(&painted) > 5_000, "{}", pasted(&painted));
    assert_eq!(painted.difference(&sequence.expect(&painted, &motion, 1)), Ok(()));
    sequence.band_rows = u32::MAX;
    assert!(painted.difference(&sequence.expect(&painted, &motion, 1)).is_err(), "bands make a difference");
}

/// Texture that goes on beyond its end stretches nothing there, wherever it comes from.
#[test]
fn texture_from_the_corner_of_the_strip_fits_beyond_its_end() {
    let gpu = Validated::new();
    let mesh = load(WALL.as_bytes());
    let size = (40, 40);
    // Every block is the strip's left end.
    let strips = [noise_strip(40, 16, 6)];
    let params = ImageParams { quilt: quilt(16, 4), k: Some(0.0), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0] };
    let repair = RepairParams { slack: 3.0, ..Default::default() };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &repair);
    let camera = before_the_wall(&mesh);
    sequence.start(&camera, &light(-1.0));
    let shifts = [(1.3, 0.4), (-1.0, 0.0)];
    let frames = shifts.map(|shift| (camera, light(-1.0), turned(size, 0.0, 1.0, shift)));
    let checked = check(&mut sequence, "corner", &frames);
    // From 1.3, 0.4 texels one pixel to the left.
    assert_eq!(checked[1].0.carried[0][0], [19, 0, 26, 0x8000]);
}

#[test]
fn nothing_changes_where_nothing_moves() {
    let gpu = Validated::new();
    let mesh = load(BOXES.as_bytes());
    let size = (96, 80);
    let strips = [noise_strip(160, 100, 3), noise_strip(90, 60, 4)];
    let params = ImageParams { quilt: quilt(16, 4), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0, 1] };
    // Blocks beside each other may come from far apart; all that fits the window is near enough.
    let repair = RepairParams { slack: 2.0, ..Default::default() };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &repair);
    let (camera, lights) = (framed(&mesh, size, 25.0), Lights::default());
    let first = sequence.start(&camera, &lights);
    for number in 1..4 {
        let painted = sequence.next(&camera, &lights, &at_rest(size), number);
        assert_eq!(pasted(&painted), 0);
        assert!(painted.frame == first.frame && painted.places == first.places, "frame {number}");
    }
}

#[test]
fn a_shift_by_whole_pixels_moves_texture_exactly() {
    let gpu = Validated::new();
    let mesh = load(WALL.as_bytes());
    let size = (100, 90);
    let strips = [noise_strip(200, 100, 5)];
    let params = ImageParams { quilt: quilt(16, 4), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0] };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams { slack: 2.0, ..Default::default() });
    let camera = before_the_wall(&mesh);
    let mut before = sequence.start(&camera, &light(0.5));
    for (number, (dx, dy)) in (1..).zip([(3, -2), (-5, 0), (0, 7)]) {
        let moved = turned(size, 0.0, 1.0, (f64::from(dx), f64::from(dy)));
        let painted = sequence.next(&camera, &light(0.5), &moved, number);
        let (width, height) = (size.0 as i32, size.1 as i32);
        let mut compared = 0;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let (from_x, from_y) = (x + dx, y + dy);
            let at = (y * width + x) as usize;
            let inside = (0..width).contains(&from_x) && (0..height).contains(&from_y);
            if inside && painted.sources[0][at] == NOT_PASTED {
                let from = (from_y * width + from_x) as usize;
                assert_eq!(painted.frame[at], before.frame[from], "{x}, {y}");
                assert_eq!(painted.places[at], before.places[from], "{x}, {y}");
                compared += 1;
            }
        }
        assert!(compared > painted.frame.len() / 2, "{compared} pixels stay");
        before = painted;
    }
}

#[test]
fn every_covered_pixel_is_painted_and_runs_are_alike() {
    let gpu = Validated::new();
    let mesh = load(BOXES.as_bytes());
    let size = (97, 83);
    let strips = [noise_strip(180, 110, 3), noise_strip(77, 60, 4)];
    let params = ImageParams { quilt: quilt(16, 4), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0, 1] };
    let run = || {
        let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams::default());
        sequence.start(&framed(&mesh, size, 25.0), &Lights::default());
        let frames = (1..).zip(motions(size)).map(|(number, motion)| {
            // Outlines leap from frame to frame.
            sequence.next(&framed(&mesh, size, 25.0 + 30.0 * number as f32), &Lights::default(), &motion, number)
        });
        frames.collect::<Vec<_>>()
    };
    let painted = run();
    for frame in &painted {
        let mut covered = 0;
        for (i, &paint) in frame.paint_at.iter().enumerate() {
            assert_eq!(frame.places[i][3] & 0x8000 != 0, paint != 0, "a place at pixel {i}");
            assert_eq!(frame.frame[i][3], if paint == 0 { 0 } else { 255 });
            if paint == 0 {
                continue;
            }
            let layer = paint as usize - 1;
            let has_texture = frame.sources[layer][i] != NOT_PASTED || frame.carried[layer][i][3] & 0x8000 != 0;
            assert!(has_texture, "pixel {i}");
            covered += 1;
        }
        assert!(covered > 500);
    }
    let again = run();
    assert!(painted.iter().zip(&again).all(|(a, b)| a == b), "the same sequence twice");
}

#[test]
fn the_comparison_notices_every_kind_of_difference() {
    let gpu = Validated::new();
    let mesh = load(BOXES.as_bytes());
    let size = (97, 83);
    let strips = [noise_strip(180, 110, 3), noise_strip(77, 60, 4)];
    let params = ImageParams { quilt: quilt(16, 4), ..Default::default() };
    let model = Model { mesh: &mesh, strips: &strips, objects: &[0, 1] };
    let mut sequence = Sequence::new(&gpu, &model, size, &params, &RepairParams::default());
    sequence.start(&framed(&mesh, size, 25.0), &Lights::default());
    let camera = framed(&mesh, size, 27.0);
    // Two frames: the first one leaves places that are turned and stretched.
    let frames = [turned(size, 10.0, 1.06, (0.0, 0.0)), torn(size, 77)];
    check(&mut sequence, "first", &[(camera, Lights::default(), frames[0].clone())]);
    let painted = sequence.next(&camera, &Lights::default(), &frames[1], 2);
    let expected = sequence.expect(&painted, &frames[1], 2);
    assert_eq!(painted.difference(&expected), Ok(()));

    let covered = painted.paint_at.iter().position(|&paint| paint == 1).expect("a pixel");
    let plant = |change: &dyn Fn(&mut Painted)| {
        let mut planted = painted.clone();
        change(&mut planted);
        planted.difference(&expected).expect_err("a planted fault must be noticed")
    };
    assert!(plant(&|p| p.carried[1][17][0] ^= 1).contains("carried"));
    assert!(plant(&|p| p.sources[0][3] ^= 1).contains("source"));
    assert!(plant(&|p| p.places[covered][0] ^= 1).contains("place"));
    assert!(plant(&|p| p.frame[covered][1] ^= 0x40).contains("frame"));
    assert!(plant(&|p| p.records[0][0].allowed[0] ^= 1).contains("block"));
    assert!(plant(&|p| p.records[1].truncate(1)).contains("blocks"));

    // Other input makes another frame.
    let mut one_step = frames[1].clone();
    one_step[covered] += 1;
    assert!(painted.difference(&sequence.expect(&painted, &one_step, 2)).is_err(), "motion by a step");
    assert!(painted.difference(&sequence.expect(&painted, &frames[1], 3)).is_err(), "the frame's number");
    let mut other = |change: &dyn Fn(&mut Sequence)| {
        let (params, repair) = (sequence.params, sequence.repair);
        change(&mut sequence);
        assert!(painted.difference(&sequence.expect(&painted, &frames[1], 2)).is_err());
        (sequence.params, sequence.repair) = (params, repair);
    };
    other(&|s| s.params.quilt.seed += 1);
    other(&|s| s.repair.tolerance = 0.0);
    other(&|s| s.params.k = Some(0.5));
    other(&|s| s.repair.stretch = 1.06);
    other(&|s| s.repair.slack = 0.0);
}

#[test]
fn wrong_use_of_carrying_is_told() {
    let gpu = Validated::new();
    let mesh = load(WALL.as_bytes());
    let strips = [noise_strip(64, 40, 5)];
    let params = ImageParams { quilt: quilt(16, 4), ..Default::default() };
    let mut uploads = Uploads::default();
    let guides = |size, uploads: &mut Uploads| GuidePass::new(&gpu.context, uploads, &mesh, size).expect("guides");
    let (pass, other_pass) = (guides((40, 30), &mut uploads), guides((41, 30), &mut uploads));
    let stages = QuiltStages::new(&gpu.context);
    let paints: Vec<_> = strips.iter().map(Strip::paint).collect();
    let mut technique =
        ImageTechnique::new(&gpu.context, &mut uploads, &stages, &pass, &paints, &[0], &params).expect("a technique");
    let picture = |width, height| {
        let desc = ImageDesc::storage_2d(width, height, ash::vk::Format::R32_UINT);
        Image::new(&gpu.context, "motion", &desc).expect("a picture")
    };
    let (motion, narrow) = (picture(40, 30), picture(39, 30));
    let mut refused = |pass: &GuidePass, paints: &[_], motion: &Image, repair: RepairParams| {
        let result = technique.carry(&gpu.context, &mut uploads, pass, paints, motion, &repair);
        result.expect_err("must be refused").to_string()
    };
    let fine = RepairParams::default();
    assert!(refused(&pass, &paints, &narrow, fine).contains("motion is 39x30, but must be 40x30"));
    let floats = ImageDesc::storage_2d(40, 30, ash::vk::Format::R32_SFLOAT);
    let floats = Image::new(&gpu.context, "motion", &floats).expect("a picture");
    assert!(refused(&pass, &paints, &floats, fine).contains("motion is R32_SFLOAT, but must be R32_UINT"));
    assert!(refused(&other_pass, &paints, &motion, fine).contains("guides is 41x30, but must be 40x30"));
    assert!(refused(&pass, &[], &motion, fine).contains("paints is 0, but must be the 1 of the technique"));
    for stretch in [1.04, 1.51, 0.0, f32::NAN] {
        let message = refused(&pass, &paints, &motion, RepairParams { stretch, ..fine });
        assert!(message.contains("stretch is") && message.contains("1.05 to 1.5"), "{message}");
    }
    for slack in [-0.1, 100.5, f32::INFINITY, f32::NAN] {
        let message = refused(&pass, &paints, &motion, RepairParams { slack, ..fine });
        assert!(message.contains("slack is") && message.contains("0 to 100 block sizes"), "{message}");
    }
    for tolerance in [-0.1, 10.5, f32::NAN] {
        let message = refused(&pass, &paints, &motion, RepairParams { tolerance, ..fine });
        assert!(message.contains("repair tolerance is") && message.contains("0 to 10"), "{message}");
    }
    for (stretch, slack) in [(1.05, 0.0), (1.5, 100.0)] {
        assert!(RepairParams { stretch, slack, ..fine }.check().is_ok());
    }
    assert!(technique.carry(&gpu.context, &mut uploads, &pass, &paints, &motion, &fine).is_ok());
}
