//! Everything that can be tuned, with its meaning and default.

use crate::error::{Error, Result};
use crate::mesh::TriMesh;

/// The template's diagonal in tolerances.
const DIAGONAL_TOLERANCES: f64 = 1000.0;
/// A landmark is clicked less exactly than a marker: this many tolerances.
const LANDMARK_TOLERANCE: f64 = 5.0;

/// Options of a reshaping. Lengths are in the template's unit; `None` takes a default relative to
/// the template's size, so that millimetres, metres and Blender units give the same shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How far a marker may be off: its noise. The result is the smoothest shape that explains the
    /// markers to about this. Default: the template's diagonal / 1000.
    pub tolerance: Option<f64>,
    /// How far a landmark may be off when it can be trusted. Default: 5 times `tolerance`.
    pub landmark_tolerance: Option<f64>,
    /// How far an attachment may be off where most attachments agree with the markers. Default: `tolerance`.
    pub attachment_tolerance: Option<f64>,
    /// Attachments are met whatever the markers say, instead of being weighed against them.
    pub hard_attachments: bool,
    /// Template points far from every marker are pulled back, except beyond the ends of a scan that
    /// cuts the organ and of an outline that was left open. Acts only for markers that lie on parallel
    /// axis-aligned slices.
    pub reverse_term: bool,
    /// The published formulation: a symmetric Fp per tet, smoothed by the graph Laplacian, stepped
    /// by the Woodbury update. For comparison; the default is more accurate and takes less time.
    pub paper: bool,
    /// Weight of the smoothness of the plastic strain, dimensionless. Not used by
    /// the published formulation, whose weight is 1.
    pub smoothness: f64,
    /// Distance over which the strain returns to its mean away from data, as a multiple of the
    /// cube root of the template's volume. Infinite: never. Default: from 0.1 for a template of which
    /// hardly anything was seen, so that a local edit stays local, to 0.3 for one seen all around.
    pub screening: Option<f64>,
    /// Poisson's ratio of the tissue.
    pub poisson: f64,
    /// Gauss-Newton iterations allowed.
    pub max_iterations: usize,
    /// How often the shape reached may be filled with new tets where the old ones have become so flat
    /// that nothing more is gained; 0: never. The published formulation does without.
    pub max_remeshes: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            tolerance: None,
            landmark_tolerance: None,
            attachment_tolerance: None,
            hard_attachments: false,
            reverse_term: true,
            paper: false,
            smoothness: 0.08,
            screening: None,
            poisson: 0.3,
            max_iterations: 80,
            max_remeshes: 3,
        }
    }
}

/// How far data of each kind may be off.
#[derive(Clone, Copy, Debug)]
pub struct Tolerances {
    /// Markers.
    pub marker: f64,
    /// Landmarks that can be trusted.
    pub landmark: f64,
    /// Attachments where most of them agree with the markers.
    pub attachment: f64,
}

impl Options {
    /// The tolerances with their defaults, which follow from the size of the template, in `unit`s of the
    /// template's own.
    pub fn tolerances(&self, template: &TriMesh, unit: f64) -> Tolerances {
        let marker = self.tolerance.unwrap_or(template.diagonal() / DIAGONAL_TOLERANCES) / unit;
        Tolerances {
            marker,
            landmark: self.landmark_tolerance.map_or(LANDMARK_TOLERANCE * marker, |t| t / unit),
            attachment: self.attachment_tolerance.map_or(marker, |t| t / unit),
        }
    }

    /// With a tolerance that no longer depends on the template's size: on new tets it has another one.
    pub(super) fn settled(&self, template: &TriMesh) -> Self {
        Self { tolerance: Some(self.tolerances(template, 1.0).marker), ..self.clone() }
    }

    /// Checks ranges.
    pub fn check(&self) -> Result<()> {
        for (name, value) in [
            ("tolerance", self.tolerance),
            ("landmark tolerance", self.landmark_tolerance),
            ("attachment tolerance", self.attachment_tolerance),
            ("smoothness", Some(self.smoothness)),
            ("screening", self.screening),
        ] {
            if value.is_some_and(|v| v.is_nan() || v <= 0.0) {
                return Err(Error::invalid(format!("the {name} must be above 0")));
            }
        }
        if !(self.poisson > 0.0 && self.poisson < 0.5) {
            return Err(Error::invalid("Poisson's ratio must lie between 0 and 0.5"));
        }
        Ok(())
    }
}
