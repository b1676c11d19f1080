//! View-aligned 3D texture projection (thesis chapter 7): nearly the picture of image-based synthesis, in real time.
//!
//! Prepared once: the strip is cut into levels of roughly constant shade; the texture of each is quilted to a tileable
//! square, and the squares are stacked into one 3D image ([`LevelTexture`] is that on the host, and in a file). Drawn
//! for every frame: a pass over the guides that takes colour by shade, and texture by place in the picture and shade.
//!
//! The hardware's blend between two levels takes contrast from the marks, by a factor of up to the root of 2, because
//! two textures that know nothing of each other are averaged: the error that the thesis names. [`LevelBlend::Contrast`]
//! multiplies the blend's deviation from the mean (which is no difference) by what it lost.

mod follow;
mod level_texture;
mod levels;

pub use follow::screen_displacement;
pub use level_texture::LevelTexture;
pub use levels::{LevelParams, LevelPart, LevelSource, LevelVolume, Tileable};

use super::colors::ColorTable;
use super::picture_pass::{frame_for, PicturePass, PICTURE};
use super::{check_paints, paint_picture, ShadeRange, Show};
use crate::gpu::{Access, BindingKind, BindingSet, Context, Image, RasterShader, Recorder, Sampler, Uploads};
use crate::paint::Trajectory;
use crate::scene::GuidePass;
use crate::{Error, Result};
use ash::vk;

/// Stroke densities that make sense: below, a texel covers many pixels; above, the marks are finer than pixels.
const DENSITY: std::ops::RangeInclusive<f32> = 0.05..=4.0;

pub(crate) const ALIGNED: RasterShader = RasterShader {
    name: "aligned",
    vertex_spirv: PICTURE,
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/aligned.frag.spv"),
    bindings: &[
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Sampled(Access::FragmentSampled),
        BindingKind::Image(Access::FragmentRead),
    ],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    offset: [f32; 2],
    range: [f32; 2],
    scale: f32,
    levels: u32,
    slices: u32,
    show: u32,
    keep_contrast: u32,
}

/// How two levels are blended where the shade lies between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LevelBlend {
    /// As the hardware blends, with the contrast given back that averaging takes (Heitz and Neyret, *High-Performance
    /// By-Example Noise using a Histogram-Preserving Blending Operator*, 2018, equation 2).
    #[default]
    Contrast,
    /// As the hardware blends: the thesis's.
    Linear,
}

/// How a frame is drawn; may change from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignedFrame {
    /// Texels of the texture to a pixel of the picture, 0.05 to 4: the scale on s and t. With 1 marks have the size
    /// that they have in the strip, with 2 half of it. Beyond 1 fine marks begin to alias.
    pub density: f32,
    /// Where the texture lies, in pixels of the picture; grows as the texture moves to the left and up. A host lets it
    /// follow what moves ([`screen_displacement`]; thesis chapter 7).
    pub offset_px: [f32; 2],
    /// How levels are blended.
    pub blend: LevelBlend,
    /// The range of shade that is spread over the strip.
    pub range: ShadeRange,
    /// What is shown.
    pub show: Show,
}

impl Default for AlignedFrame {
    fn default() -> Self {
        AlignedFrame {
            density: 1.0,
            offset_px: [0.0; 2],
            blend: LevelBlend::default(),
            range: ShadeRange::default(),
            show: Show::default(),
        }
    }
}

impl AlignedFrame {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a density out of range or an offset that is not finite.
    pub fn check(&self) -> Result<()> {
        if !DENSITY.contains(&self.density) {
            return Err(Error::parameter("density", self.density, "0.05 to 4 texels to a pixel"));
        }
        if let Some(stray) = self.offset_px.iter().find(|offset| !offset.is_finite()) {
            return Err(Error::parameter("offset_px", stray, "finite"));
        }
        Ok(())
    }
}

/// The technique, prepared for a scene's guides and its paints.
pub struct AlignedTechnique {
    levels: LevelVolume,
    colors: ColorTable,
    pass: PicturePass,
    frame: Image,
    set: BindingSet,
}

impl AlignedTechnique {
    /// Prepares to paint what `guides` draws, with levels that may still be under preparation. Object i is painted with
    /// paint `paint_of_object[i]` of the levels, in the colours of `trajectories` at the same place.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is not one trajectory for each paint, or an object without a paint;
    /// [`Error::Memory`] when the budget does not allow it.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        guides: &GuidePass,
        levels: LevelVolume,
        trajectories: &[&Trajectory],
        paint_of_object: &[u32],
    ) -> Result<Self> {
        let paints = levels.paints() as usize;
        check_paints(paints, paint_of_object, guides.object_count())?;
        if trajectories.len() != paints {
            return Err(Error::parameter(
                "trajectories",
                trajectories.len(),
                format!("one for each of {paints} paints"),
            ));
        }
        let colors = ColorTable::new(context, uploads, trajectories.iter().copied())?;
        let frame = frame_for(context, ALIGNED.name, guides.depth())?;
        let pass = PicturePass::new(context, ALIGNED, &[&frame], guides.depth())?;
        let (repeat, clamp) = (vk::SamplerAddressMode::REPEAT, vk::SamplerAddressMode::CLAMP_TO_EDGE);
        let sampler = Sampler::linear(context, [repeat, repeat, clamp])?;
        let objects = paint_picture(context, uploads, paint_of_object)?;
        let bound = [
            guides.shade().into(),
            guides.id().into(),
            (&objects).into(),
            (levels.image(), &sampler).into(),
            colors.image().into(),
        ];
        let set = BindingSet::new(context, pass.pipeline(), &bound)?;
        Ok(AlignedTechnique { levels, colors, pass, frame, set })
    }

    /// The levels, to prepare and to read.
    pub fn levels(&self) -> &LevelVolume {
        &self.levels
    }

    /// The levels, to let go of what only their preparation needs.
    pub fn levels_mut(&mut self) -> &mut LevelVolume {
        &mut self.levels
    }

    /// Records a frame; the guides must have been recorded before.
    ///
    /// # Errors
    /// Those of [`AlignedFrame::check`]; nothing is recorded then.
    pub fn record(&self, recorder: &mut Recorder<'_>, frame: &AlignedFrame) -> Result<()> {
        frame.check()?;
        let push = Push {
            offset: frame.offset_px,
            range: frame.range.to_array(),
            scale: frame.density / self.levels.params().size_px as f32,
            levels: self.levels.params().levels,
            slices: self.levels.image().size_px()[2],
            show: frame.show as u32,
            keep_contrast: u32::from(frame.blend == LevelBlend::Contrast),
        };
        self.pass.record(recorder, &[(&self.set, push)]);
        Ok(())
    }

    /// Stages other colours for one of the paints. Texture stays as it is.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is no such paint, [`Error::Memory`] when the budget does not allow it.
    pub fn set_trajectory(
        &mut self,
        context: &Context,
        uploads: &mut Uploads,
        paint: usize,
        trajectory: &Trajectory,
    ) -> Result<()> {
        self.colors.set(context, uploads, paint, trajectory)
    }

    /// The frame: R8G8B8A8_UNORM, straight alpha, background 0.
    pub fn frame(&self) -> &Image {
        &self.frame
    }
}
