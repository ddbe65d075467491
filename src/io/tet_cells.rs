//! Tets as files hold them.

use std::path::Path;

use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TetMesh;

/// A tet mesh of what a file holds: at least one tet, no points that no tet uses.
pub(super) fn tet_mesh(points: &[Vec3], mut tets: Vec<[u32; 4]>, path: &Path) -> Result<TetMesh> {
    let wrong = |message: String| Error::parse(path, None, message);
    if tets.is_empty() {
        return Err(wrong("the file holds no tetrahedra".to_owned()));
    }
    let mut new_id = vec![u32::MAX; points.len()];
    let mut used = Vec::new();
    for (t, tet) in tets.iter_mut().enumerate() {
        for corner in tet {
            let count = points.len();
            let id = new_id.get_mut(*corner as usize).ok_or_else(|| {
                wrong(format!("tet {t} refers to a vertex that is not among the {count} there are"))
            })?;
            if *id == u32::MAX {
                *id = 0;
                used.push(*corner);
            }
        }
    }
    // File order, so that a mesh without loose points keeps its numbers.
    used.sort_unstable();
    for (new, &old) in used.iter().enumerate() {
        new_id[old as usize] = new as u32;
    }
    let tets = tets.into_iter().map(|tet| tet.map(|v| new_id[v as usize])).collect();
    let points = used.into_iter().map(|v| points[v as usize]).collect();
    TetMesh::new(points, tets).map_err(|e| wrong(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loose_points_go_and_the_others_keep_their_order() {
        let points: Vec<Vec3> = (0..6)
            .map(|i| Vec3::new(f64::from(i % 2), f64::from(i / 2 % 2), f64::from(i / 4)))
            .collect();
        let mesh = tet_mesh(&points, vec![[1, 4, 3, 2]], Path::new("a.veg")).unwrap();
        assert_eq!(mesh.points, points[1..5]);
        assert!(mesh.volume(0) > 0.0);
        let error = tet_mesh(&points, vec![[0, 1, 2, 6]], Path::new("a.veg")).unwrap_err();
        assert!(error.to_string().contains("tet 0 refers to a vertex that is not"), "{error}");
        let error = tet_mesh(&points, Vec::new(), Path::new("a.veg")).unwrap_err();
        assert_eq!(error.to_string(), "a.veg: the file holds no tetrahedra");
    }
}
