//! Numbers that a process may replace once, before its first run. So an example measures the effect of each.

use std::ops::Deref;
use std::sync::OnceLock;

/// A table of numbers with its usual values, or those that replaced them.
///
/// ```
/// use controller::following::parameters::{FOLLOWING, Following};
///
/// assert_eq!(*FOLLOWING, Following::DEFAULT);
/// ```
#[derive(Debug)]
pub struct Varied<T> {
    usual: T,
    other: OnceLock<T>,
}

impl<T> Varied<T> {
    /// A table with its usual values.
    pub(crate) const fn new(usual: T) -> Self {
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
