//! A host's own motion vectors as the words that techniques read: an engine knows how its surfaces move, also those
//! that are no rigid objects, and has an image of it.
//!
//! It takes the place of [`super::MotionPass`] after the host has drawn its guides and vectors. Vectors say where a
//! surface was, not whether the previous frame showed it: that is decided by the ID and the depth at the place then.
//! Its oracle is in its test.

use super::last_guides::LastGuides;
use super::{Camera, GuideImages};
use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Sampler, Shader,
};
use crate::{Error, Result};
use ash::vk;

pub(crate) const HOST_MOTION: Shader = Shader {
    name: "host_motion",
    spirv: include_bytes!("../../glsl/spirv/scene/host_motion.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Sampled(Access::ComputeSampled),
        BindingKind::Sampled(Access::ComputeSampled),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Sampled(Access::ComputeSampled),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    scale: [f32; 2],
    nearness_now: [f32; 2],
    nearness_then: [f32; 2],
    same: f32,
}

/// How a host's motion vectors are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HostMotionParams {
    /// What a vector is multiplied by, in x and y, to be the way from a pixel to its surface's place in the previous
    /// frame, in pixels to the right and down. For vectors in normalised device coordinates that is half of the
    /// picture's width and height. Vectors that point from the previous place to this one change both signs, and a y
    /// that points up changes its own.
    pub scale: [f32; 2],
    /// How much the distance along the view axis may change from one frame to the next, 0 to 1 of the distance now. A
    /// surface that comes nearer or goes away faster than that, by its own motion or the camera's, counts as hidden; a
    /// surface of the same object less than that behind another counts as shown.
    pub depth_tolerance: f32,
}

impl Default for HostMotionParams {
    /// Vectors in pixels, from a pixel to its previous place; 2 %.
    fn default() -> Self {
        HostMotionParams { scale: [1.0; 2], depth_tolerance: 0.02 }
    }
}

impl HostMotionParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first one out of range.
    pub fn check(&self) -> Result<()> {
        if let Some(stray) = self.scale.iter().find(|scale| !scale.is_finite()) {
            return Err(Error::parameter("scale", stray, "finite"));
        }
        if !(0.0..=1.0).contains(&self.depth_tolerance) {
            return Err(Error::parameter("depth tolerance", self.depth_tolerance, "0 to 1"));
        }
        Ok(())
    }
}

/// A host's motion from frame to frame, and what the next frame needs of this one.
pub struct HostMotion {
    last: LastGuides,
    params: HostMotionParams,
    motion: Image,
    stage: ComputePipeline,
    set: BindingSet,
}

impl HostMotion {
    /// Prepares to read `vectors`: R16G16_SFLOAT, R32G32_SFLOAT or R16G16B16A16_SFLOAT (the first two channels), made
    /// for SAMPLED, of the size of `guides`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters out of range, vectors of another format, use or size, or guides that cannot
    /// be sampled or copied from (see [`GuideImages::new`]); [`Error::Memory`] when the budget does not allow it,
    /// [`Error::Vulkan`] when a call fails.
    pub fn new(
        context: &Context,
        guides: impl Into<GuideImages>,
        vectors: &Image,
        params: &HostMotionParams,
    ) -> Result<Self> {
        use vk::Format as F;
        params.check()?;
        let guides = guides.into();
        let formats = [F::R16G16_SFLOAT, F::R32G32_SFLOAT, F::R16G16B16A16_SFLOAT];
        vectors.check("vectors", &formats, vk::ImageUsageFlags::SAMPLED)?;
        vectors.check_size("vectors", guides.id().size_px())?;
        let last = LastGuides::new(context, &guides)?;
        let [width, height, _] = guides.id().size_px();
        let motion = Image::new(context, "motion", &ImageDesc::storage_2d(width, height, F::R32_UINT))?;
        let sampler = Sampler::nearest(context)?;
        let stage = ComputePipeline::new(context, &HOST_MOTION)?;
        let ([id, depth], [id_then, depth_then]) = (last.now(), last.then());
        let bound = [
            id.into(),
            (depth, &sampler).into(),
            (vectors, &sampler).into(),
            id_then.into(),
            (depth_then, &sampler).into(),
            (&motion).into(),
        ];
        let set = BindingSet::new(context, &stage, &bound)?;
        Ok(HostMotion { last, params: *params, motion, stage, set })
    }

    /// Records the motion of a frame that the host has drawn with `now`, and keeps the frame for the next. `previous`
    /// is the camera of the frame that was kept last; with `None` nothing has been shown before. Only the cameras' near
    /// and far planes are looked at (see [`Camera::with_planes`]).
    pub fn record(&self, recorder: &mut Recorder<'_>, previous: Option<&Camera>, now: &Camera) {
        let [width, height, _] = self.motion.size_px();
        recorder.clear_images("host_motion_clear", &[&self.motion]);
        if let Some(then) = previous {
            let [nearness_now, nearness_then] = [now, then].map(|camera| [camera.near(), camera.far()].map(f32::recip));
            let HostMotionParams { scale, depth_tolerance: same } = self.params;
            let push = Push { scale, nearness_now, nearness_then, same };
            recorder.dispatch(&self.stage, &self.set, &push, [width.div_ceil(16), height.div_ceil(8), 1]);
        }
        self.last.record(recorder, "host_motion_keep");
    }

    /// The way from each pixel to its surface's place in the previous frame, as [`super::MotionPass::motion`] has it.
    pub fn motion(&self) -> &Image {
        &self.motion
    }
}
