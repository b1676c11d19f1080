//! Models and paint strips of the project's own, embedded so that `impasto demo` needs no file.

use super::failure::Result;
use impasto::paint::PaintSample;
use impasto::scene::{Mesh, MeshOptions};
use std::path::Path;

/// A file that is part of the program.
pub struct Builtin {
    /// The name under which it is written.
    pub name: &'static str,
    /// Its content.
    pub bytes: &'static [u8],
}

/// All of them; `assets/README.md` says what they are and how they are made.
pub const BUILTIN: [Builtin; 5] = [
    Builtin { name: "head.obj", bytes: include_bytes!("../../assets/head.obj") },
    Builtin { name: "teapot_on_table.obj", bytes: include_bytes!("../../assets/teapot_on_table.obj") },
    Builtin { name: "strip_green_yellow.png", bytes: include_bytes!("../../assets/strip_green_yellow.png") },
    Builtin { name: "strip_dark_red.png", bytes: include_bytes!("../../assets/strip_dark_red.png") },
    Builtin { name: "strip_red_yellow.png", bytes: include_bytes!("../../assets/strip_red_yellow.png") },
];

/// The content of the one of that name; nothing, which no reader takes, where there is none.
fn bytes(name: &str) -> &'static [u8] {
    BUILTIN.iter().find(|file| file.name == name).map(|file| file.bytes).unwrap_or_default()
}

/// The model of that name.
pub fn builtin_model(name: &str) -> Result<Mesh> {
    Ok(Mesh::parse(bytes(name), name, &MeshOptions::default())?.mesh)
}

/// The strip of that name.
pub fn builtin_strip(name: &str) -> Result<PaintSample> {
    Ok(PaintSample::decode(bytes(name), Path::new(name))?)
}
