//! What a run was made with: the program, the machine, the device, the time.

use super::results::{Device, System, Tool};
use impasto::gpu::DeviceInfo;
use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

/// The program.
pub fn tool() -> Tool {
    Tool {
        name: "impasto".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: option_env!("IMPASTO_COMMIT").map(str::to_owned),
        profile: if cfg!(debug_assertions) { "debug" } else { "release" }.to_owned(),
    }
}

/// The machine.
pub fn system() -> System {
    let named = value_of("/etc/os-release", "PRETTY_NAME", '=').unwrap_or_else(|| std::env::consts::OS.to_owned());
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    System {
        os: format!("{named} {}", kernel.trim()).trim().to_owned(),
        arch: std::env::consts::ARCH.to_owned(),
        cpu: value_of("/proc/cpuinfo", "model name", ':'),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// The first value of that name in a file of lines `NAME = VALUE`.
fn value_of(file: &str, name: &str, sign: char) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let values = text.lines().filter_map(|line| line.split_once(sign)).filter(|(key, _)| key.trim() == name);
    values.map(|(_, value)| value.trim().trim_matches('"').to_owned()).find(|value| !value.is_empty())
}

/// A device, as Vulkan tells of it.
pub fn device(info: &DeviceInfo) -> Device {
    Device {
        index: info.index,
        name: info.name.clone(),
        kind: info.kind.to_string(),
        uuid: info.uuid.to_string(),
        pci: None,
        vendor_id: info.vendor_id,
        device_id: info.device_id,
        api_version: info.api_version_text(),
        driver_version: info.driver_version,
        driver_name: None,
        driver_info: None,
    }
}

/// Now, UTC, as `YYYY-MM-DDThh:mm:ssZ`.
pub fn now() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    utc(seconds)
}

/// The same for a number of seconds since 1970.
fn utc(seconds: u64) -> String {
    let (mut day, second) = (seconds / 86_400, seconds % 86_400);
    let is_leap = |year: u64| (year.is_multiple_of(4) && !year.is_multiple_of(100)) || year.is_multiple_of(400);
    let mut year = 1970;
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for days in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if day < days {
            break;
        }
        day -= days;
        month += 1;
    }
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z", day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_told_as_dates() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(1_000_000_000), "2001-09-09T01:46:40Z");
        assert_eq!(utc(1_798_761_599), "2026-12-31T23:59:59Z");
        assert_eq!(utc(4_107_542_400), "2100-03-01T00:00:00Z");
    }

    #[test]
    fn the_machine_has_a_name_and_a_core() {
        let system = system();
        assert!(!system.os.is_empty() && system.cores > 0);
    }
}
