//! Bodies of the functions that read from the object of a handle, or free it.

use std::any::Any;

use super::boundary::{MlgError, MlgStatus, Outcome, guard, guard_or};
use super::buffers::{self, Versioned};
use super::handles;

/// Lends a list of an object; NULL and a count of 0 for a handle that is not valid.
pub(super) fn lend<T: Any + Send + Sync, H, E, C>(
    handle: *const H,
    out_count: *mut usize,
    list: impl FnOnce(&T) -> &[E],
) -> *const C {
    lend_some(handle, out_count, |object| Some(list(object)))
}

/// The same where an object may not have such a list.
pub(super) fn lend_some<T: Any + Send + Sync, H, E, C>(
    handle: *const H,
    out_count: *mut usize,
    list: impl FnOnce(&T) -> Option<&[E]>,
) -> *const C {
    // SAFETY: NULL or a writable count, as every function's documentation asks.
    if let Some(count) = unsafe { out_count.as_mut() } {
        *count = 0;
    }
    guard_or(std::ptr::null(), || {
        let object = handles::get::<T, _>(handle, "handle")?;
        // SAFETY: as above; the list lives in the table.
        let lent = |list: &[E]| unsafe { buffers::lend(list, out_count) };
        Ok(list(&object).map_or(std::ptr::null(), lent))
    })
}

/// Reads a value of an object; `otherwise` for a handle that is not valid.
pub(super) fn read_or<T: Any + Send + Sync, H, V>(
    otherwise: V,
    handle: *const H,
    value: impl FnOnce(&T) -> V,
) -> V {
    guard_or(otherwise, || Ok(value(&*handles::get::<T, _>(handle, "handle")?)))
}

/// Fills a struct of the caller from an object. Both pointers come with their names.
pub(super) fn fill<T: Any + Send + Sync, H, S: Versioned>(
    (handle, name): (*const H, &str),
    (out, out_name): (*mut S, &str),
    error: *mut MlgError,
    value: impl FnOnce(&T) -> Outcome<S>,
) -> MlgStatus {
    guard(error, || {
        let object = handles::get::<T, _>(handle, name)?;
        // SAFETY: NULL or a struct that begins with its size, as every function's documentation asks.
        unsafe { buffers::fill(out, value(&object)?, out_name) }
    })
}

/// Frees an object; nothing happens for NULL and for handles that are not of this type.
pub(super) fn free<T: Any + Send + Sync, H>(handle: *mut H) {
    guard_or((), || {
        handles::free::<T, _>(handle);
        Ok(())
    });
}

/// Makes an object and writes its handle. The place for it comes with its name.
pub(super) fn make<T: Any + Send + Sync, H>(
    (out, name): (*mut *mut H, &str),
    error: *mut MlgError,
    object: impl FnOnce() -> Outcome<T>,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out, name)?;
        let handle = handles::give(object()?);
        // SAFETY: room for a handle, as every function's documentation asks.
        unsafe { buffers::write(out, handle, name) }
    })
}

/// Does something with an object, whose handle comes with its name.
pub(super) fn with<T: Any + Send + Sync, H>(
    (handle, name): (*const H, &str),
    error: *mut MlgError,
    body: impl FnOnce(&T) -> Outcome<()>,
) -> MlgStatus {
    guard(error, || body(&*handles::get::<T, _>(handle, name)?))
}
