//! Which pixels are measured: those whose blocks lie inside the object, all of them or some at random.

use super::features::block_corner;
use super::Picture;
use crate::random;

/// Which pixels of pictures of one size lie deep enough inside the object: with the block around them, and the pixel
/// around the block that the edge filters see, unless the picture ends there.
pub struct Eligible {
    width: u32,
    height: u32,
    pixels: Vec<bool>,
}

impl Eligible {
    /// Looks at a picture.
    pub fn new(picture: &Picture, block_px: u32) -> Self {
        let (width, height) = (picture.width(), picture.height());
        // Pixels outside of the object above and to the left of each corner of pixels.
        let stride = width as usize + 1;
        let mut outside = vec![0u32; stride * (height as usize + 1)];
        for y in 0..height as usize {
            for x in 0..width as usize {
                let here = u32::from(picture.pixels()[y * width as usize + x][3] != 255);
                let (above, left) = (outside[y * stride + x + 1], outside[(y + 1) * stride + x]);
                outside[(y + 1) * stride + x + 1] = here + above + left - outside[y * stride + x];
            }
        }
        let is_eligible = |x: u32, y: u32| {
            let (left, top) = block_corner((x, y), (width, height), block_px);
            let (right, bottom) = ((left + block_px + 1).min(width), (top + block_px + 1).min(height));
            let (left, top) = (left.saturating_sub(1), top.saturating_sub(1));
            let at = |x: u32, y: u32| outside[y as usize * stride + x as usize];
            at(right, bottom) + at(left, top) == at(left, bottom) + at(right, top)
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| is_eligible(x, y));
        Eligible { width, height, pixels: pixels.collect() }
    }

    /// Whether the pixel may be measured; never outside of the picture.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        x < self.width && y < self.height && self.pixels[(y * self.width + x) as usize]
    }

    /// All pixels that may be measured and that `also` accepts, row by row.
    pub fn all(&self, also: impl Fn(u32, u32) -> bool) -> Vec<(u32, u32)> {
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        pixels.filter(|&(x, y)| self.contains(x, y) && also(x, y)).collect()
    }
}

/// `count` of the pixels at random, each once, in the order in which they were drawn; all of them if there are not
/// more.
pub fn choose(mut pixels: Vec<(u32, u32)>, count: usize, seed: u32) -> Vec<(u32, u32)> {
    let count = count.min(pixels.len());
    for i in 0..count {
        let left = pixels.len() - i;
        let pick = i + (random::unit(seed, i as u32, 0) * left as f64) as usize;
        pixels.swap(i, pick);
    }
    pixels.truncate(count);
    pixels
}
