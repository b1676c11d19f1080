//! The component that a game adds, and what of it comes to the render world.

use bevy::ecs::query::QueryItem;
use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponent;
use bevy::render::sync_component::SyncComponent;
use impasto::embed::{EffectDesc, EffectPaint, Method};
use impasto::paint::PaintSample;
use impasto::scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Paints a model where the entity is. The entity needs no Bevy mesh and no material.
///
/// It may be turned, moved, and scaled alike along all axes. Another one on the same entity begins a new preparation.
#[derive(Component, Clone)]
#[require(Transform, Visibility)]
pub struct Painted(Arc<Recipe>);

/// What is painted, with what, how.
struct Recipe {
    model: Arc<scene::Mesh>,
    paint: EffectPaint,
    method: Method,
    /// How much of the preparation is done, as the bits of a float; 1 when it can be seen.
    done: AtomicU32,
}

impl Painted {
    /// The whole model with one strip of paint: dark on the left, light on the right.
    ///
    /// # Errors
    /// As [`EffectPaint::extract`]: for a strip that no colours by shade can be found in.
    pub fn new(model: impl Into<Arc<scene::Mesh>>, strip: &PaintSample, method: Method) -> impasto::Result<Self> {
        let paint = EffectPaint::extract(strip)?;
        Ok(Self(Arc::new(Recipe { model: model.into(), paint, method, done: AtomicU32::new(0) })))
    }

    /// How much of the preparation is done, 0 to 1. At 1 the paint is seen.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.0.done.load(Ordering::Relaxed))
    }

    pub(crate) fn set_progress(&self, done: f32) {
        self.0.done.store(done.to_bits(), Ordering::Relaxed);
    }

    pub(crate) fn model(&self) -> &scene::Mesh {
        &self.0.model
    }

    /// True if both are clones of one component.
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// The effect for a picture of this size, prepared in pieces of so many comparisons.
    pub(crate) fn desc(&self, size_px: (u32, u32), piece: u64) -> EffectDesc {
        let Recipe { model, paint, method, .. } = &*self.0;
        EffectDesc { piece, ..EffectDesc::new(model.clone(), paint.clone(), method.clone(), size_px) }
    }
}

/// A painted entity in the render world.
#[derive(Component, Clone)]
pub struct Seen {
    pub(crate) painted: Painted,
    pub(crate) transform: GlobalTransform,
    pub(crate) visible: bool,
}

impl SyncComponent for Painted {
    type Target = Seen;
}

impl ExtractComponent for Painted {
    type QueryData = (&'static Painted, &'static GlobalTransform, &'static InheritedVisibility);
    type QueryFilter = ();
    type Out = Seen;

    fn extract_component((painted, transform, visible): QueryItem<'_, '_, Self::QueryData>) -> Option<Seen> {
        Some(Seen { painted: painted.clone(), transform: *transform, visible: visible.get() })
    }
}
