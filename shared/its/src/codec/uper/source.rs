//! Fields in order, and the ways in which a type of the standards can be extended.

use crate::PayloadError;

/// A constrained whole number (clause 11.5): a field's name and bounds. It also describes an enumeration, the
/// alternative of a choice and the count of a list.
#[derive(Clone, Copy, Debug)]
pub(in crate::codec) struct Number {
    /// Name in errors.
    pub(super) what: &'static str,
    pub(super) least: i64,
    pub(super) most: i64,
}

impl Number {
    /// Numbers from `least` to `most`.
    pub(in crate::codec) const fn new(what: &'static str, least: i64, most: i64) -> Self {
        Self { what, least, most }
    }

    /// Bits for a number of this range.
    pub(super) const fn bits(self) -> u32 {
        i64::BITS - (self.most - self.least).leading_zeros()
    }

    /// True if `value` is within the bounds.
    pub(in crate::codec) const fn contains(self, value: i64) -> bool {
        self.least <= value && value <= self.most
    }

    pub(super) fn refuses(self, value: i64) -> PayloadError {
        let Self { what, least, most } = self;
        PayloadError::Range { what, value, least, most }
    }
}

const BIT: Number = Number::new("bit", 0, 1);
/// Clause 11.6, the short form; clause 11.9.3.4 counts from one.
const SMALL: Number = Number::new("small number", 0, 63);
const SHORT_LENGTH: Number = Number::new("length", 0, 127);
const LONG_LENGTH: Number = Number::new("length", 0, 16_383);

/// Fields in the order of the message. A decoder requests each with its bounds, so that a test can answer
/// instead of bytes. A request fails if the message ends before, or has a value outside the bounds.
pub(in crate::codec) trait Source: Sized {
    /// A whole number within its bounds.
    fn whole(&mut self, number: Number) -> Result<i64, PayloadError>;

    /// Skips bits of any content.
    fn pass(&mut self, bits: u64) -> Result<(), PayloadError>;

    /// Number of entries of a list.
    fn count(&mut self, number: Number) -> Result<i64, PayloadError> {
        self.whole(number)
    }

    /// True if a type has content of a later version.
    fn extended(&mut self) -> Result<bool, PayloadError> {
        self.bit()
    }

    /// A length without bounds (clause 11.9), in octets, bits or entries.
    fn length(&mut self) -> Result<u64, PayloadError> {
        if !self.bit()? {
            return self.number(SHORT_LENGTH);
        }
        if !self.bit()? {
            return self.number(LONG_LENGTH);
        }
        Err(PayloadError::Length)
    }

    /// A whole number in the type of the field.
    fn number<T: TryFrom<i64>>(&mut self, number: Number) -> Result<T, PayloadError> {
        let value = self.whole(number)?;
        T::try_from(value).map_err(|_| number.refuses(value))
    }

    /// A number that is present if its bit said so.
    fn some_number<T: TryFrom<i64>>(
        &mut self,
        there: bool,
        number: Number,
    ) -> Result<Option<T>, PayloadError> {
        there.then(|| self.number(number)).transpose()
    }

    /// One flag.
    fn bit(&mut self) -> Result<bool, PayloadError> {
        Ok(self.whole(BIT)? == 1)
    }

    /// A bit string of a fixed size up to 16: its bit n is bit n of the flags.
    fn flags(&mut self, what: &'static str, size: u32) -> Result<u16, PayloadError> {
        let bits: u16 = self.number(Number::new(what, 0, (1 << size) - 1))?;
        Ok(bits.reverse_bits() >> (u16::BITS - size))
    }

    /// A sequence that cannot be extended, with the presence of its optional parts.
    fn sequence<T, const N: usize>(
        &mut self,
        read: impl FnOnce(&mut Self, [bool; N]) -> Result<T, PayloadError>,
    ) -> Result<T, PayloadError> {
        let mut there = [false; N];
        for part in &mut there {
            *part = self.bit()?;
        }
        read(self, there)
    }

    /// A sequence that can be extended: additions of later versions are skipped.
    fn extensible<T, const N: usize>(
        &mut self,
        read: impl FnOnce(&mut Self, [bool; N]) -> Result<T, PayloadError>,
    ) -> Result<T, PayloadError> {
        let extended = self.extended()?;
        let value = self.sequence(read)?;
        if extended {
            self.pass_additions()?;
        }
        Ok(value)
    }

    /// A list.
    fn list<T>(
        &mut self,
        count: Number,
        mut each: impl FnMut(&mut Self) -> Result<T, PayloadError>,
    ) -> Result<Vec<T>, PayloadError> {
        let count = self.count(count)?;
        (0..count).map(|_| each(self)).collect()
    }

    /// The additions of an extended sequence (clauses 19.7 to 19.9): their presence, and each after its
    /// length.
    fn pass_additions(&mut self) -> Result<(), PayloadError> {
        let known = if self.bit()? { self.length()? } else { self.number::<u64>(SMALL)? + 1 };
        let mut there = 0;
        for _ in 0..known {
            there += u32::from(self.bit()?);
        }
        (0..there).try_for_each(|_| self.pass_open())
    }

    /// The number of an alternative that a later version added to an enumeration or choice (clause 11.6).
    fn pass_small(&mut self) -> Result<(), PayloadError> {
        if self.bit()? { self.pass_open() } else { self.whole(SMALL).map(drop) }
    }

    /// An open type, or a number without bounds: octets after their length.
    fn pass_open(&mut self) -> Result<(), PayloadError> {
        let octets = self.length()?;
        self.pass(8 * octets)
    }
}
