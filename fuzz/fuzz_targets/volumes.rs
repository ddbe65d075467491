#![no_main]
//! Reading images from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    // The first byte chooses the format.
    let Some((&kind, rest)) = data.split_first() else { return };
    let path = Path::new("a");
    let volume = match kind % 4 {
        0 => moulage::io::parse_nifti(rest, path),
        1 => moulage::io::parse_nrrd(rest, path),
        2 => moulage::io::parse_meta_image(rest, path),
        _ => moulage::io::parse_dicom(&[(rest.to_vec(), path.into())], path).map(|(v, _)| v),
    };
    if let Ok(volume) = volume {
        assert!(volume.values().iter().all(|v| v.is_finite()));
        assert!(volume.corners().iter().flat_map(|c| c.iter()).all(|c| !c.is_nan()));
    }
});
