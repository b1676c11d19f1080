//! Where and when a run takes place: this build, this machine, its device, this moment.
//!
//! What a system does not tell is left out; nothing of it fails a run.

use super::results::{Device, System, Tool};
use impasto::gpu::DeviceInfo;
use std::time::{SystemTime, UNIX_EPOCH};

impl Tool {
    /// This program. `make` tells the compiler the commit, because a build script that did would compile the whole
    /// crate again after each commit, for embedders too.
    pub fn here() -> Self {
        Tool {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("IMPASTO_COMMIT").filter(|commit| !commit.is_empty()).map(str::to_owned),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.to_owned(),
        }
    }
}

impl System {
    /// This machine.
    pub fn here() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        System {
            os: os(&read("/etc/os-release"), &read("/proc/sys/kernel/osrelease")),
            arch: std::env::consts::ARCH.to_owned(),
            cpu: cpu(&read("/proc/cpuinfo")),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}

impl Device {
    /// A device, as Vulkan tells of it.
    pub fn of(info: &DeviceInfo) -> Self {
        Device {
            index: info.index,
            name: info.name.clone(),
            kind: info.kind.to_string(),
            uuid: info.uuid.to_string(),
            pci: info.pci.map(|pci| pci.to_string()),
            vendor_id: info.vendor_id,
            device_id: info.device_id,
            api_version: info.api_version_text(),
            driver_version: info.driver_version,
            driver_name: info.driver_name.clone(),
            driver_info: info.driver_info.clone(),
        }
    }
}

/// The distribution, if `os_release` names it (freedesktop.org's os-release), and the kernel.
fn os(os_release: &str, kernel: &str) -> String {
    let pretty = os_release.lines().find_map(|line| line.strip_prefix("PRETTY_NAME="));
    let pretty = pretty.map(|name| name.trim_matches(['"', '\'']).to_owned()).filter(|name| !name.is_empty());
    let kernel = format!("{} {}", std::env::consts::OS, kernel.trim());
    pretty.into_iter().chain([kernel.trim().to_owned()]).collect::<Vec<_>>().join(", ")
}

/// The processor's name in the text of /proc/cpuinfo; what it is called differs between architectures.
fn cpu(cpuinfo: &str) -> Option<String> {
    let named = |name: &str| {
        let mut lines = cpuinfo.lines().filter_map(|line| line.split_once(':'));
        lines.find(|(key, _)| key.trim() == name).map(|(_, value)| value.trim().to_owned())
    };
    let found = ["model name", "Hardware", "Model", "cpu"].iter().find_map(|name| named(name));
    found.filter(|name| !name.is_empty())
}

/// This moment, UTC, as `YYYY-MM-DDThh:mm:ssZ`.
pub fn now() -> String {
    stamp(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs())
}

/// The time so many seconds after the begin of 1970, without leap seconds.
fn stamp(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil(days);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Year, month and day of the Gregorian calendar so many days after 1970-01-01 (the algorithm `civil_from_days` of
/// H. Hinnant, chrono-Compatible Low-Level Date Algorithms). Years begin in March, so that the leap day is their last.
fn civil(days: u64) -> (u64, u64, u64) {
    const DAYS_FROM_YEAR_0_TO_1970: u64 = 719_468;
    const DAYS_OF_400_YEARS: u64 = 146_097;
    let days = days + DAYS_FROM_YEAR_0_TO_1970;
    let (era, day) = (days / DAYS_OF_400_YEARS, days % DAYS_OF_400_YEARS);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // Five months from March, or from August, have 153 days.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    (era * 400 + year + next, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_told_by_the_calendar() {
        let known = [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_000_000_000, "2001-09-09T01:46:40Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ];
        for (seconds, text) in known {
            assert_eq!(stamp(seconds), text);
        }
    }

    #[test]
    fn every_day_of_400_years_follows_the_one_before() {
        let length = |year: u64, month: u64| match month {
            2 if year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400)) => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            _ => 31,
        };
        let (mut year, mut month, mut day) = (1970, 1, 1);
        for days in 0..146_097 {
            assert_eq!(civil(days), (year, month, day));
            day += 1;
            if day > length(year, month) {
                (month, day) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
        }
    }

    #[test]
    fn the_system_is_named_as_far_as_it_tells() {
        let release = "NAME=\"Debian\"\nPRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\nVERSION_ID=\"12\"\n";
        let kernel = std::env::consts::OS;
        assert_eq!(os(release, "6.1.0\n"), format!("Debian GNU/Linux 12 (bookworm), {kernel} 6.1.0"));
        assert_eq!(os("", ""), kernel);
        let intel = "processor\t: 0\ncpu family\t: 6\nmodel name\t: Intel(R) Xeon(R)\n\nmodel name\t: another\n";
        assert_eq!(cpu(intel).as_deref(), Some("Intel(R) Xeon(R)"));
        assert_eq!(
            cpu("processor\t: 0\nBogoMIPS\t: 108.00\n\nModel\t\t: Raspberry Pi 5\n").as_deref(),
            Some("Raspberry Pi 5")
        );
        assert_eq!(cpu("processor : 0\n"), None);
        assert!(System::here().cores >= 1 && !Tool::here().version.is_empty() && now().ends_with('Z'));
    }
}
