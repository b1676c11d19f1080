//! Links the shader compiler when the developer's feature `shaderc` is on; does nothing otherwise.
//!
//! Debian and Ubuntu ship shaderc as a static library whose own dependencies (glslang, SPIRV-Tools) the `shaderc`
//! crate does not name, so they are named here. With `SHADERC_LIB_DIR` unset the crate builds its own copy from
//! source, which needs none of this.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=SHADERC_LIB_DIR");
    if std::env::var_os("CARGO_FEATURE_SHADERC").is_none() {
        return;
    }
    let Some(dir) = std::env::var_os("SHADERC_LIB_DIR").map(std::path::PathBuf::from) else { return };
    println!("cargo:rustc-link-search=native={}", dir.display());
    // Which of these there are differs between versions of glslang: newer ones have merged some into others.
    let libraries = [
        "glslang",
        "SPIRV",
        "MachineIndependent",
        "GenericCodeGen",
        "OSDependent",
        "OGLCompiler",
        "glslang-default-resource-limits",
        "SPIRV-Tools-opt",
        "SPIRV-Tools",
    ];
    for library in libraries.iter().filter(|library| dir.join(format!("lib{library}.a")).is_file()) {
        println!("cargo:rustc-link-arg=-l{library}");
    }
    println!("cargo:rustc-link-arg=-lstdc++");
}
