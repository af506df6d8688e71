//! Numbers in as few bytes as they need: seven bits a byte, the lowest first; signed ones with their sign in the lowest bit.

use super::PackedError;

/// The bits of a number that one byte holds.
const BITS: u32 = 7;
/// Set in every byte of a number but the last.
const MORE: u8 = 0x80;

/// Writes numbers.
#[derive(Debug, Default)]
pub(in crate::convert) struct Writer {
    pub(super) bytes: Vec<u8>,
}

impl Writer {
    pub(super) fn byte(&mut self, byte: u8) {
        self.bytes.push(byte);
    }

    pub(super) fn raw<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes.extend(bytes);
    }

    #[expect(clippy::cast_possible_truncation, reason = "the lowest bits are meant")]
    pub(super) fn number(&mut self, number: impl Into<u64>) {
        let mut rest: u64 = number.into();
        while rest >= u64::from(MORE) {
            self.byte(rest as u8 | MORE);
            rest >>= BITS;
        }
        self.byte(rest as u8);
    }

    pub(super) fn length(&mut self, length: usize) {
        self.number(length as u64);
    }

    pub(super) fn signed(&mut self, number: i64) {
        self.number((number.cast_unsigned() << 1) ^ (number >> 63).cast_unsigned());
    }
}

/// Reads numbers; never beyond the bytes that are there.
#[derive(Debug)]
pub(in crate::convert) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    pub(super) fn byte(&mut self) -> Result<u8, PackedError> {
        self.raw::<1>().map(|[byte]| byte)
    }

    pub(super) fn raw<const N: usize>(&mut self) -> Result<[u8; N], PackedError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(PackedError::Short)?;
        self.rest = rest;
        Ok(*bytes)
    }

    /// A number that fits its type.
    pub(super) fn number<T: TryFrom<u64>>(&mut self) -> Result<T, PackedError> {
        let mut number = 0_u64;
        for shift in (0..u64::BITS).step_by(BITS as usize) {
            let byte = self.byte()?;
            let bits = u64::from(byte & !MORE);
            if bits << shift >> shift != bits {
                return Err(PackedError::Large);
            }
            number |= bits << shift;
            if byte & MORE == 0 {
                return T::try_from(number).map_err(|_| PackedError::Large);
            }
        }
        Err(PackedError::Large)
    }

    pub(super) fn signed(&mut self) -> Result<i64, PackedError> {
        let number: u64 = self.number()?;
        Ok((number >> 1).cast_signed() ^ -(number & 1).cast_signed())
    }

    /// A list of at most this many elements: its length, then its elements. Memory is allocated as elements arrive, never by
    /// a claimed length; the limit is there because an element takes more memory than bytes.
    pub(super) fn list<T>(
        &mut self,
        most: usize,
        mut element: impl FnMut(&mut Self) -> Result<T, PackedError>,
    ) -> Result<Vec<T>, PackedError> {
        let length: usize = self.number()?;
        if length > most {
            return Err(PackedError::TooMany { found: length, most });
        }
        let mut list = Vec::new();
        for _ in 0..length {
            list.push(element(self)?);
        }
        Ok(list)
    }

    pub(super) const fn end(&self) -> Result<(), PackedError> {
        if self.rest.is_empty() { Ok(()) } else { Err(PackedError::Trailing(self.rest.len())) }
    }
}
