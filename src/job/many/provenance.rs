//! Where a result comes from: version, options, and every input file with its hash.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::error::{Error, Result};
use crate::io::{read_bytes, read_text};
use crate::job::reshape::spec::ReshapeJob;

/// One input file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Where it was read.
    pub path: PathBuf,
    /// SHA-256 of its bytes; of a folder: of its files in the order of their names.
    pub sha256: String,
}

/// Reads a job file; returns its text too.
pub(crate) fn read_job(path: &Path) -> Result<(ReshapeJob, String)> {
    let text = read_text(path)?;
    Ok((ReshapeJob::parse(&text, path)?, text))
}

/// Every file that a job reads, each once, sorted, with its hash.
pub(crate) fn inputs(job: &ReshapeJob) -> Result<Vec<InputFile>> {
    let mut paths = Vec::new();
    reshape_inputs(job, &mut paths);
    hash_files(paths)
}

/// Each path once, sorted, with its hash.
pub(crate) fn hash_files(mut paths: Vec<PathBuf>) -> Result<Vec<InputFile>> {
    paths.sort();
    paths.dedup();
    paths.into_iter().map(|path| Ok(InputFile { sha256: hash_path(&path)?, path })).collect()
}

fn reshape_inputs(job: &ReshapeJob, paths: &mut Vec<PathBuf>) {
    let lists =
        [&job.markers, &job.landmarks, &job.attachments, &job.attachment_targets, &job.carry];
    let single = [&job.template, &job.fixed, &job.volume, &job.label_map];
    paths.extend(lists.into_iter().flatten().flatten().cloned());
    paths.extend(single.into_iter().flatten().cloned());
    paths.extend(job.tets.iter().filter(|t| t.extension().is_some()).cloned());
}

/// SHA-256 in hexadecimal digits.
pub(crate) fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        // Writing into a text does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn hash_path(path: &Path) -> Result<String> {
    if !path.is_dir() {
        return Ok(hash(&read_bytes(path)?));
    }
    let io = |e| Error::io("read", path, e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(io)? {
        files.push(entry.map_err(io)?.path());
    }
    files.sort();
    let mut all = String::new();
    for file in files.iter().filter(|f| f.is_file()) {
        all.push_str(&hash(&read_bytes(file)?));
    }
    Ok(hash(all.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_standard_one() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(hash(b"abc"), expected);
    }
}
