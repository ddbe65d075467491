//! The bodies and obstacles of a separation, and their surfaces in the present shape.

use crate::error::{Error, Result};
use crate::fem::MaterialPoint;
use crate::locate::{Embedding, Solid};
use crate::math::Vec3;
use crate::mesh::{TetMesh, TriMesh, boundary_triangles};

/// A soft body in its present shape.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name for errors and reports.
    pub name: String,
    /// Its tets in their present shape, none inverted.
    pub tets: TetMesh,
    /// Each vertex of its surface in the tets.
    pub embedding: Embedding,
    /// Triangles of its surface, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Points of the person's surface that this body meets: its surface is held there as far as
    /// contact allows.
    pub markers: Vec<Vec3>,
}

impl Body {
    /// A body whose surface is the boundary of its tets.
    pub fn from_tets(name: impl Into<String>, tets: TetMesh) -> Result<Self> {
        let boundary = boundary_triangles(&tets);
        let mut used: Vec<u32> = boundary.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let embedding = Embedding::at_vertices(&tets, &used)?;
        let place = |v: u32| used.binary_search(&v).expect("used holds all of them") as u32;
        let triangles = boundary.iter().map(|t| t.map(place)).collect();
        Ok(Self { name: name.into(), tets, embedding, triangles, markers: Vec::new() })
    }

    /// A body whose surface lies in its tets, both in the present shape.
    pub fn with_surface(name: impl Into<String>, tets: TetMesh, surface: &TriMesh) -> Result<Self> {
        let embedding = Embedding::new(&tets, &surface.points)?;
        let triangles = surface.triangles.clone();
        Ok(Self { name: name.into(), tets, embedding, triangles, markers: Vec::new() })
    }

    /// Surface vertices when the tets' vertices are at `points`.
    pub fn surface_points(&self, points: &[Vec3]) -> Vec<Vec3> {
        self.embedding.apply(points)
    }

    pub(super) fn check(&self) -> Result<()> {
        if self.triangles.is_empty() || self.tets.tets.is_empty() {
            return Err(Error::invalid(format!("'{}' has no triangles or no tets", self.name)));
        }
        match (0..self.tets.tets.len()).find(|&t| self.tets.volume(t) <= 0.0) {
            Some(t) => Err(Error::invalid(format!(
                "tet {t} of '{}' is inverted; reshape it with a larger tolerance before it is separated",
                self.name
            ))),
            None => Ok(()),
        }
    }
}

/// Something that does not move, such as a bone.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Name for errors and reports.
    pub name: String,
    /// Its surface.
    pub surface: TriMesh,
}

/// One surface in the present shape, ready for questions. Bodies come first, then obstacles.
pub(super) struct Skin<'a> {
    pub points: Vec<Vec3>,
    pub triangles: &'a [[u32; 3]],
    /// The body that it belongs to; None for an obstacle.
    pub body: Option<usize>,
    pub solid: Solid,
}

impl<'a> Skin<'a> {
    pub fn new(points: Vec<Vec3>, triangles: &'a [[u32; 3]], body: Option<usize>) -> Self {
        Self { solid: Solid::new(&points, triangles), points, triangles, body }
    }

    /// All surfaces, the bodies' tets being at `points`.
    pub fn all(bodies: &'a [Body], points: &[Vec<Vec3>], obstacles: &'a [Obstacle]) -> Vec<Self> {
        let soft = bodies.iter().zip(points).enumerate();
        let soft =
            soft.map(|(b, (body, x))| Self::new(body.surface_points(x), &body.triangles, Some(b)));
        let hard = obstacles.iter();
        let hard = hard.map(|o| Self::new(o.surface.points.clone(), &o.surface.triangles, None));
        soft.chain(hard).collect()
    }

    /// Whether the boxes around two surfaces come within `margin`; obstacles do not meet.
    pub fn may_meet(&self, other: &Self, margin: f64) -> bool {
        (self.body.is_some() || other.body.is_some()) && self.solid.boxes_meet(&other.solid, margin)
    }

    pub fn corners(&self, t: u32) -> [Vec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    /// Unit normal of a triangle; zero without area.
    pub fn normal(&self, t: u32) -> Vec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
    }
}

/// Pairs of surfaces that may touch, lower number first.
pub(super) fn near_pairs(skins: &[Skin], margin: f64) -> Vec<(usize, usize)> {
    let all = (0..skins.len()).flat_map(|i| (i + 1..skins.len()).map(move |j| (i, j)));
    all.filter(|&(i, j)| skins[i].may_meet(&skins[j], margin)).collect()
}

/// A point of a body's surface as a combination of tet vertices.
pub(super) fn surface_point(body: &Body, triangle: u32, barycentric: &[f64; 3]) -> MaterialPoint {
    let mut entries: Vec<(u32, f64)> = Vec::with_capacity(12);
    for (&v, share) in body.triangles[triangle as usize].iter().zip(barycentric) {
        let corners = body.embedding.vertices[v as usize].iter();
        for (&w, weight) in corners.zip(body.embedding.weights[v as usize]) {
            match entries.iter_mut().find(|(vertex, _)| *vertex == w) {
                Some((_, sum)) => *sum += share * weight,
                None => entries.push((w, share * weight)),
            }
        }
    }
    entries.retain(|(_, weight)| *weight != 0.0);
    MaterialPoint(entries)
}
