//! `acc-signal-stop`: an ACC that is blind to countdowns, with a driver's signal stop on top.
//!
//! It is the rival of `cacc-mpc`. He et al. (2024) name "the former ACC with a decision layer" as the simple way
//! through signalised intersections. The follower is `acc-mpc`. The layer sees the colour of the nearest signal from a
//! stated distance, and nothing of the future:
//!
//! ```text
//! seen       the colour, once the line is within sight_m
//! heeded     the colour seen, once it has been the same for reaction_s
//! yellow     stop if  v² / (2 (d - margin - tau v)) <= yellow deceleration,  else go on
//! red        stop, unless it went on through this yellow
//! green      start, as acc-mpc does
//! request    min(acc-mpc, driver in front of a standing obstacle at the line)
//! ```
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | `d` | `SignalAhead::distance_m` | m |
//! | `v` | `Ego::speed_mps` | m/s |
//! | `tau` | `Config::model_time_constant_s` | s |
//! | margin | [`SignalStop::stop_margin_m`] | m |
//!
//! A silent signal counts as red: a colour is not guessed.

use super::cacc::config::Config;
use super::cacc::{self, Signals};
use law::following::driver::{Driver, Obstacle};
use law::following::kinematics::{Lag, Motion};
use law::following::soft_stop::{Room, soften};
use law::settings::{Settings, Table};
use law::{
    Descriptor, Figure, Formulation, GapPolicy, Input, Law, ModeMemory, Output, Phase, SignalAhead,
};

const TABLE: Table = Table::of::<SignalStop>("signal_stop");

pub static ACC_SIGNAL_STOP: Descriptor = Descriptor {
    name: "acc-signal-stop",
    description: "predictive following with a driver's stop for red and yellow, blind to countdowns",
    source: "He et al. 2024 (ACC with a decision layer); ITE 2020 (reaction, yellow)",
    table: Some(TABLE),
    formulations: &[&FORMULATION],
    formulation: |_| &FORMULATION,
    gap: GapPolicy::Scenario(cacc::desired_gap),
    measured_target: false,
    trucks_alone: false,
    // Its modes and figures are its own: the commands are those of `acc-mpc`.
    build: |reader| {
        let settings: SignalStop = reader.table(TABLE.name)?;
        let (acc, config) = cacc::of(reader, Signals::Ignored)?;
        Ok(Box::new(StoppingLaw::new(acc, settings, &config)))
    },
};

law::settings! {
    /// Settings of the driver who stops at signals; decelerations are positive numbers.
    pub struct SignalStop {
        /// Distance from the stop line at which the signal's colour is seen, m.
        sight_m: f64 = 150.0, "m", 10.0..=1000.0,
            "Source: MUTCD 2009, table 4D-2: a signal shall be visible from 140 m at 45 mph (20 m/s), less below.";
        /// Time from a change of colour to the driver's response, s.
        reaction_s: f64 = 1.0, "s", 0.0..=5.0,
            "Source: ITE (2020), Guidelines for determining traffic signal change and clearance intervals: 1.0 s.";
        /// Deceleration up to which a yellow or a new red is stopped for; beyond it the drive goes on, m/s².
        yellow_deceleration_mps2: f64 = 3.05, "m/s²", 0.5..=12.0, "Source: ITE (2020), the same: 10 ft/s².";
        /// Deceleration that a stop aims at, m/s².
        stop_deceleration_mps2: f64 = 1.7, "m/s²", 0.2..=12.0,
            "Chosen: as `cacc-mpc`'s reference driver, so that only the rule differs.";
        /// Distance of the stop ahead of the line, m.
        stop_margin_m: f64 = 1.0, "m", 0.3..=20.0, "Chosen: as `cacc-mpc`'s reference driver.";
    }
}

impl Settings for SignalStop {}

pub static FORMULATION: Formulation = Formulation {
    name: "signal-stop",
    caution: None,
    modes: &["cruise", "follow", "go-on", "stop"],
    reasons: &["start", "target-lost", "target-found", "too-late-to-stop", "closed"],
    figures: &[
        Figure::new("gap_error_m", "m").meaning("desired minus real gap; positive: too close"),
        Figure::new("speed_error_mps", "m/s").meaning("speed minus the target's"),
    ],
};

/// Room that a soft stop leaves to the line, m.
const LINE_ROOM_M: f64 = 0.3;
/// Below this speed a vehicle at a closed line waits, m/s.
const STANDSTILL_MPS: f64 = 0.1;

/// Decision of the driver at the nearest signal.
#[derive(Clone, Copy, Debug)]
struct Watched {
    id: u32,
    /// Green, yellow or red.
    seen: Phase,
    since_s: f64,
    heeded: Option<Phase>,
    /// It was too late to stop when the signal closed.
    goes_on: bool,
}

/// `acc-mpc` with a driver's signal stop.
struct StoppingLaw {
    acc: Box<dyn Law + Send>,
    settings: SignalStop,
    driver: Driver,
    lag: Lag,
    watched: Option<Watched>,
    mode: ModeMemory,
}

impl StoppingLaw {
    /// The layer above `acc`, which was built with `config`.
    fn new(acc: Box<dyn Law + Send>, settings: SignalStop, config: &Config) -> Self {
        let driver = Driver {
            acceleration_mps2: config.road.acceleration_mps2,
            deceleration_mps2: settings.stop_deceleration_mps2,
            hardest_mps2: -config.min_request_mps2,
        };
        let lag = Lag { tau_s: config.model_time_constant_s };
        Self { acc, settings, driver, lag, watched: None, mode: ModeMemory::default() }
    }

    /// Watches the nearest signal in sight; returns the distance to its line if it is to be stopped at.
    fn watch(&mut self, input: &Input) -> Option<f64> {
        let in_sight =
            |s: &&SignalAhead| s.distance_m > 0.0 && s.distance_m <= self.settings.sight_m;
        let Some(signal) = input.signals.iter().flatten().find(in_sight) else {
            self.watched = None;
            return None;
        };
        let shown = signal.intervals[..signal.count.min(1)].first().map(|now| now.phase);
        let seen = shown.filter(|phase| *phase != Phase::Unknown).unwrap_or(Phase::Red);
        let now_s = input.time_s;
        let first = Watched { id: signal.id, seen, since_s: now_s, heeded: None, goes_on: false };
        let mut watched = self.watched.filter(|before| before.id == signal.id).unwrap_or(first);
        if watched.seen != seen {
            (watched.seen, watched.since_s) = (seen, now_s);
        }
        let is_heeded = now_s - watched.since_s >= self.settings.reaction_s - 1e-9;
        if is_heeded && watched.heeded != Some(seen) {
            watched.goes_on = match (watched.heeded, seen) {
                (_, Phase::Green) => false,
                // It went on through this signal's yellow, or could not stop for it.
                (Some(Phase::Yellow), Phase::Red) if watched.goes_on => true,
                _ => self.is_too_late(input, signal.distance_m),
            };
            watched.heeded = Some(seen);
        }
        self.watched = Some(watched);
        let closed = matches!(watched.heeded, Some(Phase::Yellow | Phase::Red));
        (closed && !watched.goes_on).then_some(signal.distance_m)
    }

    /// True if a stop would need more than the driver brakes for a yellow.
    fn is_too_late(&self, input: &Input, distance_m: f64) -> bool {
        let v = input.ego.speed_mps.max(0.0);
        let room_m = distance_m - self.settings.stop_margin_m - self.lag.tau_s * v;
        v * v > 2.0 * self.settings.yellow_deceleration_mps2 * room_m.max(0.0) && v > STANDSTILL_MPS
    }

    /// The request in front of a closed line.
    fn stop_mps2(&self, input: &Input, line_m: f64, follow_mps2: f64) -> f64 {
        let ego = Motion { speed_mps: input.ego.speed_mps.max(0.0), ..input.ego.motion() };
        let line = Obstacle::line(line_m, self.settings.stop_margin_m);
        let desired_mps = input.wanted_speed_mps();
        let mut request = self.driver.follow_mps2(ego.speed_mps, desired_mps, &line);
        request = request.min(follow_mps2);
        if line_m < self.settings.stop_margin_m + 1.0 && ego.speed_mps < STANDSTILL_MPS {
            request = request.min(0.0);
        }
        let room = Room { wanted_m: line_m - LINE_ROOM_M, spare_m: 0.0 };
        soften(request, ego, self.lag.tau_s, room).min(follow_mps2)
    }
}

impl Law for StoppingLaw {
    fn reset(&mut self) {
        self.acc.reset();
        (self.watched, self.mode) = (None, ModeMemory::default());
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        self.acc.step(input, output);
        let [gap_error_m, speed_error_mps, ..] = output.figures;
        output.figures = [0.0; _];
        output.figures[..2].copy_from_slice(&[gap_error_m, speed_error_mps]);
        let stop_at_m = if input.is_plausible() { self.watch(input) } else { None };
        if let Some(line_m) = stop_at_m {
            let (low, high) = self.request_bounds_mps2();
            let request = self.stop_mps2(input, line_m, output.request_mps2()).clamp(low, high);
            // The follower's plan ignores the line: its rest must not undo the braking.
            for planned in &mut output.plan_mps2[..output.plan_len] {
                *planned = planned.min(request);
            }
        }
        let goes_on = self.watched.is_some_and(|watched| watched.goes_on);
        let mode = match (stop_at_m, input.target) {
            (Some(_), _) => 3,
            (None, _) if goes_on => 2,
            (None, Some(_)) => 1,
            (None, None) => 0,
        };
        self.mode.note(output, mode, |_| mode + 1);
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        self.acc.request_bounds_mps2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cacc::build;
    use law::{Ego, PhaseInterval};

    const PERIOD_S: f64 = 0.1;

    /// A drive at 13 m/s towards a line at 200 m that shows each phase from its time on. Returns its place and speed
    /// after `seconds`, its hardest braking, and the time at which it crossed the line.
    fn drive(seconds: f64, phases: &[(f64, Phase)]) -> (Motion, f64, Option<f64>) {
        let config = Config::default();
        let acc = build(Signals::Ignored, &config).expect("the default is valid");
        let mut law = StoppingLaw::new(acc, SignalStop::default(), &config);
        let step = Lag { tau_s: config.model_time_constant_s }.discretise(PERIOD_S);
        let mut ego = Motion { speed_mps: 13.0, ..Motion::default() };
        let (mut hardest, mut crossed, mut output) = (0.0_f64, None, Output::default());
        for k in 0..(seconds / PERIOD_S) as u32 {
            let time_s = f64::from(k) * PERIOD_S;
            let phase = phases.iter().rfind(|(from_s, _)| *from_s <= time_s).expect("at 0 s").1;
            let mut signal = SignalAhead { id: 256, count: 1, ..SignalAhead::default() };
            signal.distance_m = 200.0 - ego.position_m;
            // A phase that is announced to end at once is left out.
            signal.intervals[0] = PhaseInterval { phase, ends_in_s: 0.1 };
            let mut input = Input {
                time_s,
                period_s: PERIOD_S,
                ego: Ego {
                    position_m: ego.position_m,
                    speed_mps: ego.speed_mps,
                    acceleration_mps2: ego.acceleration_mps2,
                },
                set_speed_mps: 13.0,
                speed_limit_mps: f64::INFINITY,
                ..Input::default()
            };
            input.signals[0] = Some(signal);
            law.step(&input, &mut output);
            ego = step.advance(ego, output.request_mps2());
            hardest = hardest.min(ego.acceleration_mps2);
            if ego.position_m >= 200.0 {
                crossed.get_or_insert(time_s);
            }
        }
        (ego, hardest, crossed)
    }

    #[test]
    fn it_stops_for_red_at_the_line_and_starts_a_reaction_after_green() {
        let (ego, hardest, _) = drive(40.0, &[(0.0, Phase::Red)]);
        assert!((198.0..199.8).contains(&ego.position_m) && ego.speed_mps == 0.0, "{ego:?}");
        assert!(hardest > -2.5, "{hardest}");
        let (.., crossed) = drive(60.0, &[(0.0, Phase::Red), (40.0, Phase::Green)]);
        let after_s = crossed.expect("it starts") - 40.0;
        assert!((2.0..4.0).contains(&after_s), "{after_s}");
    }

    #[test]
    fn a_yellow_is_stopped_for_where_that_is_comfortable_and_else_driven_through() {
        // At 13 m/s: 80 m before the line, and 25 m.
        let early = drive(40.0, &[(0.0, Phase::Green), (9.2, Phase::Yellow), (13.2, Phase::Red)]);
        assert!(early.2.is_none() && early.1 > -3.3, "{early:?}");
        let late = drive(40.0, &[(0.0, Phase::Green), (13.5, Phase::Yellow), (16.5, Phase::Red)]);
        assert!(late.2.is_some_and(|crossed| crossed < 16.5) && late.1 > -0.1, "{late:?}");
    }

    #[test]
    fn the_colour_is_not_seen_from_farther_than_the_sight_distance() {
        let (ego, ..) = drive(3.5, &[(0.0, Phase::Red)]);
        assert!((ego.speed_mps - 13.0).abs() < 0.05, "{ego:?}");
    }
}
