//! The values of an input that the law uses, once each is one that a vehicle can have.

use crate::law::Input;

/// The values.
pub(super) struct Checked {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) target: Option<Lead>,
    pub(super) set_speed: f64,
}

/// The values of the target.
#[derive(Clone, Copy)]
pub(super) struct Lead {
    pub(super) gap_m: f64,
    pub(super) relative_mps: f64,
    pub(super) acceleration_mps2: f64,
}

/// The input, if every value the law uses is one that a vehicle can have.
pub(super) fn check(input: &Input) -> Option<Checked> {
    let knows_the_lead = input.target.is_none_or(|t| (-50.0..=50.0).contains(&t.acceleration_mps2));
    (input.is_plausible() && knows_the_lead).then(|| Checked {
        speed: input.ego.speed_mps.max(0.0),
        acceleration: input.ego.acceleration_mps2,
        target: input.target.map(|t| Lead {
            gap_m: t.gap_m,
            relative_mps: t.relative_speed_mps,
            acceleration_mps2: t.acceleration_mps2,
        }),
        set_speed: input.wanted_speed_mps(),
    })
}
