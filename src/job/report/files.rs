//! The two files of a report.

use std::path::Path;

use serde::Serialize;

use crate::error::Result;
use crate::io::write_beside;

/// Writes a report's figures into `report.json` and its page into `report.html` of `folder`.
pub(crate) fn write_report(folder: &Path, figures: &impl Serialize, page: &str) -> Result<()> {
    write_beside(&folder.join("report.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, figures)?;
        writeln!(out)
    })?;
    write_beside(&folder.join("report.html"), |out| out.write_all(page.as_bytes()))
}
