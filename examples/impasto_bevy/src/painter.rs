//! The render world's side: effects, their preparation between frames, and their pictures in the views.

use crate::convert::{self, Place};
use crate::painted::{Painted, Seen};
use crate::raw::{self, Attachment};
use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::light::DirectionalLight;
use bevy::platform::cell::SyncCell;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::Extract;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_resource::TextureView;
use bevy::render::renderer::{RenderAdapter, RenderContext, RenderDevice, RenderInstance, RenderQueue, ViewQuery};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::{ExtractedView, ViewDepthTexture, ViewTarget};
use impasto::embed::{Composite, Effect, EffectFrame, HostDepth, Target, TargetColor};
use impasto::gpu::{Context, Recorder};
use impasto::scene::{Lights, Moment};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The scene's lights, as impasto has them.
#[derive(Resource, Default)]
pub(crate) struct SceneLights(Lights);

pub(crate) fn extract_lights(
    mut lights: ResMut<SceneLights>,
    all: Extract<Query<(&DirectionalLight, &GlobalTransform, &InheritedVisibility)>>,
) {
    let visible = all.iter().filter(|(.., visible)| visible.get());
    lights.0 = convert::lights(visible.map(|(light, transform, _)| (light, transform))).unwrap_or_default();
}

/// All that is impasto's. Bevy may hand it from thread to thread, but no two use it at a time.
#[derive(Resource)]
pub(crate) struct Painter(SyncCell<Inner>);

struct Inner {
    /// Effects by view and painted entity: each has a picture of the view's size.
    shown: HashMap<(Entity, Entity), Shown>,
    context: Context,
    piece: u64,
    frame: u64,
    /// The last frame that the GPU is done with.
    safe: Arc<AtomicU64>,
    // The last to go: the context is on it.
    device: RenderDevice,
}

impl Drop for Inner {
    fn drop(&mut self) {
        // A context may only go when the GPU is done with all that was recorded through it.
        if let Err(error) = self.device.poll(wgpu::PollType::wait_indefinitely()) {
            error!("waiting for the GPU: {error}");
        }
    }
}

/// Makes the context, once there is a device.
pub(crate) fn start(world: &mut World, piece: u64) {
    let device = world.resource::<RenderDevice>().clone();
    match raw::context(&device, world.resource::<RenderAdapter>(), world.resource::<RenderInstance>()) {
        Ok(context) => {
            let inner = Inner { shown: HashMap::new(), context, piece, frame: 0, safe: Arc::default(), device };
            world.insert_resource(Painter(SyncCell::new(inner)));
        }
        Err(error) => error!("nothing will be painted: {error}"),
    }
}

/// Counts frames, and lets go of what is gone from the scene.
pub(crate) fn begin_frame(
    mut painter: ResMut<Painter>,
    painted: Query<MainEntity, With<Seen>>,
    views: Query<MainEntity, With<ExtractedCamera>>,
) {
    let painter = painter.0.get();
    let (painted, views): (EntityHashSet, EntityHashSet) = (painted.iter().collect(), views.iter().collect());
    painter.shown.retain(|(view, entity), _| views.contains(view) && painted.contains(entity));
    painter.frame += 1;
    painter.context.advance(painter.frame, painter.safe.load(Ordering::Acquire));
}

/// Asks to be told when the GPU is done with the frame, and tells the components how far they are.
pub(crate) fn end_frame(mut painter: ResMut<Painter>, queue: Res<RenderQueue>) {
    let painter = painter.0.get();
    let (frame, safe) = (painter.frame, painter.safe.clone());
    queue.on_submitted_work_done(move || {
        safe.fetch_max(frame, Ordering::Release);
    });
    // The least of all views.
    let mut done = EntityHashMap::<f32>::default();
    for ((_, entity), shown) in &painter.shown {
        let least = done.entry(*entity).or_insert(1.0);
        *least = least.min(shown.done());
    }
    painter.shown.iter().for_each(|((_, entity), shown)| shown.painted.set_progress(done[entity]));
}

/// Records what is due for a view: preparations, pictures, and their laying over it.
pub(crate) fn paint(
    view: ViewQuery<(MainEntity, &ExtractedView, &ExtractedCamera, &ViewTarget, &ViewDepthTexture, &Msaa)>,
    entities: Query<(MainEntity, &Seen)>,
    lights: Res<SceneLights>,
    mut painter: ResMut<Painter>,
    mut ctx: RenderContext,
) {
    if entities.is_empty() {
        return;
    }
    let (view_entity, view, camera, color, depth, msaa) = view.into_inner();
    if *msaa != Msaa::Off || camera.viewport.is_some() {
        warn_once!("nothing is painted in a view with MSAA, or with a viewport of its own");
        return;
    }
    let Inner { shown, context, piece, .. } = painter.0.get();
    let context = &*context;
    let surface = Surface { view, color, depth };
    let size = surface.size_px();
    let textures = [(color.main_texture(), Attachment::Color), (&depth.texture, Attachment::Depth)];
    let recorded = raw::record(&mut ctx, context, &textures, |recorder| {
        for (entity, seen) in &entities {
            let new = || Shown::new(context, &seen.painted, size, *piece);
            let shown = shown.entry((view_entity, entity)).or_insert_with(new);
            if !shown.is(&seen.painted, size) {
                *shown = new();
            }
            shown.record(recorder, seen, &surface, &lights.0);
        }
        Ok(())
    });
    if let Err(error) = recorded {
        error_once!("nothing is painted: {error}");
    }
}

/// What a view is drawn to.
struct Surface<'a> {
    view: &'a ExtractedView,
    color: &'a ViewTarget,
    depth: &'a ViewDepthTexture,
}

impl Surface<'_> {
    fn size_px(&self) -> (u32, u32) {
        let texture = self.color.main_texture();
        (texture.width(), texture.height())
    }
}

/// A painted entity in a view.
struct Shown {
    painted: Painted,
    size_px: (u32, u32),
    /// `None` when it cannot be prepared; the log has the reason.
    effect: Option<Effect>,
    over: Option<Over>,
}

impl Shown {
    fn new(context: &Context, painted: &Painted, size_px: (u32, u32), piece: u64) -> Self {
        let effect = Effect::new(context, painted.desc(size_px, piece));
        let effect = effect.inspect_err(|error| error!("an entity is not painted: {error}")).ok();
        Shown { painted: painted.clone(), size_px, effect, over: None }
    }

    /// Whether it is what it would be made anew as.
    fn is(&self, painted: &Painted, size_px: (u32, u32)) -> bool {
        self.painted.is(painted) && self.size_px == size_px
    }

    /// How much of the preparation is done; less than 1 as long as anything is missing.
    fn done(&self) -> f32 {
        match self.effect.as_ref().map(Effect::progress) {
            Some(progress) if progress.ready => 1.0,
            Some(progress) => progress.done.min(0.999),
            None => 0.0,
        }
    }

    fn record(&mut self, recorder: &mut Recorder<'_>, seen: &Seen, surface: &Surface<'_>, lights: &Lights) {
        let Some(effect) = &mut self.effect else { return };
        match effect.prepare(recorder) {
            Ok(progress) if progress.ready && seen.visible => {
                if let Err(error) = draw(effect, &mut self.over, recorder, seen, surface, lights) {
                    warn_once!("an entity is not painted in a frame: {error}");
                }
            }
            Ok(_) => {}
            Err(error) => {
                error!("an entity is not painted: {error}");
                self.effect = None;
            }
        }
    }
}

/// Records an effect's frame, and lays it over the view.
fn draw(
    effect: &mut Effect,
    over: &mut Option<Over>,
    recorder: &mut Recorder<'_>,
    seen: &Seen,
    surface: &Surface<'_>,
    lights: &Lights,
) -> impasto::Result<()> {
    let place = Place::new(&seen.transform)?;
    let camera = place.camera(&surface.view.world_from_view, &surface.view.clip_from_view)?;
    let depth = place.depth(&surface.view.clip_from_view)?;
    let poses = vec![place.pose; seen.painted.model().objects().len()];
    let moment = Moment { poses, ..Moment::at_rest(camera, lights.clone()) };
    if !over.as_ref().is_some_and(|over| over.is_of(surface)) {
        *over = Some(Over::new(recorder.context(), effect, surface, depth.is_reversed())?);
    }
    effect.record(recorder, &EffectFrame::next(&moment))?;
    match over {
        Some(over) => over.record(recorder, effect, surface, &depth),
        None => Ok(()),
    }
}

/// An effect's picture over a view. Bevy has two textures of colour for it, which it changes between.
struct Over {
    composite: Composite,
    targets: [Target; 2],
    // What the targets are of, which they do not keep themselves. As long as the GPU is at a frame, wgpu keeps them for
    // Bevy's own passes.
    colors: [TextureView; 2],
    depth: TextureView,
}

impl Over {
    fn new(context: &Context, effect: &Effect, surface: &Surface<'_>, reversed: bool) -> impasto::Result<Self> {
        let color = surface.color;
        let depth = raw::image(context, &surface.depth.texture, surface.depth.view(), Attachment::Depth)?;
        let target = |texture, view| {
            raw::image(context, texture, view, Attachment::Color)
                .map(|color| Target { color, depth: Some(depth.clone()) })
        };
        let targets = [
            target(color.main_texture(), color.main_texture_view())?,
            target(color.main_texture_other(), color.main_texture_other_view())?,
        ];
        Ok(Over {
            composite: Composite::new(effect, &targets, TargetColor::ByFormat, reversed)?,
            targets,
            colors: [color.main_texture_view().clone(), color.main_texture_other_view().clone()],
            depth: surface.depth.view().clone(),
        })
    }

    fn index(&self, surface: &Surface<'_>) -> Option<usize> {
        self.colors.iter().position(|view| view.id() == surface.color.main_texture_view().id())
    }

    fn is_of(&self, surface: &Surface<'_>) -> bool {
        self.index(surface).is_some() && self.depth.id() == surface.depth.view().id()
    }

    fn record(
        &self,
        recorder: &mut Recorder<'_>,
        effect: &Effect,
        surface: &Surface<'_>,
        depth: &HostDepth,
    ) -> impasto::Result<()> {
        let Some(index) = self.index(surface) else { return Ok(()) };
        let target = &self.targets[index];
        Attachment::Color.take(&target.color);
        target.depth.iter().for_each(|image| Attachment::Depth.take(image));
        self.composite.record(recorder, effect, index, (0, 0), depth)?;
        recorder.hand_over(&target.color, Attachment::Color.state());
        target.depth.iter().for_each(|image| recorder.hand_over(image, Attachment::Depth.state()));
        Ok(())
    }
}
