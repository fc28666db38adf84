//! What the models ask of the brakes.

/// What a model asks for once its reaction time is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Braking {
    /// Deceleration \[m/s²\], positive.
    pub deceleration_mps2: f64,
    /// How fast the deceleration may grow \[m/s³\].
    pub growth_mps3: f64,
}
