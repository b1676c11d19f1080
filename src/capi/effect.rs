//! Effects: made, prepared beside a host's frames, and what they give.

use super::handles::{get, give_on, take, EffectObject, ImpastoContext, ImpastoEffect, ImpastoMesh, ImpastoPaint};
use super::image::{image, ImpastoImage};
use super::memory::{not_null, read, slice, text, versioned, write};
use super::params::{self, pick};
use super::params::{ImpastoAlignedParams, ImpastoDependentParams, ImpastoImageParams, ImpastoObjectParams};
use super::status::{guard, Failure, Result};
use super::types::*;
use crate::embed::{not_ready, Effect, EffectDesc, EffectPaint, Inputs, Method, Progress};
use crate::gpu::{lock, Context, Image, Recorder};
use crate::scene::{GuideImages, HostMotionParams, Mesh};
use ash::vk::Handle;
use std::ffi::c_char;
use std::sync::Arc;

/// What is painted, with what, and how.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoEffectDesc {
    /// sizeof(ImpastoEffectDesc).
    pub struct_size: u32,
    /// An ImpastoTechnique.
    pub technique: u32,
    /// The model.
    pub mesh: *const ImpastoMesh,
    /// The paints.
    pub paints: *const *const ImpastoPaint,
    /// For each object of the mesh which of the paints it has; null: all have the first.
    pub paint_of_object: *const u32,
    /// How many paints.
    pub paint_count: u32,
    /// How many objects paint_of_object tells of.
    pub object_count: u32,
    /// Width of the picture, pixels.
    pub width_px: u32,
    /// Height of the picture, pixels.
    pub height_px: u32,
    /// Pixel comparisons of one recording of the preparation; 0: 25 million, less than a millisecond of a large GPU.
    pub piece: u64,
    /// Parameters of the technique, at most one of these four; null: the defaults.
    pub object: *const ImpastoObjectParams,
    /// See above.
    pub image: *const ImpastoImageParams,
    /// See above.
    pub aligned: *const ImpastoAlignedParams,
    /// See above.
    pub dependent: *const ImpastoDependentParams,
    /// The host's own image of shades, for IMPASTO_TECHNIQUE_IMAGE and IMPASTO_TECHNIQUE_ALIGNED, together with id and
    /// depth; null: the library draws all three. VK_FORMAT_R32_SFLOAT, made for STORAGE; 0 dark to 1 light.
    pub shade: *const ImpastoImage,
    /// Object index + 1, and 0 in the background. VK_FORMAT_R32_UINT, made for STORAGE, and for TRANSFER_SRC where
    /// texture is carried.
    pub id: *const ImpastoImage,
    /// 0 near to 1 far by the projection of the frame, 1 where id is 0. VK_FORMAT_D32_SFLOAT or
    /// VK_FORMAT_X8_D24_UNORM_PACK32, made for DEPTH_STENCIL_ATTACHMENT, for SAMPLED where the picture is laid over
    /// others, and for SAMPLED and TRANSFER_SRC where texture is carried.
    pub depth: *const ImpastoImage,
    /// The host's motion vectors, where IMPASTO_TECHNIQUE_IMAGE carries texture; null: the library follows the poses.
    /// Two or four channels of floats, made for SAMPLED.
    pub vectors: *const ImpastoImage,
    /// What a vector is multiplied by to be the way from a pixel to its surface's place in the previous frame, in
    /// pixels to the right and down.
    pub vectors_scale: [f32; 2],
    /// How much the distance of a surface may change in a frame, 0 to 1 of it.
    pub vectors_depth_tolerance: f32,
    /// The seed of what is synthesised once.
    pub seed: u32,
}
versioned!(ImpastoEffectDesc);

/// How far a preparation is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoProgress {
    /// sizeof(ImpastoProgress), set by the caller.
    pub struct_size: u32,
    /// 1: frames can be recorded.
    pub ready: u32,
    /// 0 to 1, never less than before.
    pub done: f32,
    /// 1: the last call of impasto_effect_prepare() has recorded something.
    pub recorded: u32,
    /// What is being done.
    pub step: [c_char; 48],
}
versioned!(ImpastoProgress);

/// How much GPU memory an effect takes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoMemory {
    /// sizeof(ImpastoMemory), set by the caller.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// Bytes that it keeps once it is ready.
    pub persistent_bytes: u64,
    /// Bytes that it takes at the most while it is prepared.
    pub preparation_bytes: u64,
    /// Bytes that a frame takes besides: 0.
    pub frame_bytes: u64,
}
versioned!(ImpastoMemory);

/// An image of an effect.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoPicture {
    /// sizeof(ImpastoPicture), set by the caller.
    pub struct_size: u32,
    /// Its format.
    pub format: VkFormat,
    /// The image; it lives as long as the effect.
    pub image: VkImage,
    /// A view of the whole of it.
    pub view: VkImageView,
    /// Its width, pixels.
    pub width_px: u32,
    /// Its height, pixels.
    pub height_px: u32,
    /// What it was made for.
    pub usage: VkImageUsageFlags,
    /// The layout that it lies in after all that was recorded.
    pub layout: VkImageLayout,
    /// The distances that depth 0 and depth 1 stand for in the last frame; 0 before the first.
    pub near_plane: f32,
    /// See above.
    pub far_plane: f32,
}
versioned!(ImpastoPicture);

/// Fills in the defaults of the library for a technique; what has none is 0. The caller has set struct_size.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_desc_init(desc: *mut ImpastoEffectDesc, technique: u32) -> ImpastoStatus {
    guard(|| {
        check_technique(technique)?;
        let motion = HostMotionParams::default();
        // SAFETY: zeros are numbers and null pointers.
        let zero: ImpastoEffectDesc = unsafe { std::mem::zeroed() };
        let defaults = ImpastoEffectDesc {
            technique,
            piece: EffectDesc::PIECE,
            vectors_scale: motion.scale,
            vectors_depth_tolerance: motion.depth_tolerance,
            seed: 1,
            ..zero
        };
        // SAFETY: the contract of the header.
        unsafe { write(desc, &defaults) }
    })
}

fn check_technique(technique: u32) -> Result<ImpastoTechnique> {
    use ImpastoTechnique as T;
    pick("technique", technique, &[T::Object, T::Image, T::Aligned, T::Dependent])
}

/// Tells how much GPU memory an effect would take, without making it.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_memory(
    context: *const ImpastoContext,
    desc: *const ImpastoEffectDesc,
    memory: *mut ImpastoMemory,
) -> ImpastoStatus {
    guard(|| {
        let context = get(context)?;
        // SAFETY: the contract of the header, here and below.
        let (_, desc, _) = unsafe { describe(&context, desc) }?;
        let needs = Effect::memory(&context, &desc)?;
        let told = ImpastoMemory {
            struct_size: 0,
            reserved: 0,
            persistent_bytes: needs.persistent_bytes,
            preparation_bytes: needs.preparation_bytes,
            frame_bytes: needs.frame_bytes,
        };
        unsafe { write(memory, &told) }
    })
}

/// Starts to prepare an effect, on a thread of its own. Mesh and paints may be destroyed then.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_create(
    context: *const ImpastoContext,
    desc: *const ImpastoEffectDesc,
    effect: *mut *mut ImpastoEffect,
) -> ImpastoStatus {
    guard(|| {
        not_null("where the effect shall go", effect)?;
        let of_context = context.addr();
        let context = get(context)?;
        // SAFETY: the contract of the header, here and below.
        let (mesh, desc, guides) = unsafe { describe(&context, desc) }?;
        let vectors = desc.inputs.vectors.as_ref().map(|(vectors, _)| vectors.clone());
        let object = EffectObject { effect: Effect::new(&context, desc)?, context, mesh, guides, vectors };
        let handle = give_on(of_context, Arc::new(std::sync::Mutex::new(object)));
        unsafe { effect.write(handle) };
        Ok(())
    })
}

/// # Safety
/// The contract of the header.
unsafe fn describe(
    context: &Context,
    from: *const ImpastoEffectDesc,
) -> Result<(Arc<Mesh>, EffectDesc, Option<[Image; 3]>)> {
    // SAFETY: the caller promises it, here and below.
    let from = unsafe { read(from) }?;
    let method = unsafe { method(&from) }?;
    let mesh: Arc<Mesh> = get(from.mesh)?;
    let handles = unsafe { slice("paints", from.paints, from.paint_count, IMPASTO_MAX_COUNT as usize) }?;
    let paints: Vec<EffectPaint> =
        handles.iter().map(|&paint| Ok(get(paint)?.as_ref().clone())).collect::<Result<_>>()?;
    let paint_of_object = match from.paint_of_object.is_null() && from.object_count == 0 {
        true => vec![0; mesh.objects().len()],
        false => {
            let count = from.object_count;
            let told = unsafe { slice("paint_of_object", from.paint_of_object, count, IMPASTO_MAX_COUNT as usize) }?;
            told.to_vec()
        }
    };
    let guides = unsafe { guides(context, &from) }?;
    let vectors = match from.vectors.is_null() {
        true => None,
        false => {
            let (scale, depth_tolerance) = (from.vectors_scale, from.vectors_depth_tolerance);
            let vectors = unsafe { image(context, "vectors", from.vectors) }?;
            Some((vectors, HostMotionParams { scale, depth_tolerance }))
        }
    };
    let images = |[shade, id, depth]: &[Image; 3]| GuideImages::new(shade, id, depth, mesh.objects().len());
    let inputs = Inputs { guides: guides.as_ref().map(images).transpose()?, vectors };
    let desc = EffectDesc {
        mesh: mesh.clone(),
        paints,
        paint_of_object,
        method,
        size_px: (from.width_px, from.height_px),
        inputs,
        seed: from.seed,
        piece: if from.piece == 0 { EffectDesc::PIECE } else { from.piece },
    };
    Ok((mesh, desc, guides))
}

/// # Safety
/// The contract of the header.
unsafe fn method(from: &ImpastoEffectDesc) -> Result<Method> {
    let technique = check_technique(from.technique)?;
    let given = [!from.object.is_null(), !from.image.is_null(), !from.aligned.is_null(), !from.dependent.is_null()];
    if given.iter().enumerate().any(|(other, given)| *given && other != from.technique as usize) {
        return Err(Failure::parameter("parameters", "those of another technique", "those of the effect's"));
    }
    // SAFETY: the caller promises it.
    unsafe {
        match technique {
            ImpastoTechnique::Object => params::object(from.object),
            ImpastoTechnique::Image => params::image(from.image),
            ImpastoTechnique::Aligned => params::aligned(from.aligned),
            ImpastoTechnique::Dependent => params::dependent(from.dependent),
        }
    }
}

/// # Safety
/// The contract of the header.
unsafe fn guides(context: &Context, from: &ImpastoEffectDesc) -> Result<Option<[Image; 3]>> {
    let given = [from.shade, from.id, from.depth];
    if given.iter().all(|image| image.is_null()) {
        return Ok(None);
    }
    // SAFETY: the caller promises it. One that is null among them is found here.
    unsafe {
        Ok(Some([
            image(context, "shade", from.shade)?,
            image(context, "id", from.id)?,
            image(context, "depth", from.depth)?,
        ]))
    }
}

/// A recorder into a host's command buffer.
///
/// # Safety
/// `commands` is null, or recording as the header wants it.
pub(super) unsafe fn recorder(context: &Context, commands: VkCommandBuffer) -> Result<Recorder<'_>> {
    if commands.is_null() {
        return Err(Failure::new(ImpastoStatus::NullPointer, "the command buffer is null"));
    }
    // SAFETY: the caller promises it.
    Ok(unsafe { Recorder::new(context, commands, None) })
}

/// Records the next piece of the preparation, if one is due. Once a frame, or more often, until it is ready. `progress`
/// may be null.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_prepare(
    effect: *const ImpastoEffect,
    commands: VkCommandBuffer,
    progress: *mut ImpastoProgress,
) -> ImpastoStatus {
    guard(|| {
        let effect = get(effect)?;
        let mut effect = lock(&effect);
        let EffectObject { effect, context, .. } = &mut *effect;
        // SAFETY: the contract of the header, here and below.
        let mut recorder = unsafe { recorder(context, commands) }?;
        let told = effect.prepare(&mut recorder)?;
        match progress.is_null() {
            true => Ok(()),
            false => unsafe { tell(&told, progress) },
        }
    })
}

/// Tells how far the preparation is.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_progress(
    effect: *const ImpastoEffect,
    progress: *mut ImpastoProgress,
) -> ImpastoStatus {
    guard(|| {
        let effect = get(effect)?;
        let told = lock(&effect).effect.progress();
        // SAFETY: the contract of the header.
        unsafe { tell(&told, progress) }
    })
}

/// # Safety
/// The contract of the header.
unsafe fn tell(progress: &Progress, to: *mut ImpastoProgress) -> Result<()> {
    let (ready, recorded) = (u32::from(progress.ready), u32::from(progress.recorded));
    let told = ImpastoProgress { struct_size: 0, ready, done: progress.done, recorded, step: text(progress.step) };
    // SAFETY: the caller promises it.
    unsafe { write(to, &told) }
}

/// Tells of the picture: VK_FORMAT_R8G8B8A8_UNORM, straight alpha, background 0.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_picture(
    effect: *const ImpastoEffect,
    picture: *mut ImpastoPicture,
) -> ImpastoStatus {
    // SAFETY: the contract of the header.
    guard(|| unsafe { tell_image(effect, picture, Effect::picture) })
}

/// Tells of the picture's depth, 0 near to 1 far, and 1 where nothing is; the host's own where it draws the guides.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_depth(
    effect: *const ImpastoEffect,
    depth: *mut ImpastoPicture,
) -> ImpastoStatus {
    // SAFETY: the contract of the header.
    guard(|| unsafe { tell_image(effect, depth, Effect::depth) })
}

/// # Safety
/// The contract of the header.
unsafe fn tell_image(
    effect: *const ImpastoEffect,
    to: *mut ImpastoPicture,
    which: impl Fn(&Effect) -> Option<&Image>,
) -> Result<()> {
    let effect = get(effect)?;
    let effect = lock(&effect);
    let image = which(&effect.effect).ok_or_else(not_ready)?;
    let [width_px, height_px, _] = image.size_px();
    let camera = effect.effect.camera();
    let picture = ImpastoPicture {
        struct_size: 0,
        format: image.format(),
        image: image.handle(),
        view: image.view(),
        width_px,
        height_px,
        usage: image.usage(),
        layout: image.layout(),
        near_plane: camera.map_or(0.0, |camera| camera.near()),
        far_plane: camera.map_or(0.0, |camera| camera.far()),
    };
    // SAFETY: the caller promises it.
    unsafe { write(to, &picture) }
}

/// Destroys an effect; null is fine. What the GPU still uses is freed when the frame is safe. A preparation that is
/// under way is given up, and waited for on the CPU.
#[no_mangle]
pub unsafe extern "C" fn impasto_effect_destroy(effect: *mut ImpastoEffect) -> ImpastoStatus {
    guard(|| take(effect))
}
