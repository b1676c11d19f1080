//! What devices there are, how one is chosen, and the limits that the rest of the crate looks at.

use super::requirements::requirements;
use crate::{Error, Result};
use ash::vk;
use std::ffi::CStr;
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

/// Where a device sits on the PCI bus, as the system's tools name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PciAddress {
    /// The domain, 0 on most machines.
    pub domain: u32,
    /// The bus.
    pub bus: u32,
    /// The device on it.
    pub device: u32,
    /// The function of the device.
    pub function: u32,
}

impl fmt::Display for PciAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04x}:{:02x}:{:02x}.{:x}", self.domain, self.bus, self.device, self.function)
    }
}

impl FromStr for PciAddress {
    type Err = Error;

    /// `domain:bus:device.function` or `bus:device.function`, in hexadecimal.
    fn from_str(text: &str) -> Result<Self> {
        let parse = || {
            let hex = |text: &str, most: u32| {
                let digits = !text.is_empty() && text.chars().all(|c| c.is_ascii_hexdigit());
                digits.then(|| u32::from_str_radix(text, 16).ok()).flatten().filter(|&number| number <= most)
            };
            let (rest, function) = text.rsplit_once('.')?;
            let (rest, device) = rest.rsplit_once(':')?;
            let (domain, bus) = rest.rsplit_once(':').unwrap_or(("0", rest));
            Some(PciAddress {
                domain: hex(domain, u32::MAX)?,
                bus: hex(bus, 0xff)?,
                device: hex(device, 0x1f)?,
                function: hex(function, 7)?,
            })
        };
        parse().ok_or_else(|| Error::parameter("PCI address", text, "of the form 0000:01:00.0 or 01:00.0"))
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
    /// Where it sits, if it has such a place and its driver tells (`VK_EXT_pci_bus_info`).
    pub pci: Option<PciAddress>,
    /// The driver's name, where it tells (`VK_KHR_driver_properties`).
    pub driver_name: Option<String>,
    /// The driver's version in its own words, where it tells.
    pub driver_info: Option<String>,
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
    /// By its place on the PCI bus.
    Pci(PciAddress),
}

impl FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    /// A number is an index, 32 hexadecimal digits (dashes ignored) are a UUID, `0000:01:00.0` or `01:00.0` a place on
    /// the PCI bus, anything else is a name.
    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        if let Ok(index) = text.parse() {
            return Ok(DeviceChoice::Index(index));
        }
        if let Ok(address) = text.parse() {
            return Ok(DeviceChoice::Pci(address));
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
            DeviceChoice::Pci(address) => devices.iter().find(|d| d.pci == Some(*address)),
        };
        found.ok_or_else(|| {
            let wanted = match self {
                DeviceChoice::Best => "any Vulkan 1.1 device".to_owned(),
                DeviceChoice::Index(index) => format!("device {index}"),
                DeviceChoice::Name(name) => format!("a device named \"{name}\""),
                DeviceChoice::Uuid(uuid) => format!("the device with UUID {uuid}"),
                DeviceChoice::Pci(address) => format!("the device at PCI address {address}"),
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
    let loader = super::loader::Loader::new(false, None)?;
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
    // By its extension alone: a host's instance need not know of Vulkan 1.2, where the latter is part of the core.
    let tells_pci = offers(instance, physical, ash::ext::pci_bus_info::NAME);
    let tells_driver = offers(instance, physical, ash::khr::driver_properties::NAME);
    let mut id = vk::PhysicalDeviceIDProperties::default();
    let mut pci = vk::PhysicalDevicePCIBusInfoPropertiesEXT::default();
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut id);
    if tells_pci {
        properties = properties.push_next(&mut pci);
    }
    if tells_driver {
        properties = properties.push_next(&mut driver);
    }
    // SAFETY: `physical` was enumerated from this live instance, which is of version 1.1.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let p = properties.properties;
    let name = p.device_name_as_c_str().unwrap_or(c"?");
    let told = |text: Result<&CStr, std::ffi::FromBytesUntilNulError>| {
        let text = text.unwrap_or_default().to_string_lossy().into_owned();
        (tells_driver && !text.is_empty()).then_some(text)
    };
    DeviceInfo {
        index,
        name: name.to_string_lossy().into_owned(),
        kind: kind(p.device_type),
        uuid: Uuid(id.device_uuid),
        vendor_id: p.vendor_id,
        device_id: p.device_id,
        api_version: p.api_version,
        driver_version: p.driver_version,
        pci: tells_pci.then_some(PciAddress {
            domain: pci.pci_domain,
            bus: pci.pci_bus,
            device: pci.pci_device,
            function: pci.pci_function,
        }),
        driver_name: told(driver.driver_name_as_c_str()),
        driver_info: told(driver.driver_info_as_c_str()),
    }
}

/// Whether the device lists an extension.
fn offers(instance: &ash::Instance, physical: vk::PhysicalDevice, extension: &CStr) -> bool {
    // SAFETY: `physical` belongs to this live instance.
    let listed = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    listed.iter().any(|e| e.extension_name_as_c_str() == Ok(extension))
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
    if !offers(instance, physical, ash::khr::shader_integer_dot_product::NAME) {
        return false;
    }
    let mut dot = vk::PhysicalDeviceShaderIntegerDotProductFeatures::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut dot);
    // SAFETY: `physical` belongs to this live instance, which is of version 1.1; the device knows the structure.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    dot.shader_integer_dot_product == vk::TRUE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(index: usize, kind: DeviceKind, name: &str) -> DeviceInfo {
        let uuid = Uuid([index as u8 + 1; 16]);
        let name = name.to_owned();
        let pci = PciAddress { domain: 0, bus: 0x41 + index as u32, device: 0x1f, function: 7 };
        DeviceInfo {
            index,
            name,
            kind,
            uuid,
            vendor_id: 0,
            device_id: 0,
            api_version: 0,
            driver_version: 0,
            pci: Some(pci),
            driver_name: None,
            driver_info: None,
        }
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
        assert_eq!(pick("0000:42:1f.7").ok(), Some(1));
        assert_eq!(pick("43:1f.7").ok(), Some(2));
        let message = pick("00:02.0").map_err(|e| e.to_string()).expect_err("no such device");
        assert!(message.contains("the device at PCI address 0000:00:02.0 was not found"), "{message}");
        let message = pick("GeForce").map_err(|e| e.to_string()).expect_err("no such device");
        assert!(message.contains("GeForce") && message.contains("1: Iris"), "{message}");
        assert!(pick("7").is_err());
    }

    #[test]
    fn pci_addresses_are_parsed_as_they_are_shown() {
        let address = PciAddress { domain: 0, bus: 1, device: 0, function: 0 };
        assert_eq!(address.to_string(), "0000:01:00.0");
        for text in ["0000:01:00.0", "01:00.0", "1:0.0", "00000000:01:00.0"] {
            assert_eq!(text.parse::<PciAddress>().ok(), Some(address), "{text}");
        }
        let far = PciAddress { domain: 0x1_0000, bus: 0xfe, device: 0x1f, function: 7 };
        assert_eq!(far.to_string(), "10000:fe:1f.7");
        assert_eq!(far.to_string().parse::<PciAddress>().ok(), Some(far));
        for text in
            ["", ".", "::.", "01.0", "01:00", "01:00.8", "01:20.0", "100:00.0", "+1:00.0", "0:0:0:0.0", "1:0.0 "]
        {
            assert!(text.parse::<PciAddress>().is_err(), "{text}");
            assert!(!matches!(text.parse(), Ok(DeviceChoice::Pci(_))), "{text}");
        }
    }
}
