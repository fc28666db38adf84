//! Braking of the models.

/// Braking of a model after its reaction time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Braking {
    /// Deceleration \[m/s²\], positive.
    pub deceleration_mps2: f64,
    /// Largest rate of the deceleration \[m/s³\].
    pub growth_mps3: f64,
}
