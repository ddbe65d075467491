//! One person's bones as seen: a surface of all bones together, or one surface per bone.

use std::collections::BTreeMap;

use super::areas::vertex_areas;
use super::image::{Appearance, ImageTarget};
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::components;
use crate::mesh::normals::{area_vectors, unit_or_zero, vertex_normals};
use crate::volume::Volume;

/// A surface with what the search for closest points needs.
#[derive(Clone, Debug)]
pub(super) struct SearchedSurface {
    pub(super) mesh: TriMesh,
    pub(super) search: ClosestPoints,
    pub(super) areas: Vec<f64>,
    pub(super) vertex_normals: Vec<Vec3>,
    pub(super) face_normals: Vec<Vec3>,
}

impl SearchedSurface {
    pub(super) fn new(mesh: TriMesh) -> Self {
        let faces = area_vectors(&mesh.points, &mesh.triangles);
        Self {
            search: ClosestPoints::new(&mesh.points, &mesh.triangles),
            areas: vertex_areas(&mesh.points, &mesh.triangles),
            vertex_normals: vertex_normals(mesh.points.len(), &mesh.triangles, &faces),
            face_normals: faces.iter().map(unit_or_zero).collect(),
            mesh,
        }
    }

    /// The triangles whose vertices `keep` holds.
    pub(super) fn part(&self, keep: impl Fn(u32) -> bool) -> Self {
        let mut number = vec![u32::MAX; self.mesh.points.len()];
        let mut points = Vec::new();
        for (v, point) in self.mesh.points.iter().enumerate() {
            if keep(v as u32) {
                number[v] = points.len() as u32;
                points.push(*point);
            }
        }
        let renumbered = self.mesh.triangles.iter().map(|t| t.map(|v| number[v as usize]));
        let triangles = renumbered.filter(|t| !t.contains(&u32::MAX)).collect();
        Self::new(TriMesh { points, triangles })
    }
}

/// What the skeleton is registered to.
#[derive(Clone, Debug)]
pub struct Target {
    /// Some surface came with its normals inwards and was turned.
    pub(super) turned: bool,
    /// Share of its area that lies far from all bones and was left out.
    pub(super) left_out: f64,
    /// One surface for all bones, or one (or none) for each bone.
    pub(super) surfaces: Vec<Option<SearchedSurface>>,
    pub(super) labelled: bool,
    /// An image in place of surfaces.
    pub(super) image: Option<ImageTarget>,
}

impl Target {
    /// One surface of the whole skeleton; bones may be fused. It may be open and noisy. A surface whose
    /// triangles face inwards is turned.
    pub fn whole(surface: TriMesh) -> Result<Self> {
        if surface.triangles.is_empty() {
            return Err(Error::invalid("the target surface has no triangles"));
        }
        let (surface, turned) = facing_outwards(surface);
        let surfaces = vec![Some(SearchedSurface::new(surface))];
        Ok(Self { turned, left_out: 0.0, surfaces, labelled: false, image: None })
    }

    /// A surface for each named bone; bones that are not named have no data of their own and follow
    /// their joints.
    pub fn per_bone(skeleton: &Skeleton, surfaces: Vec<(String, TriMesh)>) -> Result<Self> {
        let mut of_bone: Vec<Option<SearchedSurface>> = vec![None; skeleton.bones.len()];
        let mut turned = false;
        for (name, mesh) in surfaces {
            let b = skeleton.bone_index(&name).ok_or_else(|| {
                Error::invalid(format!(
                    "the target names a bone {name} that the skeleton does not have"
                ))
            })?;
            if mesh.triangles.is_empty() {
                return Err(Error::invalid(format!(
                    "the target surface of bone {name} has no triangles"
                )));
            }
            let (mesh, inwards) = facing_outwards(mesh);
            turned |= inwards;
            if of_bone[b].replace(SearchedSurface::new(mesh)).is_some() {
                return Err(Error::invalid(format!("the target gives bone {name} twice")));
            }
        }
        if of_bone.iter().all(Option::is_none) {
            return Err(Error::invalid("the target names no bone of the skeleton"));
        }
        Ok(Self { turned, left_out: 0.0, surfaces: of_bone, labelled: true, image: None })
    }

    /// An image of the person, in which the template already lies roughly on its bones (within the
    /// reach of the search, [`super::Options::image_reach`]). `appearance`: what the template shows
    /// in its reference image, made by the same protocol.
    pub fn image(skeleton: &Skeleton, volume: Volume, appearance: Appearance) -> Result<Self> {
        let image = Some(ImageTarget::new(skeleton, volume, appearance)?);
        Ok(Self { turned: false, left_out: 0.0, surfaces: Vec::new(), labelled: false, image })
    }

    /// Whether the target tells the bones apart.
    pub fn is_labelled(&self) -> bool {
        self.labelled
    }

    /// What was done to it, in sentences.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.turned {
            notes.push("the target's triangles face inwards; they were turned".to_owned());
        }
        if self.left_out > 0.0 {
            notes.push(format!(
                "{:.1} % of the target lie far from all bones; they were left out",
                100.0 * self.left_out
            ));
        }
        notes
    }

    /// All its surfaces as one.
    pub(super) fn joined(&self) -> SearchedSurface {
        let mut all = TriMesh::default();
        for surface in self.surfaces.iter().flatten() {
            let first = all.points.len() as u32;
            all.points.extend_from_slice(&surface.mesh.points);
            all.triangles.extend(surface.mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        SearchedSurface::new(all)
    }

    /// Its mirror image.
    pub(super) fn mirrored(&self) -> Self {
        let mirrored = |surface: &SearchedSurface| {
            let points = surface.mesh.points.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
            let triangles = surface.mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
            SearchedSurface::new(TriMesh { points, triangles })
        };
        let surfaces = self.surfaces.iter().map(|s| s.as_ref().map(mirrored)).collect();
        Self { surfaces, ..self.clone() }
    }
}

/// The surface with its normals outwards, and whether it was turned: by the volume that its pieces
/// enclose, each seen from its own middle, so that open pieces count by the way they bulge. Vertices
/// of the same place are one there.
fn facing_outwards(mut mesh: TriMesh) -> (TriMesh, bool) {
    let mut first_at: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let place = |p: &Vec3| [p.x, p.y, p.z].map(f64::to_bits);
    let points = mesh.points.iter().enumerate();
    let first: Vec<u32> =
        points.map(|(v, p)| *first_at.entry(place(p)).or_insert(v as u32)).collect();
    let joined: Vec<[u32; 3]> =
        mesh.triangles.iter().map(|t| t.map(|v| first[v as usize])).collect();
    let piece = components(mesh.points.len(), &joined);
    let count = piece.iter().max().map_or(0, |&last| last as usize + 1);
    let mut middle = vec![(Vec3::zeros(), 0.0); count];
    for (triangle, &piece) in mesh.triangles.iter().zip(&piece) {
        let (sum, corners) = &mut middle[piece as usize];
        *sum += triangle.iter().map(|&v| mesh.points[v as usize]).sum::<Vec3>();
        *corners += 3.0;
    }
    let volume: f64 = (0..mesh.triangles.len())
        .map(|t| {
            let (sum, corners) = middle[piece[t] as usize];
            let [a, b, c] = mesh.corners(t).map(|p| p - sum / corners);
            a.dot(&b.cross(&c))
        })
        .sum();
    if volume < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    (mesh, volume < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::skeleton::tests::block;

    #[test]
    fn surfaces_that_face_inwards_are_turned_open_ones_too() {
        let mut mesh = block(Vec3::new(30.0, 0.0, 0.0), Vec3::new(4.0, 2.0, 1.0), 4);
        for _ in 0..2 {
            assert!(!facing_outwards(mesh.clone()).1);
            let inwards: Vec<_> = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
            let inwards = TriMesh { points: mesh.points.clone(), triangles: inwards };
            let (outwards, turned) = facing_outwards(inwards);
            assert!(turned && (outwards.volume() - mesh.volume()).abs() < 1e-9);
            // The second round: without one of its ends.
            mesh.triangles.drain(..mesh.triangles.len() / 6);
        }
    }
}
