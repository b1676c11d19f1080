//! The effect itself: prepared beside the host's frames, then a frame with one call.

use super::preparation::{prepare, Guides, Motion, Prepared};
use super::recordings::{recordings, Desk, Recordings};
use super::{EffectDesc, Inputs, MemoryNeeds, Progress};
use crate::gpu::{measuring, Context, Image, Recorder};
use crate::scene::{Camera, Mesh, Moment, Spheres};
use crate::technique::aligned::{screen_displacements, AlignedFrame};
use crate::technique::dependent::Carry;
use crate::technique::Show;
use crate::{Error, Result};
use std::sync::Arc;
use std::thread::JoinHandle;

/// A mesh that is painted by one technique, picture after picture.
///
/// Belongs to one thread at a time, like the context. Dropping it is fine at any time: what the GPU still uses is
/// destroyed when the frame is safe ([`Context::advance`]); a preparation that is under way is given up, and waited for
/// on the CPU, for what it is at.
pub struct Effect {
    context: Context,
    mesh: Arc<Mesh>,
    inputs: Inputs,
    size_px: (u32, u32),
    /// What the planes of the camera close in on; none where the host draws the depth.
    spheres: Option<Spheres>,
    state: State,
    /// What of it the last frame has drawn.
    drawn_px: (u32, u32),
    /// The moment of the last frame, unless none is to go on from.
    last: Option<Moment>,
    /// Frames recorded; enters the random choices of synthesis.
    frames: u32,
}

enum State {
    Preparing(Desk, Option<JoinHandle<Result<Prepared>>>),
    Ready(Box<Prepared>),
    /// With what was told of it.
    Failed(String),
}

/// A frame, as the host wants it. Where camera and objects were in the frame before the effect remembers; a host may
/// shift the origin of its world in between, as long as camera and poses move with it.
#[derive(Clone, Copy)]
pub struct EffectFrame<'a> {
    /// Camera, lights and poses.
    pub moment: &'a Moment,
    /// The frame has nothing to do with the one before: a cut, or a jump of the camera.
    pub reset: bool,
    /// The seed of what is synthesised for this frame. The same in all frames is what a sequence wants.
    pub seed: u32,
    /// What is shown.
    pub show: Show,
    /// Width and height of what is drawn, pixels, in the picture's upper left corner: for a host that changes its
    /// resolution from frame to frame. `None`: all of the picture. Image-based painting knows no other.
    pub size_px: Option<(u32, u32)>,
}

impl<'a> EffectFrame<'a> {
    /// A painted frame that goes on from the last one.
    pub fn next(moment: &'a Moment) -> Self {
        EffectFrame { moment, reset: false, seed: 1, show: Show::Painted, size_px: None }
    }
}

impl Effect {
    /// Starts to prepare an effect, on a thread of its own.
    ///
    /// # Errors
    /// Those of [`EffectDesc::check`]; [`Error::Parameter`] for a picture that is larger than the device's images, and
    /// for inputs of another context;
    /// [`Error::Io`] when the system has no thread to give; [`Error::DeviceLost`].
    pub fn new(context: &Context, desc: EffectDesc) -> Result<Self> {
        Self::check(context, &desc)?;
        let (mesh, inputs, size_px) = (desc.mesh.clone(), desc.inputs.clone(), desc.size_px);
        let spheres = inputs.guides.is_none().then(|| Spheres::new(&mesh));
        let (recordings, desk) = recordings();
        let on_thread = context.clone();
        let thread = std::thread::Builder::new()
            .name("impasto preparation".to_owned())
            .spawn(move || prepare(&on_thread, &desc, &recordings))
            .map_err(|error| Error::io("a thread", error))?;
        let state = State::Preparing(desk, Some(thread));
        Ok(Effect {
            context: context.clone(),
            mesh,
            inputs,
            size_px,
            spheres,
            state,
            drawn_px: size_px,
            last: None,
            frames: 0,
        })
    }

    /// How much GPU memory an effect takes, without making anything of it but, for a moment, empty buffers and images
    /// whose size the driver tells. The host's part of the preparation runs, on the calling thread.
    ///
    /// It is what [`Context::allocated_bytes`] grows by, to the byte, but for view-dependent painting: how many textures
    /// that needs is only known when the views were looked through. There it is an estimate for three textures to a view,
    /// and no fewer than 48, which few meshes exceed. Blocks that memory is taken in come on top, without [`crate::gpu::HostDevice::memory`].
    ///
    /// # Errors
    /// As [`Effect::new`], and what preparing would fail with for the same reasons: [`Error::Memory`] when the budget
    /// does not allow it.
    pub fn memory(context: &Context, desc: &EffectDesc) -> Result<MemoryNeeds> {
        Self::check(context, desc)?;
        let (measuring, measured) = measuring(context)?;
        let prepared = prepare(&measuring, desc, &Recordings::to_nobody(&measuring))?;
        let frame = measuring.frame();
        measuring.advance(frame + 1, frame);
        let persistent_bytes = measuring.allocated_bytes();
        drop(prepared);
        Ok(MemoryNeeds { persistent_bytes, preparation_bytes: measured.most_bytes(), frame_bytes: 0 })
    }

    fn check(context: &Context, desc: &EffectDesc) -> Result<()> {
        context.usable()?;
        desc.check()?;
        desc.inputs.images().try_for_each(|image| context.check_same("inputs", image.context()))?;
        let (width, height) = desc.size_px;
        let most = context.caps().max_image_2d_px;
        if width.max(height) > most {
            let allowed = format!("{most} pixels a side or less on this device");
            return Err(Error::parameter("size_px", format!("{width}x{height}"), allowed));
        }
        Ok(())
    }

    /// Records the next piece of the preparation, if one is due, and tells how far it is. To be called once a frame, or
    /// more often, until it is ready; each piece is no longer than [`EffectDesc::piece`] says. Some pieces wait for
    /// [`Context::advance`] to say that the frame of an earlier one is safe.
    ///
    /// # Errors
    /// What went wrong in preparing: once as it was, then as [`Error::Device`] with its words. What was recorded for it
    /// may be submitted or thrown away. [`Error::Parameter`] for a recorder of another context; [`Error::DeviceLost`].
    pub fn prepare(&mut self, recorder: &mut Recorder<'_>) -> Result<Progress> {
        self.context.usable()?;
        self.context.check_same("recorder", recorder.context())?;
        let mut recorded = false;
        if let State::Preparing(desk, thread) = &mut self.state {
            recorded = desk.step(&self.context, recorder);
            if let Some(thread) = thread.take_if(|thread| thread.is_finished()) {
                let result = thread.join().unwrap_or_else(|_| {
                    Err(Error::Device("the preparing thread panicked: this is a fault in impasto".to_owned()))
                });
                match result {
                    Ok(prepared) => self.state = State::Ready(Box::new(prepared)),
                    Err(error) => {
                        self.state = State::Failed(error.to_string());
                        return Err(error);
                    }
                }
            }
        }
        if let State::Failed(reason) = &self.state {
            return Err(Error::Device(format!("the effect could not be prepared: {reason}")));
        }
        Ok(Progress { recorded, ..self.progress() })
    }

    /// How far the preparation is.
    pub fn progress(&self) -> Progress {
        match &self.state {
            State::Preparing(desk, _) => Progress { ready: false, ..desk.progress() },
            State::Ready(_) => Progress { done: 1.0, step: "ready", ready: true, recorded: false },
            State::Failed(_) => Progress { done: 0.0, step: "failed", ready: false, recorded: false },
        }
    }

    /// Records a frame: only that, and only into the command buffer. It is to be submitted.
    ///
    /// What the host draws for it ([`super::Inputs`]) must have been recorded before, and told with
    /// [`Image::set_state`].
    ///
    /// # Errors
    /// [`Error::NotReady`] before the preparation is over, [`Error::Parameter`] when a camera has no projection for the
    /// picture's shape, the frame's size is not within the picture's, the recorder is of another context or an image of the host's is in a layout without content,
    /// [`Error::DeviceLost`]; nothing is recorded then.
    pub fn record(&mut self, recorder: &mut Recorder<'_>, frame: &EffectFrame<'_>) -> Result<()> {
        self.context.usable()?;
        self.context.check_same("recorder", recorder.context())?;
        let size = self.drawn_size(frame)?;
        frame.moment.camera.projection(size.0 as f32 / size.1 as f32)?;
        self.inputs.check_content()?;
        recorder.draw_within(Some([(0, 0), size]));
        let recorded = self.draw(recorder, frame, size);
        recorder.draw_within(None);
        recorded
    }

    /// What of the picture a frame draws.
    fn drawn_size(&self, frame: &EffectFrame<'_>) -> Result<(u32, u32)> {
        let (width, height) = self.size_px;
        let asked = frame.size_px.unwrap_or(self.size_px);
        let fits = (1..=width).contains(&asked.0) && (1..=height).contains(&asked.1);
        let of_image = matches!(self.prepared(), Some(Prepared::Image(..)));
        if fits && (!of_image || asked == self.size_px) {
            return Ok(asked);
        }
        let least = if of_image { "" } else { "1x1 to " };
        Err(Error::parameter("size_px", format!("{}x{}", asked.0, asked.1), format!("{least}{width}x{height}")))
    }

    fn draw(&mut self, recorder: &mut Recorder<'_>, frame: &EffectFrame<'_>, size: (u32, u32)) -> Result<()> {
        let State::Ready(prepared) = &mut self.state else {
            return Err(not_ready());
        };
        let mut now = frame.moment.clone();
        if let Some(spheres) = &self.spheres {
            now.camera = spheres.close_in(&now);
        }
        let now = now;
        let before = if frame.reset { None } else { self.last.as_ref() };
        match &mut **prepared {
            Prepared::Object(technique, range) => technique.record(recorder, &now, *range, frame.show)?,
            Prepared::Image(guides, motion, technique) => {
                guides.record(recorder, &now)?;
                if let Some(motion) = motion {
                    motion.record(recorder, before, &now)?;
                }
                match (before, motion.is_some()) {
                    (Some(_), true) => technique.record_next(recorder, frame.seed, self.frames),
                    (None, true) => technique.record(recorder, frame.seed, self.frames),
                    // Without a frame to go on from each has the same choices.
                    (_, false) => technique.record(recorder, frame.seed, 0),
                }
                if frame.show != Show::Painted {
                    technique.record_recombine(recorder, frame.show);
                }
            }
            Prepared::Aligned(guides, technique, aligned, offsets) => {
                let aligned = AlignedFrame { show: frame.show, ..*aligned };
                if let Some(offsets) = offsets {
                    follow(offsets, &self.mesh, before.map(|before| [before, &now]), size, &aligned)?;
                }
                guides.record(recorder, &now)?;
                technique.record(recorder, &aligned, offsets.as_deref().unwrap_or_default())?;
            }
            Prepared::Dependent(technique) => {
                technique.record_carry(recorder, &now, if before.is_some() { Carry::Next } else { Carry::Cut });
                technique.record_picture(recorder, &now, frame.show)?;
            }
        }
        self.last = Some(now);
        self.drawn_px = size;
        self.frames = self.frames.wrapping_add(1);
        Ok(())
    }

    /// The picture: R8G8B8A8_UNORM, straight alpha, background 0. `None` before the preparation is over.
    pub fn picture(&self) -> Option<&Image> {
        Some(match self.prepared()? {
            Prepared::Object(technique, _) => technique.frame(),
            Prepared::Image(_, _, technique) => technique.frame(),
            Prepared::Aligned(_, technique, ..) => technique.frame(),
            Prepared::Dependent(technique) => technique.frame(),
        })
    }

    /// The picture's depth, 0 near to 1 far by [`Effect::camera`]; 1 where nothing is. The host's own where it draws the
    /// guides. `None` before the preparation is over.
    pub fn depth(&self) -> Option<&Image> {
        Some(match self.prepared()? {
            Prepared::Object(technique, _) => technique.depth(),
            Prepared::Image(guides, ..) | Prepared::Aligned(guides, ..) => guides.images.depth(),
            Prepared::Dependent(technique) => technique.depth(),
        })
    }

    /// The camera of the last frame, as the picture's depth has it: its planes are those of the host's camera, closed in
    /// on the mesh where the effect draws depth itself.
    pub fn camera(&self) -> Option<&Camera> {
        self.last.as_ref().map(|moment| &moment.camera)
    }

    /// Width and height of the picture, pixels.
    pub fn size_px(&self) -> (u32, u32) {
        self.size_px
    }

    /// What of the picture the last frame has drawn, from its upper left corner: width and height, pixels.
    pub fn drawn_px(&self) -> (u32, u32) {
        self.drawn_px
    }

    pub(super) fn context(&self) -> &Context {
        &self.context
    }

    fn prepared(&self) -> Option<&Prepared> {
        match &self.state {
            State::Ready(prepared) => Some(prepared),
            _ => None,
        }
    }
}

impl Drop for Effect {
    fn drop(&mut self) {
        // The thread ends when nobody records for it any more. A host that drops its device next must find it gone.
        let state = std::mem::replace(&mut self.state, State::Failed(String::new()));
        if let State::Preparing(desk, thread) = state {
            drop(desk);
            if let Some(thread) = thread {
                drop(thread.join());
            }
        }
    }
}

/// What is answered before the preparation is over.
pub(crate) fn not_ready() -> Error {
    Error::NotReady("the effect is not ready: its preparation is not over")
}

impl Guides {
    fn record(&self, recorder: &mut Recorder<'_>, now: &Moment) -> Result<()> {
        self.pass.as_ref().map_or(Ok(()), |pass| pass.record(recorder, now))
    }
}

impl Motion {
    fn record(&self, recorder: &mut Recorder<'_>, before: Option<&Moment>, now: &Moment) -> Result<()> {
        match self {
            Motion::Own(pass) => pass.record(recorder, before, now),
            Motion::Host(pass) => {
                pass.record(recorder, before.map(|before| &before.camera), &now.camera);
                Ok(())
            }
        }
    }
}

/// Lets the objects' textures follow from one moment to the next, or puts them where they begin.
fn follow(
    offsets: &mut [[f64; 2]],
    mesh: &Mesh,
    moments: Option<[&Moment; 2]>,
    size: (u32, u32),
    frame: &AlignedFrame,
) -> Result<()> {
    let Some(moments) = moments else {
        offsets.fill(frame.offset_px.map(f64::from));
        return Ok(());
    };
    for (offset, way) in offsets.iter_mut().zip(screen_displacements(mesh, moments, size)?) {
        *offset = [0, 1].map(|axis| offset[axis] - f64::from(way[axis]));
    }
    Ok(())
}
