//! Which views show which faces, and how their slices are blended: against a brute-force oracle and by properties.

use std::collections::HashSet;

use glam::{DVec2, DVec3};
use impasto::scene::{Camera, Mesh, MeshOptions, Vec3};
use impasto::technique::dependent::{
    blend_weights, default_views, Coverage, Covered, Round, View, MAX_BLENDED, MAX_SLICES, MAX_VIEWS,
};
use impasto::Error;

const SIZE_PX: u32 = 512;
const FRONT: View = View { yaw_deg: 0.0, pitch_deg: 0.0 };

// Models.

/// Triangles that share no vertices.
fn soup(triangles: &[[Vec3; 3]]) -> Mesh {
    let positions: Vec<[f32; 3]> = triangles.iter().flatten().map(|corner| corner.to_array()).collect();
    let indices: Vec<u32> = (0..positions.len() as u32).collect();
    Mesh::build(positions, None, &indices, &[], &MeshOptions { crease_deg: 0.0 }).expect("a mesh").mesh
}

/// A box with an extra vertex in the middle of each side: 24 triangles, four for each of +x, -x, +y, -y, +z, -z.
fn cuboid(center: Vec3, half: Vec3) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let corner = |a: f32, b: f32| {
            let mut unit = [sign; 3];
            unit[(axis + 1) % 3] = a * sign;
            unit[(axis + 2) % 3] = b;
            center + half * Vec3::from(unit)
        };
        let ring = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        triangles.extend((0..4).map(|k| [corner(0.0, 0.0), ring[k], ring[(k + 1) % 4]]));
    }
    triangles
}

/// Triangles through one point, facing every way: whatever the direction, at least two face the eye and cross.
fn crossing(center: Vec3, size: f32) -> Vec<[Vec3; 3]> {
    let signs = [-1.0, 1.0];
    let corners = signs.iter().flat_map(|&x| signs.iter().map(move |&y| (x, y)));
    let normals = corners.flat_map(|(x, y)| [Vec3::new(x, y, 1.0), Vec3::new(x, y, -1.0)]);
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    normals
        .chain(axes)
        .map(|normal| {
            let normal = normal.normalize();
            let right = normal.any_orthonormal_vector();
            let up = normal.cross(right);
            [0.0_f32, 120.0, 240.0].map(|angle| {
                let (sin, cos) = angle.to_radians().sin_cos();
                center + size * (cos * right + sin * up)
            })
        })
        .collect()
}

fn asset(name: &str) -> Mesh {
    let path = format!("{}/assets/{name}", env!("CARGO_MANIFEST_DIR"));
    Mesh::load(path, &MeshOptions::default()).expect("an asset").mesh
}

fn corners_of(mesh: &Mesh, face: u32) -> [DVec3; 3] {
    let first = 3 * face as usize;
    [0, 1, 2].map(|k| Vec3::from(mesh.positions()[mesh.indices()[first + k] as usize]).as_dvec3())
}

// The pictures of face IDs, drawn plainly.

fn draw(mesh: &Mesh, camera: &Camera, faces: &[u32]) -> Vec<u32> {
    let to_clip = camera.view_projection(1.0).expect("an aspect of 1").as_dmat4();
    let side = SIZE_PX as usize;
    let mut ids = vec![0; side * side];
    let mut depths = vec![1.0; side * side];
    for &face in faces {
        let corners = corners_of(mesh, face).map(|corner| {
            let point = to_clip.project_point3(corner);
            DVec3::new((point.x + 1.0) / 2.0 * side as f64, (point.y + 1.0) / 2.0 * side as f64, point.z)
        });
        let [a, b, c] = corners;
        // Positive for what is counter-clockwise to the viewer, as y points down.
        let area = |a: DVec2, b: DVec2, p: DVec2| -(b - a).perp_dot(p - a);
        let [a2, b2, c2] = corners.map(|corner| corner.truncate());
        let whole = area(a2, b2, c2);
        if whole <= 0.0 {
            continue;
        }
        let pixels = |low: f64, high: f64| low.floor().max(0.0) as usize..(high.ceil().max(0.0) as usize).min(side);
        for y in pixels(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y)) {
            for x in pixels(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)) {
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let parts = [area(b2, c2, center), area(c2, a2, center), area(a2, b2, center)];
                if parts.iter().any(|&part| part < 0.0) {
                    continue;
                }
                let depth = (parts[0] * a.z + parts[1] * b.z + parts[2] * c.z) / whole;
                if depth < depths[y * side + x] {
                    depths[y * side + x] = depth;
                    ids[y * side + x] = face + 1;
                }
            }
        }
    }
    ids
}

fn pictures(mesh: &Mesh, round: &Round) -> Vec<Vec<u32>> {
    round.cameras.iter().map(|camera| draw(mesh, camera, &round.faces)).collect()
}

/// Runs all rounds and checks everything that holds for every model. Also gives the faces of each round.
fn cover_in_rounds(mesh: &Mesh, views: &[View]) -> (Covered, Vec<Vec<u32>>) {
    let mut coverage = Coverage::new(mesh, views, SIZE_PX).expect("usable views");
    let mut rounds = Vec::new();
    while let Some(round) = coverage.round() {
        assert!(!round.faces.is_empty() && round.faces.windows(2).all(|pair| pair[0] < pair[1]));
        coverage.take(&pictures(mesh, &round)).expect("fitting pictures");
        rounds.push(round.faces);
    }
    let covered = coverage.finish();
    check(mesh, views, &covered, &rounds);
    (covered, rounds)
}

fn cover(mesh: &Mesh, views: &[View]) -> Covered {
    cover_in_rounds(mesh, views).0
}

fn set_of(covered: &Covered, face: u32) -> &[u8] {
    &covered.sets[covered.set_of_face[face as usize] as usize]
}

fn check(mesh: &Mesh, views: &[View], covered: &Covered, rounds: &[Vec<u32>]) {
    let Covered { slices, sets, set_of_face, report } = covered;
    let faces = mesh.indices().len() / 3;
    assert!((1..=MAX_SLICES).contains(&slices.len()));
    assert_eq!(set_of_face.len(), faces);
    assert_eq!(sets.iter().collect::<HashSet<_>>().len(), sets.len(), "no set occurs twice");
    let used: HashSet<u32> = set_of_face.iter().copied().collect();
    assert_eq!(used.len(), sets.len(), "every set is some face's");
    for set in sets {
        assert!(!set.is_empty() && set.windows(2).all(|pair| pair[0] < pair[1]), "{set:?}");
        assert!(set.iter().all(|&slice| usize::from(slice) < slices.len()));
        let round = |slice: u8| slices[usize::from(slice)].round;
        assert!(set.iter().all(|&slice| round(slice) == round(set[0])), "a face is covered in one round");
    }
    let center = mesh.bounding_sphere().center;
    for (number, slice) in slices.iter().enumerate() {
        let in_sets: Vec<u32> =
            (0..faces as u32).filter(|&face| set_of(covered, face).contains(&(number as u8))).collect();
        assert_eq!(slice.faces, in_sets);
        assert!(!slice.faces.is_empty());
        assert!((slice.direction.length() - 1.0).abs() < 1e-5);
        assert!(slice.direction.distance((slice.camera.eye() - center).normalize()) < 1e-3);
        let known = if slice.round == 1 { views.to_vec() } else { default_views() };
        assert!(known.contains(&slice.view));
    }
    assert!(slices.windows(2).all(|pair| pair[0].round <= pair[1].round));
    assert_eq!((report.views, report.faces), (views.len(), faces));
    assert_eq!((report.slices, report.sets), (slices.len(), sets.len()));
    assert_eq!(report.covered + report.forced, report.faces);
    assert!(report.covered_at_first <= report.covered);
    assert_eq!(report.rounds as usize, rounds.len());
    assert!((1..=8).contains(&rounds.len()));
}

// The brute-force oracle.

/// Where a ray from `eye` along `ray` meets a triangle from its front.
fn hit([a, b, c]: [DVec3; 3], eye: DVec3, ray: DVec3) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    if normal.dot(ray) >= 0.0 {
        return None;
    }
    let distance = normal.dot(a - eye) / normal.dot(ray);
    let point = eye + distance * ray;
    let is_inside = [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| (q - p).cross(point - p).dot(normal) >= 0.0);
    (distance > 0.0 && is_inside).then_some(distance)
}

/// True if another of `faces` hides more of a face than a pixel's surroundings: the middle of a cross that reaches one
/// pixel in four directions, all of which lie in the face and behind the other. Such a cross holds a pixel centre.
fn is_hidden(mesh: &Mesh, camera: &Camera, faces: &[u32], face: u32) -> bool {
    let eye = camera.eye().as_dvec3();
    let [forward, up] = [camera.forward(), camera.up()].map(|axis| axis.as_dvec3());
    let right = forward.cross(up);
    let corners = corners_of(mesh, face);
    let [a, b, c] = corners;
    const STEPS: u32 = 24;
    for i in 1..STEPS {
        for j in 1..STEPS - i {
            let (u, v) = (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
            let middle = a + u * (b - a) + v * (c - a) - eye;
            let pixel = 2.2 * f64::from(camera.fov_y_deg().to_radians() / 2.0).tan() / f64::from(SIZE_PX);
            let reach = pixel * middle.dot(forward);
            let rays = [DVec3::ZERO, right, -right, up, -up].map(|offset| middle + reach * offset);
            let own = rays.map(|ray| hit(corners, eye, ray));
            if own.iter().any(Option::is_none) {
                continue;
            }
            let hides = |&other: &u32| {
                other != face
                    && rays.iter().zip(own).all(|(&ray, own)| {
                        let distance = hit(corners_of(mesh, other), eye, ray);
                        distance.zip(own).is_some_and(|(distance, own)| distance < own * (1.0 - 1e-5))
                    })
            };
            if faces.iter().any(hides) {
                return true;
            }
        }
    }
    false
}

/// No face is hidden in a slice of its set, unless it was forced there; and it faces the slice's eye.
fn check_by_ray_casting(mesh: &Mesh, covered: &Covered, rounds: &[Vec<u32>]) {
    let last: HashSet<u32> = rounds[rounds.len() - 1].iter().copied().collect();
    let mut maybe_forced = 0;
    for slice in &covered.slices {
        for &face in &slice.faces {
            let drawn = &rounds[slice.round as usize - 1];
            let facing = facing(mesh, face, slice.camera.eye());
            if facing <= 0.0 || is_hidden(mesh, &slice.camera, drawn, face) {
                assert!(last.contains(&face), "face {face} is hidden from {:?}", slice.view);
                maybe_forced += 1;
            }
        }
    }
    assert!(maybe_forced <= covered.report.forced);
}

fn facing(mesh: &Mesh, face: u32, eye: Vec3) -> f64 {
    let [a, b, c] = corners_of(mesh, face);
    (b - a).cross(c - a).normalize().dot((eye.as_dvec3() - (a + b + c) / 3.0).normalize())
}

// Coverage.

#[test]
fn default_views_surround_the_model() {
    let views = default_views();
    assert_eq!(views.len(), 14);
    let mesh = soup(&cuboid(Vec3::ZERO, Vec3::ONE));
    let directions: Vec<Vec3> = cover(&mesh, &views).slices.iter().map(|slice| slice.direction).collect();
    let expected = [Vec3::Z, Vec3::X, -Vec3::Z, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::ONE.normalize()];
    for (direction, expected) in directions.iter().zip(expected) {
        assert!(direction.distance(expected) < 0.05, "{direction} {expected}");
    }
    for signs in 0..8 {
        let corner = Vec3::from([0, 1, 2].map(|axis| if signs >> axis & 1 == 1 { 1.0 } else { -1.0 })).normalize();
        assert!(directions[6..].iter().any(|direction| direction.distance(corner) < 0.05), "{corner}");
    }
}

#[test]
fn a_cube_is_covered_at_once() {
    let mesh = soup(&cuboid(Vec3::ZERO, Vec3::ONE));
    let (covered, rounds) = cover_in_rounds(&mesh, &default_views());
    assert_eq!((covered.report.rounds, covered.report.slices), (1, 14));
    assert_eq!((covered.report.covered, covered.report.forced), (24, 0));
    check_by_ray_casting(&mesh, &covered, &rounds);
    // Each side is seen by its axis and by four corners. From the other axes it is at the outline or behind.
    for face in 0..24 {
        assert_eq!(set_of(&covered, face).len(), 5, "{face}");
    }
    assert_eq!(covered.sets.len(), 6);
}

#[test]
fn what_stands_before_a_face_takes_it_from_the_view() {
    let mut triangles = cuboid(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.0, 0.0, 2.5), Vec3::splat(0.3)));
    let mesh = soup(&triangles);
    let (covered, rounds) = cover_in_rounds(&mesh, &default_views());
    check_by_ray_casting(&mesh, &covered, &rounds);
    // Slice 0 looks from the front: at the small box's front (faces 40 to 43), and at nothing of the large one's.
    assert_eq!(covered.slices[0].view, FRONT);
    assert_eq!(covered.slices[0].faces, [40, 41, 42, 43]);
    assert_eq!(covered.report.forced, 0);
}

#[test]
fn one_view_is_added_to() {
    let mesh = soup(&cuboid(Vec3::ZERO, Vec3::ONE));
    let (covered, rounds) = cover_in_rounds(&mesh, &[FRONT]);
    check_by_ray_casting(&mesh, &covered, &rounds);
    assert_eq!((covered.report.covered_at_first, covered.report.covered), (4, 24));
    assert_eq!((covered.slices[0].view, covered.slices[0].round, &covered.slices[0].faces[..]), {
        (FRONT, 1, &[16, 17, 18, 19][..])
    });
    // What faces five ways is seen by two corners, of which the second adds what the first leaves.
    assert_eq!(covered.report.rounds, 2);
    assert!((3..=4).contains(&covered.report.slices), "{:?}", covered.report);
}

#[test]
fn a_box_turned_inside_out_is_covered() {
    let inside: Vec<_> = cuboid(Vec3::ZERO, Vec3::ONE).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let mesh = soup(&inside);
    let (covered, rounds) = cover_in_rounds(&mesh, &default_views());
    check_by_ray_casting(&mesh, &covered, &rounds);
    assert_eq!(covered.report.forced, 0);
}

#[test]
fn a_single_triangle_is_covered_from_its_front() {
    let mesh = soup(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
    let (covered, rounds) = cover_in_rounds(&mesh, &default_views());
    check_by_ray_casting(&mesh, &covered, &rounds);
    assert_eq!((covered.report.rounds, covered.report.covered), (1, 1));
    assert_eq!(set_of(&covered, 0)[0], 0);
    assert!(covered.slices.iter().all(|slice| slice.direction.z > 0.1));

    // From behind alone, the first round shows nothing, and others look from elsewhere.
    let behind = View { yaw_deg: 180.0, pitch_deg: 0.0 };
    let (covered, _) = cover_in_rounds(&mesh, &[behind]);
    assert_eq!((covered.report.rounds, covered.report.covered_at_first, covered.report.covered), (2, 0, 1));
    assert_eq!((covered.slices.len(), covered.slices[0].view), (1, FRONT));
}

#[test]
fn crossing_triangles_are_given_the_view_that_they_face() {
    // Nothing is covered: there is one slice, from the first view.
    let only_crossing = crossing(Vec3::ZERO, 1.0);
    let mesh = soup(&only_crossing);
    let (covered, _) = cover_in_rounds(&mesh, &default_views());
    assert_eq!((covered.report.rounds, covered.report.forced), (2, 14));
    assert_eq!((covered.slices.len(), covered.slices[0].view), (1, FRONT));

    // With a cube beside them there are slices to choose from.
    let mut triangles = cuboid(Vec3::new(4.0, 0.5, 0.2), Vec3::ONE);
    triangles.extend(only_crossing);
    let mesh = soup(&triangles);
    let (covered, rounds) = cover_in_rounds(&mesh, &default_views());
    check_by_ray_casting(&mesh, &covered, &rounds);
    let forced = rounds.last().expect("a round");
    assert!(!forced.is_empty() && forced.len() == covered.report.forced, "{:?}", covered.report);
    for &face in forced {
        let facings = covered.slices.iter().filter(|s| s.round == 1).map(|s| facing(&mesh, face, s.camera.eye()));
        let facings: Vec<f64> = facings.collect();
        let &[slice] = set_of(&covered, face) else { panic!("a forced face has one slice") };
        let best = facings.iter().copied().fold(-1.0, f64::max);
        assert!((facings[usize::from(slice)] - best).abs() < 1e-9);
    }
}

#[test]
fn a_teapot_on_a_table_is_covered_in_several_rounds() {
    let mesh = asset("teapot_on_table.obj");
    let (covered, rounds) = cover_in_rounds(&mesh, &default_views());
    println!("{:?}", covered.report);
    // As each round takes all views that add something, few are needed.
    assert!((2..=4).contains(&covered.report.rounds));
    assert!(covered.report.forced * 50 < covered.report.faces, "{:?}", covered.report);
    // The table is two triangles. The teapot stands on both, so that no view of the whole covers them.
    let table = mesh.objects().iter().find(|object| object.name == "table").expect("a table");
    assert_eq!(table.index_count, 6);
    for face in [table.first_index / 3, table.first_index / 3 + 1] {
        assert!(rounds[1].contains(&face));
        let set = set_of(&covered, face);
        // Once the underside of the teapot is covered and gone, the table is seen well, and not just along its plane.
        for &slice in set {
            assert!(facing(&mesh, face, covered.slices[usize::from(slice)].camera.eye()) >= 0.15);
        }
    }
    let again = cover(&mesh, &default_views());
    assert_eq!(again, covered, "the same every time");
}

#[test]
fn a_head_is_covered() {
    let mesh = asset("head.obj");
    let covered = cover(&mesh, &default_views());
    println!("{:?}", covered.report);
    assert!(covered.report.forced * 50 < covered.report.faces, "{:?}", covered.report);
}

fn parameter_of<T>(result: impasto::Result<T>) -> &'static str {
    match result {
        Err(Error::Parameter { name, .. }) => name,
        Err(error) => panic!("another error: {error}"),
        Ok(_) => panic!("no error"),
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let mesh = soup(&cuboid(Vec3::ZERO, Vec3::ONE));
    assert_eq!(parameter_of(Coverage::new(&mesh, &[], SIZE_PX)), "views");
    assert_eq!(parameter_of(Coverage::new(&mesh, &[FRONT; MAX_VIEWS + 1], SIZE_PX)), "views");
    assert_eq!(parameter_of(Coverage::new(&mesh, &[FRONT], 511)), "view_px");
    assert_eq!(parameter_of(Coverage::new(&mesh, &[FRONT], 4097)), "view_px");
    let steep = View { yaw_deg: 0.0, pitch_deg: 91.0 };
    assert_eq!(parameter_of(Coverage::new(&mesh, &[steep], SIZE_PX)), "pitch_deg");
    assert!(Coverage::new(&mesh, &[FRONT; MAX_VIEWS], 4096).is_ok());

    let mut coverage = Coverage::new(&mesh, &[FRONT], SIZE_PX).expect("a view");
    let picture = draw(&mesh, &coverage.round().expect("a round").cameras[0], &(0..24).collect::<Vec<_>>());
    assert_eq!(parameter_of(coverage.take(&[])), "face_ids");
    assert_eq!(parameter_of(coverage.take(&[picture.clone(), picture.clone()])), "face_ids");
    assert_eq!(parameter_of(coverage.take(&[picture[1..].to_vec()])), "face_ids");
    let mut stray = picture.clone();
    stray[0] = 25;
    assert_eq!(parameter_of(coverage.take(&[stray])), "face_ids");
    coverage.take(&[picture]).expect("the right picture");
    // An early end leaves no gap either.
    let covered = coverage.finish();
    assert_eq!((covered.report.covered, covered.report.forced, covered.slices.len()), (4, 20, 1));
    assert_eq!(covered.slices[0].faces.len(), 24);
}

#[test]
fn views_without_any_face_are_dropped() {
    let mesh = soup(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
    let behind = View { yaw_deg: 180.0, pitch_deg: 0.0 };
    let covered = cover(&mesh, &[behind, FRONT, behind, FRONT]);
    assert_eq!(covered.slices.iter().map(|slice| slice.view).collect::<Vec<_>>(), [FRONT, FRONT]);
    assert_eq!(covered.sets, [vec![0, 1]]);
}

// Blending.

/// Numbers that look random and are the same every time.
struct Noise(u64);

impl Noise {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.unit() - 1.0, std::f64::consts::TAU * self.unit());
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * angle.cos(), across * angle.sin(), z)
    }

    /// Directions, and some of their indices.
    fn slices(&mut self) -> (Vec<Vec3>, Vec<u8>) {
        let count = 1 + (self.unit() * 20.0) as usize;
        let directions: Vec<Vec3> = (0..count).map(|_| self.direction().as_vec3()).collect();
        let mut set: Vec<u8> = (0..count as u8).filter(|_| self.unit() < 0.7).collect();
        if set.is_empty() {
            set.push(0);
        }
        (directions, set)
    }
}

/// Weights by slice.
fn spread(weights: [(u8, f32); MAX_BLENDED]) -> [f64; 256] {
    let mut by_slice = [0.0; 256];
    weights.iter().for_each(|&(slice, weight)| by_slice[usize::from(slice)] += f64::from(weight));
    by_slice
}

/// How much nearer the nearest slice is than the first that takes no part.
fn lead(directions: &[Vec3], set: &[u8], direction: DVec3) -> f64 {
    let distances = set.iter().map(|&slice| 1.0 - directions[usize::from(slice)].as_dvec3().dot(direction));
    let mut distances: Vec<f64> = distances.collect();
    distances.sort_by(f64::total_cmp);
    distances.get(MAX_BLENDED).copied().unwrap_or(2.5) - distances[0]
}

#[test]
fn weights_are_those_of_a_set() {
    let mut noise = Noise(1);
    for _ in 0..20_000 {
        let (directions, set) = noise.slices();
        let direction = noise.direction().as_vec3();
        let weights = blend_weights(&directions, &set, direction);
        let sum: f32 = weights.iter().map(|&(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        for (slice, weight) in weights {
            assert!((0.0..=1.0).contains(&weight));
            assert!(weight == 0.0 || set.contains(&slice));
        }
        // By the formula, in 64 bits and in another order.
        let mut near: Vec<(f64, u8)> = set
            .iter()
            .map(|&slice| {
                (directions[usize::from(slice)].as_dvec3().distance_squared(direction.as_dvec3()) / 2.0, slice)
            })
            .collect();
        near.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        let threshold = near.get(MAX_BLENDED).map_or(2.5, |next| next.0);
        near.truncate(MAX_BLENDED);
        let weight = |distance: f64| (1.0 - distance / threshold).max(0.0) / (distance + 1e-4);
        let sum: f64 = near.iter().map(|&(distance, _)| weight(distance)).sum();
        let found = spread(weights);
        let conditioned = (near[0].0 + 1e-4) * 1e-4 < threshold - near[0].0;
        for (distance, slice) in near {
            let expected = weight(distance) / sum;
            assert!(!conditioned || (found[usize::from(slice)] - expected).abs() < 1e-3, "{expected}");
        }
    }
}

#[test]
fn odd_sets_are_blended() {
    let directions = [Vec3::Z, Vec3::X, Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y, Vec3::Z];
    // More than can be blended at the same distance: the first takes all, near or far.
    assert_eq!(blend_weights(&directions, &[0, 2, 3, 4, 6], Vec3::Z)[0], (0, 1.0));
    assert_eq!(blend_weights(&directions, &[2, 3, 4, 6, 0], Vec3::X)[0], (2, 1.0));
    // Of equally near ones the first of the set take part, also when a nearer one comes after them.
    let weights = blend_weights(&directions, &[0, 2, 3, 4, 1], Vec3::X);
    assert_eq!(weights.map(|(slice, _)| slice), [1, 0, 2, 3]);
    // A single slice takes all, even from behind; no set, or one of slices that there are not, gives nothing.
    assert_eq!(blend_weights(&directions, &[5], -Vec3::Y)[0], (5, 1.0));
    assert_eq!(blend_weights(&directions, &[], Vec3::Y), [(0, 0.0); MAX_BLENDED]);
    assert_eq!(blend_weights(&directions, &[9, 200], Vec3::Y), [(0, 0.0); MAX_BLENDED]);
    // Two at the same distance share.
    let weights = blend_weights(&directions, &[1, 5], Vec3::new(1.0, 1.0, 0.0).normalize());
    assert!((weights[0].1 - 0.5).abs() < 1e-3);
}

#[test]
fn at_its_own_direction_a_slice_takes_all() {
    let mesh = soup(&cuboid(Vec3::ZERO, Vec3::ONE));
    let directions: Vec<Vec3> = cover(&mesh, &default_views()).slices.iter().map(|slice| slice.direction).collect();
    let all: Vec<u8> = (0..14).collect();
    for (slice, &direction) in directions.iter().enumerate() {
        let weights = blend_weights(&directions, &all, direction);
        assert!(usize::from(weights[0].0) == slice && weights[0].1 > 0.99, "{weights:?}");
    }
}

/// The largest change of the weights (sum of absolute differences) on the way around great circles, in steps of
/// `step` radians. Where `lead` is the nearest slice's lead, each change is below C times the step with
/// C = 2 (8 / lead + 71):
///
/// A weight before normalisation is w = (T - a) / (a + e). A step h changes T and each a by at most h, and so w by at
/// most h (2 / (a + e) + w r), where r = sin / (a + e) is at most 1 / sqrt(2 e) = 71. The sum of the weights is at
/// least lead / (a + e) of the nearest, and there are four: together they change by at most h (8 / lead + 71) of the
/// sum, and normalised by twice that.
fn largest_change(directions: &[Vec3], set: &[u8], [from, across]: [DVec3; 2], step: f64, steps: u32) -> f64 {
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) * step).sin_cos();
        cos * from + sin * across
    };
    let weights = |direction: DVec3| spread(blend_weights(directions, set, direction.as_vec3()));
    let mut largest = 0.0_f64;
    let mut last = weights(at(0));
    for k in 1..=steps {
        let next = weights(at(k));
        let change: f64 = last.iter().zip(&next).map(|(a, b)| (a - b).abs()).sum();
        let lead = lead(directions, set, at(k - 1)).min(lead(directions, set, at(k)));
        // Rounding moves a direction by as much as 1e-7, and within a step the lead may be smaller than at its ends.
        let bound = 2.0 * (1.5 * 8.0 / lead + 71.0) * (step + 3e-7) + 1e-6;
        assert!(change <= bound, "{change} > {bound}, lead {lead}");
        largest = largest.max(change);
        last = next;
    }
    largest
}

/// The corners of the default views stand four by four at the same distance around the axes.
#[test]
fn weights_do_not_jump_between_four_equally_near_views() {
    let mesh = soup(&cuboid(Vec3::ZERO, Vec3::ONE));
    let views: Vec<Vec3> = cover(&mesh, &default_views()).slices.iter().map(|slice| slice.direction).collect();
    let corners: Vec<u8> = (0..14).filter(|&i| views[usize::from(i)].abs().max_element() < 0.9).collect();
    assert_eq!(corners.len(), 8);
    for (axis, across) in [(Vec3::Z, Vec3::X), (Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z)] {
        let at = |angle: f32| spread(blend_weights(&views, &corners, angle.cos() * axis + angle.sin() * across));
        let before = at(-1e-3);
        let change: f64 = before.iter().zip(&at(1e-3)).map(|(a, b)| (a - b).abs()).sum();
        assert!(change < 0.02, "{change} at {axis}");
        assert!(before.iter().filter(|&&weight| weight > 0.2).count() == 4, "all four take part");
    }
}

#[test]
fn weights_change_continuously() {
    let mut noise = Noise(3);
    let step = std::f64::consts::TAU / 2000.0;
    let mut compared = 0;
    for _ in 0..60 {
        let (directions, set) = noise.slices();
        let from = noise.direction();
        let circle = [from, from.cross(noise.direction()).normalize()];
        let coarse = largest_change(&directions, &set, circle, step, 2000);
        let fine = largest_change(&directions, &set, circle, step / 10.0, 20_000);
        // Where the change per radian is moderate everywhere, a tenth of the step changes a tenth.
        let (sin_cos, smallest) = ((0..2000).map(|k| (f64::from(k) * step).sin_cos()), f64::INFINITY);
        let smallest = sin_cos
            .map(|(sin, cos)| lead(&directions, &set, cos * circle[0] + sin * circle[1]))
            .fold(smallest, f64::min);
        if smallest > 0.2 && coarse > 1e-3 {
            let ratio = coarse / fine;
            assert!((5.0..15.0).contains(&ratio), "{coarse} / {fine}");
            compared += 1;
        }
    }
    assert!(compared >= 10, "{compared}");
}
