//! Sliced Wasserstein distance: how far the patches of one picture are from those of another.
//!
//! A texture is looked at as the set of its patches, each a point with one dimension for each value of each pixel. The
//! Wasserstein distance says how far the points of one set must move, at best, to become the other set; where a patch
//! lies in its picture does not matter. In many dimensions that is dear, but along a line it takes no more than
//! sorting, so the points are projected to random lines, and the squared distances are averaged.
//!
//! E. Heitz, K. Vanhoey, T. Chambon and L. Belcour, "A Sliced Wasserstein Loss for Neural Texture Synthesis" (CVPR
//! 2021), compare the features of a neural network (VGG-19) in this way, layer by layer. Here the points are patches of
//! plain RGB pixels, which need no network: what is told apart is no larger than a patch.

use super::Picture;
use crate::random::bits;
use crate::{Error, Result};

/// Which patches are compared, and along how many lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WassersteinParams {
    /// Side of a patch, 3 to 16 pixels.
    pub patch_px: u32,
    /// Random directions, 1 to 4096. With n of them the result varies from seed to seed by about 0.7 / sqrt(n) of
    /// itself where all pixels differ alike, and less elsewhere.
    pub directions: u32,
    /// Most patches that are taken of a picture, 1 to 65,536, spread evenly over it; all of them where there are fewer.
    pub patches: u32,
    /// Picks patches and directions; the same seed gives the same value.
    pub seed: u32,
}

impl Default for WassersteinParams {
    /// Patches of 8 x 8 pixels, 256 directions, at most 4096 patches.
    fn default() -> Self {
        WassersteinParams { patch_px: 8, directions: 256, patches: 4096, seed: 1 }
    }
}

impl WassersteinParams {
    fn validate(&self) -> Result<()> {
        if !(3..=16).contains(&self.patch_px) {
            return Err(Error::parameter("patch_px", self.patch_px, "3 to 16 pixels"));
        }
        if !(1..=4096).contains(&self.directions) {
            return Err(Error::parameter("directions", self.directions, "1 to 4096"));
        }
        if !(1..=65_536).contains(&self.patches) {
            return Err(Error::parameter("patches", self.patches, "1 to 65536"));
        }
        Ok(())
    }
}

/// The root of the mean, over directions, of the squared Wasserstein distance between projected patches.
///
/// In units of colour: if every value of every pixel changes by c (0 to 1), the distance is about c, so that 1 is about
/// the greatest there is. Identical pictures give exactly 0. Other pieces of one texture do not, the less so the more
/// patches there are: what counts is the difference between values. Exchanging the two pictures changes nothing.
///
/// Patches are wholly inside; sample and frame may have any sizes.
///
/// # Errors
/// [`Error::Parameter`] for a parameter outside of its range, and where no patch lies wholly inside one of the
/// pictures.
pub fn sliced_wasserstein(sample: &Picture, frame: &Picture, params: &WassersteinParams) -> Result<f64> {
    params.validate()?;
    let sample = Patches::sample("number of patches inside the sample", sample, params)?;
    let frame = Patches::sample("number of patches inside the frame", frame, params)?;
    let mut sum = 0.0;
    for number in 0..params.directions {
        let direction = unit_direction(params.seed, number, sample.dimensions.len());
        sum += squared_distance(&sample.project(&direction), &frame.project(&direction));
    }
    Ok((sum / f64::from(params.directions)).sqrt() / 255.0)
}

/// Patches as points.
struct Patches {
    /// For each dimension, its value in each patch.
    dimensions: Vec<Vec<u8>>,
}

impl Patches {
    fn sample(name: &'static str, picture: &Picture, params: &WassersteinParams) -> Result<Self> {
        let side = params.patch_px;
        let mut total = 0u64;
        for_each_patch(picture, side, |_, _| total += 1);
        if total == 0 {
            return Err(Error::parameter(name, 0, format!("at least 1 of {side} x {side} pixels")));
        }
        // The positions in reading order are cut into equal parts, and one is drawn from each.
        let wanted = total.min(u64::from(params.patches));
        let drawn = |part: u64| {
            let (start, end) = (part * total / wanted, (part + 1) * total / wanted);
            start + u64::from(bits(params.seed, part as u32, PATCH)) % (end - start)
        };
        let mut dimensions = vec![Vec::with_capacity(wanted as usize); (side * side * 3) as usize];
        let (mut passed, mut part, mut next) = (0, 0, drawn(0));
        for_each_patch(picture, side, |left, top| {
            if part < wanted && passed == next {
                let pixels = (0..side * side).map(|i| (left + i % side, top + i / side));
                for (rgb, (x, y)) in dimensions.chunks_exact_mut(3).zip(pixels) {
                    let pixel = picture.pixels()[(y * picture.width() + x) as usize];
                    rgb.iter_mut().zip(pixel).for_each(|(values, value)| values.push(value));
                }
                part += 1;
                if part < wanted {
                    next = drawn(part);
                }
            }
            passed += 1;
        });
        Ok(Patches { dimensions })
    }

    /// Where the patches lie along a direction, in ascending order.
    fn project(&self, direction: &[f32]) -> Vec<f32> {
        let mut places = vec![0.0; self.dimensions[0].len()];
        for (values, weight) in self.dimensions.iter().zip(direction) {
            places.iter_mut().zip(values).for_each(|(place, &value)| *place += weight * f32::from(value));
        }
        places.sort_unstable_by(f32::total_cmp);
        places
    }
}

/// Calls `visit` with the left column and the top row of each patch that is wholly inside, in reading order.
fn for_each_patch(picture: &Picture, side: u32, mut visit: impl FnMut(u32, u32)) {
    // How many pixels inside follow each other upwards, in each column.
    let mut heights = vec![0; picture.width() as usize];
    for y in 0..picture.height() {
        let mut wide = 0;
        for (x, height) in (0..).zip(&mut heights) {
            *height = if picture.is_inside(x, y) { *height + 1 } else { 0 };
            wide = if *height >= side { wide + 1 } else { 0 };
            if wide >= side {
                visit(x + 1 - side, y + 1 - side);
            }
        }
    }
}

/// The mean squared difference of quantiles, which is the squared Wasserstein distance of values along a line. Both
/// lists are in ascending order; none is empty.
fn squared_distance(a: &[f32], b: &[f32]) -> f64 {
    // Each value of `a` stands for a stretch of quantiles b.len() long, and the other way round.
    let (stretch_a, stretch_b) = (b.len() as u64, a.len() as u64);
    let (mut i, mut j, mut from, mut sum) = (0, 0, 0, 0.0);
    while i < a.len() && j < b.len() {
        let (end_a, end_b) = ((i as u64 + 1) * stretch_a, (j as u64 + 1) * stretch_b);
        let to = end_a.min(end_b);
        sum += (to - from) as f64 * (f64::from(a[i]) - f64::from(b[j])).powi(2);
        i += usize::from(to == end_a);
        j += usize::from(to == end_b);
        from = to;
    }
    sum / from as f64
}

/// A direction of length 1, all directions being equally likely: normally distributed numbers, scaled.
fn unit_direction(seed: u32, number: u32, dimensions: usize) -> Vec<f32> {
    let uniform =
        |i: usize, purpose| (f64::from(bits(bits(seed, number, DIRECTION), i as u32, purpose)) + 0.5) / 2f64.powi(32);
    // Box and Muller (1958).
    let normal = |i| (-2.0 * uniform(i, RADIUS).ln()).sqrt() * (std::f64::consts::TAU * uniform(i, ANGLE)).cos();
    let values: Vec<f64> = (0..dimensions).map(normal).collect();
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    values.iter().map(|value| (value / length) as f32).collect()
}

/// What a random number is for.
const PATCH: u32 = 0;
const DIRECTION: u32 = 1;
const RADIUS: u32 = 2;
const ANGLE: u32 = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        assert_eq!(squared_distance(&[1.0, 3.0], &[2.0, 7.0]), (1.0 + 16.0) / 2.0);
        assert_eq!(squared_distance(&[0.0], &[0.0, 2.0]), 4.0 / 2.0);
        // 0 meets 0 up to 1/3, then 1/2 up to 1/2; there 1 takes over and meets 1/2 up to 2/3, then 1.
        let distance = squared_distance(&[0.0, 1.0], &[0.0, 0.5, 1.0]);
        assert!((distance - 0.25 / 3.0).abs() < 1e-15, "{distance}");
    }
}
