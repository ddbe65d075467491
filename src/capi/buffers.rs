//! Reading C arrays, strings and structs; writing outputs.

use std::ffi::{CStr, CString};

use libc::c_char;
use nalgebra::Matrix4;
use std::path::PathBuf;

use super::boundary::{Failure, MlgStatus, Outcome};
use crate::error::Shown;
use crate::math::Vec3;

/// Borrows `count` elements for the length of the call.
///
/// # Safety
/// `pointer` is NULL or points to `count` elements.
unsafe fn elements<'a, T>(pointer: *const T, count: usize, name: &str) -> Outcome<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    if !pointer.is_aligned() || count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Failure::invalid(format!(
            "{name}: {count} elements at a misaligned address or more than memory holds"
        )));
    }
    // SAFETY: not NULL, aligned, and the caller promises the count.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Rows of three numbers, all finite.
pub(super) unsafe fn points(pointer: *const f64, count: usize, name: &str) -> Outcome<Vec<Vec3>> {
    // SAFETY: passed on from the caller.
    let rows = unsafe { elements(pointer.cast::<[f64; 3]>(), count, name)? };
    match rows.iter().position(|row| row.iter().any(|c| !c.is_finite())) {
        Some(i) => Err(Failure::invalid(format!(
            "{name}: point {i} has a coordinate that is not a finite number"
        ))),
        None => Ok(rows.iter().map(|row| Vec3::from(*row)).collect()),
    }
}

/// The same, at least one.
pub(super) unsafe fn some_points(
    pointer: *const f64,
    count: usize,
    name: &str,
) -> Outcome<Vec<Vec3>> {
    if count == 0 {
        return Err(Failure::invalid(format!("{name}: none given, at least one is needed")));
    }
    // SAFETY: passed on from the caller.
    unsafe { points(pointer, count, name) }
}

/// Rows of `N` indices.
pub(super) unsafe fn index_rows<const N: usize>(
    pointer: *const u32,
    count: usize,
    name: &str,
) -> Outcome<Vec<[u32; N]>> {
    // SAFETY: passed on from the caller.
    Ok(unsafe { elements(pointer.cast::<[u32; N]>(), count, name)? }.to_vec())
}

/// Handles or other plain values.
pub(super) unsafe fn list<T: Copy>(pointer: *const T, count: usize, name: &str) -> Outcome<Vec<T>> {
    // SAFETY: passed on from the caller.
    Ok(unsafe { elements(pointer, count, name)? }.to_vec())
}

/// Numbers of any kind.
pub(super) unsafe fn numbers(pointer: *const f64, count: usize, name: &str) -> Outcome<Vec<f64>> {
    // SAFETY: passed on from the caller.
    unsafe { list(pointer, count, name) }
}

/// Weights, or 1 throughout for NULL.
pub(super) unsafe fn weights(pointer: *const f64, count: usize) -> Outcome<Vec<f64>> {
    if pointer.is_null() {
        return Ok(vec![1.0; count]);
    }
    // SAFETY: passed on from the caller.
    unsafe { sizes(pointer, count, "weights") }
}

/// Finite numbers of 0 or more.
pub(super) unsafe fn sizes(pointer: *const f64, count: usize, name: &str) -> Outcome<Vec<f64>> {
    // SAFETY: passed on from the caller.
    let sizes = unsafe { elements(pointer, count, name)? };
    match sizes.iter().position(|size| !(size.is_finite() && *size >= 0.0)) {
        Some(i) => Err(Failure::invalid(format!(
            "{name}: number {i} is {}; {name} are 0 or more",
            sizes[i]
        ))),
        None => Ok(sizes.to_vec()),
    }
}

/// Texts in UTF-8, each of which may be NULL; NULL for the list: none has one.
pub(super) unsafe fn texts(
    pointer: *const *const c_char,
    count: usize,
    name: &str,
) -> Outcome<Vec<Option<String>>> {
    if pointer.is_null() {
        return Ok(vec![None; count]);
    }
    // SAFETY: passed on from the caller.
    let pointers = unsafe { elements(pointer, count, name)? };
    // SAFETY: as above.
    let text = |p: &*const c_char| unsafe { text(*p, name) };
    pointers.iter().map(|p| if p.is_null() { Ok(None) } else { text(p).map(Some) }).collect()
}

/// A text in UTF-8.
pub(super) unsafe fn text(pointer: *const c_char, name: &str) -> Outcome<String> {
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    // SAFETY: not NULL, and the caller promises a terminated string.
    let text = unsafe { CStr::from_ptr(pointer) }.to_str();
    text.map(str::to_owned).map_err(|_| Failure::invalid(format!("{name} is not UTF-8")))
}

/// A path given as UTF-8.
pub(super) unsafe fn path(pointer: *const c_char, name: &str) -> Outcome<PathBuf> {
    // SAFETY: passed on from the caller.
    unsafe { text(pointer, name) }.map(PathBuf::from)
}

/// The same for a file that is to be written: in a folder that exists, so that a typing error makes no folders.
pub(super) unsafe fn new_path(pointer: *const c_char, name: &str) -> Outcome<PathBuf> {
    // SAFETY: passed on from the caller.
    let path = unsafe { path(pointer, name)? };
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => Err(Failure {
            status: MlgStatus::Io,
            message: format!(
                "{}: there is no folder {}; make it first",
                path.shown(),
                folder.shown()
            ),
        }),
        _ => Ok(path),
    }
}

/// Writes an output; `name` must not be NULL.
pub(super) unsafe fn write<T>(out: *mut T, value: T, name: &str) -> Outcome<()> {
    check_out(out, name)?;
    // SAFETY: not NULL, and the caller promises room for one value.
    unsafe { out.write(value) };
    Ok(())
}

/// Refuses a NULL output before any work is done.
pub(super) fn check_out<T>(out: *const T, name: &str) -> Outcome<()> {
    if out.is_null() { Err(Failure::null(name)) } else { Ok(()) }
}

/// Borrows a list to the caller: first element and count; NULL for an empty list.
pub(super) unsafe fn lend<T, C>(list: &[T], out_count: *mut usize) -> *const C {
    if !out_count.is_null() {
        // SAFETY: not NULL, and the caller promises room for one count.
        unsafe { out_count.write(list.len()) };
    }
    if list.is_empty() { std::ptr::null() } else { list.as_ptr().cast() }
}

/// The element with a number from the caller.
pub(super) fn entry<'a, T>(list: &'a [T], index: usize, what: &str) -> Outcome<&'a T> {
    list.get(index).ok_or_else(|| {
        Failure::invalid(format!(
            "{what} {index} does not exist: there are {} (numbered from 0)",
            list.len()
        ))
    })
}

/// A text for C callers, who cannot have zeros in it.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// A matrix row by row, as C has it.
pub(super) fn rows_of(matrix: &Matrix4<f64>) -> [f64; 16] {
    std::array::from_fn(|k| matrix[(k / 4, k % 4)])
}

/// A switch: 0 or 1.
pub(super) fn switch(value: u32, name: &str) -> Outcome<bool> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(Failure::invalid(format!("{name} is {other}; 0 and 1 are known"))),
    }
}

/// Copies numbers to the caller, who promises room for all of them and a pointer that is not NULL.
pub(super) unsafe fn copy_out<T: Copy>(values: &[T], out: *mut T) {
    // SAFETY: passed on from the caller.
    unsafe { std::ptr::copy(values.as_ptr(), out, values.len()) };
}

/// Copies points into a buffer of the caller if it has room for all of them.
pub(super) unsafe fn copy_points(
    points: &[Vec3],
    buffer: *mut f64,
    capacity: usize,
) -> Outcome<()> {
    if points.is_empty() || points.len() > capacity {
        return Ok(());
    }
    check_out(buffer, "buffer")?;
    // SAFETY: not NULL, and the caller promises room for 3 numbers per point.
    unsafe { std::ptr::copy(points.as_ptr().cast::<f64>(), buffer, 3 * points.len()) };
    Ok(())
}

/// Writes text into a buffer of the caller, cut to `capacity` bytes, and its whole length.
pub(super) unsafe fn write_text(
    text: &str,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
) -> Outcome<()> {
    if capacity > 0 {
        check_out(buffer, "buffer")?;
        // SAFETY: not NULL, and the caller promises `capacity` bytes; bytes can be overwritten
        // whatever they hold.
        super::boundary::write_text(text, unsafe {
            std::slice::from_raw_parts_mut(buffer, capacity.min(text.len() + 1))
        });
    }
    if !out_length.is_null() {
        // SAFETY: not NULL, and the caller promises room for one count.
        unsafe { out_length.write(text.len()) };
    }
    Ok(())
}

/// A plain struct whose first field is `size_t struct_size`, made of 8-byte units only.
///
/// # Safety
/// `repr(C)`, every bit pattern valid, the first field a `usize`.
pub(super) unsafe trait Versioned: Copy {}

/// The caller's options over `defaults`: only as many bytes as the caller's struct has, so that
/// programs built against an older, shorter struct keep working. NULL: the defaults.
pub(super) unsafe fn options<T: Versioned>(given: *const T, defaults: T) -> Outcome<T> {
    let mut options = defaults;
    if given.is_null() {
        return Ok(options);
    }
    // SAFETY: the caller promises a struct that begins with its size.
    let size = unsafe { given.cast::<usize>().read() };
    check_size::<T>(size)?;
    // SAFETY: both structs have `size` bytes, and any bytes make a valid T.
    unsafe { copy_prefix(given, &raw mut options, size) };
    Ok(options)
}

/// Writes as much of `value` as the caller's struct of `size` bytes has, its size first.
pub(super) unsafe fn write_versioned<T: Versioned>(
    out: *mut T,
    size: usize,
    value: T,
    name: &str,
) -> Outcome<()> {
    check_out(out, name)?;
    check_size::<T>(size)?;
    // SAFETY: the caller promises `size` bytes, T has at least as many.
    unsafe {
        copy_prefix(&raw const value, out, size);
        out.cast::<usize>().write(size);
    }
    Ok(())
}

/// Like [`write_versioned`], the size taken from the struct itself.
pub(super) unsafe fn fill<T: Versioned>(out: *mut T, value: T, name: &str) -> Outcome<()> {
    check_out(out, name)?;
    // SAFETY: not NULL, and the caller promises a struct that begins with its size.
    let size = unsafe { out.cast::<usize>().read() };
    // SAFETY: passed on from the caller.
    unsafe { write_versioned(out, size, value, name) }
}

/// A list of the caller's structs over `defaults`, all of the size that the first one says.
pub(super) unsafe fn structs<T: Versioned>(
    pointer: *const T,
    count: usize,
    defaults: T,
    name: &str,
) -> Outcome<Vec<T>> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    // SAFETY: the caller promises structs that begin with their size.
    let size = unsafe { pointer.cast::<usize>().read() };
    check_size::<T>(size)?;
    if count > isize::MAX as usize / size {
        return Err(Failure::invalid(format!("{name}: {count} elements do not fit in memory")));
    }
    let mut list = Vec::with_capacity(count.min(1024));
    for i in 0..count {
        // SAFETY: the caller promises `count` structs of `size` bytes.
        let element = unsafe { pointer.byte_add(i * size) };
        // SAFETY: as above.
        if unsafe { element.cast::<usize>().read() } != size {
            return Err(Failure::invalid(format!(
                "{name}: element {i} has another struct_size than the first one"
            )));
        }
        // SAFETY: as above.
        list.push(unsafe { options(element, defaults)? });
    }
    Ok(list)
}

unsafe fn copy_prefix<T>(from: *const T, to: *mut T, size: usize) {
    // SAFETY: passed on from the callers.
    unsafe { std::ptr::copy_nonoverlapping(from.cast::<u8>(), to.cast::<u8>(), size) };
}

fn check_size<T>(size: usize) -> Outcome<()> {
    let known = size_of::<T>();
    if size > known {
        return Err(Failure::invalid(format!(
            "struct_size is {size}, but this library knows {known} bytes: the header is newer than the library"
        )));
    }
    if size < size_of::<usize>() || !size.is_multiple_of(8) {
        return Err(Failure::invalid(format!(
            "struct_size is {size}, not a size of any version of this struct; set it with the _init function or sizeof"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Three {
        struct_size: usize,
        a: f64,
        b: f64,
    }
    // SAFETY: repr(C), plain numbers, size first.
    unsafe impl Versioned for Three {}

    const DEFAULTS: Three = Three { struct_size: 24, a: 1.0, b: 2.0 };

    #[test]
    fn older_callers_keep_working_and_newer_ones_are_refused() {
        let read = |size| {
            let given = Three { struct_size: size, a: 7.0, b: 8.0 };
            // SAFETY: a whole struct.
            unsafe { options(&raw const given, DEFAULTS) }
        };
        assert_eq!(read(24).unwrap(), Three { struct_size: 24, a: 7.0, b: 8.0 });
        assert_eq!(read(16).unwrap(), Three { struct_size: 16, a: 7.0, b: 2.0 });
        for wrong in [0, 4, 17, 32, usize::MAX] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        let mut short = Three { struct_size: 16, a: 0.0, b: 9.0 };
        // SAFETY: a whole struct.
        unsafe { fill(&raw mut short, DEFAULTS, "out").unwrap() };
        assert_eq!(short, Three { struct_size: 16, a: 1.0, b: 9.0 });
    }

    #[test]
    fn arrays_are_checked() {
        let numbers = [0.0, 1.0, f64::NAN];
        // SAFETY: one row of three, and pointers that are refused.
        unsafe {
            assert!(points(numbers.as_ptr(), 1, "points").is_err());
            assert!(points(std::ptr::null(), 1, "points").is_err());
            assert!(points(numbers.as_ptr(), usize::MAX, "points").is_err());
            assert!(points(std::ptr::null(), 0, "points").unwrap().is_empty());
            assert_eq!(weights(std::ptr::null(), 2).unwrap(), [1.0, 1.0]);
            assert!(weights([-1.0].as_ptr(), 1).is_err());
            assert!(path(c"\xff".as_ptr(), "path").is_err());
        }
    }
}
