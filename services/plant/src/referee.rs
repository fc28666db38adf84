//! The referee: what truly happened, from the ground truth alone.
//!
//! It sees the ego, the vehicle ahead and the signals as they are, once in each period of the plant,
//! and keeps the figures of the run's summary. A collision or a red light ends the run.
//!
//! Between two samples the ego is taken to move on a straight line: so are the time at which it
//! crosses a stop line and its place at the instant of a signal's switch interpolated, as the
//! papers' figures are.

use crate::report::ControlFigures;
use scenario::Scenario;
use scenario::referee::DesiredGap;
use scenario::v2x::Phase;
use serde::{Deserialize, Serialize};

use crate::ahead::Ahead;
use crate::longitudinal::State;
use crate::wheel_energy::WheelEnergy;

/// Most signals watched at a time.
pub const MAX_SIGNALS: usize = 16;

/// Slowest closing speed for which a time to collision is counted, m/s: below it the quotient says
/// nothing but that the gap is constant.
const MIN_CLOSING_MPS: f64 = 0.01;

/// Above this speed the ego drives: what is slower between two stands makes them one, m/s.
const DRIVES_MPS: f64 = 0.5;

/// A signal as it truly is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalTruth {
    /// Identity, equal for equal signals.
    pub id: u32,
    /// Position of the stop line along the road, m.
    pub stop_line_m: f64,
    /// Phase at the time of the sample.
    pub phase: Phase,
    /// Time since the start of the run at which this phase ends; `None`: it stays.
    pub ends_ns: Option<u64>,
    /// The phase after this one.
    pub next_phase: Phase,
}

impl SignalTruth {
    /// The phase at a time, up to the end of the phase after the present one.
    #[must_use]
    pub fn phase_at(&self, time_s: f64) -> Phase {
        match self.ends_ns {
            Some(ends_ns) if time_s >= seconds(ends_ns) => self.next_phase,
            _ => self.phase,
        }
    }
}

/// What ends a run before its time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Violation {
    /// The gap to the vehicle ahead was used up.
    Collision {
        /// When, s.
        time_s: f64,
        /// Speed difference at contact, m/s.
        closing_mps: f64,
    },
    /// A stop line was crossed on red.
    RedLight {
        /// When, s.
        time_s: f64,
        /// Which signal.
        id: u32,
    },
}

/// Watches one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Referee {
    /// The gap that errors are measured against; `None`: the law alone knows it.
    desired: Option<DesiredGap>,
    set_speed_mps: f64,
    /// A vehicle farther away is none that a gap could be kept to, m.
    reach_m: f64,
    last: Option<Sample>,
    signals: [Option<SignalTruth>; MAX_SIGNALS],
    first_signal: Option<u32>,
    violation: Option<Violation>,
    red_lights: u32,
    gap_error: MeanSquare,
    jerk: MeanSquare,
    wheel_energy: Option<WheelEnergy>,
    /// The ego has driven since its last stand.
    drives: bool,
    figures: ControlFigures,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Sample {
    time_s: f64,
    ego: State,
}

impl Referee {
    /// A referee at the start of a run.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            desired: scenario.referee.desired_gap,
            set_speed_mps: scenario.set_speed_mps.value(),
            reach_m: scenario.perception.radar.max_range_m.value(),
            last: None,
            signals: [None; MAX_SIGNALS],
            first_signal: None,
            violation: None,
            red_lights: 0,
            gap_error: MeanSquare::default(),
            jerk: MeanSquare::default(),
            wheel_energy: WheelEnergy::of(&scenario.plant),
            drives: false,
            figures: ControlFigures::default(),
        }
    }

    /// Takes the truth at `now_ns`: the ego, the vehicle ahead in its lane if there is one, and the
    /// signals not yet far behind, nearest first. A sample that is not later than the one before, or
    /// not finite, is passed over.
    ///
    /// Returns the violation that this sample shows, once.
    pub fn observe(
        &mut self,
        now_ns: u64,
        ego: &State,
        ahead: Option<&Ahead>,
        signals: &[SignalTruth],
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
        let collision = self.spacing(&sample, ahead);
        let red_light = self.signals(&sample, signals);
        self.last = Some(sample);
        if self.violation.is_some() {
            return None;
        }
        self.violation = collision.or(red_light);
        self.violation
    }

    /// The figures so far.
    #[must_use]
    pub fn figures(&self) -> &ControlFigures {
        &self.figures
    }

    /// Stop lines crossed on red.
    #[must_use]
    pub fn red_lights(&self) -> u32 {
        self.red_lights
    }

    /// The first violation of the run.
    #[must_use]
    pub fn violation(&self) -> Option<Violation> {
        self.violation
    }

    fn motion(&mut self, sample: &Sample) {
        let acceleration = sample.ego.acceleration_mps2;
        let figures = &mut self.figures;
        figures.min_accel_mps2 = smaller(figures.min_accel_mps2, acceleration);
        figures.max_accel_mps2 = larger(figures.max_accel_mps2, acceleration);
        if let (Some(energy), Some(last)) = (&mut self.wheel_energy, &self.last) {
            energy.add(&last.ego, &sample.ego);
            figures.wheel_energy_kwh_per_100km = energy.kwh_per_100km();
        }
        let stands = sample.ego.speed_mps <= 0.0;
        figures.stops = Some(figures.stops.unwrap_or(0) + u64::from(stands && self.drives));
        self.drives = !stands && (self.drives || sample.ego.speed_mps > DRIVES_MPS);
        // A rigid vehicle comes to a stand with a step of its acceleration. Over one period that is no
        // jerk of the drive: it would grow without bound as the period shrinks.
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
            figures.max_abs_jerk_mps3 = larger(figures.max_abs_jerk_mps3, jerk);
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
            figures.max_abs_gap_error_m = larger(figures.max_abs_gap_error_m, error.abs());
            if let Some(last) = self.last {
                figures.rms_gap_error_m = self.gap_error.add(error, sample.time_s - last.time_s);
            }
        }
        figures.final_speed_error_mps = Some(closing);
        figures.min_gap_m = smaller(figures.min_gap_m, ahead.gap_m);
        if closing > MIN_CLOSING_MPS {
            figures.min_ttc_s = smaller(figures.min_ttc_s, ahead.gap_m.max(0.0) / closing);
        }
        let contact = ahead.gap_m <= 0.0;
        contact.then_some(Violation::Collision { time_s: sample.time_s, closing_mps: closing })
    }

    fn signals(&mut self, sample: &Sample, signals: &[SignalTruth]) -> Option<Violation> {
        if self.first_signal.is_none() {
            self.first_signal = signals.first().map(|signal| signal.id);
        }
        let mut violation = None;
        if let Some(last) = self.last {
            for slot in 0..MAX_SIGNALS {
                if let Some(signal) = self.signals[slot] {
                    violation = violation.or(self.passage(&last, sample, &signal));
                }
            }
        }
        self.remember(signals);
        violation
    }

    /// Looks at one signal over the time from the sample before to this one.
    fn passage(
        &mut self,
        last: &Sample,
        sample: &Sample,
        signal: &SignalTruth,
    ) -> Option<Violation> {
        let first = self.first_signal == Some(signal.id);
        let (from, to) = (last.ego.position_m, sample.ego.position_m);
        let switch_s = signal.ends_ns.map(seconds);
        if let Some(switch_s) = switch_s
            && first
            && self.figures.past_stop_line_at_switch_m.is_none()
            && switch_s > last.time_s
            && switch_s <= sample.time_s
        {
            let share = (switch_s - last.time_s) / (sample.time_s - last.time_s);
            let place = from + share * (to - from);
            self.figures.past_stop_line_at_switch_m = Some(place - signal.stop_line_m);
        }
        if !(from < signal.stop_line_m && signal.stop_line_m <= to) {
            return None;
        }
        let share = (signal.stop_line_m - from) / (to - from);
        let time_s = last.time_s + share * (sample.time_s - last.time_s);
        if first && self.figures.stop_line_crossing_s.is_none() {
            self.figures.stop_line_crossing_s = Some(time_s);
        }
        if signal.phase_at(time_s) != Phase::Red {
            return None;
        }
        self.red_lights += 1;
        Some(Violation::RedLight { time_s, id: signal.id })
    }

    /// Keeps the signals for the next sample. One that is no longer told of (out of radio range, or
    /// a lost message) stays as it was last known.
    fn remember(&mut self, signals: &[SignalTruth]) {
        for signal in signals.iter().filter(|signal| signal.stop_line_m.is_finite()) {
            let known = |slot: &&mut Option<SignalTruth>| slot.is_some_and(|s| s.id == signal.id);
            let slot = match self.signals.iter_mut().find(known) {
                Some(slot) => Some(slot),
                None => self.signals.iter_mut().min_by(|a, b| place(a).total_cmp(&place(b))),
            };
            if let Some(slot) = slot {
                *slot = Some(*signal);
            }
        }
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

/// Order in which stored signals give way to new ones: free slots first, then the farthest behind.
fn place(slot: &Option<SignalTruth>) -> f64 {
    slot.map_or(f64::NEG_INFINITY, |signal| signal.stop_line_m)
}

fn smaller(kept: Option<f64>, value: f64) -> Option<f64> {
    Some(kept.map_or(value, |kept| kept.min(value)))
}

fn larger(kept: Option<f64>, value: f64) -> Option<f64> {
    Some(kept.map_or(value, |kept| kept.max(value)))
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::builtin;
    use scenario::quantity::{Distance, TimeConstant};

    use super::*;

    const PERIOD_NS: u64 = 10_000_000;

    fn scenario(name: &str) -> Scenario {
        let builtin = builtin::find(name).expect("it is built in");
        Scenario::parse(name, builtin.text).expect("it is right")
    }

    /// The same with a gap to measure against, as the launcher adds it.
    fn following() -> Scenario {
        let mut scenario = scenario("following");
        scenario.referee.desired_gap = Some(DesiredGap::Headway {
            time_headway_s: TimeConstant::of(1.5),
            standstill_distance_m: Distance::of(5.0),
        });
        scenario
    }

    fn state(position_m: f64, speed_mps: f64, acceleration_mps2: f64) -> State {
        State { position_m, speed_mps, acceleration_mps2 }
    }

    fn signal(id: u32, stop_line_m: f64, phase: Phase, ends_s: f64) -> SignalTruth {
        let next_phase = if phase == Phase::Red { Phase::Green } else { Phase::Red };
        SignalTruth { id, stop_line_m, phase, ends_ns: Some((ends_s * 1e9) as u64), next_phase }
    }

    /// Drives at constant speed past one signal that is `phase` until `ends_s`.
    fn pass(speed: f64, stop_line_m: f64, phase: Phase, ends_s: f64) -> Referee {
        let mut referee = Referee::new(&scenario("cacc-a"));
        for k in 0..=1000 {
            let t = k as f64 * 0.01;
            let mut truth = signal(1, stop_line_m, phase, ends_s);
            if t >= ends_s {
                truth = SignalTruth { phase: truth.next_phase, ends_ns: None, ..truth };
            }
            referee.observe(k * PERIOD_NS, &state(speed * t, speed, 0.0), None, &[truth]);
        }
        referee
    }

    #[test]
    fn crossing_and_switch_are_interpolated() {
        let referee = pass(15.0, 65.05, Phase::Green, 5.004);
        let figures = referee.figures();
        let close =
            |figure: Option<f64>, value: f64| (figure.expect("it applies") - value).abs() < 1e-9;
        assert!(close(figures.stop_line_crossing_s, 65.05 / 15.0));
        assert!(close(figures.past_stop_line_at_switch_m, 15.0 * 5.004 - 65.05));
        assert_eq!(referee.red_lights(), 0);
    }

    #[test]
    fn a_red_light_is_judged_at_the_instant_of_crossing() {
        // The line is crossed at 5.0033 s, between the samples at 5.00 s and 5.01 s.
        let line = 15.0 * 5.0 + 0.05;
        assert_eq!(pass(15.0, line, Phase::Green, 5.004).violation(), None);
        let violation = pass(15.0, line, Phase::Green, 5.003).violation();
        assert!(matches!(violation, Some(Violation::RedLight { time_s, id: 1 })
                if (time_s - line / 15.0).abs() < 1e-9));
        assert_eq!(pass(15.0, line, Phase::Red, 5.003).violation(), None);
        assert!(pass(15.0, line, Phase::Red, 5.004).violation().is_some());
        assert_eq!(pass(15.0, line, Phase::Yellow, 6.0).violation(), None);
    }

    #[test]
    fn a_signal_that_is_no_longer_told_of_still_counts() {
        let mut referee = Referee::new(&scenario("cacc-a"));
        let red = SignalTruth { ends_ns: None, ..signal(1, 5.0, Phase::Red, 0.0) };
        assert_eq!(referee.observe(0, &state(4.9, 15.0, 0.0), None, &[red]), None);
        let violation = referee.observe(PERIOD_NS, &state(5.05, 15.0, 0.0), None, &[]);
        assert!(matches!(violation, Some(Violation::RedLight { id: 1, .. })));
    }

    #[test]
    fn the_reference_run_of_scenario_a_gives_the_reference_figures() {
        let csv =
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/cacc-a-cacc.csv"));
        let mut referee = Referee::new(&scenario("cacc-a"));
        for (k, line) in csv.lines().skip(1).enumerate() {
            let row: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
            let truth = signal(1, 80.0, Phase::Green, 5.0);
            let truth = match k < 50 {
                true => truth,
                false => SignalTruth { phase: Phase::Red, ends_ns: None, ..truth },
            };
            let ahead = Ahead { gap_m: row[7], speed_mps: row[8], acceleration_mps2: 0.0 };
            let now_ns = k as u64 * 100_000_000;
            let violation =
                referee.observe(now_ns, &state(row[1], row[2], row[3]), Some(&ahead), &[truth]);
            assert_eq!(violation, None);
        }
        let figures = referee.figures();
        // 3.91 s and 20.2 m in the table of the reconstruction.
        assert!((figures.stop_line_crossing_s.expect("it crosses") - 3.91).abs() < 0.005);
        assert!((figures.past_stop_line_at_switch_m.expect("it switches") - 20.2).abs() < 0.05);
        assert!((figures.min_gap_m.expect("there is a lead") - 24.158_18).abs() < 1e-5);
    }

    #[test]
    fn a_collision_is_reported_once() {
        let mut referee = Referee::new(&scenario("following"));
        let ahead = |gap_m| Ahead { gap_m, speed_mps: 10.0, acceleration_mps2: 0.0 };
        let ego = state(0.0, 15.0, 0.0);
        assert_eq!(referee.observe(0, &ego, Some(&ahead(0.01)), &[]), None);
        assert_eq!(
            referee.observe(PERIOD_NS, &ego, Some(&ahead(-0.04)), &[]),
            Some(Violation::Collision { time_s: 0.01, closing_mps: 5.0 })
        );
        assert_eq!(referee.observe(2 * PERIOD_NS, &ego, Some(&ahead(-0.09)), &[]), None);
        assert!(matches!(referee.violation(), Some(Violation::Collision { .. })));
        assert_eq!(referee.figures().min_ttc_s, Some(0.0));
    }

    #[test]
    fn figures_that_do_not_apply_are_absent() {
        let mut referee = Referee::new(&following());
        assert_eq!(*referee.figures(), ControlFigures::default());
        referee.observe(0, &state(0.0, 25.0, 0.5), None, &[]);
        let figures = referee.figures();
        assert_eq!(figures.min_gap_m, None);
        assert_eq!(figures.min_ttc_s, None);
        assert_eq!(figures.final_gap_error_m, None);
        assert_eq!(figures.final_speed_error_mps, Some(-5.0));
        assert_eq!(figures.max_abs_jerk_mps3, None);
        assert_eq!(figures.min_accel_mps2, Some(0.5));
        // An opening gap has no time to collision.
        let ahead = Ahead { gap_m: 30.0, speed_mps: 26.0, acceleration_mps2: 0.0 };
        referee.observe(PERIOD_NS, &state(0.25, 25.0, 0.4), Some(&ahead), &[]);
        let figures = referee.figures();
        assert_eq!(figures.min_ttc_s, None);
        assert_eq!(figures.final_gap_error_m, Some(30.0 - (1.5 * 25.0 + 5.0)));
        assert!((figures.max_abs_jerk_mps3.expect("two samples") - 10.0).abs() < 1e-9);
    }

    #[test]
    fn the_step_of_the_acceleration_at_a_stop_is_no_jerk() {
        // A car's acceleration ends with its last step, a truck's one sample later.
        for last in [0.0, -1.5] {
            let mut referee = Referee::new(&scenario("following"));
            let motion = [(0.05, -2.5), (0.025, -2.5), (0.0, last), (0.0, 0.0), (0.001, 0.1)];
            for (index, (speed, acceleration)) in (0..).zip(motion) {
                referee.observe(index * PERIOD_NS, &state(0.0, speed, acceleration), None, &[]);
            }
            let jerk = referee.figures().max_abs_jerk_mps3.expect("five samples");
            assert!(
                (jerk - 10.0).abs() < 1e-9,
                "moving off counts, coming to a stand does not: {jerk}"
            );
        }
    }

    #[test]
    fn a_stop_is_a_stand_after_a_drive() {
        let mut referee = Referee::new(&scenario("following"));
        for (index, speed) in (0..).zip([0.0, 10.0, 0.0, 0.0, 0.5, 0.0, 0.6, 0.0, 3.0]) {
            referee.observe(index * PERIOD_NS, &state(0.0, speed, 0.0), None, &[]);
        }
        assert_eq!(referee.figures().stops, Some(2), "creeping between two stands makes them one");
    }

    #[test]
    fn mean_squares_weigh_by_time() {
        let mut referee = Referee::new(&following());
        // The desired gap at 20 m/s is 1.5 * 20 + 5 = 35 m; the first sample has no length yet.
        for (time_ns, gap_m, acceleration) in
            [(0, 90.0, 0.0), (PERIOD_NS, 38.0, 0.1), (4 * PERIOD_NS, 34.0, 0.1)]
        {
            let ahead = Ahead { gap_m, speed_mps: 20.0, acceleration_mps2: 0.0 };
            referee.observe(time_ns, &state(0.0, 20.0, acceleration), Some(&ahead), &[]);
        }
        let figures = referee.figures();
        let rms = figures.rms_gap_error_m.expect("a lead");
        assert!((rms - ((9.0 + 3.0 * 1.0) / 4.0_f64).sqrt()).abs() < 1e-9, "{rms}");
        let jerk = figures.rms_jerk_mps3.expect("three samples");
        assert!((jerk - (100.0 / 4.0_f64).sqrt()).abs() < 1e-9, "{jerk}");
        assert_eq!(figures.max_abs_gap_error_m, Some(55.0));
    }

    #[test]
    fn a_gap_that_only_the_law_knows_has_no_error() {
        let mut referee = Referee::new(&scenario("six-mode"));
        let ahead = Ahead { gap_m: 30.0, speed_mps: 26.0, acceleration_mps2: 0.0 };
        referee.observe(0, &state(0.0, 25.0, 0.0), Some(&ahead), &[]);
        assert_eq!(referee.figures().final_gap_error_m, None);
        assert_eq!(referee.figures().min_gap_m, Some(30.0));
    }

    #[test]
    fn more_signals_than_slots_drop_the_ones_behind() {
        let mut referee = Referee::new(&scenario("corridor"));
        for k in 0..100u32 {
            let position = 100.0 * f64::from(k);
            let ahead = signal(k, position + 50.0, Phase::Red, 1e6);
            let now_ns = u64::from(k) * PERIOD_NS;
            let violation = referee.observe(now_ns, &state(position, 10.0, 0.0), None, &[ahead]);
            assert_eq!(violation.is_some(), k == 1);
        }
        assert_eq!(referee.red_lights(), 99);
    }

    proptest! {
        #[test]
        fn no_input_makes_a_figure_that_is_not_a_number(
            samples in prop::collection::vec(
                (prop::num::f64::ANY, prop::num::f64::ANY, prop::num::f64::ANY,
                 prop::num::f64::ANY, prop::num::f64::ANY, prop::num::f64::ANY), 1..30),
        ) {
            let mut referee = Referee::new(&scenario("cacc-a"));
            for (k, (x, v, a, gap_m, speed_mps, line)) in samples.into_iter().enumerate() {
                let ahead = Ahead { gap_m, speed_mps, acceleration_mps2: 0.0 };
                let truth = signal(1, line, Phase::Green, 0.1);
                referee.observe(k as u64 * PERIOD_NS, &state(x, v, a), Some(&ahead), &[truth]);
            }
            let f = referee.figures();
            for figure in [
                f.min_gap_m, f.min_ttc_s, f.final_gap_error_m, f.final_speed_error_mps,
                f.max_abs_jerk_mps3, f.min_accel_mps2, f.max_accel_mps2,
                f.stop_line_crossing_s, f.past_stop_line_at_switch_m, f.rms_gap_error_m,
                f.max_abs_gap_error_m, f.rms_jerk_mps3,
            ].into_iter().flatten() {
                prop_assert!(!figure.is_nan());
            }
        }
    }
}
