//! An effect's picture in a host's image: laid over what is there, and hidden by what is nearer there.

use super::effect::{not_ready, Effect};
use crate::gpu::{
    Access, Attachment, BindingKind, BindingSet, Context, Draw, Framebuffer, Image, RasterDesc, RasterPipeline,
    RasterShader, Recorder, RenderPass, Role, Sampler,
};
use crate::scene::{perspective_depth, Camera};
use crate::technique::picture_pass::PICTURE;
use crate::{Error, Result};
use ash::vk;
use glam::Mat4;

pub(crate) const COMPOSITE: RasterShader = RasterShader {
    name: "composite",
    vertex_spirv: PICTURE,
    fragment_spirv: include_bytes!("../../glsl/spirv/embed/composite.frag.spv"),
    bindings: &[BindingKind::Image(Access::FragmentRead), BindingKind::Sampled(Access::FragmentSampled)],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    to_host: [f32; 2],
    at: [i32; 2],
}

/// A host's image that is painted into, as large as the picture or larger. A host with several in turn, as those of a
/// swapchain, brings all of them.
#[derive(Clone)]
pub struct Target {
    /// Its colours: R8G8B8A8 or B8G8R8A8, UNORM or SRGB, A2B10G10R10_UNORM, or R16G16B16A16_SFLOAT, made for
    /// COLOR_ATTACHMENT.
    pub color: Image,
    /// Its depth, in any of Vulkan's depth formats but D16_UNORM_S8_UINT, made for DEPTH_STENCIL_ATTACHMENT. A stencil
    /// that it has stays as it is. Without depth nothing hides the picture.
    pub depth: Option<Image>,
}

/// What the colours of a target are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TargetColor {
    /// As its format suggests: light in SRGB and float formats, else stored values.
    #[default]
    ByFormat,
    /// Values as files have them. Paint looks as in the strip where they are shown as they are.
    Stored,
    /// Light: paint is decoded (IEC 61966-2-1), and looks as in the strip where the host encodes it again, unless it
    /// maps tones in between.
    Light,
}

/// The depth that a host has for a surface at distance z along the view axis: a + b / z. True for every perspective
/// projection, also with the far plane at infinity and with depth reversed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HostDepth {
    /// What an infinite distance has.
    pub a: f32,
    /// Negative where a larger depth is farther, positive where it is nearer (reversed).
    pub b: f32,
}

impl HostDepth {
    /// Of the projection that the host draws with (view space to clip space, depth 0 to 1).
    ///
    /// # Errors
    /// [`Error::Parameter`] when it is not a perspective one.
    pub fn from_projection(projection: &Mat4) -> Result<Self> {
        let [a, b] = perspective_depth(projection)?;
        let depth = HostDepth { a, b };
        depth.check().map(|()| depth)
    }

    /// That of a camera of ours.
    pub fn of_camera(camera: &Camera) -> Self {
        let (near, far) = (f64::from(camera.near()), f64::from(camera.far()));
        HostDepth { a: (far / (far - near)) as f32, b: (-near * far / (far - near)) as f32 }
    }

    /// The depth of surfaces that are nearer by this part of their distance, as 0.001. For a host that has drawn the
    /// same mesh into its depth: there the two depths differ by rounding, and without a bias either would win here and
    /// there.
    pub fn nearer_by(self, part: f32) -> Self {
        HostDepth { b: self.b / (1.0 - part), ..self }
    }

    /// Whether nearer is more.
    pub fn is_reversed(&self) -> bool {
        self.b > 0.0
    }

    fn check(&self) -> Result<()> {
        if self.a.is_finite() && self.b.is_finite() && self.b != 0.0 {
            return Ok(());
        }
        Err(Error::parameter("depth", format!("{} + {} / z", self.a, self.b), "finite, and dependent on z"))
    }

    /// The same as x + y d of the depth d that `camera` gives: d = far / (far - near) (1 - near / z).
    fn of_depth(&self, camera: &Camera) -> [f32; 2] {
        let (near, far) = (f64::from(camera.near()), f64::from(camera.far()));
        let (a, b) = (f64::from(self.a), f64::from(self.b));
        [(a + b / near) as f32, (-b * (far - near) / (far * near)) as f32]
    }
}

/// A render pass that draws an effect's picture over a host's images.
///
/// Made for one effect, when that is ready; it keeps what it needs of it alive.
pub struct Composite {
    picture: Image,
    pass: RenderPass,
    pipeline: RasterPipeline,
    set: BindingSet,
    framebuffers: Vec<Framebuffer>,
    /// Whether the targets have depth, and whether that is reversed.
    depth: Option<bool>,
}

impl Composite {
    /// Prepares to draw the picture of `effect` over `targets`, which are all of the same formats. `reversed` says that
    /// nearer is more in their depth.
    ///
    /// # Errors
    /// [`Error::NotReady`] for an effect that is not ready; [`Error::Parameter`] for no target, one of another format, use
    /// or context, one whose colour and depth differ in size, and one that the effect itself has: its picture, or the depth of guides that the host draws for
    /// it, which the pass reads; [`Error::Vulkan`] when a call fails.
    pub fn new(effect: &Effect, targets: &[Target], color: TargetColor, reversed: bool) -> Result<Self> {
        let (Some(picture), Some(depth)) = (effect.picture(), effect.depth()) else {
            return Err(not_ready());
        };
        let Some(first) = targets.first() else { return Err(Error::parameter("targets", 0, "1 or more")) };
        let context = effect.context();
        for target in targets {
            check(context, target, first, [picture, depth])?;
        }
        depth.check_usage("depth", vk::ImageUsageFlags::SAMPLED)?;
        let light = match color {
            TargetColor::ByFormat => is_light(first.color.format()),
            TargetColor::Stored => false,
            TargetColor::Light => true,
        };
        let mut attachments = vec![Attachment { format: first.color.format(), role: Role::ColorOver }];
        if let Some(depth) = &first.depth {
            attachments.push(Attachment { format: depth.format(), role: Role::DepthOver { reversed } });
        }
        let pass = RenderPass::new(context, COMPOSITE.name, &attachments)?;
        let desc = RasterDesc {
            shader: COMPOSITE,
            vertex_bytes: 0,
            attributes: &[],
            cull_back: false,
            constants: &[u32::from(light)],
        };
        let pipeline = RasterPipeline::new(context, &pass, &desc)?;
        let bound = [picture.into(), (depth, &Sampler::nearest(context)?).into()];
        let set = BindingSet::new(context, &pipeline, &bound)?;
        let framebuffer = |target: &Target| {
            let images: Vec<&Image> = [&target.color].into_iter().chain(&target.depth).collect();
            Framebuffer::new(context, &pass, &images)
        };
        let framebuffers = targets.iter().map(framebuffer).collect::<Result<_>>()?;
        let depth = first.depth.as_ref().map(|_| reversed);
        Ok(Composite { picture: picture.clone(), pass, pipeline, set, framebuffers, depth })
    }

    /// Records the pass into the target of this number. `effect` is the one that it was made for, and has recorded the
    /// frame before. The picture's upper left corner comes to lie at `at_px` = (x, y) of the target: that of the
    /// viewport where the host draws into a part of its image. `depth` is how the host's camera of the same frame maps
    /// distance to depth.
    ///
    /// The target is left as a colour attachment (and a depth attachment), as [`Image::layout`] says;
    /// [`Recorder::hand_over`] brings it to where the host wants it. What the host has done to it since must have been
    /// told with [`Image::set_state`].
    ///
    /// # Errors
    /// [`Error::Parameter`] for another effect, a recorder of another context, a target that there is not, one in a
    /// layout without content, one in which the picture has no room there, and a depth that is not finite or runs the
    /// other way than the pass was made for; [`Error::NotReady`] when no frame was recorded; [`Error::DeviceLost`]. Nothing is recorded then.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        effect: &Effect,
        target: usize,
        at_px: (u32, u32),
        depth: &HostDepth,
    ) -> Result<()> {
        effect.context().usable()?;
        self.picture.context().check_same("recorder", recorder.context())?;
        if !effect.picture().is_some_and(|picture| picture.is_same(&self.picture)) {
            return Err(Error::parameter("effect", "another", "the one that the pass was made for"));
        }
        let count = self.framebuffers.len();
        let Some(framebuffer) = self.framebuffers.get(target) else {
            return Err(Error::parameter("target", target, format!("below the {count} targets")));
        };
        let Some(camera) = effect.camera() else {
            return Err(no_frame());
        };
        depth.check()?;
        if self.depth.is_some_and(|reversed| reversed != depth.is_reversed()) {
            let way = if depth.is_reversed() { "nearer is more" } else { "nearer is less" };
            return Err(Error::parameter("depth", way, "the way that the pass was made for"));
        }
        for (name, image) in ["target's colour", "target's depth"].into_iter().zip(framebuffer.images()) {
            image.check_content(name)?;
        }
        let (drawn, [width, height]) = (effect.drawn_px(), framebuffer.size_px());
        let room = |at: u32, drawn: u32, size: u32| at.checked_add(drawn).is_some_and(|end| end <= size);
        if !room(at_px.0, drawn.0, width) || !room(at_px.1, drawn.1, height) {
            let allowed = format!("where {}x{} have room in a target of {width}x{height}", drawn.0, drawn.1);
            return Err(Error::parameter("at_px", format!("({}, {})", at_px.0, at_px.1), allowed));
        }
        let push = Push { to_host: depth.of_depth(camera), at: [at_px.0 as i32, at_px.1 as i32] };
        let draw = Draw { set: Some(&self.set), push, range: 0..3 };
        recorder.draw_within(Some([at_px, drawn]));
        recorder.draw(&self.pass, framebuffer, &self.pipeline, None, &[draw]);
        recorder.draw_within(None);
        Ok(())
    }
}

/// What is answered before the effect has recorded a frame.
pub(crate) fn no_frame() -> Error {
    Error::NotReady("the effect has recorded no frame yet")
}

/// Checks a target of a pass that reads these images.
fn check(context: &Context, target: &Target, first: &Target, reads: [&Image; 2]) -> Result<()> {
    use vk::Format as F;
    use vk::ImageUsageFlags as U;
    for (name, image) in [("target's colour", Some(&target.color)), ("target's depth", target.depth.as_ref())] {
        let Some(image) = image else { continue };
        context.check_same(name, image.context())?;
        if reads.iter().any(|read| read.is_same(image)) {
            return Err(Error::parameter(name, "an image that the effect reads", "one apart: a copy"));
        }
    }
    let colors = [
        F::R8G8B8A8_UNORM,
        F::R8G8B8A8_SRGB,
        F::B8G8R8A8_UNORM,
        F::B8G8R8A8_SRGB,
        F::A2B10G10R10_UNORM_PACK32,
        F::R16G16B16A16_SFLOAT,
    ];
    target.color.check("target's colour", &colors, U::COLOR_ATTACHMENT)?;
    if let Some(depth) = &target.depth {
        let depths = [F::D32_SFLOAT, F::D16_UNORM, F::X8_D24_UNORM_PACK32, F::D24_UNORM_S8_UINT, F::D32_SFLOAT_S8_UINT];
        depth.check("target's depth", &depths, U::DEPTH_STENCIL_ATTACHMENT)?;
        depth.check_size("target's depth", target.color.size_px())?;
    }
    let format = |image: &Image| image.format();
    if format(&target.color) != format(&first.color)
        || target.depth.as_ref().map(format) != first.depth.as_ref().map(format)
    {
        return Err(Error::parameter("targets", "of several formats", "all of the same formats"));
    }
    Ok(())
}

/// Whether such an image holds light by custom.
fn is_light(format: vk::Format) -> bool {
    matches!(format, vk::Format::R8G8B8A8_SRGB | vk::Format::B8G8R8A8_SRGB | vk::Format::R16G16B16A16_SFLOAT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::camera::rh::proj::vulkan::{perspective, perspective_infinite_reverse};
    use glam::Vec3;

    #[test]
    fn depth_is_that_of_the_hosts_projection() {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, None, 40.0).expect("a camera");
        let camera = camera.with_planes(0.25, 30.0).expect("planes");
        let ours = camera.projection(1.5).expect("a projection");
        let fov = 40f32.to_radians();
        let reversed = perspective(fov, 1.5, 100.0, 0.1);
        let infinite = perspective_infinite_reverse(fov, 1.5, 0.1);
        let left = glam::camera::lh::proj::vulkan::perspective(fov, 1.5, 0.1, 100.0);
        for (projection, forward) in [(ours, -1.0), (reversed, -1.0), (infinite, -1.0), (left, 1.0)] {
            let depth = HostDepth::from_projection(&projection).expect("a perspective");
            let to_host = depth.of_depth(&camera);
            for z in [0.3f32, 1.0, 7.0, 29.0] {
                let d = |projection: &Mat4, forward: f32| projection.project_point3(Vec3::Z * z * forward).z;
                let (expected, own) = (d(&projection, forward), d(&ours, -1.0));
                assert!((depth.a + depth.b / z - expected).abs() < 1e-5, "{depth:?} at {z}");
                assert!((to_host[0] + to_host[1] * own - expected).abs() < 1e-4, "{depth:?} at {z}");
            }
        }
        assert!(HostDepth::from_projection(&infinite).expect("a perspective").is_reversed());
        let of_camera = HostDepth::of_camera(&camera);
        assert!((of_camera.a - HostDepth::from_projection(&ours).expect("a perspective").a).abs() < 1e-6);
        assert!(!of_camera.is_reversed());
        let flat = glam::camera::rh::proj::vulkan::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
        assert!(HostDepth::from_projection(&flat).is_err());
    }
}
