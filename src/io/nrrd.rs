//! NRRD images, `.nrrd` and `.nhdr` with a file of voxels beside it. Own code: no kept-up crate
//! reads them.

use std::path::Path;

use super::label_names::{LabelNames, segment_names};
use super::text::shorten;
use super::voxels::{self, Encoding, Number, Packing};
use super::{read_bytes, text};
use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3};
use crate::volume::Volume;

/// The fields that matter here.
#[derive(Default)]
struct Header {
    number: Option<Number>,
    sizes: Vec<usize>,
    space: Option<String>,
    directions: Option<String>,
    origin: Option<String>,
    encoding: String,
    big_endian: bool,
    data_file: Option<String>,
    line_skip: usize,
    /// -1: the voxels are the last bytes of the file.
    byte_skip: i64,
    /// The lines "key:=value", free text.
    texts: Vec<(String, String)>,
}

/// Reads one image with its voxels in the same file.
pub fn parse_nrrd(bytes: &[u8], path: &Path) -> Result<Volume> {
    let (header, rest) = header(bytes, path)?;
    if let Some(file) = &header.data_file {
        return Err(Error::parse(
            path,
            None,
            format!("the voxels are in {}; give the path of the header", shorten(file)),
        ));
    }
    volume(&header, rest, path)
}

/// Reads one image and the names of its labels; `.nhdr` headers name a file of voxels beside them.
pub fn read_nrrd(path: &Path) -> Result<(Volume, LabelNames)> {
    let bytes = read_bytes(path)?;
    let (header, rest) = header(&bytes, path)?;
    let names = segment_names(&header.texts);
    let Some(file) = &header.data_file else { return Ok((volume(&header, rest, path)?, names)) };
    if file.starts_with("LIST") || file.contains('%') {
        return Err(Error::parse(path, None, "the voxels are in many files; save them in one"));
    }
    let beside = path.with_file_name(file);
    Ok((volume(&header, &read_bytes(&beside)?, &beside)?, names))
}

/// The header and what follows the empty line after it.
fn header<'a>(bytes: &'a [u8], path: &Path) -> Result<(Header, &'a [u8])> {
    if !bytes.starts_with(b"NRRD000") {
        return Err(Error::parse(path, 1, "no NRRD image: it does not begin with NRRD000"));
    }
    let mut header = Header::default();
    let mut rest = bytes;
    let mut line_number = 0;
    loop {
        line_number += 1;
        let wrong = |message: String| Error::parse(path, line_number, message);
        let Some(end) = rest.iter().position(|b| *b == b'\n') else {
            // A header of its own may end without an empty line.
            let alone = header.data_file.is_some();
            let cut = || wrong("the header ends before an empty line".to_owned());
            return if alone { Ok((header, &[])) } else { Err(cut()) };
        };
        let line = text::decode(&rest[..end]);
        let line = line.trim_end();
        rest = &rest[end + 1..];
        if line.is_empty() {
            return Ok((header, rest));
        }
        let Some((key, value)) = line.split_once(':') else { continue };
        if line.starts_with('#') {
            continue;
        }
        if let Some(text) = value.strip_prefix('=') {
            header.texts.push((key.to_owned(), text.to_owned()));
        } else {
            header.set(&key.trim().to_lowercase(), value.trim()).map_err(wrong)?;
        }
    }
}

impl Header {
    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "type" => self.number = Some(number(value)?),
            "dimension" if value != "3" && value != "2" => {
                return Err(format!(
                    "the image has {} dimensions; save one 3-D image alone",
                    shorten(value)
                ));
            }
            "sizes" => {
                let sizes: Result<Vec<usize>, _> =
                    value.split_whitespace().map(str::parse).collect();
                self.sizes = sizes.map_err(|_| format!("sizes are '{}'", shorten(value)))?;
            }
            "space" => self.space = Some(value.to_lowercase()),
            "space directions" => self.directions = Some(value.to_owned()),
            "space origin" => self.origin = Some(value.to_owned()),
            "encoding" => self.encoding = value.to_lowercase(),
            "endian" => self.big_endian = value.eq_ignore_ascii_case("big"),
            "data file" | "datafile" => self.data_file = Some(value.to_owned()),
            "line skip" | "lineskip" => {
                self.line_skip = value.parse().map_err(|_| "bad 'line skip'".to_owned())?;
            }
            "byte skip" | "byteskip" => {
                self.byte_skip = value.parse().map_err(|_| "bad 'byte skip'".to_owned())?;
            }
            _ => {}
        }
        Ok(())
    }

    /// World from voxel, RAS.
    fn place(&self) -> Result<(Mat3, Vec3), String> {
        let to_ras = match self.space.as_deref() {
            Some("left-posterior-superior" | "lps") => Vec3::new(-1.0, -1.0, 1.0),
            Some("right-anterior-superior" | "ras") => Vec3::new(1.0, 1.0, 1.0),
            Some("left-anterior-superior" | "las") => Vec3::new(-1.0, 1.0, 1.0),
            Some(other) => {
                return Err(format!(
                    "the space is '{}'; left-posterior-superior or another of the person's is needed",
                    shorten(other)
                ));
            }
            None => {
                return Err(
                    "the header names no space, so that left and right are unknown; save it with one"
                        .to_owned(),
                );
            }
        };
        let directions = self.directions.as_deref().ok_or("the header has no space directions")?;
        let vectors: Option<Vec<Vec3>> = vectors(directions);
        let Some([a, b, c]) = vectors.and_then(|v| <[Vec3; 3]>::try_from(v).ok()) else {
            return Err(format!(
                "space directions '{}' are not three vectors",
                shorten(directions)
            ));
        };
        let origin = self.origin.as_deref().ok_or("the header has no space origin")?;
        let [origin] = vectors_exactly(origin)
            .ok_or_else(|| format!("space origin '{}' is not a vector", shorten(origin)))?;
        let turned = |v: Vec3| v.component_mul(&to_ras);
        Ok((Mat3::from_columns(&[turned(a), turned(b), turned(c)]), turned(origin)))
    }
}

fn vectors_exactly<const N: usize>(text: &str) -> Option<[Vec3; N]> {
    vectors(text)?.try_into().ok()
}

/// "(a,b,c) (d,e,f) ..."
fn vectors(text: &str) -> Option<Vec<Vec3>> {
    let parts = text.split(')').map(str::trim).filter(|part| !part.is_empty());
    parts
        .map(|part| {
            let numbers = part.trim_start().strip_prefix('(')?.split(',');
            let numbers: Option<Vec<f64>> = numbers.map(|n| n.trim().parse().ok()).collect();
            Some(Vec3::from(<[f64; 3]>::try_from(numbers?).ok()?))
        })
        .collect()
}

fn number(name: &str) -> Result<Number, String> {
    Ok(match name.to_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => Number::Signed(1),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Number::Unsigned(1),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Number::Signed(2)
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => {
            Number::Unsigned(2)
        }
        "int" | "signed int" | "int32" | "int32_t" => Number::Signed(4),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Number::Unsigned(4),
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Number::Signed(8),
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            Number::Unsigned(8)
        }
        "float" => Number::Float32,
        "double" => Number::Float64,
        other => return Err(format!("voxels of type '{}' are not known", shorten(other))),
    })
}

fn volume(header: &Header, data: &[u8], path: &Path) -> Result<Volume> {
    let wrong = |message: String| Error::parse(path, None, message);
    let number = header.number.ok_or_else(|| wrong("the header names no type".to_owned()))?;
    let Ok(size) = <[usize; 3]>::try_from(header.sizes.as_slice()) else {
        return Err(wrong(format!("the image has {} sizes; 3 are needed", header.sizes.len())));
    };
    let (map, origin) = header.place().map_err(wrong)?;
    let count = voxels::byte_count(size, number).map_err(wrong)?;
    let mut data = data;
    for _ in 0..header.line_skip {
        let end = data.iter().position(|b| *b == b'\n');
        let end =
            end.ok_or_else(|| wrong("the file has fewer lines than 'line skip'".to_owned()))?;
        data = &data[end + 1..];
    }
    let (slope, intercept) = (1.0, 0.0);
    let encoding = Encoding { number, big_endian: header.big_endian, slope, intercept };
    let packing = match header.encoding.as_str() {
        "raw" => Packing::None,
        "gzip" | "gz" => Packing::Gzip,
        "ascii" | "text" | "txt" => {
            let values = text_values(data, count / number.bytes()).map_err(wrong)?;
            return Volume::new(size, values, map, origin).map_err(|e| wrong(e.to_string()));
        }
        other => {
            return Err(wrong(format!(
                "the encoding '{}' is not read; save it raw or with gzip",
                shorten(other)
            )));
        }
    };
    let mut stream = voxels::unpack(data, packing);
    let skip = match header.byte_skip {
        -1 if packing == Packing::None => data.len().saturating_sub(count),
        skip => usize::try_from(skip).map_err(|_| wrong(format!("byte skip {skip}")))?,
    };
    std::io::copy(&mut std::io::Read::take(&mut stream, skip as u64), &mut std::io::sink())
        .map_err(|e| wrong(format!("the compressed voxels are broken: {e}")))?;
    let bytes = voxels::take(stream, count).map_err(wrong)?;
    Volume::new(size, encoding.values(&bytes), map, origin).map_err(|e| wrong(e.to_string()))
}

fn text_values(data: &[u8], count: usize) -> Result<Vec<f32>, String> {
    let text = text::decode(data);
    let numbers = text.split(|c: char| c.is_whitespace() || c == ',').filter(|t| !t.is_empty());
    let values: Result<Vec<f32>, String> = numbers
        .take(count)
        .map(|t| t.parse().map_err(|_| format!("'{}' is not a number", shorten(t))))
        .collect();
    let values = values?;
    if values.len() == count {
        return Ok(values);
    }
    Err(format!("the file has {} values, but its sizes need {count}", values.len()))
}
