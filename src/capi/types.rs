//! The numbers and the plain structures of the header.

pub use ash::vk::{
    AccessFlags as VkAccessFlags, CommandBuffer as VkCommandBuffer, Device as VkDevice, Format as VkFormat,
    Image as VkImage, ImageLayout as VkImageLayout, ImageUsageFlags as VkImageUsageFlags, ImageView as VkImageView,
    Instance as VkInstance, PhysicalDevice as VkPhysicalDevice, PhysicalDeviceFeatures as VkPhysicalDeviceFeatures,
    PipelineCache as VkPipelineCache, PipelineStageFlags as VkPipelineStageFlags, QueueFlags as VkQueueFlags,
};

/// The version that this header belongs to, as VK_MAKE_API_VERSION makes it. impasto_version() tells that of the
/// library: it must not be lower, and have the same major version (before 1.0 also the same minor one).
pub const IMPASTO_VERSION: u32 = 0x1000;

/// The most arrays of paints, poses, views or targets may hold.
pub const IMPASTO_MAX_COUNT: u32 = 65_535;

/// What a call answers. impasto_last_error() has the details.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpastoStatus {
    /// It is done.
    Ok = 0,
    /// A pointer or handle that is needed is null.
    NullPointer = 1,
    /// A handle is of another kind, was destroyed, or never was one.
    Handle = 2,
    /// A struct_size is none, or the structure uses what this version of the library does not know.
    StructSize = 3,
    /// A value is out of its range, or does not fit the others.
    Parameter = 4,
    /// A file was read, but what it holds is not usable; or no triangle of a mesh is.
    File = 5,
    /// A file could not be read, or the system has no thread to give.
    Io = 6,
    /// The effect is not prepared yet, or has recorded no frame yet.
    NotReady = 7,
    /// Something still stands on what was to be destroyed.
    InUse = 8,
    /// The device lacks something that is needed, or a preparation has failed before.
    Device = 9,
    /// The device is lost: all that can be done is to destroy what was made on it.
    DeviceLost = 10,
    /// The memory budget, the device or the system has not enough memory.
    OutOfMemory = 11,
    /// A Vulkan call failed in another way.
    Vulkan = 12,
    /// A fault in impasto was caught. What the call was for can only be destroyed.
    Panic = 13,
}

/// How grave a message to the log is.
#[repr(u32)]
pub enum ImpastoLogLevel {
    /// Something is wrong.
    Error = 0,
    /// Something looks wrong.
    Warning = 1,
}

/// By which technique an effect paints.
#[repr(u32)]
#[derive(Clone, Copy)]
pub enum ImpastoTechnique {
    /// Object-based texture mapping: the cheapest, with paint that is pinned to the surface.
    Object = 0,
    /// Image-based texture synthesis: the best picture, synthesised for every frame.
    Image = 1,
    /// View-aligned 3D texture projection: nearly that picture, in real time.
    Aligned = 2,
    /// View-dependent interpolation: paint that was synthesised for views, in real time.
    Dependent = 3,
}

/// What a frame shows.
#[repr(u32)]
pub enum ImpastoShow {
    /// Colour and texture.
    Painted = 0,
    /// Colour alone.
    Color = 1,
    /// The texture alone.
    Texture = 2,
}

/// How a strip repeats over the surface.
#[repr(u32)]
pub enum ImpastoRepeat {
    /// Its upper edge is cut into its lower one.
    Wrap = 0,
    /// Every other repeat is mirrored.
    Mirror = 1,
}

/// What happens to object-based paint where a mesh falls apart into pieces.
#[repr(u32)]
pub enum ImpastoSeams {
    /// It goes on from the closest vertex.
    Carry = 0,
    /// Each piece begins anew, which shows the seam.
    Fresh = 1,
}

/// How the levels of view-aligned projection are made to repeat.
#[repr(u32)]
pub enum ImpastoTileable {
    /// Blocks are quilted around the edges as well.
    Wrap = 0,
    /// The quilt is blended with itself under a circular mask.
    Mask = 1,
}

/// How levels of view-aligned projection are blended.
#[repr(u32)]
pub enum ImpastoBlend {
    /// With the contrast given back that averaging takes.
    Contrast = 0,
    /// As the hardware blends.
    Linear = 1,
}

/// What the colours of a target are.
#[repr(u32)]
pub enum ImpastoTargetColor {
    /// As its format suggests: light in SRGB and float formats, else stored values.
    ByFormat = 0,
    /// Values as files have them.
    Stored = 1,
    /// Light.
    Light = 2,
}

/// How an image is used at a point of the command buffer. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImpastoUse {
    /// The stages that use it, or have used it.
    pub stages: VkPipelineStageFlags,
    /// The accesses.
    pub access: VkAccessFlags,
    /// The layout that it lies in.
    pub layout: VkImageLayout,
}

/// How an image was used before a call records, and how it will be after. The library records the barriers on both
/// sides. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImpastoImageUse {
    /// What the host has done last. All zero: what the library knows of it.
    pub before: ImpastoUse,
    /// What the host will do next. All zero: the library leaves it as it is, and where impasto_effect_picture() says.
    pub after: ImpastoUse,
}

/// Parallel light from one direction. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpastoLight {
    /// From the surface towards the light, in world space, of any length but 0.
    pub direction: [f32; 3],
    /// Its weight among the others, 1e-6 to 1e6.
    pub intensity: f32,
}

/// Where an object is: a column-major matrix from the mesh to world space that turns and moves, and does nothing else.
/// Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpastoPose {
    /// The columns, one after the other.
    pub matrix: [f32; 16],
}

/// A range of shade that is spread over the whole strip; all of it is 0 to 1. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpastoShadeRange {
    /// The shade that takes the strip's dark end.
    pub low: f32,
    /// The shade that takes its light end.
    pub high: f32,
}

/// How blocks of a strip are quilted. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpastoQuilt {
    /// Side of the square blocks, 4 to 64 pixels.
    pub block_px: u32,
    /// By how much neighbours overlap, 1 pixel to half of block_px.
    pub overlap_px: u32,
    /// How much worse than the best a position may fit and still be chosen, 0 to 10 of the least error.
    pub tolerance: f32,
}

/// A direction from which a model is looked at. Plain: never grows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpastoDirection {
    /// 0 looks from +z, 90 from +x; degrees.
    pub yaw_deg: f32,
    /// How far above the horizon the eye is, -90 to 90 degrees.
    pub pitch_deg: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_headers_version_is_the_packages() {
        let parts = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];
        let [major, minor, patch] = parts.map(|part| part.parse::<u32>().expect("a number"));
        assert_eq!(IMPASTO_VERSION, ash::vk::make_api_version(0, major, minor, patch));
    }
}
