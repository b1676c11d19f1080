//! Motion between two moments, by values worked by hand.

use impasto::metric::{Motion, Picture, Shades};
use impasto::scene::{Camera, GuideOracle, Lights, Mesh, MeshOptions, Moment, Pose, Vec3};

const SIDE: u32 = 64;

/// A camera 5 before the plane z = 0, moved to the right; it sees 64 pixels over 2 * 5 * tan(45 / 2 degrees).
fn camera(right: f32, mesh: &Mesh) -> Camera {
    let (eye, target) = (Vec3::new(right, 0.0, 5.0), Vec3::new(right, 0.0, 0.0));
    Camera::look_at(eye, target, None, 45.0).expect("a camera").fit_depth(mesh)
}

/// A large wall, and a small board 2 before its middle.
fn wall_and_board() -> Mesh {
    let text = "o wall\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n\
                o board\nv -0.5 -0.5 2\nv 0.5 -0.5 2\nv 0.5 0.5 2\nv -0.5 0.5 2\nf 5 6 7 8\n";
    Mesh::parse(text.as_bytes(), "scene", &MeshOptions::default()).expect("a mesh").mesh
}

#[test]
fn what_stands_nearer_moves_further_and_hides_what_is_behind_it() {
    let mesh = wall_and_board();
    let moments = [0.0, 0.5].map(|right| Moment::at_rest(camera(right, &mesh), Lights::default()));
    let guides = moments.each_ref().map(|moment| GuideOracle::render(&mesh, moment, SIDE, SIDE).expect("a guide"));
    let motion = Motion::between([&moments[0], &moments[1]], [&guides[0], &guides[1]]).expect("a motion");
    assert_eq!(motion.size(), (SIDE, SIDE));
    // Pixels to a unit of the world at a distance.
    let scale = |distance: f64| f64::from(SIDE) / (2.0 * distance * (22.5_f64).to_radians().tan());
    let way = |distance: f64| -(0.5 * scale(distance)).round() as i64;
    let (wall, board) = (way(5.0), way(3.0));
    assert!(board < wall && wall < 0);
    let mut hidden = 0;
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let id = guides[0].id[(y * SIDE + x) as usize];
        let expected = i64::from(x) + if id == 1 { wall } else { board };
        match motion.pixel(x, y) {
            Some((tx, ty)) => {
                // The way is not a whole number of pixels, so that rounding may go either way.
                assert!(ty == y && (i64::from(tx) - expected).abs() <= 1, "{x}, {y}: {tx}, {ty}");
                assert_eq!(guides[1].id[(ty * SIDE + tx) as usize], id);
            }
            None if expected < 1 => {}
            None => {
                // What the board hides now stands to its left, where the board moves over the wall.
                let there = guides[1].id[(y * SIDE + expected as u32) as usize];
                assert!(id != there || guides[1].id[(y * SIDE + expected as u32 - 1) as usize] != id, "{x}, {y}");
                hidden += 1;
            }
        }
    }
    assert!(hidden > 20, "{hidden}");
    assert_eq!(motion.pixel(SIDE, 0), None);
    let still = Motion::between([&moments[0], &moments[0]], [&guides[0], &guides[0]]).expect("a motion");
    assert!((0..SIDE).all(|x| still.pixel(x, 20) == Some((x, 20))));
    let small = GuideOracle::render(&mesh, &moments[1], 9, 9).expect("a guide");
    assert!(Motion::between([&moments[0], &moments[1]], [&guides[0], &small]).is_err());
    file_gives_the_same(&motion);
}

fn file_gives_the_same(motion: &Motion) {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("motion.png");
    let pixels: Vec<u16> = motion.to_rgb16().into_flattened();
    let picture: image::ImageBuffer<image::Rgb<u16>, _> =
        image::ImageBuffer::from_raw(SIDE, SIDE, pixels).expect("a picture");
    picture.save(&path).expect("saved");
    assert_eq!(&Motion::load(&path).expect("a motion"), motion);
    let coarse = dir.path().join("coarse.png");
    image::RgbImage::new(SIDE, SIDE).save(&coarse).expect("saved");
    assert!(Motion::load(&coarse).expect_err("refused").to_string().contains("coarse.png: is no motion"));
    std::fs::write(&path, "text").expect("written");
    assert!(Motion::load(&path).expect_err("refused").to_string().contains("motion.png"));
}

#[test]
fn an_object_that_moves_takes_its_pixels_along() {
    let mesh = wall_and_board();
    let still = Moment::at_rest(camera(0.0, &mesh), Lights::default());
    // The board turns by half about the view axis and goes 0.5 back: each of its points goes to the other side of the
    // middle, and further in, for it is 3.5 away instead of 3.
    let pose = Pose::new(180.0, Vec3::Z, Vec3::ZERO, -0.5 * Vec3::Z).expect("a pose");
    let moved = Moment { poses: vec![Pose::REST, pose], ..still.clone() };
    let guides = [&still, &moved].map(|m| GuideOracle::render(&mesh, m, SIDE, SIDE).expect("a guide"));
    let motion = Motion::between([&still, &moved], [&guides[0], &guides[1]]).expect("a motion");
    let mut seen = 0;
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let to = motion.pixel(x, y);
        if guides[0].id[(y * SIDE + x) as usize] == 2 {
            let across = |at: u32| {
                let middle = f64::from(SIDE) / 2.0;
                middle - (f64::from(at) + 0.5 - middle) * 3.0 / 3.5 - 0.5
            };
            let (tx, ty) = to.expect("all of it is shown");
            let off = (f64::from(tx) - across(x)).abs().max((f64::from(ty) - across(y)).abs());
            assert!(off <= 0.51, "{x}, {y}: {tx}, {ty}");
            seen += 1;
        } else {
            assert!(to.is_none_or(|to| to == (x, y)), "the wall stands");
        }
    }
    assert!(seen > 200, "{seen}");
}

#[test]
fn shades_and_masks_are_read() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("shade.png");
    let alpha = |x: u32| if x == 1 { 65_534 } else { u16::MAX };
    let shade = image::ImageBuffer::from_fn(4, 2, |x, y| image::LumaA([(x * 10_000 + y) as u16, alpha(x)]));
    shade.save(&path).expect("saved");
    let shades = Shades::load(&path).expect("shades");
    assert_eq!(shades.size(), (4, 2));
    assert!((shades.at(3, 1).expect("a shade") - 30_001.0 / 65_535.0).abs() < 1e-12);
    assert_eq!((shades.at(4, 0), shades.at(0, 2), shades.at(1, 0)), (None, None, None));

    let frame = Picture::new(2, 1, vec![[9, 9, 9, 255]; 2]).expect("a picture");
    let mask = Picture::new(2, 1, vec![[0, 127, 255, 255], [0, 128, 0, 255]]).expect("a mask");
    let masked = frame.clone().masked(&mask).expect("masked");
    assert!(!masked.is_inside(0, 0) && masked.is_inside(1, 0));
    let other = Picture::new(1, 1, vec![[255; 4]]).expect("a mask");
    assert!(frame.masked(&other).expect_err("refused").to_string().contains("mask is 1 x 1"));
}
