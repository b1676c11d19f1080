//! A mesh's vertices and indices on their way to the device, in the order in which it draws them fastest.
//!
//! A device keeps the vertices that it transformed last. Where a triangle's neighbours come soon after it, each vertex
//! is transformed about once, instead of up to six times in the order that some files have, and neighbouring pixels are
//! drawn together: on lavapipe a picture of a scanned head of 100,000 triangles takes a little more than half the time.
//! The order is Sander, Nehab and Barczak's (*Fast Triangle Reordering for Vertex Locality and Reduced Overdraw*,
//! 2007), as `meshopt_rs` has it.

use super::Object;
use crate::gpu::{Buffer, BufferKind, Context, Uploads};
use crate::Result;
use meshopt_rs::vertex::cache::optimize_vertex_cache_fifo;

/// Vertices that the order takes a device to keep: few enough for any.
const KEPT: u32 = 16;

/// Vertices and indices on their way to the device, the triangles of each object in the order that draws them fastest.
///
/// Objects stay in their order and a triangle's corners in theirs. `vertices` may be other ones than the mesh's.
pub(crate) fn upload_ordered<V: bytemuck::NoUninit>(
    context: &Context,
    uploads: &mut Uploads,
    vertices: &[V],
    indices: &[u32],
    objects: &[Object],
) -> Result<(Buffer, Buffer)> {
    let (vertices, indices) = draw_order(vertices, indices, objects);
    upload_geometry(context, uploads, &vertices, &indices)
}

/// Vertices and indices on their way to the device, as they are.
pub(crate) fn upload_geometry<V: bytemuck::NoUninit>(
    context: &Context,
    uploads: &mut Uploads,
    vertices: &[V],
    indices: &[u32],
) -> Result<(Buffer, Buffer)> {
    let mut buffer = |name, data: &[u8]| {
        let buffer = Buffer::new(context, name, BufferKind::Geometry, data.len() as u64)?;
        uploads.buffer(context, &buffer, data)?;
        Ok::<_, crate::Error>(buffer)
    };
    Ok((
        buffer("mesh vertices", bytemuck::cast_slice(vertices))?,
        buffer("mesh indices", bytemuck::cast_slice(indices))?,
    ))
}

/// Orders the triangles of each object, then the vertices by first use; vertices that none uses are left out.
fn draw_order<V: Copy>(vertices: &[V], indices: &[u32], objects: &[Object]) -> (Vec<V>, Vec<u32>) {
    let mut ordered = vec![0; indices.len()];
    for object in objects {
        let range = object.first_index as usize..(object.first_index + object.index_count) as usize;
        let of_object = &indices[range.clone()];
        // Numbered from its own first vertex, so that many objects cost no more than one.
        let first = of_object.iter().copied().min().unwrap_or_default();
        let local: Vec<u32> = of_object.iter().map(|index| index - first).collect();
        let count = local.iter().max().map_or(0, |last| *last as usize + 1);
        optimize_vertex_cache_fifo(&mut ordered[range.clone()], &local, count, KEPT);
        ordered[range].iter_mut().for_each(|index| *index += first);
    }
    let mut place = vec![u32::MAX; vertices.len()];
    let mut used = Vec::with_capacity(vertices.len());
    for index in &mut ordered {
        let vertex = *index as usize;
        if place[vertex] == u32::MAX {
            place[vertex] = used.len() as u32;
            used.push(vertices[vertex]);
        }
        *index = place[vertex];
    }
    (used, ordered)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Mesh, MeshOptions};

    /// Vertices that a device transforms which keeps the last `KEPT` of them.
    fn transformed(indices: &[u32]) -> usize {
        let mut kept = std::collections::VecDeque::new();
        let mut count = 0;
        for index in indices {
            if !kept.contains(index) {
                count += 1;
                kept.push_back(*index);
                if kept.len() > KEPT as usize {
                    kept.pop_front();
                }
            }
        }
        count
    }

    #[test]
    fn triangles_are_the_same_object_by_object_and_cost_less() {
        let text = include_str!("../../assets/teapot_on_table.obj");
        let mesh = Mesh::parse(text.as_bytes(), "teapot", &MeshOptions::default()).expect("a mesh").mesh;
        // The triangles of each object in an order that has nothing to do with neighbourhood.
        let mut shuffled = Vec::new();
        for object in mesh.objects() {
            let range = object.first_index as usize..(object.first_index + object.index_count) as usize;
            let triangles: Vec<&[u32]> = mesh.indices()[range].chunks(3).collect();
            (0..triangles.len()).for_each(|i| shuffled.extend(triangles[i * 7919 % triangles.len()]));
        }
        // A vertex that no triangle has, besides.
        let vertices: Vec<[f32; 3]> = mesh.positions().iter().copied().chain([[9.0; 3]]).collect();
        let (used, ordered) = draw_order(&vertices, &shuffled, mesh.objects());
        assert_eq!(used.len(), mesh.positions().len());
        let corners = |vertices: &[[f32; 3]], indices: &[u32]| -> Vec<[[u32; 3]; 3]> {
            let of = |i: &u32| vertices[*i as usize].map(f32::to_bits);
            let mut all: Vec<_> = indices.chunks(3).map(|t| [of(&t[0]), of(&t[1]), of(&t[2])]).collect();
            all.sort_unstable();
            all
        };
        for object in mesh.objects() {
            let range = object.first_index as usize..(object.first_index + object.index_count) as usize;
            assert_eq!(
                corners(&used, &ordered[range.clone()]),
                corners(&vertices, &shuffled[range]),
                "{}",
                object.name
            );
        }
        let (before, after) = (transformed(&shuffled), transformed(&ordered));
        assert!(2 * after < before && after < 2 * used.len(), "{before} before, {after} after, of {}", used.len());
    }

    #[test]
    fn nothing_stays_nothing() {
        let none = Object { name: String::new(), first_index: 0, index_count: 0 };
        assert_eq!(draw_order::<u8>(&[], &[], &[none]), (vec![], vec![]));
        assert_eq!(draw_order::<u8>(&[1, 2], &[], &[]), (vec![], vec![]));
    }
}
