//! Handles are tickets: the pointer a C caller holds is a number in a table, never an address.
//!
//! So a handle that was freed, was never given out, or is of another type is refused instead of
//! crashing the host, freeing twice does nothing, and freeing while another thread uses the object
//! is safe: the object lives until that call ends. Numbers are not used again.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use super::boundary::{Failure, Outcome};

/// What a handle can stand for.
pub(super) type Object = Arc<dyn Any + Send + Sync>;

struct Table {
    next: usize,
    objects: HashMap<usize, Object>,
}

/// Tickets look like aligned addresses, so that tools that check pointers stay calm; the first page
/// is left out because it is where NULL mistakes point.
const FIRST: usize = 0x1_0000;
const STEP: usize = 16;

static TABLE: LazyLock<Mutex<Table>> =
    LazyLock::new(|| Mutex::new(Table { next: FIRST, objects: HashMap::new() }));

fn table() -> MutexGuard<'static, Table> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives out a ticket for an object, as a pointer to the opaque C type `H`.
pub(super) fn give<H>(object: impl Any + Send + Sync) -> *mut H {
    let mut table = table();
    let ticket = table.next;
    table.next += STEP;
    table.objects.insert(ticket, Arc::new(object));
    std::ptr::without_provenance_mut(ticket)
}

/// The object of a ticket.
pub(super) fn get<T: Any + Send + Sync, H>(handle: *const H, name: &str) -> Outcome<Arc<T>> {
    if handle.is_null() {
        return Err(Failure::null(name));
    }
    let object = table().objects.get(&handle.addr()).cloned();
    object.and_then(|o| o.downcast::<T>().ok()).ok_or_else(|| {
        Failure::invalid(format!("{name} is not a valid handle: freed already, or of another type"))
    })
}

/// Takes a ticket back; nothing happens for NULL and for tickets that are not of this type.
pub(super) fn free<T: Any + Send + Sync, H>(handle: *mut H) -> Option<Arc<T>> {
    let mut table = table();
    let is_ours = table.objects.get(&handle.addr()).is_some_and(|o| (**o).is::<T>());
    let object = is_ours.then(|| table.objects.remove(&handle.addr())).flatten();
    // The object may take long to drop; others must not wait for that.
    drop(table);
    object.and_then(|o| o.downcast::<T>().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Opaque;

    #[test]
    fn stale_foreign_and_wrong_handles_are_refused() {
        let handle: *mut Opaque = give(5_u32);
        assert_eq!(*get::<u32, _>(handle, "n").unwrap(), 5);
        assert!(get::<String, _>(handle, "n").is_err());
        assert!(free::<String, _>(handle).is_none());
        let used = get::<u32, _>(handle, "n").unwrap();
        assert!(free::<u32, _>(handle).is_some());
        assert!(free::<u32, _>(handle).is_none());
        assert!(get::<u32, _>(handle, "n").is_err());
        assert_eq!(*used, 5, "a call under way keeps its object");
        assert!(get::<u32, Opaque>(std::ptr::null(), "n").is_err());
        let other: *mut Opaque = give(6_u32);
        assert_ne!(handle, other);
        free::<u32, _>(other);
    }
}
