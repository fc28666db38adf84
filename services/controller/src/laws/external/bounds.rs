//! Bounds of a vehicle's motion.

/// Smallest and largest request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) least_mps2: f64,
    pub(super) most_mps2: f64,
}

impl Bounds {
    pub(super) fn bring_in(self, request_mps2: f64) -> f64 {
        request_mps2.max(self.least_mps2).min(self.most_mps2)
    }
}
