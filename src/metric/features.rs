//! Features of the thesis's texture metric (section 9.1), in plain code: what the compute shaders are compared with,
//! and what ranks the few blocks that they have found to be nearest.
//!
//! Around a pixel lies a block of s x s pixels. It has 15 histograms of 10 equal bins: for each of the channels red,
//! green and blue one of the values, over [0, 1], and one of each of four 3x3 edge filters, over [-3, 3]:
//!
//! ```text
//! -1  0  1    -1 -1 -1     0  0  3    -3  0  0
//! -1  0  1     0  0  0     0  0  0     0  0  0
//! -1  0  1     1  1  1    -3  0  0     0  0  3
//! ```
//!
//! laid over the picture as they stand, rows from the top. A value on the boundary of two bins counts in the upper one,
//! the upper end in the last. Outside of the picture its nearest pixel goes on. A block begins s / 2 pixels, rounded
//! down, to the left of and above its pixel; where it would reach over the picture's edge it is moved inside.
//!
//! The thesis does not say how ranges and borders are handled, nor what is divided by what for s x s pixels of 8 bits;
//! these are the plainest choices. All of it is integers.

use super::Picture;
use crate::{Error, Result};
use std::ops::RangeInclusive;

/// Sides of a block, pixels: those of the thesis.
pub const BLOCK_PX: RangeInclusive<u32> = 4..=12;
/// Histograms of a block.
pub const HISTOGRAMS: usize = 15;
/// Bins of a histogram.
pub const BINS: usize = 10;

/// The counts of a block's histograms: histogram 5c of channel c is its colour, 5c + 1 to 5c + 4 its edges in the order
/// of the filters; bins from low to high.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Features(pub [[u8; BINS]; HISTOGRAMS]);

impl Features {
    /// The metric (section 9.1): the sum over the histograms of their Euclidean distance, divided by s * s * 15.
    pub fn distance(&self, other: &Features, block_px: u32) -> f64 {
        let histogram = |(a, b): (&[u8; BINS], &[u8; BINS])| {
            let squared: u32 = a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum();
            f64::from(squared).sqrt()
        };
        let sum: f64 = self.0.iter().zip(&other.0).map(histogram).sum();
        sum / f64::from(block_px * block_px * HISTOGRAMS as u32)
    }
}

/// A picture with the bin of every pixel in every histogram.
pub struct FeatureBins {
    width: u32,
    height: u32,
    bins: Vec<[u8; HISTOGRAMS]>,
}

impl FeatureBins {
    /// Filters a picture.
    pub fn new(picture: &Picture) -> Self {
        let (width, height) = (picture.width(), picture.height());
        let at = |x: i64, y: i64, channel: usize| {
            let (x, y) = (x.clamp(0, i64::from(width) - 1), y.clamp(0, i64::from(height) - 1));
            i32::from(picture.pixels()[(y * i64::from(width) + x) as usize][channel])
        };
        let color_bin = |value: i32| (value * 10 / 255).min(9) as u8;
        let edge_bin = |value: i32| ((value + 765) / 153).min(9) as u8;
        let mut bins = Vec::with_capacity(picture.pixels().len());
        for (y, x) in (0..i64::from(height)).flat_map(|y| (0..i64::from(width)).map(move |x| (y, x))) {
            let mut of_pixel = [0; HISTOGRAMS];
            for channel in 0..3 {
                let near = |dx: i64, dy: i64| at(x + dx, y + dy, channel);
                let column = |dx| near(dx, -1) + near(dx, 0) + near(dx, 1);
                let row = |dy| near(-1, dy) + near(0, dy) + near(1, dy);
                let edges = [
                    column(1) - column(-1),
                    row(1) - row(-1),
                    3 * (near(1, -1) - near(-1, 1)),
                    3 * (near(1, 1) - near(-1, -1)),
                ];
                of_pixel[5 * channel] = color_bin(near(0, 0));
                (0..4).for_each(|k| of_pixel[5 * channel + 1 + k] = edge_bin(edges[k]));
            }
            bins.push(of_pixel);
        }
        FeatureBins { width, height, bins }
    }

    /// The features of the block whose upper left pixel is `corner`; it must lie inside the picture.
    pub fn features(&self, corner: (u32, u32), block_px: u32) -> Features {
        let mut counts = [[0; BINS]; HISTOGRAMS];
        for y in corner.1..(corner.1 + block_px).min(self.height) {
            for x in corner.0..(corner.0 + block_px).min(self.width) {
                let bins = &self.bins[(y * self.width + x) as usize];
                counts.iter_mut().zip(bins).for_each(|(histogram, bin)| histogram[usize::from(*bin)] += 1);
            }
        }
        Features(counts)
    }
}

/// The upper left pixel of the block around a pixel of a picture of `size` = (width, height).
pub fn block_corner(pixel: (u32, u32), size: (u32, u32), block_px: u32) -> (u32, u32) {
    let along = |at: u32, side: u32| at.saturating_sub(block_px / 2).min(side.saturating_sub(block_px));
    (along(pixel.0, size.0), along(pixel.1, size.1))
}

/// Checks a block's side, alone and against a picture.
///
/// # Errors
/// [`Error::Parameter`] for a side out of [`BLOCK_PX`], or a picture that is smaller than a block.
pub fn check_block(block_px: u32, picture: &Picture) -> Result<()> {
    if !BLOCK_PX.contains(&block_px) {
        let allowed = format!("{} to {} pixels", BLOCK_PX.start(), BLOCK_PX.end());
        return Err(Error::parameter("block_px", block_px, allowed));
    }
    let (width, height) = (picture.width(), picture.height());
    if width.min(height) < block_px {
        let allowed = format!("at least a block of {block_px} x {block_px} pixels");
        return Err(Error::parameter("picture", format!("{width} x {height}"), allowed));
    }
    Ok(())
}
