//! Whether what a device computes is right.
//!
//! What a round leaves must be the bytes of the first round. A synthesis must be the bytes of the CPU oracle, where that
//! is quick enough to be run too, and those of the run's first device. Frames of different devices need not agree to
//! the bit, since Vulkan leaves a driver some room at outlines (a pixel of the guide that rounds the other way may lead
//! to another block): they must look like those of the run's first device.

use super::results::Check;
use crate::cli::techniques::TechniqueName;
use std::collections::HashMap;

/// By so much a channel of a pixel may differ before the pixel counts as another.
const CHANNEL: u8 = 4;
/// Frames with no more pixels than this are kept, to compare those of further devices with.
pub const KEPT_PX: u32 = 512 * 512;

/// The share of the painted pixels that may be others than those of another device: somewhat more than the tests of
/// golden pictures allow, because sequences carry a difference on.
pub fn share_allowed(technique: TechniqueName) -> f64 {
    match technique {
        TechniqueName::Object => 0.03,
        TechniqueName::Aligned => 0.03,
        TechniqueName::Dependent => 0.1,
        TechniqueName::Image => 0.25,
    }
}

/// The 64-bit FNV-1a hash, in hexadecimal: the same on every machine and in every version of the program.
pub fn hash(bytes: &[u8]) -> String {
    let hash = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

/// What came out of the rounds of one measurement, and what is wrong with it.
#[derive(Default)]
pub struct Outcome {
    bytes: Option<Vec<u8>>,
    rounds: u32,
    wrong: Vec<String>,
}

impl Outcome {
    /// Takes what a round has left.
    pub fn round(&mut self, bytes: Vec<u8>) {
        self.rounds += 1;
        match &self.bytes {
            None => self.bytes = Some(bytes),
            Some(first) if *first != bytes => {
                self.wrong.push(format!("round {} gave other bytes than the first", self.rounds));
            }
            Some(_) => {}
        }
    }

    fn bytes(&self) -> &[u8] {
        self.bytes.as_deref().unwrap_or_default()
    }

    /// It must have this hash; `whose` says why.
    pub fn must_be(&mut self, expected: &str, whose: &str) {
        let own = hash(self.bytes());
        if own != expected {
            self.wrong.push(format!("other bytes than {whose}: hash {own}, not {expected}"));
        }
    }

    /// It must look like this picture of RGBA texels, all but a share of the pixels that either has painted.
    pub fn must_look_like(&mut self, expected: &[u8], whose: &str, share: f64) {
        let own = self.bytes();
        if own.len() != expected.len() {
            self.wrong.push(format!("another size than {whose}: {} bytes, not {}", own.len(), expected.len()));
            return;
        }
        let pairs = || own.chunks_exact(4).zip(expected.chunks_exact(4)).filter(|(a, b)| a[3] != 0 || b[3] != 0);
        let others = pairs().filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > CHANNEL)).count();
        let off = others as f64 / pairs().count().max(1) as f64;
        if off > share {
            let (off, share) = (100.0 * off, 100.0 * share);
            self.wrong.push(format!(
                "{off:.1} % of the painted pixels differ by more than {CHANNEL} of 255 from {whose}, {share:.0} % may"
            ));
        }
    }

    /// The hash, and `ok` or all that is wrong.
    pub fn check(&self) -> Check {
        let verdict = if self.wrong.is_empty() { "ok".to_owned() } else { self.wrong.join("; ") };
        Check { hash: hash(self.bytes()), verdict }
    }
}

/// What the first device of a run gave, by the names of measurements.
#[derive(Default)]
pub struct References(HashMap<String, Reference>);

struct Reference {
    device: String,
    hash: String,
    /// Where it is kept.
    picture: Option<Vec<u8>>,
}

impl References {
    /// Compares what a device gave with what the first one did or, if this is the first, remembers it: the bytes of
    /// small pictures, and the hash of everything. `share` is that of pixels that may differ, `None` if no byte may.
    pub fn compare(&mut self, id: &str, device: &str, outcome: &mut Outcome, share: Option<f64>) {
        let Some(first) = self.0.get(id) else {
            let bytes = outcome.bytes();
            let small = bytes.len() <= 4 * KEPT_PX as usize;
            let picture = (share.is_some() && small).then(|| bytes.to_vec());
            let reference = Reference { device: device.to_owned(), hash: hash(bytes), picture };
            self.0.insert(id.to_owned(), reference);
            return;
        };
        let whose = format!("those of {}", first.device);
        match (share, &first.picture) {
            (None, _) => outcome.must_be(&first.hash, &whose),
            (Some(share), Some(picture)) => outcome.must_look_like(picture, &whose, share),
            (Some(_), None) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bytes: &[u8]) -> Outcome {
        let mut outcome = Outcome::default();
        outcome.round(bytes.to_vec());
        outcome
    }

    /// Vectors of the hash's authors.
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(hash(b""), "cbf29ce484222325");
        assert_eq!(hash(b"a"), "af63dc4c8601ec8c");
        assert_eq!(hash(b"foobar"), "85944171f73967e8");
    }

    #[test]
    fn a_round_that_gives_other_bytes_is_wrong_and_named() {
        let mut outcome = of(&[1, 2]);
        outcome.round(vec![1, 2]);
        assert!(outcome.check().is_ok());
        outcome.round(vec![1, 3]);
        outcome.round(vec![1, 2]);
        assert_eq!(outcome.check().verdict, "round 3 gave other bytes than the first");
        assert_eq!(outcome.check().hash, hash(&[1, 2]));
    }

    #[test]
    fn other_bytes_than_the_oracle_are_wrong() {
        let mut outcome = of(b"foobar");
        outcome.must_be("85944171f73967e8", "the CPU oracle's");
        assert!(outcome.check().is_ok());
        outcome.must_be("af63dc4c8601ec8c", "the CPU oracle's");
        let expected = "other bytes than the CPU oracle's: hash 85944171f73967e8, not af63dc4c8601ec8c";
        assert_eq!(outcome.check().verdict, expected);
    }

    #[test]
    fn pictures_may_differ_in_a_share_of_the_painted_pixels() {
        // Ten painted pixels among twenty.
        let picture: Vec<u8> = [100, 100, 100, 255].repeat(10).into_iter().chain([0; 40]).collect();
        let with = |others: usize, by: u8| {
            let mut other = picture.clone();
            (0..others).for_each(|pixel| other[4 * pixel + 1] += by);
            let mut outcome = of(&other);
            outcome.must_look_like(&picture, "those of A", 0.2);
            outcome.check().verdict
        };
        assert_eq!((with(0, 0), with(10, CHANNEL), with(2, 50)), ("ok".into(), "ok".into(), "ok".into()));
        let told = with(3, CHANNEL + 1);
        assert!(told.starts_with("30.0 % of the painted pixels") && told.contains("those of A, 20 % may"), "{told}");
        let mut shorter = of(&picture[4..]);
        shorter.must_look_like(&picture, "those of A", 1.0);
        assert!(!shorter.check().is_ok());
    }

    #[test]
    fn further_devices_are_compared_with_the_first() {
        let mut references = References::default();
        let mut compare = |device: &str, bytes: &[u8], share| {
            let mut outcome = of(bytes);
            references.compare("synthesis", device, &mut outcome, share);
            references.compare("frame", device, &mut outcome, share);
            outcome.check().verdict
        };
        assert_eq!(compare("A", &[1, 2, 3, 255], Some(0.0)), "ok");
        assert_eq!(compare("B", &[1, 2, 3, 255], None), "ok");
        assert_eq!(compare("B", &[2, 2, 3, 255], Some(0.0)), "ok");
        assert!(compare("C", &[2, 2, 3, 255], None).contains("other bytes than those of A"));
        assert!(compare("C", &[9, 2, 3, 255], Some(0.0)).contains("from those of A"));
    }
}
