//! `include/moulage.h` is what cbindgen makes of `src/capi` now: a section for each file, under the first line of its
//! documentation, with the file's constants, structs and functions beside each other; before them all handles.

#![cfg(test)]
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The files in the order of the manual: what a section names was declared before it.
const SECTIONS: [&str; 27] = [
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
    "findings",
    "reshaping_run",
    "result",
    "result_distances",
    "uncertainty",
    "separation",
    "separation_result",
    "volume",
    "volume_voxels",
    "volume_labels",
    "skeleton",
    "skeleton_parts",
    "skeleton_files",
    "motion",
    "shape_model",
    "registration",
    "registration_result",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The title and the declarations of one file.
fn section(file: &str, config: &cbindgen::Config) -> (String, String) {
    let path = root().join(format!("src/capi/{file}.rs"));
    let source = std::fs::read_to_string(&path).unwrap();
    let title = source.lines().next().unwrap().strip_prefix("//! ").unwrap().to_owned();
    let mut made = Vec::new();
    cbindgen::Builder::new()
        .with_config(config.clone())
        .with_src(path)
        .generate()
        .unwrap()
        .write(&mut made);
    (title, plain(&String::from_utf8(made).unwrap()))
}

/// Types by their names alone where they are used: cbindgen puts `struct` or `enum` before those of the same file.
fn plain(made: &str) -> String {
    let mut plain = made.trim().to_owned();
    for kind in ["struct", "enum"] {
        let (tag, kept) = (format!("{kind} Mlg"), format!("typedef {kind} @"));
        plain = plain
            .replace(&format!("typedef {tag}"), &kept)
            .replace(&tag, "Mlg")
            .replace(&kept, &format!("typedef {tag}"));
    }
    plain
}

/// Takes the declarations of handles out, with what is said of them.
fn take_handles(declarations: &mut String) -> Vec<String> {
    let (handles, rest): (Vec<&str>, Vec<&str>) = declarations.split("\n\n").partition(|part| {
        part.contains("\ntypedef struct Mlg") && part.ends_with(';') && !part.contains('{')
    });
    let handles = handles.into_iter().map(str::to_owned).collect();
    *declarations = rest.join("\n\n");
    handles
}

fn header() -> String {
    let mut config = cbindgen::Config::from_file(root().join("cbindgen.toml")).unwrap();
    let introduction = config.header.take().unwrap();
    let mut sections = SECTIONS.map(|file| section(file, &config)).to_vec();
    let handles: Vec<String> =
        sections.iter_mut().flat_map(|(_, declarations)| take_handles(declarations)).collect();
    sections.insert(0, ("Handles: what the functions work on.".into(), handles.join("\n\n")));

    let titles: Vec<String> = sections.iter().map(|(title, _)| format!(" *   {title}")).collect();
    let mut made = introduction.trim().replace(" *CONTENTS", &titles.join("\n"));
    made.push_str(
        "\n#ifndef MOULAGE_H\n#define MOULAGE_H\n\n#include <stddef.h>\n#include <stdint.h>\n\n\
         #ifdef __cplusplus\nextern \"C\" {\n#endif\n",
    );
    for (title, declarations) in sections {
        let line = "=".repeat(96);
        write!(made, "\n/* {line}\n * {title}\n * {line} */\n\n{declarations}\n").unwrap();
    }
    made.push_str("\n#ifdef __cplusplus\n}\n#endif\n\n#endif  /* MOULAGE_H */\n");
    made
}

#[test]
fn the_header_is_up_to_date() {
    let made = header();
    let path = root().join("include/moulage.h");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
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
