//! The vehicle of the paper's model in continuous time: first-order lag, true desired gap.

use law::{Ego, Input, Law, Output, Target};

/// Integration step, s.
pub(crate) const DT: f64 = 0.01;
/// Time constant of the acceleration, s.
pub(crate) const LAG: f64 = 0.45;

/// Ego and lead on one lane; the gap is what is between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) ego: Ego,
    pub(crate) gap: f64,
    pub(crate) lead_speed: f64,
}

impl Pair {
    /// One integration step; the lead's acceleration is constant within it.
    pub(crate) fn advance(&mut self, request: f64, lead_acceleration: f64) {
        let ego = &mut self.ego;
        ego.acceleration_mps2 += DT * (request - ego.acceleration_mps2) / LAG;
        let way = DT * (ego.speed_mps + 0.5 * DT * ego.acceleration_mps2);
        ego.speed_mps = (ego.speed_mps + DT * ego.acceleration_mps2).max(0.0);
        ego.position_m += way;
        self.gap += DT * (self.lead_speed + 0.5 * DT * lead_acceleration) - way;
        self.lead_speed += DT * lead_acceleration;
    }

    /// Report of an ideal sensor.
    pub(crate) fn target(&self) -> Target {
        Target {
            track_id: 1,
            gap_m: self.gap,
            relative_speed_mps: self.lead_speed - self.ego.speed_mps,
            ..Target::default()
        }
    }
}

/// Asks the law once; no speed limit.
pub(crate) fn ask(
    law: &mut dyn Law,
    (time_s, period_s): (f64, f64),
    ego: Ego,
    target: Option<Target>,
    set_speed_mps: f64,
) -> Output {
    let input = Input {
        time_s,
        period_s,
        ego,
        target,
        set_speed_mps,
        speed_limit_mps: f64::INFINITY,
        ..Input::default()
    };
    let mut output = Output::default();
    law.step(&input, &mut output);
    output
}
