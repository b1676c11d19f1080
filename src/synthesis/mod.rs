//! synthesis
pub mod params;
pub mod quilt;
pub mod quilt_oracle;
pub mod tile_oracle;
