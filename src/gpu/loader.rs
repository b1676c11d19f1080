//! An instance of our own: Vulkan's loader, the validation layer where it is wanted, and the devices there are.

use super::caps::{describe, DeviceInfo};
use super::context::{vulkan, LogCallback};
use super::validation;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// An instance of our own.
pub(crate) struct Loader {
    // Keeps the loader's library mapped for as long as the instance lives.
    _entry: ash::Entry,
    pub instance: ash::Instance,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    // Boxed twice so that the messenger's user pointer stays valid when the loader moves.
    _log: Option<Box<LogCallback>>,
    pub debug_utils: bool,
}

impl Loader {
    pub fn new(validation_on: bool, log: Option<LogCallback>) -> Result<Self> {
        // SAFETY: loading the system's Vulkan library runs its initialisers, which we must trust.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|e| Error::Device(format!("no Vulkan loader (libvulkan.so.1) was found: {e}")))?;
        let app = vk::ApplicationInfo::default()
            .application_name(c"impasto")
            .engine_name(c"impasto")
            .api_version(super::API_VERSION);
        // Labels and names cost nothing and are what a frame debugger shows.
        // SAFETY: the entry is live.
        let offered = unsafe { entry.enumerate_instance_extension_properties(None) }
            .map_err(vulkan("vkEnumerateInstanceExtensionProperties"))?;
        let labels = offered.iter().any(|e| e.extension_name_as_c_str() == Ok(ash::ext::debug_utils::NAME));
        let mut layers = Vec::new();
        let mut extensions = Vec::new();
        if labels || validation_on {
            extensions.push(ash::ext::debug_utils::NAME.as_ptr());
        }
        let log = validation_on.then(|| Box::new(log.unwrap_or_else(|| Arc::new(|_, _| {}))));
        if validation_on {
            // SAFETY: the entry is live.
            let present = unsafe { entry.enumerate_instance_layer_properties() }
                .map_err(vulkan("vkEnumerateInstanceLayerProperties"))?;
            if !present.iter().any(|l| l.layer_name_as_c_str() == Ok(validation::LAYER)) {
                return Err(Error::Device(
                    "validation was asked for, but the layer VK_LAYER_KHRONOS_validation is not installed".to_owned(),
                ));
            }
            layers.push(validation::LAYER.as_ptr());
            extensions.push(ash::ext::validation_features::NAME.as_ptr());
        }
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&validation::ENABLED);
        let mut messenger_info = log.as_deref().map(validation::messenger_info);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&app)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if let Some(messenger) = &mut messenger_info {
            info = info.push_next(&mut features).push_next(messenger);
        }
        // SAFETY: every pointer in `info` outlives the call.
        let instance = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                Error::Device("no Vulkan driver was found: the loader is here, but knows of no device".to_owned())
            }
            other => vulkan("vkCreateInstance")(other),
        })?;
        let messenger = match log.as_deref() {
            None => None,
            Some(log) => {
                let functions = ash::ext::debug_utils::Instance::new(&entry, &instance);
                // SAFETY: the boxed callback outlives the messenger: both are dropped by `destroy`.
                let made = unsafe { functions.create_debug_utils_messenger(&validation::messenger_info(log), None) };
                match made {
                    Ok(messenger) => Some((functions, messenger)),
                    Err(result) => {
                        // SAFETY: nothing else uses the instance yet.
                        unsafe { instance.destroy_instance(None) };
                        return Err(Error::Vulkan { call: "vkCreateDebugUtilsMessengerEXT", result });
                    }
                }
            }
        };
        Ok(Loader { _entry: entry, instance, messenger, _log: log, debug_utils: labels || validation_on })
    }

    /// The devices that can serve us.
    pub fn physical_devices(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>> {
        // SAFETY: the instance is live.
        let all =
            unsafe { self.instance.enumerate_physical_devices() }.map_err(vulkan("vkEnumeratePhysicalDevices"))?;
        Ok(all
            .into_iter()
            .enumerate()
            .map(|(index, physical)| (physical, describe(&self.instance, physical, index)))
            .filter(|(physical, info)| {
                info.api_version >= super::API_VERSION && queue_family(&self.instance, *physical).is_some()
            })
            .collect())
    }

    pub fn destroy(self) {
        // SAFETY: called once, after everything made from the instance is gone; the layer may still report here.
        unsafe {
            if let Some((functions, messenger)) = &self.messenger {
                functions.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

/// The first family of a device's queues that draws and computes.
pub(super) fn queue_family(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: `physical` belongs to this live instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    families.iter().position(|f| f.queue_flags.contains(both)).map(|i| i as u32)
}
