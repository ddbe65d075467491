#![no_main]
//! Reading ply from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = moulage::io::parse_surface(data.to_vec(), Path::new("a.ply"));
});
