//! The colours by shade of all paints, as a picture that fragment shaders sample.

use crate::gpu::{Context, Image, ImageDesc, Sampler, Uploads};
use crate::paint::Trajectory;
use crate::{Error, Result};
use ash::vk;
use half::f16;

/// Colours of a row; shade s stands at texel s * (COLORS - 1), as in colors.glsl.
const COLORS: usize = 1024;

/// A row of colours for each paint, dark on the left.
pub(crate) struct ColorTable {
    image: Image,
    sampler: Sampler,
    rows: Vec<[f16; 4]>,
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
        let mut rows = Vec::new();
        for trajectory in trajectories {
            rows.extend(row(trajectory)?);
        }
        let paints = rows.len() / COLORS;
        let most = context.caps().max_image_2d_px;
        if paints > most as usize {
            return Err(Error::parameter("paints", paints, format!("at most {most} on this device")));
        }
        let desc = ImageDesc::sampled([COLORS as u32, paints as u32, 1], vk::Format::R16G16B16A16_SFLOAT);
        let image = Image::new(context, "colours by shade", &desc)?;
        let sampler = Sampler::linear(context, [vk::SamplerAddressMode::CLAMP_TO_EDGE; 3])?;
        uploads.image(context, &image, bytemuck::cast_slice(&rows))?;
        Ok(ColorTable { image, sampler, rows })
    }

    /// The picture and its sampler.
    pub fn bound(&self) -> (&Image, &Sampler) {
        (&self.image, &self.sampler)
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

fn row(trajectory: &Trajectory) -> Result<Vec<[f16; 4]>> {
    let colors = trajectory.resampled(COLORS)?;
    Ok(colors.colors().iter().map(|&[r, g, b]| [r, g, b, 1.0].map(f16::from_f32)).collect())
}
