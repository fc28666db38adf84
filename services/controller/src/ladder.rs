//! The controller's part of the degradation ladder: what its inputs still allow.
//!
//! In each cycle [`Ladder::look`] takes the ages of the newest *valid* samples, and the validity of signal timing.
//! [`Ladder::admit`] decides on the law's other inputs. After the step [`Ladder::settle`] names the level. The table of
//! entries and ways back is at [`messages::level`].
//!
//! No law receives a target or a light from a sample that is older than the level's bound. Each level has a way back
//! to full function. [`Ladder::most_mps2`] bounds a law's request while the road ahead is not seen.
//!
//! A release is on the first level of `STRICTEST_FIRST` whose state holds. `PROOFS` has the releases in a row by
//! which an input or the law proves itself again.

use self::caution::{Caution, Departure};
use self::lead::LeadMemory;
use crate::law::{Ego, Input, MAX_PLAN, Output, Quality};
use crate::sampling::SignalTrust;
use messages::level::Level;
use messages::{RadarTracks, Sight};
use scenario::Scenario;
use scenario::perception::RadarModel;

mod blind;
mod caution;
mod lead;

/// Periods of its source after which an input is stale.
const STALE_PERIODS: f64 = 3.0;
/// Shortest age at which an input is stale, s: releases are not exact.
const SHORTEST_STALE_S: f64 = 0.1;
/// Time for which a target is predicted, s. Chosen: with 1 s, losses of 2 s in a row alternate with braking. A law then
/// brakes with 6 m/s² for a lead that brakes with 1.5. The emergency brake does not depend on the tracks.
const PREDICT_S: f64 = 2.0;
/// Time for which announced signal timing is used without a new announcement, s.
const BELIEVE_SIGNALS_S: f64 = 5.0;

const STRICTEST_FIRST: [Level; 10] = [
    Level::Silent,
    Level::LeadLost,
    Level::LeadPredicted,
    Level::SensorLimited,
    Level::EgoEstimated,
    Level::SolveFailed,
    Level::OutsideEnvelope,
    Level::SignalsLost,
    Level::SignalsDoubted,
    Level::Full,
];

/// Parts that prove themselves again after a failure.
#[derive(Clone, Copy, Debug)]
enum Part {
    Odometry,
    Radar,
    /// The radar after a loss that was too long to predict the lead.
    LostRadar,
    Signals,
    Law,
}

/// Releases in a row without a failure that prove a part, in the order of [`Part`]. Chosen: one release may
/// be luck, and a longer loss asks for more proof.
const PROOFS: [u32; 5] = [2, 2, 5, 3, 3];

/// Ages of the newest valid samples, s; `None` without one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ages {
    /// `vehicle/odometry`.
    pub odometry_s: Option<f64>,
    /// `radar/tracks`.
    pub radar_s: Option<f64>,
    /// `v2x/spat`; `None` also without a signal ahead.
    pub spat_s: Option<f64>,
    /// The ego's motion is estimated without its odometry.
    pub ego_is_estimated: bool,
    /// Announced ends were contradicted by what was seen.
    pub signals_doubted: bool,
}

/// Action of this cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Admission {
    /// The law steps, with the input as it now is.
    Law,
    /// Braking for the last seen lead, see [`Ladder::brake`]. It is also the last command before silence: the plant
    /// follows its plan.
    Brake,
    /// No command.
    Silence,
}

/// Releases that each part still has to prove itself, by [`Part`]; 0 for one in order.
#[derive(Clone, Copy, Debug, Default)]
struct Recovery([u32; PROOFS.len()]);

impl Recovery {
    /// Takes whether a part is well now; true while it has failed or has not proved itself again.
    fn observe(&mut self, part: Part, is_well: bool) -> bool {
        let left = &mut self.0[part as usize];
        *left = if is_well { left.saturating_sub(1) } else { PROOFS[part as usize] };
        self.has_failed(part)
    }

    fn has_failed(&self, part: Part) -> bool {
        self.0[part as usize] > 0
    }
}

#[derive(Clone, Debug, Default)]
pub struct Ladder {
    stale_radar_s: f64,
    stale_spat_s: f64,
    /// Age from which odometry is of no use, s.
    pub stale_odometry_s: f64,
    has_signals: bool,
    recovery: Recovery,
    radar_is_fresh: bool,
    memory: LeadMemory,
    caution: Caution,
    departure: Departure,
    /// Time of the last release with a fresh radar sample, or of the first release, s.
    remembered_s: Option<f64>,
    last_request_mps2: f64,
    /// The ego in the last cycle, if it was known.
    last_ego: Option<Ego>,
    level: Level,
}

impl Ladder {
    pub fn new(scenario: &Scenario) -> Self {
        let stale =
            |period_ms: u32| (STALE_PERIODS * f64::from(period_ms) / 1e3).max(SHORTEST_STALE_S);
        let latency_s = f64::from(scenario.perception.radar.latency_ms.value()) / 1e3;
        let latency_s =
            if scenario.perception.model() == RadarModel::Ideal { 0.0 } else { latency_s };
        Self {
            stale_radar_s: stale(scenario.perception.period_ms.value()) + latency_s,
            stale_spat_s: stale(scenario.v2x.period_ms.value()),
            stale_odometry_s: stale(scenario.plant.period_ms.value()),
            has_signals: !scenario.v2x.signals.is_empty(),
            ..Self::default()
        }
    }

    /// Takes the ages at the release at `time_s`; returns the validity of signal timing.
    pub fn look(&mut self, ages: &Ages, time_s: f64) -> SignalTrust {
        let fresh = |age: Option<f64>, limit: f64| age.is_some_and(|age| age <= limit);
        let odometry = fresh(ages.odometry_s, self.stale_odometry_s);
        let spat = !self.has_signals || fresh(ages.spat_s, self.stale_spat_s);
        let radar = fresh(ages.radar_s, self.stale_radar_s);
        let since_s = *self.remembered_s.get_or_insert(time_s);
        let radar_s = ages.radar_s.unwrap_or(time_s - since_s);
        let is_predictable = radar_s <= self.stale_radar_s + PREDICT_S;
        // A lost radar is found again by fresh samples alone.
        let keeps = is_predictable && !self.recovery.has_failed(Part::LostRadar);
        let states = [
            (Level::Silent, self.recovery.observe(Part::Odometry, odometry)),
            (Level::LeadLost, self.recovery.observe(Part::LostRadar, radar || keeps)),
            (Level::LeadPredicted, self.recovery.observe(Part::Radar, radar)),
            (Level::EgoEstimated, ages.ego_is_estimated),
            (Level::SignalsLost, self.recovery.observe(Part::Signals, spat)),
            (Level::SignalsDoubted, ages.signals_doubted),
        ];
        self.level = Level::Full;
        states.into_iter().for_each(|(level, holds)| self.enter_if(holds, level));
        self.radar_is_fresh = radar;
        match ages.spat_s {
            _ if spat => SignalTrust::Announced,
            Some(age_s) if age_s <= BELIEVE_SIGNALS_S => SignalTrust::Proven,
            _ => SignalTrust::None,
        }
    }

    /// Settles what else the law is given. `radar` is the newest radar sample.
    pub fn admit(&mut self, input: &mut Input, radar: Option<&RadarTracks>) -> Admission {
        if self.level == Level::Silent {
            let Some(ego) = self.last_ego.take() else { return Admission::Silence };
            input.ego = ego;
            return Admission::Brake;
        }
        self.last_ego = Some(input.ego);
        let unseen_s = self.remembered_s.map_or(0.0, |then_s| input.time_s - then_s);
        if self.radar_is_fresh {
            self.remembered_s = Some(input.time_s);
            input.target = self.memory.see(input, radar.map_or(&[], RadarTracks::tracks));
            self.enter_if(self.memory.is_missed, Level::LeadPredicted);
        } else if unseen_s > self.stale_radar_s + PREDICT_S {
            // Radar came while the ego's motion was not known: it was of no use then.
            let is_lost = self.recovery.observe(Part::LostRadar, false);
            self.enter_if(is_lost, Level::LeadLost);
        } else {
            let last = self.memory.last();
            input.target = last.map(|last| last.at(&input.ego, input.time_s));
        }
        let sight = self.caution.settle(radar.map(RadarTracks::sight), input.period_s);
        self.enter_if(Caution::heed(sight, input), Level::SensorLimited);
        let is_blind =
            self.memory.is_missed || unseen_s > self.stale_radar_s || sight == Sight::Blind;
        self.caution.observe(is_blind, input);
        self.caution.slow_down(sight, input);
        self.departure.observe(input);
        if self.level == Level::LeadLost { Admission::Brake } else { Admission::Law }
    }

    /// Enters a level whose state holds, unless a stricter one does.
    fn enter_if(&mut self, holds: bool, level: Level) {
        let strictness = |level| STRICTEST_FIRST.iter().position(|one| *one == level);
        if holds && strictness(level) < strictness(self.level) {
            self.level = level;
        }
    }

    /// The law's largest request while the road ahead is not seen, and for a while after, m/s²; infinite otherwise.
    pub fn most_mps2(&self) -> f64 {
        self.caution.most_mps2().min(self.departure.most_mps2())
    }

    /// Takes what the law made of it and whether the last cycle was in time; returns the level.
    pub fn settle(&mut self, output: &Output, in_time: bool) -> Level {
        self.last_request_mps2 = output.request_mps2();
        let solved = in_time && output.quality != Quality::Backup;
        let failed = self.recovery.observe(Part::Law, solved);
        self.enter_if(failed, Level::SolveFailed);
        self.enter_if(output.quality == Quality::FallBack, Level::OutsideEnvelope);
        self.level
    }

    /// Writes a plan that brakes to standstill, in place of the law's and within its bounds. Braking is comfortable, or
    /// harder where the last request was or the lost lead asks for it.
    pub fn brake(&self, ego: &Ego, period_s: f64, (least, _): (f64, f64), output: &mut Output) {
        *output = Output { mode: output.mode, quality: Quality::Backup, ..Output::default() };
        let request = self.last_request_mps2.clamp(least, 0.0);
        let deceleration =
            blind::deceleration_mps2(ego, self.memory.last()).clamp(-request, -least);
        blind::fill(&mut output.plan_mps2, request, deceleration, period_s);
        output.plan_len = MAX_PLAN;
    }
}

#[cfg(test)]
mod bounds_tests;
#[cfg(test)]
mod tests;
