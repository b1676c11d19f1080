//! Lets the texture of view-aligned projection follow what moves (thesis chapter 7).

use crate::scene::{Mesh, Moment, Vec3};
use crate::Result;
use glam::{DMat4, DVec2, DVec3, Vec2};

/// Vertices face the camera directly up to an angle of 30 degrees; the square of its cosine.
const FACING_SQUARED: f32 = 0.75;

/// By how many pixels, to the right and down, each object moves in a picture of `size` = (width, height) from one
/// moment to the next: the mean way of those of its vertices that most directly face the first camera (within 30
/// degrees, or else the one that does most), as far as both cameras have them before them. An object of which they have
/// nothing before them does not move.
///
/// The texture offsets of [`super::AlignedTechnique::record`], less the sum of these over all frames, make the texture
/// go along with each object, instead of standing still while the objects slide through it.
///
/// # Errors
/// [`crate::Error::Parameter`] when a camera has no projection for the picture's shape.
pub fn screen_displacements(mesh: &Mesh, moments: [&Moment; 2], size: (u32, u32)) -> Result<Vec<[f32; 2]>> {
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let aspect = (width / height) as f32;
    // From clip space to pixels.
    let pixels = DMat4::from_scale(DVec3::new(0.5 * width, 0.5 * height, 1.0));
    let [first, second] = moments.map(|moment| moment.camera.view_projection(aspect));
    let [first, second] = [pixels * first?.as_dmat4(), pixels * second?.as_dmat4()];
    let ways = (0..mesh.objects().len()).map(|object| {
        let [from, to] = moments.map(|moment| moment.pose(object));
        // Seen from the object, the camera moves instead: its vertices and normals can be taken as they are.
        let eye = from.point_to_object(moments[0].camera.eye());
        let screens = [Screen::new(first * from.matrix(), eye), Screen::new(second * to.matrix(), eye)];
        let vertices = mesh.vertices_of(object);
        let normals = mesh.normals()[vertices.clone()].iter();
        mean_way(mesh.positions()[vertices].iter().zip(normals), eye, &screens).to_array()
    });
    Ok(ways.collect())
}

/// Where a picture has the points of an object.
///
/// Points are given by the way from the first camera's eye, so that single precision is enough wherever the model is.
struct Screen {
    /// The projection's rows for x, y and w.
    rows: [Vec3; 3],
    /// What they have at the eye.
    at_eye: Vec3,
}

impl Screen {
    fn new(projection: DMat4, eye: Vec3) -> Self {
        let at_eye = (projection * eye.as_dvec3().extend(1.0)).as_vec4();
        let rows = [0, 1, 3].map(|row| projection.row(row).truncate().as_vec3());
        Screen { rows, at_eye: Vec3::new(at_eye.x, at_eye.y, at_eye.w) }
    }

    /// Pixels to the right and down from the picture's middle; `None` for what is not before the camera.
    fn at(&self, from_eye: Vec3) -> Option<Vec2> {
        let point = Vec3::from(self.rows.map(|row| row.dot(from_eye))) + self.at_eye;
        (point.z > 0.0).then(|| point.truncate() / point.z)
    }
}

/// The way of an object, of positions and unit normals.
fn mean_way<'a>(
    vertices: impl Iterator<Item = (&'a [f32; 3], &'a [f32; 3])> + Clone,
    eye: Vec3,
    [first, second]: &[Screen; 2],
) -> Vec2 {
    let way = |to_eye: Vec3| {
        let way = second.at(-to_eye)? - first.at(-to_eye)?;
        way.is_finite().then_some(way)
    };
    let vertices = vertices.map(|(position, normal)| (eye - Vec3::from(*position), Vec3::from(*normal)));
    let (mut sum, mut count) = (DVec2::ZERO, 0.0);
    for (to_eye, normal) in vertices.clone() {
        let along = normal.dot(to_eye);
        if along > 0.0 && along * along >= FACING_SQUARED * to_eye.length_squared() {
            if let Some(way) = way(to_eye) {
                (sum, count) = (sum + way.as_dvec2(), count + 1.0);
            }
        }
    }
    if count > 0.0 {
        return (sum / count).as_vec2();
    }
    let mut most = (f32::NEG_INFINITY, Vec2::ZERO);
    for (to_eye, normal) in vertices {
        let facing = normal.dot(to_eye.normalize_or_zero());
        if facing > most.0 {
            if let Some(way) = way(to_eye) {
                most = (facing, way);
            }
        }
    }
    most.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lights, MeshOptions, Pose};

    fn seen_from(right: f32) -> Moment {
        let camera = Camera::look_at(Vec3::new(right, 0.0, 5.0), Vec3::new(right, 0.0, 0.0), None, 90.0);
        Moment::at_rest(camera.expect("a camera"), Lights::default())
    }

    fn mesh(text: &str) -> Mesh {
        Mesh::parse(text.as_bytes(), "walls", &MeshOptions::default()).expect("a mesh").mesh
    }

    fn assert_near(way: [f32; 2], want: [f32; 2]) {
        assert!((way[0] - want[0]).abs() < 1e-3 && (way[1] - want[1]).abs() < 1e-3, "{way:?}, not {want:?}");
    }

    /// A wall at a distance of 5, where a picture of 100 pixels is 10 high, with one behind it that faces sideways.
    const WALL: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\nv 3 -1 -9\nv 3 1 -9\nv 3 1 -1\nf 5 6 7\n";
    /// A wall at a distance of 20.
    const FAR_WALL: &str = "o far\nv -9 -9 -15\nv 9 -9 -15\nv 9 9 -15\nf 8 9 10\n";

    #[test]
    fn a_wall_moves_as_far_as_its_distance_says_and_what_turns_away_does_not_count() {
        let mesh = mesh(WALL);
        let ways = screen_displacements(&mesh, [&seen_from(0.0), &seen_from(0.5)], (200, 100)).expect("ways");
        assert_near(ways[0], [-5.0, 0.0]);
        let none = screen_displacements(&mesh, [&seen_from(0.0), &seen_from(0.0)], (200, 100)).expect("ways");
        assert_eq!(none, [[0.0; 2]]);
        // Seen from the side nothing faces the camera directly: the vertex that does most is as good as can be had.
        let side = |up: f32| {
            let eye = Vec3::new(8.0, up, 1.0);
            let camera = Camera::look_at(eye, eye - Vec3::X, None, 90.0).expect("a camera");
            Moment::at_rest(camera, Lights::default())
        };
        let ways = screen_displacements(&mesh, [&side(0.0), &side(0.1)], (100, 100)).expect("ways");
        assert!(ways[0][1] > 0.0, "{ways:?}");
    }

    #[test]
    fn each_object_has_its_own_way() {
        let mesh = mesh(&format!("o near\n{WALL}{FAR_WALL}"));
        let moved = |poses: &[Pose], right| Moment { poses: poses.to_vec(), ..seen_from(right) };
        let ways = |from: &Moment, to: &Moment| screen_displacements(&mesh, [from, to], (200, 100)).expect("ways");
        let camera = ways(&seen_from(0.0), &seen_from(0.5));
        assert_near(camera[0], [-5.0, 0.0]);
        assert_near(camera[1], [-1.25, 0.0]);
        // Poses move objects; those without one are at rest.
        let way = |x: f32, y: f32, z: f32| Pose::new(0.0, Vec3::Y, Vec3::ZERO, Vec3::new(x, y, z)).expect("a pose");
        let poses = ways(&moved(&[way(0.0, 1.0, -5.0)], 0.0), &moved(&[way(0.0, 2.0, -5.0)], 0.0));
        assert_near(poses[0], [0.0, -5.0]);
        assert_eq!(poses[1], [0.0; 2]);
        // What one of the cameras has behind it does not move.
        let gone = ways(&seen_from(0.0), &moved(&[way(0.0, 0.0, 30.0), way(2.0, 0.0, 0.0)], 0.0));
        assert_eq!(gone[0], [0.0; 2]);
        assert_near(gone[1], [5.0, 0.0]);
    }

    #[test]
    fn normals_turn_with_their_object() {
        // The wall that faces sideways faces the camera once its object is turned by -90 degrees: (3, y, z) comes to
        // (-z, y, 3) then, a distance of 2, and the other wall faces sideways.
        let mesh = mesh(WALL);
        let turned = |right: f32| {
            let pose = Pose::new(-90.0, Vec3::Y, Vec3::ZERO, Vec3::new(-4.0 + right, 0.0, 0.0)).expect("a pose");
            Moment { poses: vec![pose], ..seen_from(0.0) }
        };
        let ways = screen_displacements(&mesh, [&turned(0.0), &turned(0.1)], (100, 100)).expect("ways");
        assert_near(ways[0], [2.5, 0.0]);
    }
}
