//! The file of `--motion`: keyframes of the camera, the light and the objects, and cuts. Read and checked here, so that
//! [`Motion`](super::motion::Motion) may trust it.

use super::failure::{Failure, Result};
use super::keyframes::{Direction, Key};
use super::motion::{CameraMotion, LightMotion, ObjectMotion};
use glam::DVec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::Path;

/// Degrees, about an axis: enough for any number of turns, and still exact to a millionth.
const DEGREES: RangeInclusive<f64> = -1e9..=1e9;
/// Multiples of the first camera's distance.
pub const DISTANCE: RangeInclusive<f64> = 1e-3..=1e3;
/// Fields of view, in degrees.
pub const FOV: RangeInclusive<f64> = 1.0..=150.0;
/// Coordinates: a smooth way that leads a little beyond its keys is still within what the library takes.
const PLACE: RangeInclusive<f64> = -1e14..=1e14;

/// What the file says of everything that moves.
#[derive(Debug)]
pub struct MotionFile {
    pub camera: CameraMotion,
    pub light: LightMotion,
    /// By the names that the file has for them.
    pub objects: Vec<(String, ObjectMotion)>,
    pub smooth: bool,
    pub cuts: Vec<u32>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct Document {
    smooth: bool,
    cuts: Vec<u32>,
    camera: Vec<CameraKey>,
    light: Vec<LightKey>,
    objects: BTreeMap<String, Vec<ObjectKey>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraKey {
    frame: u32,
    orbit: Option<f64>,
    distance: Option<f64>,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    fov: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightKey {
    frame: u32,
    orbit: Option<f64>,
    direction: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectKey {
    frame: u32,
    turn: Option<f64>,
    axis: Option<[f64; 3]>,
    #[serde(rename = "move")]
    way: Option<[f64; 3]>,
}

/// What is wrong with a file.
type Checked<T> = std::result::Result<T, String>;

/// Reads a file, and tells its content for the report as well. A camera's path has the field of view `fov` where none
/// is given, and an object turns about `axis` where none is given.
pub fn read(path: &Path, fov: f32, axis: DVec3) -> Result<(MotionFile, serde_json::Value)> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::file(path, error))?;
    let file = parse(&text, fov, axis).map_err(|reason| Failure::file(path, reason))?;
    let content = serde_json::from_str(&text).map_err(|error| Failure::file(path, error))?;
    Ok((file, content))
}

/// The same of a text.
pub fn parse(text: &str, fov: f32, axis: DVec3) -> Checked<MotionFile> {
    let document: Document = serde_json::from_str(text).map_err(|error| error.to_string())?;
    check_rising("cuts", document.cuts.iter().copied())?;
    let object = |(name, keys): (String, Vec<ObjectKey>)| {
        let motion = object_motion(&name, &keys, axis)?;
        Ok((name, motion))
    };
    Ok(MotionFile {
        camera: camera_motion(&document.camera, fov)?,
        light: light_motion(&document.light)?,
        objects: document.objects.into_iter().map(object).collect::<Checked<_>>()?,
        smooth: document.smooth,
        cuts: document.cuts,
    })
}

fn camera_motion(keys: &[CameraKey], fov: f32) -> Checked<CameraMotion> {
    check_rising("camera", keys.iter().map(|key| key.frame))?;
    let on_path = |key: &CameraKey| key.eye.is_some() || key.target.is_some() || key.fov.is_some();
    if !keys.iter().any(on_path) {
        let orbit =
            collect(keys, |key| Ok((key.frame, within("camera", key.frame, "orbit", key.orbit, 0.0, DEGREES)?)))?;
        let distance = |key: &CameraKey| within("camera", key.frame, "distance", key.distance, 1.0, DISTANCE);
        return Ok(CameraMotion::Orbit { orbit, distance: collect(keys, |key| Ok((key.frame, distance(key)?)))? });
    }
    let (mut eyes, mut targets, mut fovs) = (Vec::new(), Vec::new(), Vec::new());
    for key in keys {
        let frame = key.frame;
        let (Some(eye), Some(target), None, None) = (key.eye, key.target, key.orbit, key.distance) else {
            let text = "a camera's path has eye and target at every key, and neither orbit nor distance";
            return Err(format!("camera, frame {frame}: {text}"));
        };
        eyes.push((frame, place("camera", frame, "eye", eye)?));
        targets.push((frame, place("camera", frame, "target", target)?));
        fovs.push((frame, within("camera", frame, "fov", key.fov, fov.into(), FOV)?));
    }
    Ok(CameraMotion::Path { eye: eyes, target: targets, fov: fovs })
}

fn light_motion(keys: &[LightKey]) -> Checked<LightMotion> {
    check_rising("light", keys.iter().map(|key| key.frame))?;
    if keys.iter().all(|key| key.direction.is_none()) {
        let orbit = |key: &LightKey| Ok((key.frame, within("light", key.frame, "orbit", key.orbit, 0.0, DEGREES)?));
        return Ok(LightMotion::Orbit(collect(keys, orbit)?));
    }
    let path = collect(keys, |key| match (key.direction, key.orbit) {
        (Some(to), None) => Ok((key.frame, direction("light", key.frame, "direction", to)?)),
        _ => Err(format!("light, frame {}: a light's path has a direction at every key, and no orbit", key.frame)),
    })?;
    check_ways("light", "direction", &path)?;
    Ok(LightMotion::Path(path))
}

fn object_motion(name: &str, keys: &[ObjectKey], axis: DVec3) -> Checked<ObjectMotion> {
    let what = format!("object `{name}`");
    check_rising(&what, keys.iter().map(|key| key.frame))?;
    let axis = |key: &ObjectKey| direction(&what, key.frame, "axis", key.axis.unwrap_or(axis.to_array()));
    let axes = collect(keys, |key| Ok((key.frame, axis(key)?)))?;
    check_ways(&what, "axis", &axes)?;
    let turn = |key: &ObjectKey| within(&what, key.frame, "turn", key.turn, 0.0, DEGREES);
    let way = |key: &ObjectKey| place(&what, key.frame, "move", key.way.unwrap_or_default());
    Ok(ObjectMotion::Keys {
        turn: collect(keys, |key| Ok((key.frame, turn(key)?)))?,
        axis: axes,
        way: collect(keys, |key| Ok((key.frame, way(key)?)))?,
    })
}

fn collect<K, T>(keys: &[K], of: impl Fn(&K) -> Checked<Key<T>>) -> Checked<Vec<Key<T>>> {
    keys.iter().map(of).collect()
}

fn check_rising(what: &str, frames: impl Iterator<Item = u32>) -> Checked<()> {
    let frames: Vec<u32> = frames.collect();
    match frames.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(format!("the frames of {what} must rise, but {} follows {}", pair[1], pair[0])),
        None => Ok(()),
    }
}

fn check_ways(what: &str, name: &str, keys: &[Key<Direction>]) -> Checked<()> {
    match keys.windows(2).find(|pair| pair[0].1.is_opposite(pair[1].1)) {
        Some(pair) => {
            let frames = format!("frames {} and {}", pair[0].0, pair[1].0);
            Err(format!("{what}: {name} is opposite at {frames}; a key in between must say which way it goes"))
        }
        None => Ok(()),
    }
}

fn within(
    what: &str,
    frame: u32,
    name: &str,
    value: Option<f64>,
    default: f64,
    range: RangeInclusive<f64>,
) -> Checked<f64> {
    let value = value.unwrap_or(default);
    if range.contains(&value) {
        return Ok(value);
    }
    Err(wrong(what, frame, name, value, format!("from {} to {}", range.start(), range.end())))
}

fn place(what: &str, frame: u32, name: &str, place: [f64; 3]) -> Checked<DVec3> {
    match place.iter().all(|value| PLACE.contains(value)) {
        true => Ok(place.into()),
        false => Err(wrong(what, frame, name, DVec3::from(place), format!("within {}", PLACE.end()))),
    }
}

fn direction(what: &str, frame: u32, name: &str, vector: [f64; 3]) -> Checked<Direction> {
    let vector = place(what, frame, name, vector)?;
    Direction::new(vector).ok_or_else(|| wrong(what, frame, name, vector, "apart from zero"))
}

fn wrong(what: &str, frame: u32, name: &str, value: impl Display, allowed: impl Display) -> String {
    format!("{what}, frame {frame}: {name} is {value}, but must be {allowed}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_file_is_read() {
        let text = r#"{"smooth": true, "cuts": [5],
            "camera": [{"frame": 0, "eye": [0, 1, 5], "target": [0, 1, 0]},
                       {"frame": 5, "eye": [5, 1, 0], "target": [0, 0, 0], "fov": 60}],
            "light": [{"frame": 3, "direction": [0, 2, 0]}],
            "objects": {"tent": [{"frame": 1, "move": [0, 1, 0]}, {"frame": 2, "turn": -90, "axis": [3, 0, 0]}]}}"#;
        let file = parse(text, 30.0, DVec3::Z).expect("a file");
        assert!(file.smooth && file.cuts == [5]);
        let CameraMotion::Path { eye, target, fov } = file.camera else { panic!("a path") };
        assert_eq!(eye, [(0, DVec3::new(0.0, 1.0, 5.0)), (5, DVec3::new(5.0, 1.0, 0.0))]);
        assert_eq!((target[0], &fov[..]), ((0, DVec3::Y), &[(0, 30.0), (5, 60.0)][..]));
        let LightMotion::Path(light) = file.light else { panic!("a path") };
        assert_eq!(light[0].1.unit(), DVec3::Y);
        let [(name, ObjectMotion::Keys { turn, axis, way })] = &file.objects[..] else { panic!("one object") };
        assert_eq!((name.as_str(), &turn[..]), ("tent", &[(1, 0.0), (2, -90.0)][..]));
        assert_eq!(
            [axis[0].1.unit(), axis[1].1.unit(), way[0].1, way[1].1],
            [DVec3::Z, DVec3::X, DVec3::Y, DVec3::ZERO]
        );
    }

    #[test]
    fn what_is_wrong_is_told_with_place_and_value() {
        for (text, parts) in [
            (r#"{"camera": [{"frame": 5}, {"frame": 4}]}"#, vec!["camera must rise", "4 follows 5"]),
            (r#"{"light": [{"frame": 5}, {"frame": 5}]}"#, vec!["light must rise"]),
            (r#"{"cuts": [3, 3]}"#, vec!["cuts must rise"]),
            (r#"{"objects": {"x": [{"frame": 2}, {"frame": 1}]}}"#, vec!["object `x` must rise"]),
            (r#"{"objects": {"x": [{"frame": 2, "roll": 3}]}}"#, vec!["roll", "line 1"]),
            (r#"{"sound": 1}"#, vec!["sound"]),
            (r#"{"camera": [{"frame": -1}]}"#, vec!["-1"]),
            (r#"{"camera": [{"frame": 1, "orbit": 1e400}]}"#, vec!["out of range"]),
            (r#"{"camera": [{"frame": 1, "orbit": -2e9}]}"#, vec!["camera, frame 1: orbit is -2000000000"]),
            (r#"{"camera": [{"frame": 1, "distance": 0}]}"#, vec!["distance is 0", "0.001 to 1000"]),
            (r#"{"camera": [{"frame": 1, "eye": [0, 0, 0]}]}"#, vec!["frame 1", "eye and target"]),
            (r#"{"camera": [{"frame": 1, "fov": 20}]}"#, vec!["frame 1", "eye and target"]),
            (
                r#"{"camera": [{"frame": 1}, {"frame": 2, "eye": [0, 0, 1], "target": [0, 0, 0]}]}"#,
                vec!["frame 1", "eye and target"],
            ),
            (
                r#"{"camera": [{"frame": 1, "eye": [0, 0, 1], "target": [0, 0, 0], "orbit": 5}]}"#,
                vec!["frame 1", "neither orbit"],
            ),
            (r#"{"camera": [{"frame": 1, "eye": [0, 0, 1e15], "target": [0, 0, 0]}]}"#, vec!["eye is [0, 0, 1000"]),
            (r#"{"camera": [{"frame": 1, "eye": [0, 0, 1], "target": [0, 0]}]}"#, vec!["length 2"]),
            (
                r#"{"camera": [{"frame": 1, "eye": [0, 0, 1], "target": [0, 0, 0], "fov": 0.5}]}"#,
                vec!["fov is 0.5", "1 to 150"],
            ),
            (r#"{"light": [{"frame": 7, "direction": [0, 0, 0]}]}"#, vec!["frame 7", "direction", "zero"]),
            (r#"{"light": [{"frame": 7, "direction": [0, 1, 0], "orbit": 3}]}"#, vec!["frame 7", "no orbit"]),
            (
                r#"{"light": [{"frame": 7, "direction": [0, 1, 0]}, {"frame": 8, "direction": [0, -2, 0]}]}"#,
                vec!["direction is opposite at frames 7 and 8"],
            ),
            (r#"{"objects": {"x": [{"frame": 2, "axis": [0, 0, 0]}]}}"#, vec!["object `x`, frame 2: axis"]),
            (r#"{"objects": {"x": [{"frame": 2, "turn": 1e10}]}}"#, vec!["turn is 10000000000"]),
            (r#"{"objects": {"x": [{"frame": 2, "move": [-1e15, 0, 0]}]}}"#, vec!["move is [-1000"]),
        ] {
            let reason = parse(text, 30.0, DVec3::Y).expect_err(text);
            assert!(parts.iter().all(|part| reason.contains(part)), "{text}: {reason}");
        }
    }
}
