//! All that can be measured, by name: `frame/object/head/light-orbit/1920x1080`.

use crate::cli::compare::TECHNIQUES;
use crate::cli::failure::{Failure, Result};
use crate::cli::techniques::TechniqueName;
use crate::cli::values::Size;

/// What is painted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SceneName {
    /// The built-in head: one object.
    Head,
    /// The built-in teapot on a table: two objects, two paints.
    Teapot,
    /// Sixty-four objects, three paints.
    Many,
}

/// What moves from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionName {
    /// The light goes round.
    LightOrbit,
    /// The camera goes round.
    CameraOrbit,
    /// The camera comes closer and goes away again.
    Zoom,
    /// Every few frames the camera is elsewhere, and what remembers frames begins anew.
    Cut,
}

pub const SCENES: [SceneName; 3] = [SceneName::Head, SceneName::Teapot, SceneName::Many];
pub const MOTIONS: [MotionName; 4] =
    [MotionName::LightOrbit, MotionName::CameraOrbit, MotionName::Zoom, MotionName::Cut];
/// Sizes of frames.
pub const SIZES: [(u32, u32); 4] = [(512, 512), (1920, 1080), (2560, 1440), (3840, 2160)];
/// Sides of synthesised textures.
const SIDES: [u32; 4] = [256, 512, 1024, 2048];
/// Numbers of frames in flight.
const IN_FLIGHT: [u32; 3] = [1, 2, 3];

/// One thing that can be measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Case {
    /// Its name.
    pub id: String,
    /// What is done.
    pub work: Work,
    /// Size of picture or texture.
    pub size: Size,
}

/// What is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// All that a technique does once for a scene.
    Preparation(TechniqueName, SceneName),
    /// Its frames.
    Frame(TechniqueName, SceneName, MotionName),
    /// A texture, freely or by a guide.
    Synthesis { guided: bool },
    /// Image-based frames that are synthesised anew, so many in flight.
    Throughput { in_flight: u32 },
}

impl SceneName {
    /// As names of cases have it.
    pub fn name(self) -> &'static str {
        match self {
            SceneName::Head => "head",
            SceneName::Teapot => "teapot",
            SceneName::Many => "many",
        }
    }
}

impl MotionName {
    /// As names of cases have it.
    pub fn name(self) -> &'static str {
        match self {
            MotionName::LightOrbit => "light-orbit",
            MotionName::CameraOrbit => "camera-orbit",
            MotionName::Zoom => "zoom",
            MotionName::Cut => "cut",
        }
    }
}

/// As names of cases have it.
pub fn technique_name(technique: TechniqueName) -> String {
    format!("{technique:?}").to_lowercase()
}

impl Case {
    fn new(work: Work, (width, height): (u32, u32)) -> Self {
        let size = Size { width, height };
        let id = match work {
            Work::Preparation(technique, scene) => {
                format!("preparation/{}/{}/{size}", technique_name(technique), scene.name())
            }
            Work::Frame(technique, scene, motion) => {
                format!("frame/{}/{}/{}/{size}", technique_name(technique), scene.name(), motion.name())
            }
            Work::Synthesis { guided } => format!("synthesis/{}/{size}", if guided { "guided" } else { "free" }),
            Work::Throughput { in_flight } => format!("throughput/{in_flight}-in-flight/{size}"),
        };
        Case { id, work, size }
    }

    /// What it is called among the results: in a sustained run figures of frames are those of the slowest round, and
    /// not to be compared with those of all.
    pub fn id(&self, sustained: bool) -> String {
        match self.work {
            Work::Frame(..) if sustained => self.id.replacen("frame/", "sustained/", 1),
            _ => self.id.clone(),
        }
    }

    /// The technique, scene and size that must have been prepared for it, if any: one preparation serves all motions.
    pub fn prepared(&self) -> Option<(TechniqueName, SceneName, Size)> {
        match self.work {
            Work::Preparation(technique, scene) | Work::Frame(technique, scene, _) => {
                Some((technique, scene, self.size))
            }
            Work::Synthesis { .. } | Work::Throughput { .. } => None,
        }
    }

    fn is_quick(&self) -> bool {
        match self.work {
            Work::Preparation(..) => self.size.width == 512,
            Work::Frame(_, scene, motion) => {
                let most = match (self.size.width, scene) {
                    (512, SceneName::Head) => &MOTIONS[..],
                    (512, SceneName::Teapot) => &[MotionName::CameraOrbit, MotionName::Cut],
                    (512, SceneName::Many) | (1920, SceneName::Head) => &[MotionName::CameraOrbit],
                    _ => &[],
                };
                most.contains(&motion)
            }
            Work::Synthesis { .. } => matches!(self.size.width, 256 | 1024),
            Work::Throughput { .. } => true,
        }
    }
}

/// Everything, in the order in which it is measured: cases that share a preparation follow each other.
pub fn full() -> Vec<Case> {
    let mut cases = Vec::new();
    for side in SIDES {
        cases.extend([false, true].map(|guided| Case::new(Work::Synthesis { guided }, (side, side))));
    }
    for size in SIZES {
        for scene in SCENES {
            for technique in TECHNIQUES {
                cases.push(Case::new(Work::Preparation(technique, scene), size));
                cases.extend(MOTIONS.map(|motion| Case::new(Work::Frame(technique, scene, motion), size)));
            }
        }
    }
    cases.extend(IN_FLIGHT.map(|in_flight| Case::new(Work::Throughput { in_flight }, SIZES[0])));
    cases
}

/// A part of it that has every technique, scene and motion, in the same order.
pub fn quick() -> Vec<Case> {
    full().into_iter().filter(Case::is_quick).collect()
}

/// The case of that name or, if there is none, all that have `name` in theirs.
///
/// # Errors
/// None has; what there is.
pub fn named(name: &str) -> Result<Vec<Case>> {
    let all = full();
    if let Some(one) = all.iter().find(|case| case.id == name) {
        return Ok(vec![one.clone()]);
    }
    let found: Vec<Case> = all.into_iter().filter(|case| !name.is_empty() && case.id.contains(name)).collect();
    if found.is_empty() {
        return Err(Failure::new(format!("there is no scene `{name}`; {}; --list lists all names", forms())));
    }
    Ok(found)
}

/// How names are made.
fn forms() -> String {
    let any = |names: Vec<String>| names.join("|");
    let technique = any(TECHNIQUES.map(technique_name).to_vec());
    let scene = any(SCENES.map(|scene| scene.name().to_owned()).to_vec());
    let motion = any(MOTIONS.map(|motion| motion.name().to_owned()).to_vec());
    let size = any(SIZES.map(|(width, height)| format!("{width}x{height}")).to_vec());
    let side = any(SIDES.map(|side| format!("{side}x{side}")).to_vec());
    let number = any(IN_FLIGHT.map(|number| number.to_string()).to_vec());
    format!(
        "names are (parts of) frame/TECHNIQUE/SCENE/MOTION/SIZE, preparation/TECHNIQUE/SCENE/SIZE, \
         synthesis/free|guided/{side} and throughput/{number}-in-flight/{}x{}, where TECHNIQUE is {technique}, SCENE \
         {scene}, MOTION {motion} and SIZE {size}",
        SIZES[0].0, SIZES[0].1
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn ids(cases: &[Case]) -> BTreeSet<&str> {
        cases.iter().map(|case| case.id.as_str()).collect()
    }

    #[test]
    fn the_full_set_is_all_of_it_and_names_are_unique() {
        let all = full();
        assert_eq!(ids(&all).len(), all.len());
        let count = |of: fn(&Work) -> bool| all.iter().filter(|case| of(&case.work)).count();
        assert_eq!(count(|work| matches!(work, Work::Frame(..))), 4 * 3 * 4 * 4);
        assert_eq!(count(|work| matches!(work, Work::Preparation(..))), 4 * 3 * 4);
        assert_eq!(count(|work| matches!(work, Work::Synthesis { .. })), 2 * 4);
        assert_eq!(count(|work| matches!(work, Work::Throughput { .. })), 3);
    }

    #[test]
    fn the_quick_set_is_a_part_of_it_with_every_technique_scene_and_motion() {
        let quick = quick();
        let all = full();
        assert!(ids(&quick).is_subset(&ids(&all)) && quick.len() < all.len());
        for technique in TECHNIQUES {
            let has = |scene, motion| quick.iter().any(|case| case.work == Work::Frame(technique, scene, motion));
            for scene in SCENES {
                assert!(MOTIONS.iter().any(|motion| has(scene, *motion)));
                assert!(quick.iter().any(|case| case.work == Work::Preparation(technique, scene)));
            }
            assert!(MOTIONS.iter().all(|motion| SCENES.iter().any(|scene| has(*scene, *motion))));
        }
    }

    #[test]
    fn what_shares_a_preparation_lies_together_and_begins_with_it() {
        for cases in [full(), quick()] {
            let mut seen: Vec<_> = cases.iter().filter_map(Case::prepared).collect();
            seen.dedup();
            for (number, one) in seen.iter().enumerate() {
                assert!(!seen[..number].contains(one), "{one:?} is prepared twice");
            }
        }
    }

    #[test]
    fn a_case_is_found_by_its_name_or_a_part_of_it() {
        let one = named("frame/aligned/many/zoom/2560x1440").expect("it is there");
        assert_eq!(one.iter().map(|case| case.id.as_str()).collect::<Vec<_>>(), ["frame/aligned/many/zoom/2560x1440"]);
        assert_eq!(named("many/zoom/512x512").expect("they are there").len(), 4);
        for wrong in ["heads", "", "frame/object/head/light-orbit/640x480"] {
            let told = named(wrong).expect_err("there is none").0;
            assert!(told.contains(&format!("`{wrong}`")) && told.contains("object|image|aligned|dependent"), "{told}");
        }
    }
}
