//! How a device is doing while it is measured: clocks, temperature, power. Read only; nothing is ever set.
//!
//! NVIDIA's driver tells by its own library (NVML), AMD's and Intel's by the system's files
//! (Linux: Documentation/hwmon/sysfs-interface). Where there is neither nothing is told.

use super::results::Telemetry;
use impasto::gpu::DeviceInfo;
use nvml_wrapper::enum_wrappers::device::{Clock, TemperatureSensor};
use nvml_wrapper::Nvml;
use std::path::{Path, PathBuf};

/// Where Linux lists PCI devices.
pub const SYSFS: &str = "/sys/bus/pci/devices";

/// PCI vendor of NVIDIA.
const NVIDIA: u32 = 0x10de;

/// What tells of one device.
pub struct Reader(Source);

enum Source {
    Nvml(Box<Nvml>, DeviceInfo),
    /// The folder of its sensors.
    Files(PathBuf),
}

impl Reader {
    /// What tells of `device`, if anything does; `sysfs` is [`SYSFS`], but for tests.
    pub fn new(device: &DeviceInfo, sysfs: &Path) -> Option<Self> {
        // Files too for NVIDIA's devices: the driver of the Linux kernel has no NVML.
        let nvml = (device.vendor_id == NVIDIA).then(Nvml::init).and_then(Result::ok);
        let nvml = nvml.filter(|nvml| find(nvml, device).is_some());
        let nvml = nvml.map(|nvml| Source::Nvml(Box::new(nvml), device.clone()));
        nvml.or_else(|| sensors(device, sysfs).map(Source::Files)).map(Reader)
    }

    /// How the device is doing now; `None` when nothing is told of it.
    pub fn read(&self) -> Option<Telemetry> {
        let told = match &self.0 {
            Source::Nvml(nvml, device) => by_nvml(nvml, device),
            Source::Files(folder) => by_files(folder),
        };
        (told != Telemetry::default()).then_some(told)
    }
}

/// The device as NVML knows it: by its place, or by the UUID that it has from Vulkan too.
fn find<'a>(nvml: &'a Nvml, device: &DeviceInfo) -> Option<nvml_wrapper::Device<'a>> {
    let by_place = device.pci.and_then(|address| nvml.device_by_pci_bus_id(address.to_string()).ok());
    by_place.or_else(|| nvml.device_by_uuid(format!("GPU-{}", device.uuid)).ok())
}

fn by_nvml(nvml: &Nvml, device: &DeviceInfo) -> Telemetry {
    let Some(device) = find(nvml, device) else { return Telemetry::default() };
    Telemetry {
        core_mhz: device.clock_info(Clock::SM).ok().map(f64::from),
        memory_mhz: device.clock_info(Clock::Memory).ok().map(f64::from),
        celsius: device.temperature(TemperatureSensor::Gpu).ok().map(f64::from),
        watts: device.power_usage().ok().map(|milliwatts| f64::from(milliwatts) / 1e3),
    }
}

/// The first folder of sensors that the device's driver offers.
fn sensors(device: &DeviceInfo, sysfs: &Path) -> Option<PathBuf> {
    let folder = sysfs.join(device.pci?.to_string()).join("hwmon");
    let all = std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    all.filter(|path| by_files(path) != Telemetry::default()).min()
}

fn by_files(folder: &Path) -> Telemetry {
    let read = |name: &str, unit: f64| {
        let text = std::fs::read_to_string(folder.join(name)).ok()?;
        text.trim().parse::<i64>().ok().map(|number| number as f64 / unit)
    };
    Telemetry {
        core_mhz: read("freq1_input", 1e6),
        memory_mhz: read("freq2_input", 1e6),
        celsius: read("temp1_input", 1e3),
        watts: read("power1_average", 1e6).or_else(|| read("power1_input", 1e6)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use impasto::gpu::{DeviceKind, PciAddress, Uuid};

    fn device(vendor_id: u32, pci: Option<PciAddress>) -> DeviceInfo {
        DeviceInfo {
            index: 0,
            name: "a device".to_owned(),
            kind: DeviceKind::Discrete,
            uuid: Uuid([1; 16]),
            vendor_id,
            device_id: 0,
            api_version: 0,
            driver_version: 0,
            pci,
            driver_name: None,
            driver_info: None,
        }
    }

    #[test]
    fn sensors_are_read_from_the_systems_files() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("0000:0a:00.0/hwmon/hwmon3");
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::create_dir_all(root.path().join("0000:0a:00.0/hwmon/hwmon1")).expect("a folder without sensors");
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file");
        write("freq1_input", "2475000000\n");
        write("temp1_input", "-1500\n");
        write("power1_input", "98000000\n");
        let amd = device(0x1002, "0a:00.0".parse().ok());
        let reader = Reader::new(&amd, root.path()).expect("sensors");
        let expected = Telemetry { core_mhz: Some(2475.0), memory_mhz: None, celsius: Some(-1.5), watts: Some(98.0) };
        assert_eq!(reader.read(), Some(expected.clone()));
        // What is averaged is better than one moment's; what is no number is not told.
        write("power1_average", "101500000");
        write("freq2_input", "1249000000");
        write("temp1_input", "warm");
        let more = Telemetry { memory_mhz: Some(1249.0), celsius: None, watts: Some(101.5), ..expected };
        assert_eq!(reader.read(), Some(more));
        // A device that is taken away.
        std::fs::remove_dir_all(root.path().join("0000:0a:00.0")).expect("removed");
        assert_eq!(reader.read(), None);
    }

    #[test]
    fn nothing_is_told_where_there_is_nothing() {
        let root = tempfile::tempdir().expect("a folder");
        assert!(Reader::new(&device(0x1002, "0a:00.0".parse().ok()), root.path()).is_none());
        assert!(Reader::new(&device(0x1002, None), root.path()).is_none());
        // Without NVML, or without this device.
        assert!(Reader::new(&device(NVIDIA, "ffff:ff:1f.7".parse().ok()), root.path()).is_none());
        std::fs::create_dir_all(root.path().join("0000:0a:00.0/hwmon/hwmon1")).expect("a folder");
        assert!(Reader::new(&device(0x8086, "0a:00.0".parse().ok()), root.path()).is_none());
    }
}
