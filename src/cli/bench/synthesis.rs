//! The textures that are synthesised, freely and by a guide, and what they must be.
//!
//! Sample and guide are made on the host, so that all devices have the same problem to the bit, and the same answer.

use super::catalogue::{Case, Work};
use super::check::hash;
use super::scenes::strip;
use crate::cli::failure::Result;
use impasto::gpu::{Context, Uploads};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Quilt, QuiltGuide, QuiltStages, SampleTexels};
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide};
use std::sync::Arc;

/// Sides of outputs that the CPU oracle synthesises too, in about a second; others would take it minutes.
const ORACLE_PX: u32 = 256;
/// Side of the sample of a free synthesis: a piece from the middle of the strip.
const FREE_PX: u32 = 128;
/// How far from its shade a block may come in a guided one: what image-based synthesis takes for this strip.
const WINDOW_PX: u32 = 32;
/// The paint of the guide, as its texels have it.
const PAINT: u32 = 1 << 16;

/// A texture to be synthesised.
pub struct Problem {
    sample: Vec<[u8; 4]>,
    sample_size: (u32, u32),
    /// A texel for each pixel: the shade, and [`PAINT`] where there is something to paint.
    guide: Option<Vec<u32>>,
    size: (u32, u32),
    params: QuiltParams,
}

impl Problem {
    /// The one of a case.
    pub fn of(case: &Case, params: QuiltParams) -> Result<Self> {
        let guided = case.work == Work::Synthesis { guided: true };
        let (strip, _) = strip("green_yellow")?;
        let (width, height) = (strip.sample.width(), strip.sample.height());
        let all = strip.texture.to_unorm8();
        let size = case.size.pair();
        if guided {
            let guide = Some(ball(size));
            return Ok(Problem { sample: all, sample_size: (width, height), guide, size, params });
        }
        let (left, side) = (width.saturating_sub(FREE_PX) / 2, FREE_PX.min(width).min(height));
        let rows = all.chunks_exact(width as usize).take(side as usize);
        let sample = rows.flat_map(|row| row.iter().skip(left as usize).take(side as usize)).copied().collect();
        Ok(Problem { sample, sample_size: (side, side), guide: None, size, params })
    }

    /// Prepares it on a device.
    pub fn prepare(&self, context: &Context, uploads: &mut Uploads, stages: &Arc<QuiltStages>) -> Result<Quilt> {
        let sample = SampleTexels::new(context, uploads, &self.sample, self.sample_size)?;
        let guide = self.guide.as_ref();
        let guide = guide.map(|texels| QuiltGuide::from_texels(context, uploads, texels, self.size, WINDOW_PX));
        Ok(Quilt::new(context, uploads, stages, &sample, self.size, &self.params, guide.transpose()?)?)
    }

    /// The hash of what the CPU oracle makes of it; none where that would take too long.
    pub fn oracle(&self) -> Result<Option<String>> {
        if self.size.0.max(self.size.1) > ORACLE_PX {
            return Ok(None);
        }
        let texels = self.guide.as_deref().unwrap_or_default();
        let (shade, covered): (Vec<u8>, Vec<bool>) = texels.iter().map(|texel| (*texel as u8, *texel >= PAINT)).unzip();
        let guide = OracleGuide { shade: &shade, covered: &covered, window_px: WINDOW_PX };
        let guide = self.guide.is_some().then_some(&guide);
        let quilted = quilt_oracle(&self.sample, self.sample_size, self.size, &self.params, guide)?;
        Ok(Some(hash(quilted.pixels.as_flattened())))
    }
}

/// A guide: a ball, light above and dark below, before nothing. In integers, so that it is the same everywhere.
fn ball((width, height): (u32, u32)) -> Vec<u32> {
    let radius = i64::from(width.min(height)) / 2;
    let texel = |x: u32, y: u32| {
        let (dx, dy) = (i64::from(x) - i64::from(width) / 2, i64::from(y) - i64::from(height) / 2);
        let inside = dx * dx + dy * dy < radius * radius;
        // From 255 at the upper left to 0 at the lower right.
        let shade = (255 * (2 * radius - dx - dy) / (4 * radius)).clamp(0, 255) as u32;
        if inside {
            PAINT | shade
        } else {
            0
        }
    };
    (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::named;
    use super::*;

    #[test]
    fn problems_are_such_as_they_say() {
        for (name, guided, sample) in [("free/512", false, (128, 128)), ("guided/512", true, (512, 128))] {
            let cases = named(&format!("synthesis/{name}")).expect("a case");
            let problem = Problem::of(&cases[0], QuiltParams::default()).expect("a problem");
            assert_eq!((problem.guide.is_some(), problem.sample_size, problem.size), (guided, sample, (512, 512)));
            assert_eq!(problem.sample.len(), (sample.0 * sample.1) as usize);
            assert_eq!(problem.oracle().expect("none"), None, "too large");
        }
    }

    #[test]
    fn the_ball_is_round_and_has_all_shades() {
        let texels = ball((200, 100));
        let covered = texels.iter().filter(|texel| **texel >= PAINT).count();
        assert!((7700..=7900).contains(&covered), "{covered} of pi 50^2");
        let shades = texels.iter().filter(|texel| **texel >= PAINT).map(|texel| texel & 0xff);
        assert!(shades.clone().min() < Some(40) && shades.max() > Some(215));
    }
}
