//! Lets the texture of view-aligned projection follow what moves (thesis chapter 7).

use crate::scene::{Camera, Mesh, Vec3};
use crate::Result;

/// Vertices face the camera directly up to this angle; its cosine.
const FACING: f32 = 0.866;

/// By how many pixels, to the right and down, a model moves in a picture of `size` = (width, height) from one camera to
/// the next: the mean way of the vertices that most directly face the first camera (within 30 degrees, or else the one
/// that does most), as far as both cameras have them before them.
///
/// [`super::AlignedFrame::offset_px`], less the sum of these, makes the texture go along with what fills most of the picture,
/// instead of standing still while the model slides through it.
///
/// # Errors
/// [`crate::Error::Parameter`] when a camera has no projection for the picture's shape.
pub fn screen_displacement(mesh: &Mesh, cameras: [&Camera; 2], size: (u32, u32)) -> Result<[f32; 2]> {
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let aspect = (width / height) as f32;
    let [first, second] =
        [cameras[0].view_projection(aspect)?.as_dmat4(), cameras[1].view_projection(aspect)?.as_dmat4()];
    let eye = cameras[0].eye();
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    let mut most = (f32::NEG_INFINITY, None);
    for (position, normal) in mesh.positions().iter().zip(mesh.normals()) {
        let position = Vec3::from(*position);
        let facing = Vec3::from(*normal).dot((eye - position).normalize_or_zero());
        if facing < FACING && facing <= most.0 {
            continue;
        }
        let point = position.as_dvec3().extend(1.0);
        let (from, to) = (first * point, second * point);
        if from.w <= 0.0 || to.w <= 0.0 {
            continue;
        }
        let way = [(to.x / to.w - from.x / from.w) * 0.5 * width, (to.y / to.w - from.y / from.w) * 0.5 * height];
        if facing > most.0 {
            most = (facing, Some(way));
        }
        if facing >= FACING {
            (sum, count) = ([sum[0] + way[0], sum[1] + way[1]], count + 1.0);
        }
    }
    let mean = if count > 0.0 { sum.map(|sum| sum / count) } else { most.1.unwrap_or_default() };
    Ok(mean.map(|way| way as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MeshOptions;

    fn camera(right: f32) -> Camera {
        Camera::look_at(Vec3::new(right, 0.0, 5.0), Vec3::new(right, 0.0, 0.0), None, 90.0).expect("a camera")
    }

    #[test]
    fn a_wall_moves_as_far_as_its_distance_says_and_what_turns_away_does_not_count() {
        // A wall at a distance of 5, where a picture of 100 pixels is 10 high; behind it one that faces sideways.
        let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\nv 3 -1 -9\nv 3 1 -9\nv 3 1 -1\nf 5 6 7\n";
        let mesh = Mesh::parse(text.as_bytes(), "walls", &MeshOptions::default()).expect("a mesh").mesh;
        let way = screen_displacement(&mesh, [&camera(0.0), &camera(0.5)], (200, 100)).expect("a way");
        assert!((way[0] + 5.0).abs() < 1e-3 && way[1].abs() < 1e-3, "{way:?}");
        let none = screen_displacement(&mesh, [&camera(0.0), &camera(0.0)], (200, 100)).expect("a way");
        assert_eq!(none, [0.0; 2]);
        // Seen from the side nothing faces the camera directly: the vertex that does most is as good as can be had.
        let side = |up: f32| {
            let eye = Vec3::new(8.0, up, 1.0);
            Camera::look_at(eye, eye - Vec3::X, None, 90.0).expect("a camera")
        };
        let way = screen_displacement(&mesh, [&side(0.0), &side(0.1)], (100, 100)).expect("a way");
        assert!(way[1] > 0.0, "{way:?}");
    }
}
