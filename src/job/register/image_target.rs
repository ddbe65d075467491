//! Skeletons and images: the features of the reference image, the person's image as a target.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::skeleton_files::SkeletonFiles;
use crate::error::{Error, Result, Shown};
use crate::io::skeleton::ReferenceImage;
use crate::io::{read_profiles, read_volume};
use crate::register::{Appearance, Skeleton, Target};

/// How the person's image is compared with the reference image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// Intensities along normals, by correlation.
    #[default]
    Profiles,
    /// Histogram moments in balls, as published.
    Moments,
}

/// Balls of the moments begin at so many of the image's smallest voxel sizes: the thickness of the
/// cortex in an image that shows it.
const MOMENT_VOXELS: f64 = 2.0;

/// What the template shows in its reference image: the one given, else the one its file names.
pub(crate) fn appearance(
    path: &Path,
    files: &SkeletonFiles,
    reference: Option<&Path>,
    measure: Measure,
) -> Result<Appearance> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let own = files.document.reference_image.clone().unwrap_or_default();
    let ReferenceImage { volume, profiles } = own;
    let volume: Option<PathBuf> =
        reference.map(Path::to_path_buf).or_else(|| volume.map(|v| folder.join(v)));
    match (volume, profiles, measure) {
        (Some(volume), _, Measure::Moments) => {
            let volume = read_volume(&volume)?.volume;
            let radius = MOMENT_VOXELS * volume.spacing().min();
            Appearance::moments(&files.skeleton, &volume, radius)
        }
        (None, _, Measure::Moments) => Err(missing(path, "a reference image")),
        (_, Some(profiles), Measure::Profiles) if reference.is_none() => {
            Ok(Appearance::Profiles(read_profiles(&folder.join(profiles))?))
        }
        (Some(volume), _, Measure::Profiles) => {
            Appearance::profiles(&files.skeleton, &read_volume(&volume)?.volume, None)
        }
        (None, _, Measure::Profiles) => Err(missing(path, "a reference image or its profiles")),
    }
}

fn missing(path: &Path, what: &str) -> Error {
    Error::invalid(format!(
        "{}: to look for the template in an image, {what} is needed in which it lies on the bones; \
         name it with --reference, or as reference_image in the skeleton file",
        path.shown()
    ))
}

/// The person's image as a target, with the reader's notes.
pub(crate) fn image_target(
    skeleton: &Skeleton,
    volume: &Path,
    appearance: Appearance,
) -> Result<(Target, Vec<String>)> {
    let file = read_volume(volume)?;
    Ok((Target::image(skeleton, file.volume, appearance)?, file.notes))
}

/// Millimetres as shares of the skeleton's diagonal.
pub(crate) fn relative_reach(reach: &[f64], skeleton: &Skeleton) -> Result<[f64; 2]> {
    let diagonal = crate::mesh::diagonal(&skeleton.points);
    match reach {
        [first, last] if [first, last].iter().all(|r| r.is_finite() && **r > 0.0) => {
            Ok([first / diagonal, last / diagonal])
        }
        _ => Err(Error::invalid("--reach needs two lengths above 0, such as 20 5")),
    }
}
