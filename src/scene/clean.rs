//! From raw triangles to a mesh that later stages can trust.
//!
//! In this order: triangles with unusable positions go, then those without area; windings are turned to agree with the
//! normals that were given; missing normals are computed ([`super::normals`]); vertices that no triangle uses go, and
//! those that several objects or several smooth regions share are doubled. Each step counts what it did.

use glam::DVec3;

use super::mesh::{Mesh, MeshOptions, Object};
use super::normals::smooth_normals;
use super::warning::MeshWarning;

/// Coordinates beyond this are unusable: their squares and products would leave the range of single precision.
const MAX_COORDINATE: f32 = 1e12;
/// A model smaller than this in every direction is refused, for the same reason.
const MIN_EXTENT: f32 = 1e-12;

/// A mesh as it was read or given. Indices are in range; nothing else is promised.
pub(super) struct RawMesh {
    pub positions: Vec<[f32; 3]>,
    /// One per position; `None` where no normal was given.
    pub normals: Vec<Option<[f32; 3]>>,
    pub triangles: Vec<[u32; 3]>,
    /// Names and triangle counts, which add up to the number of triangles.
    pub objects: Vec<(String, usize)>,
}

/// True if every coordinate is finite and within range.
pub(super) fn is_usable(position: [f32; 3]) -> bool {
    position.iter().all(|x| x.abs() <= MAX_COORDINATE)
}

/// Cleans a raw mesh; the error is the reason why nothing usable is left.
pub(super) fn clean(mut raw: RawMesh, options: &MeshOptions) -> Result<(Mesh, Vec<MeshWarning>), String> {
    let mut warnings = Vec::new();
    let given = raw.triangles.len();
    drop_bad_positions(&mut raw, &mut warnings);
    drop_zero_area(&mut raw, &mut warnings);
    if raw.triangles.is_empty() {
        let reasons: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        return Err(format!("none of its {given} triangles is usable: {}", reasons.join("; ")));
    }
    check_extent(&raw)?;
    let emptied = raw.objects.iter().filter(|(_, triangles)| *triangles == 0).count();
    if emptied > 0 {
        warnings.push(MeshWarning::EmptiedObjects { objects: emptied });
    }
    unify_normals(&mut raw, &mut warnings);
    turn_windings(&mut raw, &mut warnings);
    Ok((assemble(&raw, options), warnings))
}

/// Keeps the triangles that `keep` says, and the objects' counts in step with them.
fn retain(raw: &mut RawMesh, mut keep: impl FnMut([u32; 3]) -> bool) {
    let mut next = 0;
    let mut kept = 0;
    for (_, count) in &mut raw.objects {
        let end = next + *count;
        let before = kept;
        for at in next..end {
            let triangle = raw.triangles[at];
            if keep(triangle) {
                raw.triangles[kept] = triangle;
                kept += 1;
            }
        }
        next = end;
        *count = kept - before;
    }
    raw.triangles.truncate(kept);
}

/// The vertices that some triangle uses.
fn used_vertices(raw: &RawMesh) -> Vec<bool> {
    let mut used = vec![false; raw.positions.len()];
    raw.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    used
}

fn drop_bad_positions(raw: &mut RawMesh, warnings: &mut Vec<MeshWarning>) {
    let bad: Vec<bool> = raw.positions.iter().map(|&position| !is_usable(position)).collect();
    let vertices = used_vertices(raw).iter().zip(&bad).filter(|(&used, &bad)| used && bad).count();
    if vertices > 0 {
        let before = raw.triangles.len();
        retain(raw, |triangle| triangle.iter().all(|&vertex| !bad[vertex as usize]));
        warnings.push(MeshWarning::BadPositions { vertices, triangles: before - raw.triangles.len() });
    }
}

fn drop_zero_area(raw: &mut RawMesh, warnings: &mut Vec<MeshWarning>) {
    let before = raw.triangles.len();
    let positions = std::mem::take(&mut raw.positions);
    retain(raw, |triangle| has_area(corners(&positions, triangle)));
    raw.positions = positions;
    if raw.triangles.len() < before {
        warnings.push(MeshWarning::ZeroArea { triangles: before - raw.triangles.len() });
    }
}

fn corners(positions: &[[f32; 3]], triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|vertex| DVec3::from(positions[vertex as usize].map(f64::from)))
}

/// Twice the triangle's area, along its normal.
fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// False if the height over the longest edge is within the rounding of the corners' coordinates (two units in the last
/// place of the largest): such a triangle has no direction that means anything. The test does not depend on scale.
fn has_area(triangle: [DVec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let largest = triangle.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    let rounding = 2.0 * f64::from(f32::EPSILON) * largest;
    area_vector(triangle).length() > longest * rounding
}

fn check_extent(raw: &RawMesh) -> Result<(), String> {
    let mut corners = raw.triangles.iter().flatten().map(|&vertex| raw.positions[vertex as usize]);
    let first = corners.next().unwrap_or_default();
    let (low, high) = corners.fold((first, first), |(low, high), position| {
        (std::array::from_fn(|i| low[i].min(position[i])), std::array::from_fn(|i| high[i].max(position[i])))
    });
    let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
    if extent < MIN_EXTENT {
        return Err(format!("is only {extent:e} units large; scale it up to at least {MIN_EXTENT:e}"));
    }
    Ok(())
}

/// Brings the given normals to unit length, and takes away those that have no direction.
fn unify_normals(raw: &mut RawMesh, warnings: &mut Vec<MeshWarning>) {
    let used = used_vertices(raw);
    let (mut good, mut bad, mut missing) = (0, 0, 0);
    for (normal, _) in raw.normals.iter_mut().zip(used).filter(|(_, used)| *used) {
        let Some(given) = *normal else {
            missing += 1;
            continue;
        };
        *normal = DVec3::from(given.map(f64::from)).try_normalize().map(|unit| unit.as_vec3().to_array());
        *if normal.is_some() { &mut good } else { &mut bad } += 1;
    }
    if bad > 0 {
        warnings.push(MeshWarning::BadNormals { vertices: bad });
    }
    if missing > 0 && good + bad > 0 {
        warnings.push(MeshWarning::SomeNormalsMissing { vertices: missing });
    }
}

/// Turns triangles whose winding says "back" where their normals say "front", so that the two always agree.
fn turn_windings(raw: &mut RawMesh, warnings: &mut Vec<MeshWarning>) {
    let mut turned = 0;
    for triangle in &mut raw.triangles {
        let given: Option<DVec3> = triangle
            .iter()
            .map(|&vertex| raw.normals[vertex as usize].map(|normal| DVec3::from(normal.map(f64::from))))
            .sum();
        if given.is_some_and(|sum| area_vector(corners(&raw.positions, *triangle)).dot(sum) < 0.0) {
            triangle.swap(1, 2);
            turned += 1;
        }
    }
    if turned > 0 {
        warnings.push(MeshWarning::WindingTurned { triangles: turned });
    }
}

/// Gives every corner its normal, and makes one vertex of the corners of an object that agree in position and normal.
fn assemble(raw: &RawMesh, options: &MeshOptions) -> Mesh {
    let any_missing = raw.triangles.iter().flatten().any(|&vertex| raw.normals[vertex as usize].is_none());
    let computed = any_missing.then(|| smooth_normals(&raw.positions, &raw.triangles, options.crease_deg));

    let mut mesh = Mesh {
        positions: Vec::with_capacity(raw.positions.len()),
        normals: Vec::with_capacity(raw.positions.len()),
        indices: Vec::with_capacity(raw.triangles.len() * 3),
        objects: Vec::with_capacity(raw.objects.len()),
    };
    // The new vertex of each old one that has its own normal, and of each smooth region of computed normals; made by
    // the object that comes first in the pair, and of no use to another.
    let mut of_vertex = vec![(u32::MAX, 0); raw.positions.len()];
    let mut of_region = vec![(u32::MAX, 0); computed.as_ref().map_or(0, |computed| computed.region_count())];
    let mut corner = 0;
    for (object, (name, triangles)) in raw.objects.iter().enumerate() {
        let object = object as u32;
        let first_index = mesh.indices.len() as u32;
        for &vertex in raw.triangles[corner / 3..corner / 3 + triangles].iter().flatten() {
            let vertex = vertex as usize;
            let (made, normal) = match (raw.normals[vertex], &computed) {
                (None, Some(computed)) => {
                    let (region, normal) = computed.at(corner);
                    (&mut of_region[region as usize], normal)
                }
                (given, _) => (&mut of_vertex[vertex], given.unwrap_or_default()),
            };
            if made.0 != object {
                *made = (object, mesh.positions.len() as u32);
                mesh.positions.push(raw.positions[vertex]);
                mesh.normals.push(normal);
            }
            mesh.indices.push(made.1);
            corner += 1;
        }
        let index_count = mesh.indices.len() as u32 - first_index;
        mesh.objects.push(Object { name: name.clone(), first_index, index_count });
    }
    mesh
}
