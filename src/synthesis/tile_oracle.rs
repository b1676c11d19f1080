//! Tiling by mask on the CPU (thesis 3.2.3): the yardstick for the GPU's blend.
//!
//! A picture that does not repeat is blended with itself, shifted by half its size: the shifted picture's edges come
//! from the picture's middle and so meet when it is repeated, and a round mask brings the picture itself back where the
//! shifted one shows its seams. The last step on the way from a quilted picture to a texture that repeats.
//!
//! At the middle of each edge both masks are at their least, and what is left there of the seam shows within a few
//! pixels: a property of the thesis's round mask.

/// The mask's weights are stored in units of 1/4096, so that the blend is exact integer arithmetic.
const WEIGHT_SCALE: f64 = 4096.0;

/// Blends a picture of `size` = (width, height) pixels, RGBA row by row, with its shifted self, so that it repeats.
///
/// Every channel, alpha too, is `(T m + T' m') / (m + m')`, rounded to nearest with halves up, where `T'` and `m'` are
/// the picture and the mask shifted by half the size, rounded down. The result is empty when `pixels` does not hold
/// width times height pixels.
pub fn tile_oracle(pixels: &[[u8; 4]], size: (u32, u32)) -> Vec<[u8; 4]> {
    let (width, height) = size;
    if pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Vec::new();
    }
    let at = |x: u32, y: u32| pixels[y as usize * width as usize + x as usize];
    let mut out = Vec::with_capacity(pixels.len());
    for y in 0..height {
        for x in 0..width {
            let shifted = (shift(x, width), shift(y, height));
            let (near, far) = (at(x, y), at(shifted.0, shifted.1));
            let (m, m_shifted) = (mask_weight((x, y), size), mask_weight(shifted, size));
            let weights = m + m_shifted;
            let blend = |c: usize| {
                let sum = u32::from(near[c]) * m + u32::from(far[c]) * m_shifted;
                ((sum + weights / 2) / weights) as u8
            };
            out.push([blend(0), blend(1), blend(2), blend(3)]);
        }
    }
    out
}

/// The mask's weight at pixel (x, y) in units of 1/4096: 255 in the middle, falling to 1 at the edges and beyond the
/// circle that touches them (an ellipse, where the picture is not square).
pub fn mask_weight((x, y): (u32, u32), (width, height): (u32, u32)) -> u32 {
    // (x - n/2) / (n/2) of the thesis, without its halves.
    let from_middle = |at: u32, side: u32| (2.0 * f64::from(at) - f64::from(side)) / f64::from(side);
    let (u, v) = (from_middle(x, width), from_middle(y, height));
    let mask = (255.0 - 255.0 * (u * u + v * v).sqrt()).clamp(1.0, 255.0);
    (mask * WEIGHT_SCALE + 0.5).floor() as u32
}

/// The coordinate half a side further on, wrapping round.
fn shift(at: u32, side: u32) -> u32 {
    ((u64::from(at) + u64::from(side / 2)) % u64::from(side)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[u8]) -> Vec<[u8; 4]> {
        values.iter().map(|&v| [v, v / 2, 255 - v, 255]).collect()
    }

    #[test]
    fn mask_by_hand() {
        // Half the distance to the edge: 255 - 127.5 = 127.5, times 4096. Beyond the circle: 1.
        let row: Vec<u32> = (0..4).map(|x| mask_weight((x, 2), (4, 4))).collect();
        assert_eq!(row, [4096, 522_240, 1_044_480, 522_240]);
        let corner: Vec<u32> = (0..4).map(|x| mask_weight((x, 0), (4, 4))).collect();
        assert_eq!(corner, [4096; 4]);
        // 255 - 255 sqrt(1/2) = 74.6877..., times 4096 = 305921.1...
        assert_eq!(mask_weight((1, 1), (4, 4)), 305_921);
        // An ellipse: half the way to either edge is the same.
        assert_eq!([mask_weight((2, 2), (8, 4)), mask_weight((4, 1), (8, 4))], [522_240; 2]);
        // Odd sides: |2*1 - 3| / 3 = 1/3 on each axis: 255 - 255 sqrt(2) / 3 = 134.7918..., times 4096 = 552107.4...
        assert_eq!(mask_weight((1, 1), (3, 3)), 552_107);
    }

    #[test]
    fn two_by_two_by_hand() {
        // The mask is 255 at (1,1) and 1 elsewhere; every pixel blends with the diagonally opposite one.
        let out = tile_oracle(&grey(&[0, 1, 2, 255]), (2, 2));
        // Left top: (0*1 + 255*255) / 256 = 254.004 -> 254. Right bottom: (255*255 + 0*1) / 256 -> 254.
        // The others: (1 + 2) / 2 = 1.5 -> 2. Green is 0, 0, 1, 127: 127*255/256 = 126.5 -> 127 and 0.5 -> 1.
        let red: Vec<u8> = out.iter().map(|p| p[0]).collect();
        let green: Vec<u8> = out.iter().map(|p| p[1]).collect();
        assert_eq!(red, [254, 2, 2, 254]);
        assert_eq!(green, [127, 1, 1, 127]);
        assert!(out.iter().all(|p| p[3] == 255));
    }

    #[test]
    fn a_constant_picture_stays_and_a_single_pixel_too() {
        for size in [(1, 1), (1, 7), (5, 4), (16, 16)] {
            let picture = vec![[7, 77, 177, 249]; (size.0 * size.1) as usize];
            assert_eq!(tile_oracle(&picture, size), picture, "{size:?}");
        }
    }

    #[test]
    fn alpha_is_blended_like_the_colours() {
        let picture: Vec<[u8; 4]> = (0..35).map(|i| [i * 7; 4]).collect();
        assert!(tile_oracle(&picture, (7, 5)).iter().all(|p| p[3] == p[0]));
    }

    /// How far apart the two ends of each row are.
    fn jumps(pixels: &[[u8; 4]], n: u32) -> Vec<u32> {
        pixels.chunks(n as usize).map(|row| u32::from(row[0][0].abs_diff(row[row.len() - 1][0]))).collect()
    }

    #[test]
    fn the_ends_of_a_ramp_meet() {
        let n = 64;
        let ramp: Vec<[u8; 4]> = (0..n * n).map(|i| [(i % n * 4) as u8; 4]).collect();
        assert!(jumps(&ramp, n).iter().all(|&jump| jump == 252), "the measure sees the ramp's own jump");
        let jumps = jumps(&tile_oracle(&ramp, (n, n)), n);
        // A step inside of the ramp is 4. Only near the middle of the edge, where both masks vanish, is there more.
        assert!(jumps[..24].iter().chain(&jumps[41..]).all(|&jump| jump <= 4), "{jumps:?}");
        assert!(jumps.iter().sum::<u32>() / n <= 10, "{jumps:?}");
    }

    #[test]
    fn a_slice_that_is_no_picture_gives_nothing() {
        let picture = vec![[1; 4]; 6];
        assert_eq!(tile_oracle(&picture, (3, 3)), Vec::<[u8; 4]>::new());
        assert_eq!(tile_oracle(&picture, (u32::MAX, u32::MAX)), Vec::<[u8; 4]>::new());
        assert_eq!(tile_oracle(&[], (0, 5)), Vec::<[u8; 4]>::new());
    }
}
