//! Painted shading as one effect inside of a host's frame: what a game engine holds on to.
//!
//! The rooms below are building blocks; this one drives them as an engine expects it of an effect that it embeds. An
//! [`Effect`] paints one mesh by one technique. A thread of its own prepares it, and hands over what has to run on the
//! GPU in small pieces, which the host records between its frames. From then on a frame is one call, which only
//! records. A [`Composite`] lays the picture over the host's own, behind what is nearer there.
//!
//! ```text
//! EffectDesc -> Effect::new -> [ prepare ] once a frame until it is ready
//!                                 -> each frame: record -> picture, depth -> Composite::record -> the host's image
//! ```
//!
//! Nothing here is a way of its own to paint: whoever needs more than one mesh, one technique and one picture uses
//! [`crate::technique`] and [`crate::scene`] directly. The contract with the host (layouts, barriers, threads, life
//! times) stands in docs/embedding.md.

mod composite;
mod effect;
mod preparation;
mod recordings;

pub(crate) use composite::COMPOSITE;
pub use composite::{Composite, HostDepth, Target, TargetColor};
pub use effect::{Effect, EffectFrame};
#[cfg(feature = "capi")]
pub(crate) use {composite::no_frame, effect::not_ready};

use crate::gpu::Image;
use crate::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
use crate::scene::{check_aspect, GuideImages, HostMotionParams, Lights, Mesh};
use crate::synthesis::repair::RepairParams;
use crate::technique::aligned::{AlignedFrame, LevelParams};
use crate::technique::dependent::{check_views, DependentParams, View};
use crate::technique::image::ImageParams;
use crate::technique::object::ObjectParams;
use crate::technique::{check_paints, Paint, ShadeRange};
use crate::{Error, Result};
use std::sync::Arc;

/// What is painted, with what, and how.
#[derive(Clone)]
pub struct EffectDesc {
    /// The model; each of its objects may move by itself.
    pub mesh: Arc<Mesh>,
    /// The paints.
    pub paints: Vec<EffectPaint>,
    /// For each object of the mesh which of the paints it has.
    pub paint_of_object: Vec<u32>,
    /// By which technique.
    pub method: Method,
    /// Width and height of the picture, pixels.
    pub size_px: (u32, u32),
    /// What the host draws for it.
    pub inputs: Inputs,
    /// The seed of what is synthesised once.
    pub seed: u32,
    /// Pixel comparisons of one recording of the preparation, at least 1: the size of the pieces that it is cut into.
    pub piece: u64,
}

impl EffectDesc {
    /// About 10 ms of a synthesis on two CPU cores.
    pub const PIECE: u64 = 100_000_000;

    /// One paint for all of a mesh, nothing of the host's, and pieces of [`EffectDesc::PIECE`].
    pub fn new(mesh: Arc<Mesh>, paint: EffectPaint, method: Method, size_px: (u32, u32)) -> Self {
        let paint_of_object = vec![0; mesh.objects().len()];
        let (paints, inputs) = (vec![paint], Inputs::default());
        EffectDesc { mesh, paints, paint_of_object, method, size_px, inputs, seed: 1, piece: Self::PIECE }
    }

    /// Checks what can be told without a device.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first thing that is out of range or does not fit.
    pub fn check(&self) -> Result<()> {
        check_paints(self.paints.len(), &self.paint_of_object, self.mesh.objects().len())?;
        let (width, height) = self.size_px;
        let size = |allowed| Err(Error::parameter("size_px", format!("{width}x{height}"), allowed));
        if width == 0 || height == 0 {
            return size("1 pixel a side or more");
        }
        if check_aspect(width as f32 / height as f32).is_err() {
            return size("at most 100 times as wide as high, or as high as wide: cameras see no more");
        }
        if self.piece == 0 {
            return Err(Error::parameter("piece", 0, "1 comparison or more"));
        }
        match &self.method {
            Method::Object { .. } => {}
            Method::Image { params, carry } => {
                for paint in &self.paints {
                    let size = (paint.texture.width(), paint.texture.height());
                    params.quilt.validate(size, self.size_px)?;
                    params.window_px(size.0)?;
                }
                if let Some(carry) = carry {
                    carry.check()?;
                }
            }
            Method::Aligned { levels, frame, .. } => {
                levels.check()?;
                frame.check()?;
            }
            Method::Dependent { views, view_px, params, .. } => {
                check_views(views, *view_px)?;
                params.check()?;
            }
        }
        self.inputs.check(self)
    }

    pub(crate) fn paints(&self) -> Vec<Paint<'_>> {
        self.paints.iter().map(|paint| Paint { texture: &paint.texture, trajectory: &paint.trajectory }).collect()
    }
}

/// A strip, taken apart.
#[derive(Clone)]
pub struct EffectPaint {
    /// Its texture.
    pub texture: TextureDifference,
    /// Its colours by shade, or those of another.
    pub trajectory: Trajectory,
}

impl EffectPaint {
    /// Takes a strip apart, as [`TrajectoryOptions::default`] does it.
    ///
    /// # Errors
    /// Those of [`Trajectory::extract`].
    pub fn extract(strip: &PaintSample) -> Result<Self> {
        let trajectory = Trajectory::extract(strip, &TrajectoryOptions::default())?;
        Ok(EffectPaint { texture: TextureDifference::extract(strip, &trajectory), trajectory })
    }
}

/// The technique of an effect, with its parameters.
#[derive(Clone)]
pub enum Method {
    /// Object-based texture mapping: the cheapest, with paint that is pinned to the surface.
    Object {
        /// How to map.
        params: ObjectParams,
        /// The range of shade that is spread over the strip.
        range: ShadeRange,
    },
    /// Image-based texture synthesis: the best picture, synthesised for every frame.
    Image {
        /// How to synthesise.
        params: ImageParams,
        /// Let texture follow the surface from frame to frame, and repair it where it no longer fits.
        carry: Option<RepairParams>,
    },
    /// View-aligned 3D texture projection: nearly that picture, in real time.
    Aligned {
        /// How to prepare the levels of shade.
        levels: LevelParams,
        /// How to draw. `show` is that of each frame.
        frame: AlignedFrame,
        /// Let each object's texture follow it: takes a look at every vertex, on the host, for each frame.
        follow: bool,
    },
    /// View-dependent interpolation: paint that was synthesised for views, in real time.
    Dependent {
        /// The views.
        views: Vec<View>,
        /// Width and height of a view's texture, pixels.
        view_px: u32,
        /// The lights whose shades the views are synthesised for; frames may be lit otherwise.
        lights: Lights,
        /// How to synthesise and blend.
        params: DependentParams,
    },
}

impl Method {
    /// Whether it paints over guides (shade, ID, depth), and so over a host's.
    pub fn takes_guides(&self) -> bool {
        matches!(self, Method::Image { .. } | Method::Aligned { .. })
    }

    /// Whether it goes by the motion of surfaces, and so by a host's vectors.
    pub fn takes_vectors(&self) -> bool {
        matches!(self, Method::Image { carry: Some(_), .. })
    }
}

/// Images that the host draws for an effect, of its size. What is `None` the effect draws itself.
#[derive(Clone, Default)]
pub struct Inputs {
    /// Shade, object ID and depth, for the techniques that paint over guides.
    pub guides: Option<GuideImages>,
    /// Motion vectors and how to read them, for texture that is carried.
    pub vectors: Option<(Image, HostMotionParams)>,
}

impl Inputs {
    /// Checks that all images hold something, as far as the host has told.
    fn check_content(&self) -> Result<()> {
        if let Some(guides) = &self.guides {
            let images = [("guide shade", guides.shade()), ("guide id", guides.id()), ("guide depth", guides.depth())];
            images.into_iter().try_for_each(|(name, image)| image.check_content(name))?;
        }
        self.vectors.as_ref().map_or(Ok(()), |(vectors, _)| vectors.check_content("vectors"))
    }

    fn images(&self) -> impl Iterator<Item = &Image> {
        let guides = self.guides.iter().flat_map(|guides| [guides.shade(), guides.id(), guides.depth()]);
        guides.chain(self.vectors.iter().map(|(vectors, _)| vectors))
    }

    fn check(&self, desc: &EffectDesc) -> Result<()> {
        if let Some(guides) = &self.guides {
            if !desc.method.takes_guides() {
                let allowed = "left out for a technique that draws the mesh itself";
                return Err(Error::parameter("guides", "given", allowed));
            }
            guides.shade().check_size("guides", [desc.size_px.0, desc.size_px.1, 1])?;
            if guides.object_count() != desc.mesh.objects().len() {
                let allowed = format!("the mesh's {}", desc.mesh.objects().len());
                return Err(Error::parameter("objects of the guides", guides.object_count(), allowed));
            }
        }
        if let Some((vectors, params)) = &self.vectors {
            if !desc.method.takes_vectors() {
                return Err(Error::parameter("vectors", "given", "left out where no texture is carried"));
            }
            vectors.check_size("vectors", [desc.size_px.0, desc.size_px.1, 1])?;
            params.check()?;
        }
        Ok(())
    }
}

/// How far a preparation is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// 0 to 1, never less than before.
    pub done: f32,
    /// What is being done.
    pub step: &'static str,
    /// Frames can be recorded.
    pub ready: bool,
    /// Something was recorded by the call that answers so, and has to be submitted.
    pub recorded: bool,
}

/// How much GPU memory an effect takes, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryNeeds {
    /// For as long as it lives, once it is prepared.
    pub persistent_bytes: u64,
    /// The most there is at a time while it is prepared, the persistent part among it.
    pub preparation_bytes: u64,
    /// For each frame in flight: nothing.
    pub frame_bytes: u64,
}
