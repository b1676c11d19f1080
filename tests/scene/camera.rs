//! Projection of known points, and cameras that frame a model by themselves.

use glam::Mat4;
use impasto::scene::{Camera, Framing, Mesh, MeshOptions, Vec3};

/// Where a point lands: x and y from -1 (left, top) to 1 (right, bottom), and depth.
fn project(camera: &Camera, aspect: f32, point: Vec3) -> Vec3 {
    camera.view_projection(aspect).expect("a usable aspect").project_point3(point)
}

#[test]
fn known_points_land_where_vulkan_expects_them() {
    // A field of view of 90 degrees has a tangent of 1: at distance 10 the picture is 20 high and, at 2:1, 40 wide.
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 10.0), Vec3::ZERO, None, 90.0).expect("a camera");
    let cases = [
        (Vec3::ZERO, (0.0, 0.0)),
        (Vec3::new(20.0, 0.0, 0.0), (1.0, 0.0)),
        // Up in the world is up in the picture: y = -1 is Vulkan's upper edge.
        (Vec3::new(0.0, 10.0, 0.0), (0.0, -1.0)),
        (Vec3::new(-5.0, -5.0, 5.0), (-0.5, 1.0)),
    ];
    for (point, (x, y)) in cases {
        let seen = project(&camera, 2.0, point);
        assert!((seen.x - x).abs() < 1e-6 && (seen.y - y).abs() < 1e-6, "{point}: {seen}");
    }
    // Near and far planes are at 0.1 and 1000: depth 0 and 1, and f (1 - n / z) / (f - n) between them.
    assert_eq!((camera.near(), camera.far()), (0.1, 1000.0));
    for (z, depth) in [(9.9, 0.0), (9.0, 900.0 / 999.9), (0.0, 990.0 / 999.9), (-990.0, 1.0)] {
        let seen = project(&camera, 2.0, Vec3::new(0.0, 0.0, z));
        assert!((seen.z - depth).abs() < 1e-4, "{z}: {seen}");
    }
}

#[test]
fn yaw_goes_to_the_right_and_pitch_up() {
    let cube = cube(Vec3::ZERO, 1.0);
    let forward = |yaw_deg, pitch_deg| {
        let framing = Framing { yaw_deg, pitch_deg, ..Framing::default() };
        Camera::framing(&cube, &framing, 1.0).expect("a camera").forward()
    };
    let cases = [
        ((0.0, 0.0), -Vec3::Z),
        ((90.0, 0.0), -Vec3::X),
        ((180.0, 0.0), Vec3::Z),
        ((-90.0, 0.0), Vec3::X),
        ((0.0, 90.0), -Vec3::Y),
        ((30.0, -90.0), Vec3::Y),
        ((3600.0 + 45.0, 45.0), Vec3::new(-0.5, -std::f32::consts::FRAC_1_SQRT_2, -0.5)),
    ];
    for ((yaw, pitch), direction) in cases {
        assert!(forward(yaw, pitch).distance(direction) < 1e-5, "{yaw} {pitch}: {}", forward(yaw, pitch));
    }
}

#[test]
fn a_camera_keeps_its_up_direction() {
    let right = Camera::look_at(Vec3::Z, Vec3::ZERO, Some(Vec3::new(3.0, 0.0, 9.0)), 30.0).expect("a camera");
    assert!(right.up().distance(Vec3::X) < 1e-6);
    let down = Camera::look_at(Vec3::Y, Vec3::ZERO, None, 30.0).expect("a camera");
    assert!(down.up().distance(-Vec3::Z) < 1e-6);
}

/// A cube of side 2 `half` about `center`, with extra vertices inside of its faces.
fn cube(center: Vec3, half: f32) -> Mesh {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let mut corner = |a: f32, b: f32| {
            let mut unit = [sign; 3];
            unit[(axis + 1) % 3] = a * sign;
            unit[(axis + 2) % 3] = b;
            positions.push((center + half * Vec3::from(unit)).to_array());
            positions.len() as u32 - 1
        };
        let middle = corner(0.0, 0.0);
        let ring = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        indices.extend((0..4).flat_map(|k| [middle, ring[k], ring[(k + 1) % 4]]));
    }
    Mesh::build(positions, None, &indices, &[], &MeshOptions::default()).expect("a cube").mesh
}

/// A long, thin, leaning shape without any symmetry.
fn shard(center: Vec3, size: f32) -> Mesh {
    let points = [[0.0, 0.0, 0.0], [5.0, 0.3, 1.0], [4.0, 2.0, -0.5], [1.0, -0.2, 0.4]];
    let positions = points.map(|p| (center + size * Vec3::from(p)).to_array()).to_vec();
    let indices = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2];
    Mesh::build(positions, None, &indices, &[], &MeshOptions::default()).expect("a shard").mesh
}

#[test]
fn framing_fills_the_picture_but_for_the_margin() {
    for scale in [1e-7, 1e-3, 1.0, 1e3, 1e7] {
        for mesh in [cube(Vec3::new(3.0, -2.0, 5.0) * scale, scale), shard(Vec3::new(-1.0, 4.0, 2.0) * scale, scale)] {
            for aspect in [0.3, 0.75, 1.0, 16.0 / 9.0, 3.0] {
                for (yaw_deg, pitch_deg) in [(0.0, 0.0), (25.0, 12.0), (-130.0, 60.0), (77.0, -90.0), (10.0, 89.9)] {
                    for (fov_y_deg, margin) in [(30.0, 0.05), (90.0, 0.0), (10.0, 0.3), (120.0, 0.1)] {
                        let framing = Framing { yaw_deg, pitch_deg, fov_y_deg, margin, distance: None };
                        assert_framed(&mesh, &framing, aspect);
                    }
                }
            }
        }
    }
}

fn assert_framed(mesh: &Mesh, framing: &Framing, aspect: f32) {
    let what = format!("{framing:?}, aspect {aspect}, radius {:e}", mesh.bounding_sphere().radius);
    let camera = Camera::framing(mesh, framing, aspect).expect("a camera");
    let seen: Vec<Vec3> = mesh.positions().iter().map(|&p| project(&camera, aspect, p.into())).collect();
    let limit = 1.0 - 2.0 * framing.margin;
    let low = seen.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = seen.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let slack = 2e-4;
    assert!(low.x > -limit - slack && high.x < limit + slack, "{what}: {low} {high}");
    assert!(low.y > -limit - slack && high.y < limit + slack, "{what}: {low} {high}");
    assert!(low.z > 0.0 && high.z < 1.0, "{what}: {low} {high}");
    // It touches the margin on both sides in one direction, unless the eye would come too close, and is centred in the
    // other.
    let depth = |&p: &[f32; 3]| (Vec3::from(p) - camera.eye()).dot(camera.forward());
    let nearest = mesh.positions().iter().map(depth).fold(f32::INFINITY, f32::min);
    let is_close = nearest < 0.051 * mesh.bounding_sphere().radius;
    let [x, y] = [(low.x, high.x), (low.y, high.y)];
    assert!(is_close || (x.1 - limit).abs() < slack || (y.1 - limit).abs() < slack, "{what}: {low} {high}");
    assert!(!is_close || framing.fov_y_deg > 60.0, "{what}: a usual camera is never as close as that");
    assert!((x.0 + x.1).abs() < slack && (y.0 + y.1).abs() < slack, "{what}: {low} {high}");
    // The depth is used: neither plane is far from the model.
    assert!(low.z < 0.35 && high.z > 0.65, "{what}: {low} {high}");
}

#[test]
fn a_flat_model_seen_edge_on_is_framed_too() {
    let plate = crate::mesh("v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 4 3 2 1\n");
    let framing = Framing { yaw_deg: 45.0, pitch_deg: 0.0, ..Framing::default() };
    let camera = Camera::framing(&plate, &framing, 1.0).expect("a camera");
    for &position in plate.positions() {
        let seen = project(&camera, 1.0, position.into());
        assert!(seen.x.abs() < 0.9001 && seen.y.abs() < 1e-6 && (0.0..1.0).contains(&seen.z), "{seen}");
    }
}

#[test]
fn a_given_distance_is_kept_and_one_distance_suits_all_views() {
    let mesh = shard(Vec3::new(7.0, 7.0, 7.0), 2.0);
    let sphere = mesh.bounding_sphere();
    for aspect in [0.4, 1.0, 2.5] {
        let distance = Framing::default().distance_for_all_views(aspect).expect("a distance");
        for yaw in 0..36 {
            let framing = Framing { yaw_deg: yaw as f32 * 10.0, distance: Some(distance), ..Framing::default() };
            let camera = Camera::framing(&mesh, &framing, aspect).expect("a camera");
            assert!((camera.eye().distance(sphere.center) / sphere.radius - distance).abs() < 1e-4);
            assert!(camera.target().distance(sphere.center) < 1e-4);
            for &position in mesh.positions() {
                let seen = project(&camera, aspect, position.into());
                assert!(seen.x.abs() < 0.9001 && seen.y.abs() < 0.9001 && (0.0..1.0).contains(&seen.z), "{seen}");
            }
        }
    }
    // At a field of view of 90 degrees, less no margin, a sphere fits from sqrt(2) radii.
    let wide = Framing { fov_y_deg: 90.0, margin: 0.0, ..Framing::default() };
    assert!((wide.distance_for_all_views(1.0).expect("a distance") - 2.0_f32.sqrt()).abs() < 1e-6);
}

#[test]
fn depth_is_fitted_to_what_lies_in_front() {
    let mesh = cube(Vec3::ZERO, 1.0);
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, None, 30.0).expect("a camera").fit_depth(&mesh);
    assert!(camera.near() < 4.0 && camera.near() > 3.9 && camera.far() > 6.0 && camera.far() < 6.1, "{camera:?}");
    let inside = Camera::look_at(Vec3::ZERO, Vec3::X, None, 30.0).expect("a camera").fit_depth(&mesh);
    assert!(inside.near() > 0.0 && inside.near() < 1e-3 && inside.far() > 1.0, "{inside:?}");
    let away = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::new(0.0, 0.0, 9.0), None, 30.0).expect("a camera");
    assert_eq!(away.fit_depth(&mesh), away);
}

#[test]
fn unusable_cameras_are_refused() {
    let look = |eye, target, up, fov| Camera::look_at(eye, target, up, fov);
    assert!(look(Vec3::ONE, Vec3::ONE, None, 30.0).is_err());
    assert!(look(Vec3::NAN, Vec3::ONE, None, 30.0).is_err());
    assert!(look(Vec3::ZERO, Vec3::X, Some(Vec3::X), 30.0).is_err());
    assert!(look(Vec3::ZERO, Vec3::X, Some(Vec3::ZERO), 30.0).is_err());
    for fov in [0.0, 151.0, -30.0, f32::NAN] {
        assert!(look(Vec3::ZERO, Vec3::X, None, fov).is_err(), "{fov}");
    }
    let camera = look(Vec3::ZERO, Vec3::X, None, 30.0).expect("a camera");
    for aspect in [0.0, -1.0, 1e6, f32::NAN] {
        assert!(camera.projection(aspect).is_err(), "{aspect}");
    }
    let good = Framing::default();
    for framing in [
        Framing { yaw_deg: f32::INFINITY, ..good },
        Framing { pitch_deg: 90.5, ..good },
        Framing { distance: Some(0.0), ..good },
        Framing { margin: 0.5, ..good },
        Framing { margin: f32::NAN, ..good },
        Framing { fov_y_deg: 0.5, ..good },
    ] {
        let error = Camera::framing(&cube(Vec3::ZERO, 1.0), &framing, 1.0).expect_err("out of range");
        assert!(matches!(error, impasto::Error::Parameter { .. }), "{error}");
        assert!(framing.distance_for_all_views(1.0).is_err());
    }
}

#[test]
fn a_camera_goes_around_and_away_from_what_it_looks_at() {
    let target = Vec3::new(1.0, 2.0, 3.0);
    let camera = Camera::look_at(target + Vec3::new(0.0, 3.0, 4.0), target, None, 40.0).expect("a camera");
    let quarter = camera.orbited(90.0, Vec3::Y).expect("a camera");
    // From +z to +x, at the same height.
    assert!((quarter.eye() - (target + Vec3::new(4.0, 3.0, 0.0))).length() < 1e-5, "{}", quarter.eye());
    assert!((quarter.up() - Vec3::new(-0.6, 0.8, 0.0)).length() < 1e-6 && quarter.target() == target);
    let around = (0..8).try_fold(camera, |camera, _| camera.orbited(45.0, Vec3::Y)).expect("a camera");
    assert!((around.eye() - camera.eye()).length() < 1e-5);
    // Straight from above the picture turns.
    let above = Camera::look_at(target + Vec3::Y, target, None, 40.0).expect("a camera");
    let turned = above.orbited(90.0, Vec3::Y).expect("a camera");
    assert!((turned.eye() - above.eye()).length() < 1e-6 && turned.up().dot(above.up()).abs() < 1e-6);
    let far = camera.moved_away(2.0).expect("a camera");
    assert!((far.eye() - (target + Vec3::new(0.0, 6.0, 8.0))).length() < 1e-5);
    assert_eq!((far.near(), far.far(), far.fov_y_deg()), (camera.near(), camera.far(), 40.0));
    assert!(camera.orbited(f32::NAN, Vec3::Y).is_err() && camera.orbited(1.0, Vec3::ZERO).is_err());
    assert!(camera.moved_away(0.0).is_err() && camera.moved_away(-1.0).is_err());
}

/// A host's matrices give the camera back that they came from, whichever way its clip space runs.
#[test]
fn a_hosts_matrices_are_a_camera() {
    use glam::camera::rh::proj::{directx, vulkan};
    let eye = Vec3::new(1234.5, -20.25, 77.0);
    let camera = Camera::look_at(eye, eye + Vec3::new(3.0, 1.0, -2.0), Some(Vec3::new(0.1, 1.0, 0.0)), 35.0);
    let camera = camera.expect("a camera").with_planes(0.5, 200.0).expect("planes");
    let (view, fov) = (camera.view(), 35f32.to_radians());
    let flip = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let left = glam::camera::lh::proj::vulkan::perspective(fov, 1.6, 0.5, 200.0);
    let cases = [
        ("ours", view, camera.projection(1.6).expect("a projection"), 200.0),
        ("y up", view, directx::perspective(fov, 1.6, 0.5, 200.0), 200.0),
        ("reversed", view, vulkan::perspective(fov, 1.6, 200.0, 0.5), 200.0),
        ("reversed, infinite, y up", view, directx::perspective_infinite_reverse(fov, 1.6, 0.5), 0.5e6),
        ("along +z", flip * view, left, 200.0),
    ];
    for (name, view, projection, far) in cases {
        let found = Camera::from_matrices(&view, &projection).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(found.eye().distance(camera.eye()) < 1e-3, "{name}: {found:?}");
        assert!(found.forward().distance(camera.forward()) < 1e-5, "{name}: {found:?}");
        assert!(found.up().distance(camera.up()) < 1e-5, "{name}: {found:?}");
        assert!((found.fov_y_deg() - 35.0).abs() < 1e-3, "{name}: {found:?}");
        assert!((found.near() - 0.5).abs() < 1e-3 && (found.far() / far - 1.0).abs() < 1e-2, "{name}: {found:?}");
    }
    let projection = camera.projection(1.6).expect("a projection");
    let mut jittered = projection;
    jittered.z_axis.x = 0.01;
    let mirrored = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * view;
    let flat = glam::camera::rh::proj::vulkan::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
    for (view, projection, word) in [
        (view, jittered, "jitter"),
        (view, flat, "perspective"),
        (mirrored, projection, "mirror"),
        (Mat4::from_scale(Vec3::splat(2.0)) * view, projection, "turn"),
        (view * f32::NAN, projection, "finite"),
    ] {
        let error = Camera::from_matrices(&view, &projection).expect_err(word).to_string();
        assert!(error.contains(word), "{error}");
    }
}
