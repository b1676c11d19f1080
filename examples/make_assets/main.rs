//! Makes the project's own assets: two models and three paint strips, all by the code beside this file.
//!
//! ```text
//! cargo run --release --example make_assets -- assets
//! ```
//!
//! writes them into the folder `assets`, from where the program embeds them. Every run gives the same bytes: random
//! choices come from fixed seeds, and only arithmetic that IEEE 754 specifies exactly is used. The test `assets`
//! makes them again and compares.
//!
//! - `head` models a skull with signed distance `field`s; `surface_nets` turns it into triangles and `decimate`
//!   thins them.
//! - `teapot` draws the pot along its `curve`s.
//! - `strips` says where strokes go; `brush` lays them down, with paints that mix as in `pigment`.

pub mod brush;
pub mod curve;
pub mod decimate;
pub mod field;
pub mod head;
pub mod mesh;
pub mod pigment;
pub mod random;
pub mod strips;
pub mod surface_nets;
pub mod teapot;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use std::error::Error;
use std::path::Path;

/// The skull-like head as OBJ text.
pub fn head_obj() -> String {
    mesh::to_obj("impasto: a skull-like head; centimetres, y up, facing +z", &[("head", &head::mesh())], 3)
}

/// The teapot on its table as OBJ text.
pub fn teapot_obj() -> String {
    let (pot, table) = (teapot::pot(), teapot::table());
    mesh::to_obj("impasto: a teapot on a table of two triangles; y up", &[("teapot", &pot), ("table", &table)], 4)
}

/// Each strip: its file name, its size in pixels, its rows of RGB bytes and the number of strokes on it.
pub fn strips() -> impl Iterator<Item = (String, (usize, usize), Vec<u8>, usize)> {
    strips::RECIPES.iter().map(|recipe| {
        let (pixels, strokes) = recipe.paint();
        (format!("{}.png", recipe.name), strips::SIZE, pixels, strokes)
    })
}

fn png((width, height): (usize, usize), pixels: &[u8]) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(pixels, width as u32, height as u32, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))?;
    println!("{} ({} bytes)", path.display(), bytes.len());
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("usage: make_assets FOLDER")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, size, pixels, _) in strips() {
        write(folder, &name, &png(size, &pixels)?)?;
    }
    write(folder, "teapot_on_table.obj", teapot_obj().as_bytes())?;
    write(folder, "head.obj", head_obj().as_bytes())
}
