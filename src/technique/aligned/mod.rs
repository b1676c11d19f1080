//! View-aligned 3D texture projection (thesis chapter 7): nearly the picture of image-based synthesis, in real time.
//!
//! Prepared once: the strip is cut into levels of roughly constant shade; the texture of each is quilted to a tileable
//! square, and the squares are stacked into one 3D image ([`LevelTexture`] is that on the host, and in a file). Drawn
//! for every frame: a pass over the guides that takes colour by shade, and texture by place in the picture and shade.
//!
//! The hardware's blend between two levels takes contrast from the marks, by a factor of up to the root of 2, because
//! two textures that know nothing of each other are averaged: the error that the thesis names. [`LevelBlend::Contrast`]
//! multiplies the blend's deviation from the mean (which is no difference) by what it lost.
//!
//! # Moving texture
//! Each object's texture has an offset of its own, which a host lets follow the object ([`screen_displacements`]). The
//! texture is drawn at whole pixels: it moves as the picture that it is, and is the same in every frame. Offsets in
//! between would let the filter blend neighbouring texels differently from frame to frame: at density 1, where texels
//! are pixels, marks would lose a quarter of their gradient as soon as they move. At other densities whole texels would
//! not do as well: a large texel would jump by the many pixels that it covers, and a small one would be sampled anew
//! somewhere else, as it moves by a part of a pixel. What is rounded is what is drawn, not what the host adds up, so
//! that nothing drifts.

mod follow;
mod level_texture;
mod levels;

pub use follow::screen_displacements;
pub use level_texture::LevelTexture;
pub use levels::{LevelParams, LevelPart, LevelSource, LevelVolume, Tileable};

use super::colors::ColorTable;
use super::picture_pass::{frame_for, PicturePass, PICTURE};
use super::{check_paints, picture_of_objects, ShadeRange, Show};
use crate::gpu::{
    Access, BindingKind, BindingSet, Buffer, BufferKind, Context, Image, RasterShader, Recorder, Sampler, Uploads,
};
use crate::paint::Trajectory;
use crate::scene::GuideImages;
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
    /// Where the texture lies, in pixels of the picture; grows as the texture moves to the left and up. It is drawn at
    /// the nearest whole pixel.
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

/// What the shader knows of an object.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct ObjectTexel {
    /// Where its texture lies, in repeats, 0 to 1.
    offset: [f32; 2],
    paint: u32,
    unused: u32,
}

/// The technique, prepared for a scene's guides and its paints.
pub struct AlignedTechnique {
    paint_of_object: Vec<u32>,
    /// The texels of `objects` on their way to it; those beyond the last object are never written nor looked at.
    staged: Buffer,
    objects: Image,
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
        guides: impl Into<GuideImages>,
        levels: LevelVolume,
        trajectories: &[&Trajectory],
        paint_of_object: &[u32],
    ) -> Result<Self> {
        let guides = guides.into();
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
        let pass = PicturePass::new(context, ALIGNED, &[], &[&frame], guides.depth())?;
        let (repeat, clamp) = (vk::SamplerAddressMode::REPEAT, vk::SamplerAddressMode::CLAMP_TO_EDGE);
        let sampler = Sampler::linear(context, [repeat, repeat, clamp])?;
        let paint_of_object = paint_of_object[..guides.object_count()].to_vec();
        let format = vk::Format::R32G32B32A32_UINT;
        let objects = picture_of_objects(context, "aligned objects", paint_of_object.len(), format)?;
        let bytes = objects.texels() * size_of::<ObjectTexel>() as u64;
        let staged = Buffer::new(context, "aligned objects", BufferKind::Storage, bytes)?;
        let bound = [
            guides.shade().into(),
            guides.id().into(),
            (&objects).into(),
            (levels.image(), &sampler).into(),
            colors.image().into(),
        ];
        let set = BindingSet::new(context, pass.pipeline(), &bound)?;
        Ok(AlignedTechnique { paint_of_object, staged, objects, levels, colors, pass, frame, set })
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
    /// `offsets_px` are where the objects' textures lie, in their order, as [`AlignedFrame::offset_px`] is for those
    /// beyond the last. A host that lets them follow the objects starts with that one for all and takes from each what
    /// [`screen_displacements`] gives for every step; double precision keeps the sum exact however long it goes on.
    ///
    /// # Errors
    /// Those of [`AlignedFrame::check`], and [`Error::Parameter`] for an offset that is not finite; nothing is recorded
    /// then.
    pub fn record(&self, recorder: &mut Recorder<'_>, frame: &AlignedFrame, offsets_px: &[[f64; 2]]) -> Result<()> {
        frame.check()?;
        if let Some(stray) = offsets_px.as_flattened().iter().find(|offset| !offset.is_finite()) {
            return Err(Error::parameter("offsets_px", stray, "finite"));
        }
        let texels = self.object_texels(frame, offsets_px);
        recorder.update_buffer("aligned objects", &self.staged, bytemuck::cast_slice(&texels));
        recorder.upload_image("aligned objects", &self.staged, &self.objects);
        let push = Push {
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

    fn object_texels(&self, frame: &AlignedFrame, offsets_px: &[[f64; 2]]) -> Vec<ObjectTexel> {
        let repeat_px = f64::from(self.levels.params().size_px) / f64::from(frame.density);
        let texel = |(object, &paint): (usize, &u32)| {
            let offset = offsets_px.get(object).copied().unwrap_or(frame.offset_px.map(f64::from));
            // Taken to the first repeat before single precision would round it.
            let offset = offset.map(|px| (px.round().rem_euclid(repeat_px) / repeat_px) as f32);
            ObjectTexel { offset, paint, unused: 0 }
        };
        self.paint_of_object.iter().enumerate().map(texel).collect()
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
