#![no_main]
//! Reading markers from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    // The first byte chooses the format.
    let Some((&kind, rest)) = data.split_first() else { return };
    let names = ["a.csv", "a.xyz", "a.mrk.json", "a.fcsv", "a.pp", "a.ply"];
    let path = Path::new(names[kind as usize % names.len()]);
    for marker in moulage::io::parse_markers(rest, path).unwrap_or_default() {
        assert!(marker.position.iter().all(|c| c.is_finite()));
    }
});
