//! Whether what a device computes is right.
//!
//! What a round leaves must be the bytes of the first round. A synthesis must be the bytes of the CPU oracle, where that
//! is quick enough to be run too, and those of the run's first device. Frames of different devices need not agree to
//! the bit, since Vulkan leaves a driver some room at outlines (a pixel of the guide that rounds the other way may lead
//! to another block): they must look like those of the run's first device.

use super::results::Check;
use crate::cli::techniques::TechniqueName;
use crate::cli::values::Size;
use std::collections::HashMap;

/// By so much a channel of a pixel may differ before the pixel counts as another.
const CHANNEL: u8 = 4;
/// So many pixels of a frame are kept, to compare those of further devices with.
const KEPT_PX: usize = 512 * 512;
/// Of a picture, at least this part is painted.
const PAINTED: f64 = 0.01;

/// The share of the painted pixels that may be others than those of another device: somewhat more than the tests of
/// golden pictures allow, because sequences carry a difference on. Image-based, another block means others after it,
/// the more the larger a frame is: beyond 512x512 nothing is said.
pub fn share_allowed(technique: TechniqueName, size: Size) -> f64 {
    match technique {
        TechniqueName::Object => 0.03,
        TechniqueName::Aligned => 0.03,
        TechniqueName::Dependent => 0.1,
        TechniqueName::Image if size.width as usize * size.height as usize <= KEPT_PX => 0.25,
        TechniqueName::Image => 1.0,
    }
}

/// Every so manyth of some texels, so that about [`KEPT_PX`] are left; an odd number, which wanders over the columns.
fn thinned(texels: &[u8]) -> Vec<u8> {
    let step = (texels.len() / 4).div_ceil(KEPT_PX) | 1;
    texels.chunks_exact(4).step_by(step).flatten().copied().collect()
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

    /// It must be a picture of RGBA texels with something in it: a device that draws nothing is quick.
    pub fn must_be_painted(&mut self) {
        let texels = || self.bytes().chunks_exact(4);
        let painted = || texels().filter(|texel| texel[3] != 0);
        let enough = painted().count() as f64 >= PAINTED * texels().count() as f64;
        if !enough || painted().all(|texel| Some(texel) == painted().next()) {
            self.wrong.push("there is nothing in the picture".to_owned());
        }
    }

    /// It must look like this picture of RGBA texels, [`thinned`], but for a share of the pixels that either painted.
    pub fn must_look_like(&mut self, expected: &[u8], whose: &str, share: f64) {
        let own = thinned(self.bytes());
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
    /// [`thinned`], if it is one.
    picture: Option<Vec<u8>>,
}

impl References {
    /// Compares what a device gave with what the first one did with which nothing was wrong or, if this is the first,
    /// remembers it: some of the pixels of pictures, and the hash of everything. `share` is that of pixels that may
    /// differ, `None` if no byte may.
    pub fn compare(&mut self, id: &str, device: &str, outcome: &mut Outcome, share: Option<f64>) {
        let Some(first) = self.0.get(id) else {
            // What is wrong by itself says nothing about others.
            if !outcome.wrong.is_empty() {
                return;
            }
            let bytes = outcome.bytes();
            let picture = share.map(|_| thinned(bytes));
            let reference = Reference { device: device.to_owned(), hash: hash(bytes), picture };
            self.0.insert(id.to_owned(), reference);
            return;
        };
        let whose = format!("those of {}", first.device);
        match (share, &first.picture) {
            (Some(share), Some(picture)) => outcome.must_look_like(picture, &whose, share),
            _ => outcome.must_be(&first.hash, &whose),
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
    fn large_pictures_are_compared_in_some_of_their_pixels() {
        let large = [10, 20, 30, 255].repeat(4 * KEPT_PX);
        assert_eq!(thinned(&large).len(), 4 * (4 * KEPT_PX).div_ceil(5));
        assert_eq!(thinned(&large[..4 * KEPT_PX]), large[..4 * KEPT_PX]);
        let mut references = References::default();
        let mut compare = |device: &str, bytes: &[u8]| {
            let mut outcome = of(bytes);
            references.compare("frame", device, &mut outcome, Some(0.1));
            outcome.check().is_ok()
        };
        let (few, many) = ([&[0; 400][..], &large[400..]].concat(), [&large[large.len() / 2..], &large].concat());
        let half = [&vec![0; large.len() / 2][..], &large[large.len() / 2..]].concat();
        assert!(compare("A", &large) && compare("B", &few) && !compare("C", &half) && !compare("D", &many));
        let (small, large) = (Size { width: 512, height: 512 }, Size { width: 513, height: 512 });
        assert!(share_allowed(TechniqueName::Image, small) < 1.0 && share_allowed(TechniqueName::Image, large) == 1.0);
        assert!(share_allowed(TechniqueName::Dependent, large) < 1.0);
    }

    #[test]
    fn a_picture_without_anything_in_it_is_wrong() {
        let verdict = |pixels: &[[u8; 4]]| {
            let mut outcome = of(&[pixels.as_flattened(), &[0; 4 * 100][..]].concat());
            outcome.must_be_painted();
            outcome.check().verdict
        };
        for blank in [&[][..], &[[1, 2, 3, 255]; 50], &[[1, 2, 3, 255]], &[[1, 2, 3, 0], [3, 2, 1, 0]]] {
            assert_eq!(verdict(blank), "there is nothing in the picture", "{blank:?}");
        }
        assert_eq!(verdict(&[[1, 2, 3, 255], [3, 2, 1, 255]]), "ok");
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

    #[test]
    fn what_is_known_to_be_wrong_is_nothing_to_compare_with() {
        let mut references = References::default();
        let mut compare = |device: &str, bytes: &[u8]| {
            let mut outcome = of(bytes);
            outcome.must_be(&hash(b"right"), "those of the CPU oracle");
            references.compare("synthesis", device, &mut outcome, None);
            outcome.check().verdict
        };
        assert!(compare("A", b"wrong").starts_with("other bytes than those of the CPU oracle"));
        assert_eq!(compare("B", b"right"), "ok");
        assert!(compare("C", b"other").contains("other bytes than those of B"));
    }
}
