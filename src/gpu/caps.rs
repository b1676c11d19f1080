//! What devices there are, how one is chosen, and the limits that the rest of the crate looks at.

use super::requirements::requirements;
use crate::{Error, Result};
use ash::vk;
use std::fmt;
use std::str::FromStr;

/// A device's `deviceUUID` (Vulkan 1.1), stable over restarts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Uuid(pub [u8; 16]);

impl fmt::Display for Uuid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, byte) in self.0.iter().enumerate() {
            if matches!(i, 4 | 6 | 8 | 10) {
                f.write_str("-")?;
            }
            write!(f, "{byte:02x}")?;
        }
        Ok(())
    }
}

/// The kind of a device; in this order one is preferred over the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics card with memory of its own.
    Discrete,
    /// A GPU that shares the system's memory.
    Integrated,
    /// A GPU inside a virtual machine.
    Virtual,
    /// Vulkan computed on the CPU, such as Mesa's lavapipe.
    Cpu,
    /// Anything else.
    Other,
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            DeviceKind::Discrete => "discrete",
            DeviceKind::Integrated => "integrated",
            DeviceKind::Virtual => "virtual",
            DeviceKind::Cpu => "cpu",
            DeviceKind::Other => "other",
        })
    }
}

/// One physical device, as [`list_devices`] sees it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Its place in Vulkan's own enumeration.
    pub index: usize,
    /// The driver's name for it.
    pub name: String,
    /// Discrete, integrated, ...
    pub kind: DeviceKind,
    /// Stable identity.
    pub uuid: Uuid,
    /// PCI vendor.
    pub vendor_id: u32,
    /// PCI device.
    pub device_id: u32,
    /// The highest Vulkan version that it offers.
    pub api_version: u32,
    /// The driver's version, in the driver's own encoding.
    pub driver_version: u32,
}

impl DeviceInfo {
    /// The API version as `major.minor.patch`.
    pub fn api_version_text(&self) -> String {
        let v = self.api_version;
        format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v))
    }
}

/// Which device to take.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// Discrete over integrated over virtual over CPU, the first of its kind.
    #[default]
    Best,
    /// By its place in the list.
    Index(usize),
    /// By (part of) its name, letters' case ignored.
    Name(String),
    /// By its UUID.
    Uuid(Uuid),
}

impl FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    /// A number is an index, 32 hexadecimal digits (dashes ignored) are a UUID, anything else is a name.
    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        if let Ok(index) = text.parse() {
            return Ok(DeviceChoice::Index(index));
        }
        let digits: Vec<u32> = text.chars().filter(|&c| c != '-').map_while(|c| c.to_digit(16)).collect();
        if digits.len() == 32 && text.chars().filter(|&c| c != '-').count() == 32 {
            let mut uuid = [0u8; 16];
            for (byte, pair) in uuid.iter_mut().zip(digits.chunks_exact(2)) {
                *byte = (pair[0] * 16 + pair[1]) as u8;
            }
            return Ok(DeviceChoice::Uuid(Uuid(uuid)));
        }
        Ok(DeviceChoice::Name(text.to_owned()))
    }
}

impl DeviceChoice {
    /// Picks from `devices`, or says what there is to pick from.
    pub fn pick<'a>(&self, devices: &'a [DeviceInfo]) -> Result<&'a DeviceInfo> {
        let found = match self {
            DeviceChoice::Best => devices.iter().min_by_key(|d| (d.kind, d.index)),
            DeviceChoice::Index(index) => devices.iter().find(|d| d.index == *index),
            DeviceChoice::Name(name) => {
                let name = name.to_lowercase();
                devices.iter().find(|d| d.name.to_lowercase().contains(&name))
            }
            DeviceChoice::Uuid(uuid) => devices.iter().find(|d| d.uuid == *uuid),
        };
        found.ok_or_else(|| {
            let wanted = match self {
                DeviceChoice::Best => "any Vulkan 1.1 device".to_owned(),
                DeviceChoice::Index(index) => format!("device {index}"),
                DeviceChoice::Name(name) => format!("a device named \"{name}\""),
                DeviceChoice::Uuid(uuid) => format!("the device with UUID {uuid}"),
            };
            let list: Vec<String> = devices.iter().map(|d| format!("{}: {}", d.index, d.name)).collect();
            let list = if list.is_empty() { "none".to_owned() } else { list.join("; ") };
            Error::Device(format!("{wanted} was not found; devices here: {list}"))
        })
    }
}

/// All devices that offer Vulkan 1.1 and a queue that draws and computes, in Vulkan's order.
///
/// # Errors
/// [`Error::Device`] when there is no Vulkan loader.
pub fn list_devices() -> Result<Vec<DeviceInfo>> {
    let loader = super::context::Loader::new(false, None)?;
    let listed = loader.physical_devices();
    loader.destroy();
    Ok(listed?.into_iter().map(|(_, info)| info).collect())
}

fn kind(device: vk::PhysicalDeviceType) -> DeviceKind {
    match device {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

pub(crate) fn describe(instance: &ash::Instance, physical: vk::PhysicalDevice, index: usize) -> DeviceInfo {
    let mut id = vk::PhysicalDeviceIDProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut id);
    // SAFETY: `physical` was enumerated from this live instance, which is of version 1.1.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let p = properties.properties;
    let name = p.device_name_as_c_str().unwrap_or(c"?");
    DeviceInfo {
        index,
        name: name.to_string_lossy().into_owned(),
        kind: kind(p.device_type),
        uuid: Uuid(id.device_uuid),
        vendor_id: p.vendor_id,
        device_id: p.device_id,
        api_version: p.api_version,
        driver_version: p.driver_version,
    }
}

/// The limits of one device that the crate looks at.
#[derive(Debug, Clone)]
pub struct Caps {
    /// What kind of device it is.
    pub kind: DeviceKind,
    /// Nanoseconds per timestamp tick; timestamps are off where the queue has none.
    pub timestamp_period_ns: f32,
    /// Valid bits of a timestamp on the queue family in use; 0: no timestamps.
    pub timestamp_bits: u32,
    /// Largest side of a 2D image, pixels (4,096 at least).
    pub max_image_2d_px: u32,
    /// Largest side of a 3D image, texels (256 at least).
    pub max_image_3d_px: u32,
    /// Largest range of one storage buffer, bytes (128 MiB at least).
    pub max_storage_buffer_bytes: u64,
    /// Largest x count of workgroups in a dispatch (65,535 at least).
    pub max_group_count_x: u32,
    /// Whether integer dot products of packed 8-bit numbers (`VK_KHR_shader_integer_dot_product`) are enabled: on a
    /// device of our own where it offers them, never on a host's.
    pub integer_dot_product: bool,
    /// The depth format that guide passes use.
    pub depth_format: vk::Format,
    /// For the pipeline cache's header.
    pub pipeline_cache_uuid: [u8; 16],
    /// PCI vendor.
    pub vendor_id: u32,
    /// PCI device.
    pub device_id: u32,
}

impl Caps {
    pub(crate) fn query(instance: &ash::Instance, physical: vk::PhysicalDevice, queue_family: u32) -> Self {
        // SAFETY: `physical` belongs to this live instance.
        let (p, families) = unsafe {
            (
                instance.get_physical_device_properties(physical),
                instance.get_physical_device_queue_family_properties(physical),
            )
        };
        // SAFETY: as above.
        let format = |format| unsafe { instance.get_physical_device_format_properties(physical, format) };
        Caps {
            kind: kind(p.device_type),
            timestamp_period_ns: p.limits.timestamp_period,
            timestamp_bits: families.get(queue_family as usize).map_or(0, |f| f.timestamp_valid_bits),
            max_image_2d_px: p.limits.max_image_dimension2_d,
            max_image_3d_px: p.limits.max_image_dimension3_d,
            max_storage_buffer_bytes: u64::from(p.limits.max_storage_buffer_range),
            max_group_count_x: p.limits.max_compute_work_group_count[0],
            integer_dot_product: false,
            // A device that is in use has one: `Requirements::check`.
            depth_format: requirements().depth_format(format).unwrap_or(vk::Format::D32_SFLOAT),
            pipeline_cache_uuid: p.pipeline_cache_uuid,
            vendor_id: p.vendor_id,
            device_id: p.device_id,
        }
    }
}

/// Whether the device offers `VK_KHR_shader_integer_dot_product` and its feature.
pub(crate) fn offers_integer_dot_product(instance: &ash::Instance, physical: vk::PhysicalDevice) -> bool {
    // SAFETY: `physical` belongs to this live instance.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    let name = ash::khr::shader_integer_dot_product::NAME;
    if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name)) {
        return false;
    }
    let mut dot = vk::PhysicalDeviceShaderIntegerDotProductFeatures::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut dot);
    // SAFETY: as above; the instance is of version 1.1, and the device knows the structure.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    dot.shader_integer_dot_product == vk::TRUE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(index: usize, kind: DeviceKind, name: &str) -> DeviceInfo {
        let uuid = Uuid([index as u8 + 1; 16]);
        let name = name.to_owned();
        DeviceInfo { index, name, kind, uuid, vendor_id: 0, device_id: 0, api_version: 0, driver_version: 0 }
    }

    #[test]
    fn choice_is_parsed_and_picked() {
        let devices = [
            device(0, DeviceKind::Cpu, "llvmpipe"),
            device(1, DeviceKind::Integrated, "Iris"),
            device(2, DeviceKind::Discrete, "Radeon Pro"),
        ];
        let pick = |text: &str| {
            let Ok(choice) = text.parse::<DeviceChoice>();
            choice.pick(&devices).map(|d| d.index)
        };
        assert_eq!(DeviceChoice::Best.pick(&devices).map(|d| d.index).ok(), Some(2));
        assert_eq!(pick("1").ok(), Some(1));
        assert_eq!(pick("radeon").ok(), Some(2));
        assert_eq!(pick(&devices[1].uuid.to_string()).ok(), Some(1));
        let message = pick("GeForce").map_err(|e| e.to_string()).expect_err("no such device");
        assert!(message.contains("GeForce") && message.contains("1: Iris"), "{message}");
        assert!(pick("7").is_err());
    }
}
