//! MetaImage (ITK), `.mha` and `.mhd` with a file of voxels beside it. Own code: no kept-up crate
//! reads them.

use std::path::Path;

use super::read_bytes;
use super::text::{self, shorten};
use super::voxels::{self, Encoding, Number, Packing};
use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3};
use crate::volume::Volume;

#[derive(Default)]
struct Header {
    number: Option<Number>,
    size: Vec<usize>,
    spacing: Option<Vec<f64>>,
    origin: Option<Vec<f64>>,
    /// Rows of the file are the directions of the index axes.
    directions: Option<Vec<f64>>,
    big_endian: bool,
    compressed: bool,
    /// -1: the voxels are the last bytes of the file.
    skip: i64,
    data_file: String,
}

/// Reads one image with its voxels in the same file (`ElementDataFile = LOCAL`).
pub fn parse_meta_image(bytes: &[u8], path: &Path) -> Result<Volume> {
    let (header, rest) = header(bytes, path)?;
    if header.data_file != "LOCAL" {
        return Err(Error::parse(
            path,
            None,
            format!(
                "the voxels are in {}; give the path of the header",
                shorten(&header.data_file)
            ),
        ));
    }
    volume(&header, rest, path)
}

/// Reads one image; `.mhd` headers name a file of voxels beside them.
pub fn read_meta_image(path: &Path) -> Result<Volume> {
    let bytes = read_bytes(path)?;
    let (header, rest) = header(&bytes, path)?;
    if header.data_file == "LOCAL" {
        return volume(&header, rest, path);
    }
    if header.data_file.starts_with("LIST") || header.data_file.contains('%') {
        return Err(Error::parse(path, None, "the voxels are in many files; save them in one"));
    }
    let beside = path.with_file_name(&header.data_file);
    volume(&header, &read_bytes(&beside)?, &beside)
}

/// The header, which ends with the line `ElementDataFile`, and what follows.
fn header<'a>(bytes: &'a [u8], path: &Path) -> Result<(Header, &'a [u8])> {
    let mut header = Header::default();
    let mut rest = bytes;
    let mut line_number = 0;
    loop {
        line_number += 1;
        let wrong = |message: String| Error::parse(path, line_number, message);
        if rest.is_empty() {
            return Err(wrong("no MetaImage: the line ElementDataFile is missing".to_owned()));
        }
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let line = text::decode(&rest[..end]);
        rest = rest.get(end + 1..).unwrap_or_default();
        let Some((key, value)) = line.split_once('=') else {
            return Err(wrong(format!("'{}' is not 'Key = value'", shorten(line.trim()))));
        };
        let (key, value) = (key.trim(), value.trim());
        header.set(key, value).map_err(wrong)?;
        if key == "ElementDataFile" {
            return Ok((header, rest));
        }
    }
}

impl Header {
    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let yes = value.eq_ignore_ascii_case("true");
        match key {
            "NDims" if value != "3" => {
                return Err(format!("the image has {} dimensions; 3 are needed", shorten(value)));
            }
            "DimSize" => {
                let sizes: Result<Vec<usize>, _> =
                    value.split_whitespace().map(str::parse).collect();
                self.size = sizes.map_err(|_| format!("DimSize is '{}'", shorten(value)))?;
            }
            "ElementType" => self.number = Some(number(value)?),
            "ElementSpacing" => self.spacing = Some(numbers(value)?),
            // An older name; ElementSpacing wins where both are given.
            "ElementSize" if self.spacing.is_none() => self.spacing = Some(numbers(value)?),
            "Offset" | "Position" | "Origin" => self.origin = Some(numbers(value)?),
            "TransformMatrix" | "Rotation" | "Orientation" => {
                self.directions = Some(numbers(value)?);
            }
            "BinaryDataByteOrderMSB" | "ElementByteOrderMSB" => self.big_endian = yes,
            "CompressedData" => self.compressed = yes,
            "BinaryData" if !yes => {
                return Err("the voxels are written as text; save them binary".to_owned());
            }
            "HeaderSize" => {
                self.skip = value.parse().map_err(|_| "bad HeaderSize".to_owned())?;
            }
            "ElementNumberOfChannels" if value != "1" => {
                return Err(format!("the image has {} channels; save one alone", shorten(value)));
            }
            "ElementDataFile" => value.clone_into(&mut self.data_file),
            _ => {}
        }
        Ok(())
    }

    /// World from voxel. MetaImage's world is ITK's: LPS.
    fn place(&self) -> Result<(Mat3, Vec3), String> {
        let three = |list: &Option<Vec<f64>>, name: &str| match list.as_deref() {
            Some([x, y, z]) => Ok(Vec3::new(*x, *y, *z)),
            Some(other) => Err(format!("{name} has {} numbers; 3 are needed", other.len())),
            None => Err(format!("the header has no {name}")),
        };
        let spacing = three(&self.spacing, "ElementSpacing")?;
        let origin = three(&self.origin, "Offset")?;
        let rows = self.directions.as_deref().ok_or("the header has no TransformMatrix")?;
        if rows.len() != 9 {
            return Err(format!("TransformMatrix has {} numbers; 9 are needed", rows.len()));
        }
        let to_ras = Vec3::new(-1.0, -1.0, 1.0);
        let column = |k: usize| {
            Vec3::new(rows[3 * k], rows[3 * k + 1], rows[3 * k + 2]).component_mul(&to_ras)
                * spacing[k]
        };
        let map = Mat3::from_columns(&[column(0), column(1), column(2)]);
        Ok((map, origin.component_mul(&to_ras)))
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let list: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    list.map_err(|_| format!("'{}' are not numbers", shorten(text)))
}

fn number(name: &str) -> Result<Number, String> {
    Ok(match name {
        "MET_CHAR" => Number::Signed(1),
        "MET_UCHAR" => Number::Unsigned(1),
        "MET_SHORT" => Number::Signed(2),
        "MET_USHORT" => Number::Unsigned(2),
        "MET_INT" | "MET_LONG" => Number::Signed(4),
        "MET_UINT" | "MET_ULONG" => Number::Unsigned(4),
        "MET_LONG_LONG" => Number::Signed(8),
        "MET_ULONG_LONG" => Number::Unsigned(8),
        "MET_FLOAT" => Number::Float32,
        "MET_DOUBLE" => Number::Float64,
        other => return Err(format!("voxels of type '{}' are not known", shorten(other))),
    })
}

fn volume(header: &Header, data: &[u8], path: &Path) -> Result<Volume> {
    let wrong = |message: String| Error::parse(path, None, message);
    let number = header.number.ok_or_else(|| wrong("the header has no ElementType".to_owned()))?;
    let Ok(size) = <[usize; 3]>::try_from(header.size.as_slice()) else {
        return Err(wrong(format!("DimSize has {} numbers; 3 are needed", header.size.len())));
    };
    let (map, origin) = header.place().map_err(wrong)?;
    let count = voxels::byte_count(size, number).map_err(wrong)?;
    let skip = match header.skip {
        -1 => data.len().saturating_sub(count),
        skip => usize::try_from(skip).map_err(|_| wrong(format!("HeaderSize {skip}")))?,
    };
    let data =
        data.get(skip..).ok_or_else(|| wrong(format!("HeaderSize {skip} is beyond the end")))?;
    let packing = if header.compressed { Packing::Zlib } else { Packing::None };
    let bytes = voxels::take(voxels::unpack(data, packing), count).map_err(wrong)?;
    let (slope, intercept) = (1.0, 0.0);
    let encoding = Encoding { number, big_endian: header.big_endian, slope, intercept };
    Volume::new(size, encoding.values(&bytes), map, origin).map_err(|e| wrong(e.to_string()))
}
