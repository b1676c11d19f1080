//! Three textures of our own.

use super::super::Picture;
use crate::{random, Error, Result};
use std::f64::consts::{SQRT_2, TAU};
use std::ops::RangeInclusive;

/// Sides of a test texture, pixels.
pub const TEST_SIDE_PX: RangeInclusive<u32> = 32..=1024;

/// A square texture for tests of the metric (thesis 9.1.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TestTexture {
    /// Smooth coloured noise with a grain of some 6 pixels; no direction is different from another.
    Random,
    /// Stripes that climb from the lower left to the upper right, some 20 pixels apart, uneven in width and depth.
    Diagonal,
    /// A square grid of round dots, some 12 pixels apart. A quarter turn changes nothing, and since each dot is round
    /// other angles change little.
    Symmetric,
}

/// Darkest and lightest paint of the textures.
const DARK: [f64; 3] = [38.0, 46.0, 92.0];
const LIGHT: [f64; 3] = [244.0, 226.0, 170.0];

impl TestTexture {
    /// All of them, in the thesis's order.
    pub const ALL: [TestTexture; 3] = [TestTexture::Random, TestTexture::Diagonal, TestTexture::Symmetric];

    /// One word for it.
    pub fn name(self) -> &'static str {
        match self {
            TestTexture::Random => "random",
            TestTexture::Diagonal => "diagonal",
            TestTexture::Symmetric => "symmetric",
        }
    }

    /// The texture with sides of `side_px`. The same `seed` gives the same texture; it means nothing to the symmetric
    /// one.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a side out of [`TEST_SIDE_PX`].
    pub fn picture(self, side_px: u32, seed: u32) -> Result<Picture> {
        if !TEST_SIDE_PX.contains(&side_px) {
            let allowed = format!("{} to {} pixels", TEST_SIDE_PX.start(), TEST_SIDE_PX.end());
            return Err(Error::parameter("side_px", side_px, allowed));
        }
        let color = |place: u32| {
            let (x, y) = (f64::from(place % side_px), f64::from(place / side_px));
            match self {
                TestTexture::Random => grain(x, y, seed),
                TestTexture::Diagonal => paint([stripes(x, y, seed); 3]),
                TestTexture::Symmetric => paint([dots(x, y, f64::from(side_px)); 3]),
            }
        };
        Picture::new(side_px, side_px, (0..side_px * side_px).map(color).collect())
    }
}

/// A mixture of dark (0) and light (1) paint, channel by channel.
fn paint(light: [f64; 3]) -> [u8; 4] {
    let [r, g, b] = [0, 1, 2].map(|i| (DARK[i] + (LIGHT[i] - DARK[i]) * light[i].clamp(0.0, 1.0)).round() as u8);
    [r, g, b, 255]
}

fn grain(x: f64, y: f64, seed: u32) -> [u8; 4] {
    // Grain that is much finer loses its contrast when a copy is shrunk to half of its size.
    let of_purpose = |purpose| noise(x / 6.0, y / 6.0, seed, purpose);
    // What all channels have in common, and a little of their own.
    let common = of_purpose(0);
    paint([1, 2, 3].map(|channel| 0.5 + 1.5 * (0.75 * common + 0.25 * of_purpose(channel) - 0.5)))
}

fn stripes(x: f64, y: f64, seed: u32) -> f64 {
    let across = (x + y) / SQRT_2;
    let phase = across / 20.0 * TAU + 2.0 * (noise(x / 24.0, y / 24.0, seed, 4) - 0.5);
    // The slopes decide what a turn by 45 degrees does. The filters for horizontal and vertical edges weigh less than
    // the diagonal ones. On slopes so gentle that their answers stay in the two middle bins they notice nothing, and
    // the diagonal ones differ most at a right angle. On steep ones, as of stripes 10 pixels apart, all four differ at
    // 45 degrees already, and the error is much the same from there to 135.
    let depth = 0.55 + 0.2 * noise(x / 12.0, y / 12.0, seed, 5);
    0.5 + 0.5 * depth * phase.sin()
}

fn dots(x: f64, y: f64, side: f64) -> f64 {
    // A whole number of dots, so that the grid is the same on all sides of the picture's centre. They are little larger
    // than the metric's blocks: of a grid twice as wide a small block sees hardly more than a slope, which is found
    // anywhere.
    let period = side / (side / 12.0).round();
    let from_dot = |at: f64| ((at + 0.5).rem_euclid(period) - period / 2.0).abs();
    let radius = from_dot(x).hypot(from_dot(y));
    // Light in the middle, dark between the dots.
    let edge = ((radius / period - 0.15) / 0.3).clamp(0.0, 1.0);
    1.0 - edge * edge * (3.0 - 2.0 * edge)
}

/// Smooth noise, 0 to 1, with random values at whole coordinates (of at most 0 to 32,767).
fn noise(x: f64, y: f64, seed: u32, purpose: u32) -> f64 {
    let at = |x: f64, y: f64| random::unit(seed, x as u32 | (y as u32) << 16, purpose);
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (left, top) = (x.floor(), y.floor());
    let (right, down) = (smooth(x - left), smooth(y - top));
    let row = |y: f64| at(left, y) + (at(left + 1.0, y) - at(left, y)) * right;
    row(top) + (row(top + 1.0) - row(top)) * down
}

#[cfg(test)]
mod tests {
    use super::super::rotated;
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// Mean difference of two pictures' colours, where both have one.
    fn difference(a: &Picture, b: &Picture) -> f64 {
        let pairs: Vec<_> = a.pixels().iter().zip(b.pixels()).filter(|(a, b)| a[3] == 255 && b[3] == 255).collect();
        let sum: u32 = pairs.iter().map(|(a, b)| (0..3).map(|i| u32::from(a[i].abs_diff(b[i]))).sum::<u32>()).sum();
        f64::from(sum) / (3 * pairs.len()) as f64
    }

    #[test]
    fn textures_are_the_seeds_alone_opaque_and_full_of_contrast() {
        for texture in TestTexture::ALL {
            let picture = texture.picture(128, 1).expect("a texture");
            assert_eq!(picture, texture.picture(128, 1).expect("a texture"));
            assert_eq!(picture == texture.picture(128, 2).expect("a texture"), texture == TestTexture::Symmetric);
            let reds = || picture.pixels().iter().map(|pixel| pixel[0]);
            assert!(reds().min() < Some(70) && reds().max() > Some(210), "{texture:?}");
            assert!(picture.pixels().iter().all(|pixel| pixel[3] == 255));
        }
        for side_px in [0, 31, 1025, u32::MAX] {
            assert!(TestTexture::Random.picture(side_px, 1).is_err());
        }
    }

    #[test]
    fn a_quarter_turn_changes_what_it_should() {
        let turned = |texture: TestTexture| {
            let picture = texture.picture(128, 1).expect("a texture");
            difference(&picture, &rotated(&picture, FRAC_PI_2))
        };
        assert!(turned(TestTexture::Symmetric) < 1.0);
        assert!(turned(TestTexture::Diagonal) > 40.0 && turned(TestTexture::Random) > 20.0);
    }

    #[test]
    fn stripes_run_along_the_diagonal() {
        let picture = TestTexture::Diagonal.picture(128, 1).expect("a texture");
        let change = |dx: usize, dy: usize| {
            let at = |x: usize, y: usize| f64::from(picture.pixels()[y * 128 + x][0]);
            let places = (8..120).flat_map(|y| (8..120).map(move |x| (x, y)));
            places.map(|(x, y)| (at(x + dx, y + 4 - dy) - at(x, y + 4)).abs()).sum::<f64>()
        };
        // To the upper right, and to the right alone.
        assert!(change(3, 3) * 3.0 < change(4, 0));
    }
}
