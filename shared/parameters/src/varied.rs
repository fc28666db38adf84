//! Tables that a process may replace once, before its first use of them.

use std::ops::Deref;
use std::sync::OnceLock;

/// A table of numbers with its usual values, or those that replaced them.
///
/// ```
/// use parameters::Varied;
///
/// static LIMITS: Varied<[f64; 2]> = Varied::new([0.5, 2.0]);
///
/// assert_eq!(LIMITS[1], 2.0);
/// LIMITS.replace([0.5, 4.0]).expect("the first replacement");
/// assert_eq!(LIMITS[1], 4.0);
/// assert!(LIMITS.replace([0.5, 2.0]).is_err());
/// ```
#[derive(Debug)]
pub struct Varied<T> {
    usual: T,
    other: OnceLock<T>,
}

impl<T> Varied<T> {
    /// A table with its usual values.
    pub const fn new(usual: T) -> Self {
        Self { usual, other: OnceLock::new() }
    }

    /// Replaces the values in this process.
    ///
    /// # Errors
    /// The values, if they were replaced before.
    pub fn replace(&self, values: T) -> Result<(), T> {
        self.other.set(values)
    }
}

impl<T> Deref for Varied<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.other.get().unwrap_or(&self.usual)
    }
}
