//! What moves from frame to frame: flags for the common cases, a file for the rest.

use super::failure::{Failure, Result};
use super::report::number;
use super::session::Session;
use super::values::finite;
use clap::Args;
use impasto::scene::{Camera, DirectionalLight, Lights, Mesh, Vec3};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The last frame there can be.
const MAX_FRAME: u32 = 999_999;

/// How camera and lights move.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Motion")]
pub struct MotionFlags {
    /// By how many degrees the camera goes around the model from frame to frame
    #[arg(long, value_name = "DEGREES", value_parser = finite, default_value_t = 0.0, allow_hyphen_values = true)]
    orbit: f32,
    /// What the camera's distance is multiplied by from frame to frame, 0.5 to 2
    #[arg(long, value_name = "FACTOR", value_parser = finite, default_value_t = 1.0, allow_hyphen_values = true)]
    zoom: f32,
    /// By how many degrees the lights go around the model, about the y axis, from frame to frame
    #[arg(long, value_name = "DEGREES", value_parser = finite, default_value_t = 0.0, allow_hyphen_values = true)]
    light_orbit: f32,
    /// Keyframes of camera and light, JSON: {"camera": [{"frame": 0, "orbit": 0, "distance": 1}, ...],
    /// "light": [{"frame": 0, "orbit": 0}, ...]}, degrees and multiples of the first distance, linear in between
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["orbit", "zoom", "light_orbit"])]
    motion: Option<PathBuf>,
}

/// A first and a last frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    pub first: u32,
    pub last: u32,
}

/// The motion, ready to be asked.
pub struct Motion {
    camera: Camera,
    /// What the camera goes around.
    axis: Vec3,
    lights: Lights,
    camera_keys: Vec<CameraKey>,
    light_keys: Vec<LightKey>,
    per_frame: Option<[f32; 3]>,
}

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    camera: Vec<CameraKey>,
    #[serde(default)]
    light: Vec<LightKey>,
}

#[derive(Deserialize, Debug, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct CameraKey {
    frame: u32,
    #[serde(default)]
    orbit: f32,
    #[serde(default = "one")]
    distance: f32,
}

#[derive(Deserialize, Debug, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct LightKey {
    frame: u32,
    #[serde(default)]
    orbit: f32,
}

fn one() -> f32 {
    1.0
}

impl std::str::FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || format!("must be FIRST..LAST, both shown, like 0..99, up to {MAX_FRAME}");
        let (first, last) = text.split_once("..").ok_or_else(wrong)?;
        let number = |text: &str| text.parse().ok().filter(|number| *number <= MAX_FRAME).ok_or_else(wrong);
        let frames = Frames { first: number(first)?, last: number(last)? };
        if frames.first > frames.last {
            return Err(wrong());
        }
        Ok(frames)
    }
}

impl std::fmt::Display for Frames {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}..{}", self.first, self.last)
    }
}

impl Frames {
    /// How many there are.
    pub fn count(self) -> u32 {
        self.last - self.first + 1
    }

    /// Part `index` of `count` parts of nearly the same length; `None` where that has no frame.
    pub fn part(self, index: u32, count: u32) -> Option<Frames> {
        let at = |i: u32| self.first + (u64::from(self.count()) * u64::from(i) / u64::from(count)) as u32;
        let (first, end) = (at(index), at(index + 1));
        (first < end).then(|| Frames { first, last: end - 1 })
    }
}

impl MotionFlags {
    /// The motion of a scene whose first frame looks through `camera` in `lights`; the camera goes around `axis`. Adds
    /// the flags to the report..
    pub fn load(&self, camera: Camera, axis: Vec3, lights: Lights, session: &mut Session) -> Result<Motion> {
        if !(0.5..=2.0).contains(&self.zoom) {
            return Err(Failure::new(format!("--zoom is {}, but must be from 0.5 to 2", self.zoom)));
        }
        let mut motion = Motion {
            camera,
            axis,
            lights,
            camera_keys: Vec::new(),
            light_keys: Vec::new(),
            per_frame: Some([self.orbit, self.zoom, self.light_orbit]),
        };
        session.parameter("orbit", number(self.orbit));
        session.parameter("zoom", number(self.zoom));
        session.parameter("light_orbit", number(self.light_orbit));
        session.parameter("motion", self.motion.as_ref().map(|path| path.display().to_string()));
        if let Some(path) = &self.motion {
            let file = read(path)?;
            session.parameter("keyframes", format!("{file:?}"));
            motion = Motion { per_frame: None, camera_keys: file.camera, light_keys: file.light, ..motion };
        }
        Ok(motion)
    }
}

fn read(path: &Path) -> Result<File> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::file(path, error))?;
    let file: File = serde_json::from_str(&text).map_err(|error| Failure::file(path, error))?;
    let camera = file.camera.iter().map(|key| key.frame);
    let light = file.light.iter().map(|key| key.frame);
    for (name, frames) in [("camera", camera.collect::<Vec<_>>()), ("light", light.collect())] {
        if !frames.is_sorted_by(|a, b| a < b) {
            return Err(Failure::file(path, format!("the frames of {name} must rise")));
        }
    }
    let values = file.camera.iter().flat_map(|key| [key.orbit, key.distance]);
    if values.chain(file.light.iter().map(|key| key.orbit)).any(|value| !value.is_finite()) {
        return Err(Failure::file(path, "must have finite numbers"));
    }
    if let Some(key) = file.camera.iter().find(|key| !(1e-3..=1e3).contains(&key.distance)) {
        let text = format!("the distance of frame {} is {}, but must be from 0.001 to 1000", key.frame, key.distance);
        return Err(Failure::file(path, text));
    }
    Ok(file)
}

/// What keyframes have at a frame: linear in between, and the nearest outside of them.
fn between<const N: usize>(keys: &[(u32, [f32; N])], frame: u32) -> Option<[f32; N]> {
    let after = keys.iter().position(|(at, _)| *at >= frame);
    match after {
        None => keys.last().map(|(_, values)| *values),
        Some(0) => Some(keys[0].1),
        Some(next) => {
            let ((from, a), (to, b)) = (keys[next - 1], keys[next]);
            let part = f64::from(frame - from) / f64::from(to - from);
            let mix = |k: usize| (f64::from(a[k]) * (1.0 - part) + f64::from(b[k]) * part) as f32;
            Some(std::array::from_fn(mix))
        }
    }
}

impl Motion {
    /// Camera and lights of a frame. They depend on nothing but its number.
    pub fn at(&self, frame: u32, mesh: &Mesh) -> Result<(Camera, Lights)> {
        let [orbit, distance, light] = match self.per_frame {
            Some([orbit, zoom, light]) => {
                let frame = f64::from(frame);
                [
                    (f64::from(orbit) * frame) as f32,
                    f64::from(zoom).powf(frame) as f32,
                    (f64::from(light) * frame) as f32,
                ]
            }
            None => {
                let camera: Vec<_> =
                    self.camera_keys.iter().map(|key| (key.frame, [key.orbit, key.distance])).collect();
                let lights: Vec<_> = self.light_keys.iter().map(|key| (key.frame, [key.orbit])).collect();
                let [orbit, distance] = between(&camera, frame).unwrap_or([0.0, 1.0]);
                let [light] = between(&lights, frame).unwrap_or([0.0]);
                [orbit, distance, light]
            }
        };
        let camera = self.camera.orbited(orbit, self.axis)?.moved_away(distance)?.fit_depth(mesh);
        let (sin, cos) = f64::from(light).to_radians().sin_cos();
        let turned = |d: Vec3| {
            let (x, z) = (f64::from(d.x), f64::from(d.z));
            Vec3::new((x * cos + z * sin) as f32, d.y, (z * cos - x * sin) as f32)
        };
        let lights: impasto::Result<Vec<_>> = self
            .lights
            .as_slice()
            .iter()
            .map(|light| DirectionalLight::new(turned(light.direction()), light.intensity()))
            .collect();
        Ok((camera, Lights::new(lights?)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_and_cut_without_gap_or_overlap() {
        let frames: Frames = "10..19".parse().expect("frames");
        assert_eq!((frames.count(), frames.to_string()), (10, "10..19".to_owned()));
        for wrong in ["", "5", "5..", "..5", "9..3", "-1..3", "0..1000000", "a..b"] {
            assert!(wrong.parse::<Frames>().is_err(), "{wrong}");
        }
        for count in [1, 2, 3, 7, 10, 13] {
            let parts: Vec<Frames> = (0..count).filter_map(|i| frames.part(i, count)).collect();
            assert_eq!(parts[0].first, 10);
            assert_eq!(parts[parts.len() - 1].last, 19);
            assert!(parts.windows(2).all(|pair| pair[0].last + 1 == pair[1].first));
        }
    }

    #[test]
    fn keyframes_are_linear_in_between_and_hold_outside() {
        let keys = [(10, [0.0, 1.0]), (20, [90.0, 3.0])];
        assert_eq!(between(&keys, 0), Some([0.0, 1.0]));
        assert_eq!(between(&keys, 15), Some([45.0, 2.0]));
        assert_eq!(between(&keys, 20), Some([90.0, 3.0]));
        assert_eq!(between(&keys, 99), Some([90.0, 3.0]));
        assert_eq!(between::<1>(&[], 5), None);
    }
}
