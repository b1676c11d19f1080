//! The triangle mesh that every later stage works on, and the ways to make one.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::clean::{clean, RawMesh};
use super::obj::{self, MAX_TRIANGLES, MAX_VERTICES};
use super::warning::MeshWarning;
use crate::error::{Error, Result};

/// The most objects of one mesh: the ID buffer stores object index + 1 in 16 bits, and 0 for the background.
pub const MAX_OBJECTS: usize = 65_535;

/// A part of a mesh that gets its own paint and its own ID: an `o` or `g` block of an OBJ file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Object {
    /// Its name; `unnamed_object` for faces of a file that names none.
    pub name: String,
    /// Where its triangles begin in [`Mesh::indices`]; a multiple of 3.
    pub first_index: u32,
    /// How many indices it has: three per triangle. 0 if none of its triangles was usable.
    pub index_count: u32,
}

/// A triangle mesh of one or more objects, checked and repaired (thesis section 3.1.1).
///
/// What always holds: there is at least one triangle; every triangle has an area; positions are finite; normals have
/// unit length; indices are in range; objects lie one after the other in `indices`, and so do their vertices, each
/// beginning with its first index and sharing none with another; where normals were given, a triangle's
/// counter-clockwise side is the one that its normals point to.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) indices: Vec<u32>,
    pub(super) objects: Vec<Object>,
}

/// How a mesh is made of raw data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshOptions {
    /// Where normals have to be computed, faces that meet at a sharper angle than this keep a hard edge. In degrees,
    /// 0 (all flat) to 180 (all smooth).
    pub crease_deg: f32,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self { crease_deg: 60.0 }
    }
}

impl MeshOptions {
    fn check(&self) -> Result<()> {
        if (0.0..=180.0).contains(&self.crease_deg) {
            return Ok(());
        }
        Err(Error::parameter("crease_deg", self.crease_deg, "from 0 to 180 degrees"))
    }
}

/// A mesh, and what had to be dropped or repaired to get it.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The usable mesh.
    pub mesh: Mesh,
    /// What was found wrong; empty for a clean model.
    pub warnings: Vec<MeshWarning>,
}

/// A sphere that holds every vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingSphere {
    /// The middle of the bounding box.
    pub center: Vec3,
    /// Distance from there to the farthest vertex; above 0.
    pub radius: f32,
}

impl Mesh {
    /// Reads a Wavefront OBJ file. Only this file is opened: material libraries that it names are not needed.
    ///
    /// Faces may have any number of corners and be concave; indices may be relative. Texture coordinates, materials,
    /// and lines and points are left out. `o` and `g` both begin an object; blocks of the same name are one object.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read. [`Error::File`] with the line where possible if it is larger than
    /// [`MAX_FILE_BYTES`](super::MAX_FILE_BYTES), is malformed, refers to vertices that do not exist, has more than
    /// [`MAX_TRIANGLES`](super::MAX_TRIANGLES) triangles or [`MAX_OBJECTS`] objects, or holds no usable triangle.
    /// [`Error::Parameter`] if an option is out of range.
    pub fn load(path: impl AsRef<Path>, options: &MeshOptions) -> Result<Loaded> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|source| Error::io(path, source))?;
        let metadata = file.metadata().map_err(|source| Error::io(path, source))?;
        if metadata.is_dir() {
            return Err(Error::file(path, "is a folder, not a model file"));
        }
        if metadata.len() > obj::MAX_FILE_BYTES {
            return Err(Error::file(path, obj::too_large()));
        }
        Self::parse(file, path, options)
    }

    /// Reads Wavefront OBJ text from memory (`&[u8]`) or any other reader; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Mesh::load`].
    pub fn parse(reader: impl Read, name: impl AsRef<Path>, options: &MeshOptions) -> Result<Loaded> {
        options.check()?;
        let name = name.as_ref();
        let (raw, mut warnings) = obj::read(reader, name)?;
        let (mesh, found) = clean(raw, options).map_err(|reason| Error::file(name, reason))?;
        warnings.extend(found);
        Ok(Loaded { mesh, warnings })
    }

    /// Makes a mesh of geometry that a host has at hand.
    ///
    /// `normals` has one entry per position, or is `None` to have all computed; single ones that are zero or not finite
    /// are computed as well. `indices` has three entries per triangle. `objects` lie one after the other and cover all
    /// indices; an empty list makes everything one object. Vertices may be renumbered, objects keep their order.
    ///
    /// # Errors
    /// [`Error::Parameter`] if lengths, indices, object ranges or options do not fit, or a limit is exceeded (as for
    /// [`Mesh::load`]). [`Error::File`], with the name "mesh", if no triangle is usable.
    pub fn build(
        positions: Vec<[f32; 3]>,
        normals: Option<Vec<[f32; 3]>>,
        indices: &[u32],
        objects: &[Object],
        options: &MeshOptions,
    ) -> Result<Loaded> {
        options.check()?;
        if positions.len() > MAX_VERTICES {
            return Err(Error::parameter("positions", positions.len(), format!("at most {MAX_VERTICES}")));
        }
        let normals = match normals {
            None => vec![None; positions.len()],
            Some(normals) if normals.len() == positions.len() => normals.into_iter().map(Some).collect(),
            Some(normals) => {
                let allowed = format!("as many as positions ({})", positions.len());
                return Err(Error::parameter("normals", normals.len(), allowed));
            }
        };
        if indices.is_empty() || !indices.len().is_multiple_of(3) || indices.len() / 3 > MAX_TRIANGLES {
            let allowed = format!("three per triangle, for 1 to {MAX_TRIANGLES} triangles");
            return Err(Error::parameter("indices", format!("a list of {}", indices.len()), allowed));
        }
        if let Some(index) = indices.iter().find(|&&index| index as usize >= positions.len()) {
            return Err(Error::parameter("indices", index, format!("below the vertex count ({})", positions.len())));
        }
        let triangles: Vec<[u32; 3]> = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let objects = check_objects(objects, indices.len())?;
        let raw = RawMesh { positions, normals, triangles, objects };
        let (mesh, warnings) = clean(raw, options).map_err(|reason| Error::file("mesh", reason))?;
        Ok(Loaded { mesh, warnings })
    }

    /// Vertex positions in world space.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Unit normals in world space, one per vertex.
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// Vertex indices, three per triangle, counter-clockwise seen from the front.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// The objects, in the order of their triangles; at least one.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The vertices of an object; none where there is no such object.
    pub fn vertices_of(&self, object: usize) -> Range<usize> {
        let first = |object: &Object| self.indices[object.first_index as usize] as usize;
        let mut used = self.objects.iter().skip(object).filter(|object| object.index_count > 0);
        match self.objects.get(object) {
            Some(own) if own.index_count > 0 => {
                let next = used.nth(1).map_or(self.positions.len(), first);
                first(own)..next
            }
            _ => 0..0,
        }
    }

    /// For each vertex, the index of the object that it belongs to. The ID buffer holds this number + 1.
    pub fn object_of_vertex(&self) -> Vec<u32> {
        let mut of_vertex = vec![0; self.positions.len()];
        for (number, object) in self.objects.iter().enumerate() {
            let (first, count) = (object.first_index as usize, object.index_count as usize);
            self.indices[first..first + count].iter().for_each(|&vertex| of_vertex[vertex as usize] = number as u32);
        }
        of_vertex
    }

    /// Finds an object by its name or, if no object has that name, by its index as a decimal number from 0.
    ///
    /// # Errors
    /// [`Error::Parameter`] with the names that there are, or if several objects have the name.
    pub fn object_index(&self, name_or_index: &str) -> Result<usize> {
        let mut named = (0..self.objects.len()).filter(|&i| self.objects[i].name == name_or_index);
        match (named.next(), named.next(), name_or_index.parse::<usize>()) {
            (Some(index), None, _) => Ok(index),
            (Some(first), Some(second), _) => {
                let allowed = format!("unique; objects {first} and {second} have it, so use an index");
                Err(Error::parameter("object", name_or_index, allowed))
            }
            (None, _, Ok(index)) if index < self.objects.len() => Ok(index),
            _ => {
                let mut names: Vec<_> = self.objects.iter().take(20).map(|o| format!("`{}`", o.name)).collect();
                names.extend((self.objects.len() > 20).then(|| "...".to_string()));
                let last = self.objects.len() - 1;
                let allowed = format!("an index from 0 to {last} or one of the names {}", names.join(", "));
                Err(Error::parameter("object", name_or_index, allowed))
            }
        }
    }

    /// The lowest and the highest coordinates of all vertices.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.positions
            .iter()
            .map(|&position| Vec3::from(position))
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), position| (low.min(position), high.max(position)))
    }

    /// A sphere around all vertices: no more than sqrt(3) times as large as the smallest one, mostly much closer.
    pub fn bounding_sphere(&self) -> BoundingSphere {
        let (low, high) = self.bounds();
        let center = (low.as_dvec3() + high.as_dvec3()) / 2.0;
        let farthest = |center: DVec3| {
            self.positions.iter().map(|&p| Vec3::from(p).as_dvec3().distance(center)).fold(0.0, f64::max)
        };
        let center = center.as_vec3();
        // Rounded up a little, so that no vertex is outside.
        BoundingSphere { center, radius: (farthest(center.as_dvec3()) * (1.0 + 1e-6)) as f32 }
    }
}

/// Names and triangle counts of objects that have to cover all indices in order.
fn check_objects(objects: &[Object], index_count: usize) -> Result<Vec<(String, usize)>> {
    if objects.is_empty() {
        return Ok(vec![("unnamed_object".to_string(), index_count / 3)]);
    }
    if objects.len() > MAX_OBJECTS {
        return Err(Error::parameter("objects", objects.len(), format!("at most {MAX_OBJECTS}")));
    }
    let mut next = 0_u64;
    for object in objects {
        if u64::from(object.first_index) != next || object.index_count % 3 != 0 {
            let value = format!("`{}` of {} indices from {}", object.name, object.index_count, object.first_index);
            return Err(Error::parameter("objects", value, format!("whole triangles from index {next} on")));
        }
        next += u64::from(object.index_count);
    }
    if next != index_count as u64 {
        return Err(Error::parameter("objects", format!("{next} indices in all"), format!("all {index_count}")));
    }
    Ok(objects.iter().map(|object| (object.name.clone(), object.index_count as usize / 3)).collect())
}
