//! Reading and writing what a caller's pointers point to: structures of any version, arrays, strings.

use super::status::{Failure, Result};
use super::types::ImpastoStatus;
use std::ffi::{c_char, CStr};
use std::mem::{size_of, MaybeUninit};
use std::path::PathBuf;

/// The largest structure that is believed in: garbage in the place of a size must not have us read far.
const MOST_BYTES: usize = 4096;

/// A structure that begins with its own size and may grow with the versions of the header.
///
/// # Safety
/// It is `repr(C)`, its first field is a `u32`, and any bytes, also zeros alone, are a valid value of it.
pub(super) unsafe trait Versioned: Copy {
    const NAME: &'static str;
    /// Its size in the first version.
    const FIRST_BYTES: usize;
}

/// `versioned!(Type)`, and once fields were added `versioned!(Type, since first_of_them)`.
macro_rules! versioned {
    ($kind:ident) => {
        versioned!($kind: std::mem::size_of::<$kind>());
    };
    ($kind:ident, since $added:ident) => {
        versioned!($kind: std::mem::offset_of!($kind, $added));
    };
    ($kind:ident: $bytes:expr) => {
        // SAFETY: numbers, pointers, arrays of these, and functions that may be null; the size comes first.
        unsafe impl $crate::capi::memory::Versioned for $kind {
            const NAME: &'static str = stringify!($kind);
            const FIRST_BYTES: usize = $bytes;
        }
        const _: () = assert!(std::mem::offset_of!($kind, struct_size) == 0);
    };
}
pub(super) use versioned;

/// The size that the caller's structure has, after a look at whether it can be.
///
/// # Safety
/// As [`read`].
unsafe fn size<T: Versioned>(pointer: *const T) -> Result<usize> {
    not_null(T::NAME, pointer)?;
    // SAFETY: the size comes first, and the caller promises that it is there.
    let bytes = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    if !(T::FIRST_BYTES..=MOST_BYTES).contains(&bytes) {
        let text = format!("the struct_size of {} is {bytes}, but must be sizeof({0})", T::NAME);
        return Err(Failure::new(ImpastoStatus::StructSize, text));
    }
    Ok(bytes)
}

/// A caller's structure. What an older header does not have is zero; what a newer one has besides must be.
///
/// # Safety
/// `from` is null, or points to `struct_size` readable bytes.
pub(super) unsafe fn read<T: Versioned>(from: *const T) -> Result<T> {
    // SAFETY: the caller promises it.
    let bytes = unsafe { size(from) }?;
    let common = bytes.min(size_of::<T>());
    // SAFETY: the caller promises `bytes` bytes, of which these are those that we do not know.
    let unknown = unsafe { std::slice::from_raw_parts(from.cast::<u8>().add(common), bytes - common) };
    if unknown.iter().any(|byte| *byte != 0) {
        let text = format!("{} is from a newer header, and uses what this version of impasto does not know", T::NAME);
        return Err(Failure::new(ImpastoStatus::StructSize, text));
    }
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: both sides have `common` bytes; they are apart, and any bytes are a value.
    unsafe {
        value.as_mut_ptr().cast::<u8>().copy_from_nonoverlapping(from.cast::<u8>(), common);
        Ok(value.assume_init())
    }
}

/// As [`read`], with null for nothing.
///
/// # Safety
/// As [`read`].
pub(super) unsafe fn read_if<T: Versioned>(from: *const T) -> Result<Option<T>> {
    match from.is_null() {
        true => Ok(None),
        // SAFETY: the caller promises it.
        false => unsafe { read(from) }.map(Some),
    }
}

/// Fills in a caller's structure, as far as its header knows it; its size stays, and what we do not know becomes zero.
///
/// # Safety
/// `to` is null, or points to as many writable bytes as its `struct_size` says.
pub(super) unsafe fn write<T: Versioned>(to: *mut T, value: &T) -> Result<()> {
    // SAFETY: the caller promises it.
    let bytes = unsafe { size(to) }?;
    let common = bytes.min(size_of::<T>());
    let begin = size_of::<u32>();
    // SAFETY: both sides have `common` bytes and are apart; the rest is the caller's too.
    unsafe {
        let to = to.cast::<u8>();
        to.add(begin).copy_from_nonoverlapping(std::ptr::from_ref(value).cast::<u8>().add(begin), common - begin);
        to.add(common).write_bytes(0, bytes - common);
    }
    Ok(())
}

/// Checks that a pointer to `name` is given.
pub(super) fn not_null<T>(name: &str, pointer: *const T) -> Result<()> {
    match pointer.is_null() {
        true => Err(Failure::new(ImpastoStatus::NullPointer, format!("{name} is null"))),
        false => Ok(()),
    }
}

/// A caller's array of plain numbers, of at most `most` elements; null is fine for none.
///
/// # Safety
/// `from` is null, or points to `count` readable elements that stay as they are for `'a`; any bytes are a value of `T`.
pub(super) unsafe fn slice<'a, T: Copy>(
    name: &'static str,
    from: *const T,
    count: u32,
    most: usize,
) -> Result<&'a [T]> {
    let count = count as usize;
    if count > most {
        return Err(Failure::parameter(name, format!("an array of {count}"), format!("{most} or less")));
    }
    if count == 0 {
        return Ok(&[]);
    }
    not_null(name, from)?;
    if !from.is_aligned() {
        return Err(Failure::parameter(name, "at an odd address", "aligned as its type wants it"));
    }
    // SAFETY: not null, aligned, and the caller promises the elements.
    Ok(unsafe { std::slice::from_raw_parts(from, count) })
}

/// A plain value that may be left out.
///
/// # Safety
/// `from` is null, or points to a readable value; any bytes are one.
pub(super) unsafe fn value_if<T: Copy>(from: *const T) -> Option<T> {
    // SAFETY: the caller promises it.
    (!from.is_null()).then(|| unsafe { from.read_unaligned() })
}

/// A path: on Unix any bytes, elsewhere UTF-8.
///
/// # Safety
/// `from` is null, or points to a string that ends with a zero.
pub(super) unsafe fn path(name: &'static str, from: *const c_char) -> Result<PathBuf> {
    not_null(name, from)?;
    // SAFETY: not null, and the caller promises a string.
    let text = unsafe { CStr::from_ptr(from) };
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        Ok(PathBuf::from(std::ffi::OsStr::from_bytes(text.to_bytes())))
    }
    #[cfg(not(unix))]
    {
        let bad = |_| Failure::parameter(name, text.to_string_lossy(), "UTF-8");
        text.to_str().map(PathBuf::from).map_err(bad)
    }
}

/// Checks that a switch is 0 or 1.
pub(super) fn switch(name: &'static str, value: u32) -> Result<bool> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Failure::parameter(name, value, "0 or 1")),
    }
}

/// Puts words into a caller's array, cut to fit and ended by a zero.
pub(super) fn text<const N: usize>(words: &str) -> [c_char; N] {
    let mut array = [0; N];
    for (to, byte) in array.iter_mut().zip(words.bytes()).take(N - 1) {
        *to = byte as c_char;
    }
    array
}

#[cfg(test)]
mod tests {
    use super::*;

    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Grown {
        struct_size: u32,
        first: f32,
        added: u32,
    }
    versioned!(Grown, since added);

    /// The structure of a header that is newer than the library.
    #[repr(C)]
    #[derive(Clone, Copy)]
    struct Newer {
        known: Grown,
        unknown: [u32; 2],
    }

    fn newer(bytes: u32, unknown: [u32; 2]) -> Newer {
        Newer { known: Grown { struct_size: bytes, first: 0.5, added: 7 }, unknown }
    }

    fn read_back(newer: &Newer) -> std::result::Result<Grown, ImpastoStatus> {
        // SAFETY: the sizes in these tests are at most that of `Newer`, but for those that are refused unread.
        unsafe { read(std::ptr::from_ref(newer).cast::<Grown>()) }.map_err(|failure| failure.status)
    }

    #[test]
    fn an_older_structure_is_read_with_zeros_for_what_it_has_not() {
        let read = read_back(&newer(8, [9; 2])).expect("an older one");
        assert_eq!(read, Grown { struct_size: 8, first: 0.5, added: 0 });
        let read = read_back(&newer(12, [9; 2])).expect("one of ours");
        assert_eq!(read, Grown { struct_size: 12, first: 0.5, added: 7 });
    }

    #[test]
    fn a_newer_structure_is_read_unless_it_uses_what_is_new() {
        assert_eq!(read_back(&newer(20, [0; 2])).expect("a newer one").added, 7);
        assert_eq!(read_back(&newer(20, [0, 1])), Err(ImpastoStatus::StructSize));
        assert_eq!(read_back(&newer(16, [0, 1])).expect("a newer one").added, 7);
    }

    #[test]
    fn what_cannot_be_a_size_is_refused_and_so_is_null() {
        for bytes in [0, 4, 7, 4097, u32::MAX] {
            assert_eq!(read_back(&newer(bytes, [0; 2])), Err(ImpastoStatus::StructSize), "{bytes}");
        }
        // SAFETY: null is looked at.
        let read = unsafe { read::<Grown>(std::ptr::null()) };
        assert_eq!(read.map_err(|failure| failure.status), Err(ImpastoStatus::NullPointer));
    }

    #[test]
    fn no_more_is_written_than_the_caller_has() {
        let value = Grown { struct_size: 0, first: 2.0, added: 3 };
        for (bytes, added, unknown) in [(8, 7, [9; 2]), (12, 3, [9; 2]), (16, 3, [0, 9]), (20, 3, [0; 2])] {
            let mut to = newer(bytes, [9; 2]);
            // SAFETY: `bytes` is no more than it has.
            unsafe { write(std::ptr::from_mut(&mut to).cast::<Grown>(), &value) }.expect("a size that is right");
            assert_eq!(to.known, Grown { struct_size: bytes, first: 2.0, added }, "{bytes}");
            assert_eq!(to.unknown, unknown, "{bytes}");
        }
    }

    #[test]
    fn words_are_cut_to_fit() {
        let bytes = |array: [c_char; 4]| array.map(|c| c as u8);
        assert_eq!(bytes(text::<4>("ab")), *b"ab\0\0");
        assert_eq!(bytes(text::<4>("abcdef")), *b"abc\0");
    }
}
