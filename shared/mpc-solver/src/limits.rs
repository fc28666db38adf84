//! Upper limits on a problem's size.

/// Largest horizon \[steps\].
pub const MAX_HORIZON: usize = 1000;
/// Largest number of rows of a problem.
pub const MAX_ROWS: usize = 4;
