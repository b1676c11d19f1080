//! Which frames of an animation there are, and parts of them for many machines.

/// The last frame there can be.
const MAX_FRAME: u32 = 999_999;

/// A first and a last frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    pub first: u32,
    pub last: u32,
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
}
