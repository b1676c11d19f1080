//! What a host holds: numbers that look like pointers, and the table of what they stand for.
//!
//! A number is never given twice and never followed as an address. So a null, a handle of another kind, one that was
//! destroyed and plain garbage are all told from a live one, and no use of a handle touches memory that is not there.

use super::status::{Failure, Result};
use super::types::ImpastoStatus;
use crate::embed::{Composite, Effect, EffectPaint};
use crate::gpu::{lock, Context, Image};
use crate::scene::Mesh;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// A device to paint on, borrowed from the host.
pub struct ImpastoContext(());
/// A model.
pub struct ImpastoMesh(());
/// A strip of paint, taken apart into colours and texture.
pub struct ImpastoPaint(());
/// A mesh that is painted by one technique, picture after picture.
pub struct ImpastoEffect(());
/// A pass that lays the picture of an effect over the host's own.
pub struct ImpastoComposite(());

/// What an effect needs at each call.
pub(super) struct EffectObject {
    pub effect: Effect,
    pub context: Context,
    pub mesh: Arc<Mesh>,
    /// The host's images, if it has any.
    pub guides: Option<[Image; 3]>,
    pub vectors: Option<Image>,
}

/// What a composite needs at each call.
pub(super) struct CompositeObject {
    pub composite: Composite,
    pub targets: Vec<crate::embed::Target>,
    pub context: Context,
    /// The handle of the effect that it was made for.
    pub of_effect: usize,
}

pub(super) enum Object {
    Context(Context),
    Mesh(Arc<Mesh>),
    Paint(Arc<EffectPaint>),
    Effect(Arc<Mutex<EffectObject>>),
    Composite(Arc<Mutex<CompositeObject>>),
}

/// The one thing that is global: which handles are live, and what they stand for.
static TABLE: Mutex<Table> = Mutex::new(Table { last: 0, live: BTreeMap::new() });

struct Table {
    last: usize,
    live: BTreeMap<usize, Entry>,
}

struct Entry {
    object: Object,
    /// The handle of the context that it stands on; 0 for none.
    of_context: usize,
}

/// A kind of handle.
pub(super) trait Handle: Sized {
    type Object: Clone;
    const NAME: &'static str;
    fn wrap(object: Self::Object) -> Object;
    fn of(object: &Object) -> Option<&Self::Object>;
}

macro_rules! handle {
    ($($kind:ident, $name:literal, $variant:ident($object:ty);)*) => {$(
        impl Handle for $kind {
            type Object = $object;
            const NAME: &'static str = $name;
            fn wrap(object: $object) -> Object {
                Object::$variant(object)
            }
            fn of(object: &Object) -> Option<&$object> {
                match object {
                    Object::$variant(object) => Some(object),
                    _ => None,
                }
            }
        }
    )*};
}
handle! {
    ImpastoContext, "context", Context(Context);
    ImpastoMesh, "mesh", Mesh(Arc<Mesh>);
    ImpastoPaint, "paint", Paint(Arc<EffectPaint>);
    ImpastoEffect, "effect", Effect(Arc<Mutex<EffectObject>>);
    ImpastoComposite, "composite", Composite(Arc<Mutex<CompositeObject>>);
}

/// Gives out a handle for something that stands on no context.
pub(super) fn give<H: Handle>(object: H::Object) -> *mut H {
    give_on(0, object)
}

/// Gives out a handle for something that stands on the context with this handle.
pub(super) fn give_on<H: Handle>(of_context: usize, object: H::Object) -> *mut H {
    let mut table = lock(&TABLE);
    table.last += 1;
    let number = table.last;
    table.live.insert(number, Entry { object: H::wrap(object), of_context });
    std::ptr::without_provenance_mut(number)
}

/// What a handle stands for.
pub(super) fn get<H: Handle>(handle: *const H) -> Result<H::Object> {
    super::memory::not_null(H::NAME, handle)?;
    get_number::<H>(handle.addr())
}

/// As [`get`], of a handle that was kept as a number.
pub(super) fn get_number<H: Handle>(number: usize) -> Result<H::Object> {
    let table = lock(&TABLE);
    table.live.get(&number).and_then(|entry| H::of(&entry.object)).cloned().ok_or_else(|| unknown::<H>())
}

/// The handle of the context that something stands on; 0 for none.
pub(super) fn context_of<H: Handle>(handle: *const H) -> usize {
    lock(&TABLE).live.get(&handle.addr()).map_or(0, |entry| entry.of_context)
}

fn unknown<H: Handle>() -> Failure {
    let text = format!("the {} is none: it was destroyed, or is no handle of this kind", H::NAME);
    Failure::new(ImpastoStatus::Handle, text)
}

/// Takes a handle back; null is none, and fine. What it stood for is dropped when nobody else uses it any more, but a
/// handle on which others stand is left as it is.
pub(super) fn take<H: Handle>(handle: *mut H) -> Result<()> {
    if handle.is_null() {
        return Ok(());
    }
    let number = handle.addr();
    let mut table = lock(&TABLE);
    if table.live.get(&number).and_then(|entry| H::of(&entry.object)).is_none() {
        return Err(unknown::<H>());
    }
    let count = table.live.values().filter(|entry| entry.of_context == number).count();
    if count > 0 {
        let text = format!("of the effects and composites of the {} {count} are not destroyed yet", H::NAME);
        return Err(Failure::new(ImpastoStatus::InUse, text));
    }
    let entry = table.live.remove(&number);
    // An effect waits for its thread when it is dropped, which must not keep others from the table.
    drop(table);
    drop(entry);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MeshOptions;

    fn mesh() -> Arc<Mesh> {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        Arc::new(Mesh::parse(text.as_bytes(), "one.obj", &MeshOptions::default()).expect("a mesh").mesh)
    }

    fn status<T>(result: Result<T>) -> ImpastoStatus {
        result.err().map_or(ImpastoStatus::Ok, |failure| failure.status)
    }

    #[test]
    fn only_live_handles_of_the_right_kind_are_known() {
        let held = mesh();
        let handle = give::<ImpastoMesh>(held.clone());
        assert!(Arc::ptr_eq(&get(handle.cast_const()).expect("live"), &held));
        assert_eq!(status(get(handle.cast::<ImpastoPaint>().cast_const())), ImpastoStatus::Handle);
        assert_eq!(status(take(handle.cast::<ImpastoPaint>())), ImpastoStatus::Handle);
        assert_eq!(status(get(std::ptr::null::<ImpastoMesh>())), ImpastoStatus::NullPointer);
        assert_eq!(status(get(std::ptr::from_ref(&held).cast::<ImpastoMesh>())), ImpastoStatus::Handle);
        assert_eq!(status(take(handle)), ImpastoStatus::Ok);
        assert_eq!(Arc::strong_count(&held), 1);
        assert_eq!(status(take(handle)), ImpastoStatus::Handle);
        assert_eq!(status(take(std::ptr::null_mut::<ImpastoMesh>())), ImpastoStatus::Ok);
        assert!(give::<ImpastoMesh>(held) != handle);
    }
}
