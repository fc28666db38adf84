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

    /// The value, if it is within the bounds.
    pub(super) fn checked(self, value: i64) -> Result<i64, PayloadError> {
        if self.contains(value) { Ok(value) } else { Err(self.refuses(value)) }
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

/// Fields in the order of the message, to be read or to be written.
///
/// One walk over a message serves both directions. It gives each field with its bounds. A writer takes the given value.
/// A reader puts its own in the place, and so does a test that draws messages. A field fails if the message ends before
/// it, or if its value is outside the bounds.
pub(in crate::codec) trait Fields: Sized {
    /// A whole number within its bounds: the given one is written, and the one of the message returned.
    fn whole(&mut self, number: Number, given: i64) -> Result<i64, PayloadError>;

    /// Skips bits of any content; they are written as 0.
    fn pass(&mut self, bits: u64) -> Result<(), PayloadError>;

    /// Number of entries of a list.
    fn count(&mut self, number: Number, given: i64) -> Result<i64, PayloadError> {
        self.whole(number, given)
    }

    /// True if a type has content of a later version, which is never written.
    fn extended(&mut self) -> Result<bool, PayloadError> {
        self.bit(false)
    }

    /// A length without bounds (clause 11.9), in octets, bits or entries.
    fn length(&mut self) -> Result<u64, PayloadError> {
        if !self.bit(false)? {
            return Ok(self.whole(SHORT_LENGTH, 0)?.unsigned_abs());
        }
        if !self.bit(false)? {
            return Ok(self.whole(LONG_LENGTH, 0)?.unsigned_abs());
        }
        Err(PayloadError::Length)
    }

    /// A whole number in the type of the field.
    fn number<T>(&mut self, number: Number, value: &mut T) -> Result<(), PayloadError>
    where
        T: Copy + Into<i64> + TryFrom<i64>,
    {
        let found = self.whole(number, (*value).into())?;
        *value = T::try_from(found).map_err(|_| number.refuses(found))?;
        Ok(())
    }

    /// A number that is present if its bit said so.
    fn some_number<T>(
        &mut self,
        there: bool,
        number: Number,
        value: &mut Option<T>,
    ) -> Result<(), PayloadError>
    where
        T: Copy + Default + Into<i64> + TryFrom<i64>,
    {
        let place = there.then(|| value.get_or_insert_default());
        match place {
            Some(value) => self.number(number, value),
            None => {
                *value = None;
                Ok(())
            }
        }
    }

    /// A figure that is not read. It is written as unknown: the standards have the highest number for that.
    fn unread(&mut self, number: Number) -> Result<(), PayloadError> {
        self.whole(number, number.most).map(drop)
    }

    /// An enumeration to which a later version may add, and which is not read.
    fn enumeration(&mut self, number: Number, given: i64) -> Result<(), PayloadError> {
        if self.extended()? { self.pass_small() } else { self.whole(number, given).map(drop) }
    }

    fn bit(&mut self, given: bool) -> Result<bool, PayloadError> {
        Ok(self.whole(BIT, given.into())? == 1)
    }

    /// A bit string of a fixed size up to 16: its bit n is bit n of the flags.
    fn flags(
        &mut self,
        what: &'static str,
        size: u32,
        flags: &mut u16,
    ) -> Result<(), PayloadError> {
        let turned = |bits: u16| bits.reverse_bits() >> (u16::BITS - size);
        let bits = self.whole(Number::new(what, 0, (1 << size) - 1), turned(*flags).into())?;
        *flags = turned(bits as u16);
        Ok(())
    }

    /// A sequence that cannot be extended, with the presence of its optional parts.
    fn sequence<T, const N: usize>(
        &mut self,
        mut there: [bool; N],
        inside: impl FnOnce(&mut Self, [bool; N]) -> Result<T, PayloadError>,
    ) -> Result<T, PayloadError> {
        for part in &mut there {
            *part = self.bit(*part)?;
        }
        inside(self, there)
    }

    /// A sequence that can be extended: additions of later versions are skipped.
    fn extensible<T, const N: usize>(
        &mut self,
        there: [bool; N],
        inside: impl FnOnce(&mut Self, [bool; N]) -> Result<T, PayloadError>,
    ) -> Result<T, PayloadError> {
        let extended = self.extended()?;
        let value = self.sequence(there, inside)?;
        if extended {
            self.pass_additions()?;
        }
        Ok(value)
    }

    fn list<T: Default>(
        &mut self,
        count: Number,
        entries: &mut Vec<T>,
        mut each: impl FnMut(&mut Self, &mut T) -> Result<(), PayloadError>,
    ) -> Result<(), PayloadError> {
        let count = self.count(count, i64::try_from(entries.len()).unwrap_or(i64::MAX))?;
        entries.resize_with(count as usize, T::default);
        entries.iter_mut().try_for_each(|entry| each(self, entry))
    }

    /// The additions of an extended sequence (clauses 19.7 to 19.9): their presence, and each after its
    /// length.
    fn pass_additions(&mut self) -> Result<(), PayloadError> {
        let is_long = self.bit(false)?;
        let known = if is_long { self.length()? } else { self.whole(SMALL, 0)?.unsigned_abs() + 1 };
        let mut there = 0;
        for _ in 0..known {
            there += u32::from(self.bit(false)?);
        }
        (0..there).try_for_each(|_| self.pass_open())
    }

    /// The number of an alternative that a later version added to an enumeration or choice (clause 11.6).
    fn pass_small(&mut self) -> Result<(), PayloadError> {
        if self.bit(false)? { self.pass_open() } else { self.whole(SMALL, 0).map(drop) }
    }

    /// An open type, or a number without bounds: octets after their length.
    fn pass_open(&mut self) -> Result<(), PayloadError> {
        let octets = self.length()?;
        self.pass(8 * octets)
    }
}
