//! Model files from the wild: each gives the expected mesh, or an error that says what is wrong and where.

use std::fs;

use impasto::scene::{Camera, Framing, Mesh, MeshOptions, MeshWarning};
use impasto::Error;

use crate::{assert_sound, sample_data};

/// File, triangles, objects, warnings in their order.
const GOOD: &[(&str, usize, usize, &[MeshWarning])] = &[
    ("models/bunny.obj", 69_451, 1, &[]),
    ("models/demosthenes_bust.obj", 16_719, 1, &[]),
    ("models/skull.obj", 100_002, 1, &[]),
    ("models/skull_low.obj", 10_312, 1, &[]),
    ("models/sphere.obj", 1280, 1, &[]),
    ("models/spot.obj", 5856, 1, &[]),
    ("models/spot_control_mesh.obj", 372, 1, &[MeshWarning::CrossingFaces { faces: 2 }]),
    ("models/table_2tri.obj", 2, 1, &[]),
    ("models/teapot.obj", 6320, 1, &[]),
    ("models/teapot_on_table.obj", 6322, 2, &[]),
    ("models/venus_de_milo.obj", 43_357, 1, &[MeshWarning::WindingTurned { triangles: 2 }]),
    ("odd_models/assimp/box_longline.obj", 478, 1, &[MeshWarning::ZeroArea { triangles: 466 }]),
    ("odd_models/assimp/concave_polygon.obj", 64, 1, &[]),
    ("odd_models/assimp/regr01.obj", 2686, 55, &[MeshWarning::ZeroArea { triangles: 24 }]),
    ("odd_models/assimp/testmixed.obj", 12, 1, &[MeshWarning::LinesAndPoints { elements: 12 }]),
    ("odd_models/derived/spot_unicode_crlf.obj", 372, 2, &[MeshWarning::CrossingFaces { faces: 2 }]),
    ("odd_models/derived/teapot_huge_1e7.obj", 6320, 1, &[]),
    ("odd_models/derived/teapot_tiny_1e-7.obj", 6320, 1, &[]),
    ("odd_models/tinyobjloader/cornell_box_multimaterial.obj", 36, 8, &[]),
    ("odd_models/tinyobjloader/cube-vertex-w-component.obj", 12, 6, &[]),
    ("odd_models/tinyobjloader/test-nan.obj", 34, 8, &[MeshWarning::BadPositions { vertices: 4, triangles: 2 }]),
    ("odd_models/trimesh/capsule.obj", 10_000, 1, &[MeshWarning::ZeroArea { triangles: 200 }]),
    ("odd_models/trimesh/joined_tetrahedra.obj", 8, 2, &[]),
    ("odd_models/trimesh/negative_indices.obj", 12, 1, &[]),
    ("odd_models/trimesh/notenoughindices.obj", 1, 1, &[MeshWarning::ShortFaces { faces: 1 }]),
    ("odd_models/trimesh/two_objects.obj", 16, 2, &[]),
    ("odd_models/trimesh/wallhole.obj", 66, 1, &[]),
];

/// File, and what its error says.
const REFUSED: &[(&str, &str)] = &[
    ("models/bunny_dense_1.1M.obj.gz", "is compressed with gzip; unpack it first"),
    ("odd_models/assimp/empty.obj", "holds no faces to shade (0 vertices)"),
    ("odd_models/assimp/malformed.obj", "line 28: face corner `0`: indices start at 1, not 0"),
    ("odd_models/assimp/number_formats.obj", "line 11: `3.1+e2` is not a number"),
    ("odd_models/assimp/point_cloud.obj", "holds no faces to shade (3 vertices)"),
    ("odd_models/tinyobjloader/issue-140-zero-face-idx.obj", "line 16: face corner `0/0/0`: indices start at 1, not 0"),
];

#[test]
fn every_model_gives_the_expected_mesh_or_error() {
    let Some(data) = sample_data() else { return };
    for &(file, triangles, objects, warnings) in GOOD {
        let loaded = Mesh::load(data.join(file), &MeshOptions::default()).expect(file);
        assert_sound(&loaded.mesh);
        let found = (loaded.mesh.indices().len() / 3, loaded.mesh.objects().len(), &loaded.warnings[..]);
        assert_eq!(found, (triangles, objects, warnings), "{file}");
    }
    for &(file, reason) in REFUSED {
        let path = data.join(file);
        let error = Mesh::load(&path, &MeshOptions::default()).expect_err(file);
        assert_eq!(error.to_string(), format!("{}: {reason}", path.display()));
    }
}

#[test]
fn no_model_of_the_sample_data_is_left_out() {
    let Some(data) = sample_data() else { return };
    let listed: Vec<_> = GOOD.iter().map(|row| row.0).chain(REFUSED.iter().map(|row| row.0)).collect();
    let folders =
        ["models", "odd_models/assimp", "odd_models/derived", "odd_models/tinyobjloader", "odd_models/trimesh"];
    for folder in folders {
        for entry in fs::read_dir(data.join(folder)).expect("a folder of models") {
            let name = entry.expect("a readable entry").file_name().into_string().expect("an ASCII name");
            let name = format!("{folder}/{name}");
            assert!(name.ends_with(".mtl") || listed.contains(&name.as_str()), "{name} is in no table");
        }
    }
}

/// Areas worked out by hand: concave faces and holes are covered once, and nothing outside of them is.
#[test]
fn concave_faces_have_their_true_area() {
    let Some(data) = sample_data() else { return };
    let area = |file: &str| {
        let mesh = Mesh::load(data.join(file), &MeshOptions::default()).expect(file).mesh;
        let corner = |i: u32| impasto::scene::Vec3::from(mesh.positions()[i as usize]).as_dvec3();
        let triangles = mesh.indices().chunks_exact(3);
        triangles.map(|t| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length() / 2.0).sum::<f64>()
    };
    // One ring-shaped face.
    assert!((area("odd_models/assimp/concave_polygon.obj") - RING_AREA).abs() < 1e-5);
    let cube = area("odd_models/trimesh/negative_indices.obj");
    assert!((cube - 24.0).abs() < 1e-5, "{cube}");
}

/// Sum over the corners of `concave_polygon.obj` of half the cross product of each corner with the next.
const RING_AREA: f64 = 0.245_496_687;

#[test]
fn teapots_of_all_scales_are_alike() {
    let Some(data) = sample_data() else { return };
    let load = |file: &str| Mesh::load(data.join(file), &MeshOptions::default()).expect(file).mesh;
    let teapot = load("models/teapot.obj");
    for (file, scale) in [("teapot_tiny_1e-7", 1e-7), ("teapot_huge_1e7", 1e7)] {
        let scaled = load(&format!("odd_models/derived/{file}.obj"));
        assert_eq!(scaled.indices(), teapot.indices());
        let camera = |mesh| Camera::framing(mesh, &Framing::default(), 1.5).expect("a camera");
        let (a, b) = (camera(&scaled).eye(), camera(&teapot).eye() * scale);
        assert!(a.distance(b) < 1e-4 * b.length(), "{a} {b}");
    }
}

#[test]
fn names_survive_in_any_encoding() {
    let Some(data) = sample_data() else { return };
    let names = |file: &str| -> Vec<String> {
        let mesh = Mesh::load(data.join(file), &MeshOptions::default()).expect(file).mesh;
        mesh.objects().iter().map(|object| object.name.clone()).collect()
    };
    let unicode = names("odd_models/derived/spot_unicode_crlf.obj");
    assert!(unicode.iter().all(|name| name.chars().any(|c| c as u32 > 127) && !name.contains('\r')), "{unicode:?}");
    let groups = names("odd_models/tinyobjloader/cube-vertex-w-component.obj");
    assert_eq!(groups, ["front cube", "back cube", "right cube", "top cube", "left cube", "bottom cube"]);
}

#[test]
fn files_that_are_not_there_or_are_folders_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let missing = folder.path().join("missing.obj");
    let error = Mesh::load(&missing, &MeshOptions::default()).expect_err("no such file");
    assert!(matches!(&error, Error::Io { path, .. } if *path == missing), "{error}");
    let error = Mesh::load(folder.path(), &MeshOptions::default()).expect_err("a folder").to_string();
    assert!(error.ends_with("is a folder, not a model file"), "{error}");
}

/// A file that claims to be too large is refused before it is read (it is sparse: nothing is on the disk).
#[test]
fn a_file_beyond_the_limit_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.obj");
    let file = fs::File::create(&path).expect("a new file");
    file.set_len((1 << 30) + 1).expect("a sparse file");
    let error = Mesh::load(&path, &MeshOptions::default()).expect_err("too large").to_string();
    assert!(error.ends_with("large.obj: is larger than 1024 MiB"), "{error}");
}
