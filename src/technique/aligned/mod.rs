//! View-aligned 3D texture projection (thesis chapter 7).

mod level_texture;

pub use level_texture::LevelTexture;
