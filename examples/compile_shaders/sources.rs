//! Which shaders there are, and a fingerprint of everything that one is compiled from.
//!
//! Shared by the compiler of the shaders and by the test that finds a stale binary without a compiler.

use std::path::{Path, PathBuf};

/// Changes whenever the compiler's options do, so that binaries made with others are stale.
pub const OPTIONS: &str = "vulkan1.1 spirv1.3 performance";

/// One shader: its path below glsl/ with '/' between the parts, as in `synthesis/quilt_search.comp`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ShaderSource {
    pub name: String,
    pub path: PathBuf,
}

impl ShaderSource {
    /// Where its binary is kept.
    pub fn binary(&self, glsl: &Path) -> PathBuf {
        glsl.join("spirv").join(format!("{}.spv", self.name))
    }
}

/// Every shader below `glsl`, sorted by name.
pub fn shaders(glsl: &Path) -> std::io::Result<Vec<ShaderSource>> {
    let mut found = Vec::new();
    for room in std::fs::read_dir(glsl)? {
        let room = room?;
        if !room.file_type()?.is_dir() {
            continue;
        }
        for file in std::fs::read_dir(room.path())? {
            let path = file?.path();
            if matches!(path.extension().and_then(|e| e.to_str()), Some("comp" | "vert" | "frag")) {
                let file_name = path.file_name().unwrap_or_default().to_string_lossy();
                found.push(ShaderSource { name: format!("{}/{file_name}", room.file_name().to_string_lossy()), path });
            }
        }
    }
    found.sort();
    Ok(found)
}

/// FNV-1a over the options, the source and every file that it includes, in the order of inclusion.
pub fn fingerprint(shader: &ShaderSource) -> std::io::Result<String> {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut add = |bytes: &[u8]| {
        for &byte in bytes {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    add(OPTIONS.as_bytes());
    let mut pending = vec![shader.path.clone()];
    while let Some(path) = pending.pop() {
        let text = std::fs::read_to_string(&path)?;
        add(text.as_bytes());
        let includes = text.lines().filter_map(|line| line.trim().strip_prefix("#include"));
        for name in includes {
            pending.push(path.with_file_name(name.trim().trim_matches('"')));
        }
    }
    Ok(format!("{hash:016x}"))
}

/// The list that stands beside the binaries: a fingerprint and a name a line.
pub fn listing(glsl: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    for shader in shaders(glsl)? {
        text += &format!("{}  {}\n", fingerprint(&shader)?, shader.name);
    }
    Ok(text)
}
