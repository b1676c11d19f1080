//! A frame of an effect.

use super::effect::recorder;
use super::handles::{get, EffectObject, ImpastoEffect};
use super::image::{uses, Uses};
use super::memory::{read, slice, switch, versioned};
use super::params::{lights, pick};
use super::status::{guard, Failure, Result};
use super::types::*;
use crate::embed::{not_ready, EffectFrame};
use crate::gpu::lock;
use crate::scene::{Camera, Lights, Mat4, Moment, Pose};
use crate::technique::Show;

/// A frame, as the host wants it. Matrices are column-major. Where everything was in the frame before the effect
/// remembers; a host may shift the origin of its world in between, as long as camera and poses move with it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoFrame {
    /// sizeof(ImpastoFrame).
    pub struct_size: u32,
    /// The seed of what is synthesised for this frame; the same in all frames is what a sequence wants.
    pub seed: u32,
    /// World space to view space: a turn and a move. The view may look along -z or +z.
    pub view: [f32; 16],
    /// View space to clip space with depth 0 to 1, without jitter. Depth may be reversed, and far at infinity.
    pub projection: [f32; 16],
    /// The poses, in the order of the objects.
    pub poses: *const ImpastoPose,
    /// The lights.
    pub lights: *const ImpastoLight,
    /// How many objects have a pose; the others are where the mesh has them.
    pub pose_count: u32,
    /// How many lights, 1 to 8.
    pub light_count: u32,
    /// An ImpastoShow.
    pub show: u32,
    /// 1: the frame has nothing to do with the one before: a cut, or a jump of the camera.
    pub reset: u32,
    /// Width and height of what is drawn, pixels, in the picture's upper left corner: for a host that changes its
    /// resolution from frame to frame. 0 and 0: all of the picture. Image-based painting knows no other.
    pub width_px: u32,
    /// See above.
    pub height_px: u32,
    /// The use of the picture; null: nothing to tell.
    pub picture: *const ImpastoImageUse,
    /// The use of the picture's depth. Where it is the host's image it must be told, as for the others below.
    pub depth: *const ImpastoImageUse,
    /// The use of the host's image of shades, if it has one.
    pub shade: *const ImpastoImageUse,
    /// The use of the host's image of IDs, if it has one.
    pub id: *const ImpastoImageUse,
    /// The use of the host's motion vectors, if it has any.
    pub vectors: *const ImpastoImageUse,
}
versioned!(ImpastoFrame);

/// Records a frame of an effect that is ready, and nothing if it fails. It must be submitted.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_record(
    effect: *const ImpastoEffect,
    commands: VkCommandBuffer,
    frame: *const ImpastoFrame,
) -> ImpastoStatus {
    guard(|| {
        let effect = get(effect)?;
        let mut effect = lock(&effect);
        // SAFETY: the contract of the header.
        unsafe { record(&mut effect, commands, frame) }
    })
}

/// # Safety
/// The contract of the header.
unsafe fn record(object: &mut EffectObject, commands: VkCommandBuffer, frame: *const ImpastoFrame) -> Result<()> {
    // SAFETY: the caller promises it, here and below.
    let frame = unsafe { read(frame) }?;
    if !object.effect.progress().ready {
        return Err(not_ready().into());
    }
    let show = pick("show", frame.show, &[Show::Painted, Show::Color, Show::Texture])?;
    let reset = switch("reset", frame.reset)?;
    let size_px = (frame.width_px != 0 || frame.height_px != 0).then_some((frame.width_px, frame.height_px));
    let lights = unsafe { lights(frame.lights, frame.light_count) }?;
    let now = unsafe { moment(object, &frame, lights, size_px) }?;
    // Clones are the same images; the effect itself is borrowed to record.
    let (picture, depth) = (object.effect.picture().cloned(), object.effect.depth().cloned());
    let (Some(picture), Some(depth)) = (picture, depth) else { return Err(not_ready().into()) };
    let mut told = vec![unsafe { uses("picture", &picture, frame.picture, false) }?];
    told.push(unsafe { uses("depth", &depth, frame.depth, object.guides.is_some()) }?);
    if let Some([shade, id, _]) = &object.guides {
        told.push(unsafe { uses("shade", shade, frame.shade, true) }?);
        told.push(unsafe { uses("id", id, frame.id, true) }?);
    }
    if let Some(vectors) = &object.vectors {
        told.push(unsafe { uses("vectors", vectors, frame.vectors, true) }?);
    }
    let mut recorder = unsafe { recorder(&object.context, commands) }?;
    told.iter().for_each(|told: &Uses<'_>| unsafe { told.begin() });
    let frame = EffectFrame { moment: &now, reset, seed: frame.seed, show, size_px };
    object.effect.record(&mut recorder, &frame)?;
    told.iter().for_each(|told| told.end(&mut recorder));
    Ok(())
}

/// # Safety
/// `from.poses` is as long as it says.
unsafe fn moment(
    object: &EffectObject,
    from: &ImpastoFrame,
    lights: Lights,
    size_px: Option<(u32, u32)>,
) -> Result<Moment> {
    let projection = Mat4::from_cols_array(&from.projection);
    let camera = Camera::from_matrices(&Mat4::from_cols_array(&from.view), &projection)?;
    let (width, height) = size_px.unwrap_or(object.effect.size_px());
    let aspect = f64::from(projection.y_axis.y / projection.x_axis.x).abs();
    let picture = f64::from(width) / f64::from(height);
    // A picture without a shape is refused with its size.
    if width > 0 && height > 0 && (aspect / picture - 1.0).abs() > 1e-3 {
        let allowed = format!("that of the picture, {picture}");
        return Err(Failure::parameter("aspect of the projection", aspect, allowed));
    }
    // SAFETY: the caller promises it.
    let poses = unsafe { slice("poses", from.poses, from.pose_count, object.mesh.objects().len()) }?;
    let pose = |pose: &ImpastoPose| Pose::from_matrix(&Mat4::from_cols_array(&pose.matrix));
    let poses = poses.iter().map(pose).collect::<crate::Result<_>>()?;
    Ok(Moment { camera, lights, poses })
}
