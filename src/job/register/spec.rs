//! One registration described as data: the flags of the command line, the keys of an anatomy's skeleton.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::image_target::Measure;
use crate::register::Limits;

/// All that describes one registration. What is `None` takes its default. Lengths are in the
/// template's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(default, deny_unknown_fields)]
pub struct RegisterJob {
    /// Template: *.skeleton.json
    #[cfg_attr(feature = "cli", arg(value_name = "SKELETON"))]
    pub skeleton: PathBuf,
    /// Surface of all the person's bones: .obj, .ply, .stl, or a label map with one label; bones may be
    /// fused
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub target: Option<PathBuf>,
    /// Folder with one surface per bone, named as the bone, or a label map (the skeleton file gives
    /// each bone its label), instead of --target
    #[cfg_attr(feature = "cli", arg(long, value_name = "PATH", help_heading = "Input"))]
    pub labels: Option<PathBuf>,
    /// The label of --target that is bone [default: the only one]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "N", requires = "target", help_heading = "Input")
    )]
    pub label: Option<u32>,
    /// Image of the person instead of a surface; the template must lie near the bones
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME", help_heading = "Input"))]
    pub volume: Option<PathBuf>,
    /// Image in which the template lies on the bones [default: what the skeleton file names]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "VOLUME", requires = "volume", help_heading = "Input")
    )]
    pub reference: Option<PathBuf>,
    /// Places of bones that are known on the person: one file with both positions (template_x .. and
    /// target_x ..), or two marker files, of the template and of the person, paired by name; named as
    /// the bone (femur, "femur: head"), else on the nearest one
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "FILE", num_args = 1..=2, help_heading = "Input")
    )]
    pub landmarks: Option<Vec<PathBuf>>,
    /// Soft tissue surfaces in the template's pose to carry along, besides the skeleton's own
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Input"))]
    pub carry: Option<Vec<PathBuf>>,
    /// Shape statistics (.h5.json) of the template's bones, from `moulage model fit` [default: what the
    /// skeleton file names]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub shape_model: Option<PathBuf>,
    /// Motion to put on the person's skeleton: OpenSim (.mot, .sto), or .bvh with nodes named as the bones
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub motion: Option<PathBuf>,
    /// Angles of the motion whose sign is the opposite of the skeleton's
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME", num_args = 1.., help_heading = "Input"))]
    pub flip: Option<Vec<String>>,

    /// Run the loop as published: exact clusters, updates only when the elastic steps rest
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Method"))]
    pub paper: bool,
    /// How images are compared: profiles, or the published moments [default: profiles]
    #[cfg_attr(feature = "cli", arg(long, value_enum, help_heading = "Method"))]
    pub measure: Option<Measure>,
    /// How far an image is searched to each side, at most and at least, mm [default: 10 and 0.5 % of the
    /// template's diagonal]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "MM", num_args = 2, help_heading = "Method")
    )]
    pub reach: Option<Vec<f64>>,
    /// The template already lies where the person is
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Method"))]
    pub no_align: bool,
    /// The target is meant as it is, even if it looks like a mirror image or another unit
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Method"))]
    pub as_is: bool,
    /// What the joints' limits are: soft (10 degrees further where the data insist), walls, or nothing
    /// [default: soft]
    #[cfg_attr(feature = "cli", arg(long, value_enum, help_heading = "Method"))]
    pub limits: Option<Limits>,
    /// Cluster radii from coarse to fine, "inf" for one cluster [default: from the size]
    #[cfg_attr(feature = "cli", arg(long, value_name = "RADIUS", num_args = 1.., help_heading = "Method"))]
    pub radii: Option<Vec<f64>>,
    /// Iterations per level at most [default: 30]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Method"))]
    pub iterations: Option<usize>,
    /// Threads [default: all cores]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Method"))]
    pub threads: Option<usize>,

    /// Folder for the result: bones/, result.skeleton.json, skeleton.glb, soft/
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER", help_heading = "Output"))]
    pub out: Option<PathBuf>,
    /// Bones in one .ply with bone, verdict, seen and distance to the target at each vertex
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Output"))]
    pub ply_out: Option<PathBuf>,
    /// Folder for report.html, report.json and result.ply (as --ply-out)
    #[cfg_attr(feature = "cli", arg(long, value_name = "FOLDER", help_heading = "Output"))]
    pub report: Option<PathBuf>,
    /// Metres per unit of the template, for skeleton.glb [default: what its file
    /// says, else 0.001]
    #[cfg_attr(feature = "cli", arg(long, value_name = "METRES", help_heading = "Output"))]
    pub metres_per_unit: Option<f64>,
}
