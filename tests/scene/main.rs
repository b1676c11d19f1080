//! The scene: meshes, cameras, light, and the plain rasteriser, against values worked out by hand and properties;
//! motion on the GPU against the plain one.

mod camera;
#[path = "../common/mod.rs"]
mod common;
mod host_motion;
mod light;
mod mesh;
mod motion;
mod odd_models;
mod oracle;

use std::path::PathBuf;

use impasto::scene::{Loaded, Mesh, MeshOptions, Vec3};

/// Reads OBJ text with the default options.
fn parse(text: &str) -> impasto::Result<Loaded> {
    Mesh::parse(text.as_bytes(), "test.obj", &MeshOptions::default())
}

/// The mesh of OBJ text that is known to be good.
fn mesh(text: &str) -> Mesh {
    parse(text).expect("a usable model").mesh
}

/// A sphere of `rings` by `2 rings` quads about the origin, poles included, without normals. With a pole's quads come
/// triangles without area.
fn sphere(rings: u32, radius: f32) -> Mesh {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    let around = 2 * rings;
    for ring in 0..=rings {
        for step in 0..around {
            let (theta, phi) = (
                f64::from(ring) / f64::from(rings) * std::f64::consts::PI,
                f64::from(step) / f64::from(around) * std::f64::consts::TAU,
            );
            let sin = if ring == 0 || ring == rings { 0.0 } else { theta.sin() };
            let unit = [sin * phi.sin(), theta.cos(), sin * phi.cos()];
            positions.push(unit.map(|x| (x * f64::from(radius)) as f32));
            if ring < rings {
                let [a, b] = [step, (step + 1) % around].map(|step| ring * around + step);
                indices.extend([a, a + around, b + around, a, b + around, b]);
            }
        }
    }
    let loaded = Mesh::build(positions, None, &indices, &[], &MeshOptions::default()).expect("a sphere");
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    loaded.mesh
}

/// What every mesh promises, whatever it was made of.
fn assert_sound(mesh: &Mesh) {
    let vertices = mesh.positions().len();
    assert!(!mesh.indices().is_empty() && mesh.indices().len().is_multiple_of(3));
    assert_eq!(mesh.normals().len(), vertices);
    assert!(mesh.positions().iter().flatten().all(|x| x.is_finite()));
    for normal in mesh.normals() {
        assert!((Vec3::from(*normal).length() - 1.0).abs() < 1e-5, "{normal:?}");
    }
    let mut used = vec![None; vertices];
    let mut next = 0;
    for (number, object) in mesh.objects().iter().enumerate() {
        assert_eq!(object.first_index, next);
        assert_eq!(object.index_count % 3, 0);
        next += object.index_count;
        for &vertex in &mesh.indices()[object.first_index as usize..next as usize] {
            let owner = used[vertex as usize].get_or_insert(number as u32);
            assert_eq!(*owner, number as u32, "vertex {vertex} belongs to two objects");
        }
    }
    assert_eq!(next as usize, mesh.indices().len());
    let owners: Vec<u32> = used.into_iter().map(|owner| owner.expect("no vertex is left over")).collect();
    assert_eq!(mesh.object_of_vertex(), owners);
    for object in 0..=mesh.objects().len() {
        let own = (0..vertices).filter(|&vertex| owners[vertex] as usize == object);
        assert!(mesh.vertices_of(object).eq(own), "object {object}");
    }
    for triangle in mesh.indices().chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(mesh.positions()[triangle[k] as usize]).as_dvec3());
        assert!((b - a).cross(c - a).length() > 0.0, "{triangle:?}");
    }
}

/// The folder of the optional sample data, or `None` where it is not there.
fn sample_data() -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data"));
    let folder = std::env::var_os("IMPASTO_DATA").map_or_else(beside, PathBuf::from);
    let there = folder.join("odd_models").is_dir();
    if !there {
        eprintln!("no sample data at {}: skipped", folder.display());
    }
    there.then_some(folder)
}
