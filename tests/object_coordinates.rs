//! The coordinate t of equation 5.1 against a plain oracle that shares no code with it, the strip that repeats along
//! it, and the grid that shows it.

mod common;

use common::Numbers;
use impasto::paint::{PaintSample, TextureDifference, Trajectory};
use impasto::scene::{Mesh, MeshOptions, Vec3};
use impasto::technique::object::{density, texture_coordinates, CoordinateParams, Orientation, SeamPolicy};

fn mesh(text: &str) -> Mesh {
    Mesh::parse(text.as_bytes(), "test", &MeshOptions::default()).expect("a mesh").mesh
}

/// Points, and triangles of them.
type Part = (Vec<[f32; 3]>, Vec<[usize; 3]>);

/// A wavy sheet of n by n points whose corner lies at `at`.
fn sheet(n: usize, at: [f32; 3]) -> Part {
    let point = |i: usize| {
        let (x, z) = ((i % n) as f32, (i / n) as f32);
        [at[0] + 0.7 * x, at[1] + (1.3 * x).sin() + (0.9 * z).cos() + 0.2 * z, at[2] + 0.8 * z]
    };
    let faces = (0..n - 1).flat_map(|z| (0..n - 1).map(move |x| z * n + x));
    ((0..n * n).map(point).collect(), faces.flat_map(|i| [[i, i + n, i + 1], [i + 1, i + n, i + n + 1]]).collect())
}

fn obj(parts: &[Part]) -> Mesh {
    let (mut text, mut first) = (String::new(), 1);
    for (points, faces) in parts {
        points.iter().for_each(|[x, y, z]| text.push_str(&format!("v {x} {y} {z}\n")));
        faces.iter().for_each(|f| {
            text.push_str(&format!("f {} {} {}\n", f[0] + first, f[1] + first, f[2] + first));
        });
        first += points.len();
    }
    mesh(&text)
}

fn cube() -> Mesh {
    mesh(
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nf 4 3 2 1\nf 5 6 7 8\n\
         f 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n",
    )
}

/// Triangles thrown about, some of which share corners.
fn soup(count: usize) -> Mesh {
    let mut numbers = Numbers(7);
    let mut text = String::new();
    for i in 0..count {
        let at: Vec<f32> = (0..3).map(|_| (numbers.next() % 13) as f32).collect();
        for k in 0..3 {
            let p: Vec<f32> =
                (0..3).map(|a| at[a] + (numbers.next() % 3) as f32 * if k == a { 2.0 } else { 0.5 }).collect();
            text.push_str(&format!("v {} {} {}\n", p[0], p[1], p[2]));
        }
        text.push_str(&format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3));
    }
    mesh(&text)
}

/// The hash that random choices come from, written out again.
fn random(seed: u32, number: u32, purpose: u32) -> f64 {
    let mix = |x: u32| {
        let mut x = x.wrapping_add(0x9e3779b9);
        for (shift, factor) in [(16, 0x7feb352d_u32), (15, 0x846ca68b)] {
            x = (x ^ (x >> shift)).wrapping_mul(factor);
        }
        x ^ (x >> 16)
    };
    f64::from(mix(mix(mix(seed) ^ number) ^ purpose)) / 4294967296.0
}

/// Equation 5.1 as it reads, with searches through everything.
fn oracle(mesh: &Mesh, params: &CoordinateParams, axis: Vec3) -> Vec<f32> {
    let mut points: Vec<[f32; 3]> = Vec::new();
    let mut point_of = Vec::new();
    for p in mesh.positions() {
        let known = points.iter().position(|q| q == p);
        point_of.push(known.unwrap_or(points.len()));
        if known.is_none() {
            points.push(*p);
        }
    }
    let n = points.len();
    let d = axis.as_dvec3().normalize().to_array();
    let at = |i: usize| points[i].map(f64::from);
    let along = |i: usize| at(i)[0] * d[0] + at(i)[1] * d[1] + at(i)[2] * d[2];
    let squared = |i: usize, j: usize| {
        let (a, b) = (at(i), at(j));
        (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)
    };
    let step = |i: usize, j: usize| {
        let (a, b) = (at(i), at(j));
        (b[0] - a[0]) * d[0] + (b[1] - a[1]) * d[1] + (b[2] - a[2]) * d[2]
    };
    let mut beside = vec![vec![false; n]; n];
    for t in mesh.indices().chunks(3) {
        for k in 0..3 {
            let (a, b) = (point_of[t[k] as usize], point_of[t[(k + 1) % 3] as usize]);
            beside[a][b] = true;
            beside[b][a] = true;
        }
    }
    let most = (0..n).map(along).fold(f64::MIN, f64::max);
    let extent = most - (0..n).map(along).fold(f64::MAX, f64::min);
    let scale = if extent > 0.0 { f64::from(params.repeats) / extent } else { 0.0 };
    let mut t: Vec<Option<f64>> = vec![None; n];
    let value = |t: &[Option<f64>], from: usize, to: usize| {
        let gamma = (2.0 * random(params.seed, to as u32, 2) - 1.0) * f64::from(params.variation);
        t[from].expect("processed") + step(from, to) * scale + gamma
    };
    let mut piece = 0;
    while t.iter().any(Option::is_none) {
        let (start, t_start) = if piece == 0 || params.seams == SeamPolicy::Fresh {
            let place = (random(params.seed, piece, 0) * n as f64) as usize;
            let free = (0..n).map(|i| (place + i) % n).find(|&i| t[i].is_none()).expect("one is left");
            (free, random(params.seed, piece, 1))
        } else {
            let mut best = (f64::INFINITY, n, n);
            for to in (0..n).filter(|&i| t[i].is_none()) {
                for from in (0..n).filter(|&i| t[i].is_some()) {
                    if squared(to, from) < best.0 {
                        best = (squared(to, from), to, from);
                    }
                }
            }
            (best.1, value(&t, best.2, best.1))
        };
        piece += 1;
        t[start] = Some(t_start);
        let mut queue: Vec<usize> = (0..n).filter(|&i| beside[start][i] && t[i].is_none()).collect();
        let mut next = 0;
        while next < queue.len() {
            let v = queue[next];
            next += 1;
            let mut near = n;
            for u in (0..n).filter(|&u| beside[v][u] && t[u].is_some()) {
                if near == n || squared(u, v) < squared(near, v) {
                    near = u;
                }
            }
            t[v] = Some(value(&t, near, v));
            let more: Vec<usize> = (0..n).filter(|&i| beside[v][i] && t[i].is_none() && !queue.contains(&i)).collect();
            queue.extend(more);
        }
    }
    point_of.into_iter().map(|i| t[i].expect("processed") as f32).collect()
}

fn params(seams: SeamPolicy, variation: f32, axis: Vec3, seed: u32) -> CoordinateParams {
    CoordinateParams { repeats: 3.5, variation, orientation: Orientation::Axis(axis), seams, seed }
}

#[test]
fn t_equals_the_oracle_exactly() {
    let two = obj(&[sheet(9, [0.0; 3]), sheet(7, [9.0, 0.5, 1.0])]);
    let three = obj(&[sheet(5, [0.0; 3]), sheet(4, [20.0, 0.0, 0.0]), sheet(6, [4.0, 3.0, 0.0])]);
    for (number, mesh) in [two, three, cube(), soup(60)].iter().enumerate() {
        for seams in [SeamPolicy::Carry, SeamPolicy::Fresh] {
            for (axis, variation, seed) in [(Vec3::Y, 0.0, 1), (Vec3::new(1.0, 2.0, -3.0), 0.05, 77), (Vec3::X, 1.0, 5)]
            {
                let params = params(seams, variation, axis, seed);
                let got = texture_coordinates(mesh, &params).expect("t");
                let mut want = oracle(mesh, &params, axis);
                assert!(got == want, "mesh {number}, {params:?}");
                want[3] += 1e-6 * want[3].abs().max(1.0);
                assert!(got != want, "a planted difference is noticed");
            }
        }
    }
}

#[test]
fn without_variation_t_follows_the_axis_whatever_the_way() {
    let mesh = obj(&[sheet(12, [0.0; 3]), sheet(8, [15.0, 2.0, 0.0])]);
    let t = texture_coordinates(&mesh, &params(SeamPolicy::Carry, 0.0, Vec3::Y, 4)).expect("t");
    let (low, high) = mesh.bounds();
    let at = |i: usize| t[0] + 3.5 * (mesh.positions()[i][1] - mesh.positions()[0][1]) / (high.y - low.y);
    assert!((0..t.len()).all(|i| (t[i] - at(i)).abs() < 1e-4), "the second piece goes on where the first one is");
    let fresh = texture_coordinates(&mesh, &params(SeamPolicy::Fresh, 0.0, Vec3::Y, 4)).expect("t");
    let off: Vec<f32> = fresh.iter().zip(&t).map(|(a, b)| a - b).collect();
    assert!((off[0] - off[off.len() - 1]).abs() > 1e-3, "a fresh piece begins somewhere else");
    let other = texture_coordinates(&mesh, &params(SeamPolicy::Carry, 0.0, Vec3::Y, 5)).expect("t");
    assert!(other != t, "another seed begins with another t");
    let per_unit = density(&mesh, &params(SeamPolicy::Carry, 0.0, Vec3::Y, 4)).expect("a density");
    assert!((per_unit - 3.5 / (high.y - low.y)).abs() < 1e-5);
}

#[test]
fn doubled_vertices_share_t_and_a_constant_field_is_an_axis() {
    let cube = cube();
    assert_eq!(cube.positions().len(), 24, "the creases have doubled the corners");
    let axis = Vec3::new(0.3, 1.0, -0.2);
    let t = texture_coordinates(&cube, &params(SeamPolicy::Carry, 0.1, axis, 9)).expect("t");
    for i in 0..24 {
        for j in 0..24 {
            assert!(cube.positions()[i] != cube.positions()[j] || t[i] == t[j]);
        }
    }
    let orientation = Orientation::Field(vec![axis * 5.0; 24]);
    let field = CoordinateParams { orientation, ..params(SeamPolicy::Carry, 0.1, axis, 9) };
    let by_field = texture_coordinates(&cube, &field).expect("t");
    assert!(t.iter().zip(&by_field).all(|(a, b)| (a - b).abs() < 1e-5));
    // A field that turns gives something else.
    let turning = (0..24).map(|i| Vec3::new((i as f32).cos(), (i as f32).sin(), 0.0)).collect();
    let field = CoordinateParams { orientation: Orientation::Field(turning), ..field };
    assert!(texture_coordinates(&cube, &field).expect("t") != by_field);
}

#[test]
fn a_plane_across_the_axis_has_one_t() {
    let plane = mesh("v 0 1 0\nv 4 1 0\nv 4 1 3\nv 0 1 3\nf 4 3 2 1\n");
    let t = texture_coordinates(&plane, &params(SeamPolicy::Carry, 0.0, Vec3::Y, 1)).expect("t");
    assert!(t.iter().all(|value| *value == t[0]));
    let per_unit = density(&plane, &params(SeamPolicy::Carry, 0.0, Vec3::Y, 1)).expect("a density");
    assert!((per_unit - 3.5 / 4.0).abs() < 1e-6, "a density all the same");
    // Nor is what rounding makes of a plane an extent.
    let nearly = mesh("v 0 1 0\nv 4 1.0000001 0\nv 4 1 3\nv 0 0.9999999 3\nf 4 3 2 1\n");
    let t = texture_coordinates(&nearly, &params(SeamPolicy::Carry, 0.0, Vec3::Y, 1)).expect("t");
    assert!(t.iter().all(|value| *value == t[0]), "{t:?}");
}

#[test]
fn wrong_parameters_are_named() {
    let cube = cube();
    let good = params(SeamPolicy::Carry, 0.0, Vec3::Y, 1);
    let cases = [
        (CoordinateParams { repeats: 0.0, ..good.clone() }, "repeats is 0"),
        (CoordinateParams { repeats: f32::NAN, ..good.clone() }, "repeats"),
        (CoordinateParams { variation: -0.1, ..good.clone() }, "variation is -0.1"),
        (CoordinateParams { orientation: Orientation::Axis(Vec3::ZERO), ..good.clone() }, "orientation"),
        (CoordinateParams { orientation: Orientation::Axis(Vec3::NAN), ..good.clone() }, "orientation"),
        (CoordinateParams { orientation: Orientation::Field(vec![Vec3::X; 3]), ..good }, "24 vertices"),
    ];
    for (params, part) in cases {
        let error = texture_coordinates(&cube, &params).expect_err(part).to_string();
        assert!(error.contains(part), "{error}");
        assert!(density(&cube, &params).is_err());
    }
}

fn difference(width: u32, height: u32) -> TextureDifference {
    let mut numbers = Numbers(width * 7 + height);
    let pixels = (0..width * height).map(|i| {
        let slow = ((i / width) as f32 * 0.4 + (i % width) as f32 * 0.1).sin() * 0.3;
        [0; 3].map(|_: i32| slow + (numbers.next() % 100) as f32 * 0.001)
    });
    TextureDifference::from_pixels(width, height, pixels.collect()).expect("a difference")
}

#[test]
fn rows_repeat_without_a_line() {
    let texture = difference(96, 60);
    let wrapped = texture.tileable_rows();
    assert_eq!((wrapped.width(), wrapped.height()), (96, 50));
    let change = |texture: &TextureDifference, a: u32, b: u32| -> f32 {
        (0..96).map(|x| (texture.pixel(x, a)[0] - texture.pixel(x, b)[0]).abs()).sum::<f32>() / 96.0
    };
    let inside: f32 = (0..49).map(|y| change(&wrapped, y, y + 1)).sum::<f32>() / 49.0;
    assert!(change(&wrapped, 49, 0) < 1.5 * inside, "{} at the seam, {inside} inside", change(&wrapped, 49, 0));
    assert!(change(&texture, 59, 0) > 2.0 * inside, "the texture itself has a seam");
    // Every value comes from its column.
    for x in 0..96 {
        let column: Vec<_> = (0..60).map(|y| texture.pixel(x, y)).collect();
        assert!((0..50).all(|y| column.contains(&wrapped.pixel(x, y))));
    }
    for height in [1, 2] {
        assert_eq!(difference(9, height).tileable_rows(), difference(9, height));
    }
    let steps = vec![[0.0; 3], [0.1; 3], [0.3; 3]];
    let steep = TextureDifference::from_pixels(1, 3, steps).expect("a difference").tileable_rows();
    assert_eq!(steep.height(), 2);
    let grid = PaintSample::grid();
    let black = Trajectory::from_colors(vec![[0.0; 3]]).expect("a trajectory");
    let grid = TextureDifference::extract(&grid, &black);
    assert_eq!(grid.tileable_rows(), grid, "its rows repeat already");
    let constant = TextureDifference::from_pixels(5, 12, vec![[0.25; 3]; 60]).expect("a difference").tileable_rows();
    assert!(constant.pixels().iter().all(|pixel| *pixel == [0.25; 3]));
}

#[test]
fn the_grid_repeats_and_marks_the_middle() {
    let grid = PaintSample::grid();
    assert_eq!((grid.width(), grid.height()), (512, 128));
    let blue = |x, y| grid.pixel(x, y)[2] > 0.8 && grid.pixel(x, y)[0] < 0.2;
    assert!((0..128).any(|y| blue(256, y)) && (0..128).any(|y| !blue(256, y)), "dots of blue");
    assert!((0..128).all(|y| (0..512).filter(|&x| blue(x, y)).all(|x| (254..=258).contains(&x))));
    let dark_row = |y: u32| (0..512).filter(|&x| grid.pixel(x, y)[0] < 0.35).count() > 480;
    let rows: Vec<u32> = (0..128).filter(|&y| dark_row(y)).collect();
    assert_eq!(rows, [0, 1, 32, 33, 64, 65, 96, 97], "one line at each step, and one where it repeats");
    assert!(grid.pixel(20, 20)[0] < grid.pixel(500, 20)[0], "dark on the left");
}
