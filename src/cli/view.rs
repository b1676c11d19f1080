//! Camera and lights on the command line.

use super::failure::Result;
use super::report::number;
use super::session::Session;
use super::values::{finite, light, vector};
use clap::Args;
use impasto::scene::{Camera, DirectionalLight, Framing, Lights, Mesh, Vec3, DEFAULT_FOV_Y_DEG};
use serde_json::json;

/// From where the model is seen, and how it is lit.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Camera and light")]
pub struct ViewFlags {
    /// Degrees around the model: 0 from +z, positive towards +x [default: a three-quarter view]
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true)]
    yaw: Option<f32>,
    /// Degrees above the horizon, -90 to 90 [default: a little above]
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true)]
    pitch: Option<f32>,
    /// From the middle of the model, in radii of its bounding sphere [default: so that the model fits the picture]
    #[arg(long, value_name = "RADII", value_parser = finite, allow_hyphen_values = true)]
    distance: Option<f32>,
    /// Vertical field of view, 1 to 150 degrees
    #[arg(long, value_name = "DEGREES", value_parser = finite, default_value_t = DEFAULT_FOV_Y_DEG,
          allow_negative_numbers = true)]
    fov: f32,
    /// The camera's place, instead of yaw, pitch and distance
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true,
          conflicts_with_all = ["yaw", "pitch", "distance"])]
    eye: Option<Vec3>,
    /// The point that the camera looks at [default: the middle of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "eye")]
    target: Option<Vec3>,
    /// The direction that is up in the picture [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "eye")]
    up: Option<Vec3>,
    /// Direction towards a light, with its weight among several; may be repeated [default: from the upper left]
    #[arg(long = "light", value_name = "X,Y,Z[@INTENSITY]", value_parser = light, allow_hyphen_values = true)]
    lights: Vec<DirectionalLight>,
}

impl ViewFlags {
    /// The camera for a picture of this width over height.
    pub fn camera(&self, mesh: &Mesh, aspect: f32) -> Result<Camera> {
        let camera = match self.eye {
            Some(eye) => {
                let target = self.target.unwrap_or_else(|| mesh.bounding_sphere().center);
                Camera::look_at(eye, target, self.up, self.fov)?.fit_depth(mesh)
            }
            None => {
                let default = Framing::default();
                let framing = Framing {
                    yaw_deg: self.yaw.unwrap_or(default.yaw_deg),
                    pitch_deg: self.pitch.unwrap_or(default.pitch_deg),
                    distance: self.distance,
                    fov_y_deg: self.fov,
                    ..default
                };
                Camera::framing(mesh, &framing, aspect)?
            }
        };
        // A picture's shape may be too long for a camera of a fixed place as well.
        camera.projection(aspect)?;
        Ok(camera)
    }

    /// What the camera goes around: the line through its target that is up in the scene.
    pub fn axis(&self) -> Vec3 {
        self.up.unwrap_or(Vec3::Y)
    }

    /// The lights.
    pub fn lights(&self) -> Result<Lights> {
        if self.lights.is_empty() {
            return Ok(Lights::default());
        }
        Ok(Lights::new(self.lights.clone())?)
    }

    /// Adds camera and lights to the report.
    pub fn report(&self, camera: &Camera, lights: &Lights, session: &mut Session) {
        let vector = |v: Vec3| json!([number(v.x), number(v.y), number(v.z)]);
        session.parameter(
            "camera",
            json!({
                "yaw": self.yaw.map(number), "pitch": self.pitch.map(number), "distance": self.distance.map(number),
                "fov": number(self.fov), "eye": vector(camera.eye()), "target": vector(camera.target()),
                "up": vector(camera.up()),
            }),
        );
        let lights: Vec<_> = lights
            .as_slice()
            .iter()
            .map(|light| json!({ "direction": vector(light.direction()), "intensity": number(light.intensity()) }))
            .collect();
        session.parameter("lights", lights);
    }
}
