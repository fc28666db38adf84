//! The referee: what truly happened, from the ground truth alone.
//!
//! Once in each period of the plant it takes the true ego, vehicle ahead and signals. It keeps the
//! figures of the run's summary. A collision or a red light ends the run.
//!
//! Between two samples the ego moves evenly. So two figures are interpolated, as in the papers: the time at a stop
//! line, and the place at a signal's switch.

use crate::report::{ControlFigures, Outcome};
use scenario::Scenario;
use scenario::grade::GradeProfile;
use scenario::referee::DesiredGap;
use serde::{Deserialize, Serialize};

use crate::ahead::Ahead;
use crate::longitudinal::State;
use crate::numbers::Numbers;
use crate::wheel_energy::WheelEnergy;

mod plane;
mod signals;

pub use plane::InPlane;
use plane::PlaneFigures;
pub use signals::SignalTruth;
use signals::StopLines;
pub(crate) use signals::shown;

/// Slowest closing speed for which a time to collision counts, m/s. Chosen: rounding of two equal speeds is far below.
const CLOSING_MPS: f64 = 0.01;

/// A cause that ends a run before its time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Violation {
    /// The gap to the vehicle ahead was used up.
    Collision {
        time_s: f64,
        /// Speed difference at contact, m/s.
        closing_mps: f64,
    },
    /// A stop line was crossed on red.
    RedLight { time_s: f64, id: u32 },
}

/// Watches one run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Referee {
    /// `None` on a level road.
    #[serde(skip)]
    heights: Option<GradeProfile>,
    /// Speed above which the ego drives, m/s.
    drives_mps: f64,
    /// Gap from which errors are measured. `None`: only the law has it.
    desired: Option<DesiredGap>,
    set_speed_mps: f64,
    /// Distance beyond which the ego keeps no gap to a vehicle, m.
    reach_m: f64,
    last: Option<Sample>,
    stop_lines: StopLines,
    violation: Option<Violation>,
    gap_error: MeanSquare,
    jerk: MeanSquare,
    wheel_energy: Option<WheelEnergy>,
    /// The ego has driven since its last stand.
    drives: bool,
    /// On a road with a plan.
    plane: Option<PlaneFigures>,
    figures: ControlFigures,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Sample {
    time_s: f64,
    ego: State,
}

impl Referee {
    pub fn new(scenario: &Scenario, numbers: &Numbers) -> Self {
        Self {
            // A scenario's check has read the heights already.
            heights: scenario.road.profile().ok().filter(|_| !scenario.road.is_level()),
            drives_mps: numbers.drives_mps,
            desired: scenario.referee.desired_gap,
            set_speed_mps: scenario.set_speed_mps.value(),
            reach_m: scenario.perception.radar.max_range_m.value(),
            wheel_energy: WheelEnergy::of(scenario, numbers),
            plane: PlaneFigures::of(scenario, numbers),
            ..Self::default()
        }
    }

    /// Goes on from what another process kept.
    pub fn restore(&mut self, kept: Self) {
        *self = Self { heights: self.heights.take(), ..kept };
    }

    /// Takes the truth at `now_ns`: the ego, the vehicle ahead in its lane, and the signals (nearest first). The
    /// signals are not yet far behind. A sample that is not later than the one before, or not finite, is passed over.
    ///
    /// Returns the violation that this sample shows, once. On a road with a plan contact is that of the bodies in the
    /// plane, not a gap that is used up.
    pub fn observe(
        &mut self,
        now_ns: u64,
        ego: &State,
        ahead: Option<&Ahead>,
        signals: impl IntoIterator<Item = SignalTruth>,
        in_plane: Option<&InPlane>,
    ) -> Option<Violation> {
        let sample = Sample { time_s: seconds(now_ns), ego: *ego };
        let finite = ego.position_m.is_finite()
            && ego.speed_mps.is_finite()
            && ego.acceleration_mps2.is_finite();
        if !finite || self.last.is_some_and(|last| last.time_s >= sample.time_s) {
            return None;
        }
        self.motion(&sample);
        let ahead = ahead.filter(|ahead| ahead.gap_m.is_finite() && ahead.speed_mps.is_finite());
        let mut collision = self.spacing(&sample, ahead);
        if let Some(in_plane) = in_plane {
            let time_s = sample.time_s;
            let of = |closing_mps| Violation::Collision { time_s, closing_mps };
            collision = in_plane.closing_at_contact_mps.map(of);
            let period_s = self.last.map_or(0.0, |last| time_s - last.time_s);
            if let Some(plane) = &mut self.plane {
                plane.add(in_plane, period_s, &mut self.figures);
            }
        }
        let red_light = self.stop_lines.observe(
            self.last.as_ref(),
            &sample,
            signals.into_iter(),
            &mut self.figures,
        );
        self.last = Some(sample);
        if self.violation.is_some() {
            return None;
        }
        self.violation = collision.or(red_light);
        self.violation
    }

    pub fn figures(&self) -> &ControlFigures {
        &self.figures
    }

    /// End of the run by the first violation.
    pub(crate) fn outcome(&self) -> Option<Outcome> {
        Some(match self.violation? {
            Violation::Collision { .. } => Outcome::Collision,
            Violation::RedLight { .. } => Outcome::RedLight,
        })
    }

    fn motion(&mut self, sample: &Sample) {
        let acceleration = sample.ego.acceleration_mps2;
        let figures = &mut self.figures;
        smaller(&mut figures.min_accel_mps2, acceleration);
        larger(&mut figures.max_accel_mps2, acceleration);
        if let (Some(energy), Some(last)) = (&mut self.wheel_energy, &self.last) {
            energy.add(&last.ego, &sample.ego, self.heights.as_ref());
            figures.wheel_energy_kwh_per_100km = energy.kwh_per_100km();
        }
        let stands = sample.ego.speed_mps <= 0.0;
        figures.stops = Some(figures.stops.unwrap_or(0) + u64::from(stands && self.drives));
        self.drives = !stands && (self.drives || sample.ego.speed_mps > self.drives_mps);
        // A rigid vehicle comes to a stand with a step of its acceleration. The jerk leaves this step out: over one
        // period it would grow without bound as the period shrinks.
        let comes_to_stand =
            |last: &Sample| last.ego.speed_mps > 0.0 && sample.ego.speed_mps <= 0.0;
        // A truck's sample at which it first stands still has its last step's mean acceleration.
        let felt = |state: &State| match state.speed_mps <= 0.0 {
            true => state.acceleration_mps2.max(0.0),
            false => state.acceleration_mps2,
        };
        if let Some(last) = self.last.filter(|last| !comes_to_stand(last)) {
            let rise = felt(&sample.ego) - felt(&last.ego);
            let period_s = sample.time_s - last.time_s;
            let jerk = (rise / period_s).abs();
            larger(&mut figures.max_abs_jerk_mps3, jerk);
            figures.rms_jerk_mps3 = self.jerk.add(jerk, period_s);
        }
    }

    fn spacing(&mut self, sample: &Sample, ahead: Option<&Ahead>) -> Option<Violation> {
        let speed = sample.ego.speed_mps;
        let Some(ahead) = ahead else {
            self.figures.final_gap_error_m = None;
            self.figures.final_speed_error_mps = Some(speed - self.set_speed_mps);
            return None;
        };
        let closing = speed - ahead.speed_mps;
        let desired = self.desired.map(|desired| desired.at(speed));
        let figures = &mut self.figures;
        let gap_error = desired.map(|desired| ahead.gap_m - desired);
        figures.final_gap_error_m = gap_error;
        if let Some(error) = gap_error.filter(|_| ahead.gap_m <= self.reach_m) {
            larger(&mut figures.max_abs_gap_error_m, error.abs());
            if let Some(last) = self.last {
                figures.rms_gap_error_m = self.gap_error.add(error, sample.time_s - last.time_s);
            }
        }
        figures.final_speed_error_mps = Some(closing);
        smaller(&mut figures.min_gap_m, ahead.gap_m);
        if closing > CLOSING_MPS {
            smaller(&mut figures.min_ttc_s, ahead.gap_m.max(0.0) / closing);
        }
        let contact = ahead.gap_m <= 0.0;
        if contact && figures.impact_speed_mps.is_none() {
            figures.impact_speed_mps = Some(closing.abs());
        }
        contact.then_some(Violation::Collision { time_s: sample.time_s, closing_mps: closing })
    }
}

/// The mean square of a signal over time.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct MeanSquare {
    integral: f64,
    time_s: f64,
}

impl MeanSquare {
    /// Counts `value` for `time_s` and gives the root mean square so far.
    fn add(&mut self, value: f64, time_s: f64) -> Option<f64> {
        self.integral += value * value * time_s;
        self.time_s += time_s;
        let rms = (self.integral / self.time_s).sqrt();
        rms.is_finite().then_some(rms)
    }
}

fn smaller(kept: &mut Option<f64>, value: f64) {
    *kept = Some(kept.map_or(value, |kept| kept.min(value)));
}

fn larger(kept: &mut Option<f64>, value: f64) {
    *kept = Some(kept.map_or(value, |kept| kept.max(value)));
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}

#[cfg(test)]
mod plane_tests;
#[cfg(test)]
mod tests;
