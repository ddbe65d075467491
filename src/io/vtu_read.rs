//! VTK unstructured grids, `.vtu`: text, inline and appended data, with or without zlib.
//!
//! The XML is read by `roxmltree`, the rest here: the crate for the whole format (`vtkio`) has had
//! only release candidates for some years.

use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use roxmltree::{Document, Node};

use super::bytes::Bytes;
use super::tet_cells::tet_mesh;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TetMesh;

/// VTK's numbers of the tets with 4 corners and with 10 nodes.
const TET_TYPES: [f64; 2] = [10.0, 24.0];
/// No zlib stream grows more than this when unpacked.
const MAX_GROWTH: u64 = 1100;

/// Reads the points and the tets of all pieces; other cells and data arrays are left out.
pub fn parse_vtu(bytes: &[u8], path: &Path) -> Result<TetMesh> {
    let (xml, raw) = split_raw(bytes);
    let text = String::from_utf8_lossy(&xml);
    let document = Document::parse(&text).map_err(|e| {
        Error::parse(path, e.pos().row as usize, format!("not a good .vtu file: {e}"))
    })?;
    let root = document.root_element();
    let wrong = |message: &str| Error::parse(path, None, message);
    if root.attribute("type") != Some("UnstructuredGrid") {
        return Err(wrong("not an unstructured grid of VTK (its <VTKFile> must say so)"));
    }
    let file = File::new(root, raw.as_deref()).map_err(|what| wrong(&what))?;
    let (mut points, mut tets) = (Vec::new(), Vec::new());
    for piece in root.descendants().filter(|node| node.has_tag_name("Piece")) {
        file.add_piece(piece, &mut points, &mut tets).map_err(|what| wrong(&what))?;
    }
    tet_mesh(&points, tets, path)
}

/// Raw appended data is no XML: the bytes between its `_` and the closing tag are taken out.
fn split_raw(bytes: &[u8]) -> (Vec<u8>, Option<Vec<u8>>) {
    let find = |what: &[u8], from: usize| {
        bytes[from..].windows(what.len()).position(|w| w == what).map(|at| from + at)
    };
    let Some(start) = find(b"<AppendedData", 0) else { return (bytes.to_vec(), None) };
    let Some(open) = find(b"_", start) else { return (bytes.to_vec(), None) };
    let closing = b"</AppendedData>";
    let Some(close) = bytes.windows(closing.len()).rposition(|w| w == closing) else {
        return (bytes.to_vec(), None);
    };
    if close <= open {
        return (bytes.to_vec(), None);
    }
    let xml = [&bytes[..open], &bytes[close..]].concat();
    (xml, Some(bytes[open + 1..close].to_vec()))
}

struct File<'a> {
    big_endian: bool,
    header_size: usize,
    compressed: bool,
    appended: Option<&'a [u8]>,
    appended_is_text: bool,
}

impl<'a> File<'a> {
    fn new(root: Node, appended: Option<&'a [u8]>) -> Result<Self, String> {
        let compressed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(format!(
                    "compression by {other} is not read; save with zlib or without compression"
                ));
            }
        };
        let section = root.children().find(|node| node.has_tag_name("AppendedData"));
        Ok(Self {
            big_endian: root.attribute("byte_order") == Some("BigEndian"),
            header_size: if root.attribute("header_type") == Some("UInt64") { 8 } else { 4 },
            compressed,
            appended,
            appended_is_text: section.and_then(|s| s.attribute("encoding")) == Some("base64"),
        })
    }

    fn add_piece(
        &self,
        piece: Node,
        points: &mut Vec<Vec3>,
        tets: &mut Vec<[u32; 4]>,
    ) -> Result<(), String> {
        let first = points.len();
        let coordinates = self.array(piece, "Points", None)?;
        if coordinates.len() % 3 != 0 {
            return Err("the number of coordinates is not a multiple of three".to_owned());
        }
        points.extend(coordinates.chunks_exact(3).map(Vec3::from_column_slice));
        let connectivity = self.array(piece, "Cells", Some("connectivity"))?;
        let offsets = self.array(piece, "Cells", Some("offsets"))?;
        let types = self.array(piece, "Cells", Some("types"))?;
        let mut start = 0;
        for (cell, (&end, kind)) in offsets.iter().zip(&types).enumerate() {
            let range = start..end as usize;
            let corners = connectivity.get(range);
            let corners =
                corners.ok_or_else(|| format!("cell {cell} goes beyond the connectivity array"))?;
            if TET_TYPES.contains(kind) {
                let four = corners.first_chunk::<4>();
                let four = four.ok_or_else(|| format!("cell {cell} has too few corners"))?;
                tets.push(four.map(|v| (v + first as f64) as u32));
            }
            start = end as usize;
        }
        Ok(())
    }

    fn array(&self, piece: Node, group: &str, name: Option<&str>) -> Result<Vec<f64>, String> {
        let node = piece
            .children()
            .filter(|node| node.has_tag_name(group))
            .flat_map(|node| node.children())
            .find(|node| {
                node.has_tag_name("DataArray") && (name.is_none() || node.attribute("Name") == name)
            });
        let what = name.unwrap_or(group);
        let node = node.ok_or_else(|| format!("there is no data array '{what}'"))?;
        self.values(node).ok_or_else(|| format!("the data array '{what}' cannot be read"))
    }

    fn values(&self, node: Node) -> Option<Vec<f64>> {
        let text = node.text().unwrap_or_default();
        let data = match node.attribute("format") {
            Some("ascii") | None => {
                return text.split_whitespace().map(|word| word.parse().ok()).collect();
            }
            Some("binary") => self.unpack(&decode_base64(text.as_bytes())?)?,
            _ => {
                let offset: usize = node.attribute("offset")?.parse().ok()?;
                let data = self.appended?.get(offset..)?;
                if self.appended_is_text {
                    self.unpack(&decode_base64(data)?)?
                } else {
                    self.unpack(data)?
                }
            }
        };
        numbers(&data, node.attribute("type")?, self.big_endian)
    }

    /// The bytes of one array: what follows the header, unpacked if need be.
    fn unpack(&self, data: &[u8]) -> Option<Vec<u8>> {
        let mut bytes = Bytes::new(data, self.big_endian);
        let count = bytes.unsigned(self.header_size)?;
        if !self.compressed {
            return bytes.take(usize::try_from(count).ok()?).map(<[u8]>::to_vec);
        }
        let block = bytes.unsigned(self.header_size)?;
        let last = bytes.unsigned(self.header_size)?;
        let mut sizes = Vec::new();
        for _ in 0..count {
            sizes.push(usize::try_from(bytes.unsigned(self.header_size)?).ok()?);
        }
        let mut out = Vec::new();
        for (b, &size) in sizes.iter().enumerate() {
            let packed = bytes.take(size)?;
            let whole = if b + 1 == sizes.len() && last > 0 { last } else { block };
            let limit = whole.min(MAX_GROWTH * (size as u64 + 1));
            let before = out.len() as u64;
            flate2::read::ZlibDecoder::new(packed).take(limit).read_to_end(&mut out).ok()?;
            if out.len() as u64 - before != whole {
                return None;
            }
        }
        Some(out)
    }
}

/// Header and data may be two base64 texts in one, so padding may stand in the middle.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::RequireNone);
    let engine = GeneralPurpose::new(&STANDARD, config);
    let text: Vec<u8> = text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    let mut out = Vec::new();
    for part in text.split(|&b| b == b'=').filter(|part| !part.is_empty()) {
        engine.decode_vec(part, &mut out).ok()?;
    }
    Some(out)
}

fn numbers(data: &[u8], kind: &str, big_endian: bool) -> Option<Vec<f64>> {
    let size = match kind {
        "Int8" | "UInt8" => 1,
        "Int16" | "UInt16" => 2,
        "Int32" | "UInt32" | "Float32" => 4,
        "Int64" | "UInt64" | "Float64" => 8,
        _ => return None,
    };
    let mut bytes = Bytes::new(data, big_endian);
    (0..data.len() / size)
        .map(|_| match kind {
            "Float32" => bytes.f32().map(f64::from),
            "Float64" => bytes.f64(),
            // Negative numbers come out too large and fail as indices.
            _ => bytes.unsigned(size).map(|value| value as f64),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt32">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="2">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">3 7</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5 10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>"#;

    fn parse(bytes: &[u8]) -> Result<TetMesh> {
        parse_vtu(bytes, Path::new("a.vtu"))
    }

    #[test]
    fn raw_appended_data_is_read() {
        let mut file = TEXT
            .replace(r#"format="ascii">0 1 2 0 1 2 3<"#, r#"format="appended" offset="0"><"#)
            .replace(
                "</UnstructuredGrid></",
                "</UnstructuredGrid><AppendedData encoding=\"raw\">_@</AppendedData></",
            )
            .into_bytes();
        let mut data = 28_u32.to_le_bytes().to_vec();
        data.extend([0, 1, 2, 0, 1, 2, 3_i32].into_iter().flat_map(i32::to_le_bytes));
        let at = file.iter().position(|&b| b == b'@').unwrap();
        file.splice(at..=at, data);
        assert_eq!(parse(&file).unwrap(), parse(TEXT.as_bytes()).unwrap());
        for length in 0..file.len() {
            assert!(parse(&file[..length]).is_err());
        }
    }

    #[test]
    fn packed_blocks_are_read_and_lies_about_their_size_are_not_believed() {
        let points = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1_u8].map(f32::from);
        let points: Vec<u8> = points.into_iter().flat_map(f32::to_le_bytes).collect();
        let mut packed = Vec::new();
        flate2::read::ZlibEncoder::new(&points[..], flate2::Compression::default())
            .read_to_end(&mut packed)
            .unwrap();
        let file = |block: u32| {
            let header = [1, block, 0, packed.len() as u32].map(u32::to_le_bytes).concat();
            let engine = base64::engine::general_purpose::STANDARD;
            let data = format!("{}{}", engine.encode(header), engine.encode(&packed));
            let array = format!(r#""Float32" NumberOfComponents="3" format="binary">{data}<"#);
            TEXT.replace(
                r#""Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1<"#,
                &array,
            )
            .replace("header_type", "compressor=\"vtkZLibDataCompressor\" header_type")
        };
        let good = file(48);
        assert_eq!(parse(good.as_bytes()).unwrap(), parse(TEXT.as_bytes()).unwrap());
        let error = parse(file(u32::MAX).as_bytes()).unwrap_err().to_string();
        assert!(error.contains("the data array 'Points' cannot be read"), "{error}");
    }

    #[test]
    fn errors_say_what_is_wrong() {
        for (from, to, expected) in [
            ("\"UnstructuredGrid\" v", "\"PolyData\" v", "not an unstructured grid"),
            ("</Cells>", "", "line 8: not a good .vtu file"),
            ("3 7", "3 9", "cell 1 goes beyond the connectivity array"),
            ("3 7", "7 3", "cell 1 goes beyond the connectivity array"),
            ("3 7", "4 7", "cell 1 has too few corners"),
            ("0 1 2 0 1 2 3", "0 1 2 0 1 2 4", "tet 0 refers to a vertex that is not"),
            ("0 1 2 0 1 2 3", "0 1 2 0 1 2 x", "the data array 'connectivity' cannot be read"),
            ("0 0 0 1 0 0 0", "nan 0 0 1 0 0 0", "vertex 0 has a coordinate that is not a finite"),
            ("\"types\"", "\"kinds\"", "there is no data array 'types'"),
            ("header_type", "compressor=\"vtkLZ4DataCompressor\" h", "save with zlib"),
        ] {
            let message = parse(TEXT.replace(from, to).as_bytes()).unwrap_err().to_string();
            assert!(message.contains(expected), "{to}: {message}");
        }
    }
}
