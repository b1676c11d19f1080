//! `impasto devices`: what there is to compute on.

use super::failure::{Failure, Result};
use super::session::{device_json, Session};
use impasto::gpu::{list_devices, DeviceChoice};
use serde_json::Value;

/// Lists the devices; the one that is taken by default is marked.
pub fn run(session: &mut Session) -> Result {
    if session.validates() {
        return Err(Failure::new("--validate: this command opens no device, so that there is nothing to validate"));
    }
    let devices = list_devices()?;
    let best = DeviceChoice::Best.pick(&devices).map(|device| device.index);
    let best = best.map_err(|_| Failure::new("there is no Vulkan 1.1 device that draws and computes"))?;
    let mut lines = Vec::new();
    for device in &devices {
        let mark = if device.index == best { "  (default)" } else { "" };
        lines.push(format!("{}  {}{mark}", device.index, device.name));
        lines.push(format!("   {:10}  Vulkan {}  {}", device.kind, device.api_version_text(), device.uuid));
        let place = device.pci.map(|address| format!("PCI {address}"));
        let driver = [&device.driver_name, &device.driver_info].into_iter().flatten().cloned();
        let more: Vec<String> = place.into_iter().chain(driver).collect();
        if !more.is_empty() {
            lines.push(format!("   {}", more.join("  ")));
        }
    }
    let list: Vec<Value> = devices.iter().map(device_json).collect();
    session.result("default_device", best, lines.join("\n"));
    session.attach("devices", list);
    Ok(())
}
