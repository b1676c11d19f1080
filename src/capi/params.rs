//! The parameters of each technique, and their defaults.

use super::memory::{read_if, slice, switch, versioned, write};
use super::status::{guard, Failure, Result};
use super::types::*;
use crate::embed::Method;
use crate::scene::{DirectionalLight, Lights, Vec3, MAX_LIGHTS};
use crate::synthesis::params::QuiltParams;
use crate::synthesis::quilt::PreviousWeight;
use crate::synthesis::repair::RepairParams;
use crate::technique::aligned::{AlignedFrame, LevelBlend, LevelParams, Tileable};
use crate::technique::dependent::{default_views, DependentParams, View};
use crate::technique::image::ImageParams;
use crate::technique::object::{CoordinateParams, ObjectParams, Orientation, SeamPolicy, StripRepeat};
use crate::technique::ShadeRange;

/// How object-based texture mapping paints.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoObjectParams {
    /// sizeof(ImpastoObjectParams).
    pub struct_size: u32,
    /// How often the strip repeats over the mesh, 0.01 to 1000.
    pub repeats: f32,
    /// The most by which it changes at random from a vertex to the next, 0 to 1 repeats.
    pub variation: f32,
    /// The direction along which the strip repeats, of any length but 0.
    pub axis: [f32; 3],
    /// An ImpastoSeams.
    pub seams: u32,
    /// An ImpastoRepeat.
    pub repeat: u32,
    /// Enters the random choices.
    pub seed: u32,
    /// 1: keep the paint visible where the mapping loses it.
    pub keep_paint: u32,
    /// The range of shade that is spread over the strip.
    pub range: ImpastoShadeRange,
}
versioned!(ImpastoObjectParams);

/// How image-based texture synthesis paints.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoImageParams {
    /// sizeof(ImpastoImageParams).
    pub struct_size: u32,
    /// How to quilt.
    pub quilt: ImpastoQuilt,
    /// How many block sizes a block may be from its shade's place on the strip, 0 to 1000; negative: by the strip.
    pub k: f32,
    /// The range of shade that is spread over the strip.
    pub range: ImpastoShadeRange,
    /// How much each block must match the last frame, 0.25 to 3 in steps of 0.25; 0: not at all.
    pub previous_weight: f32,
    /// 1: let texture follow the surface from frame to frame, and repair it where it no longer fits.
    pub carry: u32,
    /// By what factor carried texture may be stretched, 1.05 to 1.5.
    pub stretch: f32,
    /// How much worse than the best a repaired position may fit, 0 to 10.
    pub repair_tolerance: f32,
    /// How many block sizes beyond its place carried texture may be from, 0 to 100.
    pub slack: f32,
}
versioned!(ImpastoImageParams);

/// How view-aligned 3D texture projection paints.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoAlignedParams {
    /// sizeof(ImpastoAlignedParams).
    pub struct_size: u32,
    /// Levels of shade, 1 to 64.
    pub levels: u32,
    /// Side of each level's texture, 16 to 2048 pixels.
    pub size_px: u32,
    /// An ImpastoTileable.
    pub tileable: u32,
    /// How to quilt.
    pub quilt: ImpastoQuilt,
    /// Texels of the texture to a pixel of the picture, 0.05 to 4.
    pub density: f32,
    /// Where the texture lies, pixels of the picture to the left and up.
    pub offset_px: [f32; 2],
    /// An ImpastoBlend.
    pub blend: u32,
    /// The range of shade that is spread over the strip.
    pub range: ImpastoShadeRange,
    /// 1: let each object's texture follow it.
    pub follow: u32,
}
versioned!(ImpastoAlignedParams);

/// How view-dependent interpolation paints.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoDependentParams {
    /// sizeof(ImpastoDependentParams).
    pub struct_size: u32,
    /// Width and height of a view's texture, pixels.
    pub view_px: u32,
    /// The views; null: fourteen around the model.
    pub views: *const ImpastoDirection,
    /// The lights that the views are synthesised for; null: the library's default.
    pub lights: *const ImpastoLight,
    /// How many views.
    pub view_count: u32,
    /// How many lights, at most 8.
    pub light_count: u32,
    /// How to quilt.
    pub quilt: ImpastoQuilt,
    /// How many block sizes a block may be from its shade's place on the strip, 0 to 1000; negative: by the strip.
    pub k: f32,
    /// 1: give back the contrast that blending takes.
    pub keep_contrast: u32,
    /// The range of shade that is spread over the strip.
    pub range: ImpastoShadeRange,
    /// By how many degrees a frame a face's texture follows the camera, 0 to 180.
    pub follow_deg: f32,
}
versioned!(ImpastoDependentParams);

/// One of a few names, by its number.
pub(super) fn pick<T: Copy>(name: &'static str, value: u32, all: &[T]) -> Result<T> {
    let last = all.len() - 1;
    all.get(value as usize).copied().ok_or_else(|| Failure::parameter(name, value, format!("0 to {last}")))
}

/// The number of one of a few names.
fn number<T: PartialEq>(value: &T, all: &[T]) -> u32 {
    all.iter().position(|one| one == value).unwrap_or_default() as u32
}

const SEAMS: [SeamPolicy; 2] = [SeamPolicy::Carry, SeamPolicy::Fresh];
const REPEATS: [StripRepeat; 2] = [StripRepeat::Wrap, StripRepeat::Mirror];
const TILEABLE: [Tileable; 2] = [Tileable::Wrap, Tileable::Mask];
const BLENDS: [LevelBlend; 2] = [LevelBlend::Contrast, LevelBlend::Linear];
/// Side of a view's texture where none is asked for.
const VIEW_PX: u32 = 512;

impl From<ShadeRange> for ImpastoShadeRange {
    fn from(range: ShadeRange) -> Self {
        ImpastoShadeRange { low: range.low, high: range.high }
    }
}

fn range(range: ImpastoShadeRange) -> Result<ShadeRange> {
    for end in [range.low, range.high] {
        if !(0.0..=1.0).contains(&end) {
            return Err(Failure::parameter("range", end, "from 0 to 1"));
        }
    }
    Ok(ShadeRange { low: range.low, high: range.high })
}

impl From<QuiltParams> for ImpastoQuilt {
    fn from(quilt: QuiltParams) -> Self {
        ImpastoQuilt { block_px: quilt.block_px, overlap_px: quilt.overlap_px, tolerance: quilt.tolerance }
    }
}

/// The seed is given when something is recorded.
fn quilt(quilt: ImpastoQuilt) -> QuiltParams {
    let ImpastoQuilt { block_px, overlap_px, tolerance } = quilt;
    QuiltParams { block_px, overlap_px, tolerance, ..QuiltParams::default() }
}

/// Lights, of an array that is not empty.
///
/// # Safety
/// `from` is null, or points to `count` lights.
pub(super) unsafe fn lights(from: *const ImpastoLight, count: u32) -> Result<Lights> {
    // SAFETY: the caller promises it.
    let lights = unsafe { slice("lights", from, count, MAX_LIGHTS) }?;
    let light = |light: &ImpastoLight| DirectionalLight::new(Vec3::from(light.direction), light.intensity);
    Ok(Lights::new(lights.iter().map(light).collect::<crate::Result<Vec<_>>>()?)?)
}

impl Default for ImpastoObjectParams {
    fn default() -> Self {
        let ObjectParams { coordinates, repeat, keep_paint } = ObjectParams::default();
        let axis = match coordinates.orientation {
            Orientation::Axis(axis) => axis.into(),
            Orientation::Field(_) => [0.0; 3],
        };
        ImpastoObjectParams {
            struct_size: size_of::<Self>() as u32,
            repeats: coordinates.repeats,
            variation: coordinates.variation,
            axis,
            seams: number(&coordinates.seams, &SEAMS),
            repeat: number(&repeat, &REPEATS),
            seed: coordinates.seed,
            keep_paint: u32::from(keep_paint),
            range: ShadeRange::default().into(),
        }
    }
}

impl Default for ImpastoImageParams {
    fn default() -> Self {
        let (params, repair) = (ImageParams::default(), RepairParams::default());
        ImpastoImageParams {
            struct_size: size_of::<Self>() as u32,
            quilt: params.quilt.into(),
            k: params.k.unwrap_or(-1.0),
            range: params.range.into(),
            previous_weight: params.previous.map_or(0.0, |weight| weight.0),
            carry: 1,
            stretch: repair.stretch,
            repair_tolerance: repair.tolerance,
            slack: repair.slack,
        }
    }
}

impl Default for ImpastoAlignedParams {
    fn default() -> Self {
        let (levels, frame) = (LevelParams::default(), AlignedFrame::default());
        ImpastoAlignedParams {
            struct_size: size_of::<Self>() as u32,
            levels: levels.levels,
            size_px: levels.size_px,
            tileable: number(&levels.tileable, &TILEABLE),
            quilt: levels.quilt.into(),
            density: frame.density,
            offset_px: frame.offset_px,
            blend: number(&frame.blend, &BLENDS),
            range: frame.range.into(),
            follow: 1,
        }
    }
}

impl Default for ImpastoDependentParams {
    fn default() -> Self {
        let params = DependentParams::default();
        ImpastoDependentParams {
            struct_size: size_of::<Self>() as u32,
            view_px: VIEW_PX,
            views: std::ptr::null(),
            lights: std::ptr::null(),
            view_count: 0,
            light_count: 0,
            quilt: params.quilt.into(),
            k: params.k.unwrap_or(-1.0),
            keep_contrast: u32::from(params.keep_contrast),
            range: params.range.into(),
            follow_deg: params.follow_deg,
        }
    }
}

/// Fills in the defaults of the library. The caller has set struct_size.
#[no_mangle]
pub unsafe extern "C" fn impasto_object_params_init(params: *mut ImpastoObjectParams) -> ImpastoStatus {
    // SAFETY: the contract of the header.
    guard(|| unsafe { write(params, &ImpastoObjectParams::default()) })
}

/// Fills in the defaults of the library. The caller has set struct_size.
#[no_mangle]
pub unsafe extern "C" fn impasto_image_params_init(params: *mut ImpastoImageParams) -> ImpastoStatus {
    // SAFETY: the contract of the header.
    guard(|| unsafe { write(params, &ImpastoImageParams::default()) })
}

/// Fills in the defaults of the library. The caller has set struct_size.
#[no_mangle]
pub unsafe extern "C" fn impasto_aligned_params_init(params: *mut ImpastoAlignedParams) -> ImpastoStatus {
    // SAFETY: the contract of the header.
    guard(|| unsafe { write(params, &ImpastoAlignedParams::default()) })
}

/// Fills in the defaults of the library. The caller has set struct_size.
#[no_mangle]
pub unsafe extern "C" fn impasto_dependent_params_init(params: *mut ImpastoDependentParams) -> ImpastoStatus {
    // SAFETY: the contract of the header.
    guard(|| unsafe { write(params, &ImpastoDependentParams::default()) })
}

/// # Safety
/// `from` is null for the defaults, or points to a structure.
pub(super) unsafe fn object(from: *const ImpastoObjectParams) -> Result<Method> {
    // SAFETY: the caller promises it.
    let from = unsafe { read_if(from) }?.unwrap_or_default();
    let coordinates = CoordinateParams {
        repeats: from.repeats,
        variation: from.variation,
        orientation: Orientation::Axis(Vec3::from(from.axis)),
        seams: pick("seams", from.seams, &SEAMS)?,
        seed: from.seed,
    };
    let repeat = pick("repeat", from.repeat, &REPEATS)?;
    let params = ObjectParams { coordinates, repeat, keep_paint: switch("keep_paint", from.keep_paint)? };
    Ok(Method::Object { params, range: range(from.range)? })
}

/// # Safety
/// As [`object`].
pub(super) unsafe fn image(from: *const ImpastoImageParams) -> Result<Method> {
    // SAFETY: the caller promises it.
    let from = unsafe { read_if(from) }?.unwrap_or_default();
    let previous = (from.previous_weight != 0.0).then_some(PreviousWeight(from.previous_weight));
    let quilt = quilt(from.quilt);
    if let Some(previous) = previous {
        previous.check(quilt.block_px)?;
    }
    let params = ImageParams { quilt, k: k(from.k), range: range(from.range)?, previous };
    let repair = RepairParams { stretch: from.stretch, tolerance: from.repair_tolerance, slack: from.slack };
    Ok(Method::Image { params, carry: switch("carry", from.carry)?.then_some(repair) })
}

/// # Safety
/// As [`object`].
pub(super) unsafe fn aligned(from: *const ImpastoAlignedParams) -> Result<Method> {
    // SAFETY: the caller promises it.
    let from = unsafe { read_if(from) }?.unwrap_or_default();
    let levels = LevelParams {
        levels: from.levels,
        size_px: from.size_px,
        tileable: pick("tileable", from.tileable, &TILEABLE)?,
        quilt: quilt(from.quilt),
    };
    let frame = AlignedFrame {
        density: from.density,
        offset_px: from.offset_px,
        blend: pick("blend", from.blend, &BLENDS)?,
        range: range(from.range)?,
        ..AlignedFrame::default()
    };
    Ok(Method::Aligned { levels, frame, follow: switch("follow", from.follow)? })
}

/// # Safety
/// As [`object`]; the arrays in it are as long as it says.
pub(super) unsafe fn dependent(from: *const ImpastoDependentParams) -> Result<Method> {
    // SAFETY: the caller promises it, here and below.
    let from = unsafe { read_if(from) }?.unwrap_or_default();
    let views = unsafe { slice("views", from.views, from.view_count, IMPASTO_MAX_COUNT as usize) }?;
    let views = match views {
        [] => default_views(),
        views => views.iter().map(|view| View { yaw_deg: view.yaw_deg, pitch_deg: view.pitch_deg }).collect(),
    };
    let lights = match from.light_count {
        0 => Lights::default(),
        count => unsafe { lights(from.lights, count) }?,
    };
    let params = DependentParams {
        quilt: quilt(from.quilt),
        k: k(from.k),
        keep_contrast: switch("keep_contrast", from.keep_contrast)?,
        range: range(from.range)?,
        follow_deg: from.follow_deg,
    };
    Ok(Method::Dependent { views, view_px: from.view_px, lights, params })
}

/// Not a number is no way to ask for the default.
fn k(k: f32) -> Option<f32> {
    (k >= 0.0 || k.is_nan()).then_some(k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_the_librarys() {
        // SAFETY: null is the defaults.
        let methods = unsafe {
            use std::ptr::null;
            [object(null()), image(null()), aligned(null()), dependent(null())].map(|m| m.expect("defaults"))
        };
        let [object, image, aligned, dependent] = methods;
        let Method::Object { params, range } = object else { panic!("another technique") };
        assert_eq!((params, range), (ObjectParams::default(), ShadeRange::default()));
        let Method::Image { params, carry } = image else { panic!("another technique") };
        assert_eq!((params, carry), (ImageParams::default(), Some(RepairParams::default())));
        let Method::Aligned { levels, frame, follow } = aligned else { panic!("another technique") };
        assert_eq!((levels, frame, follow), (LevelParams::default(), AlignedFrame::default(), true));
        let Method::Dependent { views, lights, params, .. } = dependent else { panic!("another technique") };
        assert_eq!((views, lights, params), (default_views(), Lights::default(), DependentParams::default()));
    }
}
