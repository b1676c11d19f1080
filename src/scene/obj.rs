//! Reading Wavefront OBJ text with `tobj` into plain arrays: triangles, grouped by object, not yet cleaned.

use std::collections::HashMap;
use std::io::{BufReader, Read};
use std::path::Path;

use super::clean::{is_usable, RawMesh};
use super::obj_lines::{Failure, LineCounts, ObjLines};
use super::polygon::{Cut, Triangulator};
use super::MeshWarning;
use crate::error::{Error, Result};

/// The largest model file in bytes: 1 GiB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;
/// The most triangles of one model. It bounds memory to about 2 GiB while a file is read.
pub const MAX_TRIANGLES: usize = 1 << 22;
/// The most vertices, and the most normals, of one model.
pub const MAX_VERTICES: usize = 1 << 24;

/// Reads OBJ text to its end; `name` is what errors call it. The warnings are those of reading alone.
pub(super) fn read(reader: impl Read, name: &Path) -> Result<(RawMesh, Vec<MeshWarning>)> {
    let mut lines = ObjLines::new(BufReader::with_capacity(1 << 16, reader));
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    // The lines name no material library, so the loader is never asked for one.
    let parsed = tobj::load_obj_buf(&mut lines, &options, |_| Err(tobj::LoadError::OpenFileFailed));
    let line = lines.line();
    let counts = lines.finish().map_err(|failure| match failure {
        Failure::Io(source) => Error::io(name, source),
        Failure::Content(reason) => Error::file(name, reason),
    })?;
    let (models, _) = parsed.map_err(|error| Error::file(name, format!("line {line}: {error}")))?;

    let mut merge = Merge::default();
    for model in models {
        merge.add(model).map_err(|reason| Error::file(name, reason))?;
    }
    if merge.triangle_count == 0 {
        return Err(Error::file(name, no_faces(&counts)));
    }
    let warnings = [
        (counts.short_faces > 0).then_some(MeshWarning::ShortFaces { faces: counts.short_faces }),
        (counts.lines_and_points > 0).then_some(MeshWarning::LinesAndPoints { elements: counts.lines_and_points }),
        (merge.rough_cuts > 0).then_some(MeshWarning::CrossingFaces { faces: merge.rough_cuts }),
    ];
    Ok((merge.into_raw(), warnings.into_iter().flatten().collect()))
}

/// What is wrong with a file beyond [`MAX_FILE_BYTES`].
pub(super) fn too_large() -> String {
    format!("is larger than {} MiB", MAX_FILE_BYTES >> 20)
}

fn no_faces(counts: &LineCounts) -> String {
    let mut held = format!("{} vertices", counts.positions);
    if counts.short_faces > 0 {
        held += &format!(", {} faces with fewer than three corners", counts.short_faces);
    }
    if counts.lines_and_points > 0 {
        held += &format!(", {} line and point elements", counts.lines_and_points);
    }
    format!("holds no faces to shade ({held})")
}

/// Gathers the models that `tobj` made, one for each `o` or `g` block, into one mesh. Blocks of the same name are one
/// object: many programs open a group anew for every material in it.
#[derive(Default)]
struct Merge {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Name and triangles of each object, in the order of the file.
    objects: Vec<(String, Vec<[u32; 3]>)>,
    by_name: HashMap<String, usize>,
    triangulator: Triangulator,
    triangle_count: usize,
    rough_cuts: usize,
}

impl Merge {
    /// Adds one model, after checking that its arrays fit together.
    fn add(&mut self, model: tobj::Model) -> Result<(), String> {
        let mesh = model.mesh;
        if mesh.indices.is_empty() {
            return Ok(());
        }
        let vertex_count = mesh.positions.len() / 3;
        let arity_sum: usize = mesh.face_arities.iter().map(|&n| n as usize).sum();
        let fits = mesh.positions.len().is_multiple_of(3)
            && mesh.normals.len() == mesh.positions.len()
            && mesh.indices.iter().all(|&i| (i as usize) < vertex_count)
            && if mesh.face_arities.is_empty() {
                mesh.indices.len().is_multiple_of(3)
            } else {
                arity_sum == mesh.indices.len()
            };
        if !fits {
            return Err(format!("object `{}`: its arrays do not fit together", model.name));
        }
        let first = self.positions.len();
        if first + vertex_count > u32::MAX as usize {
            return Err("more vertices than 32 bits can number".to_string());
        }
        let triples = |flat: &[f32]| flat.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect::<Vec<_>>();
        self.positions.extend(triples(&mesh.positions));
        self.normals.extend(triples(&mesh.normals));

        let object = *self.by_name.entry(model.name).or_insert_with_key(|name| {
            self.objects.push((name.clone(), Vec::new()));
            self.objects.len() - 1
        });
        let mut rest = &mesh.indices[..];
        let mut arities = mesh.face_arities.iter().map(|&n| n as usize);
        while !rest.is_empty() {
            let (face, others) = rest.split_at(arities.next().unwrap_or(3));
            rest = others;
            self.add_face(object, face, first as u32);
        }
        Ok(())
    }

    /// Cuts one face into triangles. `first` is the number of the model's first vertex.
    fn add_face(&mut self, object: usize, face: &[u32], first: u32) {
        if face.len() < 3 {
            return;
        }
        let corners: Vec<u32> = face.iter().map(|&i| first + i).collect();
        let places: Vec<[f32; 3]> = corners.iter().map(|&i| self.positions[i as usize]).collect();
        let triangles = &mut self.objects[object].1;
        self.triangle_count += face.len() - 2;
        if let Some(bad) = places.iter().position(|&place| !is_usable(place)) {
            // There is no plane to cut it in. A fan about the bad corner keeps the count, and all of it will be
            // dropped.
            let n = corners.len();
            let at = |i: usize| corners[(bad + i) % n];
            triangles.extend((2..n).map(|i| [at(0), at(i - 1), at(i)]));
            return;
        }
        let cut = self.triangulator.cut(&places, |[a, b, c]| triangles.push([corners[a], corners[b], corners[c]]));
        self.rough_cuts += usize::from(cut == Cut::Rough);
    }

    fn into_raw(self) -> RawMesh {
        let mut triangles = Vec::with_capacity(self.triangle_count);
        let mut objects = Vec::with_capacity(self.objects.len());
        for (name, of_object) in self.objects {
            triangles.extend_from_slice(&of_object);
            objects.push((name, of_object.len()));
        }
        // The lines hold a NaN nowhere but in the placeholder for "no normal".
        let normals = self.normals.into_iter().map(|normal| (!normal[0].is_nan()).then_some(normal)).collect();
        RawMesh { positions: self.positions, normals, triangles, objects }
    }
}
