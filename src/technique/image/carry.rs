//! Texture that follows the surface, for image-based sequences beyond the thesis: the quality of synthesis with the
//! calm of texture that is pinned to the model.
//!
//! Each pixel has a *place*: where in the strip its texture comes from. `image_carry` brings the places of the last
//! frame to where their surface is now, the repair stages of [`crate::synthesis::repair`] synthesise anew what no
//! longer fits, and `image_settle` writes the places of the new frame and draws it from the strip itself. Colours are
//! looked up once from the strip and never from a frame, so no blur builds up, however long the sequence.

use super::{ImageTechnique, RecombinePush};
use crate::gpu::{
    Access, BindingKind, BindingSet, Context, Image, ImageDesc, RasterShader, Recorder, Sampler, Uploads,
};
use crate::scene::GuideImages;
use crate::synthesis::quilt::Quilt;
use crate::synthesis::repair::{Repair, RepairParams, RepairStages, PLACES};
use crate::technique::picture_pass::{PicturePass, PICTURE};
use crate::technique::{Paint, Show};
use crate::{Error, Result};
use ash::vk;

pub(crate) const IMAGE_CARRY: RasterShader = RasterShader {
    name: "image_carry",
    vertex_spirv: PICTURE,
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/image_carry.frag.spv"),
    bindings: &[
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
    ],
    push_bytes: size_of::<CarryPush>() as u32,
};

pub(crate) const IMAGE_SETTLE: RasterShader = RasterShader {
    name: "image_settle",
    vertex_spirv: PICTURE,
    fragment_spirv: include_bytes!("../../../glsl/spirv/technique/image_settle.frag.spv"),
    bindings: &[
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Image(Access::FragmentRead),
        BindingKind::Sampled(Access::FragmentSampled),
        BindingKind::Image(Access::FragmentRead),
    ],
    push_bytes: size_of::<RecombinePush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct CarryPush {
    sample: [u32; 2],
    paint: u32,
    least: u32,
    most: u32,
}

/// What carrying needs.
pub(super) struct Carry {
    places: Image,
    layers: Vec<Layer>,
    /// Draws all paints.
    settle: PicturePass,
}

/// What it needs for a paint.
struct Layer {
    carried: Image,
    carry: PicturePass,
    carry_set: BindingSet,
    push: CarryPush,
    repair: Repair,
    settle_set: BindingSet,
}

impl Carry {
    /// Prepares to carry what `technique` paints over `guides`.
    pub(super) fn new(
        context: &Context,
        uploads: &mut Uploads,
        technique: &ImageTechnique,
        guides: &GuideImages,
        paints: &[Paint<'_>],
        motion: &Image,
        params: &RepairParams,
    ) -> Result<Self> {
        let size = technique.tone.size_px();
        motion.check("motion", &[vk::Format::R32_UINT], vk::ImageUsageFlags::STORAGE)?;
        motion.check_size("motion", size)?;
        guides.shade().check_size("guides", size)?;
        if paints.len() != technique.layers.len() {
            let allowed = format!("the {} of the technique", technique.layers.len());
            return Err(Error::parameter("paints", paints.len(), allowed));
        }
        let image = |name| Image::new(context, name, &ImageDesc::drawn(size[0], size[1], PLACES));
        let places = image("image places")?;
        let settle = PicturePass::new(context, IMAGE_SETTLE, &[], &[&technique.frame, &places], guides.depth())?;
        let sampler = Sampler::linear(context, [vk::SamplerAddressMode::CLAMP_TO_EDGE; 3])?;
        let stages = RepairStages::new(context)?;
        let mut layers = Vec::with_capacity(paints.len());
        for ((number, layer), paint) in (1..).zip(&technique.layers).zip(paints) {
            let (quilt, sample) = (&layer.quilt, &layer.sample);
            let carried = image("image carried")?;
            let carry = PicturePass::new(context, IMAGE_CARRY, &[], &[&carried, quilt.canvas()], guides.depth())?;
            let bound = [motion.into(), (&technique.guide).into(), (&places).into(), sample.image().into()];
            let carry_set = BindingSet::new(context, carry.pipeline(), &bound)?;
            let (width, height) = sample.size();
            let repair = Repair::new(context, &stages, quilt, sample, &carried, params)?;
            let desc = ImageDesc::sampled([width, height, 1], vk::Format::R8G8B8A8_UNORM);
            let difference = Image::new(context, "texture difference", &desc)?;
            uploads.image(context, &difference, bytemuck::cast_slice(&paint.texture.to_unorm8()))?;
            let bound = [
                (&technique.tone).into(),
                (&technique.guide).into(),
                quilt.source().into(),
                (&carried).into(),
                (&difference, &sampler).into(),
                technique.colors.image().into(),
            ];
            let settle_set = BindingSet::new(context, settle.pipeline(), &bound)?;
            let (least, most) = params.limits();
            let push = CarryPush { sample: [width, height], paint: number, least, most };
            layers.push(Layer { carried, carry, carry_set, push, repair, settle_set });
        }
        Ok(Carry { places, layers, settle })
    }

    /// Places, and what was carried for each paint.
    pub(super) fn images(&self) -> (&Image, Vec<&Image>) {
        (&self.places, self.layers.iter().map(|layer| &layer.carried).collect())
    }

    /// Records carrying and repairs, from the guide on; `quilts` are those of the technique.
    pub(super) fn record<'q>(
        &self,
        recorder: &mut Recorder<'_>,
        quilts: impl Iterator<Item = &'q Quilt>,
        seed: u32,
        frame: u32,
    ) {
        for (layer, quilt) in self.layers.iter().zip(quilts) {
            layer.carry.record(recorder, &[(&layer.carry_set, layer.push)]);
            layer.repair.record(recorder, quilt, seed, frame);
        }
    }

    /// Records the last stage: places of the next frame, and the picture.
    pub(super) fn settle(&self, recorder: &mut Recorder<'_>, show: Show) {
        let draw = |layer: &Layer| RecombinePush { paint: layer.push.paint, show: show as u32 };
        let draws: Vec<_> = self.layers.iter().map(|layer| (&layer.settle_set, draw(layer))).collect();
        self.settle.record(recorder, &draws);
    }
}
