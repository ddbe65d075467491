//! One oblique, anisotropic, left-handed image, written in every format that moulage reads.
// Not every test needs every format.
#![allow(dead_code)]

use std::fmt::Write;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

pub const SIZE: [usize; 3] = [5, 4, 3];
/// RAS: the steps along the three indices and the centre of the first voxel. Left-handed.
pub const STEPS: [[f64; 3]; 3] = [[0.6, 0.0, 0.8], [0.0, -2.0, 0.0], [-2.4, 0.0, 1.8]];
pub const ORIGIN: [f64; 3] = [-12.5, 30.25, 101.0];

/// What voxel v holds.
pub fn value(v: usize) -> i16 {
    (v * 7) as i16 - 100
}

pub fn voxels(big_endian: bool) -> Vec<u8> {
    let bytes = |v| if big_endian { value(v).to_be_bytes() } else { value(v).to_le_bytes() };
    (0..SIZE.iter().product()).flat_map(bytes).collect()
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// With an sform, little-endian shorts.
pub fn nifti() -> Vec<u8> {
    let mut h = vec![0_u8; 352];
    let mut put = |at: usize, bytes: &[u8]| h[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (d, n) in [3, 5, 4, 3, 1, 1, 1, 1_i16].into_iter().enumerate() {
        put(40 + 2 * d, &n.to_le_bytes());
    }
    put(70, &4_i16.to_le_bytes());
    put(72, &16_i16.to_le_bytes());
    for (d, n) in [1.0, 1.0, 2.0, 3.0_f32].into_iter().enumerate() {
        put(76 + 4 * d, &n.to_le_bytes());
    }
    put(108, &352.0_f32.to_le_bytes());
    put(123, &[2]);
    put(254, &1_i16.to_le_bytes());
    for row in 0..3 {
        for column in 0..4 {
            let x = if column < 3 { STEPS[column][row] } else { ORIGIN[row] };
            put(280 + 16 * row + 4 * column, &(x as f32).to_le_bytes());
        }
    }
    put(344, b"n+1\0");
    h.extend(voxels(false));
    h
}

/// LPS: x and y are negated.
fn lps(v: [f64; 3]) -> [f64; 3] {
    [-v[0], -v[1], v[2]]
}

/// Raw little-endian, gzip big-endian, or text.
pub fn nrrd(encoding: &str) -> Vec<u8> {
    let vector = |v: [f64; 3]| format!("({},{},{})", v[0], v[1], v[2]);
    let [a, b, c] = STEPS.map(|s| vector(lps(s)));
    let endian = if encoding == "gzip" { "big" } else { "little" };
    let mut file = format!(
        "NRRD0004\n# a comment\ntype: short\ndimension: 3\nspace: left-posterior-superior\n\
         sizes: 5 4 3\nspace directions: {a} {b} {c}\nkinds: domain domain domain\n\
         endian: {endian}\nencoding: {encoding}\nspace origin: {}\nkey:=value\n\n",
        vector(lps(ORIGIN))
    )
    .into_bytes();
    match encoding {
        "raw" => file.extend(voxels(false)),
        "gzip" => file.extend(gzip(&voxels(true))),
        _ => {
            let mut text = String::new();
            for v in 0..60 {
                writeln!(text, "{}", value(v)).unwrap();
            }
            file.extend(text.into_bytes());
        }
    }
    file
}

pub fn meta_image(compressed: bool) -> Vec<u8> {
    let lengths = [1.0, 2.0, 3.0];
    let mut rows = String::new();
    for (step, length) in STEPS.into_iter().zip(lengths) {
        for x in lps(step) {
            write!(rows, " {}", x / length).unwrap();
        }
    }
    let origin = lps(ORIGIN);
    let mut file = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = {}\nTransformMatrix ={rows}\nOffset = {} {} {}\n\
         ElementSpacing = 1 2 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n\
         ElementDataFile = LOCAL\n",
        if compressed { "True" } else { "False" },
        origin[0],
        origin[1],
        origin[2]
    )
    .into_bytes();
    file.extend(if compressed { zlib(&voxels(false)) } else { voxels(false) });
    file
}

/// One DICOM slice, explicit little-endian; values are stored plus 1000 and halved by no one.
pub struct DicomSlice {
    pub series: &'static str,
    /// LPS.
    pub position: [f64; 3],
    pub pixels: Vec<i16>,
}

/// Slice k of the image.
pub fn dicom_slice(k: usize) -> DicomSlice {
    let at = lps(ORIGIN);
    let step = lps(STEPS[2]);
    DicomSlice {
        series: "1.2.3",
        position: [0, 1, 2].map(|c| at[c] + k as f64 * step[c]),
        pixels: (20 * k..20 * (k + 1)).map(value).collect(),
    }
}

impl DicomSlice {
    pub fn bytes(&self) -> Vec<u8> {
        let numbers = |list: &[f64]| {
            list.iter().map(ToString::to_string).collect::<Vec<_>>().join("\\").into_bytes()
        };
        let across = lps(STEPS[0]);
        let down = lps(STEPS[1]).map(|x| x / 2.0);
        let short = |n: u16| n.to_le_bytes().to_vec();
        // Stored values are twice the real ones plus 2000: slope 0.5, intercept -1000.
        let pixels = self.pixels.iter().flat_map(|v| (2 * v + 2000).to_le_bytes()).collect();
        let mut meta = Vec::new();
        element(&mut meta, [2, 0x10], b"UI", b"1.2.840.10008.1.2.1".to_vec());
        let mut file = vec![0; 128];
        file.extend(b"DICM");
        element(&mut file, [2, 0], b"UL", (meta.len() as u32).to_le_bytes().to_vec());
        file.extend(meta);
        for (tag, kind, bytes) in [
            ([0x0020, 0x000e], b"UI", self.series.as_bytes().to_vec()),
            ([0x0020, 0x0032], b"DS", numbers(&self.position)),
            ([0x0020, 0x0037], b"DS", numbers(&[across, down].concat())),
            ([0x0028, 0x0002], b"US", short(1)),
            ([0x0028, 0x0004], b"CS", b"MONOCHROME2".to_vec()),
            ([0x0028, 0x0010], b"US", short(4)),
            ([0x0028, 0x0011], b"US", short(5)),
            ([0x0028, 0x0030], b"DS", numbers(&[2.0, 1.0])),
            ([0x0028, 0x0100], b"US", short(16)),
            ([0x0028, 0x0101], b"US", short(16)),
            ([0x0028, 0x0102], b"US", short(15)),
            ([0x0028, 0x0103], b"US", short(1)),
            ([0x0028, 0x1052], b"DS", numbers(&[-1000.0])),
            ([0x0028, 0x1053], b"DS", numbers(&[0.5])),
            ([0x7fe0, 0x0010], b"OW", pixels),
        ] {
            element(&mut file, tag, kind, bytes);
        }
        file
    }
}

/// A slice alone, which needs a thickness.
pub fn single_dicom() -> Vec<u8> {
    let mut file = dicom_slice(0).bytes();
    let mut thickness = Vec::new();
    element(&mut thickness, [0x0018, 0x0050], b"DS", b"3".to_vec());
    let series = file.windows(4).position(|w| w == [0x20, 0, 0x0e, 0]).unwrap();
    file.splice(series..series, thickness);
    file
}

fn element(file: &mut Vec<u8>, tag: [u16; 2], kind: &[u8; 2], mut value: Vec<u8>) {
    if value.len() % 2 == 1 {
        value.push(if kind == b"UI" { 0 } else { b' ' });
    }
    file.extend(tag.into_iter().flat_map(u16::to_le_bytes));
    file.extend(kind);
    if kind == b"OW" {
        file.extend([0, 0]);
        file.extend((value.len() as u32).to_le_bytes());
    } else {
        file.extend((value.len() as u16).to_le_bytes());
    }
    file.extend(value);
}
