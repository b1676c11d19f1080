//! How include/impasto.h is made of src/capi; for the command that writes it and the test that finds a stale one.

use cbindgen::{Builder, Config, EnumConfig, ExportConfig, Language, RenameRule, Style};
use std::path::Path;

/// The files that declare what C sees, in the order of the header.
const FILES: [&str; 10] =
    ["types", "handles", "status", "context", "image", "mesh", "params", "effect", "frame", "composite"];
/// Declared, but named by no function: structures have them as plain numbers.
const NUMBERS: [&str; 9] = [
    "ImpastoBlend",
    "ImpastoLogLevel",
    "ImpastoRepeat",
    "ImpastoSeams",
    "ImpastoShow",
    "ImpastoTargetColor",
    "ImpastoTechnique",
    "ImpastoTileable",
    "ImpastoStatus",
];

/// The text of the header.
pub fn header(root: &Path) -> Result<String, cbindgen::Error> {
    let config = Config {
        language: Language::C,
        cpp_compat: true,
        style: Style::Both,
        include_guard: Some("IMPASTO_H".to_owned()),
        header: Some(include_str!("contract.h").trim_end().to_owned()),
        no_includes: true,
        sys_includes: vec!["stdint.h".to_owned(), "vulkan/vulkan_core.h".to_owned()],
        line_length: 120,
        enumeration: EnumConfig { rename_variants: RenameRule::QualifiedScreamingSnakeCase, ..EnumConfig::default() },
        export: ExportConfig {
            include: NUMBERS.map(str::to_owned).to_vec(),
            exclude: vec!["PFN_vkGetInstanceProcAddr".to_owned()],
            ..ExportConfig::default()
        },
        ..Config::default()
    };
    let builder = FILES.iter().fold(Builder::new().with_config(config), |builder, file| {
        builder.with_src(root.join(format!("src/capi/{file}.rs")))
    });
    let mut text = Vec::new();
    builder.generate()?.write(&mut text);
    Ok(String::from_utf8_lossy(&text).into_owned())
}
