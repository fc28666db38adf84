//! The law: increments, virtual lead, the smaller of two, and the envelope.

use super::certificate::{ClosedState, Content, Design, extended};
use super::envelope::{self, Envelope};
use super::model::State;
use super::printed;
use super::{GainSource, Settings};
use law::settings;
use law::{Ego, Input, Law, Output, Quality, Target};
use nalgebra::{SMatrix, SVector};
use scenario::Problem;

/// Request towards which a law without usable input moves, m/s².
const BLIND_REQUEST: f64 = -1.0;
/// Share of the sample time by which a release may come early and still be due.
const EARLY: f64 = 1e-6;

/// Lead that the law follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The virtual lead, at the set speed and without gap error.
    Cruise,
    /// The real one.
    Follow,
    /// Neither: the fall-back drives.
    FallBack,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Reason {
    #[default]
    None,
    NoTarget,
    CruiseDemandsLess,
    LeadDemandsLess,
    OutsideCertifiedRange,
}

/// Request for one lead.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// [x; xc] as the law takes it.
    z: ClosedState,
    increment: f64,
}

#[derive(Clone, Debug)]
pub struct QuadraticBounded {
    design: Design,
    settings: Settings,
    memory: Memory,
}

/// All state that `reset` clears.
#[derive(Clone, Debug, Default)]
struct Memory {
    /// Lead of the last update; `None` before the first and after unusable input.
    mode: Option<Mode>,
    reason: Reason,
    /// Controller state xc.
    xc: State,
    /// u(k-1), m/s².
    request: f64,
    started: bool,
    envelope: Envelope,
    /// Time until the next update is due, s.
    wait_s: f64,
    /// Quality and figures of the last update, for the releases that hold it.
    quality: Quality,
    figures: [f64; 8],
}

impl QuadraticBounded {
    pub fn new(design: Design, settings: Settings) -> Result<Self, Problem> {
        settings::Settings::check(&settings)?;
        Ok(Self { design, settings, memory: Memory::default() })
    }

    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Lead of the last update.
    pub fn mode(&self) -> Option<Mode> {
        self.memory.mode
    }

    /// One sample of the increment law.
    fn update(&mut self, input: &Input, too_slow: bool) {
        let p = self.design.parameters();
        let Input { ego, target, set_speed_mps, .. } = *input;
        let (speed, acceleration) = (ego.speed_mps, ego.acceleration_mps2);
        if !self.memory.started {
            self.memory.started = true;
            self.memory.request = acceleration.clamp(-p.request_bound_mps2, p.request_bound_mps2);
        }
        let desired = p.desired_gap_m(speed);
        let virtual_lead =
            State::new(0.0, set_speed_mps - speed, acceleration, self.memory.request);
        let cruise = self.candidate(Mode::Cruise, virtual_lead, speed);
        let followed = target.filter(|t| t.gap_m <= self.settings.sensor_range_m);
        let follow = followed.map(|t| {
            let (error_m, request) = (t.gap_m - desired, self.memory.request);
            let x = State::new(error_m, t.relative_speed_mps, acceleration, request);
            self.candidate(Mode::Follow, x, speed)
        });
        let (mode, reason, chosen) = match follow {
            None => (Mode::Cruise, Reason::NoTarget, cruise),
            Some(f) if f.increment < cruise.increment => (Mode::Follow, Reason::LeadDemandsLess, f),
            Some(_) => (Mode::Cruise, Reason::CruiseDemandsLess, cruise),
        };
        let [excess, excess_after_reset] = self.excess(&chosen.z, followed.as_ref());
        let state = envelope::State {
            excess,
            excess_after_reset,
            speed_mps: speed,
            lead_mps: followed.map_or(f64::INFINITY, |t| speed + t.relative_speed_mps),
            lead_mps2: followed.map_or(0.0, |t| t.acceleration_mps2),
        };
        let p = self.design.parameters();
        if self.memory.envelope.is_left(p, &state, p.sample_time_s) {
            self.fall_back(input, excess);
            return;
        }
        if self.memory.mode != Some(mode) {
            self.memory.mode = Some(mode);
            self.memory.reason = reason;
        }
        let bound = p.increment_bound_mps2;
        let request = (self.memory.request + chosen.increment.clamp(-bound, bound))
            .clamp(-p.request_bound_mps2, p.request_bound_mps2);
        let increment = request - self.memory.request;
        self.memory.request = request;
        if !self.is_printed() {
            self.memory.xc = self.next_controller_state(&chosen.z, speed);
        }
        self.memory.quality = if excess > 1.0 || too_slow || self.is_printed() {
            Quality::Relaxed
        } else {
            Quality::Full
        };
        let true_gap_error = target.map_or(0.0, |t| t.gap_m - desired);
        let rate = chosen.z[1] - p.gap_derivative_s(speed) * acceleration;
        self.memory.figures = [
            excess,
            true_gap_error,
            chosen.z[0],
            chosen.z[1],
            rate,
            increment,
            cruise.increment,
            follow.map_or(0.0, |f| f.increment),
        ];
    }

    fn is_printed(&self) -> bool {
        self.settings.gains == GainSource::Printed
    }

    /// Progress of the state towards the end of the law's range, which is 1. The second value is the same from a reset
    /// controller state. V of a certified design, the urgency of the printed gains.
    fn excess(&self, z: &ClosedState, lead: Option<&Target>) -> [f64; 2] {
        if self.is_printed() {
            let p = self.design.parameters();
            return [lead
                .map_or(0.0, |lead| printed::urgency(p, lead.gap_m, lead.relative_speed_mps));
                2];
        }
        let x = State::from_fn(|i, _| z[i]);
        let after_reset = (x.transpose() * self.design.x_inverse * x)[(0, 0)];
        [self.design.lyapunov(z), after_reset]
    }

    fn fall_back(&mut self, input: &Input, excess: f64) {
        let p = self.design.parameters();
        let Input { ego: Ego { speed_mps, acceleration_mps2, .. }, set_speed_mps, .. } = *input;
        let braking_mps2 = self.settings.fall_back_braking_mps2;
        let ego = input.ego.motion();
        let target = input.target.filter(|t| t.gap_m <= self.settings.sensor_range_m);
        let lead = target.map(|target| target.lead(speed_mps));
        let hardest = (braking_mps2, self.settings.lead_deceleration_mps2);
        let request = envelope::fall_back_mps2(p, hardest, ego, lead.as_ref(), set_speed_mps);
        let request = request.clamp(-braking_mps2, p.request_bound_mps2);
        if self.memory.mode != Some(Mode::FallBack) {
            self.memory.mode = Some(Mode::FallBack);
            self.memory.reason = Reason::OutsideCertifiedRange;
        }
        let increment = request - self.memory.request;
        self.memory.request = request;
        self.memory.quality = Quality::FallBack;
        let gap_error_m = target.map_or(0.0, |t| t.gap_m - p.desired_gap_m(speed_mps));
        let speed_error_mps = target.map_or(0.0, |t| t.relative_speed_mps);
        let rate_mps = speed_error_mps - p.gap_derivative_s(speed_mps) * acceleration_mps2;
        let shown = [excess, gap_error_m, gap_error_m, speed_error_mps, rate_mps, increment];
        self.memory.figures = [0.0; 8];
        self.memory.figures[..6].copy_from_slice(&shown);
    }

    /// The request for the lead of a mode, and the state as the law takes it.
    ///
    /// The state is cut off so that V stays within its limit: the virtual lead's speed error on both sides, the real
    /// lead's gap error above. Otherwise a slower lead far away would be outside of the design's range.
    fn candidate(&self, mode: Mode, mut x: State, speed: f64) -> Candidate {
        let is_real = mode == Mode::Follow;
        if is_real {
            x[0] = x[0].min(self.settings.gap_error_limit_m);
        }
        if self.is_printed() {
            return Candidate {
                z: extended(&x, &State::zeros()),
                increment: printed::increment(&x),
            };
        }
        let Design { content: Content { p, rules, .. }, reset, x_inverse } = &self.design;
        let (index, limit) = (usize::from(!is_real), self.settings.envelope_limit);
        let goes_on = self.memory.mode == Some(mode);
        let (low, high) = if goes_on {
            interval(p, &extended(&x, &self.memory.xc), index, limit)
        } else {
            interval(x_inverse, &x, index, limit)
        };
        x[index] = x[index].clamp(if is_real { f64::NEG_INFINITY } else { low }, high);
        let xc = if goes_on { self.memory.xc } else { reset * x };
        let blend = self.design.parameters().memberships(speed);
        let increment =
            blend.iter().zip(rules).map(|(h, r)| h * (r.fx.dot(&xc) + r.fy.dot(&x))).sum();
        Candidate { z: extended(&x, &xc), increment }
    }

    fn next_controller_state(&self, z: &ClosedState, speed: f64) -> State {
        let x = State::from_fn(|i, _| z[i]);
        let xc = State::from_fn(|i, _| z[i + x.len()]);
        let blend = self.design.parameters().memberships(speed);
        blend
            .iter()
            .zip(self.design.rules())
            .fold(State::zeros(), |next, (h, r)| next + (r.ac * xc + r.l * x) * *h)
    }

    /// Without usable input: towards comfortable braking, never releasing a brake that is on. The
    /// next usable input starts from a reset controller state.
    fn blind(&mut self) {
        let step = self.design.parameters().increment_bound_mps2;
        self.memory.request =
            BLIND_REQUEST.min(self.memory.request).max(self.memory.request - step);
        self.memory.mode = None;
        self.memory.started = true;
        self.memory.wait_s = 0.0;
        self.memory.quality = Quality::Backup;
        self.memory.figures = [0.0; 8];
    }
}

/// Roots of V(z with entry `index` free) = limit for V = z' m z.
fn interval<const N: usize>(
    m: &SMatrix<f64, N, N>,
    z: &SVector<f64, N>,
    index: usize,
    limit: f64,
) -> (f64, f64) {
    let mut rest = *z;
    rest[index] = 0.0;
    let row = m.column(index).dot(&rest);
    let square = m[(index, index)];
    let constant = (rest.transpose() * m * rest)[(0, 0)];
    let half_width = (row * row - square * (constant - limit)).max(0.0).sqrt();
    ((-row - half_width) / square, (-row + half_width) / square)
}

impl Law for QuadraticBounded {
    fn reset(&mut self) {
        self.memory = Memory::default();
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        let sample_time = self.design.parameters().sample_time_s;
        match input.sound() {
            None => self.blind(),
            Some(checked) => {
                if self.memory.wait_s <= EARLY * sample_time {
                    let too_slow = input.period_s > sample_time * (1.0 + EARLY);
                    self.update(&checked, too_slow);
                    // A late update does not shift the next; a lost one is not made up for.
                    self.memory.wait_s = (self.memory.wait_s + sample_time).max(0.0);
                }
                self.memory.wait_s -= input.period_s;
            }
        }
        output.set_request(self.memory.request);
        output.quality = self.memory.quality;
        output.figures = self.memory.figures;
        output.mode = self.memory.mode.map_or(0, |mode| mode as u32);
        output.mode_reason = self.memory.reason as u32;
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        let bound = self.design.parameters().request_bound_mps2;
        (-bound.max(self.settings.fall_back_braking_mps2), bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_ends_where_v_meets_the_limit() {
        let m = nalgebra::Matrix2::new(2.0, 0.5, 0.5, 1.0);
        let z = nalgebra::Vector2::new(7.0, 0.3);
        let (low, high) = interval(&m, &z, 0, 0.98);
        for x in [low, high] {
            let z = nalgebra::Vector2::new(x, 0.3);
            assert!(((z.transpose() * m * z)[(0, 0)] - 0.98).abs() < 1e-12);
        }
        assert!(low < high);
        // No value is admissible: the minimiser of V.
        let z = nalgebra::Vector2::new(7.0, 30.0);
        assert_eq!(interval(&m, &z, 0, 0.98), (-7.5, -7.5));
    }

    #[test]
    fn settings_name_the_bad_key() {
        use law::settings::Settings as _;
        assert_eq!(Settings::default().check(), Ok(()));
        let bad = Settings { envelope_limit: 1.5, ..Settings::default() };
        assert_eq!(bad.check().expect_err("too large").path, "envelope_limit");
        let bad = Settings { gap_error_limit_m: f64::NAN, ..Settings::default() };
        assert_eq!(bad.check().expect_err("NaN").path, "gap_error_limit_m");
    }
}
