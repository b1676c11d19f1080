//! Where the surface at each pixel was in the previous frame, for what follows the surface from frame to frame
//! (thesis section 9.3: coherence in object space).
//!
//! It stands after the guide pass, reads its ID and depth, and keeps both for the next frame. A pixel's point is found
//! by its depth, moved as its object has moved, and seen through the camera of then. The previous frame showed it if it
//! had the same object at that place, and nearly the same point. The oracle is [`crate::metric::Motion::between`], from
//! now to then.

use super::last_guides::LastGuides;
use super::{GuideImages, Moment, ObjectRows};
use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Sampler, Shader,
};
use crate::Result;
use ash::vk;
use glam::{DMat4, DVec4};

pub(crate) const MOTION: Shader = Shader {
    name: "motion",
    spirv: include_bytes!("../../glsl/spirv/scene/motion.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Sampled(Access::ComputeSampled),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Sampled(Access::ComputeSampled),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    nearness_now: [f32; 4],
    nearness_then: [f32; 4],
    half_view: [f32; 2],
    near: f32,
    same: f32,
}

/// How far apart, in pixels now, a point and what was shown at its place then may be to be the same. Rounding to whole
/// pixels takes up to half a pixel's diagonal, and a slanted surface makes more of it.
const SAME_PX: f64 = 3.0;

/// Motion from frame to frame, and what the next frame needs of this one.
pub struct MotionPass {
    last: LastGuides,
    objects: ObjectRows<3>,
    motion: Image,
    stage: ComputePipeline,
    set: BindingSet,
}

impl MotionPass {
    /// Prepares to follow what `guides` draws, or what a host draws to its [`GuideImages`].
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for images that cannot be sampled or copied from (see [`GuideImages::new`]),
    /// [`crate::Error::Memory`] when the budget does not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, guides: impl Into<GuideImages>) -> Result<Self> {
        let guides = guides.into();
        let last = LastGuides::new(context, &guides)?;
        let [width, height, _] = guides.id().size_px();
        let motion = Image::new(context, "motion", &ImageDesc::storage_2d(width, height, vk::Format::R32_UINT))?;
        let objects = ObjectRows::new(context, "motion_objects", guides.object_count())?;
        let sampler = Sampler::nearest(context)?;
        let stage = ComputePipeline::new(context, &MOTION)?;
        let ([id, depth], [id_then, depth_then]) = (last.now(), last.then());
        let bound = [
            id.into(),
            (depth, &sampler).into(),
            id_then.into(),
            (depth_then, &sampler).into(),
            objects.image().into(),
            (&motion).into(),
        ];
        let set = BindingSet::new(context, &stage, &bound)?;
        Ok(MotionPass { last, objects, motion, stage, set })
    }

    /// Records the motion of a frame that was drawn at `now`, and keeps the frame for the next. `previous` is the
    /// moment of the frame that was kept last; with `None` nothing has been shown before.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when a camera has no projection for this picture's shape; nothing is recorded then.
    pub fn record(&self, recorder: &mut Recorder<'_>, previous: Option<&Moment>, now: &Moment) -> Result<()> {
        let [width, height, _] = self.motion.size_px();
        let frames = previous.map(|then| Frames::new(then, now, [width, height])).transpose()?;
        recorder.clear_images("motion_clear", &[&self.motion]);
        if let Some(frames) = frames {
            self.objects.record(recorder, |object| frames.rows(object));
            recorder.dispatch(&self.stage, &self.set, &frames.push(), [width.div_ceil(16), height.div_ceil(8), 1]);
        }
        self.last.record(recorder, "motion_keep");
        Ok(())
    }

    /// The way from each pixel to its surface's place in the previous frame, R32_UINT: twice 15 bits, x low, each
    /// 16,384 + 64 times the pixels to the right or down, rounded; the highest bit is set where the previous frame
    /// showed the surface. 0 in the background, and for ways of 256 pixels and more.
    pub fn motion(&self) -> &Image {
        &self.motion
    }
}

/// Two frames, and how to get from one to the other. In 64 bits: what is nearly the same on either side cancels here,
/// so that the shader need not be exact.
struct Frames<'a> {
    then: &'a Moment,
    now: &'a Moment,
    size: [u32; 2],
    /// From world space to clip space then.
    to_then: DMat4,
    /// From places (x, y, 1 - depth, 1) of clip space to world space, then and now.
    from: [DMat4; 2],
}

impl<'a> Frames<'a> {
    fn new(then: &'a Moment, now: &'a Moment, size: [u32; 2]) -> Result<Self> {
        let aspect = size[0] as f32 / size[1] as f32;
        let to_then = then.camera.view_projection(aspect)?.as_dmat4();
        let to_now = now.camera.view_projection(aspect)?.as_dmat4();
        let depth = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::NEG_Z, DVec4::new(0.0, 0.0, 1.0, 1.0));
        let from = [to_then, to_now].map(|matrix| matrix.inverse() * depth);
        Ok(Frames { then, now, size, to_then, from })
    }

    /// What takes places now to clip space then, by the distance now.
    fn rows(&self, object: usize) -> [[f32; 4]; 3] {
        let moved = self.then.pose(object).matrix() * self.now.pose(object).matrix().inverse();
        let matrix = self.to_then * moved * self.from[1];
        [0, 1, 3].map(|row| matrix.row(row).as_vec4().to_array())
    }

    fn push(&self) -> Push {
        let [width, height] = self.size.map(f64::from);
        let half_view = |moment: &Moment| {
            let down = (f64::from(moment.camera.fov_y_deg()).to_radians() / 2.0).tan();
            [down * width / height, down]
        };
        let [nearness_then, nearness_now] = self.from.map(|from| from.row(3).as_vec4().to_array());
        Push {
            nearness_now,
            nearness_then,
            half_view: half_view(self.then).map(|half| half as f32),
            near: self.then.camera.near(),
            same: (SAME_PX * 2.0 * half_view(self.now)[1] / height) as f32,
        }
    }
}
