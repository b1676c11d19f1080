//! `scripts/setup` on machines that lack things: a folder of made-up commands stands in for the system's.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

/// What is made up: cargo's version, the packages that are installed, who we are, and whether there is an apt-get.
struct Machine {
    cargo: &'static str,
    installed: &'static str,
    root: bool,
    debian: bool,
}

const WHOLE: Machine = Machine {
    cargo: "cargo 1.90.0 (abc 2025-09-01)",
    installed: "libvulkan1 mesa-vulkan-drivers vulkan-validationlayers libvulkan-dev valgrind libshaderc-dev \
                glslang-dev spirv-tools g++",
    root: false,
    debian: true,
};

/// Runs the script with nothing on its path but made-up commands and the few plain tools that it uses. Every call of
/// apt-get is noted in the second result.
fn setup(machine: &Machine, purpose: &str) -> (Output, String) {
    let dir = tempfile::tempdir().expect("a folder");
    let bin = dir.path().join("bin");
    fs::create_dir(&bin).expect("a folder");
    let command = |name: &str, body: &str| {
        let path = bin.join(name);
        fs::write(&path, format!("#!/bin/sh\n{body}\n")).expect("a script");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("an executable");
    };
    for tool in ["sed", "env"] {
        let real = ["/usr/bin", "/bin"].map(|d| Path::new(d).join(tool)).into_iter().find(|p| p.exists());
        std::os::unix::fs::symlink(real.expect("a plain tool"), bin.join(tool)).expect("a link");
    }
    command("cargo", &format!("echo '{}'", machine.cargo));
    command("cargo-fmt", "exit 0");
    command("cargo-clippy", "exit 0");
    command("cc", "exit 0");
    command("id", if machine.root { "echo 0" } else { "echo 1000" });
    let log = dir.path().join("apt");
    if machine.debian {
        let known = format!(
            "for p in {}; do [ \"$p\" = \"$3\" ] && {{ printf installed; exit 0; }}; done; exit 1",
            machine.installed
        );
        command("dpkg-query", &known);
        command("apt-get", &format!("echo \"$@\" >>'{}'", log.display()));
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/setup");
    let output = Command::new("/bin/sh")
        .arg(script)
        .arg(purpose)
        .env_clear()
        .env("PATH", &bin)
        // No driver's manifest lies below this folder.
        .env("SETUP_ROOT", dir.path())
        .output()
        .expect("a shell");
    (output, fs::read_to_string(log).unwrap_or_default())
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn nothing_is_run_where_all_is_there() {
    for purpose in ["demo", "test"] {
        let (output, apt) = setup(&WHOLE, purpose);
        assert!(output.status.success(), "{}", errors(&output));
        assert_eq!((output.stdout.len(), apt.as_str()), (0, ""), "{purpose}");
    }
}

#[test]
fn without_roots_rights_the_exact_command_is_printed() {
    let machine = Machine { installed: "libvulkan1", ..WHOLE };
    let (output, apt) = setup(&machine, "demo");
    assert_eq!((output.status.code(), apt.as_str()), (Some(1), ""));
    let told = errors(&output);
    let command = "sudo apt-get update && sudo apt-get install -y --no-install-recommends g++ mesa-vulkan-drivers\n";
    assert!(told.contains(command), "{told}");
}

#[test]
fn root_installs_just_what_is_missing() {
    let machine = Machine { installed: "libvulkan1 mesa-vulkan-drivers g++ spirv-tools", root: true, ..WHOLE };
    let (output, apt) = setup(&machine, "test");
    assert!(output.status.success(), "{}", errors(&output));
    let lacking = "vulkan-validationlayers libvulkan-dev valgrind libshaderc-dev glslang-dev";
    assert_eq!(apt, format!("install -y --no-install-recommends {lacking}\n"));
    // The demo needs none of these.
    assert_eq!(setup(&machine, "demo").1, "");
}

#[test]
fn an_old_cargo_is_refused_and_another_system_is_told_what_is_needed() {
    let (output, _) = setup(&Machine { cargo: "cargo 1.65.0", ..WHOLE }, "demo");
    assert_eq!(output.status.code(), Some(1));
    assert!(errors(&output).contains("cargo 1.65.0 is too old: Rust 1.88 or later"), "{}", errors(&output));

    let (output, _) = setup(&Machine { debian: false, ..WHOLE }, "test");
    assert!(output.status.success(), "{}", errors(&output));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains("not Debian") && told.contains("vulkan-validationlayers"), "{told}");
}

#[test]
fn the_least_cargo_is_that_of_the_manifest() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = fs::read_to_string(root.join("scripts/setup")).expect("the script");
    let manifest = fs::read_to_string(root.join("Cargo.toml")).expect("the manifest");
    let minor = script.lines().find_map(|line| line.strip_prefix("rust_minor=")).expect("the version");
    assert!(manifest.contains(&format!("rust-version = \"1.{minor}\"")));
}
