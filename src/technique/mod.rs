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
//! | [`dependent`] | a texture for every important view | one render pass over the mesh | chapter 8 |

pub mod aligned;
pub mod dependent;
pub mod image;
pub mod object;

use crate::paint::{TextureDifference, Trajectory};
use crate::{Error, Result};

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

/// Checks how many paints there are, and that every object has one of them.
fn check_paints(paints: usize, paint_of_object: &[u32], objects: usize) -> Result<()> {
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
