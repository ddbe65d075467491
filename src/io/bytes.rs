//! Numbers in binary files, never beyond the bytes that are there.

/// A reader of numbers from a slice; every read may come back empty-handed.
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
    big_endian: bool,
}

impl<'a> Bytes<'a> {
    pub fn new(bytes: &'a [u8], big_endian: bool) -> Self {
        Self { rest: bytes, big_endian }
    }

    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    /// An unsigned number of 1 to 8 bytes.
    pub fn unsigned(&mut self, size: usize) -> Option<u64> {
        let bytes = self.take(size)?;
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        Some(if self.big_endian {
            bytes.iter().fold(0, fold)
        } else {
            bytes.iter().rev().fold(0, fold)
        })
    }

    pub fn f64(&mut self) -> Option<f64> {
        Some(f64::from_bits(self.unsigned(8)?))
    }

    pub fn f32(&mut self) -> Option<f32> {
        Some(f32::from_bits(self.unsigned(4)? as u32))
    }

    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }
}
