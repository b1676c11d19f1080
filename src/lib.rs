//! impasto shades 3D models with real paint.
//!
//! An artist paints one strip, dark on the left to light on the right. The crate takes the strip and a 3D model and
//! makes the model look painted with it: R. Bailey, *Techniques for Non-photorealistic Shading Using Real Paint* (2004),
//! on Vulkan 1.1.
#![warn(missing_docs)]

pub mod error;
pub mod gpu;
pub mod paint;
pub mod scene;
#[doc(hidden)]
pub mod shader_table;
pub mod synthesis;
pub mod technique;

pub use error::{Error, Result};

/// Compiles the README's examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
