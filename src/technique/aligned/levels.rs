//! The levels of all paints on the device, and their preparation: which part of the strip each comes from, and its way
//! through quilting and tiling into the volume (thesis chapter 7).

use super::LevelTexture;
use crate::gpu::{Context, Image, Recorder, Runner, Uploads};
use crate::paint::{TextureDifference, Trajectory};
use crate::synthesis::params::QuiltParams;
use crate::synthesis::quilt::{Quilt, QuiltStages, SampleTexels};
use crate::synthesis::tile_mask::TileMask;
use crate::synthesis::volume::{SliceCopy, Volume};
use crate::technique::check_paints;
use crate::{Error, Result};
use std::ops::Range;
use std::sync::Arc;

/// How a level is made to repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tileable {
    /// Blocks are quilted around the edges as well, which keeps texture sharp.
    #[default]
    Wrap,
    /// The quilt is blended with itself under a circular mask: the thesis's way (3.2.3).
    Mask,
}

/// How a paint is prepared for view-aligned projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelParams {
    /// Levels of shade, 1 to 64; the thesis found 8 to be enough.
    pub levels: u32,
    /// Side of each level's square texture, pixels: 16 to 2048.
    pub size_px: u32,
    /// How they are made to repeat.
    pub tileable: Tileable,
    /// How they are quilted; its `tileable` follows from the field above, and is ignored.
    pub quilt: QuiltParams,
}

impl Default for LevelParams {
    fn default() -> Self {
        LevelParams { levels: 8, size_px: 512, tileable: Tileable::Wrap, quilt: QuiltParams::default() }
    }
}

impl LevelParams {
    /// Checks number and size of the levels, and that a strip of `block_px` can be quilted to that size.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field out of range.
    pub fn check(&self) -> Result<()> {
        if !(1..=64).contains(&self.levels) {
            return Err(Error::parameter("levels", self.levels, "1 to 64"));
        }
        if !(16..=2048).contains(&self.size_px) {
            return Err(Error::parameter("size_px", self.size_px, "16 to 2048 pixels"));
        }
        self.quilting().validate((64, 64), (self.size_px, self.size_px))
    }

    fn quilting(&self) -> QuiltParams {
        QuiltParams { tileable: self.tileable == Tileable::Wrap, ..self.quilt }
    }

    /// The columns of a strip that a level comes from: its share of the width, widened on a short strip to one and a
    /// half blocks, so that blocks have something to choose from.
    pub fn columns(&self, level: u32, strip_width_px: u32) -> Range<u32> {
        let edge = |i: u32| (u64::from(i) * u64::from(strip_width_px) / u64::from(self.levels)) as u32;
        let (begin, end) = (edge(level), edge(level + 1));
        let width = (end - begin).max(self.quilt.block_px * 3 / 2).min(strip_width_px);
        let begin = (begin + (end - begin) / 2).saturating_sub(width / 2).min(strip_width_px - width);
        begin..begin + width
    }

    /// The sample that a level is quilted from: these columns of the strip's texture difference less their mean, in 8
    /// bits, [-1, 1] mapped to [0, 255]; and its size.
    ///
    /// The thesis subtracts the mean colour of the columns from the strip. The trajectory, which is gone from the
    /// difference already, leaves no slope of colour within the level, and the mean that is left is subtracted here.
    pub fn sample(&self, texture: &TextureDifference, level: u32) -> (Vec<[u8; 4]>, (u32, u32)) {
        let columns = self.columns(level, texture.width());
        let size = (columns.len() as u32, texture.height());
        let (begin, end) = (columns.start as usize, columns.end as usize);
        let rows = || texture.pixels().chunks_exact(texture.width() as usize).map(|row| &row[begin..end]);
        let mut mean = [0.0f64; 3];
        for pixel in rows().flatten() {
            for (sum, value) in mean.iter_mut().zip(pixel) {
                *sum += f64::from(*value);
            }
        }
        let mean = mean.map(|sum| sum / f64::from(size.0 * size.1));
        let byte = |value: f64| ((value.clamp(-1.0, 1.0) + 1.0) / 2.0 * 255.0).round() as u8;
        let texels = rows().flatten().map(|pixel| {
            let [r, g, b] = [0, 1, 2].map(|k| byte(f64::from(pixel[k]) - mean[k]));
            [r, g, b, 255]
        });
        (texels.collect(), size)
    }
}

/// Where a paint's levels come from.
#[derive(Clone, Copy)]
pub enum LevelSource<'a> {
    /// From the texture of a strip: they are synthesised.
    Strip(&'a TextureDifference),
    /// They were prepared before.
    Prepared(&'a LevelTexture),
}

/// A part of the preparation, small enough for one submission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LevelPart {
    /// Which of the levels that have to be synthesised.
    level: usize,
    steps: Range<usize>,
    last: bool,
}

/// The levels of all paints in one 3D image: those of a paint one after the other, dark first.
pub struct LevelVolume {
    params: LevelParams,
    paints: u32,
    volume: Volume,
    syntheses: Vec<LevelSynthesis>,
}

impl LevelVolume {
    /// Prepares the levels of these paints.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range, a strip smaller than a block, no paint, and prepared levels of
    /// another size or number than `params` has; [`Error::Device`] when the device's 3D images are too small;
    /// [`Error::Memory`] when the budget does not allow it.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        paints: &[LevelSource<'_>],
        params: &LevelParams,
    ) -> Result<Self> {
        check_paints(paints.len(), &[], 0)?;
        params.check()?;
        let (size, levels) = (params.size_px, params.levels);
        let count = paints.len() as u32;
        let volume = Volume::new(context, "levels of shade", (size, size), count.saturating_mul(levels))?;
        let mut syntheses = Vec::new();
        for (first, paint) in (0..).step_by(levels as usize).zip(paints) {
            match paint {
                LevelSource::Strip(texture) => {
                    for level in 0..levels {
                        let slice = first + level;
                        syntheses.push(LevelSynthesis::new(
                            context, uploads, stages, &volume, texture, level, slice, params,
                        )?);
                    }
                }
                LevelSource::Prepared(texture) => {
                    if (texture.size_px(), texture.levels()) != (size, levels) {
                        let value = format!("{} of {} px", texture.levels(), texture.size_px());
                        return Err(Error::parameter("prepared levels", value, format!("{levels} of {size} px")));
                    }
                    let data = bytemuck::cast_slice(texture.texels());
                    uploads.slices(context, volume.image(), first..first + levels, data)?;
                }
            }
        }
        Ok(LevelVolume { params: *params, paints: count, volume, syntheses })
    }

    /// Cuts the preparation into parts of at most about `comparisons` pixel comparisons, to be submitted one by one, in
    /// order. There are none when all paints were prepared before.
    pub fn parts(&self, comparisons: u64) -> Vec<LevelPart> {
        let mut parts = Vec::new();
        for (level, synthesis) in self.syntheses.iter().enumerate() {
            let steps = synthesis.quilt.parts(comparisons);
            parts.extend(steps.into_iter().map(|steps| LevelPart { level, steps, last: false }));
            if let Some(part) = parts.last_mut() {
                part.last = true;
            }
        }
        parts
    }

    /// Records a part of the preparation. `seed` plus the level's number is the seed of its quilting.
    pub fn record_part(&self, recorder: &mut Recorder<'_>, part: &LevelPart, seed: u32) {
        if let Some(synthesis) = self.syntheses.get(part.level) {
            synthesis.record(recorder, &self.volume, part.steps.clone(), part.last, seed);
        }
    }

    /// Lets go of what only the preparation needs, once all of it is recorded.
    pub fn finish(&mut self) {
        self.syntheses.clear();
    }

    /// How they were prepared.
    pub fn params(&self) -> &LevelParams {
        &self.params
    }

    /// How many paints there are.
    pub fn paints(&self) -> u32 {
        self.paints
    }

    /// All levels: R8G8B8A8_UNORM, 3D, a slice for each (one more, empty, where there is only one), the difference from
    /// [-1, 1] mapped to [0, 1].
    pub fn image(&self) -> &Image {
        self.volume.image()
    }

    /// Reads the levels of a paint back, with these colours, to be kept for another time.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is no such paint; those of [`Runner::read_image`].
    pub fn read(&self, runner: &mut Runner, paint: usize, trajectory: &Trajectory) -> Result<LevelTexture> {
        if paint >= self.paints as usize {
            return Err(Error::parameter("paint", paint, format!("below the {} paints", self.paints)));
        }
        let bytes = runner.read_image(self.volume.image())?;
        let texels: Vec<[u8; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let (size, levels) = (self.params.size_px, self.params.levels);
        let count = size as usize * size as usize * levels as usize;
        let own = texels[paint * count..(paint + 1) * count].to_vec();
        LevelTexture::new(size, levels, own, trajectory.clone())
    }
}

/// The synthesis of one level.
pub(super) struct LevelSynthesis {
    quilt: Quilt,
    mask: Option<TileMask>,
    copy: SliceCopy,
    level: u32,
}

impl LevelSynthesis {
    #[allow(clippy::too_many_arguments)] // the tools, the texture, the place, the way
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        volume: &Volume,
        texture: &TextureDifference,
        level: u32,
        slice: u32,
        params: &LevelParams,
    ) -> Result<Self> {
        let quilting = params.quilting();
        let strip = (texture.width(), texture.height());
        quilting.validate(strip, (params.size_px, params.size_px))?;
        let (texels, size) = params.sample(texture, level);
        let sample = SampleTexels::new(context, uploads, &texels, size)?;
        let output = (params.size_px, params.size_px);
        let quilt = Quilt::new(context, uploads, stages, &sample, output, &quilting, None)?;
        let mask = match params.tileable {
            Tileable::Wrap => None,
            Tileable::Mask => Some(TileMask::of_image(context, uploads, quilt.canvas())?),
        };
        let copy = volume.copy(context, mask.as_ref().map_or(quilt.canvas(), TileMask::image), slice)?;
        Ok(LevelSynthesis { quilt, mask, copy, level })
    }

    /// Records some of the quilting's steps, and after the last one what follows. The level's number is added to the
    /// seed, so that levels do not repeat each other's choices.
    pub fn record(&self, recorder: &mut Recorder<'_>, volume: &Volume, steps: Range<usize>, last: bool, seed: u32) {
        self.quilt.record_part(recorder, steps, seed.wrapping_add(self.level), 0);
        if last {
            if let Some(mask) = &self.mask {
                mask.record(recorder);
            }
            volume.record(recorder, &self.copy);
        }
    }
}
