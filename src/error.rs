//! The one error type of the crate.
//!
//! Every variant carries what a person needs to act: the file, the name of the parameter, its value and its limits,
//! or the Vulkan call that failed. The library never prints and never panics on bad input; it returns one of these.

use std::path::PathBuf;

/// What can go wrong, with the facts a person needs to put it right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file was read, but what it holds is not usable.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file, or the name that the caller gave to bytes in memory.
        path: PathBuf,
        /// What is wrong with its content.
        reason: String,
    },
    /// A parameter lies outside of its range.
    #[error("{name} is {value}, but must be {allowed}")]
    Parameter {
        /// The parameter's name, as in the API.
        name: &'static str,
        /// The value that was given.
        value: String,
        /// The allowed range or form, in words that follow "must be".
        allowed: String,
    },
    /// No device, or the device lacks something that is needed.
    #[error("{0}")]
    Device(String),
    /// Something was asked of what is not prepared yet, or has recorded nothing yet.
    #[error("{0}")]
    NotReady(&'static str),
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Vulkan {
        /// The Vulkan function.
        call: &'static str,
        /// Its result code.
        result: ash::vk::Result,
    },
    /// The device is lost: it crashed, hung or was taken away, and what was on it is gone. All that can be done is to
    /// drop everything that was made with the context, and to begin again with a new device.
    #[error("the GPU is lost (it crashed, hung or was removed), and all that was on it with it")]
    DeviceLost,
    /// More GPU memory is needed than the context may use.
    #[error("{what} needs {needed} bytes of GPU memory, but {available} are left of the context's budget")]
    Memory {
        /// What the memory was for.
        what: String,
        /// Bytes asked for.
        needed: u64,
        /// Bytes left in the budget.
        available: u64,
    },
}

/// `Result` with the crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// A parameter outside of its range; `allowed` completes the sentence "must be ...".
    pub fn parameter(name: &'static str, value: impl ToString, allowed: impl Into<String>) -> Self {
        Error::Parameter { name, value: value.to_string(), allowed: allowed.into() }
    }

    /// A file whose content is not usable.
    pub fn file(path: impl Into<PathBuf>, reason: impl ToString) -> Self {
        Error::File { path: path.into(), reason: reason.to_string() }
    }

    /// A file that could not be opened, read or written.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Error::Io { path: path.into(), source }
    }
}
