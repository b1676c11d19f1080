//! An effect's picture in a host's image.

use super::effect::recorder;
use super::handles::{get, get_number, give_on, take, CompositeObject, ImpastoComposite, ImpastoEffect};
use super::image::{image, uses, ImpastoImage};
use super::memory::{not_null, read, slice, switch, value_if, versioned};
use super::params::pick;
use super::status::{guard, Failure, Result};
use super::types::*;
use crate::embed::{no_frame, not_ready, Composite, HostDepth, Target, TargetColor};
use crate::gpu::{lock, Context};
use crate::scene::Mat4;
use std::sync::{Arc, Mutex};

/// A host's image that is painted into, as large as the picture or larger. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoTarget {
    /// Its colours: R8G8B8A8 or B8G8R8A8, UNORM or SRGB, A2B10G10R10_UNORM_PACK32 or R16G16B16A16_SFLOAT, made for
    /// COLOR_ATTACHMENT.
    pub color: *const ImpastoImage,
    /// Its depth, in any format of Vulkan's for depth but D16_UNORM_S8_UINT, made for DEPTH_STENCIL_ATTACHMENT; null:
    /// nothing hides the picture.
    pub depth: *const ImpastoImage,
}

/// What a picture is laid over.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoCompositeDesc {
    /// sizeof(ImpastoCompositeDesc).
    pub struct_size: u32,
    /// How many targets, as of a swapchain; all of the same formats.
    pub target_count: u32,
    /// The targets.
    pub targets: *const ImpastoTarget,
    /// An ImpastoTargetColor.
    pub color: u32,
    /// 1: in the targets' depth nearer is more.
    pub reversed: u32,
}
versioned!(ImpastoCompositeDesc);

/// How a picture is laid over a target.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoCompositeFrame {
    /// sizeof(ImpastoCompositeFrame).
    pub struct_size: u32,
    /// The number of the target.
    pub target: u32,
    /// 16 numbers: the projection that the host has drawn the target's depth with; null: depth_a and depth_b tell.
    pub projection: *const f32,
    /// The depth that the host has for a surface at distance z is depth_a + depth_b / z.
    pub depth_a: f32,
    /// See above.
    pub depth_b: f32,
    /// Where the picture's upper left corner comes to lie in the target, pixels to the right.
    pub x_px: u32,
    /// And down.
    pub y_px: u32,
    /// The use of the target's colours, before and after.
    pub color: *const ImpastoImageUse,
    /// The use of the target's depth, if it has one.
    pub depth: *const ImpastoImageUse,
}
versioned!(ImpastoCompositeFrame);

/// Prepares to lay the picture of an effect that is ready over a host's images.
#[no_mangle]
pub unsafe extern "C" fn impasto_composite_create(
    effect: *const ImpastoEffect,
    desc: *const ImpastoCompositeDesc,
    composite: *mut *mut ImpastoComposite,
) -> ImpastoStatus {
    guard(|| {
        not_null("where the composite shall go", composite)?;
        let of_effect = effect.addr();
        let (effect, of_context) = (get(effect)?, super::handles::context_of(effect));
        let effect = lock(&effect);
        if effect.effect.picture().is_none() {
            return Err(not_ready().into());
        }
        let context = effect.context.clone();
        // SAFETY: the contract of the header, here and below.
        let desc = unsafe { read(desc) }?;
        let targets = unsafe { targets(&context, &desc) }?;
        let colors = [TargetColor::ByFormat, TargetColor::Stored, TargetColor::Light];
        let color = pick("color", desc.color, &colors)?;
        let made = Composite::new(&effect.effect, &targets, color, switch("reversed", desc.reversed)?)?;
        let object = CompositeObject { composite: made, targets, context, of_effect };
        let handle = give_on(of_context, Arc::new(Mutex::new(object)));
        unsafe { composite.write(handle) };
        Ok(())
    })
}

/// # Safety
/// The contract of the header.
unsafe fn targets(context: &Context, desc: &ImpastoCompositeDesc) -> Result<Vec<Target>> {
    // SAFETY: the caller promises it, here and below.
    let given = unsafe { slice("targets", desc.targets, desc.target_count, IMPASTO_MAX_COUNT as usize) }?;
    let target = |target: &ImpastoTarget| unsafe {
        let color = image(context, "target's colour", target.color)?;
        let depth = match target.depth.is_null() {
            true => None,
            false => Some(image(context, "target's depth", target.depth)?),
        };
        Ok(Target { color, depth })
    };
    given.iter().map(target).collect()
}

/// Records the picture of the effect's last frame into a target, and nothing if it fails. It must be submitted.
#[no_mangle]
pub unsafe extern "C" fn impasto_composite_record(
    composite: *const ImpastoComposite,
    commands: VkCommandBuffer,
    frame: *const ImpastoCompositeFrame,
) -> ImpastoStatus {
    guard(|| {
        let composite = get(composite)?;
        let composite = lock(&composite);
        // SAFETY: the contract of the header.
        unsafe { record(&composite, commands, frame) }
    })
}

/// # Safety
/// The contract of the header.
unsafe fn record(
    object: &CompositeObject,
    commands: VkCommandBuffer,
    frame: *const ImpastoCompositeFrame,
) -> Result<()> {
    // SAFETY: the caller promises it, here and below.
    let frame = unsafe { read(frame) }?;
    let effect = get_number::<ImpastoEffect>(object.of_effect)?;
    let effect = &lock(&effect).effect;
    if effect.camera().is_none() {
        return Err(no_frame().into());
    }
    let count = object.targets.len();
    let target = object.targets.get(frame.target as usize);
    let target =
        target.ok_or_else(|| Failure::parameter("target", frame.target, format!("below the {count} targets")))?;
    let depth = match (unsafe { value_if(frame.projection.cast::<[f32; 16]>()) }, &target.depth) {
        (Some(projection), _) => HostDepth::from_projection(&Mat4::from_cols_array(&projection))?,
        (None, Some(_)) => HostDepth { a: frame.depth_a, b: frame.depth_b },
        // Without a depth nothing is compared with it.
        (None, None) => HostDepth { a: 1.0, b: -1.0 },
    };
    let mut told = vec![unsafe { uses("color", &target.color, frame.color, true) }?];
    if let Some(depth) = &target.depth {
        told.push(unsafe { uses("depth", depth, frame.depth, true) }?);
    }
    let mut recorder = unsafe { recorder(&object.context, commands) }?;
    told.iter().for_each(|told| unsafe { told.begin() });
    object.composite.record(&mut recorder, effect, frame.target as usize, (frame.x_px, frame.y_px), &depth)?;
    told.iter().for_each(|told| told.end(&mut recorder));
    Ok(())
}

/// Destroys a composite; null is fine. What the GPU still uses is freed when the frame is safe.
#[no_mangle]
pub unsafe extern "C" fn impasto_composite_destroy(composite: *mut ImpastoComposite) -> ImpastoStatus {
    guard(|| take(composite))
}
