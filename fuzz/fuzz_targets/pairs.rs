#![no_main]
//! Reading pairs from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = Path::new("a.csv");
    let _ = moulage::io::parse_landmarks(data, path);
    let _ = moulage::io::parse_attachments(data, path);
    let _ = moulage::io::parse_fixed(data, path);
});
