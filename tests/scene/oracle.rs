//! The plain rasteriser, against geometry that can be worked out by hand.

use impasto::scene::{
    Camera, DirectionalLight, Framing, Guide, GuideOracle, Lights, Mesh, MeshOptions, Moment, Object, Vec3,
    MAX_GUIDE_SIDE_PX,
};

use crate::{mesh, sphere};

fn render(mesh: &Mesh, camera: &Camera, width: u32, height: u32) -> Guide {
    GuideOracle::render(mesh, &Moment::at_rest(*camera, Lights::default()), width, height).expect("a guide")
}

/// A camera at distance 8 that sees the square from -4 to 4 in the plane z = 0: with 8x8 pixels, one unit each.
fn square_on() -> Camera {
    let fov = 2.0 * 0.5_f32.atan().to_degrees();
    Camera::look_at(Vec3::new(0.0, 0.0, 8.0), Vec3::ZERO, None, fov).expect("a camera")
}

fn rows(guide: &Guide) -> Vec<String> {
    let digit = |&id: &u32| char::from_digit(id, 10).expect("few objects");
    guide.id.chunks_exact(guide.width as usize).map(|row| row.iter().map(digit).collect()).collect()
}

#[test]
fn pixels_belong_to_the_triangle_over_their_centre() {
    // Corners in pixels from the upper left: (1, 1), (1, 7), (7, 7). Centres on the slanted edge lie on the right of
    // it, so they do not belong to it; those on its left and upper edges would.
    let triangle = mesh("v -3 3 0\nv -3 -3 0\nv 3 -3 0\nf 1 2 3\n");
    let guide = render(&triangle, &square_on(), 8, 8);
    let below = ["00000000", "00000000", "01000000", "01100000", "01110000", "01111000", "01111100", "00000000"];
    assert_eq!(rows(&guide), below);
    // The other half of the square has the slanted edge on its left, and gets them.
    let triangle = mesh("v -3 3 0\nv 3 -3 0\nv 3 3 0\nf 1 2 3\n");
    let guide = render(&triangle, &square_on(), 8, 8);
    let above = ["00000000", "01111110", "00111110", "00011110", "00001110", "00000110", "00000010", "00000000"];
    assert_eq!(rows(&guide), above);
}

/// Triangles that share corners cover every pixel once: which of them is drawn first makes no difference.
#[test]
fn neighbours_leave_no_gap_and_do_not_overlap() {
    let mut positions = vec![[0.5, -0.5, 0.0]];
    let mut triangles = Vec::new();
    let ring = 9;
    for k in 0..ring {
        let (sin, cos) = (k as f32 / ring as f32 * std::f32::consts::TAU).sin_cos();
        // Some corners on pixel centres and edges.
        positions.push([(7.0 * cos).round() + 0.5 * (k % 2) as f32, (7.0 * sin).round(), 0.0]);
        triangles.push([0, k + 1, (k + 1) % ring + 1]);
    }
    let draw = |order: &[usize]| {
        let indices: Vec<u32> = order.iter().flat_map(|&k| triangles[k].map(|i| i as u32)).collect();
        let part = |&k: &usize| Object { name: k.to_string(), first_index: 0, index_count: 3 };
        let mut objects: Vec<Object> = order.iter().map(part).collect();
        objects.iter_mut().enumerate().for_each(|(i, object)| object.first_index = 3 * i as u32);
        let options = MeshOptions::default();
        let mesh = Mesh::build(positions.clone(), None, &indices, &objects, &options).expect("a fan").mesh;
        let guide = render(&mesh, &square_on(), 64, 64);
        let name = |&id: &u32| id.checked_sub(1).map(|object| mesh.objects()[object as usize].name.clone());
        guide.id.iter().map(name).collect::<Vec<_>>()
    };
    let order: Vec<usize> = (0..ring).collect();
    let reversed: Vec<usize> = (0..ring).rev().collect();
    let drawn = draw(&order);
    assert_eq!(drawn, draw(&reversed));
    // The ring around the picture reaches beyond its corners, so no pixel may be left free.
    assert!(drawn.iter().all(Option::is_some));
}

#[test]
fn a_sphere_is_shaded_as_equation_3_1_says() {
    let ball = sphere(64, 3.0);
    let camera = square_on().fit_depth(&ball);
    let side = 96;
    let guide = render(&ball, &camera, side, side);
    let mut compared = 0;
    for y in 0..side {
        for x in 0..side {
            // The ray through the pixel's centre, and where it meets the ball of radius 3.
            let [u, v] = [x, y].map(|pixel| (pixel as f32 + 0.5) / side as f32 * 8.0 - 4.0);
            let ray = Vec3::new(u, -v, -8.0).normalize();
            let half = ray.dot(camera.eye());
            let inside = half * half - (64.0 - 9.0);
            let at = (y * side + x) as usize;
            if inside < 0.0 {
                assert!(inside > -0.5 || guide.id[at] == 0, "{x} {y}");
                continue;
            }
            // Outlines differ by the facets; there the normal turns fast, too.
            if inside > 0.5 {
                let distance = -half - inside.sqrt();
                let point = camera.eye() + distance * ray;
                assert_eq!(guide.id[at], 1);
                let shade = Lights::default().shade(point / 3.0);
                assert!((guide.shade[at] - shade).abs() < 0.01, "{x} {y}: {} {shade}", guide.shade[at]);
                let seen = camera.view_projection(1.0).expect("square").project_point3(point);
                assert!((guide.depth[at] - seen.z).abs() < 2e-3, "{x} {y}: {} {}", guide.depth[at], seen.z);
                compared += 1;
            }
        }
    }
    assert!(compared > 3000, "{compared}");
}

#[test]
fn the_back_of_a_triangle_is_lit_as_a_back() {
    let triangle = mesh("v -3 -3 0\nv 3 -3 0\nv 0 3 0\nf 1 2 3\n");
    let front = square_on();
    let behind = Camera::look_at(Vec3::new(0.0, 0.0, -8.0), Vec3::ZERO, None, front.fov_y_deg()).expect("a camera");
    let lights = Lights::from(DirectionalLight::new(Vec3::new(0.0, 0.6, 0.8), 1.0).expect("a light"));
    for (camera, shade) in [(front, 0.9), (behind, 0.1)] {
        let guide = GuideOracle::render(&triangle, &Moment::at_rest(camera, lights.clone()), 9, 9).expect("a guide");
        assert_eq!(guide.id[4 * 9 + 4], 1);
        assert!((guide.shade[4 * 9 + 4] - shade).abs() < 1e-6);
        assert_eq!((guide.shade[0], guide.id[0], guide.depth[0]), (0.0, 0, 1.0));
    }
}

/// A floor that runs towards the viewer, below and behind him, with normals that turn along it.
fn floor() -> Mesh {
    mesh("v -50 -1 20\nv 50 -1 20\nv 50 -1 -100\nv -50 -1 -100\nvn 0 1 0\nvn 0 1 1\nf 1//1 2//1 3//2 4//2\n")
}

#[test]
fn a_slanted_floor_is_clipped_and_interpolated_in_perspective() {
    let camera = Camera::look_at(Vec3::ZERO, -Vec3::Z, None, 90.0).expect("a camera");
    let (width, height) = (16, 200);
    let guide =
        GuideOracle::render(&floor(), &Moment::at_rest(camera, Lights::default()), width, height).expect("a guide");
    let aspect = width as f32 / height as f32;
    let (mut seen, mut sky) = (0, 0);
    for y in 0..height {
        let slope = 2.0 * (y as f32 + 0.5) / height as f32 - 1.0;
        for x in 0..width {
            let at = (y * width + x) as usize;
            // The floor is 1 below the eye: a ray that falls by `slope` per unit meets it at 1 / slope.
            let z = 1.0 / slope;
            if slope < 0.0 || z > 99.9 {
                assert!(guide.id[at] == 0 || z > 99.0);
                sky += 1;
                continue;
            }
            seen += 1;
            assert_eq!(guide.id[at], 1, "{x} {y}");
            // Along the floor from z = 20 to z = -100 the normal goes straight from the one to the other.
            let t = (20.0 + z) / 120.0;
            let tilted = Vec3::new(0.0, 1.0, 1.0).normalize();
            let normal = (Vec3::Y * (1.0 - t) + tilted * t).normalize();
            assert!((guide.shade[at] - Lights::default().shade(normal)).abs() < 1e-4, "{x} {y}");
            let depth = camera.projection(aspect).expect("an aspect").project_point3(Vec3::new(0.0, 0.0, -z)).z;
            assert!((guide.depth[at] - depth).abs() < 1e-4, "{x} {y}: {} {depth}", guide.depth[at]);
        }
    }
    assert!(seen > 1000 && sky > 1000, "{seen} {sky}");
}

#[test]
fn the_nearer_surface_wins_whatever_the_order() {
    let square = |z: f32, half: f32, first: u32| {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
        let lines: String = corners.iter().map(|(x, y)| format!("v {x} {y} {z}\n")).collect();
        format!("{lines}f {first} {} {} {}\n", first + 1, first + 2, first + 3)
    };
    let far_first = mesh(&format!("o far\n{}o near\n{}", square(-2.0, 9.0, 1), square(0.0, 2.0, 5)));
    let near_first = mesh(&format!("o near\n{}o far\n{}", square(0.0, 2.0, 1), square(-2.0, 9.0, 5)));
    let (a, b) = (render(&far_first, &square_on(), 8, 8), render(&near_first, &square_on(), 8, 8));
    assert_eq!(rows(&a)[2], "11222211");
    assert_eq!(rows(&b)[2], "22111122");
    assert_eq!(a.depth, b.depth);
}

#[test]
fn of_two_surfaces_at_one_place_the_first_wins() {
    let twice = mesh("v -3 -3 0\nv 3 -3 0\nv 0 3 0\no a\nf 1 2 3\no b\nf 1 2 3\n");
    let guide = render(&twice, &square_on(), 8, 8);
    assert!(guide.id.contains(&1) && !guide.id.contains(&2));
}

#[test]
fn sides_out_of_range_are_refused_and_a_single_pixel_is_not() {
    let ball = sphere(8, 1.0);
    let camera = Camera::framing(&ball, &Framing::default(), 1.0).expect("a camera");
    for (width, height) in [(0, 1), (1, 0), (MAX_GUIDE_SIDE_PX + 1, 1)] {
        assert!(GuideOracle::render(&ball, &Moment::at_rest(camera, Lights::default()), width, height).is_err());
    }
    assert_eq!(render(&ball, &camera, 1, 1).id, [1]);
}
