//! The colours by shade of all paints, as a picture that fragment shaders look up.

use crate::gpu::{Context, Image, ImageDesc, Uploads};
use crate::paint::Trajectory;
use crate::{Error, Result};
use ash::vk;

/// Colours of a row; shade s stands at texel s * (COLORS - 1), as in paint.glsl. So many that the nearest one is as
/// good as what lies between two: a channel has 256 values.
const COLORS: usize = 2048;

/// A row of colours for each paint, dark on the left.
pub(crate) struct ColorTable {
    image: Image,
    rows: Vec<[u8; 4]>,
}

impl ColorTable {
    /// Puts the trajectories of all paints into one picture.
    ///
    /// # Errors
    /// [`Error::Parameter`] for more paints than the device's pictures have rows, [`Error::Memory`] when the budget does
    /// not allow it.
    pub fn new<'a>(
        context: &Context,
        uploads: &mut Uploads,
        trajectories: impl Iterator<Item = &'a Trajectory>,
    ) -> Result<Self> {
        let trajectories: Vec<_> = trajectories.collect();
        let paints = trajectories.len();
        let most = context.caps().max_image_2d_px;
        if paints > most as usize {
            return Err(Error::parameter("paints", paints, format!("at most {most} on this device")));
        }
        let mut rows = Vec::with_capacity(paints * COLORS);
        for trajectory in trajectories {
            rows.extend(row(trajectory)?);
        }
        let desc = ImageDesc::storage_2d(COLORS as u32, paints as u32, vk::Format::R32_UINT);
        let image = Image::new(context, "colours by shade", &desc)?;
        uploads.image(context, &image, bytemuck::cast_slice(&rows))?;
        Ok(ColorTable { image, rows })
    }

    /// The picture: R32_UINT, red in the low byte.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Stages other colours for one paint.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is no such paint, [`Error::Memory`] when the budget does not allow it.
    pub fn set(
        &mut self,
        context: &Context,
        uploads: &mut Uploads,
        paint: usize,
        trajectory: &Trajectory,
    ) -> Result<()> {
        let paints = self.rows.len() / COLORS;
        if paint >= paints {
            return Err(Error::parameter("paint", paint, format!("below the {paints} paints")));
        }
        self.rows[paint * COLORS..(paint + 1) * COLORS].copy_from_slice(&row(trajectory)?);
        uploads.image(context, &self.image, bytemuck::cast_slice(&self.rows))
    }
}

fn row(trajectory: &Trajectory) -> Result<Vec<[u8; 4]>> {
    let colors = trajectory.resampled(COLORS)?;
    Ok(colors.colors().iter().map(|&[r, g, b]| [r, g, b, 1.0].map(|value| (value * 255.0).round() as u8)).collect())
}
