//! A car behind one vehicle: actuator lag, a noisy radar with latency, a tracker, and a law.

use controller::law::{Ego, Input, Law, Output, Target};
use rand_pcg::Pcg64;

use crate::tracker::Tracker;

/// Step of the integration, s.
pub(crate) const STEP_S: f64 = 0.01;
/// Steps from one scan of the radar to the next.
const SCAN_STEPS: u64 = 5;
/// Lag of the acceleration behind the request, s.
pub(crate) const LAG_S: f64 = 0.5;
/// Slew limits of the actuator gateway, m/s³.
const RISE_MPS3: f64 = 20.0;
const FALL_MPS3: f64 = 50.0;
/// Noise of range, m, and range rate, m/s.
const RANGE_SIGMA_M: f64 = 0.4;
const RATE_SIGMA_MPS: f64 = 0.15;
/// Probability that a scan misses the target.
const DROPOUT: f64 = 0.02;

/// Position of a vehicle's bumper, its speed and acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Vehicle {
    pub(crate) position_m: f64,
    pub(crate) speed_mps: f64,
    pub(crate) acceleration_mps2: f64,
}

impl Vehicle {
    /// One step at a constant acceleration; it stops rather than reverse.
    pub(crate) fn advance(&mut self, acceleration_mps2: f64) {
        let next = (self.speed_mps + STEP_S * acceleration_mps2).max(0.0);
        self.acceleration_mps2 = (next - self.speed_mps) / STEP_S;
        self.position_m += 0.5 * STEP_S * (self.speed_mps + next);
        self.speed_mps = next;
    }

    /// One step towards a request, with the actuator's lag.
    pub(crate) fn follow(&mut self, request_mps2: f64) {
        let decay = libm::exp(-STEP_S / LAG_S);
        let acceleration = request_mps2 + (self.acceleration_mps2 - request_mps2) * decay;
        self.advance(0.5 * (self.acceleration_mps2 + acceleration));
        self.acceleration_mps2 = if self.speed_mps > 0.0 { acceleration } else { 0.0 };
    }
}

/// Information on the target that the law receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Perception {
    /// Exactly what is, at once.
    Ideal,
    /// Radar and tracker.
    Tracked,
}

/// The closed loop.
pub(crate) struct World {
    pub(crate) ego: Vehicle,
    pub(crate) lead: Vehicle,
    pub(crate) set_speed_mps: f64,
    pub(crate) output: Output,
    law: Box<dyn Law>,
    perception: Perception,
    tracker: Tracker,
    /// The scan that the latency still holds back: target, and when it was taken.
    held: Option<(Target, f64)>,
    told: Option<(Target, f64)>,
    request_mps2: f64,
    control_steps: u64,
    steps: u64,
    rng: Pcg64,
}

impl World {
    pub(crate) fn new(
        law: Box<dyn Law>,
        perception: Perception,
        period_s: f64,
        (ego, lead): (Vehicle, Vehicle),
        seed: u64,
    ) -> Self {
        Self {
            ego,
            lead,
            set_speed_mps: 40.0,
            output: Output::default(),
            law,
            perception,
            tracker: Tracker::default(),
            held: None,
            told: None,
            request_mps2: 0.0,
            control_steps: (period_s / STEP_S).round() as u64,
            steps: 0,
            rng: Pcg64::new(u128::from(seed), 11),
        }
    }

    pub(crate) fn time_s(&self) -> f64 {
        self.steps as f64 * STEP_S
    }

    pub(crate) fn gap_m(&self) -> f64 {
        self.lead.position_m - self.ego.position_m
    }

    /// One step in which the lead accelerates by so much.
    pub(crate) fn advance(&mut self, lead_mps2: f64) {
        if self.steps.is_multiple_of(SCAN_STEPS) {
            self.scan();
        }
        if self.steps.is_multiple_of(self.control_steps) {
            self.control();
        }
        let wanted = self.output.request_mps2();
        let (low, high) = (FALL_MPS3 * STEP_S, RISE_MPS3 * STEP_S);
        self.request_mps2 = wanted.clamp(self.request_mps2 - low, self.request_mps2 + high);
        self.ego.follow(self.request_mps2.clamp(-9.0, 5.0));
        self.lead.advance(lead_mps2);
        self.steps += 1;
    }

    fn truth(&self) -> Target {
        Target {
            track_id: 1,
            gap_m: self.gap_m(),
            relative_speed_mps: self.lead.speed_mps - self.ego.speed_mps,
            acceleration_mps2: self.lead.acceleration_mps2,
            age_s: 0.0,
        }
    }

    fn scan(&mut self) {
        let truth = self.truth();
        if self.perception == Perception::Ideal {
            self.told = Some((truth, self.time_s()));
            return;
        }
        let range_m = truth.gap_m + RANGE_SIGMA_M * self.normal();
        let rate_mps = truth.relative_speed_mps + RATE_SIGMA_MPS * self.normal();
        let missed = self.uniform() < DROPOUT;
        let dt_s = SCAN_STEPS as f64 * STEP_S;
        let measured = (!missed).then_some([range_m, rate_mps]);
        let seen = self.tracker.update(measured, self.ego.acceleration_mps2, dt_s);
        self.told = self.held;
        self.held = Some((seen, self.time_s()));
    }

    fn control(&mut self) {
        let time_s = self.time_s();
        let target = self.told.map(|(target, then_s)| {
            let age_s = time_s - then_s;
            let gap_m = target.gap_m + target.relative_speed_mps * age_s;
            Target { gap_m, age_s, ..target }
        });
        let ego = Ego {
            position_m: self.ego.position_m,
            speed_mps: self.ego.speed_mps,
            acceleration_mps2: self.ego.acceleration_mps2,
        };
        let input = Input {
            time_s,
            period_s: self.control_steps as f64 * STEP_S,
            ego,
            target,
            set_speed_mps: self.set_speed_mps,
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        };
        self.law.step(&input, &mut self.output);
    }

    /// Smallest request of the law, m/s².
    pub(crate) fn authority_mps2(&self) -> f64 {
        self.law.request_bounds_mps2().0
    }

    fn uniform(&mut self) -> f64 {
        random::uniform(&mut self.rng)
    }

    /// Irwin and Hall: the sum of twelve uniform numbers has a variance of one.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// True if braking with `authority_mps2` from `reaction_s` on avoids a lead that brakes with
/// `lead_mps2` to standstill.
pub(crate) fn avoidable(
    mut ego: Vehicle,
    mut lead: Vehicle,
    authority_mps2: f64,
    reaction_s: f64,
    lead_mps2: f64,
) -> bool {
    let held_mps2 = ego.acceleration_mps2;
    let mut time_s = 0.0;
    while ego.speed_mps > 0.0 {
        ego.follow(if time_s < reaction_s { held_mps2 } else { authority_mps2 });
        lead.advance(lead_mps2);
        if lead.position_m <= ego.position_m {
            return false;
        }
        time_s += STEP_S;
    }
    true
}
