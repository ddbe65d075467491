//! Whole files: read into memory, or written beside the target and renamed over it.

use std::collections::HashSet;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;

use crate::error::{Error, Result, Shown};

/// The bytes of a file.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).map_err(|e| Error::io("read", path, e))
}

/// The text of a file.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path)?)
        .map_err(|_| Error::parse(path, None, "the file is not valid UTF-8 text"))
}

/// A file's name without folder and extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Whether a file's name ends in this extension, in letters of either case.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

/// Names that Windows has for devices, whatever follows after a dot.
const DEVICES: [&str; 6] = ["aux", "com", "con", "lpt", "nul", "prn"];

/// A name without anything that means something in a path, on any system.
pub fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "_-.".contains(c) { c } else { '_' };
    let cleaned: String = name.chars().map(safe).collect();
    let cleaned = cleaned.trim_matches('.');
    let first = cleaned.split('.').next().unwrap_or_default().to_lowercase();
    let device = DEVICES.contains(&first.trim_end_matches(|c: char| c.is_ascii_digit()));
    if device { format!("_{cleaned}") } else { cleaned.to_string() }
}

/// File names for many things, no two of them one file where letters of either case are the same: a
/// later one is numbered.
pub fn file_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut taken = HashSet::new();
    let different = |name: &str| {
        let own = file_name(name);
        let numbered = (2..).map(|k| format!("{own}_{k}"));
        let mut candidates = std::iter::once(own.clone()).chain(numbered);
        candidates.find(|name| taken.insert(name.to_lowercase())).unwrap_or(own)
    };
    names.into_iter().map(different).collect()
}

/// Writes a file such that `path` holds either its old content or the complete new one: `fill`
/// writes to a file beside it, which is then renamed. Missing folders are made.
pub fn write_beside(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    }
    let beside = beside(path);
    let written = fill_file(&beside, fill).and_then(|()| fs::rename(&beside, path));
    written.map_err(|e| {
        // The first error is the one to tell; a leftover that cannot be removed is harmless.
        let _ = fs::remove_file(&beside);
        Error::io("write", path, e)
    })
}

/// Writes a value as JSON with indentation, see [`write_beside`].
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_beside(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        writeln!(out)
    })
}

/// Whether a file can be written at `path`, found out before a long computation: the folder, or the
/// nearest one above it that exists, must take a new file.
pub fn check_writable(path: &Path) -> Result<()> {
    let mut folder = path.parent();
    while let Some(missing) = folder.filter(|f| !f.as_os_str().is_empty() && !f.exists()) {
        folder = missing.parent();
    }
    let probe = beside(&folder.unwrap_or(Path::new("")).join(path.file_name().unwrap_or_default()));
    let made = if path.is_dir() {
        Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"))
    } else {
        File::create(&probe).and_then(|_| fs::remove_file(&probe))
    };
    made.map_err(|e| Error::io("write", path, e))
}

/// The same for the file that `flag` names, which must end in one of `extensions`.
pub fn check_output(path: &Path, extensions: &[&str], flag: &str) -> Result<()> {
    if !extensions.iter().any(|known| has_extension(path, known)) {
        let known = extensions.join(" or .");
        let text = format!("{flag} {}: the name must end in .{known}", path.shown());
        return Err(Error::invalid(text));
    }
    check_writable(path)
}

/// A name in the same folder (renaming works only within one file system), another one at every call:
/// jobs side by side write files of one name, and look whether they can before their folders exist.
fn beside(path: &Path) -> PathBuf {
    static CALLS: AtomicUsize = AtomicUsize::new(0);
    let call = CALLS.fetch_add(1, Ordering::Relaxed);
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.{call}.part", std::process::id()));
    path.with_file_name(name)
}

fn fill_file(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    fill(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_other() {
        let folder = std::env::temp_dir().join(format!("moulage_write_{}", std::process::id()));
        let path = folder.join("a/b.txt");
        write_beside(&path, |out| out.write_all(b"old")).unwrap();
        let error = write_beside(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        })
        .unwrap_err();
        assert!(error.to_string().ends_with("b.txt: the disk is full"), "{error}");
        assert_eq!(read_bytes(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.join("a")).unwrap().count(), 1);
        check_writable(&path).unwrap();
        check_writable(&folder.join("new/folder/c.txt")).unwrap();
        let error = check_writable(&folder.join("a")).unwrap_err().to_string();
        assert!(error.ends_with("it is a folder"), "{error}");
        let error = check_writable(&path.join("d.txt")).unwrap_err().to_string();
        assert!(error.starts_with("cannot write "), "{error}");
        assert_eq!(fs::read_dir(folder.join("a")).unwrap().count(), 1);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn file_names_are_good_on_every_system() {
        let names =
            ["Femur", "femur", "a b", "a_b", "con", "Com1.left", "../x", "Rippe Ä", "femur."];
        let expected =
            ["Femur", "femur_2", "a_b", "a_b_2", "_con", "_Com1.left", "_x", "Rippe_Ä", "femur_3"];
        assert_eq!(file_names(names), expected);
    }

    #[test]
    fn files_of_one_name_are_checked_side_by_side() {
        let folder = std::env::temp_dir().join(format!("moulage_probe_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        std::thread::scope(|scope| {
            for k in 0..4 {
                let path = folder.join(format!("{k}/result.obj"));
                scope.spawn(move || (0..200).for_each(|_| check_writable(&path).unwrap()));
            }
        });
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
        fs::remove_dir_all(folder).unwrap();
    }
}
