//! What changes from frame to frame: where the camera is, how the scene is lit, and where its objects are.

use super::camera::{is_orthonormal, Camera};
use super::light::Lights;
use super::mesh::Mesh;
use crate::error::{Error, Result};
use glam::{DMat3, DMat4, DQuat, DVec3, Mat4, Vec3, Vec4};

/// Where an object is: turned and moved from its place in the mesh, and as large as it is there.
///
/// A point p of the mesh is at rotation * p + translation in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    rotation: DQuat,
    translation: DVec3,
}

impl Default for Pose {
    fn default() -> Self {
        Self::REST
    }
}

impl Pose {
    /// Where the mesh has it.
    pub const REST: Pose = Pose { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// Turned by `degrees`, counter-clockwise about an axis through `center`, then moved by `way`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an angle or a vector that is not finite or beyond 1e15, or an axis that is zero.
    pub fn new(degrees: f32, axis: Vec3, center: Vec3, way: Vec3) -> Result<Self> {
        if !degrees.is_finite() {
            return Err(Error::parameter("turn", degrees, "finite"));
        }
        for (name, vector) in [("axis", axis), ("center", center), ("way", way)] {
            if !vector.is_finite() || vector.abs().max_element() > 1e15 {
                return Err(Error::parameter(name, vector, "finite and within 1e15"));
            }
        }
        let axis = axis.as_dvec3().try_normalize().ok_or_else(|| Error::parameter("axis", axis, "not zero"))?;
        let rotation = DQuat::from_axis_angle(axis, f64::from(degrees).to_radians());
        let center = center.as_dvec3();
        Ok(Self { rotation, translation: center - rotation * center + way.as_dvec3() })
    }

    /// As a matrix tells it, from the mesh to world space.
    ///
    /// # Errors
    /// [`Error::Parameter`] for one that is not finite or beyond 1e15, or does anything but turn and move.
    pub fn from_matrix(matrix: &Mat4) -> Result<Self> {
        let turn = DMat3::from_mat4(matrix.as_dmat4());
        let is_turn = is_orthonormal(turn) && turn.determinant() > 0.0;
        let translation = matrix.w_axis.truncate();
        let is_near = translation.is_finite() && translation.abs().max_element() <= 1e15;
        if !is_turn || !is_near || matrix.row(3) != Vec4::W {
            return Err(Error::parameter("pose", matrix, "a turn and a move by 1e15 at the most"));
        }
        Ok(Self { rotation: DQuat::from_mat3(&turn).normalize(), translation: translation.as_dvec3() })
    }

    /// From the mesh to world space.
    pub fn matrix(&self) -> DMat4 {
        DMat4::from_rotation_translation(self.rotation, self.translation)
    }

    /// A world-space direction, as the object has it.
    pub fn to_object(&self, direction: Vec3) -> Vec3 {
        (self.rotation.inverse() * direction.as_dvec3()).as_vec3()
    }

    /// A world-space point, as the object has it.
    pub fn point_to_object(&self, point: Vec3) -> Vec3 {
        (self.rotation.inverse() * (point.as_dvec3() - self.translation)).as_vec3()
    }
}

/// The scene at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Where it is seen from.
    pub camera: Camera,
    /// How it is lit.
    pub lights: Lights,
    /// Where the mesh's objects are, in their order; objects beyond the last pose are at rest.
    pub poses: Vec<Pose>,
}

impl Moment {
    /// All objects at rest.
    pub fn at_rest(camera: Camera, lights: Lights) -> Self {
        Self { camera, lights, poses: Vec::new() }
    }

    /// The same moment with the camera's near and far planes close around what of the mesh lies in front of it.
    pub fn fit_depth(mut self, mesh: &Mesh) -> Self {
        let poses = &self.poses;
        let points = mesh.objects().iter().enumerate().flat_map(|(number, object)| {
            let to_world = poses.get(number).copied().unwrap_or_default().matrix();
            let indices = object.first_index as usize..(object.first_index + object.index_count) as usize;
            let point = move |&vertex: &u32| Vec3::from(mesh.positions()[vertex as usize]).as_dvec3();
            mesh.indices()[indices].iter().map(point).map(move |point| to_world.transform_point3(point))
        });
        self.camera = self.camera.fit_points(points);
        self
    }

    /// Where an object is.
    pub fn pose(&self, object: usize) -> Pose {
        self.poses.get(object).copied().unwrap_or_default()
    }
}

/// Spheres around the objects of a mesh: enough to tell, for each frame, between which distances they lie.
pub(crate) struct Spheres(Vec<Sphere>);

struct Sphere {
    object: usize,
    center: DVec3,
    radius: f64,
}

impl Spheres {
    /// Looks at every vertex.
    pub fn new(mesh: &Mesh) -> Self {
        let drawn = mesh.objects().iter().enumerate().filter(|(_, object)| object.index_count > 0);
        let sphere = |(object, _)| {
            let points = || mesh.positions()[mesh.vertices_of(object)].iter().map(|&p| Vec3::from(p).as_dvec3());
            let low = points().fold(DVec3::INFINITY, DVec3::min);
            let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
            let center = (low + high) / 2.0;
            Sphere { object, center, radius: points().map(|p| p.distance(center)).fold(0.0, f64::max) }
        };
        Spheres(drawn.map(sphere).collect())
    }

    /// The moment's camera with its planes close around the objects, as far as they were farther apart: what a camera of
    /// a host with a far plane at infinity needs, or two surfaces far away have one depth.
    pub fn close_in(&self, moment: &Moment) -> Camera {
        let (eye, forward) = (moment.camera.eye().as_dvec3(), moment.camera.forward().as_dvec3());
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        for Sphere { object, center, radius } in &self.0 {
            let Pose { rotation, translation } = moment.pose(*object);
            let along = (rotation * *center + translation - eye).dot(forward);
            (nearest, farthest) = (nearest.min(along - radius), farthest.max(along + radius));
        }
        moment.camera.closed_in(nearest, farthest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MeshOptions;

    #[test]
    fn a_pose_turns_about_its_center_then_moves() {
        // A quarter turn about the vertical through (1, 0, 0) takes (2, 5, 0) to (1, 5, -1); then 10 to the right.
        let pose = Pose::new(90.0, Vec3::Y, Vec3::X, 10.0 * Vec3::X).expect("a pose");
        let to = pose.matrix().transform_point3(DVec3::new(2.0, 5.0, 0.0));
        assert!((to - DVec3::new(11.0, 5.0, -1.0)).length() < 1e-9, "{to}");
        assert!((pose.point_to_object(to.as_vec3()) - Vec3::new(2.0, 5.0, 0.0)).length() < 1e-5);
        assert!((pose.to_object(Vec3::NEG_Z) - Vec3::X).length() < 1e-6);
        assert_eq!(Pose::default().matrix(), DMat4::IDENTITY);
    }

    #[test]
    fn depth_is_fitted_to_where_the_objects_are() {
        let text = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 4 5 6\n";
        let mesh = Mesh::parse(text.as_bytes(), "two.obj", &MeshOptions::default()).expect("a mesh").mesh;
        let camera = Camera::look_at(10.0 * Vec3::Z, Vec3::ZERO, None, 30.0).expect("a camera");
        let mut moment = Moment::at_rest(camera, Lights::default());
        assert_eq!(moment.clone().fit_depth(&mesh).camera, camera.fit_depth(&mesh));
        let pose = |z| Pose::new(0.0, Vec3::Y, Vec3::ZERO, z * Vec3::Z).expect("a pose");
        // One moves towards the camera, the other away; then the other stays.
        for (poses, near, far) in [(vec![pose(4.0), pose(-20.0)], 6.0, 30.0), (vec![pose(4.0)], 6.0, 10.0)] {
            moment.poses = poses;
            let camera = moment.clone().fit_depth(&mesh).camera;
            assert!((0.9 * near..near).contains(&camera.near()), "{}", camera.near());
            assert!((far + 1e-6..1.1 * far).contains(&camera.far()), "{}", camera.far());
        }
    }

    #[test]
    fn a_pose_may_come_from_a_matrix() {
        let pose = Pose::new(40.0, Vec3::new(1.0, 2.0, -1.0), Vec3::X, Vec3::new(3.0, -2.0, 1.0)).expect("a pose");
        let again = Pose::from_matrix(&pose.matrix().as_mat4()).expect("a pose");
        assert!(again.matrix().abs_diff_eq(pose.matrix(), 1e-6), "{again:?} is not {pose:?}");
        assert_eq!(Pose::from_matrix(&Mat4::IDENTITY).expect("a pose"), Pose::REST);
        let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let twice = Mat4::from_scale(Vec3::splat(2.0));
        let slanted = Mat4 { w_axis: Vec4::ONE, x_axis: Vec4::ONE, ..Mat4::IDENTITY };
        let far = [f32::NAN, f32::INFINITY, 1e20].map(|far| Mat4::from_translation(Vec3::Y * far));
        let projecting = Mat4 { w_axis: Vec4::splat(2.0), ..Mat4::IDENTITY };
        for bad in [mirror, twice, slanted, projecting].into_iter().chain(far) {
            assert!(Pose::from_matrix(&bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn planes_close_in_on_the_objects_and_never_open() {
        let text = "o a\nv -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nv -1 0 0\nv 1 0 0\nv 0 1 0\nf 4 5 6\n";
        let mesh = Mesh::parse(text.as_bytes(), "two.obj", &MeshOptions::default()).expect("a mesh").mesh;
        let spheres = Spheres::new(&mesh);
        let camera = Camera::look_at(10.0 * Vec3::Z, Vec3::ZERO, None, 30.0).expect("a camera");
        let pose = |z| Pose::new(0.0, Vec3::Y, Vec3::ZERO, z * Vec3::Z).expect("a pose");
        let planes = |near, far, poses: Vec<Pose>| {
            let camera = camera.with_planes(near, far).expect("planes");
            let closed = spheres.close_in(&Moment { poses, ..Moment::at_rest(camera, Lights::default()) });
            let fitted = camera.fit_depth(&mesh);
            assert_eq!((closed.eye(), closed.forward()), (fitted.eye(), fitted.forward()));
            [closed.near(), closed.far()]
        };
        // Half as high as wide: a radius of sqrt(1.25) about the middle.
        let radius = 1.25_f32.sqrt();
        let [near, far] = planes(1e-3, 1e3, vec![pose(4.0), pose(-20.0)]);
        assert!((6.0 - radius - 0.5..6.0).contains(&near), "{near}");
        assert!((30.0..30.0 + radius + 0.5).contains(&far), "{far}");
        assert_eq!(planes(7.0, 8.0, vec![pose(4.0), pose(-20.0)]), [7.0, 8.0], "as the host has it");
        // Objects around the eye, and none between the planes.
        assert_eq!(planes(1e-3, 1e3, vec![pose(10.0)])[0], 1e-3);
        assert_eq!(planes(100.0, 200.0, Vec::new()), [100.0, 200.0]);
        assert_eq!(planes(1.0, 2.0, vec![pose(40.0), pose(40.0)]), [1.0, 2.0]);
    }

    #[test]
    fn what_is_no_pose_is_refused() {
        let bad = f32::NAN;
        assert!(Pose::new(bad, Vec3::Y, Vec3::ZERO, Vec3::ZERO).is_err());
        assert!(Pose::new(1.0, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO).is_err());
        assert!(Pose::new(1.0, Vec3::Y, Vec3::splat(bad), Vec3::ZERO).is_err());
        assert!(Pose::new(1.0, Vec3::Y, Vec3::ZERO, Vec3::splat(1e20)).is_err());
    }
}
