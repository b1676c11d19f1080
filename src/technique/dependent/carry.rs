//! By which direction faces take their texture, carried from frame to frame (thesis chapter 8: "we copy the resulting
//! texture from the faces in v to the corresponding faces in v+1").
//!
//! Copied texels would blur more with every frame. What is carried is the direction that the texture was chosen by: the
//! same slices in the same shares, sampled anew, are the same texture. It is kept for each corner that faces begin at,
//! rather than for each face: there are several times fewer, and a corner's normal, unlike a face's, differs little
//! from its neighbours', so that they come into sight together and their textures fit.
//!
//! Directions are as the corner's object has them, so an object that turns keeps its texture as if the camera went
//! around it. A carried direction turns towards the camera's, slowly, so that a picture at rest becomes that of its own
//! view. It turns faster in two cases, and the more so the more they are given, so that no edges come about:
//!
//! - The corner is turned away from the eye. Beyond 30 degrees behind the horizon its direction is the camera's. So
//!   what comes into sight has the direction that it came into sight by, and passes over into what was never out of
//!   sight. Being hidden by other parts, or outside of the picture, makes nothing forget.
//! - The corner came into sight at a grazing angle and is now seen much straighter. Views from beside it show its
//!   texture stretched. A turn of up to 14 degrees never counts.

use super::coverage::Covered;
use super::geometry::Corner;
use crate::gpu::{
    Access, BindingKind, BindingSet, ComputePipeline, Context, Image, ImageDesc, Recorder, Shader, Uploads,
};
use crate::scene::{Mesh, Moment, ObjectRows, Vec3};
use crate::Result;
use ash::vk;

pub(crate) const DEPENDENT_CARRY: Shader = Shader {
    name: "dependent_carry",
    spirv: include_bytes!("../../../glsl/spirv/technique/dependent_carry.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeReadWrite),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<Push>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    count: u32,
    cut: u32,
    turn: f32,
}

/// Texels in a row of what is looked up by number, as in the shaders.
const ACROSS: u32 = 4096;

/// Whether a frame goes on from the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carry {
    /// It stands alone, or a shot begins: faces take their texture by its own direction, whatever was before.
    Cut,
    /// It follows the one that was recorded last: faces that stay in sight keep their texture.
    Next,
}

/// The pass that finds which slices faces take.
pub(super) struct CarryPass {
    stage: ComputePipeline,
    set: BindingSet,
    /// For each object the direction that it is seen from, and the eye.
    objects: ObjectRows<2>,
    blends: Image,
    carried: Image,
    center: Vec3,
    count: u32,
    follow_deg: f32,
}

impl CarryPass {
    /// Prepares the pass for the corners of faces and their sets, which are pairs of one of `covered` and an object.
    #[allow(clippy::too_many_arguments)] // the device, the model's faces and paints, what is seen of them, the way
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        mesh: &Mesh,
        corners: &[Corner],
        sets: &[(u32, u32)],
        paint_of_object: &[u32],
        covered: &Covered,
        follow_deg: f32,
    ) -> Result<Self> {
        // The slices of every set, one list after the other, each with its direction.
        let mut slices: Vec<[f32; 4]> = Vec::new();
        let slice = |&slice: &u8| {
            let of_slice = covered.slices.get(usize::from(slice));
            of_slice.map(|of_slice| of_slice.direction.extend(f32::from(slice)).to_array())
        };
        let list = |&(set, object): &(u32, u32)| {
            let paint = paint_of_object.get(object as usize).copied().unwrap_or_default();
            let begin = slices.len() as u32;
            slices.extend(covered.sets.get(set as usize).into_iter().flatten().filter_map(slice));
            [begin, slices.len() as u32, paint, object]
        };
        let lists: Vec<[u32; 4]> = sets.iter().map(list).collect();
        let lists: Vec<[u32; 4]> =
            corners.iter().map(|corner| lists.get(corner.set as usize).copied().unwrap_or_default()).collect();
        let places: Vec<[u32; 4]> = corners.iter().map(place).collect();

        let integers = vk::Format::R32G32B32A32_UINT;
        let floats = vk::Format::R32G32B32A32_SFLOAT;
        let places = table(context, uploads, "corners", integers, &places)?;
        let lists = table(context, uploads, "sets of corners", integers, &lists)?;
        let slices = table(context, uploads, "slices of sets", floats, &slices)?;
        // As if all had been turned away, so that a first frame is a cut in any case.
        let nothing = vec![[0.0_f32, 0.0, 0.0, 1.0]; corners.len()];
        let carried = table(context, uploads, "carried directions", floats, &nothing)?;
        let blends = Image::new(context, "blends of corners", &table_desc(corners.len(), integers))?;
        let stage = ComputePipeline::new(context, &DEPENDENT_CARRY)?;
        let objects = ObjectRows::new(context, "dependent_views", mesh.objects().len())?;
        let bound = [&places, &lists, &slices, objects.image(), &carried, &blends].map(Into::into);
        let set = BindingSet::new(context, &stage, &bound)?;
        let center = mesh.bounding_sphere().center;
        Ok(CarryPass { stage, set, objects, blends, carried, center, count: corners.len() as u32, follow_deg })
    }

    /// How much of which slices the faces of each corner take: weights, slices, paint and object.
    pub fn blends(&self) -> &Image {
        &self.blends
    }

    /// The direction of each corner, and how far it is turned away.
    pub fn carried(&self) -> &Image {
        &self.carried
    }

    /// Records the pass.
    pub fn record(&self, recorder: &mut Recorder<'_>, moment: &Moment, carry: Carry) {
        self.objects.record(recorder, |object| self.view(moment, object));
        let at_once = self.follow_deg == 180.0;
        let push = Push {
            count: self.count,
            cut: u32::from(carry == Carry::Cut || at_once),
            turn: (f64::from(self.follow_deg).to_radians() / 2.0).tan() as f32,
        };
        recorder.dispatch(&self.stage, &self.set, &push, [self.count.div_ceil(64), 1, 1]);
    }

    /// The direction from the middle of the model to the eye, and the eye, as an object has them.
    fn view(&self, moment: &Moment, object: usize) -> [[f32; 4]; 2] {
        let (pose, camera) = (moment.pose(object), &moment.camera);
        let eye = pose.point_to_object(camera.eye());
        // An eye at the very middle of the model has no direction but the one that it looks along.
        let direction = (eye - self.center).try_normalize().unwrap_or_else(|| -pose.to_object(camera.forward()));
        [direction, eye].map(|v| v.extend(0.0).to_array())
    }
}

/// A corner as the shader reads it: its place, and its normal in four times 8 bits.
fn place(corner: &Corner) -> [u32; 4] {
    let [x, y, z] = corner.normal.map(|v| (v.clamp(-1.0, 1.0) * 127.0).round() as i8 as u8);
    let [px, py, pz] = corner.position.map(f32::to_bits);
    [px, py, pz, u32::from_le_bytes([x, y, z, 0])]
}

fn table_desc(count: usize, format: vk::Format) -> ImageDesc {
    let count = count.max(1) as u32;
    ImageDesc::storage_2d(ACROSS.min(count), count.div_ceil(ACROSS), format)
}

/// Values to be looked up by number: number i is in column i % [`ACROSS`] and row i / [`ACROSS`].
fn table<T: bytemuck::Pod>(
    context: &Context,
    uploads: &mut Uploads,
    name: &'static str,
    format: vk::Format,
    values: &[T],
) -> Result<Image> {
    let desc = table_desc(values.len(), format);
    let image = Image::new(context, name, &desc)?;
    let mut texels = values.to_vec();
    texels.resize((desc.size_px[0] * desc.size_px[1]) as usize, T::zeroed());
    uploads.image(context, &image, bytemuck::cast_slice(&texels))?;
    Ok(image)
}
