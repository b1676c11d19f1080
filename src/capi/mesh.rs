//! Meshes and paints: from files or from memory, on no device.

use super::handles::{get, give, take, ImpastoMesh, ImpastoPaint};
use super::memory::{not_null, path, read, slice, versioned, write};
use super::status::{guard, Failure, Result};
use super::types::*;
use crate::embed::EffectPaint;
use crate::paint::{PaintSample, MAX_SIDE_PX};
use crate::scene::{Loaded, Mesh, MeshOptions, Object, MAX_OBJECTS, MAX_TRIANGLES, MAX_VERTICES};
use std::ffi::c_char;
use std::sync::Arc;

/// Geometry at hand.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoMeshDesc {
    /// sizeof(ImpastoMeshDesc).
    pub struct_size: u32,
    /// Vertices.
    pub vertex_count: u32,
    /// Three numbers for each vertex.
    pub positions: *const f32,
    /// Three numbers for each vertex; those that are 0 or not finite are computed, and all if this is null.
    pub normals: *const f32,
    /// Three for each triangle, counter-clockwise seen from the front.
    pub indices: *const u32,
    /// How many indices each object has, one object after the other; null makes everything one object.
    pub object_index_counts: *const u32,
    /// Indices in all.
    pub index_count: u32,
    /// Objects that object_index_counts tells of.
    pub object_count: u32,
    /// Where normals have to be computed, faces that meet at a sharper angle keep a hard edge: 0 to 180 degrees,
    /// usually 60.
    pub crease_deg: f32,
    /// 0.
    pub reserved: u32,
}
versioned!(ImpastoMeshDesc);

/// What a mesh is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoMeshInfo {
    /// sizeof(ImpastoMeshInfo), set by the caller.
    pub struct_size: u32,
    /// Objects, each with paint and pose of its own.
    pub object_count: u32,
    /// Triangles.
    pub triangle_count: u32,
    /// The lowest coordinates of all vertices.
    pub low: [f32; 3],
    /// The highest.
    pub high: [f32; 3],
}
versioned!(ImpastoMeshInfo);

/// A strip of paint at hand, dark on the left, light on the right; rows from the top, tightly packed. One of the two
/// arrays is given.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoPaintDesc {
    /// sizeof(ImpastoPaintDesc).
    pub struct_size: u32,
    /// Width, 1 to 4096 pixels.
    pub width_px: u32,
    /// Height, 1 to 4096 pixels.
    pub height_px: u32,
    /// 0.
    pub reserved: u32,
    /// Four bytes for each pixel, the last of which is not looked at; or null.
    pub rgba8: *const u8,
    /// Three numbers from 0 to 1 for each pixel, or null.
    pub rgb: *const f32,
}
versioned!(ImpastoPaintDesc);

/// Fills in the defaults of the library; what has none is 0. The caller has set struct_size.
#[no_mangle]
pub unsafe extern "C" fn impasto_mesh_desc_init(desc: *mut ImpastoMeshDesc) -> ImpastoStatus {
    guard(|| {
        // SAFETY: zeros are numbers and null pointers.
        let zero: ImpastoMeshDesc = unsafe { std::mem::zeroed() };
        let defaults = ImpastoMeshDesc { crease_deg: MeshOptions::default().crease_deg, ..zero };
        // SAFETY: the contract of the header.
        unsafe { write(desc, &defaults) }
    })
}

/// Reads a Wavefront OBJ file.
#[no_mangle]
pub unsafe extern "C" fn impasto_mesh_load(file: *const c_char, mesh: *mut *mut ImpastoMesh) -> ImpastoStatus {
    guard(|| {
        not_null("where the mesh shall go", mesh)?;
        // SAFETY: the contract of the header.
        unsafe { give_mesh(Mesh::load(path("path of the mesh", file)?, &MeshOptions::default())?, mesh) }
        Ok(())
    })
}

/// Makes a mesh of geometry at hand, which is copied.
#[no_mangle]
pub unsafe extern "C" fn impasto_mesh_create(
    desc: *const ImpastoMeshDesc,
    mesh: *mut *mut ImpastoMesh,
) -> ImpastoStatus {
    guard(|| {
        not_null("where the mesh shall go", mesh)?;
        // SAFETY: the contract of the header.
        unsafe { give_mesh(build(desc)?, mesh) }
        Ok(())
    })
}

/// # Safety
/// The contract of the header.
unsafe fn build(desc: *const ImpastoMeshDesc) -> Result<Loaded> {
    // SAFETY: the caller promises it, here and below.
    let desc = unsafe { read(desc) }?;
    let positions = unsafe { triples("positions", desc.positions, desc.vertex_count, MAX_VERTICES) }?;
    let normals = match desc.normals.is_null() {
        true => None,
        false => Some(unsafe { triples("normals", desc.normals, desc.vertex_count, MAX_VERTICES) }?),
    };
    let indices = unsafe { slice("indices", desc.indices, desc.index_count, 3 * MAX_TRIANGLES) }?;
    let counts = match desc.object_index_counts.is_null() && desc.object_count == 0 {
        true => &[][..],
        false => unsafe { slice("objects", desc.object_index_counts, desc.object_count, MAX_OBJECTS) }?,
    };
    let options = MeshOptions { crease_deg: desc.crease_deg };
    Ok(Mesh::build(positions, normals, indices, &objects(counts)?, &options)?)
}

/// Objects one after the other, by their numbers of indices.
fn objects(index_counts: &[u32]) -> Result<Vec<Object>> {
    let mut next = 0u32;
    let object = |(number, &index_count): (usize, &u32)| {
        let first_index = next;
        next = next.checked_add(index_count).ok_or_else(|| {
            Failure::parameter("objects", "of more than 4,294,967,295 indices", "of as many as there are")
        })?;
        Ok(Object { name: format!("object {number}"), first_index, index_count })
    };
    index_counts.iter().enumerate().map(object).collect()
}

/// # Safety
/// As [`slice`], of three times as many elements.
unsafe fn triples(name: &'static str, from: *const f32, count: u32, most: usize) -> Result<Vec<[f32; 3]>> {
    // SAFETY: the caller promises it; an array of numbers is aligned as they are.
    unsafe { slice(name, from.cast::<[f32; 3]>(), count, most) }.map(<[_]>::to_vec)
}

/// # Safety
/// `to` can be written to.
unsafe fn give_mesh(loaded: Loaded, to: *mut *mut ImpastoMesh) {
    // SAFETY: the caller promises it.
    unsafe { to.write(give(Arc::new(loaded.mesh))) };
}

/// Tells what a mesh is.
#[no_mangle]
pub unsafe extern "C" fn impasto_mesh_info(mesh: *const ImpastoMesh, info: *mut ImpastoMeshInfo) -> ImpastoStatus {
    guard(|| {
        let mesh = get(mesh)?;
        let (low, high) = mesh.bounds();
        let (object_count, triangle_count) = (mesh.objects().len() as u32, mesh.indices().len() as u32 / 3);
        let known =
            ImpastoMeshInfo { struct_size: 0, object_count, triangle_count, low: low.into(), high: high.into() };
        // SAFETY: the contract of the header.
        unsafe { write(info, &known) }
    })
}

/// Destroys a mesh; null is fine. Effects that were made with it keep what they need.
#[no_mangle]
pub unsafe extern "C" fn impasto_mesh_destroy(mesh: *mut ImpastoMesh) -> ImpastoStatus {
    guard(|| take(mesh))
}

/// Reads a picture of a strip (PNG, JPEG, BMP, GIF or TIFF).
#[no_mangle]
pub unsafe extern "C" fn impasto_paint_load(file: *const c_char, paint: *mut *mut ImpastoPaint) -> ImpastoStatus {
    guard(|| {
        not_null("where the paint shall go", paint)?;
        // SAFETY: the contract of the header.
        unsafe { give_paint(&PaintSample::load(path("path of the paint", file)?)?, paint) }
    })
}

/// Makes a paint of pixels at hand, which are copied.
#[no_mangle]
pub unsafe extern "C" fn impasto_paint_create(
    desc: *const ImpastoPaintDesc,
    paint: *mut *mut ImpastoPaint,
) -> ImpastoStatus {
    guard(|| {
        not_null("where the paint shall go", paint)?;
        // SAFETY: the contract of the header.
        unsafe { give_paint(&strip(desc)?, paint) }
    })
}

/// # Safety
/// The contract of the header.
unsafe fn strip(desc: *const ImpastoPaintDesc) -> Result<PaintSample> {
    // SAFETY: the caller promises it, here and below.
    let desc = unsafe { read(desc) }?;
    let (width, height) = (desc.width_px, desc.height_px);
    if !(1..=MAX_SIDE_PX).contains(&width) || !(1..=MAX_SIDE_PX).contains(&height) {
        let allowed = format!("1 to {MAX_SIDE_PX} pixels a side");
        return Err(Failure::parameter("size of the paint", format!("{width}x{height}"), allowed));
    }
    let count = width * height;
    let pixels = match (desc.rgba8.is_null(), desc.rgb.is_null()) {
        (false, true) => {
            let bytes = unsafe { slice("rgba8", desc.rgba8.cast::<[u8; 4]>(), count, count as usize) }?;
            bytes.iter().map(|pixel| [0, 1, 2].map(|k| f32::from(pixel[k]) / 255.0)).collect()
        }
        (true, false) => unsafe { triples("rgb", desc.rgb, count, count as usize) }?,
        (true, true) => return Err(Failure::new(ImpastoStatus::NullPointer, "rgba8 and rgb are null: one is needed")),
        (false, false) => return Err(Failure::parameter("pixels", "given twice", "given as rgba8 or as rgb")),
    };
    Ok(PaintSample::from_pixels(width, height, pixels)?)
}

/// # Safety
/// `to` can be written to.
unsafe fn give_paint(strip: &PaintSample, to: *mut *mut ImpastoPaint) -> Result<()> {
    let paint = EffectPaint::extract(strip)?;
    // SAFETY: the caller promises it.
    unsafe { to.write(give(Arc::new(paint))) };
    Ok(())
}

/// Destroys a paint; null is fine. Effects that were made with it keep what they need.
#[no_mangle]
pub unsafe extern "C" fn impasto_paint_destroy(paint: *mut ImpastoPaint) -> ImpastoStatus {
    guard(|| take(paint))
}
