//! The camera: where the scene is seen from, and how it is projected onto the picture (thesis section 3.1.4).
//!
//! View space is right-handed: x to the right, y up, the camera looks along -z. Clip space is Vulkan's: y points down,
//! depth runs from 0 (near) to 1 (far). With this projection a triangle that is counter-clockwise for the viewer is
//! counter-clockwise for Vulkan too (`VK_FRONT_FACE_COUNTER_CLOCKWISE`).

use glam::camera::rh::{proj::vulkan::perspective, view::look_to_mat4};
use glam::{DMat3, DVec3, Mat4, Vec3, Vec4};

use super::mesh::Mesh;
use crate::error::{Error, Result};

/// The vertical field of view where none is asked for, in degrees: about that of a portrait lens.
pub const DEFAULT_FOV_Y_DEG: f32 = 30.0;
/// The vertical fields of view that a camera may have.
const FOV_Y_DEG: std::ops::RangeInclusive<f32> = 1.0..=150.0;
/// The pictures' aspect ratios that a camera may have.
const ASPECT: std::ops::RangeInclusive<f32> = 0.01..=100.0;
/// The near plane is no closer than this part of the far plane's distance: what is left of the depth's precision.
const MIN_NEAR: f64 = 1e-4;

/// A perspective camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: Vec3,
    target: Vec3,
    /// Unit vectors, at a right angle to each other.
    forward: Vec3,
    up: Vec3,
    fov_y_deg: f32,
    near: f32,
    far: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`. `up` is the direction that shall be up in the picture, by default +y
    /// (or -z for a camera that looks along the y axis). `fov_y_deg` is the vertical field of view.
    ///
    /// Near and far planes are set to 1/100 and 100 times the distance to the target; [`Camera::fit_depth`] sets them
    /// close around a model.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a vector is not finite, eye and target are closer than 1e-12, `up` is zero or along the
    /// view, or the field of view is not in 1..=150 degrees.
    pub fn look_at(eye: Vec3, target: Vec3, up: Option<Vec3>, fov_y_deg: f32) -> Result<Self> {
        check_fov(fov_y_deg)?;
        for (name, vector) in [("eye", eye), ("target", target), ("up", up.unwrap_or_default())] {
            if !vector.is_finite() || vector.abs().max_element() > 1e15 {
                return Err(Error::parameter(name, vector, "finite and within 1e15"));
            }
        }
        let distance = target.as_dvec3().distance(eye.as_dvec3());
        if distance < 1e-12 {
            return Err(Error::parameter("target", target, format!("apart from the eye ({eye})")));
        }
        let forward = (target.as_dvec3() - eye.as_dvec3()) / distance;
        let across = |up: DVec3| (up - up.dot(forward) * forward).try_normalize();
        let up = match up.map(|up| up.as_dvec3().normalize_or_zero()) {
            Some(up) if forward.cross(up).length() < 1e-4 => {
                return Err(Error::parameter("up", up, "neither zero nor along the view direction"));
            }
            Some(up) => across(up),
            None if forward.cross(DVec3::Y).length() < 1e-4 => across(DVec3::NEG_Z),
            None => across(DVec3::Y),
        };
        let up = up.ok_or_else(|| Error::parameter("up", "undefined", "apart from the view direction"))?;
        Ok(Self {
            eye,
            target,
            forward: forward.as_vec3(),
            up: up.as_vec3(),
            fov_y_deg,
            near: (distance * 0.01) as f32,
            far: (distance * 100.0) as f32,
        })
    }

    /// The camera of a host that has matrices: world space to view space, and view space to clip space, where depth is
    /// from 0 to 1. The view may look along -z or +z; y may point up or down in clip space; depth may be reversed; a far
    /// plane at infinity is put at a million times the near one, and [`Camera::fit_depth`] brings both close to a model.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a view that does not only turn and move, that is a mirror of the world, and for a
    /// projection that is no perspective, or an off-centre one: paint does not want the jitter of temporal antialiasing.
    pub fn from_matrices(view: &Mat4, projection: &Mat4) -> Result<Self> {
        if !view.is_finite() || !projection.is_finite() {
            return Err(Error::parameter("matrices", "not finite", "finite"));
        }
        let [a, b] = perspective_depth(projection)?.map(f64::from);
        let z = projection.z_axis;
        if z.x.abs().max(z.y.abs()) > 1e-6 {
            return Err(Error::parameter("projection", projection, "centred, without jitter"));
        }
        let [right, up, ahead] = [0, 1, 2].map(|row| view.row(row).truncate());
        let forward = ahead * z.w;
        if !is_orthonormal(DMat3::from_cols(right.as_dvec3(), up.as_dvec3(), forward.as_dvec3()))
            || view.row(3) != Vec4::W
        {
            return Err(Error::parameter("view", view, "a turn and a move"));
        }
        if forward.cross(up).dot(right) * projection.x_axis.x < 0.0 {
            return Err(Error::parameter("view", view, "no mirror: right, up and back must be right-handed"));
        }
        let fov_y_deg = 2.0 * (1.0 / projection.y_axis.y.abs()).atan().to_degrees();
        check_fov(fov_y_deg)?;
        let moved = view.w_axis.truncate().as_dvec3();
        let eye = -(moved.x * right.as_dvec3() + moved.y * up.as_dvec3() + moved.z * ahead.as_dvec3()).as_vec3();
        // The planes are where depth is 0 and 1.
        let planes = [-b / a, b / (1.0 - a)].map(f64::abs);
        let near = planes[0].min(planes[1]);
        let far = planes[0].max(planes[1]).min(near * 1e6);
        let (forward, up) = (forward.normalize(), up.normalize());
        Self { eye, target: eye + forward, forward, up, fov_y_deg, near: 0.0, far: 0.0 }
            .with_planes(near as f32, far as f32)
    }

    /// The same camera with near and far planes close around what of the mesh, at rest, lies in front of it;
    /// [`Moment::fit_depth`](super::Moment::fit_depth) heeds its objects' poses.
    pub fn fit_depth(self, mesh: &Mesh) -> Self {
        self.fit_points(mesh.positions().iter().map(|&p| Vec3::from(p).as_dvec3()))
    }

    /// As [`Camera::fit_depth`], for points in world space.
    pub(super) fn fit_points(mut self, points: impl Iterator<Item = DVec3>) -> Self {
        let eye = self.eye.as_dvec3();
        let forward = self.forward.as_dvec3();
        let depths = points.map(|p| (p - eye).dot(forward));
        let (nearest, farthest) =
            depths.fold((f64::INFINITY, 0.0_f64), |(low, high), depth| (low.min(depth), high.max(depth)));
        if farthest > 0.0 {
            let room = Self::room(nearest, farthest);
            self.far = (farthest + room) as f32;
            self.near = (nearest - room).max(MIN_NEAR * farthest) as f32;
        }
        self
    }

    /// The same camera with its planes brought close to what lies at these distances along the view axis, but no farther
    /// apart than they are: nothing is seen that was not, and nothing is lost.
    pub(super) fn closed_in(self, nearest: f64, farthest: f64) -> Self {
        let room = Self::room(nearest, farthest);
        let near = (nearest - room).max(f64::from(self.near));
        let far = (farthest + room).min(f64::from(self.far));
        self.with_planes(near as f32, far as f32).unwrap_or(self)
    }

    /// A little more room than needed: rounding must not clip anything.
    fn room(nearest: f64, farthest: f64) -> f64 {
        0.01 * (farthest - nearest) + 1e-5 * farthest
    }

    /// The same camera with these near and far planes, for a host that knows the ones it draws with.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless 0 < near < far, both finite.
    pub fn with_planes(self, near: f32, far: f32) -> Result<Self> {
        if !(near > 0.0 && near < far && far.is_finite()) {
            return Err(Error::parameter(
                "planes",
                format!("{near} and {far}"),
                "above 0, finite, and far beyond near",
            ));
        }
        Ok(Self { near, far, ..self })
    }

    /// The same camera, moved around what it looks at by `degrees`, counter-clockwise about `axis`: with +y, as a
    /// turntable does it. Near and far planes stay.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an angle that is not finite, or an axis that is zero or not finite.
    pub fn orbited(&self, degrees: f32, axis: Vec3) -> Result<Self> {
        if !degrees.is_finite() {
            return Err(Error::parameter("orbit", degrees, "finite"));
        }
        let axis = axis.as_dvec3().try_normalize().ok_or_else(|| Error::parameter("axis", axis, "not zero"))?;
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        let turned = |v: DVec3| {
            let along = axis * axis.dot(v);
            along + cos * (v - along) + sin * axis.cross(v)
        };
        let eye = self.target.as_dvec3() + turned((self.eye - self.target).as_dvec3());
        let up = turned(self.up.as_dvec3()).as_vec3();
        let moved = Self::look_at(eye.as_vec3(), self.target, Some(up), self.fov_y_deg)?;
        Ok(Self { near: self.near, far: self.far, ..moved })
    }

    /// The same camera at `factor` times its distance from what it looks at. Near and far planes stay.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a factor that is not above 0, or that leads too far away or too close.
    pub fn moved_away(&self, factor: f32) -> Result<Self> {
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(Error::parameter("distance factor", factor, "above 0 and finite"));
        }
        let eye = self.target + factor * (self.eye - self.target);
        let moved = Self::look_at(eye, self.target, Some(self.up), self.fov_y_deg)?;
        Ok(Self { near: self.near, far: self.far, ..moved })
    }

    /// Where the camera is.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The point that it looks at: the middle of the picture.
    pub fn target(&self) -> Vec3 {
        self.target
    }

    /// Unit vector of the view direction, from the eye into the scene.
    pub fn forward(&self) -> Vec3 {
        self.forward
    }

    /// Unit vector that is up in the picture, at a right angle to [`Camera::forward`].
    pub fn up(&self) -> Vec3 {
        self.up
    }

    /// Vertical field of view in degrees.
    pub fn fov_y_deg(&self) -> f32 {
        self.fov_y_deg
    }

    /// Distance of the near plane, above 0: depth 0.
    pub fn near(&self) -> f32 {
        self.near
    }

    /// Distance of the far plane, beyond [`Camera::near`]: depth 1.
    pub fn far(&self) -> f32 {
        self.far
    }

    /// World space to view space.
    pub fn view(&self) -> Mat4 {
        look_to_mat4(self.eye, self.forward, self.up)
    }

    /// View space to Vulkan's clip space, for a picture of this width over height.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `aspect` is not in 0.01..=100.
    pub fn projection(&self, aspect: f32) -> Result<Mat4> {
        check_aspect(aspect)?;
        Ok(perspective(self.fov_y_deg.to_radians(), aspect, self.near, self.far))
    }

    /// World space to Vulkan's clip space.
    ///
    /// # Errors
    /// As [`Camera::projection`].
    pub fn view_projection(&self, aspect: f32) -> Result<Mat4> {
        Ok(self.projection(aspect)? * self.view())
    }
}

/// The depth that a perspective projection gives at distance z along the view axis, as a and b of a + b / z.
///
/// # Errors
/// [`Error::Parameter`] for a projection that is none.
pub(crate) fn perspective_depth(projection: &Mat4) -> Result<[f32; 2]> {
    let (z, w) = (projection.z_axis, projection.w_axis);
    if z.w.abs() != 1.0 || w.w != 0.0 || projection.x_axis.x == 0.0 || projection.y_axis.y == 0.0 {
        return Err(Error::parameter("projection", projection, "a perspective one"));
    }
    Ok([z.z / z.w, w.z])
}

/// Whether a matrix turns, or turns and mirrors, and does nothing else, but for rounding.
pub(super) fn is_orthonormal(matrix: DMat3) -> bool {
    /// How far off rounding may be.
    const ROUNDING: f64 = 1e-3;
    let off = matrix * matrix.transpose() - DMat3::IDENTITY;
    off.to_cols_array().iter().all(|entry| entry.abs() <= ROUNDING)
}

pub(super) fn check_fov(fov_y_deg: f32) -> Result<()> {
    if FOV_Y_DEG.contains(&fov_y_deg) {
        return Ok(());
    }
    Err(Error::parameter("fov_y_deg", fov_y_deg, "from 1 to 150 degrees"))
}

pub(crate) fn check_aspect(aspect: f32) -> Result<()> {
    if ASPECT.contains(&aspect) {
        return Ok(());
    }
    Err(Error::parameter("aspect", aspect, "from 0.01 to 100 (width over height)"))
}
