//! What the cases paint: models and paints of the project's own, and where everything is in each frame.

use super::catalogue::{MotionName, SceneName};
use crate::cli::builtin::{builtin_model, builtin_strip};
use crate::cli::failure::Result;
use crate::cli::paints::Paints;
use crate::cli::strips::Strip;
use glam::DQuat;
use impasto::paint::{TextureDifference, Trajectory, TrajectoryOptions};
use impasto::scene::{Camera, DirectionalLight, Framing, Lights, Mesh, MeshOptions, Moment, Object, Vec3};
use std::f32::consts::PI;
use std::path::PathBuf;

/// Degrees by which the light turns from frame to frame.
const LIGHT_DEG: f64 = 3.0;
/// Degrees by which the camera turns from frame to frame.
const CAMERA_DEG: u32 = 1;
/// By what the distance changes from frame to frame, and for how many frames before it changes back.
const ZOOM: (f32, u32) = (0.99, 40);
/// Frames from cut to cut, and degrees by which the camera jumps there.
const CUT: (u32, u32) = (8, 117);
/// Objects of the scene of many, to a side.
const ACROSS: u32 = 8;

/// A model with its paints.
pub struct Model {
    /// The model.
    pub mesh: Mesh,
    /// The paints of its objects.
    pub paints: Paints,
    pitch_deg: f32,
}

impl Model {
    /// The one of that name.
    pub fn new(scene: SceneName) -> Result<Self> {
        let (mesh, strips, pitch_deg) = match scene {
            SceneName::Head => (builtin_model("head.obj")?, &["green_yellow"][..], 12.0),
            SceneName::Teapot => (builtin_model("teapot_on_table.obj")?, &["red_yellow", "green_yellow"][..], 12.0),
            SceneName::Many => (many()?, &["green_yellow", "dark_red", "red_yellow"][..], 35.0),
        };
        let strips = strips.iter().map(|name| strip(name)).collect::<Result<Vec<_>>>()?;
        let paints = Paints::in_turn(strips, &mesh);
        Ok(Model { mesh, paints, pitch_deg })
    }

    /// Where everything is in the first `frames` frames, in pictures of this width over height.
    pub fn moments(&self, motion: MotionName, frames: u32, aspect: f32) -> Result<Vec<Moment>> {
        let framing = Framing { pitch_deg: self.pitch_deg, ..Framing::default() };
        let distance = framing.distance_for_all_views(aspect)?;
        let camera = Camera::framing(&self.mesh, &Framing { distance: Some(distance), ..framing }, aspect)?;
        (0..frames).map(|frame| self.moment(&camera, motion, frame)).collect()
    }

    fn moment(&self, camera: &Camera, motion: MotionName, frame: u32) -> Result<Moment> {
        let turned = |degrees: u32| camera.orbited((degrees % 360) as f32, Vec3::Y);
        let camera = match motion {
            MotionName::LightOrbit => *camera,
            MotionName::CameraOrbit => turned(frame * CAMERA_DEG)?,
            MotionName::Zoom => {
                let (factor, steps) = ZOOM;
                let step = frame % (2 * steps);
                camera.moved_away(factor.powi(step.min(2 * steps - step) as i32))?
            }
            MotionName::Cut => turned(frame / CUT.0 * CUT.1 + frame % CUT.0 * CAMERA_DEG)?,
        };
        let lights = match motion {
            MotionName::LightOrbit => light(frame)?,
            _ => light(0)?,
        };
        Ok(Moment::at_rest(camera.fit_depth(&self.mesh), lights))
    }
}

impl MotionName {
    /// Whether a frame has nothing to do with the one before.
    pub fn is_fresh(self, frame: u32) -> bool {
        frame == 0 || (self == MotionName::Cut && frame.is_multiple_of(CUT.0))
    }
}

/// The default light, turned.
fn light(frame: u32) -> Result<Lights> {
    let turn = DQuat::from_rotation_y((LIGHT_DEG * f64::from(frame)).to_radians());
    let turned = Lights::default().mean_direction().as_dvec3();
    Ok(DirectionalLight::new((turn * turned).as_vec3(), 1.0)?.into())
}

/// A built-in strip, taken apart.
pub fn strip(name: &str) -> Result<(Strip, PathBuf)> {
    let file = format!("strip_{name}.png");
    let sample = builtin_strip(&file)?;
    let trajectory = Trajectory::extract(&sample, &TrajectoryOptions::default())?;
    let texture = TextureDifference::extract(&sample, &trajectory);
    Ok((Strip { sample, trajectory, texture }, file.into()))
}

/// A square of balls, cones and drums, each an object of its own, of several sizes.
fn many() -> Result<Mesh> {
    let (mut positions, mut indices, mut objects) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..ACROSS * ACROSS {
        let profile: &[[f32; 2]] = match number % 3 {
            0 => &[[0.0, -1.0], [0.5, -0.87], [0.87, -0.5], [1.0, 0.0], [0.87, 0.5], [0.5, 0.87], [0.0, 1.0]],
            1 => &[[0.0, -1.0], [1.0, -1.0], [0.5, 0.0], [0.0, 1.0]],
            _ => &[[0.0, -1.0], [0.8, -1.0], [0.8, 0.0], [0.8, 1.0], [0.0, 1.0]],
        };
        let radius = 0.3 + 0.03 * (number % 5) as f32;
        let place = Vec3::new((number % ACROSS) as f32, radius, (number / ACROSS) as f32);
        let first_index = indices.len() as u32;
        turn(profile, radius, place, &mut positions, &mut indices);
        let index_count = indices.len() as u32 - first_index;
        objects.push(Object { name: format!("object {number}"), first_index, index_count });
    }
    Ok(Mesh::build(positions, None, &indices, &objects, &MeshOptions::default())?.mesh)
}

/// A solid that a profile of (distance from the axis, height) leaves when it is turned round the vertical. The profile
/// begins and ends on the axis, at the bottom and at the top.
fn turn(profile: &[[f32; 2]], scale: f32, place: Vec3, positions: &mut Vec<[f32; 3]>, indices: &mut Vec<u32>) {
    const AROUND: u32 = 24;
    let first = positions.len() as u32;
    for [out, up] in profile {
        for step in 0..AROUND {
            let (sin, cos) = (2.0 * PI * step as f32 / AROUND as f32).sin_cos();
            positions.push((place + scale * Vec3::new(out * cos, *up, out * sin)).to_array());
        }
    }
    let rings = profile.len() as u32 - 1;
    for ring in 0..rings {
        for step in 0..AROUND {
            let at = |ring: u32, step: u32| first + ring * AROUND + step % AROUND;
            let (a, b) = (at(ring, step), at(ring, step + 1));
            let (c, d) = (at(ring + 1, step + 1), at(ring + 1, step));
            // On the axis a quad is a triangle.
            if ring > 0 {
                indices.extend([a, d, b]);
            }
            if ring + 1 < rings {
                indices.extend([b, d, c]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::{MOTIONS, SCENES};
    use super::*;

    #[test]
    fn scenes_have_as_many_objects_and_paints_as_they_say() {
        for (scene, objects) in SCENES.into_iter().zip([1, 2, 64]) {
            let model = Model::new(scene).expect("a model");
            assert_eq!(model.mesh.objects().len(), objects);
            assert!(model.mesh.objects().iter().all(|object| object.index_count > 0), "{scene:?}");
            let used = model.paints.of_object.iter().max().map(|most| *most as usize + 1);
            assert_eq!(used, Some(objects.min(3)), "{scene:?}");
        }
    }

    /// Seen from outside, a solid's faces are counter-clockwise: their normals point away from its middle.
    #[test]
    fn solids_face_outwards() {
        let mesh = many().expect("a mesh");
        for (number, object) in mesh.objects().iter().enumerate() {
            // Two triangles for each quad, one where it touches the axis; none was dropped.
            let rings = [6, 3, 4][number % 3];
            assert_eq!(object.index_count, 3 * 24 * (2 * rings - 2), "object {number}");
            let range = object.first_index as usize..(object.first_index + object.index_count) as usize;
            let corners: Vec<Vec3> =
                mesh.indices()[range].iter().map(|&i| Vec3::from(mesh.positions()[i as usize])).collect();
            let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
            for face in corners.chunks_exact(3) {
                let normal = (face[1] - face[0]).cross(face[2] - face[0]);
                assert!(normal.dot(face[0] + face[1] + face[2] - 3.0 * middle) > 0.0, "object {number}");
            }
        }
    }

    #[test]
    fn motions_are_functions_of_the_frame_that_move_something() {
        let model = Model::new(SceneName::Head).expect("a model");
        for motion in MOTIONS {
            let moments = model.moments(motion, 20, 1.0).expect("moments");
            assert_eq!(moments, model.moments(motion, 20, 1.0).expect("moments"));
            assert_eq!(moments[..3], model.moments(motion, 3, 1.0).expect("moments"));
            assert!(moments.windows(2).all(|pair| pair[0] != pair[1]), "{motion:?}");
            let fresh: Vec<u32> = (0..20).filter(|&frame| motion.is_fresh(frame)).collect();
            assert_eq!(fresh, if motion == MotionName::Cut { vec![0, 8, 16] } else { vec![0] });
        }
    }

    #[test]
    fn a_cut_is_a_jump() {
        let model = Model::new(SceneName::Teapot).expect("a model");
        let moments = model.moments(MotionName::Cut, 10, 1.0).expect("moments");
        let way = |frame: usize| moments[frame].camera.eye().distance(moments[frame - 1].camera.eye());
        assert!(way(8) > 20.0 * way(7), "{} and {}", way(8), way(7));
    }
}
