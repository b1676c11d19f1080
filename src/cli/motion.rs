//! What moves from frame to frame: flags for the common cases, a file for the rest
//! ([`motion_file`](super::motion_file)).

use super::failure::{Failure, Result};
use super::frames::Frames;
use super::keyframes::{between, of_shot, Direction, Key, Value};
use super::motion_file::{self, MotionFile, DISTANCE, FOV};
use super::report::number;
use super::session::Session;
use super::shot::Shot;
use super::values::finite;
use clap::Args;
use glam::{DQuat, DVec3};
use impasto::scene::{Camera, DirectionalLight, Lights, Mesh, Moment, Pose, Vec3};
use std::path::PathBuf;

/// What stands for every object that does not move by itself.
const ALL: &str = "all";
/// A camera that turns by more than this from one frame to the next, in degrees, shows another picture.
const CUT_TURN_DEG: f32 = 15.0;
/// So does one that moves by more than this part of its distance to what it looks at.
const CUT_WAY: f32 = 0.5;
/// And one whose distance becomes so many times as large or as small.
const CUT_ZOOM: f32 = 1.5;

/// How camera, lights and objects move.
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
    /// By how many degrees an object (its name, or its index from 0) turns from frame to frame, about the vertical line
    /// through its middle; `all` turns all others, about that through the model's middle. May be repeated
    #[arg(long, value_name = "OBJECT=DEGREES", value_parser = turn)]
    turn: Vec<(String, f32)>,
    /// Keyframes of camera, light and objects, and cuts, JSON: {"camera": [{"frame": 0, "orbit": 0, "distance": 1},
    /// ...], "light": [{"frame": 0, "orbit": 0}, ...], "objects": {"NAME": [{"frame": 0, "turn": 0}, ...]}}, degrees
    /// and multiples of the first distance, linear in between; for paths, smooth ways and cuts see the README
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["orbit", "zoom", "light_orbit", "turn"])]
    motion: Option<PathBuf>,
}

/// The motion, ready to be asked.
pub struct Motion {
    /// Camera and lights as the flags have them: what orbits, and multiples of distances, count from.
    first: Camera,
    lights: Lights,
    /// What is up: what the camera goes around, and objects turn about.
    axis: Vec3,
    camera: CameraMotion,
    light: LightMotion,
    objects: Vec<Moved>,
    /// For each object of the mesh, which of these moves it.
    of_object: Vec<Option<usize>>,
    smooth: bool,
    cuts: Vec<u32>,
}

/// How the camera moves.
#[derive(Debug)]
pub enum CameraMotion {
    /// Degrees around the target, and what the distance is multiplied by, per frame.
    Steady { orbit: f32, zoom: f32 },
    /// The same in all.
    Orbit { orbit: Vec<Key<f64>>, distance: Vec<Key<f64>> },
    /// Where it stands and what it looks at, in world space, and its field of view in degrees.
    Path { eye: Vec<Key<DVec3>>, target: Vec<Key<DVec3>>, fov: Vec<Key<f64>> },
}

/// How the lights move.
#[derive(Debug)]
pub enum LightMotion {
    /// Degrees around the y axis, per frame.
    Steady(f32),
    /// The same in all.
    Orbit(Vec<Key<f64>>),
    /// Where the only light comes from.
    Path(Vec<Key<Direction>>),
}

/// How an object moves.
#[derive(Debug)]
pub enum ObjectMotion {
    /// Degrees about the vertical axis, per frame.
    Steady(f32),
    /// Degrees about an axis, and how far it is moved after that.
    Keys { turn: Vec<Key<f64>>, axis: Vec<Key<Direction>>, way: Vec<Key<DVec3>> },
}

/// What moves together, and the point that it turns about.
struct Moved {
    center: Vec3,
    motion: ObjectMotion,
}

impl MotionFlags {
    /// The motion over `frames` of a shot whose camera goes around `axis`. Adds the flags to the report.
    pub fn load(&self, shot: &Shot, axis: Vec3, frames: Frames, session: &mut Session) -> Result<Motion> {
        if !(0.5..=2.0).contains(&self.zoom) {
            return Err(Failure::new(format!("--zoom is {}, but must be from 0.5 to 2", self.zoom)));
        }
        session.parameter("orbit", number(self.orbit));
        session.parameter("zoom", number(self.zoom));
        session.parameter("light_orbit", number(self.light_orbit));
        session.parameter("turn", self.turn.iter().map(|(name, by)| format!("{name}={by}")).collect::<Vec<_>>());
        session.parameter("motion", self.motion.as_ref().map(|path| path.display().to_string()));
        let (file, about) = match &self.motion {
            Some(path) => {
                let (file, content) = motion_file::read(path, shot.camera.fov_y_deg(), axis.as_dvec3())?;
                session.parameter("keyframes", content);
                (file, format!("{}: ", path.display()))
            }
            None => (self.steady(), String::new()),
        };
        let motion = Motion::new(file, &shot.mesh, shot.camera, &shot.lights, axis);
        motion.and_then(|motion| motion.checked(frames)).map_err(|failure| Failure(about + &failure.0))
    }

    /// What the flags say, as a file would.
    fn steady(&self) -> MotionFile {
        MotionFile {
            camera: CameraMotion::Steady { orbit: self.orbit, zoom: self.zoom },
            light: LightMotion::Steady(self.light_orbit),
            objects: self.turn.iter().map(|(name, by)| (name.clone(), ObjectMotion::Steady(*by))).collect(),
            smooth: false,
            cuts: Vec::new(),
        }
    }
}

impl Motion {
    /// The motion of a mesh that is first seen through `camera` in `lights`; the camera goes around `axis`.
    fn new(file: MotionFile, mesh: &Mesh, camera: Camera, lights: &Lights, axis: Vec3) -> Result<Self> {
        let MotionFile { camera: camera_motion, light, objects, smooth, cuts } = file;
        let count = lights.as_slice().len();
        if matches!(light, LightMotion::Path(_)) && count > 1 {
            return Err(Failure::new(format!("light: a path of directions is for a single --light, not for {count}")));
        }
        let (objects, of_object) = assign(objects, mesh)?;
        let lights = lights.clone();
        Ok(Motion { first: camera, lights, axis, camera: camera_motion, light, objects, of_object, smooth, cuts })
    }

    /// The motion, if there is a camera at every frame: better found out now than after hours of work. What objects do
    /// is within bounds already.
    fn checked(self, frames: Frames) -> Result<Self> {
        for frame in frames.first..=frames.last {
            let found = self.camera(frame).and_then(|_| self.lights(frame));
            found.map_err(|error| Failure::new(format!("frame {frame}: {error}")))?;
        }
        Ok(self)
    }

    /// A frame's camera, lights and objects. They depend on nothing but its number.
    pub fn at(&self, frame: u32, mesh: &Mesh) -> Result<Moment> {
        let moment = Moment { camera: self.camera(frame)?, lights: self.lights(frame)?, poses: self.poses(frame)? };
        Ok(moment.fit_depth(mesh))
    }

    /// What a frame shows that is to be reached from another, no further than to the next cut: the last frame before
    /// it.
    pub fn ahead(&self, from: u32, to: u32, mesh: &Mesh) -> Result<Moment> {
        let cut = (from + 1..=to).find(|&frame| self.is_cut(frame));
        self.at(cut.map_or(to, |cut| cut - 1), mesh)
    }

    /// Whether the camera jumps between the frame before and this one: by a cut of the file, or because it moves so far
    /// that little of the one picture is in the other.
    pub fn is_cut(&self, frame: u32) -> bool {
        let Some(before) = frame.checked_sub(1) else { return false };
        let jumps = match (self.camera(before), self.camera(frame)) {
            (Ok(from), Ok(to)) => jumps(&from, &to),
            _ => false,
        };
        jumps || self.cuts.binary_search(&frame).is_ok()
    }

    /// The camera; its near and far planes are left to [`Moment::fit_depth`].
    fn camera(&self, frame: u32) -> impasto::Result<Camera> {
        let (orbit, distance) = match &self.camera {
            CameraMotion::Steady { orbit, zoom } => (by(*orbit, frame), f64::from(*zoom).powf(f64::from(frame))),
            CameraMotion::Orbit { orbit, distance } => {
                let distance = self.in_shot(distance, frame).unwrap_or(1.0);
                // A smooth way may lead beyond its keys.
                (self.in_shot(orbit, frame).unwrap_or(0.0), distance.clamp(*DISTANCE.start(), *DISTANCE.end()))
            }
            CameraMotion::Path { eye, target, fov } => {
                let point = |keys: &[Key<DVec3>]| self.in_shot(keys, frame).unwrap_or_default().as_vec3();
                let fov = self.in_shot(fov, frame).unwrap_or(self.first.fov_y_deg().into());
                // An upright camera may look along the vertical; who says what is up is taken at their word.
                let up = (self.axis != Vec3::Y).then_some(self.axis);
                let fov = fov.clamp(*FOV.start(), *FOV.end()) as f32;
                return Camera::look_at(point(eye), point(target), up, fov);
            }
        };
        self.first.orbited(within_a_turn(orbit), self.axis)?.moved_away(distance as f32)
    }

    fn lights(&self, frame: u32) -> impasto::Result<Lights> {
        let orbit = match &self.light {
            LightMotion::Steady(degrees) => by(*degrees, frame),
            LightMotion::Orbit(keys) => between(keys, self.smooth, frame).unwrap_or(0.0),
            LightMotion::Path(keys) => {
                let to = between(keys, self.smooth, frame).map(|direction| direction.unit().as_vec3());
                return self.lights_from(|direction| to.unwrap_or(direction));
            }
        };
        let turn = DQuat::from_rotation_y(orbit.to_radians());
        self.lights_from(|direction| (turn * direction.as_dvec3()).as_vec3())
    }

    /// The lights from other directions.
    fn lights_from(&self, to: impl Fn(Vec3) -> Vec3) -> impasto::Result<Lights> {
        let light = |light: &DirectionalLight| DirectionalLight::new(to(light.direction()), light.intensity());
        Lights::new(self.lights.as_slice().iter().map(light).collect::<impasto::Result<Vec<_>>>()?)
    }

    fn poses(&self, frame: u32) -> impasto::Result<Vec<Pose>> {
        let poses = self.objects.iter().map(|object| self.pose(object, frame)).collect::<impasto::Result<Vec<_>>>()?;
        Ok(self.of_object.iter().map(|moved| moved.map_or(Pose::REST, |index| poses[index])).collect())
    }

    fn pose(&self, object: &Moved, frame: u32) -> impasto::Result<Pose> {
        let (degrees, axis, way) = match &object.motion {
            ObjectMotion::Steady(degrees) => (by(*degrees, frame), self.axis, Vec3::ZERO),
            ObjectMotion::Keys { turn, axis, way } => (
                between(turn, self.smooth, frame).unwrap_or(0.0),
                between(axis, self.smooth, frame).map_or(self.axis, |axis| axis.unit().as_vec3()),
                between(way, self.smooth, frame).unwrap_or_default().as_vec3(),
            ),
        };
        Pose::new(within_a_turn(degrees), axis, object.center, way)
    }

    /// What keys of the camera have at a frame; no way leads across a cut.
    fn in_shot<T: Value>(&self, keys: &[Key<T>], frame: u32) -> Option<T> {
        between(of_shot(keys, &self.cuts, frame), self.smooth, frame)
    }
}

/// So many degrees per frame, at a frame.
fn by(degrees: f32, frame: u32) -> f64 {
    f64::from(degrees) * f64::from(frame)
}

/// An angle, without whole turns, of which single precision would keep too little.
fn within_a_turn(degrees: f64) -> f32 {
    (degrees % 360.0) as f32
}

/// Whether little of what one camera shows is in the picture of the next.
fn jumps(from: &Camera, to: &Camera) -> bool {
    let distance = |camera: &Camera| camera.eye().distance(camera.target());
    let zoom = distance(to) / distance(from);
    from.forward().dot(to.forward()) < CUT_TURN_DEG.to_radians().cos()
        || from.eye().distance(to.eye()) > CUT_WAY * distance(from)
        || !(1.0 / CUT_ZOOM..=CUT_ZOOM).contains(&zoom)
}

/// Finds the objects that move, and the points that they turn about.
fn assign(given: Vec<(String, ObjectMotion)>, mesh: &Mesh) -> Result<(Vec<Moved>, Vec<Option<usize>>)> {
    let mut of_object = vec![None; mesh.objects().len()];
    let (mut moved, mut all) = (Vec::with_capacity(given.len()), None);
    for (name, motion) in given {
        let (place, indices) = if name == ALL {
            (&mut all, mesh.indices())
        } else {
            let wrong = |error| Failure::new(format!("an object that moves: {}", Failure::from(error).0));
            let index = mesh.object_index(&name).map_err(wrong)?;
            let object = &mesh.objects()[index];
            let (first, count) = (object.first_index as usize, object.index_count as usize);
            (&mut of_object[index], &mesh.indices()[first..first + count])
        };
        if place.replace(moved.len()).is_some() {
            return Err(Failure::new(format!("an object that moves: `{name}` is given twice")));
        }
        moved.push(Moved { center: middle(mesh, indices), motion });
    }
    let of_object = if moved.is_empty() { Vec::new() } else { of_object };
    Ok((moved, of_object.into_iter().map(|own: Option<usize>| own.or(all)).collect()))
}

/// The middle of the bounding box of some of a mesh's vertices; of an object that has none there is nothing to turn.
fn middle(mesh: &Mesh, indices: &[u32]) -> Vec3 {
    let mut points = indices.iter().map(|&index| Vec3::from(mesh.positions()[index as usize]).as_dvec3());
    let Some(first) = points.next() else { return Vec3::ZERO };
    let (low, high) = points.fold((first, first), |(low, high), point| (low.min(point), high.max(point)));
    ((low + high) / 2.0).as_vec3()
}

/// Reads `OBJECT=DEGREES`. The name may contain an equals sign.
fn turn(text: &str) -> std::result::Result<(String, f32), String> {
    let wrong = || format!("must be OBJECT=DEGREES, like head=5, or {ALL}=5");
    let (name, degrees) = text.rsplit_once('=').ok_or_else(wrong)?;
    Ok((name.to_owned(), finite(degrees).map_err(|_| wrong())?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use impasto::scene::MeshOptions;

    /// Three objects: `a` around (1, 0, 0), `b` around (0, 5, 0), and `c`.
    fn mesh() -> Mesh {
        let object = |name: &str, [x, y, z]: [i32; 3], first: i32| {
            format!(
                "o {name}\nv {} {} {z}\nv {} {} {z}\nv {x} {} {z}\nf {first} {} {}\n",
                x - 1,
                y - 1,
                x + 1,
                y - 1,
                y + 1,
                first + 1,
                first + 2
            )
        };
        let text = object("a", [1, 0, 0], 1) + &object("b", [0, 5, 0], 4) + &object("c", [-2, 0, 8], 7);
        Mesh::parse(text.as_bytes(), "three.obj", &MeshOptions::default()).expect("a mesh").mesh
    }

    fn camera() -> Camera {
        Camera::look_at(Vec3::new(0.0, 0.0, 10.0), Vec3::ZERO, None, 30.0).expect("a camera")
    }

    fn of(file: MotionFile) -> Result<Motion> {
        let motion = Motion::new(file, &mesh(), camera(), &Lights::default(), Vec3::Y)?;
        motion.checked(Frames { first: 0, last: 50 })
    }

    fn of_text(text: &str) -> Result<Motion> {
        of(motion_file::parse(text, 30.0, DVec3::Y).map_err(Failure)?)
    }

    fn at(motion: &Motion, frame: u32) -> Moment {
        motion.at(frame, &mesh()).expect("a moment")
    }

    fn flags(turn: &[(&str, f32)]) -> MotionFlags {
        let turn = turn.iter().map(|&(name, by)| (name.to_owned(), by)).collect();
        MotionFlags { orbit: 0.0, zoom: 1.0, light_orbit: 0.0, turn, motion: None }
    }

    /// Where a pose takes a point.
    fn taken(pose: Pose, point: [f64; 3]) -> DVec3 {
        pose.matrix().transform_point3(point.into())
    }

    #[test]
    fn flags_turn_objects_about_their_own_middle_and_all_others_about_the_models() {
        let motion = of(flags(&[("a", 45.0), ("all", 1.0), ("2", 0.0)]).steady()).expect("a motion");
        let moment = at(&motion, 2);
        assert_eq!(moment.poses.len(), 3);
        // A quarter turn about the vertical line through (1, 0, 0).
        assert!((taken(moment.poses[0], [2.0, 3.0, 0.0]) - DVec3::new(1.0, 3.0, -1.0)).length() < 1e-6);
        let way = Pose::new(2.0, Vec3::Y, Vec3::new(-0.5, 2.5, 4.0), Vec3::ZERO).expect("a pose");
        assert_eq!(moment.poses[1], way);
        assert_eq!(moment.poses[2], Pose::REST);
        assert!(at(&of(flags(&[]).steady()).expect("a motion"), 5).poses.is_empty());
        // Whole turns lose no precision.
        let turns = of(flags(&[("a", 36.5)]).steady()).expect("a motion");
        assert_eq!(at(&turns, 720_001).poses, at(&turns, 1).poses);
    }

    #[test]
    fn objects_follow_their_keys() {
        let motion = of_text(
            r#"{"objects": {"a": [{"frame": 0}, {"frame": 10, "turn": 180, "move": [0, 0, 20]}],
                            "1": [{"frame": 0, "axis": [0, 0, 1]}, {"frame": 10, "axis": [2, 0, 0], "turn": 180}]}}"#,
        )
        .expect("a motion");
        let moment = at(&motion, 5);
        assert!((taken(moment.poses[0], [2.0, 3.0, 0.0]) - DVec3::new(1.0, 3.0, 9.0)).length() < 1e-6);
        // A quarter turn about the line between z and x.
        let to = taken(moment.poses[1], [0.0, 6.0, 0.0]) - DVec3::new(0.0, 5.0, 0.0);
        assert!((to - DVec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-6, "{to}");
        assert_eq!(moment.poses[2], Pose::REST);
        // What has moved towards the camera is not cut off, and what is there is not behind the far plane.
        let camera = at(&motion, 2).camera;
        assert!(camera.near() < 2.0 && camera.far() > 10.0, "{} {}", camera.near(), camera.far());
    }

    #[test]
    fn a_path_leads_through_its_keys_straight_or_smooth() {
        let text = |smooth: bool| {
            format!(
                r#"{{"smooth": {smooth}, "camera": [
                {{"frame": 0, "eye": [0, 0, 9], "target": [0, 0, 0]}},
                {{"frame": 10, "eye": [4, 0, 8], "target": [0, 1, 0], "fov": 50}},
                {{"frame": 20, "eye": [8, 6, 0], "target": [0, 2, 0]}}],
                "light": [{{"frame": 0, "direction": [0, 0, 1]}}, {{"frame": 20, "direction": [1, 0, 0]}}]}}"#
            )
        };
        let (straight, smooth) = (of_text(&text(false)).expect("a motion"), of_text(&text(true)).expect("a motion"));
        for (frame, eye, fov) in [(0, [0.0, 0.0, 9.0], 30.0), (10, [4.0, 0.0, 8.0], 50.0), (99, [8.0, 6.0, 0.0], 30.0)]
        {
            for motion in [&straight, &smooth] {
                let camera = at(motion, frame).camera;
                assert_eq!((camera.eye(), camera.fov_y_deg()), (Vec3::from(eye), fov), "{frame}");
            }
        }
        let (a, b) = (at(&straight, 15), at(&smooth, 15));
        assert_eq!((a.camera.eye(), a.camera.target()), (Vec3::new(6.0, 3.0, 4.0), Vec3::new(0.0, 1.5, 0.0)));
        assert!(a.camera.eye().distance(b.camera.eye()) > 0.1, "{}", b.camera.eye());
        let light = at(&straight, 10).lights.as_slice()[0].direction();
        assert!((light - Vec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-6, "{light}");
    }

    #[test]
    fn nothing_leads_across_a_cut_and_only_there_is_one() {
        let keys =
            r#"[{"frame": 0}, {"frame": 10, "orbit": 10}, {"frame": 20, "orbit": 12}, {"frame": 30, "orbit": 22}]"#;
        let with = |rest: &str| of_text(&format!(r#"{{"camera": {keys}{rest}}}"#)).expect("a motion");
        let motion = with(r#", "cuts": [15]"#);
        let at_orbit = |frame: u32, orbit: f32| {
            let expected = camera().orbited(orbit, Vec3::Y).expect("a camera").eye();
            let eye = at(&motion, frame).camera.eye();
            assert!(eye.distance(expected) < 1e-5, "frame {frame}: {eye}, not {expected}");
        };
        at_orbit(5, 5.0);
        at_orbit(14, 10.0);
        at_orbit(15, 12.0);
        at_orbit(25, 17.0);
        let cuts = |motion: &Motion| (0..40).filter(|&frame| motion.is_cut(frame)).collect::<Vec<_>>();
        assert_eq!(cuts(&motion), [15]);
        assert!(cuts(&with("")).is_empty());
    }

    #[test]
    fn a_camera_that_jumps_is_a_cut_without_a_word() {
        let between = |first: &str, second: &str| {
            let text = format!(r#"{{"camera": [{{"frame": 4, {first}}}, {{"frame": 5, {second}}}]}}"#);
            let motion = of_text(&text).expect("a motion");
            (0..10).filter(|&frame| motion.is_cut(frame)).collect::<Vec<_>>()
        };
        let path = |eye: &str, target: &str| format!(r#""eye": {eye}, "target": {target}"#);
        let first = path("[0, 0, 10]", "[0, 0, 0]");
        assert_eq!(between(r#""orbit": 0"#, r#""orbit": 16"#), [5]);
        assert!(between(r#""orbit": 0"#, r#""orbit": 14"#).is_empty());
        assert_eq!(between(r#""distance": 1"#, r#""distance": 0.6"#), [5]);
        assert!(between(r#""distance": 1"#, r#""distance": 0.7"#).is_empty());
        assert_eq!(between(&first, &path("[6, 0, 10]", "[6, 0, 0]")), [5], "to the side");
        assert!(between(&first, &path("[4, 0, 10]", "[4, 0, 0]")).is_empty());
        assert_eq!(between(&first, &path("[0, 0, 10]", "[0, 3, 0]")), [5], "looks up");
        assert!(of(MotionFlags { orbit: 20.0, ..flags(&[]) }.steady()).expect("a motion").is_cut(1));
    }

    #[test]
    fn what_does_not_fit_the_scene_is_told() {
        let path = r#"{"camera": [{"frame": 0, "eye": [0, 0, 4], "target": [0, 0, 0]},
                                  {"frame": 8, "eye": [0, 0, -4], "target": [0, 0, 0]}]}"#;
        for (motion, parts) in [
            (of_text(path), vec!["frame 4", "target", "apart from the eye"]),
            (of_text(r#"{"objects": {"roof": []}}"#), vec!["`a`, `b`, `c`", "roof"]),
            (of_text(r#"{"objects": {"a": [], "0": []}}"#), vec!["`a` is given twice"]),
            (of(flags(&[("all", 1.0), ("all", 2.0)]).steady()), vec!["`all` is given twice"]),
            (of(MotionFlags { zoom: 0.5, ..flags(&[]) }.steady()), vec!["frame 44", "apart from the eye"]),
        ] {
            let failure = motion.err().expect("a failure");
            assert!(parts.iter().all(|part| failure.0.contains(part)), "{}", failure.0);
        }
        let file = motion_file::parse(r#"{"light": [{"frame": 0, "direction": [0, 1, 0]}]}"#, 30.0, DVec3::Y);
        let light = DirectionalLight::new(Vec3::Y, 1.0).expect("a light");
        let two = Lights::new([light, light]).expect("lights");
        let failure = Motion::new(file.expect("a file"), &mesh(), camera(), &two, Vec3::Y).err().expect("a failure");
        assert!(failure.0.contains("single --light, not for 2"), "{}", failure.0);
    }

    #[test]
    fn turns_are_read() {
        assert_eq!(turn("a=b=-1.5"), Ok(("a=b".to_owned(), -1.5)));
        for wrong in ["5", "a=", "a=x", "a=inf"] {
            assert!(turn(wrong).expect_err(wrong).contains("OBJECT=DEGREES"), "{wrong}");
        }
    }
}
