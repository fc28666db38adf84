//! The values of an input that a follower uses, once each is one that a road vehicle can have.

use law::{Ego, Input, Target};

/// The values of an input that a follower uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Checked {
    /// Ego state; its speed is not negative.
    pub(super) ego: Ego,
    pub(super) target: Option<Target>,
    /// Set speed within the limit, m/s.
    pub(super) set_speed_mps: f64,
    /// Control period, s.
    pub(super) period_s: f64,
}

impl Checked {
    /// The values, if the input is plausible.
    pub(super) fn of(input: &Input) -> Option<Self> {
        input.is_plausible().then(|| Self {
            ego: Ego { speed_mps: input.ego.speed_mps.max(0.0), ..input.ego },
            target: input.target,
            set_speed_mps: input.wanted_speed_mps(),
            period_s: input.period_s,
        })
    }
}
