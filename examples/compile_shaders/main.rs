//! Compiles glsl/ to the SPIR-V in glsl/spirv/ that the crate embeds.
//!
//! `cargo run --features shaderc --example compile_shaders` writes the binaries and `fingerprints.txt`;
//! with `-- --check` it writes nothing and fails when a binary is not what its source compiles to.

mod sources;

use shaderc::{CompileOptions, Compiler, EnvVersion, IncludeType, OptimizationLevel, ResolvedInclude, ShaderKind};
use sources::ShaderSource;
use std::error::Error;
use std::path::Path;

fn compile(compiler: &Compiler, shader: &ShaderSource) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut options = CompileOptions::new()?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, EnvVersion::Vulkan1_1 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_3);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    let folder = shader.path.parent().unwrap_or(Path::new(".")).to_owned();
    options.set_include_callback(move |name, kind, _, _| {
        if kind != IncludeType::Relative {
            return Err(format!("include \"{name}\" with quotes"));
        }
        let path = folder.join(name);
        let content = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(ResolvedInclude { resolved_name: path.display().to_string(), content })
    });
    let kind = match shader.path.extension().and_then(|e| e.to_str()) {
        Some("vert") => ShaderKind::Vertex,
        Some("frag") => ShaderKind::Fragment,
        _ => ShaderKind::Compute,
    };
    let text = std::fs::read_to_string(&shader.path)?;
    let artifact = compiler.compile_into_spirv(&text, kind, &shader.name, "main", Some(&options))?;
    Ok(artifact.as_binary_u8().to_vec())
}

fn main() -> Result<(), Box<dyn Error>> {
    let check = std::env::args().any(|argument| argument == "--check");
    let glsl = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl");
    let compiler = Compiler::new()?;
    let mut stale = Vec::new();
    let shaders = sources::shaders(&glsl)?;
    for shader in &shaders {
        let binary = compile(&compiler, shader)?;
        let path = shader.binary(&glsl);
        if check {
            if std::fs::read(&path).ok().as_ref() != Some(&binary) {
                stale.push(shader.name.clone());
            }
        } else {
            std::fs::create_dir_all(path.parent().ok_or("no folder for binaries")?)?;
            std::fs::write(path, binary)?;
        }
    }
    if !stale.is_empty() {
        return Err(format!("not what their sources compile to: {}; run `make shaders`", stale.join(", ")).into());
    }
    if !check {
        std::fs::write(glsl.join("spirv/fingerprints.txt"), sources::listing(&glsl)?)?;
    }
    println!("{} shaders {}", shaders.len(), if check { "are up to date" } else { "compiled" });
    Ok(())
}
