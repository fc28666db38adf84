//! Fields to bits.

use super::Number;
use crate::EncodeError;

/// Bits in order; the last byte is filled with 0.
#[derive(Debug, Default)]
pub(in crate::codec) struct Writer {
    bytes: Vec<u8>,
    /// Unused bits of the last byte.
    free: u32,
}

impl Writer {
    /// The message.
    pub(in crate::codec) fn finish(self) -> Vec<u8> {
        self.bytes
    }

    /// A flag: whether an extensible type is extended, or an optional part is present.
    pub(in crate::codec) fn bit(&mut self, bit: bool) {
        if self.free == 0 {
            self.bytes.push(0);
            self.free = 8;
        }
        self.free -= 1;
        if let Some(last) = self.bytes.last_mut() {
            *last |= u8::from(bit) << self.free;
        }
    }

    /// The start of a sequence or choice that could be extended but is not.
    pub(in crate::codec) fn not_extended(&mut self) {
        self.bit(false);
    }

    /// Presence of a sequence's optional parts.
    pub(in crate::codec) fn present<const N: usize>(&mut self, parts: [bool; N]) {
        parts.into_iter().for_each(|part| self.bit(part));
    }

    /// A constrained whole number.
    pub(in crate::codec) fn number(
        &mut self,
        number: Number,
        value: impl Into<i64>,
    ) -> Result<(), EncodeError> {
        let value = value.into();
        if !number.contains(value) {
            let Number { what, least, most } = number;
            return Err(EncodeError::Range(format!("{what} {value}, expected {least} to {most}")));
        }
        let offset = value - number.least;
        (0..number.bits()).rev().for_each(|place| self.bit(offset >> place & 1 == 1));
        Ok(())
    }

    /// A figure that is unknown: the standards have the highest number for that.
    pub(in crate::codec) fn unknown(&mut self, number: Number) -> Result<(), EncodeError> {
        self.number(number, number.most)
    }

    /// Like [`Self::number`], for an optional part.
    pub(in crate::codec) fn some_number(
        &mut self,
        number: Number,
        value: Option<impl Into<i64>>,
    ) -> Result<(), EncodeError> {
        value.map_or(Ok(()), |value| self.number(number, value))
    }

    /// The count of a list, then its entries.
    pub(in crate::codec) fn list<T>(
        &mut self,
        count: Number,
        entries: &[T],
        mut each: impl FnMut(&mut Self, &T) -> Result<(), EncodeError>,
    ) -> Result<(), EncodeError> {
        let number = i64::try_from(entries.len()).unwrap_or(i64::MAX);
        self.number(count, number)?;
        entries.iter().try_for_each(|entry| each(self, entry))
    }

    /// A bit string of a fixed size, whose bit n is bit n of `flags`.
    pub(in crate::codec) fn flags(&mut self, flags: u16, size: u32) {
        (0..size).for_each(|n| self.bit(flags >> n & 1 == 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_bits_that_their_range_needs() {
        let mut writer = Writer::default();
        writer.number(Number::new("one of one", 5, 5), 5).expect("in range");
        writer.number(Number::new("three", 0, 7), 3).expect("in range");
        writer.number(Number::new("below", -160, 161), -160).expect("in range");
        writer.flags(0b101, 3);
        assert_eq!(writer.finish(), [0b0110_0000, 0b0000_1010]);
        let refused = Writer::default().number(Number::new("eight", 0, 7), 8);
        assert_eq!(refused, Err(EncodeError::Range("eight 8, expected 0 to 7".into())));
    }

    #[test]
    fn a_list_begins_with_its_count() {
        let entry = Number::new("entry", 0, 15);
        let count = Number::new("entries", 1, 4);
        let each = |writer: &mut Writer, value: &u8| writer.number(entry, *value);
        let mut writer = Writer::default();
        writer.list(count, &[1, 2], each).expect("in range");
        assert_eq!(writer.finish(), [0b0100_0100, 0b1000_0000]);
        assert!(Writer::default().list(count, &[], each).is_err());
    }
}
