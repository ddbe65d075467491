//! TetGen's `.node` and `.ele` files.

use std::path::Path;

use super::tet_cells::tet_mesh;
use super::text::{Place, data_lines, decode};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TetMesh;

/// Reads a mesh numbered from 0 or 1. Of ten-node tets the four corners are taken; attributes and
/// boundary marks are left out.
pub fn parse_tetgen(
    node_bytes: &[u8],
    node_path: &Path,
    element_bytes: &[u8],
    element_path: &Path,
) -> Result<TetMesh> {
    let (first, points) = parse_nodes(&decode(node_bytes), node_path)?;
    let tets = parse_elements(&decode(element_bytes), element_path, first)?;
    tet_mesh(&points, tets, element_path)
}

type Lines<'a> = Box<dyn Iterator<Item = (Place<'a>, &'a str)> + 'a>;

/// The first line's numbers, and the lines after it.
fn header<'a>(text: &'a str, path: &'a Path) -> Result<(Place<'a>, Vec<usize>, Lines<'a>)> {
    let mut lines = data_lines(text, path);
    let (place, line) =
        lines.next().ok_or_else(|| Error::parse(path, None, "the file is empty"))?;
    let numbers = line.split_whitespace().map(|token| place.index(token, "a count"));
    Ok((place, numbers.collect::<Result<_>>()?, Box::new(lines)))
}

/// The number of the first point (0 or 1), and the points.
fn parse_nodes(text: &str, path: &Path) -> Result<(usize, Vec<Vec3>)> {
    let (place, counts, lines) = header(text, path)?;
    if counts.get(1).is_some_and(|&dimension| dimension != 3) {
        return Err(place.error("the points must have three dimensions"));
    }
    let mut first = None;
    let mut points = Vec::new();
    for (place, line) in lines {
        let mut tokens = line.split_whitespace();
        let number = place.index(place.next(&mut tokens, "the point's number")?, "the number")?;
        let base = *first.get_or_insert(number);
        if base > 1 || number != base + points.len() {
            return Err(place.error(format!("point {number} is out of order")));
        }
        points.push(place.position(&mut tokens)?);
    }
    check_count(&counts, points.len(), "points", place)?;
    Ok((first.unwrap_or(0), points))
}

fn parse_elements(text: &str, path: &Path, first: usize) -> Result<Vec<[u32; 4]>> {
    let (place, counts, lines) = header(text, path)?;
    if counts.get(1).is_some_and(|&corners| corners != 4 && corners != 10) {
        return Err(place.error("the elements must be tets of 4 or 10 nodes"));
    }
    let mut tets = Vec::new();
    for (place, line) in lines {
        let mut tokens = line.split_whitespace().skip(1);
        let mut tet = [0; 4];
        for corner in &mut tet {
            let number = place.index(place.next(&mut tokens, "the fourth corner")?, "a corner")?;
            *corner = number
                .checked_sub(first)
                .and_then(|id| u32::try_from(id).ok())
                .ok_or_else(|| place.error(format!("there is no point {number}")))?;
        }
        tets.push(tet);
    }
    check_count(&counts, tets.len(), "tets", place)?;
    Ok(tets)
}

fn check_count(counts: &[usize], found: usize, what: &str, place: Place) -> Result<()> {
    match counts.first() {
        Some(&promised) if promised != found => {
            Err(place.error(format!("{promised} {what} are promised, but the file has {found}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: &str =
        "# by hand\n4 3 0 1\n1 0 0 0 1\n2 1 0 0 1 # x\n3 0 1 0 1\n4 0 0 1 1\n# end\n";
    const ELEMENTS: &str = "1 4 1\n1 1 2 3 4 7\n";

    fn parse(nodes: &str, elements: &str) -> Result<TetMesh> {
        let (a, b) = (Path::new("a.node"), Path::new("a.ele"));
        parse_tetgen(nodes.as_bytes(), a, elements.as_bytes(), b)
    }

    #[test]
    fn numbers_from_zero_and_one_give_the_same_mesh() {
        let mesh = parse(NODES, ELEMENTS).unwrap();
        assert_eq!(mesh.tets, [[0, 1, 2, 3]]);
        let nodes = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
        assert_eq!(parse(nodes, "1 4 0\n0 0 1 2 3\n").unwrap(), mesh);
    }

    #[test]
    fn errors_name_file_and_line() {
        for (from, to, expected) in [
            ("4 3 0 1", "5 3 0 1", "a.node, line 2: 5 points are promised, but the file has 4"),
            ("4 3 0 1", "4 2 0 1", "must have three dimensions"),
            ("3 0 1 0 1", "7 0 1 0 1", "a.node, line 5: point 7 is out of order"),
            ("3 0 1 0 1", "3 0 inf 0 1", "a.node, line 5: y is inf"),
        ] {
            let message = parse(&NODES.replace(from, to), ELEMENTS).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
        for (from, to, expected) in [
            ("1 1 2 3 4 7", "1 1 2 3", "a.ele, line 2: the line ends before the fourth corner"),
            ("1 1 2 3 4 7", "1 0 2 3 4", "there is no point 0"),
            ("1 1 2 3 4 7", "1 1 2 3 5", "a.ele: tet 0 refers to a vertex that is not"),
            ("1 1 2 3 4 7", "1 1 2 3 3", "a.ele: tet 0 has no volume"),
            ("1 4 1", "99999999999 4 1", "99999999999 tets are promised"),
            ("1 4 1", "1 3 1", "must be tets of 4 or 10 nodes"),
        ] {
            let message = parse(NODES, &ELEMENTS.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
