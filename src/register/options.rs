//! Settings of a registration. Every length is relative to the template's size.

use super::bone_scales::{ScaleFreedom, ScaleOptions};
use super::joint_limits::Limits;

/// How clusters of vertices are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clustering {
    /// Centres this share of the cluster radius apart.
    Sampled {
        /// Share of the radius, 0 to 1.
        spacing: f64,
    },
    /// One at every vertex, as published.
    Exact,
}

/// The cluster radii from coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub enum Levels {
    /// Infinite, then a third of the template's diagonal, a sixth, ... down to a multiple of the
    /// mean edge.
    Automatic {
        /// Smallest radius in mean edge lengths.
        smallest_in_edges: f64,
    },
    /// Given radii in the template's unit; infinity = one cluster.
    Radii(Vec<f64>),
}

/// When the reference shape and pose are updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    /// In every iteration.
    EveryIteration,
    /// When the elastic iterations have come to rest, as published.
    AfterElastic,
    /// Never: clusters alone shape and pose the bones (an ablation; it glues them at their joints).
    Never,
}

/// All settings of [`super::register`].
// Each switch is a step of the method that can be left out on its own.
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Cluster radii.
    pub levels: Levels,
    /// Cluster choice.
    pub clustering: Clustering,
    /// When shape and pose are updated.
    pub schedule: Schedule,
    /// Last levels with clusters bone by bone, stricter normals and robust weights.
    pub refine_bones: bool,
    /// Their smallest radius in mean edge lengths, halving from the last joint level. Clusters are halved
    /// further only where what is left is shape, not noise.
    pub finest_in_edges: f64,
    /// Clusters never span bones, at any level (an ablation; it loses bones).
    pub separate_bones: bool,
    /// Joints hold the bones together.
    pub use_joints: bool,
    /// What the joints' limits are to the search.
    pub limits: Limits,
    /// Target to template pairs are used too (an ablation without).
    pub both_ways: bool,
    /// Freedom of bone scales where there is no shape model.
    pub scale_freedom: ScaleFreedom,
    /// How scales are held together.
    pub scales: ScaleOptions,
    /// At rest when no bone moves more than this share of the template's diagonal on average.
    pub tolerance: f64,
    /// Iterations per level at most.
    pub max_iterations: usize,
    /// Share of its last movement along the surface that a vertex is asked to make again, 0 to 1
    /// (surfaces only).
    pub momentum: f64,
    /// Levels before the first, on which the joints are springs (not where the target tells the bones apart): the
    /// distance of a bone from its data, as a share of the template's diagonal, that counts as much as a
    /// joint turned by its whole range. Empty = none, as published.
    pub springs: Vec<f64>,
    /// Sweeps over the joints in each iteration.
    pub joint_sweeps: usize,
    /// Pairs with a smaller cosine of their normals are dropped before the last level.
    pub min_cosine: f64,
    /// The same for the last level.
    pub last_min_cosine: f64,
    /// A place of the target belongs to another bone when that one is nearer to it by this factor;
    /// 0 = to all that find it. Not on the first level, where all bones move as one.
    pub taken_factor: f64,
    /// Pieces of the target that do not touch others become bones' own between the levels.
    pub own_pieces: bool,
    /// Robust distance scale of the last level in median distances.
    pub robust_factor: f64,
    /// Spacing of the sampled pairs as a share of the level's cluster radius (0 = use all).
    pub pair_spacing: f64,
    /// Largest spacing of the sampled pairs, as a share of the template's diagonal.
    pub coarsest_pairs: f64,
    /// Starting poses that are tried, as shares of the way from the template's pose to the middle of
    /// the joints' ranges.
    pub pose_starts: Vec<f64>,
    /// At the end, joint points of two bones up to this many shift limits apart are joined in their
    /// middle instead of pulling the bones off the data (1 = pull the bones).
    pub seat_factor: f64,
    /// Find the rigid start by trying many rotations; otherwise the template starts as it lies.
    pub align: bool,
    /// Attempts after the plain one at most, where bones stay in doubt (surfaces only).
    pub further_attempts: usize,
    /// The target is of this unit and this side of the body, whatever it looks like.
    pub as_is: bool,
    /// How far an image is searched to each side of a vertex at most and at least, as shares of the
    /// template's diagonal. [G] 3.2.2: 20 mm to 5 mm for a hand.
    pub image_reach: [f64; 2],
}

impl Default for Options {
    fn default() -> Self {
        Self {
            levels: Levels::Automatic { smallest_in_edges: 4.0 },
            clustering: Clustering::Sampled { spacing: 0.5 },
            schedule: Schedule::EveryIteration,
            refine_bones: true,
            finest_in_edges: 1.2,
            separate_bones: false,
            use_joints: true,
            limits: Limits::default(),
            both_ways: true,
            scale_freedom: ScaleFreedom::PerAxis,
            scales: ScaleOptions::default(),
            tolerance: 1.5e-4,
            max_iterations: 30,
            momentum: 0.8,
            springs: vec![0.16, 0.08, 0.04, 0.02, 0.01, 0.005],
            joint_sweeps: 10,
            min_cosine: -0.2,
            last_min_cosine: 0.3,
            taken_factor: 0.5,
            own_pieces: true,
            robust_factor: 2.5,
            pair_spacing: 0.125,
            coarsest_pairs: 0.02,
            pose_starts: vec![0.0],
            seat_factor: 5.0,
            align: true,
            further_attempts: 3,
            as_is: false,
            image_reach: [0.1, 0.005],
        }
    }
}

impl Options {
    /// The loop as published: exact clusters, elastic iterations to rest before each update, every
    /// pair used.
    pub fn published() -> Self {
        Self {
            clustering: Clustering::Exact,
            schedule: Schedule::AfterElastic,
            refine_bones: false,
            momentum: 0.0,
            springs: Vec::new(),
            min_cosine: -1.0,
            taken_factor: 0.0,
            own_pieces: false,
            pair_spacing: 0.0,
            further_attempts: 0,
            ..Self::default()
        }
    }

    /// Radii of the levels for a template of this diagonal and mean edge.
    pub fn radii(&self, diagonal: f64, mean_edge: f64) -> Vec<f64> {
        match &self.levels {
            Levels::Radii(radii) => radii.clone(),
            Levels::Automatic { smallest_in_edges } => {
                let mut radii = vec![f64::INFINITY];
                let mut radius = diagonal / 3.0;
                while radius >= smallest_in_edges * mean_edge && radii.len() < 12 {
                    radii.push(radius);
                    radius /= 2.0;
                }
                radii
            }
        }
    }
}
