//! Where a frame is seen from, as the host says it: two matrices.

use crate::scene::FRAME;
use glam::camera::rh::{proj, view::look_at_mat4};
use glam::{Mat4, Vec3};

const FOV_Y: f32 = 27.0;
/// Depth at distance z is NEAR / z: 1 at the near plane, 0 at infinity.
const NEAR: f32 = 2.0;

pub struct View {
    pub view: Mat4,
    pub projection: Mat4,
}

impl View {
    /// On a way around the head, from its left to its right; `along` is 0 to 1.
    pub fn on_orbit(along: f32) -> Self {
        let (sin, cos) = (-60.0 + 120.0 * along).to_radians().sin_cos();
        let eye = Vec3::new(92.0 * sin, 28.0, 92.0 * cos);
        let aspect = FRAME[0] as f32 / FRAME[1] as f32;
        View {
            view: look_at_mat4(eye, Vec3::new(0.0, 8.5, 0.0), Vec3::Y),
            projection: proj::directx::perspective_infinite_reverse(FOV_Y.to_radians(), aspect, NEAR),
        }
    }
}
