//! NIfTI-1 images, `.nii` and `.nii.gz`. The crate `nifti` reads the header; the voxels are read
//! here, because a header must not decide how much memory is taken.

use std::io::{Read, sink};
use std::path::Path;

use nifti::{Endianness, NiftiHeader};

use super::label_names::{LabelNames, caret_names};
use super::text;
use super::voxels::{self, Encoding, Number, Packing};
use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3};
use crate::volume::Volume;

const HEADER_BYTES: usize = 348;
/// Extensions are read up to here; a broken header may say that they are longer.
const MOST_EXTENSION_BYTES: u64 = 1 << 24;
const NIFTI_2_BYTES: u32 = 540;

/// Reads one image. World coordinates are the file's: RAS. The `sform` counts before the `qform`;
/// a file with neither is an error, because its place and sides would be a guess.
pub fn parse_nifti(bytes: &[u8], path: &Path) -> Result<Volume> {
    Ok(parse_named_nifti(bytes, path)?.0)
}

/// The same with the names of labels in the file's extensions.
pub fn parse_named_nifti(bytes: &[u8], path: &Path) -> Result<(Volume, LabelNames)> {
    let wrong = |message: String| Error::parse(path, None, message);
    let packed = bytes.starts_with(&[0x1f, 0x8b]);
    let packing = if packed { Packing::Gzip } else { Packing::None };
    let mut stream = voxels::unpack(bytes, packing);
    let head = voxels::take(&mut stream, HEADER_BYTES)
        .map_err(|_| wrong("no NIfTI image: the header is cut short or broken".to_owned()))?;
    let length = [head[0], head[1], head[2], head[3]];
    if [u32::from_le_bytes(length), u32::from_be_bytes(length)].contains(&NIFTI_2_BYTES) {
        return Err(wrong("the file is NIfTI-2; save it as NIfTI-1".to_owned()));
    }
    match &head[344..348] {
        b"n+1\0" => {}
        b"ni1\0" => {
            return Err(wrong(
                "the voxels are in a second file (.img); save the image as one .nii file"
                    .to_owned(),
            ));
        }
        _ => return Err(wrong("no NIfTI image: the mark 'n+1' is missing".to_owned())),
    }
    let header = NiftiHeader::from_reader(&head[..])
        .map_err(|e| wrong(format!("the header is broken: {e}")))?;
    let size = size(&header).map_err(wrong)?;
    let encoding = encoding(&header).map_err(wrong)?;
    let (map, origin) = place(&header).map_err(wrong)?;
    let count = voxels::byte_count(size, encoding.number).map_err(wrong)?;
    let offset = f64::from(header.vox_offset);
    if !(offset >= HEADER_BYTES as f64 && offset < 1e9) {
        return Err(wrong(format!("the voxels cannot begin at byte {offset}")));
    }
    let before = (offset as usize - HEADER_BYTES) as u64;
    let mut extensions = Vec::new();
    let mut between = (&mut stream).take(before);
    let read = (&mut between).take(MOST_EXTENSION_BYTES).read_to_end(&mut extensions);
    let skipped = read.and_then(|_| std::io::copy(&mut between, &mut sink()));
    skipped.map_err(|e| wrong(format!("the compressed voxels are broken: {e}")))?;
    let data = voxels::take(stream, count).map_err(&wrong)?;
    let volume =
        Volume::new(size, encoding.values(&data), map, origin).map_err(|e| wrong(e.to_string()))?;
    Ok((volume, caret_names(&text::decode(&extensions)).unwrap_or_default()))
}

fn size(header: &NiftiHeader) -> Result<[usize; 3], String> {
    let rank = usize::from(header.dim[0]);
    if !(2..=7).contains(&rank) {
        return Err(format!("the image has {rank} dimensions; 2 or 3 are needed"));
    }
    let length = |d: usize| if d <= rank { usize::from(header.dim[d]) } else { 1 };
    let images: usize = (4..8).map(|d| length(d).max(1)).product();
    if images > 1 {
        return Err(format!(
            "the file holds {images} images, one per time or channel; save one alone"
        ));
    }
    Ok([length(1), length(2), length(3)])
}

fn encoding(header: &NiftiHeader) -> Result<Encoding, String> {
    let number = match header.datatype {
        2 => Number::Unsigned(1),
        4 => Number::Signed(2),
        8 => Number::Signed(4),
        16 => Number::Float32,
        64 => Number::Float64,
        256 => Number::Signed(1),
        512 => Number::Unsigned(2),
        768 => Number::Unsigned(4),
        1024 => Number::Signed(8),
        1280 => Number::Unsigned(8),
        other => {
            return Err(format!(
                "voxels of type {other} (colour, complex or bits) are no intensities; save whole or real numbers"
            ));
        }
    };
    let big_endian = header.endianness == Endianness::Big;
    let (slope, intercept) = (f64::from(header.scl_slope), f64::from(header.scl_inter));
    // A slope of 0 means no scaling.
    let scaled = slope != 0.0 && slope.is_finite() && intercept.is_finite();
    let (slope, intercept) = if scaled { (slope, intercept) } else { (1.0, 0.0) };
    Ok(Encoding { number, big_endian, slope, intercept })
}

/// World from voxel, in millimetres.
fn place(header: &NiftiHeader) -> Result<(Mat3, Vec3), String> {
    let mut header = header.clone();
    if header.sform_code <= 0 {
        header.sform_code = 0;
        if header.qform_code <= 0 {
            return Err(
                "the header says nothing about orientation (no sform, no qform); set it, e.g. in 3D Slicer"
                    .to_owned(),
            );
        }
        if header.pixdim[1..4].iter().any(|step| !(step.is_finite() && *step > 0.0)) {
            return Err(format!("the voxel sizes are {:?}", &header.pixdim[1..4]));
        }
        // The sign of the third axis; other numbers mean 1.
        header.pixdim[0] = if (header.pixdim[0] + 1.0).abs() < 1e-6 { -1.0 } else { 1.0 };
        let turn = [header.quatern_b, header.quatern_c, header.quatern_d];
        let squared: f32 = turn.iter().map(|q| q * q).sum();
        if !squared.is_finite() || squared > 1.01 {
            return Err(format!("the rotation (b, c, d) = {turn:?} is longer than 1"));
        }
        if squared > 1.0 {
            let length = squared.sqrt() * (1.0 + f32::EPSILON);
            header.quatern_b /= length;
            header.quatern_c /= length;
            header.quatern_d /= length;
        }
    }
    let unit = match header.xyzt_units & 7 {
        1 => 1000.0,
        3 => 0.001,
        _ => 1.0,
    };
    let affine = header.affine::<f64>() * unit;
    Ok((affine.fixed_view::<3, 3>(0, 0).into(), affine.fixed_view::<3, 1>(0, 3).into()))
}
