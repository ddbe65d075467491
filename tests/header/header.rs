//! `include/moulage.h` is what cbindgen makes of `src/capi` now.

#![cfg(test)]
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_header_is_up_to_date() {
    let root = root();
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let mut made = Vec::new();
    let mut builder = cbindgen::Builder::new().with_config(config);
    // Source order of the modules is the order of the manual.
    for file in [
        "version",
        "boundary",
        "mesh",
        "distances",
        "markers",
        "run",
        "tetrahedralization",
        "reshaping",
        "pairs",
        "placing",
        "reshaping_run",
        "result",
        "separation",
        "separation_result",
        "volume",
        "volume_labels",
        "skeleton",
        "skeleton_parts",
        "skeleton_files",
        "motion",
        "shape_model",
        "registration",
        "registration_result",
    ] {
        builder = builder.with_src(root.join(format!("src/capi/{file}.rs")));
    }
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let header = root.join("include/moulage.h");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&header, &made).unwrap();
    }
    let committed = std::fs::read_to_string(&header).unwrap_or_default();
    assert!(
        committed == made,
        "include/moulage.h is not what src/capi makes now; run UPDATE=1 cargo test -p moulage-header and look at the change"
    );
}

#[test]
fn every_function_of_the_header_is_exported_and_no_other() {
    let root = root();
    let header = std::fs::read_to_string(root.join("include/moulage.h")).unwrap();
    let mut declared: Vec<&str> = header
        .split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .filter(|word| word.starts_with("mlg_"))
        .filter(|word| header.contains(&format!("{word}(")))
        .collect();
    declared.sort_unstable();
    declared.dedup();
    let mut defined = Vec::new();
    for entry in std::fs::read_dir(root.join("src/capi")).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        for part in text.split("extern \"C\" fn ").skip(1) {
            defined.push(part.split('(').next().unwrap().to_owned());
        }
    }
    defined.sort_unstable();
    assert_eq!(declared, defined);
}
