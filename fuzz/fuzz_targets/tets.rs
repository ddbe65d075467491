#![no_main]
//! Reading tets from any bytes.

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    // The first byte chooses the format; TetGen's two files are split at the first zero byte.
    let Some((&kind, rest)) = data.split_first() else { return };
    let path = Path::new("a");
    let _ = match kind % 4 {
        0 => moulage::io::parse_vtu(rest, path),
        1 => moulage::io::parse_gmsh(rest, path),
        2 => moulage::io::parse_veg(rest, path),
        _ => {
            let cut = rest.iter().position(|&b| b == 0).unwrap_or(rest.len());
            let (nodes, elements) = rest.split_at(cut);
            moulage::io::parse_tetgen(nodes, path, elements.get(1..).unwrap_or_default(), path)
        }
    };
});
