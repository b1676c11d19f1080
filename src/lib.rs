//! impasto: shades 3D models with real paint.

pub mod error;
pub mod gpu;
pub mod paint;
pub mod scene;
pub mod synthesis;

pub use error::{Error, Result};
