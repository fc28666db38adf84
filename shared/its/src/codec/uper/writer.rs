//! Fields to bits.

use super::{Fields, Number};
use crate::PayloadError;

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

    fn push(&mut self, bit: bool) {
        if self.free == 0 {
            self.bytes.push(0);
            self.free = 8;
        }
        self.free -= 1;
        if let Some(last) = self.bytes.last_mut() {
            *last |= u8::from(bit) << self.free;
        }
    }
}

impl Fields for Writer {
    fn whole(&mut self, number: Number, given: i64) -> Result<i64, PayloadError> {
        let offset = number.checked(given)? - number.least;
        (0..number.bits()).rev().for_each(|place| self.push(offset >> place & 1 == 1));
        Ok(given)
    }

    fn pass(&mut self, bits: u64) -> Result<(), PayloadError> {
        (0..bits).for_each(|_| self.push(false));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_bits_that_their_range_needs() {
        let mut writer = Writer::default();
        writer.whole(Number::new("one of one", 5, 5), 5).expect("in range");
        writer.whole(Number::new("three", 0, 7), 3).expect("in range");
        writer.whole(Number::new("below", -160, 161), -160).expect("in range");
        writer.flags("three", 3, &mut 0b101).expect("in range");
        assert_eq!(writer.finish(), [0b0110_0000, 0b0000_1010]);
        let refused = Writer::default().whole(Number::new("eight", 0, 7), 8);
        assert_eq!(refused.expect_err("eight").to_string(), "eight 8, expected 0 to 7");
    }

    #[test]
    fn a_list_begins_with_its_count() {
        let entry = Number::new("entry", 0, 15);
        let count = Number::new("entries", 1, 4);
        let each = |writer: &mut Writer, value: &mut u8| writer.number(entry, value);
        let mut writer = Writer::default();
        writer.list(count, &mut vec![1, 2], each).expect("in range");
        assert_eq!(writer.finish(), [0b0100_0100, 0b1000_0000]);
        assert!(Writer::default().list(count, &mut vec![], each).is_err());
    }
}
