//! Numbers for every object that change with every frame, as the texels of a picture: what shaders look up cheaply
//! everywhere.

use crate::gpu::{Buffer, BufferKind, Context, Image, ImageDesc, Recorder};
use crate::Result;
use ash::vk;

/// Objects in a row of the picture, as in the shaders.
const OBJECTS_ACROSS: usize = 1024;

/// N vectors of four numbers for each object: vector k of object i, from 0, is in column N * (i % 1024) + k and row
/// i / 1024 of an R32G32B32A32_SFLOAT picture.
pub(crate) struct ObjectRows<const N: usize> {
    name: &'static str,
    objects: usize,
    staging: Buffer,
    image: Image,
}

impl<const N: usize> ObjectRows<N> {
    /// Makes room for `objects` objects. `name` is the pass's.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] when the budget does not allow it, [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, name: &'static str, objects: usize) -> Result<Self> {
        let across = objects.clamp(1, OBJECTS_ACROSS);
        let rows = objects.div_ceil(OBJECTS_ACROSS).max(1);
        let desc = ImageDesc::storage_2d((N * across) as u32, rows as u32, vk::Format::R32G32B32A32_SFLOAT);
        let image = Image::new(context, name, &desc)?;
        let staging = Buffer::new(context, name, BufferKind::Storage, 16 * image.texels())?;
        Ok(ObjectRows { name, objects, staging, image })
    }

    /// The picture.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Records how the picture is filled, with `vectors` for each object by its number.
    pub fn record(&self, recorder: &mut Recorder<'_>, vectors: impl Fn(usize) -> [[f32; 4]; N]) {
        let all: Vec<[[f32; 4]; N]> = (0..self.objects).map(vectors).collect();
        recorder.update_buffer(self.name, &self.staging, bytemuck::cast_slice(all.as_flattened()));
        recorder.upload_image(self.name, &self.staging, &self.image);
    }
}
