//! Plausibility of the inputs.
//!
//! The end-to-end protection finds what was changed on the way, not what its sender made up. A sender may
//! repeat itself under fresh stamps, or its figures may be off. It then contradicts itself, another sensor or
//! its earlier messages:
//!
//! | check | compares | consequence |
//! |---|---|---|
//! | [`Check::SpeedAgainstPosition`] | odometry's position with its speed, from sample to sample and summed up | odometry is not used |
//! | [`Check::VehicleLimits`] | odometry's change of speed with what a vehicle can do | the same |
//! | [`Check::SpeedAgainstRadar`] | odometry's speed with that of what stands beside the road | the same |
//! | [`Check::SpeedAgainstCommand`] | odometry that stands still in every figure with the commands meanwhile | the same |
//! | [`Check::RadarFrozen`] | a scan with the one before: noise never repeats itself, nor do exact range rates while the ego's speed changes | the radar is not used |
//! | [`Check::RangeRateAgainstRange`] | the change of a track's range with its range rate | the same |
//! | [`Check::TargetAgainstTrack`] | the target with the track that it is made of | of each figure the more careful one |
//! | [`Check::CountdownAgainstClock`] | the end of a shown phase with the time of its switch | announced ends lose trust, see [`countdown`] |
//! | [`Check::CountdownAgainstHistory`] | announced ends with those announced before | the same |
//!
//! While odometry is not used, [`estimate::EgoEstimate`] goes on from its last value for a while. The plant checks
//! commands: one whose cycle began before the time it is stamped with is an earlier one.
//!
//! Three faults cannot be found without another sensor. Odometry may have both position and speed wrong, with no object
//! beside the road for the radar. A frozen radar may show an empty road. A countdown may be off from the first
//! announcement on, until a phase ends at another time.

pub mod countdown;
pub mod estimate;
pub mod motion;
pub mod radar;

use crate::report::CheckReport;
use crate::sampling::Setting;
use messages::{Odometry, RadarTracks, Spat, numbered};
use scenario::Scenario;
use scenario::perception::RadarModel;

numbered! {
    /// A check of the inputs.
    pub enum Check {
        /// Odometry's position against its speed.
        SpeedAgainstPosition = 0 "speed-against-position",
        /// Odometry's change of speed against a vehicle's limits.
        VehicleLimits = 1 "vehicle-limits",
        /// Odometry's speed against the radar's.
        SpeedAgainstRadar = 2 "speed-against-radar",
        /// Odometry's standstill against the commands.
        SpeedAgainstCommand = 3 "speed-against-command",
        /// A scan against the one before.
        RadarFrozen = 4 "radar-frozen",
        /// Change of a range against its rate.
        RangeRateAgainstRange = 5 "range-rate-against-range",
        /// Target against its track.
        TargetAgainstTrack = 6 "target-against-track",
        /// End of a shown phase against the time.
        CountdownAgainstClock = 7 "countdown-against-clock",
        /// Announced ends against earlier ones.
        CountdownAgainstHistory = 8 "countdown-against-history",
    }
}

/// Findings of a check over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finding {
    /// Cycles in which it found a contradiction.
    pub cycles: u64,
    /// Release of the first of them, s.
    pub first_s: Option<f64>,
    /// Largest value seen in a cycle without a contradiction, as a share of the threshold.
    pub nearest: f64,
}

/// Findings of each check.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Findings {
    of: [Finding; Check::ALL.len()],
}

impl Findings {
    /// Notes what `check` found at `time_s`: its value as a share of the threshold.
    pub(crate) fn note(&mut self, check: Check, time_s: f64, share: f64) -> bool {
        let finding = &mut self.of[check as usize];
        let contradicts = share > 1.0;
        if contradicts {
            finding.cycles += 1;
            finding.first_s = finding.first_s.or(Some(time_s));
        } else {
            finding.nearest = finding.nearest.max(share);
        }
        contradicts
    }

    /// Report of the run: the checks that found a contradiction, and how near the others came.
    pub fn report(&self) -> Vec<CheckReport> {
        let report = |(check, finding): (Check, &Finding)| CheckReport {
            check: check.name().to_owned(),
            cycles: finding.cycles,
            first_s: finding.first_s,
            nearest: finding.nearest,
        };
        Check::ALL.into_iter().zip(&self.of).map(report).collect()
    }

    /// The finding of a check.
    pub fn of(&self, check: Check) -> &Finding {
        &self.of[check as usize]
    }
}

/// The valid parts of the inputs.
#[derive(Debug)]
pub struct TrustedInputs<'a> {
    /// Odometry; `None` if it contradicts something.
    pub odometry: Option<&'a Odometry>,
    /// Tracks; `None` if they contradict something.
    pub radar: Option<&'a RadarTracks>,
    /// Signal timing, as far as its announcements hold.
    pub spat: Option<&'a Spat>,
    /// Signal timing was cut down to that.
    pub signals_doubted: bool,
}

/// Checks all inputs of one controller.
#[derive(Debug)]
pub struct Plausibility {
    motion: motion::Motion,
    radar: radar::Radar,
    countdown: countdown::Countdown,
    pub findings: Findings,
}

impl Plausibility {
    /// Nothing seen yet, with the radar and the clocks of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let (model, keys) = (scenario.perception.model(), &scenario.perception.radar);
        let range_sigma_m =
            if model == RadarModel::ObjectList { keys.range_sigma_m.value() } else { 0.0 };
        let clocks_s = Setting::of(scenario, false).clock_tolerance_s;
        Self {
            motion: motion::Motion::default(),
            radar: radar::Radar::new(model != RadarModel::Ideal, range_sigma_m),
            countdown: countdown::Countdown::new(clocks_s),
            findings: Findings::default(),
        }
    }

    /// Takes the newest samples at the release at `time_s`, with the request of the last command, m/s².
    pub fn look<'a>(
        &'a mut self,
        odometry: Option<&'a Odometry>,
        radar: Option<&RadarTracks>,
        spat: Option<&'a Spat>,
        commanded_mps2: f64,
        time_s: f64,
    ) -> TrustedInputs<'a> {
        let Self { motion, radar: radars, countdown, findings } = self;
        let radar = radar.and_then(|sample| radars.look(sample, odometry, time_s, findings));
        let odometry = odometry
            .filter(|sample| motion.agrees(sample, radar, commanded_mps2, time_s, findings));
        let (spat, signals_doubted) = match spat.map(|s| countdown.look(s, time_s, findings)) {
            Some((believed, contradicts)) => (Some(believed), contradicts),
            None => (None, false),
        };
        TrustedInputs { odometry, radar, spat, signals_doubted }
    }
}

#[cfg(test)]
mod countdown_tests;
#[cfg(test)]
mod estimate_tests;
#[cfg(test)]
mod radar_tests;
#[cfg(test)]
mod shares_tests;
