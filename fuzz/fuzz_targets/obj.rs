#![no_main]
//! Reading obj from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Ok(document) = moulage::io::ObjDocument::parse(data.to_vec(), Path::new("a.obj")) else { return };
    // What can be read can be written back, and its text survives.
    let same = document.text_with_points(document.points());
    assert_eq!(same.expect("the points are the file's own"), data);
    let moved: Vec<_> = document.points().iter().map(|p| p * 0.5).collect();
    if let Ok(text) = document.text_with_points(&moved) {
        let again = moulage::io::ObjDocument::parse(text, Path::new("a.obj"));
        assert_eq!(again.expect("what is written can be read").points(), moved);
    }
});
