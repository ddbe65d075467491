//! `*.profiles.json`: what a template shows around its surface in a reference image, so that the
//! image itself need not travel with the template.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::{read_bytes, write_beside};
use crate::error::{Error, Result};
use crate::volume::Profiles;

const FORMAT: &str = "intensity-profiles";

#[derive(Serialize, Deserialize)]
struct File {
    format: String,
    version: u32,
    /// Millimetres between samples.
    step_mm: f64,
    /// Samples on each side of the surface.
    half: usize,
    /// Little-endian single precision, point by point from inside outwards, in base64.
    values: String,
}

/// Reads profiles.
pub fn read_profiles(path: &Path) -> Result<Profiles> {
    parse_profiles(&read_bytes(path)?, path)
}

/// Reads profiles from a file's bytes; `path` is for error messages.
pub fn parse_profiles(bytes: &[u8], path: &Path) -> Result<Profiles> {
    let wrong = |message: String| Error::parse(path, None, message);
    let file: File = serde_json::from_slice(bytes)
        .map_err(|e| Error::parse(path, e.line(), format!("no profiles: {e}")))?;
    if file.format != FORMAT || file.version != 1 {
        return Err(wrong(format!("the format is '{}', version {}", file.format, file.version)));
    }
    let bytes = STANDARD.decode(&file.values).map_err(|e| wrong(format!("broken values: {e}")))?;
    let number = |chunk: &[u8]| f32::from_le_bytes([chunk[0], chunk[1], chunk[2], chunk[3]]);
    let values = bytes.chunks_exact(4).map(number).collect();
    Profiles::from_values(file.step_mm, file.half, values).map_err(|e| wrong(e.to_string()))
}

/// Writes profiles.
pub fn write_profiles(path: &Path, profiles: &Profiles) -> Result<()> {
    let bytes: Vec<u8> = profiles.values().iter().flat_map(|v| v.to_le_bytes()).collect();
    let file = File {
        format: FORMAT.to_owned(),
        version: 1,
        step_mm: profiles.step(),
        half: profiles.half(),
        values: STANDARD.encode(bytes),
    };
    write_beside(path, |out| Ok(serde_json::to_writer(out, &file)?))
}
