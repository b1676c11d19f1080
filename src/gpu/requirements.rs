//! What a host must know before it makes its device: what the crate needs of instance, device and queue.
//!
//! The answer is plain Vulkan 1.1: no extension, no feature, formats and uses that every device must offer. What goes
//! beyond the least that Vulkan promises are a few limits on what one shader may bind; desktop GPUs offer far more.
//! [`Requirements::check`] looks at a device before it is made, and [`super::Context::from_host`] does so again.

use crate::{Error, Result};
use ash::vk;
use std::ffi::CStr;

/// What is needed of a device, and of the instance that it is made from.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Requirements {
    /// The least Vulkan version, of instance and device.
    pub api_version: u32,
    /// Instance extensions: none. With `VK_EXT_debug_utils` objects are named (`HostDevice::debug_utils`).
    pub instance_extensions: &'static [&'static CStr],
    /// Device extensions: none.
    pub device_extensions: &'static [&'static CStr],
    /// Features that must be enabled: none.
    pub features: vk::PhysicalDeviceFeatures,
    /// What the one queue's family must do.
    pub queue_flags: vk::QueueFlags,
    /// Limits that are made use of.
    pub limits: Limits,
    /// Formats of images and vertices, and what they must be good for with optimal tiling and in buffers.
    pub formats: &'static [Format],
    /// Formats of depth images; one of these must be good for [`Requirements::depth_features`].
    pub depth_formats: &'static [vk::Format],
    /// What depth images are for.
    pub depth_features: vk::FormatFeatureFlags,
}

/// The least that a device's limits must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of push constants.
    pub push_constant_bytes: u32,
    /// Invocations of a compute shader's workgroup.
    pub workgroup_invocations: u32,
    /// Bytes of shared memory of a workgroup.
    pub shared_memory_bytes: u32,
    /// Pixels along a side of a 2D image. Larger pictures need more ([`super::Caps::max_image_2d_px`]).
    pub image_2d_px: u32,
    /// Texels along a side of a 3D image.
    pub image_3d_px: u32,
    /// Bytes of a storage buffer.
    pub storage_buffer_bytes: u32,
    /// Storage buffers that a shader binds.
    pub stage_storage_buffers: u32,
    /// Storage images that a shader binds; Vulkan promises 4.
    pub stage_storage_images: u32,
    /// Images with a sampler that a shader binds.
    pub stage_sampled_images: u32,
    /// Colour attachments of a render pass.
    pub color_attachments: u32,
    /// Storage images and colour attachments of a fragment shader together; Vulkan promises 4.
    pub fragment_outputs: u32,
}

/// A format, and what is done with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Format {
    /// The format.
    pub format: vk::Format,
    /// Of images with optimal tiling.
    pub image: vk::FormatFeatureFlags,
    /// Of buffers.
    pub buffer: vk::FormatFeatureFlags,
}

const STORED: vk::FormatFeatureFlags = vk::FormatFeatureFlags::STORAGE_IMAGE;
const SAMPLED: vk::FormatFeatureFlags = vk::FormatFeatureFlags::SAMPLED_IMAGE;
const DRAWN: vk::FormatFeatureFlags = vk::FormatFeatureFlags::COLOR_ATTACHMENT;

const fn image(format: vk::Format, uses: &[vk::FormatFeatureFlags]) -> Format {
    let (mut flags, mut i) = (0, 0);
    while i < uses.len() {
        flags |= uses[i].as_raw();
        i += 1;
    }
    let buffer = vk::FormatFeatureFlags::empty();
    Format { format, image: vk::FormatFeatureFlags::from_raw(flags), buffer }
}

const fn vertex(format: Format) -> Format {
    Format { buffer: vk::FormatFeatureFlags::VERTEX_BUFFER, ..format }
}

/// All of these are mandatory in Vulkan 1.1; drivers that are not quite conformant are told apart by the check.
const FORMATS: &[Format] = &[
    image(vk::Format::R8G8B8A8_UNORM, &[STORED, SAMPLED, vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR, DRAWN]),
    vertex(image(vk::Format::R32_UINT, &[STORED, DRAWN])),
    vertex(image(vk::Format::R32_SFLOAT, &[STORED, DRAWN])),
    vertex(image(vk::Format::R32G32B32_SFLOAT, &[])),
    image(vk::Format::R16G16B16A16_UINT, &[STORED, DRAWN]),
    image(vk::Format::R32G32B32A32_UINT, &[STORED]),
    image(vk::Format::R32G32B32A32_SFLOAT, &[STORED]),
];

/// What is needed of a host's device; see [`Requirements`].
pub fn requirements() -> Requirements {
    Requirements {
        api_version: super::API_VERSION,
        instance_extensions: &[],
        device_extensions: &[],
        features: vk::PhysicalDeviceFeatures::default(),
        queue_flags: vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE,
        limits: Limits {
            push_constant_bytes: 128,
            workgroup_invocations: 128,
            shared_memory_bytes: 16_384,
            image_2d_px: 4096,
            image_3d_px: 256,
            storage_buffer_bytes: 1 << 27,
            stage_storage_buffers: 4,
            stage_storage_images: 7,
            stage_sampled_images: 3,
            color_attachments: 3,
            fragment_outputs: 8,
        },
        formats: FORMATS,
        depth_formats: &[vk::Format::D32_SFLOAT, vk::Format::X8_D24_UNORM_PACK32],
        depth_features: vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT | vk::FormatFeatureFlags::SAMPLED_IMAGE,
    }
}

impl Requirements {
    /// Checks that a device and one of its queue families have all that is needed; the device need not be made yet.
    ///
    /// # Safety
    /// `instance` must be live and of version 1.1 at least, and `physical` one of its devices.
    ///
    /// # Errors
    /// [`Error::Device`] that tells in words all that the device lacks.
    pub unsafe fn check(
        &self,
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        queue_family: u32,
    ) -> Result<()> {
        // SAFETY: the caller promises a live instance and a device of its.
        let (properties, families) = unsafe {
            (
                instance.get_physical_device_properties(physical),
                instance.get_physical_device_queue_family_properties(physical),
            )
        };
        let found = Found {
            api_version: properties.api_version,
            queue: families.get(queue_family as usize).map(|family| family.queue_flags),
            limits: &properties.limits,
            // SAFETY: as above.
            format: &|format| unsafe { instance.get_physical_device_format_properties(physical, format) },
        };
        let lacks = self.lacks(&found);
        if lacks.is_empty() {
            return Ok(());
        }
        let name = properties.device_name_as_c_str().unwrap_or(c"the device").to_string_lossy();
        Err(Error::Device(format!("{name} cannot be used: {}", lacks.join("; "))))
    }

    /// The depth format of images of our own: the first that is good for it.
    pub(crate) fn depth_format(&self, format: impl Fn(vk::Format) -> vk::FormatProperties) -> Option<vk::Format> {
        let good = |candidate: &vk::Format| format(*candidate).optimal_tiling_features.contains(self.depth_features);
        self.depth_formats.iter().copied().find(good)
    }

    /// All that is missing, in words.
    fn lacks(&self, found: &Found<'_>) -> Vec<String> {
        let mut lacks = Vec::new();
        if found.api_version < self.api_version {
            let text = |v| format!("{}.{}", vk::api_version_major(v), vk::api_version_minor(v));
            lacks.push(format!("it offers Vulkan {}, {} is needed", text(found.api_version), text(self.api_version)));
        }
        match found.queue {
            None => lacks.push("it has no queue family of that number".to_owned()),
            Some(flags) if !flags.contains(self.queue_flags) => {
                lacks.push(format!("the queue family does {flags:?}, {:?} is needed", self.queue_flags));
            }
            Some(_) => {}
        }
        for (what, has, needs) in self.limits.against(found.limits) {
            if has < needs {
                lacks.push(format!("it allows {has} {what}, {needs} are needed"));
            }
        }
        for needed in self.formats {
            let offered = (found.format)(needed.format);
            let missing =
                (needed.image & !offered.optimal_tiling_features) | (needed.buffer & !offered.buffer_features);
            if !missing.is_empty() {
                lacks.push(format!("{:?} is not good for {missing:?}", needed.format));
            }
        }
        if self.depth_format(found.format).is_none() {
            lacks.push(format!("none of {:?} is good for {:?}", self.depth_formats, self.depth_features));
        }
        lacks
    }
}

impl Limits {
    /// Each limit in words, what a device has of it, and what is needed.
    fn against(&self, has: &vk::PhysicalDeviceLimits) -> [(&'static str, u32, u32); 11] {
        [
            ("bytes of push constants", has.max_push_constants_size, self.push_constant_bytes),
            (
                "invocations of a workgroup",
                has.max_compute_work_group_invocations.min(has.max_compute_work_group_size[0]),
                self.workgroup_invocations,
            ),
            ("bytes of shared memory", has.max_compute_shared_memory_size, self.shared_memory_bytes),
            ("pixels along a side of a 2D image", has.max_image_dimension2_d, self.image_2d_px),
            ("texels along a side of a 3D image", has.max_image_dimension3_d, self.image_3d_px),
            ("bytes of a storage buffer", has.max_storage_buffer_range, self.storage_buffer_bytes),
            ("storage buffers in a shader", has.max_per_stage_descriptor_storage_buffers, self.stage_storage_buffers),
            ("storage images in a shader", has.max_per_stage_descriptor_storage_images, self.stage_storage_images),
            (
                "images with a sampler in a shader",
                has.max_per_stage_descriptor_samplers.min(has.max_per_stage_descriptor_sampled_images),
                self.stage_sampled_images,
            ),
            (
                "colour attachments",
                has.max_color_attachments.min(has.max_fragment_output_attachments),
                self.color_attachments,
            ),
            (
                "storage images and colour attachments of a fragment shader",
                has.max_fragment_combined_output_resources,
                self.fragment_outputs,
            ),
        ]
    }
}

/// What a device has.
struct Found<'a> {
    api_version: u32,
    queue: Option<vk::QueueFlags>,
    limits: &'a vk::PhysicalDeviceLimits,
    format: &'a dyn Fn(vk::Format) -> vk::FormatProperties,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::BindingKind;
    use crate::shader_table::{raster_shaders, shaders};

    /// The least that Vulkan 1.1 promises, but for what one shader binds.
    fn limits() -> vk::PhysicalDeviceLimits {
        vk::PhysicalDeviceLimits {
            max_push_constants_size: 128,
            max_compute_work_group_invocations: 128,
            max_compute_work_group_size: [128, 128, 64],
            max_compute_shared_memory_size: 16_384,
            max_image_dimension2_d: 4096,
            max_image_dimension3_d: 256,
            max_storage_buffer_range: 1 << 27,
            max_per_stage_descriptor_storage_buffers: 4,
            max_per_stage_descriptor_storage_images: 8,
            max_per_stage_descriptor_samplers: 16,
            max_per_stage_descriptor_sampled_images: 16,
            max_color_attachments: 4,
            max_fragment_output_attachments: 4,
            max_fragment_combined_output_resources: 8,
            ..Default::default()
        }
    }

    fn everything(_: vk::Format) -> vk::FormatProperties {
        let all = vk::FormatFeatureFlags::from_raw(u32::MAX);
        vk::FormatProperties { optimal_tiling_features: all, buffer_features: all, ..Default::default() }
    }

    fn lacks(change: impl Fn(&mut Found<'_>, &mut vk::PhysicalDeviceLimits)) -> Vec<String> {
        let mut limits = limits();
        let unchanged = limits;
        let queue = Some(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE | vk::QueueFlags::TRANSFER);
        let mut found =
            Found { api_version: vk::make_api_version(0, 1, 1, 75), queue, limits: &unchanged, format: &everything };
        change(&mut found, &mut limits);
        requirements().lacks(&Found { limits: &limits, ..found })
    }

    #[test]
    fn what_is_missing_is_said_in_words() {
        assert_eq!(lacks(|_, _| ()), [""; 0]);
        assert_eq!(lacks(|f, _| f.api_version = vk::API_VERSION_1_0), ["it offers Vulkan 1.0, 1.1 is needed"],);
        assert_eq!(lacks(|f, _| f.queue = None), ["it has no queue family of that number"]);
        assert_eq!(
            lacks(|f, _| f.queue = Some(vk::QueueFlags::COMPUTE)),
            ["the queue family does COMPUTE, GRAPHICS | COMPUTE is needed"],
        );
        assert_eq!(
            lacks(|_, l| l.max_per_stage_descriptor_storage_images = 4),
            ["it allows 4 storage images in a shader, 7 are needed"],
        );
        assert_eq!(
            lacks(|_, l| (l.max_push_constants_size, l.max_compute_shared_memory_size) = (64, 8192)),
            [
                "it allows 64 bytes of push constants, 128 are needed",
                "it allows 8192 bytes of shared memory, 16384 are needed"
            ],
        );
    }

    #[test]
    fn formats_are_looked_at_one_by_one() {
        let without = |lost: vk::Format, flag: vk::FormatFeatureFlags| {
            let format = move |format: vk::Format| {
                let mut all = everything(format);
                if format == lost {
                    all.optimal_tiling_features &= !flag;
                    all.buffer_features &= !flag;
                }
                all
            };
            let found = Found {
                api_version: vk::API_VERSION_1_1,
                queue: Some(requirements().queue_flags),
                limits: &limits(),
                format: &format,
            };
            (requirements().lacks(&found), requirements().depth_format(format))
        };
        let (d32, d24) = (vk::Format::D32_SFLOAT, vk::Format::X8_D24_UNORM_PACK32);
        let (lacks, depth) = without(vk::Format::R32_UINT, STORED);
        assert_eq!((lacks, depth), (vec!["R32_UINT is not good for STORAGE_IMAGE".to_owned()], Some(d32)));
        let (lacks, _) = without(vk::Format::R32G32B32_SFLOAT, vk::FormatFeatureFlags::VERTEX_BUFFER);
        assert_eq!(lacks, ["R32G32B32_SFLOAT is not good for VERTEX_BUFFER"]);
        // Without one depth format the other serves.
        assert_eq!(without(d32, vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT), (vec![], Some(d24)));
        let neither = |_| vk::FormatProperties::default();
        assert_eq!(requirements().depth_format(neither), None);
    }

    /// Neither more nor less than the shaders bind.
    #[test]
    fn limits_are_those_that_the_shaders_reach() {
        let count = |bindings: &[BindingKind], what: fn(&BindingKind) -> bool| {
            bindings.iter().filter(|kind| what(kind)).count() as u32
        };
        let compute = shaders();
        let raster = raster_shaders();
        let all = compute.iter().map(|(_, s)| s.bindings).chain(raster.iter().map(|(_, _, s)| s.bindings));
        let all: Vec<&[BindingKind]> = all.collect();
        let most = |what: fn(&BindingKind) -> bool| all.iter().map(|b| count(b, what)).max();
        let limits = requirements().limits;
        assert_eq!(most(|kind| matches!(kind, BindingKind::Image(_))), Some(limits.stage_storage_images));
        assert_eq!(most(|kind| matches!(kind, BindingKind::Sampled(_))), Some(limits.stage_sampled_images));
        let buffers = most(|kind| matches!(kind, BindingKind::Buffer(_)));
        assert_eq!(buffers, Some(limits.stage_storage_buffers));
    }
}
