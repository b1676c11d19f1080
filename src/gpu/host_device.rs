//! What a host hands over to have its device borrowed.

use super::allocation::HostMemory;
use super::context::LogCallback;
use ash::vk;
use std::sync::Arc;

/// A host's device, to be borrowed. The host keeps ownership of everything in it.
#[derive(Clone)]
pub struct HostDevice {
    /// The host's instance (version 1.1 or later).
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device; no extension and no optional feature is needed.
    pub device: ash::Device,
    /// The family of the queue on which the host will submit; it must draw and compute.
    pub queue_family: u32,
    /// The features that were *enabled* on the device. None is needed; faster paths are only taken for these.
    pub enabled_features: vk::PhysicalDeviceFeatures,
    /// The host's pipeline cache, or null.
    pub pipeline_cache: vk::PipelineCache,
    /// True if the instance has `VK_EXT_debug_utils`: objects are named and passes labelled then.
    pub debug_utils: bool,
    /// Bytes of GPU memory that the context may take; `None`: 4 GiB.
    pub memory_budget: Option<u64>,
    /// Where messages go; `None`: nowhere.
    pub log: Option<LogCallback>,
    /// Where all memory comes from; `None`: from an allocator of our own, in blocks of 4 to 256 MiB.
    pub memory: Option<Arc<dyn HostMemory>>,
}

impl HostDevice {
    /// A device of which no more is told than what must be: no feature is enabled, nothing is named or logged.
    pub fn new(
        instance: ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: ash::Device,
        queue_family: u32,
    ) -> Self {
        HostDevice {
            instance,
            physical_device,
            device,
            queue_family,
            enabled_features: vk::PhysicalDeviceFeatures::default(),
            pipeline_cache: vk::PipelineCache::null(),
            debug_utils: false,
            memory_budget: None,
            log: None,
            memory: None,
        }
    }

    /// Loads the function tables from raw handles, as a host that does not use ash has them.
    ///
    /// # Safety
    /// The handles must be live, belong together, and outlive every context made from this.
    pub unsafe fn from_raw(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        device: vk::Device,
        queue_family: u32,
    ) -> Self {
        let functions = ash::StaticFn { get_instance_proc_addr };
        // SAFETY: the caller promises live handles.
        let (instance, device) = unsafe {
            let instance = ash::Instance::load(&functions, instance);
            let device = ash::Device::load(instance.fp_v1_0(), device);
            (instance, device)
        };
        Self::new(instance, physical_device, device, queue_family)
    }
}
