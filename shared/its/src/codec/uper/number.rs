//! Constrained whole numbers.

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
}
