//! Versions.

use libc::c_char;

/// Raised whenever a program built against an older header would break.
pub const MLG_ABI_VERSION: u32 = 1;
/// First number of the library's version.
pub const MLG_VERSION_MAJOR: u32 = 0;
/// Second number of the library's version.
pub const MLG_VERSION_MINOR: u32 = 1;
/// Third number of the library's version.
pub const MLG_VERSION_PATCH: u32 = 0;

/// The library's `MLG_ABI_VERSION`. Compare it with the header's when loading the library at run
/// time, and refuse to go on if they differ.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_abi_version() -> u32 {
    MLG_ABI_VERSION
}

/// The library's version, e.g. "0.1.0". Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_version_string() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_crate() {
        let numbers = format!("{MLG_VERSION_MAJOR}.{MLG_VERSION_MINOR}.{MLG_VERSION_PATCH}");
        assert_eq!(numbers, env!("CARGO_PKG_VERSION"));
    }
}
