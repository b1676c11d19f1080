//! Real paint on meshes in Bevy: a small plugin on impasto.
//!
//! An entity with [`Painted`] is drawn by impasto, in place of a Bevy mesh with a material: its picture is laid over
//! the opaque things of every 3D camera, and behind what is nearer. It is lit by the scene's directional lights. Until
//! its preparation is over, between frames, nothing of it is shown.
//!
//! README.md has an example, and the limits.
#![warn(missing_docs)]

mod convert;
mod painted;
mod painter;
mod raw;

/// Compiles the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use convert::mesh;
pub use impasto;
pub use painted::Painted;

use bevy::core_pipeline::core_3d::{main_opaque_pass_3d, main_transparent_pass_3d};
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponentPlugin;
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems};
use impasto::embed::EffectDesc;

/// Paints what is [`Painted`], on Vulkan. On other backends it says so in the log, and paints nothing.
pub struct ImpastoPlugin {
    /// Pixel comparisons that a preparation may do in one frame.
    pub piece: u64,
}

impl Default for ImpastoPlugin {
    fn default() -> Self {
        Self { piece: EffectDesc::PIECE }
    }
}

impl Plugin for ImpastoPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractComponentPlugin::<Painted>::default());
        let Some(render) = app.get_sub_app_mut(RenderApp) else { return };
        let piece = self.piece;
        let start = move |world: &mut World| painter::start(world, piece);
        render
            .init_resource::<painter::SceneLights>()
            .add_systems(RenderStartup, start)
            .add_systems(ExtractSchedule, painter::extract_lights)
            .add_systems(
                Render,
                (
                    painter::begin_frame.in_set(RenderSystems::PrepareResources),
                    painter::end_frame.in_set(RenderSystems::Cleanup),
                )
                    .run_if(resource_exists::<painter::Painter>),
            )
            .add_systems(
                Core3d,
                painter::paint
                    .after(main_opaque_pass_3d)
                    .before(main_transparent_pass_3d)
                    .in_set(Core3dSystems::MainPass)
                    .run_if(resource_exists::<painter::Painter>),
            );
    }
}
