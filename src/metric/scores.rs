//! The thesis's three metrics of single pixels, and their means (sections 9.1 to 9.3).

use super::features::Features;
use super::search::Neighbour;

/// A mean with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// The mean.
    pub mean: f64,
    /// Half the width of the 95 % confidence interval of the mean, as of independent values with a normal mean: 1.96
    /// standard deviations of it. `None` for fewer than two values.
    pub half_width: Option<f64>,
    /// How many values there are.
    pub count: usize,
}

impl Score {
    /// The score of some values; `None` for no value.
    pub fn of(values: &[f64]) -> Option<Score> {
        let count = values.len();
        if count == 0 {
            return None;
        }
        let mean = values.iter().sum::<f64>() / count as f64;
        let half_width = (count > 1).then(|| {
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            1.96 * (squares / (count - 1) as f64 / count as f64).sqrt()
        });
        Some(Score { mean, half_width, count })
    }
}

/// Texture similarity of each tested pixel: the mean distance of its nearest source pixels (section 9.1). 0 is the same
/// texture.
pub fn similarity(nearest: &[Vec<Neighbour>]) -> Vec<f64> {
    nearest.iter().map(|of_pixel| mean(of_pixel.iter().map(|neighbour| neighbour.distance))).collect()
}

/// Shading error of each tested pixel (section 9.2): the mean shade of its nearest source pixels less the shade that it
/// should have, 0 to 1. A source pixel's shade is its place along the strip, (x + 0.5) / width. The thesis takes it
/// without its sign; whether squared it does not say.
pub fn shading_error(nearest: &[Vec<Neighbour>], source_width: u32, shades: &[f64]) -> Vec<f64> {
    let found = nearest.iter().map(|of_pixel| {
        mean(of_pixel.iter().map(|neighbour| (f64::from(neighbour.pixel.0) + 0.5) / f64::from(source_width)))
    });
    found.zip(shades).map(|(found, shade)| found - shade).collect()
}

/// Frame-to-frame coherence of each tested pixel (section 9.3): the distance of its block in one frame to the block of
/// the pixel in the next that is the same place of the picture, or the same point of the object. 0 is perfectly calm.
pub fn coherence(first: &[Features], second: &[Features], block_px: u32) -> Vec<f64> {
    first.iter().zip(second).map(|(first, second)| first.distance(second, block_px)).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_are_those_worked_by_hand() {
        let score = Score::of(&[1.0, 2.0, 3.0, 6.0]).expect("a score");
        // Deviations -2, -1, 0, 3: squares 14, variance 14 / 3, of the mean 14 / 12.
        assert_eq!((score.mean, score.count), (3.0, 4));
        assert!((score.half_width.expect("a width") - 1.96 * (14.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(Score::of(&[5.0]), Some(Score { mean: 5.0, half_width: None, count: 1 }));
        assert_eq!(Score::of(&[]), None);
        let near = |x, distance| Neighbour { pixel: (x, 9), distance };
        let nearest = [vec![near(1, 0.2), near(6, 0.4)], vec![near(3, 0.0)]];
        assert!((similarity(&nearest)[0] - 0.3).abs() < 1e-12 && similarity(&nearest)[1] == 0.0);
        let errors = shading_error(&nearest, 8, &[0.25, 0.4375]);
        assert_eq!(errors, [0.25, 0.0]);
    }
}
