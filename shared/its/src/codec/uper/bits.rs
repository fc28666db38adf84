//! Fields from bits, and fields to bits.

use super::{Fields, Number};
use crate::PayloadError;

/// The bits of a message from the first one on.
#[derive(Debug)]
pub(in crate::codec) struct Reader<'a> {
    bytes: &'a [u8],
    /// Number of bits read.
    at: u64,
}

impl<'a> Reader<'a> {
    /// A reader of a message's bits.
    pub(in crate::codec) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The bits from the present one to `end`, exclusive.
    fn advance(&mut self, bits: u64) -> Result<(u64, u64), PayloadError> {
        let (from, end) = (self.at, self.at + bits);
        if end > 8 * self.bytes.len() as u64 {
            return Err(PayloadError::Ends { bit: from });
        }
        self.at = end;
        Ok((from, end))
    }
}

impl Fields for Reader<'_> {
    fn whole(&mut self, number: Number, _: i64) -> Result<i64, PayloadError> {
        // The longest number of the standards has 42 bits, in at most seven bytes.
        let bits = number.bits();
        let (from, end) = self.advance(bits.into())?;
        let bytes = &self.bytes[(from / 8) as usize..end.div_ceil(8) as usize];
        let window = bytes.iter().fold(0, |window: u64, byte| window << 8 | u64::from(*byte));
        let behind = end.next_multiple_of(8) - end;
        let offset = window >> behind & ((1 << bits) - 1);
        number.checked(number.least + offset as i64)
    }

    fn pass(&mut self, bits: u64) -> Result<(), PayloadError> {
        self.advance(bits).map(drop)
    }
}

/// Bits in order; the last byte is filled with 0.
#[derive(Debug, Default)]
pub(in crate::codec) struct Writer {
    bytes: Vec<u8>,
    /// Unused bits of the last byte.
    free: u32,
}

impl Writer {
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
    use super::super::{Form, Part, optional, required};
    use super::*;

    fn read<T>(
        bytes: &[u8],
        read: impl FnOnce(&mut Reader<'_>) -> Result<T, PayloadError>,
    ) -> Result<(T, u64), PayloadError> {
        let mut reader = Reader::new(bytes);
        read(&mut reader).map(|value| (value, reader.at))
    }

    #[test]
    fn a_number_outside_its_bounds_and_one_that_is_cut_are_refused() {
        let number = Number::new("phase", 0, 9);
        let phase = |bytes: &[u8]| read(bytes, |from| from.whole(number, 0));
        assert_eq!(phase(&[0x90]), Ok((9, 4)));
        let refused = PayloadError::Range { what: "phase", value: 10, least: 0, most: 9 };
        assert_eq!(phase(&[0xa0]), Err(refused));
        assert_eq!(phase(&[]), Err(PayloadError::Ends { bit: 0 }));
    }

    #[test]
    fn a_long_number_may_begin_at_any_bit() {
        let long = Number::new("time", 0, (1 << 42) - 1);
        for shift in 0..8_u32 {
            let bits = 0x2aa_aaaa_aaa1_u128 << (128 - 42 - shift);
            let value = read(&bits.to_be_bytes(), |from| {
                from.pass(shift.into())?;
                from.whole(long, 0)
            });
            assert_eq!(value, Ok((0x2aa_aaaa_aaa1, u64::from(shift) + 42)));
        }
    }

    #[test]
    fn fields_that_a_later_version_adds_are_passed_over() {
        // Extended; no optional part; one bit; two known additions, the second present, of two octets; a 1.
        let bytes = [0b1100_0000, 0b1010_0000, 0b0101_0101, 0b0101_0101, 0b0101_0000];
        let sequence = |from: &mut Reader<'_>| from.extensible([], |from, []| from.bit(false));
        let value = read(&bytes, |from| Ok((sequence(from)?, from.bit(false)?)));
        assert_eq!(value, Ok(((true, true), 36)));
        assert_eq!(read(&bytes[..4], sequence), Err(PayloadError::Ends { bit: 19 }));
        // 65 known additions, the last present, without octets.
        let mut many = [0; 12];
        (many[0], many[1], many[9]) = (0b1010_1000, 0b0010_0000, 0b0001_0000);
        assert_eq!(read(&many, sequence), Ok((false, 84)));
    }

    #[test]
    fn a_length_in_fragments_is_refused() {
        let length = |bytes: &[u8]| read(bytes, |from| from.length());
        assert_eq!(length(&[0x7f]), Ok((127, 8)));
        assert_eq!(length(&[0x80, 0x80]), Ok((128, 16)));
        assert_eq!(length(&[0xc1, 0]), Err(PayloadError::Length));
    }

    #[test]
    fn parts_are_skipped_by_their_tables() {
        static ENTRY: Part = Part::Sequence(
            Form::Fixed,
            &[required(Part::whole("angle", 0, 2)), optional(Part::Open)],
        );
        let part = Part::List(Number::new("entries", 1, 2), &ENTRY);
        // Two entries: one with an open type of one octet, one without.
        let bytes = [0b1110_0000, 0b0001_1111, 0b1111_0010];
        assert_eq!(read(&bytes, |from| part.skip(from)), Ok(((), 23)));
        let refused = PayloadError::Range { what: "angle", value: 3, least: 0, most: 2 };
        assert_eq!(read(&[0b0011_0000], |from| part.skip(from)), Err(refused));
    }

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
