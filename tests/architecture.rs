//! The layers of ARCHITECTURE.md: imports go only downwards, not between modules on one line, and never in
//! a circle.

#![allow(clippy::unwrap_used)]

use moulage::error::Shown;
use std::collections::{BTreeMap, BTreeSet};
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

/// The rooms of `job` in the same way.
const ROOMS: &[&[&str]] = &[
    &["job_file", "report", "separate"],
    &["images", "register"],
    &["convert", "reshape"],
    &["check", "many"],
];

/// Algorithms never touch files.
const MAY_USE_IO: &[&str] = &["job", "capi"];

/// A longer file has more than one subject.
const MOST_LINES: usize = 400;

/// A file's place among the modules: `["job", "many", "case"]`. A `mod.rs` has that of its folder.
type Module = Vec<String>;

/// Whether the unit tests at the end of a file count.
#[derive(Clone, Copy, PartialEq)]
enum Tests {
    Read,
    LeftOut,
}

struct Source {
    /// The code of every file, without comments.
    files: BTreeMap<Module, String>,
    /// What each file shows under another module's name: name to path.
    shown: BTreeMap<Module, BTreeMap<String, Module>>,
}

impl Source {
    fn read(tests: Tests) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut files = BTreeMap::new();
        for path in rust_files(&root) {
            let module = module_of(path.strip_prefix(&root).unwrap());
            if module.first().is_some_and(|m| !matches!(m.as_str(), "lib" | "main" | "cli")) {
                files.insert(module, code(&std::fs::read_to_string(&path).unwrap(), tests));
            }
        }
        let shown = files.iter().map(|(module, text)| {
            let uses = uses(text).into_iter().filter(|u| u.shown);
            (module.clone(), uses.map(|u| (u.name, u.path)).collect())
        });
        Self { shown: shown.collect(), files }
    }

    /// The files that `module` uses.
    fn used_by(&self, module: &Module) -> BTreeSet<Module> {
        let uses = uses(&self.files[module]);
        let found = uses.iter().filter_map(|u| self.resolve(module, &u.path));
        found.filter(|other| other != module).collect()
    }

    /// The file that a path leads to as it stands in `module`, through what folders show.
    fn resolve(&self, module: &Module, path: &[String]) -> Option<Module> {
        let ups = path.iter().take_while(|s| *s == "super").count();
        let (mut at, rest) = match path.first()?.as_str() {
            "crate" => (Vec::new(), &path[1..]),
            "self" => (module.clone(), &path[1..]),
            "super" => (module[..module.len().checked_sub(ups)?].to_vec(), &path[ups..]),
            _ => (module.clone(), path),
        };
        for (k, step) in rest.iter().enumerate() {
            let next: Module = at.iter().chain([step]).cloned().collect();
            if self.files.contains_key(&next) {
                at = next;
                continue;
            }
            // A name that a folder shows is one of a file below it.
            if let Some(shown) = self.shown.get(&at).and_then(|shown| shown.get(step))
                && shown.first() != Some(step)
            {
                let on: Module = shown.iter().chain(&rest[k + 1..]).cloned().collect();
                return self.resolve(&at, &on);
            }
            break;
        }
        (!at.is_empty()).then_some(at)
    }
}

struct Use {
    name: String,
    path: Module,
    shown: bool,
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

fn module_of(path: &Path) -> Module {
    let path = path.with_extension("");
    let mut module: Module = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    module.pop_if(|last| last == "mod");
    module
}

fn code(text: &str, tests: Tests) -> String {
    let code = match tests {
        Tests::Read => text,
        Tests::LeftOut => text.split("#[cfg(test)]\nmod ").next().unwrap(),
    };
    code.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// All that stands in `use` statements, and all paths from `crate::` or `super::` elsewhere.
fn uses(code: &str) -> Vec<Use> {
    let mut found = Vec::new();
    let mut elsewhere = String::new();
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let start = line.trim_start();
        let (seen, rest) = match start.split_once("use ") {
            Some((seen, rest))
                if matches!(seen.trim(), "" | "pub" | "pub(crate)" | "pub(super)") =>
            {
                (seen, rest)
            }
            _ => {
                elsewhere = elsewhere + line + "\n";
                continue;
            }
        };
        let mut tree = rest.to_owned();
        while !tree.ends_with(';') {
            tree += lines.next().unwrap().trim();
        }
        for path in expanded(tree.trim_end_matches(';')) {
            let (path, name) = path.split_once(" as ").unwrap_or((&path, ""));
            let path: Module = path.split("::").map(str::to_owned).collect();
            let name = if name.is_empty() { path.last().unwrap() } else { name }.to_owned();
            found.push(Use { name, path, shown: !seen.is_empty() });
        }
    }
    for start in ["crate::", "super::"] {
        let starts =
            elsewhere.match_indices(start).filter(|(at, _)| !elsewhere[..*at].ends_with("::"));
        for (at, _) in starts {
            let end = elsewhere[at..]
                .find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':')
                .map_or(elsewhere.len(), |length| at + length);
            let path: Module = elsewhere[at..end].split("::").map(str::to_owned).collect();
            found.push(Use { name: String::new(), path, shown: false });
        }
    }
    found
}

/// Each path of a tree such as `a::{b, c::{d, e}}`.
fn expanded(tree: &str) -> Vec<String> {
    let Some((head, body)) = tree.split_once('{') else { return vec![tree.trim().to_owned()] };
    let body = &body[..body.rfind('}').unwrap()];
    let mut depth = 0;
    let parts = body.split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    let parts = parts.map(str::trim).filter(|part| !part.is_empty());
    parts.flat_map(expanded).map(|rest| format!("{}{rest}", head.trim())).collect()
}

/// What is wrong with an import from `module` to `used`, both names of a table's entries.
fn upwards(table: &[&[&str]], module: &str, used: &str) -> bool {
    let floor = |name: &str| {
        table.iter().position(|line| line.contains(&name)).unwrap_or_else(|| {
            panic!("{name} stands in no layer: add it to tests/architecture.rs and ARCHITECTURE.md")
        })
    };
    module != used && floor(used) >= floor(module)
}

#[test]
fn imports_go_only_downwards() {
    let source = Source::read(Tests::Read);
    let mut wrong = Vec::new();
    for module in source.files.keys() {
        for used in source.used_by(module) {
            let path = module.join("/");
            let (own, other) = (module[0].as_str(), used[0].as_str());
            if upwards(LAYERS, own, other)
                || other == "io" && own != other && !MAY_USE_IO.contains(&own)
            {
                wrong.push(format!("{path}: {own} must not use {other}"));
            }
            if let (["job", own, ..], ["job", other, ..]) = (&names(module)[..], &names(&used)[..])
                && upwards(ROOMS, own, other)
            {
                wrong.push(format!("{path}: {own} must not use {other}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn names(module: &Module) -> Vec<&str> {
    module.iter().map(String::as_str).collect()
}

/// A folder's `mod.rs` shows what its files hold and is left out, and so are unit tests, which may set up
/// what stands above.
#[test]
fn no_files_import_each_other_in_a_circle() {
    let source = Source::read(Tests::LeftOut);
    let is_folder =
        |m: &Module| source.files.keys().any(|other| other.len() > m.len() && other.starts_with(m));
    let mut open: BTreeMap<&Module, BTreeSet<Module>> = source
        .files
        .keys()
        .filter(|m| !is_folder(m))
        .map(|m| (m, source.used_by(m).into_iter().filter(|u| !is_folder(u)).collect()))
        .collect();
    // What uses nothing that is still open is in no circle, nor what nothing open uses.
    loop {
        let before = open.len();
        let left: BTreeSet<Module> = open.keys().map(|m| (*m).clone()).collect();
        open.retain(|_, used| used.iter().any(|u| left.contains(u)));
        let asked: BTreeSet<Module> = open.values().flatten().cloned().collect();
        open.retain(|module, _| asked.contains(*module));
        if open.len() == before {
            break;
        }
    }
    let circle: Vec<String> = open.keys().map(|m| m.join("/")).collect();
    assert!(circle.is_empty(), "they import each other in a circle: {}", circle.join(", "));
}

#[test]
fn no_file_is_long() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for path in rust_files(&root) {
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines <= MOST_LINES, "{}: {lines} lines; split it", path.shown());
    }
}
