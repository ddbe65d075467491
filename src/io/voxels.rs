//! What all readers of volumes share: number types, bytes to values, compressed data.

use std::io::Read;

use flate2::read::{MultiGzDecoder, ZlibDecoder};

use super::bytes::Bytes;
use crate::volume::MAX_VOXELS;

/// How one voxel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Signed(usize),
    Unsigned(usize),
    Float32,
    Float64,
}

impl Number {
    pub fn bytes(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) => size,
            Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }

    fn read(self, bytes: &mut Bytes) -> Option<f64> {
        Some(match self {
            Self::Unsigned(size) => bytes.unsigned(size)? as f64,
            Self::Signed(size) => {
                let unused = 64 - 8 * size as u32;
                ((bytes.unsigned(size)? << unused) as i64 >> unused) as f64
            }
            Self::Float32 => f64::from(bytes.f32()?),
            Self::Float64 => bytes.f64()?,
        })
    }
}

/// How the voxels' bytes are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Encoding {
    pub number: Number,
    pub big_endian: bool,
    /// Value = stored number * slope + intercept.
    pub slope: f64,
    pub intercept: f64,
}

impl Encoding {
    /// All values of `bytes`, which must be a whole number of them.
    pub fn values(&self, bytes: &[u8]) -> Vec<f32> {
        let mut source = Bytes::new(bytes, self.big_endian);
        let one = || self.number.read(&mut source);
        std::iter::from_fn(one).map(|n| (n * self.slope + self.intercept) as f32).collect()
    }
}

/// The number of bytes of `size` voxels; an error for none and for enormous numbers of them.
pub(super) fn byte_count(size: [usize; 3], number: Number) -> Result<usize, String> {
    let [a, b, c] = size;
    match a.checked_mul(b).and_then(|ab| ab.checked_mul(c)) {
        Some(0) => Err(format!("the image has {a} x {b} x {c} voxels: none")),
        Some(count) if count <= MAX_VOXELS => Ok(count * number.bytes()),
        _ => Err(format!(
            "the image has {a} x {b} x {c} voxels, more than {MAX_VOXELS}; crop or resample it"
        )),
    }
}

/// Exactly `count` bytes of a stream. Memory grows with what is there, not with what a header
/// promises.
pub(super) fn take(stream: impl Read, count: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let read = stream.take(count as u64).read_to_end(&mut bytes);
    match read {
        Ok(_) if bytes.len() == count => Ok(bytes),
        Ok(_) => Err(format!(
            "the voxels end after {} of {count} bytes; the file is cut short or its header is wrong",
            bytes.len()
        )),
        Err(e) => Err(format!("the compressed voxels are broken after {} bytes: {e}", bytes.len())),
    }
}

/// How bytes are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Gzip,
    Zlib,
}

/// A stream of unpacked bytes.
pub(super) fn unpack(bytes: &[u8], packing: Packing) -> Box<dyn Read + '_> {
    match packing {
        Packing::None => Box::new(bytes),
        Packing::Gzip => Box::new(MultiGzDecoder::new(bytes)),
        Packing::Zlib => Box::new(ZlibDecoder::new(bytes)),
    }
}
