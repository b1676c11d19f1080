//! Light: how bright a surface is for its normal (thesis section 3.1.2, equation 3.1).

use glam::Vec3;

use super::camera::Camera;
use crate::error::{Error, Result};

/// The most lights of one scene.
pub const MAX_LIGHTS: usize = 8;

/// Parallel light that comes from one direction, like the sun's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    direction: Vec3,
    intensity: f32,
}

impl DirectionalLight {
    /// A light from `direction`, a world-space vector of any length that points from the surface towards the light.
    /// `intensity` is its weight among several lights; a single light shades the same with any.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the direction is zero or not finite, or the intensity is not in 1e-6..=1e6.
    pub fn new(direction: Vec3, intensity: f32) -> Result<Self> {
        let unit = direction.as_dvec3().try_normalize().filter(|_| direction.is_finite());
        let Some(unit) = unit else {
            return Err(Error::parameter("direction", direction, "a finite vector that is not zero"));
        };
        if !(1e-6..=1e6).contains(&intensity) {
            return Err(Error::parameter("intensity", intensity, "from 1e-6 to 1e6"));
        }
        Ok(Self { direction: unit.as_vec3(), intensity })
    }

    /// A light whose direction is given as the camera sees it: x to the right, y up, z towards the viewer. It keeps its
    /// place in the picture, wherever the camera stands.
    ///
    /// # Errors
    /// As [`DirectionalLight::new`].
    pub fn from_view(camera: &Camera, direction: Vec3, intensity: f32) -> Result<Self> {
        Self::new(camera.view().inverse().transform_vector3(direction), intensity)
    }

    /// Unit vector in world space from the surface towards the light: L of equation 3.1.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// The light's weight, above 0.
    pub fn intensity(&self) -> f32 {
        self.intensity
    }
}

/// The lights of a scene, 1 to [`MAX_LIGHTS`].
#[derive(Debug, Clone, PartialEq)]
pub struct Lights(Vec<DirectionalLight>);

impl Default for Lights {
    /// One light from the upper left, a little in front of the model, as seen from +z.
    ///
    /// Light from the side uses most of a paint strip: on a sphere seen from +z the visible shades run from 0.03 to 1,
    /// and seen through [`Framing::default`](super::Framing) from 0.00 to 1.
    fn default() -> Self {
        let direction = Vec3::new(-0.8, 0.5, 0.35).normalize();
        Self(vec![DirectionalLight { direction, intensity: 1.0 }])
    }
}

impl Lights {
    /// Several lights together.
    ///
    /// # Errors
    /// [`Error::Parameter`] if there are none, or more than [`MAX_LIGHTS`].
    pub fn new(lights: impl Into<Vec<DirectionalLight>>) -> Result<Self> {
        let lights = lights.into();
        if lights.is_empty() || lights.len() > MAX_LIGHTS {
            return Err(Error::parameter("lights", lights.len(), format!("from 1 to {MAX_LIGHTS}")));
        }
        Ok(Self(lights))
    }

    /// The single lights.
    pub fn as_slice(&self) -> &[DirectionalLight] {
        &self.0
    }

    /// The amount of light, 0 to 1, that a surface with this unit normal receives: equation 3.1, s = (1 + N.L) / 2, as
    /// the mean over all lights, weighted by their intensities.
    pub fn shade(&self, normal: Vec3) -> f32 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for light in &self.0 {
            sum += light.intensity * (1.0 + normal.dot(light.direction)) / 2.0;
            weights += light.intensity;
        }
        (sum / weights).clamp(0.0, 1.0)
    }

    /// The weighted mean M of all light directions, at most 1 long. Equation 3.1 is linear in L, so that a shader needs
    /// this vector only: `shade(N)` is (1 + N.M) / 2 for any number of lights.
    pub fn mean_direction(&self) -> Vec3 {
        let weights: f32 = self.0.iter().map(|light| light.intensity).sum();
        self.0.iter().map(|light| light.direction * (light.intensity / weights)).sum()
    }
}

impl From<DirectionalLight> for Lights {
    fn from(light: DirectionalLight) -> Self {
        Self(vec![light])
    }
}
