//! Statuses and errors: what every function does at the border.

use libc::c_char;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::Error;

/// How a call ended. Numbers are never reused.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgStatus {
    /// All went well; outputs are written.
    Ok = 0,
    /// Stopped on request before there was a result.
    Cancelled = 1,
    /// A pointer that must not be NULL is NULL.
    NullArgument = 2,
    /// A value is wrong: the message names it. Also for handles that were freed or are of another
    /// type.
    InvalidArgument = 3,
    /// A valid wish that this version cannot fulfil, or a program that is not installed.
    Unsupported = 4,
    /// A file could not be read or written.
    Io = 5,
    /// A file does not hold what its format asks for.
    Parse = 6,
    /// A linear system has no unique solution.
    Singular = 7,
    /// The solver could not make further progress and there is no result.
    Diverged = 8,
    /// A fault in the library; the message says where. Free all handles and report it.
    Panic = 9,
    /// A program started by the library failed.
    ExternalProgram = 10,
}

/// Bytes of `MlgError.message`, the ending zero included.
pub const MLG_ERROR_MESSAGE_SIZE: usize = 512;

/// What went wrong. Owned by the caller; written by a call only when it fails.
#[repr(C)]
pub struct MlgError {
    /// The status the call returned.
    pub status: MlgStatus,
    /// One sentence for the user: UTF-8, zero-terminated, cut to fit.
    pub message: [c_char; MLG_ERROR_MESSAGE_SIZE],
}

/// The name of a status, e.g. "INVALID_ARGUMENT"; "UNKNOWN" for other numbers. Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_status_name(status: u32) -> *const c_char {
    const NAMES: [&str; 11] = [
        "OK\0",
        "CANCELLED\0",
        "NULL_ARGUMENT\0",
        "INVALID_ARGUMENT\0",
        "UNSUPPORTED\0",
        "IO\0",
        "PARSE\0",
        "SINGULAR\0",
        "DIVERGED\0",
        "PANIC\0",
        "EXTERNAL_PROGRAM\0",
    ];
    name_of(&NAMES, status)
}

/// One of some names that end with a zero.
pub(super) fn name_of(names: &[&'static str], number: u32) -> *const c_char {
    names.get(number as usize).unwrap_or(&"UNKNOWN\0").as_ptr().cast()
}

/// A failed call on its way to the caller.
#[derive(Debug)]
pub(super) struct Failure {
    pub status: MlgStatus,
    pub message: String,
}

pub(super) type Outcome<T> = Result<T, Failure>;

impl Failure {
    pub fn null(name: &str) -> Self {
        Self { status: MlgStatus::NullArgument, message: format!("{name} must not be NULL") }
    }

    pub fn invalid(message: impl Into<String>) -> Self {
        Self { status: MlgStatus::InvalidArgument, message: message.into() }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match error {
            Error::Io { .. } => MlgStatus::Io,
            Error::Parse { .. } => MlgStatus::Parse,
            Error::Unsupported(_) => MlgStatus::Unsupported,
            Error::ExternalProgram { .. } => MlgStatus::ExternalProgram,
            Error::Singular(_) => MlgStatus::Singular,
            Error::Diverged(_) => MlgStatus::Diverged,
            Error::Cancelled => MlgStatus::Cancelled,
            Error::InvalidInput(_) => MlgStatus::InvalidArgument,
        };
        Self { status, message: error.to_string() }
    }
}

/// Runs the body of a function: failures and panics become a status and a message.
pub(super) fn guard(error: *mut MlgError, body: impl FnOnce() -> Outcome<()>) -> MlgStatus {
    let failure = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return MlgStatus::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => panicked(panic.as_ref()),
    };
    // SAFETY: NULL or a writable MlgError, as every function's documentation asks.
    if let Some(error) = unsafe { error.as_mut() } {
        error.status = failure.status;
        write_text(&failure.message, &mut error.message);
    }
    failure.status
}

/// Runs the body of a getter, which has no way to say what went wrong.
pub(super) fn guard_or<T>(otherwise: T, body: impl FnOnce() -> Outcome<T>) -> T {
    catch_unwind(AssertUnwindSafe(body)).ok().and_then(Result::ok).unwrap_or(otherwise)
}

/// A caught panic as a failure.
pub(super) fn panicked(panic: &(dyn Any + Send)) -> Failure {
    let text = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no details");
    Failure { status: MlgStatus::Panic, message: format!("fault in the library: {text}") }
}

/// Copies text into a C array: whole characters only, always zero-terminated. The rest of the
/// array is zeroed.
pub(super) fn write_text(text: &str, into: &mut [c_char]) {
    let room = into.len().saturating_sub(1);
    let end = (0..=text.len().min(room)).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
    into.fill(0);
    for (to, byte) in into.iter_mut().zip(&text.as_bytes()[..end]) {
        // A zero inside would end the text early for the caller.
        *to = if *byte == 0 { b' ' } else { *byte } as c_char;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn empty() -> MlgError {
        MlgError { status: MlgStatus::Ok, message: [0; MLG_ERROR_MESSAGE_SIZE] }
    }

    fn text(error: &MlgError) -> &str {
        // SAFETY: write_text always terminates.
        unsafe { CStr::from_ptr(error.message.as_ptr()) }.to_str().unwrap()
    }

    #[test]
    fn a_panic_becomes_a_status_and_its_text() {
        let mut error = empty();
        let status = guard(&raw mut error, || panic!("forced {}", 7));
        assert_eq!((status, error.status), (MlgStatus::Panic, MlgStatus::Panic));
        assert_eq!(text(&error), "fault in the library: forced 7");
        assert_eq!(guard_or(3, || panic!("forced")), 3);
        assert_eq!(
            guard(std::ptr::null_mut(), || Err(Failure::null("x"))),
            MlgStatus::NullArgument
        );
    }

    #[test]
    fn long_messages_are_cut_between_characters() {
        let mut error = empty();
        // 2 bytes each: 511 bytes would end in the middle of one.
        let long = "\u{e9}".repeat(400);
        guard(&raw mut error, || Err(Failure::invalid(long)));
        assert_eq!(text(&error).chars().count(), 255);
    }

    #[test]
    fn every_status_has_its_name() {
        // SAFETY: the names are static and terminated.
        let name = |s: u32| unsafe { CStr::from_ptr(mlg_status_name(s)) }.to_str().unwrap();
        assert_eq!(name(MlgStatus::Ok as u32), "OK");
        assert_eq!(name(MlgStatus::ExternalProgram as u32), "EXTERNAL_PROGRAM");
        assert_eq!(name(MlgStatus::Parse as u32), "PARSE");
        assert_eq!(name(999), "UNKNOWN");
    }
}
