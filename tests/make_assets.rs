//! The parts of the code that makes the assets, against values worked by hand.

use glam::{DVec2, DVec3};
use make_assets::{brush, curve, decimate, field, mesh::Mesh, pigment, random, surface_nets};

// Not every function of the example is called from here.
#[allow(dead_code)]
#[path = "../examples/make_assets/main.rs"]
mod make_assets;

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn fields_join_and_carve() {
    // Far apart, the smaller one; equal, a quarter of the width deeper: h = 1, d - k / 4.
    assert_eq!(field::union(1.0, 3.0, 0.5), 1.0);
    assert_eq!(field::union(0.0, 0.0, 0.8), -0.2);
    assert_eq!(field::carve(-1.0, 3.0, 0.5), -1.0);
    assert_eq!(field::carve(-1.0, -3.0, 0.5), 3.0);
}

#[test]
fn simple_shapes_have_exact_distances() {
    let p = DVec3::new(3.0, 0.0, 0.0);
    assert!(near(field::ellipsoid(p, DVec3::ZERO, DVec3::splat(1.0)), 2.0, 1e-12));
    assert!(near(field::ellipsoid(DVec3::ZERO, DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)), -1.0, 1e-12));
    // Turned to face +x, its long third axis points along x.
    let turned = field::ellipsoid_facing(p, DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 3.0));
    assert!(near(turned, 0.0, 1e-12), "{turned}");
    assert!(near(field::capsule(p, DVec3::ZERO, DVec3::Y, 0.5, 0.5), 2.5, 1e-12));
    assert!(near(field::rounded_box(p, DVec3::splat(1.0), 0.2), 2.0, 1e-12));
    assert!(near(field::rounded_box(DVec3::ZERO, DVec3::splat(1.0), 0.2), -1.0, 1e-12));
    let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(DVec2::from);
    assert!(near(field::polygon(DVec2::new(1.5, 1.0), &square), -0.5, 1e-12));
    assert!(near(field::polygon(DVec2::new(5.0, 6.0), &square), 5.0, 1e-12));
}

#[test]
fn the_circle_is_round() {
    let circle = curve::unit_circle(2);
    assert_eq!(circle.len(), 24);
    for (i, &(c, s)) in circle.iter().enumerate() {
        let angle = std::f64::consts::TAU * i as f64 / 24.0;
        assert!(near(c, angle.cos(), 1e-12) && near(s, angle.sin(), 1e-12));
    }
}

#[test]
fn splines_pass_through_their_knots() {
    let knots = [[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]];
    let points = curve::spline(&knots, 4);
    assert_eq!(points.len(), 9);
    assert_eq!([points[0], points[4], points[8]], knots);
    // On evenly spaced knots of a straight line the inner spans are straight.
    let line = curve::spline(&[[0.0], [1.0], [2.0], [3.0]], 2);
    assert!(near(line[3][0], 1.5, 1e-12));
}

fn volume(mesh: &Mesh) -> f64 {
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

#[test]
fn drawn_bodies_face_outwards() {
    // A prism over the regular 24-gon: area 12 sin(15 degrees) times the height.
    let area = 12.0 * 15.0_f64.to_radians().sin();
    let cylinder = curve::revolve(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], 2);
    assert!(near(volume(&cylinder), 2.0 * area, 1e-9), "{}", volume(&cylinder));
    for direction in [1.0, -1.0] {
        let rod =
            curve::sweep(&[[0.0, 0.0, 1.0, 1.0], [direction, 0.0, 1.0, 1.0], [3.0 * direction, 0.0, 1.0, 1.0]], 2);
        assert!(near(volume(&rod), 3.0 * area, 1e-9), "{}", volume(&rod));
    }
    // A pipe closed at one end: out along x, back inside with half the radius to 1.
    let stations = [[0.0, 1.0], [3.0, 1.0], [3.0, 0.5], [1.0, 0.5]].map(|[x, r]| [x, 0.0, r, r]);
    assert!(near(volume(&curve::sweep(&stations, 2)), 3.0 * area - 2.0 * area * 0.25, 1e-9));
}

fn sphere(p: DVec3) -> f64 {
    p.length() - 1.0
}

#[test]
fn a_sphere_is_polygonised_and_thinned() {
    let fine = surface_nets::polygonise(&sphere, DVec3::splat(-1.3), DVec3::splat(1.3), 0.1);
    assert!(fine.positions.iter().all(|p| near(p.length(), 1.0, 1e-3)));
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    assert!(near(volume(&fine), ball, 0.03), "{}", volume(&fine));
    // Euler's formula for a closed surface without handles: V - T / 2 = 2.
    assert_eq!(fine.positions.len(), fine.triangles.len() / 2 + 2);

    let thin = decimate::decimate(&fine, 400, &|_| 1.0);
    assert!((398..=400).contains(&thin.triangles.len()), "{}", thin.triangles.len());
    assert_eq!(thin.positions.len(), thin.triangles.len() / 2 + 2);
    assert!(near(volume(&thin), ball, 0.1), "{}", volume(&thin));
}

#[test]
fn detail_keeps_triangles_where_it_is_wanted() {
    let fine = surface_nets::polygonise(&sphere, DVec3::splat(-1.3), DVec3::splat(1.3), 0.1);
    let thin = decimate::decimate(&fine, 400, &|p| if p.y > 0.0 { 30.0 } else { 1.0 });
    let above = thin.positions.iter().filter(|p| p.y > 0.0).count();
    assert!(above * 3 > thin.positions.len() * 2, "{above} of {}", thin.positions.len());
}

#[test]
fn touching_corners_do_not_pinch_the_surface() {
    // Two balls that meet across an edge of the grid's cells, and two across a corner.
    for middle in [DVec3::new(0.5, 0.5, 0.0), DVec3::splat(0.5)] {
        let balls = |p: DVec3| (p - middle).length().min((p + middle).length()) - middle.length() * 0.999;
        let mesh = surface_nets::polygonise(&balls, DVec3::splat(-2.5), DVec3::splat(2.5), 1.0);
        let mut edges: Vec<[u32; 2]> =
            mesh.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
        let count = edges.len();
        edges.sort_unstable();
        edges.dedup();
        assert!(count > 0);
        assert_eq!(edges.len(), count, "no edge is used twice in one direction");
    }
}

#[test]
fn the_largest_piece_is_kept() {
    let mut mesh = curve::revolve(&[[0.0, 0.0], [1.0, 1.0], [0.0, 2.0]], 0);
    let large = curve::revolve(&[[0.0, 0.0], [1.0, 1.0], [1.0, 2.0], [0.0, 3.0]], 0);
    mesh.append(&large);
    let kept = mesh.largest_piece();
    assert_eq!((kept.positions.len(), kept.triangles.len()), (large.positions.len(), large.triangles.len()));
    assert!(near(volume(&kept), volume(&large), 1e-12));
}

#[test]
fn paints_mix_by_absorption() {
    let grey = DVec3::splat(0.5);
    assert!((pigment::mix(grey, grey, 0.3) - grey).abs().max_element() < 1e-9);
    // Stored 0.5 is reflectance 0.25, K/S = 0.75^2 / 0.5 = 1.125; white has 0. Half of it, 0.5625, gives
    // R = 1.5625 - sqrt(0.5625^2 + 1.125) = 0.361914, stored as its root 0.601593.
    let mixed = pigment::mix(grey, DVec3::ONE, 0.5);
    assert!((mixed - DVec3::splat(0.601593)).abs().max_element() < 1e-5, "{mixed}");
}

#[test]
fn random_numbers_repeat_and_stay_in_range() {
    let draw = |seed| {
        let mut random = random::Random::new(seed);
        (0..1000).map(|_| random.range(2.0, 3.0)).collect::<Vec<f64>>()
    };
    assert_eq!(draw(7), draw(7));
    assert_ne!(draw(7), draw(8));
    assert!(draw(7).iter().all(|v| (2.0..3.0).contains(v)));
    let mean = draw(7).iter().sum::<f64>() / 1000.0;
    // The mean of 1000 even draws has a standard deviation of 0.289 / sqrt(1000) = 0.0091.
    assert!(near(mean, 2.5, 0.04), "{mean}");
    let mut list: Vec<u32> = (0..50).collect();
    random::Random::new(1).shuffle(&mut list);
    assert_ne!(list, (0..50).collect::<Vec<_>>());
    list.sort_unstable();
    assert_eq!(list, (0..50).collect::<Vec<_>>());
}

#[test]
fn a_stroke_covers_its_path_and_nothing_else() {
    let mut random = random::Random::new(3);
    let ground = DVec3::new(0.2, 0.4, 0.2);
    let mut canvas = brush::Canvas::new(80, 40, |_| ground, &mut random);
    let bare = canvas.render();
    let red = DVec3::new(0.8, 0.1, 0.1);
    let path = [DVec2::new(10.0, 20.0), DVec2::new(40.0, 20.0), DVec2::new(70.0, 20.0)];
    canvas.lay(&brush::Stroke { path, width: 10.0, paints: [red, red], load: 1.2 }, &mut random);
    let painted = canvas.render();
    let at = |image: &[u8], x: usize, y: usize| [0, 1, 2].map(|k| image[(y * 80 + x) * 3 + k]);
    let mut changed_outside = 0;
    for y in 0..40 {
        for x in 0..80 {
            if !(12..28).contains(&y) || !(4..76).contains(&x) {
                changed_outside += usize::from(at(&bare, x, y) != at(&painted, x, y));
            }
        }
    }
    assert_eq!(changed_outside, 0);
    // Wet at the start: red all across the middle. Dry at the end: more of the ground is left there.
    let redness = |columns: std::ops::Range<usize>| {
        let count = (columns.len() * 6) as f64;
        let red = |x, y| f64::from(at(&painted, x, y)[0]) - f64::from(at(&painted, x, y)[1]);
        columns.flat_map(|x| (17..23).map(move |y| (x, y))).map(|(x, y)| red(x, y)).sum::<f64>() / count
    };
    assert!(redness(20..40) > 120.0, "{}", redness(20..40));
    assert!(redness(62..68) < redness(20..40) - 20.0, "{}", redness(62..68));
}
