//! The C ABI: [`crate::embed`] for hosts that are not written in Rust. On with the feature `capi`.
//!
//! `include/impasto.h` is generated from these files (`make header`) and is its documentation: the contract of all calls
//! stands at its top. What is `unsafe` here is what a C caller promises there, and nothing else: handles are numbers
//! that are looked up, sizes are checked before they are believed, and no panic leaves a call.
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
pub use types::*;

use std::ffi::{c_char, CStr};

/// The version of the library, as IMPASTO_VERSION.
#[no_mangle]
pub extern "C" fn impasto_version() -> u32 {
    IMPASTO_VERSION
}

/// A few words on a status, which stay for ever.
#[no_mangle]
pub extern "C" fn impasto_status_text(status: u32) -> *const c_char {
    const WORDS: [&CStr; 14] = [
        c"done",
        c"a pointer or handle that is needed is null",
        c"a handle is of another kind, was destroyed, or never was one",
        c"a struct_size is none, or the structure is of a newer version",
        c"a value is out of its range",
        c"what a file holds is not usable",
        c"a file could not be read",
        c"not prepared yet",
        c"something still stands on it",
        c"the device lacks something",
        c"the device is lost",
        c"not enough memory",
        c"a Vulkan call failed",
        c"a fault in impasto was caught",
    ];
    WORDS.get(status as usize).copied().unwrap_or(c"an unknown status").as_ptr()
}

/// What went wrong in the last call of this thread that failed, with the details; "" if none has. It stays until the
/// next one fails.
#[no_mangle]
pub extern "C" fn impasto_last_error() -> *const c_char {
    status::last_error()
}
