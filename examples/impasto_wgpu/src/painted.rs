//! The object that impasto paints, and how it comes into the host's frame.

use crate::host::Host;
use crate::scene::{Scene, LIGHT, NEARER_IS_MORE};
use crate::view::View;
use crate::{lend, Result};
use impasto::embed::{Composite, Effect, EffectDesc, EffectFrame, EffectPaint, HostDepth, Method, Target, TargetColor};
use impasto::gpu::{Context, Image, ResourceState};
use impasto::paint::PaintSample;
use impasto::scene::{Camera, DirectionalLight, Lights, Mesh, MeshOptions, Moment};
use impasto::technique::aligned::{AlignedFrame, LevelParams};
use std::path::PathBuf;
use std::sync::Arc;

/// One of impasto's own models and strips.
pub fn asset(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets")).join(name)
}

/// Fields are dropped in this order: the context last.
pub struct Painted {
    /// Made when the effect is ready.
    composite: Option<Composite>,
    effect: Effect,
    target: Target,
    lights: Lights,
    context: Context,
}

impl Painted {
    /// Starts to prepare the object, on a thread of its own.
    pub fn new(host: &Host, scene: &Scene) -> Result<Self> {
        let mesh = Arc::new(Mesh::load(asset("head.obj"), &MeshOptions::default())?.mesh);
        let paint = EffectPaint::extract(&PaintSample::load(asset("strip_green_yellow.png"))?)?;
        let levels = LevelParams { size_px: 256, ..LevelParams::default() };
        // Marks a little larger than in the strip, since the last pass halves them.
        let frame = AlignedFrame { density: 0.6, ..AlignedFrame::default() };
        let method = Method::Aligned { levels, frame, follow: false };
        let size = (scene.color.width(), scene.color.height());
        let desc = EffectDesc::new(mesh, paint, method, size);

        let context = lend::context(&host.adapter, &host.device)?;
        let target = Target {
            color: lend::image(&context, &scene.color, &scene.color_view)?,
            depth: Some(lend::image(&context, &scene.depth, &scene.depth_view)?),
        };
        let effect = Effect::new(&context, desc)?;
        let lights = DirectionalLight::new(LIGHT, 1.0)?.into();
        Ok(Painted { composite: None, effect, target, lights, context })
    }

    pub fn is_ready(&self) -> bool {
        self.composite.is_some()
    }

    /// To be told before a frame is recorded: which one, up to which one the device is done, and whether it is lost.
    /// What is recorded on a lost device fails, and all may be dropped.
    pub fn advance(&self, frame: u64, safe: u64, lost: bool) {
        if lost {
            self.context.device_lost();
        }
        self.context.advance(frame, safe);
    }

    /// Records the next piece of the preparation, or nothing.
    pub fn prepare(&mut self, device: &wgpu::Device) -> Result<wgpu::CommandBuffer> {
        let commands = lend::record(device, &self.context, |recorder| Ok(self.effect.prepare(recorder).map(drop)?))?;
        if self.effect.progress().ready && !self.is_ready() {
            let targets = std::slice::from_ref(&self.target);
            self.composite = Some(Composite::new(&self.effect, targets, TargetColor::Stored, NEARER_IS_MORE)?);
        }
        Ok(commands)
    }

    /// Records the object over what the host has drawn so far, seen from the same place.
    pub fn paint(&mut self, device: &wgpu::Device, view: &View) -> Result<wgpu::CommandBuffer> {
        let camera = Camera::from_matrices(&view.view, &view.projection)?;
        let moment = Moment::at_rest(camera, self.lights.clone());
        let depth = HostDepth::from_projection(&view.projection)?;
        lend::record(device, &self.context, |recorder| {
            self.effect.record(recorder, &EffectFrame::next(&moment))?;
            if let Some(composite) = &self.composite {
                for (image, state) in textures(&self.target) {
                    // SAFETY: `lend::bring_to_attachment` ends the command buffer that runs before.
                    unsafe { image.set_state(state) };
                }
                composite.record(recorder, &self.effect, 0, (0, 0), &depth)?;
                for (image, state) in textures(&self.target) {
                    recorder.hand_over(image, state);
                }
            }
            Ok(())
        })
    }
}

/// wgpu's textures, and how wgpu leaves them and expects to find them.
fn textures(target: &Target) -> impl Iterator<Item = (&Image, ResourceState)> {
    let color = [(&target.color, lend::color_attachment())].into_iter();
    color.chain(target.depth.iter().map(|depth| (depth, lend::depth_attachment())))
}
