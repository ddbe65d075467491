#![no_main]
//! Reading skeletons, and what comes with them, from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use moulage::io;

fuzz_target!(|data: &[u8]| {
    // The first byte chooses the format.
    let Some((&kind, rest)) = data.split_first() else { return };
    let path = Path::new("a");
    let text = std::str::from_utf8(rest).unwrap_or_default();
    match kind % 7 {
        0 => {
            if let Ok(document) = io::skeleton::SkeletonDocument::parse(text, path)
                && let Ok(written) = document.to_text()
            {
                let again = io::skeleton::SkeletonDocument::parse(&written, path);
                assert!(again.is_ok(), "what is written can be read: {again:?}");
            }
        }
        1 => drop(io::osim::model::OsimModel::parse(text, path)),
        2 => drop(io::mot::parse_motion(rest, path)),
        3 => drop(io::vtp::parse_vtp(text, path)),
        4 => drop(io::parse_profiles(rest, path)),
        5 => {
            if let Ok(motion) = io::bvh::parse_bvh(rest, path) {
                let again = io::bvh::parse_bvh(io::bvh::bvh_text(&motion).as_bytes(), path);
                assert!(again.is_ok(), "what is written can be read: {again:?}");
            }
        }
        _ => drop(io::h5_json::H5Document::parse(text, path)),
    }
});
