//! Pictures that the texture metric is tested with: textures, and copies of them that are wrong in a known way (thesis
//! 9.1.1 to 9.1.3).
//!
//! ```text
//! TestTexture (or one's own) -> rotated, scaled, poorly_sampled -> BlockSearch: the copy against the original
//! ```
//!
//! The thesis shows only what came out, so that the three textures are ours, made after its words: a random one, one
//! with a strong diagonal element, and a symmetric one. All of it is plain code on the host.

mod resample;
mod texture;

pub use resample::{rotated, scaled};
pub use texture::{TestTexture, TEST_SIDE_PX};

use super::Picture;
use crate::synthesis::params::{Placement, QuiltParams};
use crate::synthesis::quilt_oracle::quilt_at_random;
use crate::Result;

/// A copy full of discontinuities (section 9.1.3): blocks of `block_px` x `block_px` pixels, each taken at random from
/// the vertical stripe of the picture that is two blocks wide and has the block's place in its middle; neighbours are
/// joined by the minimum error cut. Smaller blocks make more cuts.
///
/// A block lies within its stripe as a whole, so that its columns move by half a block at most; where the stripe
/// reaches over the picture's edge, the rest of it serves. Blocks overlap by a sixth, rounded, as those of Efros and
/// Freeman do; the thesis does not say by how much. The same `seed` gives the same copy. Alpha is copied with the
/// colours.
///
/// # Errors
/// [`Error::Parameter`](crate::Error::Parameter) for blocks out of 4 to 64 pixels, and for a picture with a side that is
/// smaller than a block or longer than 4096 pixels.
pub fn poorly_sampled(picture: &Picture, block_px: u32, seed: u32) -> Result<Picture> {
    let sources = poor_sources(picture, block_px, seed)?;
    let width = picture.width() as usize;
    let pixels = sources.iter().map(|&(x, y)| picture.pixels()[usize::from(y) * width + usize::from(x)]);
    Picture::new(picture.width(), picture.height(), pixels.collect())
}

/// The pixel that each pixel of [`poorly_sampled`] is a copy of.
fn poor_sources(picture: &Picture, block_px: u32, seed: u32) -> Result<Vec<(u16, u16)>> {
    let size = (picture.width(), picture.height());
    let overlap_px = (block_px.saturating_add(3) / 6).max(1);
    let params = QuiltParams { block_px, overlap_px, seed, ..QuiltParams::default() };
    let last = (size.0.saturating_sub(block_px), size.1.saturating_sub(block_px));
    let stripe = |placement: &Placement| {
        let half = block_px / 2;
        let left = placement.x.saturating_sub(half).min(last.0);
        [left, 0, (placement.x + half).min(last.0), last.1]
    };
    quilt_at_random(picture.pixels(), size, size, &params, stripe)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture() -> Picture {
        TestTexture::Random.picture(64, 1).expect("a texture")
    }

    #[test]
    fn poor_sampling_takes_whole_blocks_from_the_stripe_and_from_all_heights() {
        let picture = TestTexture::Random.picture(96, 3).expect("a texture");
        for block_px in [4, 5, 12, 32] {
            let sources = poor_sources(&picture, block_px, 7).expect("sources");
            assert_eq!(sources.len(), 96 * 96);
            let (mut shifts, mut far) = (std::collections::BTreeSet::new(), 0);
            for (&(sx, sy), place) in sources.iter().zip(0..) {
                let (x, y) = (place % 96, place / 96);
                let shift = i32::from(sx) - x;
                // Half a block; where the output cuts a block off, its stripe ends at the picture's edge.
                let at_the_edge = x + block_px as i32 > 96;
                let most = if at_the_edge { block_px as i32 } else { block_px as i32 / 2 };
                assert!(shift.abs() <= most, "{x}, {y}: from {sx}, block {block_px}");
                shifts.insert(shift);
                far += u32::from((i32::from(sy) - y).abs() > 24);
            }
            assert!(shifts.len() > 4, "{block_px}: {shifts:?}");
            assert!(far > 96 * 96 / 8, "{block_px}: {far} pixels come from far above or below");
            // A pixel's right neighbour mostly comes from its source's right neighbour: blocks are whole.
            let joined = |pair: &&[(u16, u16)]| pair[1] == (pair[0].0 + 1, pair[0].1);
            let share = sources.windows(2).filter(|pair| joined(pair)).count() as f64 / sources.len() as f64;
            assert!(share > 1.0 - 2.0 / f64::from(block_px), "{block_px}: {share}");
        }
    }

    #[test]
    fn poor_sampling_is_the_seeds_alone_and_copies_alpha() {
        let picture = texture();
        let copy = |seed| poorly_sampled(&picture, 8, seed).expect("a copy");
        assert_eq!(copy(1), copy(1));
        assert_ne!(copy(1), copy(2));
        let mut pixels = picture.pixels().to_vec();
        pixels.iter_mut().for_each(|pixel| pixel[3] = 7);
        let faint = Picture::new(64, 64, pixels).expect("a picture");
        assert!(poorly_sampled(&faint, 8, 1).expect("a copy").pixels().iter().all(|pixel| pixel[3] == 7));
    }

    #[test]
    fn poor_sampling_that_cannot_be_done_is_refused() {
        let picture = texture();
        for (block_px, word) in [(0, "4 to 64"), (3, "4 to 64"), (65, "4 to 64"), (u32::MAX - 2, "4 to 64")] {
            let error = poorly_sampled(&picture, block_px, 1).expect_err("refused").to_string();
            assert!(error.contains("block_px") && error.contains(word), "{error}");
        }
        let small = TestTexture::Random.picture(32, 1).expect("a texture");
        assert!(poorly_sampled(&small, 33, 1).is_err() && poorly_sampled(&small, 32, 1).is_ok());
    }
}
