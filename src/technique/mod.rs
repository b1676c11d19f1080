//! The thesis's techniques: what each prepares once, and what it records for a frame.
//!
//! A technique takes guides or a mesh from the scene, samples from paint and textures from synthesis, and draws a
//! frame. It records into a command buffer that it is given and never submits.
//!
//! | technique | prepares | draws a frame with | thesis |
//! |---|---|---|---|
//! | [`object`] | a coordinate t for every vertex | one render pass over the mesh | chapter 5 |
//! | [`image`] | nothing | guided quilting of the whole picture | chapter 6 |
//! | [`aligned`] | a volume of tileable textures, one for each level of shade | a pass over the guides | chapter 7 |
//! | [`dependent`] | a texture for every important view | a pass over the mesh, and one over its pixels | chapter 8 |

pub mod aligned;
pub mod dependent;
pub mod image;
pub mod object;

mod colors;
pub(crate) mod picture_pass;

use crate::gpu::{Context, Image, ImageDesc, Uploads};
use crate::paint::{TextureDifference, Trajectory};
use crate::{Error, Result};
use ash::vk;

/// Paints and objects are numbered in 16 bits, 0 being the background.
const MAX_PAINTS: usize = 65_535;

/// What objects are painted with: a strip, taken apart.
#[derive(Clone, Copy)]
pub struct Paint<'a> {
    /// The strip's texture, which is quilted.
    pub texture: &'a TextureDifference,
    /// The colours by shade, of this strip or any other.
    pub trajectory: &'a Trajectory,
}

/// What the frame shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Show {
    /// Colour and texture.
    #[default]
    Painted,
    /// Colour alone.
    Color,
    /// The texture difference alone, [-1, 1] mapped to [0, 1].
    Texture,
}

/// The range of shade that is spread over a whole strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadeRange {
    /// The shade that takes the strip's dark end, 0 to 1.
    pub low: f32,
    /// The shade that takes its light end; anything but more than `low` leaves shades as they are.
    pub high: f32,
}

impl Default for ShadeRange {
    /// All of it: the thesis's plain mapping.
    fn default() -> Self {
        ShadeRange { low: 0.0, high: 1.0 }
    }
}

impl ShadeRange {
    /// The range of shade of a guide, less half a percent of its pixels at each end, in steps of 1/1023. `shade` and
    /// `id` are texels of the guide's images. All of it where there is no pixel.
    pub fn of_guide(shade: &[f32], id: &[u32]) -> Self {
        let mut bins = [0u64; 1024];
        for (shade, _) in shade.iter().zip(id).filter(|(_, id)| **id != 0) {
            bins[(shade.clamp(0.0, 1.0) * 1023.0 + 0.5) as usize] += 1;
        }
        let total: u64 = bins.iter().sum();
        if total == 0 {
            return Self::default();
        }
        // The first bin, counted from either end, with which more than the cut has been passed.
        let place = |bin_at: &dyn Fn(usize) -> usize| {
            let mut passed = 0;
            let bin = (0..1024).map(bin_at).find(|&bin| {
                passed += bins[bin];
                passed > total / 200
            });
            bin.unwrap_or_default() as f32 / 1023.0
        };
        ShadeRange { low: place(&|i| i), high: place(&|i| 1023 - i) }
    }

    /// Where a shade lies in the range, 0 to 1: its place on the strip.
    pub fn spread(&self, shade: f32) -> f32 {
        if self.high > self.low {
            ((shade - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
        } else {
            shade
        }
    }

    fn to_array(self) -> [f32; 2] {
        [self.low, self.high]
    }
}

/// Columns of a picture of objects, as in the shaders.
const OBJECTS_ACROSS: usize = 1024;

/// A picture with a texel for each of `count` objects, row by row: fragment shaders look it up cheaply everywhere.
fn picture_of_objects(context: &Context, name: &str, count: usize, format: vk::Format) -> Result<Image> {
    let rows = count.div_ceil(OBJECTS_ACROSS).max(1);
    Image::new(context, name, &ImageDesc::storage_2d(OBJECTS_ACROSS as u32, rows as u32, format))
}

/// The paint of each object as a picture of objects, R32_UINT.
fn paint_picture(context: &Context, uploads: &mut Uploads, paint_of_object: &[u32]) -> Result<Image> {
    let picture = picture_of_objects(context, "paint of object", paint_of_object.len(), vk::Format::R32_UINT)?;
    let mut texels = paint_of_object.to_vec();
    texels.resize(picture.texels() as usize, 0);
    uploads.image(context, &picture, bytemuck::cast_slice(&texels))?;
    Ok(picture)
}

/// Checks how many paints there are, and that every object has one of them.
pub(crate) fn check_paints(paints: usize, paint_of_object: &[u32], objects: usize) -> Result<()> {
    if !(1..=MAX_PAINTS).contains(&paints) {
        return Err(Error::parameter("paints", paints, format!("1 to {MAX_PAINTS}")));
    }
    if let Some(stray) = paint_of_object.iter().find(|&&paint| paint as usize >= paints) {
        return Err(Error::parameter("paint of object", stray, format!("below the {paints} paints")));
    }
    if paint_of_object.len() < objects {
        let allowed = format!("one for each of the {objects} objects");
        return Err(Error::parameter("paints of objects", paint_of_object.len(), allowed));
    }
    Ok(())
}
