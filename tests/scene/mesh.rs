//! Meshes: cleaning, normals, objects, and what is refused.

use impasto::scene::{Mesh, MeshOptions, MeshWarning, Object, Vec3, MAX_OBJECTS};
use impasto::Error;

use crate::{assert_sound, mesh, parse, sphere};

const CUBE: &str = "
    v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn with_crease(text: &str, crease_deg: f32) -> Mesh {
    let loaded = Mesh::parse(text.as_bytes(), "test.obj", &MeshOptions { crease_deg }).expect("a usable model");
    assert_eq!(loaded.warnings, []);
    assert_sound(&loaded.mesh);
    loaded.mesh
}

#[test]
fn a_cube_has_hard_edges_unless_asked_otherwise() {
    let hard = with_crease(CUBE, 60.0);
    assert_eq!(hard.positions().len(), 24);
    for (position, normal) in hard.positions().iter().zip(hard.normals()) {
        let axis = (0..3).find(|&axis| normal[axis].abs() == 1.0).expect("a normal along an axis");
        assert_eq!(normal[axis], position[axis], "it points outwards");
    }
    // Every corner sees each of its three faces under a right angle, however the faces are cut.
    let smooth = with_crease(CUBE, 180.0);
    assert_eq!(smooth.positions().len(), 8);
    for (position, normal) in smooth.positions().iter().zip(smooth.normals()) {
        assert!(Vec3::from(*normal).distance(Vec3::from(*position).normalize()) < 1e-6, "{normal:?}");
    }
}

/// A prism of six sides, whose faces meet at 60 degrees, without its ends.
fn hexagonal_prism() -> String {
    let mut text = String::new();
    for k in 0..6 {
        let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 3.0).sin_cos();
        text += &format!(
            "v {sin} 0 {cos}\nv {sin} 1 {cos}\nf {} {} {} {}\n",
            2 * k + 1,
            (2 * k + 2) % 12 + 1,
            (2 * k + 3) % 12 + 1,
            2 * k + 2
        );
    }
    text
}

#[test]
fn the_crease_angle_itself_is_still_smooth() {
    let smooth = with_crease(&hexagonal_prism(), 60.0);
    assert_eq!(smooth.positions().len(), 12);
    for (position, normal) in smooth.positions().iter().zip(smooth.normals()) {
        let outwards = Vec3::new(position[0], 0.0, position[2]);
        assert!(Vec3::from(*normal).distance(outwards) < 1e-5, "{normal:?}");
    }
    assert_eq!(with_crease(&hexagonal_prism(), 59.0).positions().len(), 24);
}

#[test]
fn a_seam_of_doubled_positions_is_no_seam_of_the_surface() {
    // Two faces that meet at 53 degrees along x = 0, each with its own vertices there; -0 is 0.
    let seam = "v -3 0 0\nv 0 0 0\nv 0 0 1\nv -0 -0 0\nv 3 4 0\nv 0 0 1\nf 1 2 3\nf 4 5 6\n";
    let smooth = with_crease(seam, 60.0);
    assert_eq!(smooth.positions().len(), 4);
    let hard = with_crease(seam, 50.0);
    assert_eq!(hard.positions().len(), 6);
}

#[test]
fn normals_are_smooth_across_objects_that_touch() {
    let joined = mesh("v -3 0 0\nv 0 0 0\nv 0 0 1\nv 3 1 0\no a\nf 1 2 3\no b\nf 2 4 3\n");
    assert_eq!((joined.positions().len(), joined.objects().len()), (6, 2));
    for (i, position) in joined.positions().iter().enumerate() {
        for (k, other) in joined.positions().iter().enumerate() {
            assert!(position != other || joined.normals()[i] == joined.normals()[k]);
        }
    }
}

#[test]
fn normals_of_a_sphere_point_outwards_at_every_scale() {
    let unit = sphere(24, 1.0);
    assert_sound(&unit);
    for (position, normal) in unit.positions().iter().zip(unit.normals()) {
        assert!(Vec3::from(*position).distance(Vec3::from(*normal)) < 0.02, "{position:?} {normal:?}");
    }
    for radius in [1e-7, 1e7] {
        let scaled = sphere(24, radius);
        assert_eq!(scaled.indices(), unit.indices(), "the same triangles are kept at scale {radius}");
        for (normal, same) in scaled.normals().iter().zip(unit.normals()) {
            assert!(Vec3::from(*normal).distance(Vec3::from(*same)) < 1e-4);
        }
    }
}

#[test]
fn given_normals_are_kept_and_unusable_ones_replaced() {
    let text = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nvn 0 3 4\nvn 0 0 0\nvn nan 0 1\nf 1//1 2//2 3//3\nf 2//1 4 3//1\n";
    let loaded = parse(text).expect("a usable model");
    assert_sound(&loaded.mesh);
    let (bad, missing) = (MeshWarning::BadNormals { vertices: 2 }, MeshWarning::SomeNormalsMissing { vertices: 1 });
    assert_eq!(loaded.warnings, [bad, missing]);
    assert_eq!(bad.to_string(), "replaced 2 normals that are zero or not finite");
    let found: Vec<[f32; 3]> = loaded.mesh.indices().iter().map(|&i| loaded.mesh.normals()[i as usize]).collect();
    let (given, computed) = ([0.0, 0.6, 0.8], [0.0, 0.0, 1.0]);
    assert_eq!(found, [given, computed, computed, given, computed, given]);
}

#[test]
fn windings_are_turned_to_agree_with_the_normals() {
    let text = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nvn 0 0.1 -1\nvn 0 0 1\nf 1//1 2//1 3//1\nf 2//2 4//2 3//2\n";
    let loaded = parse(text).expect("a usable model");
    assert_eq!(loaded.warnings, [MeshWarning::WindingTurned { triangles: 1 }]);
    for triangle in loaded.mesh.indices().chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(loaded.mesh.positions()[triangle[k] as usize]));
        let normal = Vec3::from(loaded.mesh.normals()[triangle[0] as usize]);
        assert!((b - a).cross(c - a).dot(normal) > 0.0);
    }
}

#[test]
fn bad_positions_and_empty_triangles_are_dropped_with_their_number() {
    let good = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 1 1 0\nv nan 0 0\nv 0 1e13 0\nv 2 2 0\n";
    let faces = "f 1 2 3\nf 1 2 5\nf 1 2 7 5\nf 6 2 3\nf 1 1 2\nf 2 4 3\n";
    let loaded = parse(&format!("{good}{faces}")).expect("a usable model");
    assert_sound(&loaded.mesh);
    assert_eq!(loaded.mesh.indices().len(), 3);
    let positions = MeshWarning::BadPositions { vertices: 2, triangles: 4 };
    assert_eq!(loaded.warnings, [positions, MeshWarning::ZeroArea { triangles: 2 }]);
    let texts: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        [
            "dropped 4 triangles that use 2 vertices with a coordinate that is not finite or beyond 1e12",
            "dropped 2 triangles of zero area",
        ]
    );
}

#[test]
fn slivers_within_rounding_go_and_thin_triangles_stay() {
    // Three points on a line that single precision cannot hold exactly, at several scales.
    for scale in [1e-7_f32, 1.0, 1e7] {
        let on_line = |t: f32| [0.1 * t * scale, 0.7 * t * scale, 0.3 * t * scale];
        let thin = [1.0, 7.0 + 1e-5, 3.0].map(|x| x * scale);
        let positions = vec![on_line(0.0), on_line(10.0), on_line(3.0), thin];
        let loaded =
            Mesh::build(positions, None, &[0, 1, 2, 0, 1, 3], &[], &MeshOptions::default()).expect("one is good");
        assert_eq!(loaded.mesh.indices().len(), 3, "scale {scale}");
        assert_eq!(loaded.warnings, [MeshWarning::ZeroArea { triangles: 1 }]);
    }
}

#[test]
fn objects_keep_their_order_and_blocks_of_one_name_are_one() {
    let text = format!("{CUBE}g b c\nf 1 4 3\no a\nf 5 6 7\nf 7 8 5\ng b c\nf 1 3 2\no empty\n");
    let mesh = mesh(&text);
    assert_sound(&mesh);
    let found: Vec<(&str, u32)> = mesh.objects().iter().map(|o| (o.name.as_str(), o.index_count / 3)).collect();
    assert_eq!(found, [("unnamed_object", 12), ("b c", 2), ("a", 2)]);
    assert_eq!(mesh.object_index("a").ok(), Some(2));
    assert_eq!(mesh.object_index("1").ok(), Some(1));
    let error = mesh.object_index("3").expect_err("out of range").to_string();
    assert!(error.contains("an index from 0 to 2") && error.contains("`unnamed_object`, `b c`, `a`"), "{error}");
}

#[test]
fn names_win_over_indices_and_must_be_unique() {
    let object = |name: &str, first_index| Object { name: name.to_string(), first_index, index_count: 3 };
    let make = |objects: &[Object]| {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Mesh::build(positions, None, &[0, 1, 2, 0, 1, 2], objects, &MeshOptions::default())
    };
    let mesh = make(&[object("1", 0), object("x", 3)]).expect("two objects").mesh;
    assert_eq!((mesh.object_index("1").ok(), mesh.object_index("0").ok()), (Some(0), Some(0)));
    assert_sound(&mesh);
    let twins = make(&[object("x", 0), object("x", 3)]).expect("two objects").mesh;
    assert!(twins.object_index("x").is_err_and(|error| error.to_string().contains("objects 0 and 1")));
    // Objects that leave a gap, overlap, cut a triangle, or end early.
    for objects in [[object("a", 0), object("b", 4)], [object("a", 0), object("b", 0)]] {
        assert!(make(&objects).is_err());
    }
    assert!(make(&[object("a", 0)]).is_err());
    assert!(make(&[Object { name: String::new(), first_index: 0, index_count: 4 }]).is_err());
}

#[test]
fn an_object_that_loses_all_its_triangles_keeps_its_place() {
    let loaded = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\no a\nf 1 1 2\no b\nf 1 2 3\n").expect("a usable model");
    assert_sound(&loaded.mesh);
    assert_eq!(loaded.mesh.objects()[0].index_count, 0);
    assert!(loaded.warnings.contains(&MeshWarning::EmptiedObjects { objects: 1 }));
}

#[test]
fn more_objects_than_ids_are_refused() {
    let blocks = |n: usize| {
        let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_string();
        (0..n).for_each(|i| text += &format!("o {i}\nf 1 2 3\n"));
        parse(&text)
    };
    assert_eq!(blocks(MAX_OBJECTS).expect("as many as fit").mesh.objects().len(), MAX_OBJECTS);
    let error = blocks(MAX_OBJECTS + 1).expect_err("one too many").to_string();
    assert!(error.contains("more than 65535 objects"), "{error}");
}

#[test]
fn bounds_and_sphere_hold_the_mesh_tightly() {
    let cube = mesh(CUBE);
    assert_eq!(cube.bounds(), (Vec3::NEG_ONE, Vec3::ONE));
    let sphere = cube.bounding_sphere();
    assert_eq!(sphere.center, Vec3::ZERO);
    assert!(sphere.radius >= 3.0_f32.sqrt() && sphere.radius < 1.7321, "{sphere:?}");
}

#[test]
fn unusable_geometry_is_refused_with_the_reason() {
    let options = MeshOptions::default();
    let good = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let fails = |positions: &[[f32; 3]], normals: Option<Vec<[f32; 3]>>, indices: &[u32], part: &str| {
        let error = Mesh::build(positions.to_vec(), normals, indices, &[], &options).expect_err(part).to_string();
        assert!(error.contains(part), "{error}");
    };
    fails(&good, None, &[], "indices");
    fails(&good, None, &[0, 1], "indices");
    fails(&good, None, &[0, 1, 3], "indices is 3, but must be below the vertex count (3)");
    fails(&good, Some(vec![[0.0, 0.0, 1.0]]), &[0, 1, 2], "as many as positions (3)");
    fails(&[[0.0; 3]; 3], None, &[0, 1, 2], "none of its 1 triangles is usable: dropped 1 triangle of zero area");
    fails(&[[f32::NAN; 3]; 3], None, &[0, 1, 2], "3 vertices with a coordinate that is not finite");
    let speck = good.iter().map(|p| p.map(|x| x * 1e-20)).collect::<Vec<_>>();
    fails(&speck, None, &[0, 1, 2], "scale it up");
    for crease_deg in [-1.0, 181.0, f32::NAN] {
        let error = Mesh::build(good.clone(), None, &[0, 1, 2], &[], &MeshOptions { crease_deg });
        assert!(matches!(error, Err(Error::Parameter { name: "crease_deg", .. })));
    }
}

#[test]
fn a_face_with_many_doubled_edges_and_wild_input_end_quickly() {
    // Thousands of faces about one edge, and one vertex of thousands of faces.
    let mut text = "v 0 0 0\nv 0 1 0\n".to_string();
    for k in 0..3000 {
        let (sin, cos) = (f64::from(k) * 0.0021).sin_cos();
        text += &format!("v {sin} 0.5 {cos}\nf 1 2 {}\n", k + 3);
    }
    for crease_deg in [0.0, 0.1, 60.0, 180.0] {
        let mesh = Mesh::parse(text.as_bytes(), "edge.obj", &MeshOptions { crease_deg }).expect("a model").mesh;
        assert_sound(&mesh);
        assert_eq!(mesh.indices().len(), 9000);
    }
}

/// Damages a good file in many ways: whatever comes out is an error or a sound mesh, never a panic.
#[test]
fn damaged_files_give_an_error_or_a_sound_mesh() {
    let text = format!("{CUBE}o b\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//2 3//-1\nf -1 -2 -3 -4 -6\nl 1 2 3\nf 1/2/1 2 3\n");
    let mut state = 12345_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let (mut good, mut refused) = (0, 0);
    for _ in 0..3000 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            let letters = b"0123456789-/. \n\\#evfnogl\r\xff\0";
            match random(4) {
                0 => bytes[at] = letters[random(letters.len())],
                1 => bytes.insert(at, letters[random(letters.len())]),
                2 => drop(bytes.remove(at)),
                _ => bytes.truncate(at.max(40)),
            }
        }
        match Mesh::parse(&bytes[..], "damaged.obj", &MeshOptions::default()) {
            Ok(loaded) => {
                assert_sound(&loaded.mesh);
                good += 1;
            }
            Err(error) => {
                assert!(error.to_string().starts_with("damaged.obj: "), "{error}");
                refused += 1;
            }
        }
    }
    assert!(good > 100 && refused > 100, "{good} good, {refused} refused");
}
