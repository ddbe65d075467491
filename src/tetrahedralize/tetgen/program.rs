//! Running the program TetGen: find it, feed it, read what it made, put its failures into words.
//!
//! TetGen (H. Si) is AGPL; it is a separate program and never linked.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::error::{Error, Result, Shown};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::run::Run;

/// A run that takes longer than this is stopped.
const TIME_LIMIT: Duration = Duration::from_secs(120);
/// How often a running program is looked at.
const LOOK: Duration = Duration::from_millis(5);
/// Environment variable that names the program.
const VARIABLE: &str = "MOULAGE_TETGEN";

/// Looks for TetGen: the path asked for, else the variable `MOULAGE_TETGEN`, else the search path.
/// None if there is none; an error if a path was named and nothing is there.
pub fn find(asked: Option<&Path>) -> Result<Option<PathBuf>> {
    let named = asked.map(Path::to_path_buf);
    let named =
        named.or_else(|| std::env::var_os(VARIABLE).filter(|v| !v.is_empty()).map(Into::into));
    if let Some(path) = named {
        if path.is_file() {
            return Ok(Some(path));
        }
        return Err(Error::invalid(format!(
            "TetGen was to be {}, but there is no such file; correct the path, or leave it out to search for it",
            path.shown()
        )));
    }
    let file = format!("tetgen{}", std::env::consts::EXE_SUFFIX);
    let folders = std::env::var_os("PATH").unwrap_or_default();
    Ok(std::env::split_paths(&folders).map(|f| f.join(&file)).find(|p| p.is_file()))
}

/// What TetGen made: its points (the given ones first) and tets.
pub type Tets = (Vec<Vec3>, Vec<[u32; 4]>);

/// TetGen with one surface written for it.
pub struct Program<'a> {
    path: &'a Path,
    surface: &'a TriMesh,
    folder: TempDir,
}

impl<'a> Program<'a> {
    /// Writes the surface into a new private folder, removed when this is dropped.
    pub fn new(path: &'a Path, surface: &'a TriMesh) -> Result<Self> {
        let failed = |e| Error::io("create a folder in", &std::env::temp_dir(), e);
        let folder = tempfile::Builder::new().prefix("moulage-").tempdir().map_err(failed)?;
        let program = Self { path, surface, folder };
        let file = program.file("smesh");
        std::fs::write(&file, smesh(surface)).map_err(|e| Error::io("write", &file, e))?;
        Ok(program)
    }

    /// Fills the surface; no tet larger than `max_volume`.
    pub fn fill(&self, max_volume: Option<f64>, run: &Run) -> Result<Tets> {
        // p: a surface, Y: keep it as it is, q1.4: radius-edge ratio, F: no faces, z: from zero.
        let size = max_volume.map(|a| format!("a{a:.17}")).unwrap_or_default();
        let status = self.call(&format!("-pYq1.4{size}FzQ"), run)?;
        let (points, tets) = (self.file("1.node"), self.file("1.ele"));
        if !status.success() || !tets.is_file() {
            return Err(self.failure(self.reason(status, run)));
        }
        let points = read_table::<3, f64>(&points)?.into_iter().map(Vec3::from).collect();
        Ok((points, read_table::<4, u32>(&tets)?))
    }

    fn file(&self, ending: &str) -> PathBuf {
        self.folder.path().join(format!("surface.{ending}"))
    }

    fn failure(&self, message: String) -> Error {
        Error::ExternalProgram { program: self.path.shown(), message }
    }

    /// Runs the program to its end, its words going to a file.
    fn call(&self, switches: &str, run: &Run) -> Result<ExitStatus> {
        let words = self.file("log");
        let log = File::create(&words).map_err(|e| Error::io("create", &words, e))?;
        let mut child = Command::new(self.path)
            .args([switches, "surface.smesh"])
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(log)
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| self.failure(format!("could not be started: {e}")))?;
        let started = Instant::now();
        loop {
            if let Some(status) =
                child.try_wait().map_err(|e| self.failure(format!("was lost sight of: {e}")))?
            {
                return Ok(status);
            }
            let late = started.elapsed() > TIME_LIMIT;
            if late || run.is_cancelled() {
                // It may have ended meanwhile; both calls are then without effect.
                let _ = child.kill();
                let _ = child.wait();
                return Err(if late {
                    let limit = TIME_LIMIT.as_secs();
                    self.failure(format!("still at work after {limit} seconds, stopped; ask for fewer tets or use the lattice"))
                } else {
                    Error::Cancelled
                });
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Why a run failed: TetGen itself says which facets cut each other when asked with `-d`.
    fn reason(&self, status: ExitStatus, run: &Run) -> String {
        let checked = self.call("-dz", run).is_ok();
        let words = std::fs::read_to_string(self.file("log")).unwrap_or_default();
        let pairs = if checked { crossing_facets(&words) } else { Vec::new() };
        match pairs.first() {
            Some(&(a, b)) if a.max(b) < self.surface.triangles.len() => {
                let p = self.surface.corners(a)[0];
                format!(
                    "the surface cuts itself in {} places, the first near ({:.4}, {:.4}, {:.4}); mend it there or use the lattice",
                    pairs.len(),
                    p.x,
                    p.y,
                    p.z
                )
            }
            _ => format!(
                "ended without tets ({status}); the surface may be open or cut itself; the lattice takes such surfaces"
            ),
        }
    }
}

/// Pairs of 0-based triangles from lines "Facet #4 intersects facet #5 at triangles:".
fn crossing_facets(words: &str) -> Vec<(usize, usize)> {
    let number = |part: &str| {
        let digits: String = part.chars().take_while(char::is_ascii_digit).collect();
        digits.parse::<usize>().ok()?.checked_sub(1)
    };
    let pair = |line: &str| {
        let mut parts = line.split('#').skip(1);
        Some((number(parts.next()?)?, number(parts.next()?)?))
    };
    words.lines().filter(|l| l.contains("intersects")).filter_map(pair).collect()
}

/// The surface in TetGen's format. Numbers are written so that they read back exactly.
fn smesh(surface: &TriMesh) -> Vec<u8> {
    let mut text = Vec::new();
    let mut write = || -> std::io::Result<()> {
        writeln!(text, "{} 3 0 0", surface.points.len())?;
        for (i, p) in surface.points.iter().enumerate() {
            writeln!(text, "{i} {:e} {:e} {:e}", p.x, p.y, p.z)?;
        }
        writeln!(text, "{} 0", surface.triangles.len())?;
        for [a, b, c] in &surface.triangles {
            writeln!(text, "3 {a} {b} {c}")?;
        }
        writeln!(text, "0\n0")
    };
    write().expect("memory takes all");
    text
}

/// Rows of a .node or .ele file: a header, then an index and `N` values in each line.
fn read_table<const N: usize, T: std::str::FromStr + Copy + Default>(
    path: &Path,
) -> Result<Vec<[T; N]>> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io("read", path, e))?;
    let mut rows = Vec::new();
    for (n, line) in text.lines().enumerate().skip(1) {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let mut words = line.split_whitespace().skip(1);
        let mut row = [T::default(); N];
        for value in &mut row {
            let word = words.next().and_then(|w| w.parse().ok());
            *value = word.ok_or_else(|| {
                Error::parse(path, n + 1, format!("{N} numbers expected after the index"))
            })?;
        }
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_tetgen_says_about_crossing_facets() {
        let words = "Detecting ...\n  Facet #4 intersects facet #5 at triangles:\n    (1,2,3) and (4,6,5)\n";
        assert_eq!(crossing_facets(words), [(3, 4)]);
        assert!(crossing_facets("Facet #0 intersects facet #x").is_empty());
    }

    #[test]
    fn tables_are_read_and_broken_ones_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.ele");
        std::fs::write(&file, "2 4 0\n 0 1 2 3 4\n1  5 6 7 8\n# Generated\n").unwrap();
        assert_eq!(read_table::<4, u32>(&file).unwrap(), [[1, 2, 3, 4], [5, 6, 7, 8]]);
        std::fs::write(&file, "9999999999 4 0\n0 1 2 3\n").unwrap();
        let message = read_table::<4, u32>(&file).unwrap_err().to_string();
        assert!(message.contains("line 2"), "{message}");
    }

    #[test]
    fn a_named_program_must_exist() {
        assert!(find(Some(Path::new("/no/such/tetgen"))).is_err());
    }
}
