//! OBJ text with moved points and turned normals, everything else byte for byte.

use std::ops::Range;
use std::path::Path;

use nalgebra::Rotation3;

use super::obj::ObjDocument;
use super::write_beside;
use crate::error::{Error, Result, Shown};
use crate::math::Vec3;

/// A written normal within this cosine (10 degrees) of its corners' mean normal is taken as
/// computed from the shape; others are the artist's own and are turned along.
const COMPUTED_NORMAL_COSINE: f64 = 0.985;

impl ObjDocument {
    /// Writes the file with `points` in place of its own (see [`ObjDocument::text_with_points`]).
    pub fn write_with_points(&self, path: &Path, points: &[Vec3]) -> Result<()> {
        let text = self.text_with_points(points)?;
        write_beside(path, |out| out.write_all(&text))
    }

    /// The text with the numbers of moved `v` lines replaced (shortest form that reads back to the
    /// same bits; further columns stay) and the `vn` lines that moved faces use recomputed.
    ///
    /// A `vn` line becomes the mean of the angle-weighted face normals at the corners that name it,
    /// so hard edges stay hard; when vertices share a line they get one mean normal. A line
    /// that was not computed from the shape is turned as that mean turns. Fails if the number of points
    /// differs from the file's or a point is not finite.
    pub fn text_with_points(&self, points: &[Vec3]) -> Result<Vec<u8>> {
        if points.len() != self.points.len() {
            return Err(Error::invalid(format!(
                "{} has {} vertices, but {} points are to be written into it",
                self.path.shown(),
                self.points.len(),
                points.len()
            )));
        }
        if let Some(v) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::invalid(format!("vertex {v} to be written is not finite")));
        }
        let mut changes: Vec<(Range<usize>, String)> = self
            .point_spans
            .iter()
            .zip(self.points.iter().zip(points))
            .filter(|(_, (old, new))| old != new)
            .map(|(span, (_, p))| (span.clone(), format!("{:?} {:?} {:?}", p.x, p.y, p.z)))
            .collect();
        for (normal, new) in self.turned_normals(points).into_iter().enumerate() {
            if let Some(n) = new {
                let text = format!("{:.6} {:.6} {:.6}", n.x, n.y, n.z);
                changes.push((self.normal_spans[normal].clone(), text));
            }
        }
        changes.sort_by_key(|(span, _)| span.start);
        Ok(replace(&self.text, &changes))
    }

    /// The new value of each `vn` line that has to change.
    fn turned_normals(&self, points: &[Vec3]) -> Vec<Option<Vec3>> {
        let mut before = vec![Vec3::zeros(); self.normals.len()];
        let mut after = before.clone();
        let mut touched = vec![false; self.normals.len()];
        for polygon in self.polygons() {
            if polygon.iter().all(|corner| corner.normal.is_none()) {
                continue;
            }
            let ids: Vec<usize> = polygon.iter().map(|corner| corner.vertex as usize).collect();
            let moved = ids.iter().any(|&v| self.points[v] != points[v]);
            let (old, new) = (corner_normals(&self.points, &ids), corner_normals(points, &ids));
            for (c, corner) in polygon.iter().enumerate() {
                if let Some(n) = corner.normal.map(|n| n as usize) {
                    before[n] += old[c];
                    after[n] += new[c];
                    touched[n] |= moved;
                }
            }
        }
        (0..self.normals.len())
            .map(|n| touched[n].then(|| turn(self.normals[n], before[n], after[n])).flatten())
            .collect()
    }
}

/// The normal that `written` becomes; none where the faces around it have no area.
fn turn(written: Vec3, before: Vec3, after: Vec3) -> Option<Vec3> {
    let tiny = f64::MIN_POSITIVE;
    let after = after.try_normalize(tiny)?;
    let (Some(written), Some(before)) = (written.try_normalize(tiny), before.try_normalize(tiny))
    else {
        return Some(after);
    };
    if written.dot(&before) > COMPUTED_NORMAL_COSINE {
        return Some(after);
    }
    Rotation3::rotation_between(&before, &after).map(|rotation| rotation * written)
}

/// Polygon normal (Newell's, so that bent polygons have one too) times the angle at each corner.
fn corner_normals(points: &[Vec3], ids: &[usize]) -> Vec<Vec3> {
    let count = ids.len();
    let at = |c: usize| points[ids[c % count]];
    // Relative to the first corner: a polygon far from the origin loses no digits.
    let newell: Vec3 = (0..count).map(|c| (at(c) - at(0)).cross(&(at(c + 1) - at(0)))).sum();
    let normal = newell.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
    (0..count).map(|c| normal * (at(c + 1) - at(c)).angle(&(at(c + count - 1) - at(c)))).collect()
}

/// `text` with byte ranges (sorted, not overlapping) replaced.
fn replace(text: &[u8], changes: &[(Range<usize>, String)]) -> Vec<u8> {
    let mut out = Vec::with_capacity(text.len() + 16 * changes.len());
    let mut at = 0;
    for (span, new) in changes {
        out.extend_from_slice(&text[at..span.start]);
        out.extend_from_slice(new.as_bytes());
        at = span.end;
    }
    out.extend_from_slice(&text[at..]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE_SIDE: &str = "# two faces meeting at a hard edge\r\no corner\r\n\
        v 0 0 0 0.5 0.5 0.5\r\nv  1.0 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nv 0 0 1\r\nv 1 0 1\r\n\
        vt 0 0\r\nvn 0 0 1\r\nvn 0 1 0\r\ng a\r\nusemtl skin\r\n\
        f 1/1/1 2/1/1 3/1/1 4/1/1\r\nf 1//2 5//2 6//2 2//2\r\n# end";

    fn document() -> ObjDocument {
        ObjDocument::parse(CUBE_SIDE.as_bytes().to_vec(), Path::new("a.obj")).unwrap()
    }

    #[test]
    fn unmoved_points_give_the_same_bytes() {
        let document = document();
        let text = document.text_with_points(document.points()).unwrap();
        assert_eq!(text, CUBE_SIDE.as_bytes());
    }

    #[test]
    fn only_v_and_vn_lines_change_and_the_points_read_back_to_the_same_bits() {
        let document = document();
        // A quarter turn about x, plus a shift with awkward digits.
        let moved: Vec<Vec3> =
            document.points().iter().map(|p| Vec3::new(p.x + 0.1 + 0.2, -p.z, p.y) / 3.0).collect();
        let text = document.text_with_points(&moved).unwrap();
        let again = ObjDocument::parse(text.clone(), Path::new("a.obj")).unwrap();
        assert_eq!(again.points(), moved);
        assert_eq!(again.normals, [Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)]);
        let text = String::from_utf8(text).unwrap();
        assert_eq!(text.lines().count(), CUBE_SIDE.lines().count());
        for (new, old) in text.split("\r\n").zip(CUBE_SIDE.split("\r\n")) {
            if !old.starts_with("v ") && !old.starts_with("vn ") {
                assert_eq!(new, old);
            }
        }
        assert!(text.lines().nth(2).unwrap().ends_with(" 0.5 0.5 0.5"));
    }

    #[test]
    fn a_normal_of_the_artist_turns_with_the_shape() {
        let text = CUBE_SIDE.replace("vn 0 0 1\r", "vn 0 0.6 -0.8\r");
        let document = ObjDocument::parse(text.into_bytes(), Path::new("a.obj")).unwrap();
        let moved: Vec<Vec3> =
            document.points().iter().map(|p| Vec3::new(p.x, -p.z, p.y)).collect();
        let text = document.text_with_points(&moved).unwrap();
        let again = ObjDocument::parse(text, Path::new("a.obj")).unwrap();
        assert_eq!(again.normals[0], Vec3::new(0.0, 0.8, 0.6));
    }

    #[test]
    fn wrong_counts_and_values_are_refused() {
        let document = document();
        let error = document.text_with_points(&[]).unwrap_err();
        assert!(error.to_string().contains("has 6 vertices, but 0 points"), "{error}");
        let mut points = document.points().to_vec();
        points[3].y = f64::NAN;
        let error = document.text_with_points(&points).unwrap_err();
        assert!(error.to_string().contains("vertex 3"), "{error}");
    }
}
