//! Unaligned PER (ITU-T X.691) as far as the messages need it that are sent here.
//!
//! Encoding by the generated types would compile every part of the standards that a message may have; what is
//! sent here has few of them. Received messages may have all: those are decoded by the generated types.

use crate::EncodeError;
use std::ops::RangeInclusive;

/// Bits one after another; what is missing to the last byte is 0.
#[derive(Debug, Default)]
pub(super) struct Writer {
    bytes: Vec<u8>,
    /// Bits in the last byte that are not used yet.
    free: u32,
}

impl Writer {
    /// The message.
    pub(super) fn finish(self) -> Vec<u8> {
        self.bytes
    }

    /// A flag: of an extensible type whether it is extended, of an optional part whether it is there.
    pub(super) fn bit(&mut self, bit: bool) {
        if self.free == 0 {
            self.bytes.push(0);
            self.free = 8;
        }
        self.free -= 1;
        if let Some(last) = self.bytes.last_mut() {
            *last |= u8::from(bit) << self.free;
        }
    }

    /// The beginning of a sequence or choice that could be extended, and is not.
    pub(super) fn not_extended(&mut self) {
        self.bit(false);
    }

    /// Which of a sequence's optional parts are there.
    pub(super) fn present<const N: usize>(&mut self, parts: [bool; N]) {
        parts.into_iter().for_each(|part| self.bit(part));
    }

    /// A constrained whole number (clause 11.5); also an enumeration's and a choice's number.
    ///
    /// # Errors
    /// [`EncodeError::Range`].
    pub(super) fn number(
        &mut self,
        what: &str,
        value: impl Into<i64>,
        range: RangeInclusive<i64>,
    ) -> Result<(), EncodeError> {
        let value = value.into();
        if !range.contains(&value) {
            let (least, most) = (range.start(), range.end());
            return Err(EncodeError::Range(format!("{what} {value}, expected {least} to {most}")));
        }
        let (offset, width) = (value - range.start(), bits_of(range.end() - range.start()));
        (0..width).rev().for_each(|place| self.bit(offset >> place & 1 == 1));
        Ok(())
    }

    /// As [`Self::number`], of a part that may be missing.
    pub(super) fn some_number(
        &mut self,
        what: &str,
        value: Option<impl Into<i64>>,
        range: RangeInclusive<i64>,
    ) -> Result<(), EncodeError> {
        value.map_or(Ok(()), |value| self.number(what, value, range))
    }

    /// How many entries a list has, and each of them.
    pub(super) fn list<T>(
        &mut self,
        what: &str,
        entries: &[T],
        count: RangeInclusive<i64>,
        mut each: impl FnMut(&mut Self, &T) -> Result<(), EncodeError>,
    ) -> Result<(), EncodeError> {
        let number = i64::try_from(entries.len()).unwrap_or(i64::MAX);
        self.number(what, number, count)?;
        entries.iter().try_for_each(|entry| each(self, entry))
    }

    /// A bit string of a fixed size, whose bit n is bit n of `flags`.
    pub(super) fn flags(&mut self, flags: u16, size: u32) {
        (0..size).for_each(|n| self.bit(flags >> n & 1 == 1));
    }
}

/// Bits that the numbers from 0 to `most` need.
fn bits_of(most: i64) -> u32 {
    i64::BITS - most.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_bits_that_their_range_needs() {
        let mut writer = Writer::default();
        writer.number("one of one", 5, 5..=5).expect("in range");
        writer.number("three", 3, 0..=7).expect("in range");
        writer.number("below", -160, -160..=161).expect("in range");
        writer.flags(0b101, 3);
        assert_eq!(writer.finish(), [0b0110_0000, 0b0000_1010]);
        let refused = Writer::default().number("eight", 8, 0..=7);
        assert_eq!(refused, Err(EncodeError::Range("eight 8, expected 0 to 7".into())));
    }

    #[test]
    fn a_list_says_how_long_it_is() {
        let mut writer = Writer::default();
        let each = |writer: &mut Writer, entry: &u8| writer.number("entry", *entry, 0..=15);
        writer.list("entries", &[1, 2], 1..=4, each).expect("in range");
        assert_eq!(writer.finish(), [0b0100_0100, 0b1000_0000]);
        assert!(Writer::default().list("entries", &[], 1..=4, each).is_err());
    }
}
