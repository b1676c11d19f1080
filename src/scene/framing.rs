//! A camera that frames the model by itself: from a direction, as large as the picture allows.

use glam::{DVec3, Vec3};

use super::camera::{check_aspect, check_fov, Camera, DEFAULT_FOV_Y_DEG};
use super::mesh::Mesh;
use crate::error::{Error, Result};

/// The closest that the eye comes to the nearest vertex, in bounding-sphere radii.
const MIN_CLEARANCE: f64 = 0.05;

/// From where, and how large, a model is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// 0 looks at the model from +z, which is its front if it faces +z. A positive angle moves the camera to the right
    /// of that, towards +x. In degrees, any.
    pub yaw_deg: f32,
    /// How far above the horizon the camera stands, in degrees: -90 (below the model) to 90 (above it).
    pub pitch_deg: f32,
    /// Distance of the eye from the middle of the model in bounding-sphere radii, 0.01 to 1000. `None` fits the model
    /// into the picture as large as possible.
    pub distance: Option<f32>,
    /// Vertical field of view in degrees, 1 to 150.
    pub fov_y_deg: f32,
    /// What stays free on every side of the picture when the model is fitted, as a part of its width or height: 0 to
    /// 0.45.
    pub margin: f32,
}

impl Default for Framing {
    /// Three-quarter view from a little above, fitted.
    fn default() -> Self {
        Self { yaw_deg: 25.0, pitch_deg: 12.0, distance: None, fov_y_deg: DEFAULT_FOV_Y_DEG, margin: 0.05 }
    }
}

impl Framing {
    /// The distance, in bounding-sphere radii, from which every view of a model fits into a picture of this aspect
    /// (width over height). For a camera that turns around the model: fitted anew for each picture it would seem to
    /// move to and fro.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a field or the aspect is out of range.
    pub fn distance_for_all_views(&self, aspect: f32) -> Result<f32> {
        self.check()?;
        check_aspect(aspect)?;
        let [x, y] = self.usable_tangents(aspect);
        // The sphere touches the cone of this tangent.
        Ok((1.0 + x.min(y).powi(-2)).sqrt() as f32)
    }

    /// Tangents of half the fields of view across and upwards, less the margins.
    fn usable_tangents(&self, aspect: f32) -> [f64; 2] {
        let y = f64::from(self.fov_y_deg).to_radians() / 2.0;
        let usable = y.tan() * (1.0 - 2.0 * f64::from(self.margin));
        [usable * f64::from(aspect), usable]
    }

    fn check(&self) -> Result<()> {
        if !self.yaw_deg.is_finite() {
            return Err(Error::parameter("yaw_deg", self.yaw_deg, "a finite angle in degrees"));
        }
        if !(-90.0..=90.0).contains(&self.pitch_deg) {
            return Err(Error::parameter("pitch_deg", self.pitch_deg, "from -90 to 90 degrees"));
        }
        if let Some(distance) = self.distance.filter(|distance| !(0.01..=1000.0).contains(distance)) {
            return Err(Error::parameter("distance", distance, "from 0.01 to 1000 bounding-sphere radii"));
        }
        if !(0.0..=0.45).contains(&self.margin) {
            return Err(Error::parameter("margin", self.margin, "from 0 to 0.45 of the picture's side"));
        }
        check_fov(self.fov_y_deg)
    }

    /// Unit vectors of the camera: right, up, forward.
    fn axes(&self) -> [DVec3; 3] {
        let (sin_yaw, cos_yaw) = f64::from(self.yaw_deg % 360.0).to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = f64::from(self.pitch_deg).to_radians().sin_cos();
        let towards_eye = DVec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let right = DVec3::new(cos_yaw, 0.0, -sin_yaw);
        [right, towards_eye.cross(right), -towards_eye]
    }
}

impl Camera {
    /// A camera that shows the whole mesh in a picture of this aspect (width over height), with near and far planes
    /// close around it.
    ///
    /// Unless a distance is asked for, every vertex is projected: in the tighter of the two directions the model fills
    /// the picture but for the margins, and in the other one it is centred.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a field of `framing` or the aspect is out of range.
    pub fn framing(mesh: &Mesh, framing: &Framing, aspect: f32) -> Result<Self> {
        framing.check()?;
        check_aspect(aspect)?;
        let sphere = mesh.bounding_sphere();
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        let [right, up, forward] = framing.axes();
        let eye = match framing.distance {
            Some(distance) => DVec3::new(0.0, 0.0, -f64::from(distance) * radius),
            None => {
                let points: Vec<DVec3> = mesh
                    .positions()
                    .iter()
                    .map(|&position| Vec3::from(position).as_dvec3() - center)
                    .map(|p| DVec3::new(p.dot(right), p.dot(up), p.dot(forward)))
                    .collect();
                fit(&points, framing.usable_tangents(aspect), radius * MIN_CLEARANCE)
            }
        };
        let beside = center + eye.x * right + eye.y * up;
        let eye = beside + eye.z * forward;
        let target = if eye.distance(beside) < 1e-6 * radius { eye + radius * forward } else { beside };
        let camera = Camera::look_at(eye.as_vec3(), target.as_vec3(), Some(up.as_vec3()), framing.fov_y_deg)?;
        Ok(camera.fit_depth(mesh))
    }
}

/// The eye that sees all points (x right, y up, z forward) within the given tangents, from as close as possible but at
/// least `clearance` in front of the first.
///
/// A point is seen within a tangent t if |x - eye.x| <= t (z - eye.z). So the largest x - t z and the largest -x - t z
/// of all points tell how near the eye may come, and where it has to be across.
fn fit(points: &[DVec3], tangents: [f64; 2], clearance: f64) -> DVec3 {
    let mut nearest = f64::INFINITY;
    let mut highest = [[f64::NEG_INFINITY; 2]; 2];
    for point in points {
        nearest = nearest.min(point.z);
        for axis in 0..2 {
            let reach = tangents[axis] * point.z;
            highest[axis][0] = highest[axis][0].max(point[axis] - reach);
            highest[axis][1] = highest[axis][1].max(-point[axis] - reach);
        }
    }
    let mut z = nearest - clearance;
    for axis in 0..2 {
        z = z.min(-(highest[axis][0] + highest[axis][1]) / (2.0 * tangents[axis]));
    }
    let across = [0, 1].map(|axis| {
        let (low, high) = (highest[axis][0] + tangents[axis] * z, -highest[axis][1] - tangents[axis] * z);
        centred(points, axis, z, (low + high) / 2.0).clamp(low.min(high), high.max(low))
    });
    DVec3::new(across[0], across[1], z)
}

/// Moves the eye across, from `start`, until the outermost points on both sides are equally far from the picture's
/// middle. Which points are the outermost changes little on the way, so that a few rounds suffice.
fn centred(points: &[DVec3], axis: usize, eye_z: f64, start: f64) -> f64 {
    let mut eye = start;
    for _ in 0..4 {
        let (mut low, mut high) = ((f64::INFINITY, 0.0, 1.0), (f64::NEG_INFINITY, 0.0, 1.0));
        for point in points {
            let depth = point.z - eye_z;
            let projected = (point[axis] - eye) / depth;
            if projected < low.0 {
                low = (projected, point[axis], depth);
            }
            if projected > high.0 {
                high = (projected, point[axis], depth);
            }
        }
        eye = (low.1 * high.2 + high.1 * low.2) / (low.2 + high.2);
    }
    eye
}
