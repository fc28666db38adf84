//! Sizes that a problem cannot exceed.

/// Largest horizon, steps.
pub const MAX_HORIZON: usize = 1000;
/// Most rows that a problem can have.
pub const MAX_ROWS: usize = 4;
