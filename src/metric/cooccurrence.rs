//! Average co-occurrence error: how unlike two textures are in which grey levels lie near each other.
//!
//! P. Bénard, J. Thollot and F. Sillion, "Quality Assessment of Fractalized NPR Textures: a Perceptual Objective
//! Metric" (APGV 2009), asked people to rank textures distorted by blending copies at several scales, as animation
//! does, and found that this error predicts their ranking. Here a strip of paint stands for the original, a frame for
//! the distorted texture. That the difference of such matrices agrees with what people see is also in A. Copeland, G.
//! Ravichandran and M. Trivedi, "Texture synthesis using gray-level co-occurrence models" (2001).
//!
//! # What is computed
//!
//! 1. Grey is 0.299 R + 0.587 G + 0.114 B of the stored values, cut into `levels` classes of equal width.
//! 2. For each distance d there are four offsets: (d, 0), (d, d), (0, d) and (-d, d). The opposite ones would count the
//!    same pairs the other way round.
//! 3. For each offset, a matrix holds the share of the pairs of pixels, that far apart and both inside, which have
//!    level i first and level j second. Its entries add up to 1.
//! 4. The error at an offset is half of the sum of |sample - frame| over the entries: the share of pairs that would
//!    have to be others. The result is the mean over all offsets.
//!
//! The idea, matrices compared and the errors averaged, is the papers'. The absolute difference, the half that makes 1
//! the greatest error, the weights of grey, the number of levels and the offsets are ours; the papers may differ in
//! them, so that values must not be compared with printed ones. Grey levels are not equalised before: paint of another
//! tone is an error, too.
//!
//! A matrix of few pairs is a rough estimate, and two pieces of one texture differ by chance. What counts is the
//! difference between values of pieces of like size.

use super::picture::{grey, Picture};
use crate::{Error, Result};

/// How co-occurrence is counted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CooccurrenceParams {
    /// Classes of grey, 2 to 64. More tell more apart, and need more pixels.
    pub levels: u32,
    /// How far apart the pixels of a pair are, along rows, columns and diagonals: at least one distance, each 1 to 256
    /// pixels (a diagonal goes as far in both directions).
    pub distances_px: Vec<u32>,
}

impl Default for CooccurrenceParams {
    /// Eight levels; distances from neighbours to the width of a brush mark.
    fn default() -> Self {
        CooccurrenceParams { levels: 8, distances_px: vec![1, 2, 4, 8] }
    }
}

impl CooccurrenceParams {
    fn validate(&self) -> Result<()> {
        if !(2..=64).contains(&self.levels) {
            return Err(Error::parameter("levels", self.levels, "2 to 64"));
        }
        if self.distances_px.is_empty() {
            return Err(Error::parameter("number of distances_px", 0, "at least 1"));
        }
        match self.distances_px.iter().find(|distance| !(1..=256).contains(*distance)) {
            Some(stray) => Err(Error::parameter("distances_px", stray, "1 to 256 pixels each")),
            None => Ok(()),
        }
    }
}

/// The average co-occurrence error of a frame, 0 (every pair as often as in the sample) to 1 (no pair in common).
///
/// Only pixels inside count; sample and frame may have any sizes. Exchanging the two changes nothing.
///
/// # Errors
/// [`Error::Parameter`] for a parameter outside of its range, and where a picture has no pair of pixels inside at one
/// of the offsets.
pub fn cooccurrence_error(sample: &Picture, frame: &Picture, params: &CooccurrenceParams) -> Result<f64> {
    params.validate()?;
    let sample = Levels::new("number of pixel pairs inside the sample", sample, params.levels);
    let frame = Levels::new("number of pixel pairs inside the frame", frame, params.levels);
    let offsets = params.distances_px.iter().flat_map(|&distance| {
        let d = i64::from(distance);
        [(d, 0), (d, d), (0, d), (-d, d)]
    });
    let (mut sum, mut count) = (0.0, 0);
    for offset in offsets {
        let (of_sample, of_frame) = (sample.matrix(offset)?, frame.matrix(offset)?);
        sum += of_sample.iter().zip(&of_frame).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0;
        count += 1;
    }
    Ok(sum / f64::from(count))
}

/// A picture as levels of grey.
struct Levels {
    /// What an error calls the pairs of this picture.
    name: &'static str,
    width: i64,
    height: i64,
    levels: usize,
    /// Row by row; none outside.
    pixels: Vec<Option<u8>>,
}

impl Levels {
    fn new(name: &'static str, picture: &Picture, levels: u32) -> Self {
        let level = |pixel: &[u8; 4]| (pixel[3] == 255).then_some((grey(*pixel) * levels / 256_000) as u8);
        let pixels = picture.pixels().iter().map(level).collect();
        let (width, height) = (i64::from(picture.width()), i64::from(picture.height()));
        Levels { name, width, height, levels: levels as usize, pixels }
    }

    /// The share of each pair of levels among the pairs of pixels that are `(dx, dy)` apart; `dy` is not negative.
    fn matrix(&self, (dx, dy): (i64, i64)) -> Result<Vec<f64>> {
        let mut counts = vec![0u64; self.levels * self.levels];
        let mut total = 0u64;
        for y in 0..self.height - dy {
            for x in (-dx).max(0)..self.width - dx.max(0) {
                let at = |x: i64, y: i64| self.pixels[(y * self.width + x) as usize];
                if let (Some(first), Some(second)) = (at(x, y), at(x + dx, y + dy)) {
                    counts[usize::from(first) * self.levels + usize::from(second)] += 1;
                    total += 1;
                }
            }
        }
        if total == 0 {
            let allowed = format!("at least 1 for each offset; there is none at ({dx}, {dy}) px");
            return Err(Error::parameter(self.name, 0, allowed));
        }
        Ok(counts.iter().map(|&count| count as f64 / total as f64).collect())
    }
}
