//! What a call answers: a status, and the words of the last failure of this thread.

use super::types::{ImpastoStatus, IMPASTO_VERSION};
use crate::Error;
use ash::vk;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{c_char, CStr, CString};
use std::panic::{catch_unwind, AssertUnwindSafe};

/// Why a call fails.
#[derive(Debug)]
pub(super) struct Failure {
    pub status: ImpastoStatus,
    pub text: String,
}

pub(super) type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    pub fn new(status: ImpastoStatus, text: impl Into<String>) -> Self {
        Failure { status, text: text.into() }
    }

    /// A parameter outside of its range; `allowed` completes the sentence "must be ...".
    pub fn parameter(name: &'static str, value: impl ToString, allowed: impl Into<String>) -> Self {
        Error::parameter(name, value, allowed).into()
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Io { .. } => ImpastoStatus::Io,
            Error::File { .. } => ImpastoStatus::File,
            Error::Parameter { .. } => ImpastoStatus::Parameter,
            Error::NotReady(_) => ImpastoStatus::NotReady,
            Error::Device(_) => ImpastoStatus::Device,
            Error::DeviceLost => ImpastoStatus::DeviceLost,
            Error::Memory { .. } => ImpastoStatus::OutOfMemory,
            Error::Vulkan { result, .. } => match *result {
                vk::Result::ERROR_DEVICE_LOST => ImpastoStatus::DeviceLost,
                vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
                | vk::Result::ERROR_OUT_OF_HOST_MEMORY
                | vk::Result::ERROR_OUT_OF_POOL_MEMORY
                | vk::Result::ERROR_FRAGMENTED_POOL
                | vk::Result::ERROR_MEMORY_MAP_FAILED => ImpastoStatus::OutOfMemory,
                _ => ImpastoStatus::Vulkan,
            },
        };
        Failure { status, text: error.to_string() }
    }
}

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

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
    LAST_ERROR.with_borrow(|text| text.as_ptr())
}

/// Runs the body of a call: no panic leaves it, and what goes wrong is noted.
pub(super) fn guard(call: impl FnOnce() -> Result<()>) -> ImpastoStatus {
    // What a panic leaves half done is locked and owned by the library, which is valid at every point; the header tells
    // the host to destroy it.
    let result = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|payload| Err(panicked(payload)));
    let Err(failure) = result else { return ImpastoStatus::Ok };
    let text = c_string(&failure.text);
    LAST_ERROR.with_borrow_mut(|last| *last = text);
    failure.status
}

/// Words for C.
pub(super) fn c_string(words: &str) -> CString {
    let bytes: Vec<u8> = words.bytes().filter(|byte| *byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}

fn panicked(payload: Box<dyn Any + Send>) -> Failure {
    let words = match payload.downcast::<String>() {
        Ok(words) => *words,
        Err(payload) => {
            let words = payload.downcast_ref::<&str>().copied().unwrap_or("without words").to_owned();
            // What else it is might panic again when it is dropped.
            std::mem::forget(payload);
            words
        }
    };
    Failure::new(ImpastoStatus::Panic, format!("a panic, which is a fault in impasto: {words}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words() -> String {
        // SAFETY: it points to this thread's text, which nothing changes meanwhile.
        unsafe { CStr::from_ptr(impasto_last_error()) }.to_str().expect("UTF-8").to_owned()
    }

    #[test]
    fn no_panic_leaves_a_call() {
        struct Bomb;
        impl Drop for Bomb {
            fn drop(&mut self) {
                panic!("again");
            }
        }
        assert_eq!(guard(|| panic!("a {}", "fault")), ImpastoStatus::Panic);
        assert!(words().ends_with("impasto: a fault"), "{}", words());
        assert_eq!(guard(|| panic!("plain")), ImpastoStatus::Panic);
        assert!(words().ends_with("impasto: plain"), "{}", words());
        assert_eq!(guard(|| std::panic::panic_any(Bomb)), ImpastoStatus::Panic);
        assert!(words().ends_with("without words"), "{}", words());
    }

    #[test]
    fn the_last_failure_of_a_thread_is_kept_until_its_next() {
        let fail = |text: &'static str| guard(|| Err(Failure::new(ImpastoStatus::Io, text)));
        assert_eq!(words(), "");
        assert_eq!(fail("one\0two"), ImpastoStatus::Io);
        assert_eq!(guard(|| Ok(())), ImpastoStatus::Ok);
        assert_eq!(words(), "onetwo");
        std::thread::spawn(move || {
            assert_eq!(words(), "");
            fail("there");
            assert_eq!(words(), "there");
        })
        .join()
        .expect("a thread");
        assert_eq!(words(), "onetwo");
    }
}
