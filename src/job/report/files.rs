//! The two files of a report.

use std::path::Path;

use serde::Serialize;

use crate::error::Result;
use crate::io::{write_beside, write_json};

/// Writes a report's figures into `report.json` and its page into `report.html` of `folder`.
pub(crate) fn write_report(folder: &Path, figures: &impl Serialize, page: &str) -> Result<()> {
    write_json(&folder.join("report.json"), figures)?;
    write_beside(&folder.join("report.html"), |out| out.write_all(page.as_bytes()))
}
