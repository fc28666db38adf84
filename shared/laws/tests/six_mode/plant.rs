//! An ego vehicle with a first-order lag, and point-mass traffic.

use law::{Ego, Input, Law, Output, Target};

/// Integration step, s.
pub(crate) const DT: f64 = 0.01;

/// A vehicle of the traffic: rear bumper position and speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Actor {
    pub(crate) id: u32,
    pub(crate) position: f64,
    pub(crate) speed: f64,
}

impl Actor {
    /// One integration step at the given acceleration; never reverses.
    pub(crate) fn advance(&mut self, acceleration: f64) {
        let speed = (self.speed + acceleration * DT).max(0.0);
        self.position += 0.5 * (self.speed + speed) * DT;
        self.speed = speed;
    }

    /// Report of an ideal sensor on `ego`.
    pub(crate) fn seen_from(&self, ego: &Ego) -> Target {
        Target {
            track_id: self.id,
            gap_m: self.position - ego.position_m,
            relative_speed_mps: self.speed - ego.speed_mps,
            ..Target::default()
        }
    }
}

/// One step of the ego: lag first, then speed, then the mean speed moves it.
pub(crate) fn advance_ego(ego: &mut Ego, request: f64, lag: f64) {
    ego.acceleration_mps2 += DT * (request - ego.acceleration_mps2) / lag;
    let mut speed = ego.speed_mps + DT * ego.acceleration_mps2;
    if speed < 0.0 {
        speed = 0.0;
        ego.acceleration_mps2 = ego.acceleration_mps2.max(0.0);
    }
    ego.position_m += 0.5 * (ego.speed_mps + speed) * DT;
    ego.speed_mps = speed;
}

/// Asks the law once.
pub(crate) fn ask(law: &mut dyn Law, input: &Input) -> Output {
    let mut output = Output::default();
    law.step(input, &mut output);
    output
}

/// Input of a single release, no speed limit.
pub(crate) fn input(
    time: f64,
    period: f64,
    set_speed: f64,
    ego: Ego,
    target: Option<Target>,
) -> Input {
    Input {
        time_s: time,
        period_s: period,
        ego,
        target,
        set_speed_mps: set_speed,
        speed_limit_mps: f64::INFINITY,
        ..Input::default()
    }
}
