//! The C ABI: [`crate::embed`] for hosts that are not written in Rust. On with the feature `capi`.
//!
//! `include/impasto.h` is generated from these files (`make header`) and is its documentation: the contract of all
//! calls stands at its top. What is `unsafe` here is what a C caller promises there, and nothing else: handles are
//! numbers that are looked up, sizes are checked before they are believed, and no panic leaves a call.
//!
//! ```text
//! a C call -> guard -> handles: what it is about -> memory: its structures -> crate::embed -> a status, last_error
//! ```

// The contract of every call is one, and stands in the header.
#![allow(clippy::missing_safety_doc)]

mod composite;
mod context;
mod effect;
mod frame;
mod handles;
mod image;
mod memory;
mod mesh;
mod params;
mod status;
mod types;

pub use composite::*;
pub use context::*;
pub use effect::*;
pub use frame::*;
pub use handles::{ImpastoComposite, ImpastoContext, ImpastoEffect, ImpastoMesh, ImpastoPaint};
pub use image::ImpastoImage;
pub use mesh::*;
pub use params::*;
pub use status::{impasto_last_error, impasto_status_text, impasto_version};
pub use types::*;
