//! Margins and their order.

/// Margin by which a formula holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Distance to violation, in the formula's unit; negative where it is violated.
    pub value: f64,
    /// The sample that decides it.
    pub sample: usize,
}

impl Margin {
    /// The margin of the contrary.
    pub(crate) fn negative(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

/// The smaller one; of equal ones the earlier.
pub(crate) fn smaller(a: Margin, b: Margin) -> Margin {
    if b.value < a.value || (b.value == a.value && b.sample < a.sample) { b } else { a }
}

/// The larger one; of equal ones the earlier.
pub(crate) fn larger(a: Margin, b: Margin) -> Margin {
    smaller(a.negative(), b.negative()).negative()
}

/// The margins of the contrary.
pub(crate) fn negative(margins: &[Margin]) -> Vec<Margin> {
    margins.iter().map(|margin| margin.negative()).collect()
}
