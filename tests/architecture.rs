//! The layers of ARCHITECTURE.md: imports go only downwards, and not between modules on one line.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

/// Bottom to top. Modules on one line do not see each other.
const LAYERS: &[&[&str]] = &[
    &["error", "run"],
    &["math", "threads"],
    &["mesh", "volume"],
    &["locate", "material", "solve"],
    &["align", "fem", "io", "measure", "tetrahedralize"],
    &["reshape", "register", "separate"],
    &["job"],
    &["capi"],
];

/// Algorithms never touch files.
const MAY_USE_IO: &[&str] = &["job", "capi"];

fn layer(module: &str) -> usize {
    LAYERS.iter().position(|line| line.contains(&module)).unwrap_or_else(|| {
        panic!("module {module} stands in no layer: add it to tests/architecture.rs and ARCHITECTURE.md")
    })
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Names after each `crate::` in the code, comments left out.
fn used_modules(text: &str) -> Vec<String> {
    let code: String =
        text.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    code.split("crate::")
        .skip(1)
        .map(|rest| {
            rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
        })
        .filter(|name| name.chars().next().is_some_and(char::is_lowercase))
        .collect()
}

#[test]
fn imports_go_only_downwards() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    let mut wrong = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&source).unwrap();
        let first = inside.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
        let module = first.trim_end_matches(".rs");
        if matches!(module, "lib" | "main" | "cli") {
            continue;
        }
        for used in used_modules(&std::fs::read_to_string(&file).unwrap()) {
            if used == module {
                continue;
            }
            let lower = layer(&used) < layer(module);
            if !lower || (used == "io" && !MAY_USE_IO.contains(&module)) {
                wrong.push(format!("{}: {module} must not use {used}", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
