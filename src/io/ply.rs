//! PLY surfaces and point sets, text and binary, through the `ply-rs-bw` crate.

use std::path::{Path, PathBuf};

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Header, Ply, Property, PropertyDef,
    PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;

use super::write_beside;
use crate::error::{Error, Result, Shown};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// A PLY file with all its elements and properties, which can be written back with moved points.
#[derive(Clone, Debug)]
pub struct PlyDocument {
    path: PathBuf,
    ply: Ply<DefaultElement>,
    points: Vec<Vec3>,
}

impl PlyDocument {
    /// Reads a PLY file in any encoding.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let wrong = |e: &dyn std::fmt::Display| {
            // The crate's message spans lines and repeats the text it could not read.
            let words = e.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
            let message: String = words.chars().take(200).collect();
            Error::parse(path, None, format!("not a good PLY file: {message}"))
        };
        let parser = Parser::<DefaultElement>::new();
        let mut reader = Reader::new(bytes);
        let header = parser.read_header(&mut reader).map_err(|e| wrong(&e))?;
        check_counts(&header, bytes.len(), path)?;
        let payload = parser.read_payload(&mut reader, &header).map_err(|e| wrong(&e))?;
        let mut ply = Ply::new();
        ply.header = header;
        ply.payload = payload;
        let points = read_points(&ply, path)?;
        Ok(Self { path: path.to_path_buf(), ply, points })
    }

    /// The vertices.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// A scalar property of the vertices, where the file has it.
    pub fn vertex_scalars(&self, name: &str) -> Option<Vec<f64>> {
        let vertices = self.ply.payload.get("vertex")?;
        vertices.iter().map(|vertex| scalar(vertex.get(name)?)).collect()
    }

    /// The surface, each polygon as a fan of triangles; no triangles if the file has points only.
    pub fn mesh(&self) -> Result<TriMesh> {
        let mut triangles = Vec::new();
        for (f, face) in self.ply.payload.get("face").into_iter().flatten().enumerate() {
            let list = face.get("vertex_indices").or_else(|| face.get("vertex_index"));
            let corners = list.and_then(Property::to_u32_list).ok_or_else(|| {
                let message = format!("face {f} has no list 'vertex_indices' of whole numbers");
                Error::parse(&self.path, None, message)
            })?;
            for pair in corners.get(1..).unwrap_or_default().windows(2) {
                triangles.push([corners[0], pair[0], pair[1]]);
            }
        }
        TriMesh::new(self.points.clone(), triangles)
            .map_err(|e| Error::parse(&self.path, None, e.to_string()))
    }

    /// Writes the file with moved points and, where it has them, recomputed vertex normals; all
    /// other elements, the encoding and the precision of the coordinates stay.
    pub fn write_with_points(&self, path: &Path, points: &[Vec3]) -> Result<()> {
        let count = self.points.len();
        if points.len() != count {
            return Err(Error::invalid(format!(
                "{} has {count} vertices, but {} points are to be written into it",
                self.path.shown(),
                points.len()
            )));
        }
        let mut moved = self.mesh()?;
        moved.points = points.to_vec();
        let normals = moved.vertex_normals();
        let mut ply = self.ply.clone();
        for (v, vertex) in ply.payload.get_mut("vertex").into_iter().flatten().enumerate() {
            let (p, n) = (points[v], normals[v]);
            for (name, value) in ["x", "y", "z"].into_iter().zip([p.x, p.y, p.z]) {
                set_scalar(vertex, name, value);
            }
            for (name, value) in ["nx", "ny", "nz"].into_iter().zip([n.x, n.y, n.z]) {
                set_scalar(vertex, name, value);
            }
        }
        write(path, &mut ply)
    }
}

/// Writes a little-endian PLY file: positions (double), `scalars` per vertex by name (float), and
/// faces. Fails if an array of scalars has not one value per vertex.
pub fn write_ply(path: &Path, mesh: &TriMesh, scalars: &[(&str, &[f64])]) -> Result<()> {
    let mut ply = Ply::<DefaultElement>::new();
    ply.header.encoding = Encoding::BinaryLittleEndian;
    let mut vertex = ElementDef::new("vertex".to_owned());
    for name in ["x", "y", "z"] {
        vertex
            .properties
            .add(PropertyDef::new(name.to_owned(), PropertyType::Scalar(ScalarType::Double)));
    }
    for (name, values) in scalars {
        if values.len() != mesh.points.len() {
            return Err(Error::invalid(format!(
                "'{name}' has {} values for {} vertices",
                values.len(),
                mesh.points.len()
            )));
        }
        let data_type = PropertyType::Scalar(ScalarType::Float);
        vertex.properties.add(PropertyDef::new((*name).to_owned(), data_type));
    }
    let mut face = ElementDef::new("face".to_owned());
    let list = PropertyType::List(ScalarType::UChar, ScalarType::Int);
    face.properties.add(PropertyDef::new("vertex_indices".to_owned(), list));
    ply.header.elements.add(vertex);
    ply.header.elements.add(face);
    let vertices = mesh.points.iter().enumerate().map(|(v, p)| {
        let position = ["x", "y", "z"].into_iter().zip([p.x, p.y, p.z]);
        let position = position.map(|(name, c)| (name.to_owned(), Property::Double(c)));
        let own = scalars.iter().map(|(n, s)| ((*n).to_owned(), Property::Float(s[v] as f32)));
        position.chain(own).collect()
    });
    ply.payload.insert("vertex".to_owned(), vertices.collect());
    let faces = mesh.triangles.iter().map(|t| {
        let corners = Property::ListInt(t.iter().map(|&v| v as i32).collect());
        std::iter::once(("vertex_indices".to_owned(), corners)).collect()
    });
    ply.payload.insert("face".to_owned(), faces.collect());
    write(path, &mut ply)
}

fn write(path: &Path, ply: &mut Ply<DefaultElement>) -> Result<()> {
    write_beside(path, |mut out| Writer::new().write_ply(&mut out, ply).map(|_| ()))
}

/// Refuses counts that the file cannot hold, before anything is made for them. Each element takes
/// a byte or more, unless it has no properties.
fn check_counts(header: &Header, bytes: usize, path: &Path) -> Result<()> {
    for (name, element) in &header.elements {
        if element.count > bytes || (element.properties.is_empty() && element.count > 0) {
            return Err(Error::parse(
                path,
                None,
                format!(
                    "the header promises {} elements '{name}', more than the file holds",
                    element.count
                ),
            ));
        }
    }
    Ok(())
}

fn read_points(ply: &Ply<DefaultElement>, path: &Path) -> Result<Vec<Vec3>> {
    let vertices = ply
        .payload
        .get("vertex")
        .ok_or_else(|| Error::parse(path, None, "the file has no element 'vertex'"))?;
    let coordinate = |v: usize, name: &str| match vertices[v].get(name).and_then(scalar) {
        Some(value) if value.is_finite() => Ok(value),
        Some(value) => Err(Error::parse(
            path,
            None,
            format!("vertex {v}: {name} is {value}, not a finite number"),
        )),
        None => Err(Error::parse(path, None, format!("vertex {v} has no number '{name}'"))),
    };
    (0..vertices.len())
        .map(|v| Ok(Vec3::new(coordinate(v, "x")?, coordinate(v, "y")?, coordinate(v, "z")?)))
        .collect()
}

fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(value) => value.into(),
        Property::UChar(value) => value.into(),
        Property::Short(value) => value.into(),
        Property::UShort(value) => value.into(),
        Property::Int(value) => value.into(),
        Property::UInt(value) => value.into(),
        Property::Float(value) => value.into(),
        Property::Double(value) => value,
        _ => return None,
    })
}

/// Sets a floating point property that is there.
fn set_scalar(vertex: &mut DefaultElement, name: &str, value: f64) {
    match vertex.get_mut(name) {
        Some(Property::Float(stored)) => *stored = value as f32,
        Some(Property::Double(stored)) => *stored = value,
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\n\
        property float x\nproperty float y\nproperty double z\nproperty float nz\n\
        property uchar red\nelement face 1\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0 0.5 7\n1 0 0 0 8\n1 1 0 0 9\n0 1 0 0 10\n4 0 1 2 3\n";

    fn parse(bytes: &[u8]) -> Result<PlyDocument> {
        PlyDocument::parse(bytes, Path::new("a.ply"))
    }

    fn through_file(name: &str, write: impl Fn(&Path) -> Result<()>) -> PlyDocument {
        let path = std::env::temp_dir().join(format!("{name}_{}.ply", std::process::id()));
        write(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        parse(&bytes).unwrap()
    }

    #[test]
    fn a_template_keeps_what_is_not_a_position_or_normal() {
        let document = parse(TEXT.as_bytes()).unwrap();
        assert_eq!(document.mesh().unwrap().triangles, [[0, 1, 2], [0, 2, 3]]);
        let moved: Vec<Vec3> = document.points().iter().map(|p| -p / 3.0).collect();
        let again = through_file("moulage_ply", |p| document.write_with_points(p, &moved));
        assert_eq!(again.vertex_scalars("red").unwrap(), [7.0, 8.0, 9.0, 10.0]);
        assert_eq!(again.vertex_scalars("nz").unwrap(), [1.0; 4]);
        assert_eq!(again.ply.header.comments, ["by hand"]);
        let third = f64::from(-1.0_f32 / 3.0);
        assert_eq!(again.points()[1], Vec3::new(third, 0.0, 0.0));
    }

    #[test]
    fn a_result_carries_its_scalars_and_exact_positions() {
        let mut mesh = parse(TEXT.as_bytes()).unwrap().mesh().unwrap();
        mesh.points[1].x = 0.1;
        let stretch = [1.0, 2.0, 3.0, 4.0];
        let again =
            through_file("moulage_scalars", |p| write_ply(p, &mesh, &[("stretch", &stretch)]));
        assert_eq!(again.mesh().unwrap(), mesh);
        assert_eq!(again.vertex_scalars("stretch").unwrap(), stretch);
        let wrong = write_ply(Path::new("never.ply"), &mesh, &[("stretch", &[1.0])]);
        assert!(wrong.unwrap_err().to_string().contains("1 values for 4 vertices"));
    }

    #[test]
    fn broken_files_are_refused_in_words() {
        for (from, to, expected) in [
            ("vertex 4", "vertex 4000000000", "promises 4000000000 elements 'vertex'"),
            ("vertex 4", "vertex 6", "not a good PLY file"),
            ("0 1 0 0 10", "1e99 1 0 0 10", "vertex 3: x is inf"),
            ("4 0 1 2 3", "4 0 1 2 4", "vertex 4, but there are only 4"),
            ("4 0 1 2 3", "4 0 1 2 -1", "face 0 has no list"),
            ("4 0 1 2 3", "400 0 1 2 3", "not a good PLY file"),
            ("element vertex", "element point", "no element 'vertex'"),
            ("float x", "float u", "vertex 0 has no number 'x'"),
        ] {
            let text = TEXT.replace(from, to);
            let result = parse(text.as_bytes()).and_then(|document| document.mesh());
            let message = result.unwrap_err().to_string();
            assert!(message.contains(expected), "{to}: {message}");
            assert_eq!(message.lines().count(), 1);
        }
    }
}
