//! Volume files, by what they are.

use std::path::Path;

use super::dicom::read_dicom;
use super::label_names::LabelNames;
use super::meta_image::read_meta_image;
use super::nifti::parse_named_nifti;
use super::nrrd::read_nrrd;
use super::read_bytes;
use crate::error::{Error, Result, Shown};
use crate::volume::Volume;

/// A volume with what its reader noticed.
#[derive(Clone, Debug)]
pub struct VolumeFile {
    /// The image.
    pub volume: Volume,
    /// "NIfTI", "DICOM", "NRRD" or "MetaImage".
    pub format: &'static str,
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
    /// The names that the file has for the labels of a label map.
    pub label_names: LabelNames,
}

/// Whether [`read_volume`] would take this path: an extension of a volume, or a folder.
pub fn is_volume(path: &Path) -> bool {
    format(path).is_some()
}

/// Reads `.nii`, `.nii.gz`, `.nrrd`, `.nhdr`, `.mha`, `.mhd`, a folder of DICOM slices, or the
/// series that one DICOM file (`.dcm` or no extension) belongs to.
pub fn read_volume(path: &Path) -> Result<VolumeFile> {
    let format = format(path).ok_or_else(|| {
        Error::Unsupported(format!(
            "{} is not a volume: .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd and folders of DICOM files are",
            path.shown()
        ))
    })?;
    let mut notes = Vec::new();
    let (volume, label_names) = match format {
        "NIfTI" => parse_named_nifti(&read_bytes(path)?, path)?,
        "NRRD" => read_nrrd(path)?,
        "MetaImage" => (read_meta_image(path)?, LabelNames::new()),
        _ => {
            let (volume, found) = read_dicom(path)?;
            notes = found;
            (volume, LabelNames::new())
        }
    };
    Ok(VolumeFile { volume, format, notes, label_names })
}

fn format(path: &Path) -> Option<&'static str> {
    if path.is_dir() {
        return Some("DICOM");
    }
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    let endings = [
        (".nii", "NIfTI"),
        (".nii.gz", "NIfTI"),
        (".nrrd", "NRRD"),
        (".nhdr", "NRRD"),
        (".mha", "MetaImage"),
        (".mhd", "MetaImage"),
        (".dcm", "DICOM"),
        (".ima", "DICOM"),
    ];
    let known = endings.into_iter().find(|(ending, _)| name.ends_with(ending));
    // Scanners and archives write slices without an extension.
    known.map(|(_, format)| format).or_else(|| {
        let bare =
            path.extension().is_none() || name.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        (bare && path.is_file()).then_some("DICOM")
    })
}
