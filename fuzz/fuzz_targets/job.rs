#![no_main]
//! Reading job from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = moulage::job::ReshapeJob::parse(text, Path::new("job.toml"));
    }
});
