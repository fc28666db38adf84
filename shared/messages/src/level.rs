//! The degradation ladder: how far down a service is, and the record of its ways down and up.
//!
//! | level | who | entered | left |
//! |---|---|---|---|
//! | [`Level::Full`] | both | at the start | |
//! | [`Level::SignalsLost`] | controller | no valid `v2x/spat` for three of its periods | three releases in a row with a fresh one |
//! | [`Level::SignalsDoubted`] | controller | an announced end of a signal ahead was contradicted by what was seen | phases end as announced again |
//! | [`Level::SolveFailed`] | controller | the law used its backup, or the cycle missed its deadline | three releases in a row in order |
//! | [`Level::OutsideEnvelope`] | controller | the state is outside the range that the law is made for: its fall-back drives | the law drives again |
//! | [`Level::LeadPredicted`] | controller | no valid `radar/tracks` for three of its periods and the radar's latency, or a lead that mattered is not among its tracks and was not seen to leave the lane (for 3 s) | two releases in a row with a fresh one; the lead is seen again |
//! | [`Level::LeadLost`] | controller | no valid `radar/tracks` for 2 s longer, or at the start none yet for as long | five releases in a row with a fresh one |
//! | [`Level::EgoEstimated`] | controller | no valid `vehicle/odometry` for 0.1 s, or one that contradicts itself, the radar or the commands: the radar's measurement of the ego's speed takes its place for up to 10 s, the commands for up to 1.5 s | a fresh one that contradicts nothing |
//! | [`Level::SensorLimited`] | controller | the radar reports that it sees less than it should (`seen_share` of `radar/tracks`) | it has seen enough for 5 s |
//! | [`Level::Silent`] | controller | the same for longer, or at the start | two releases in a row with odometry |
//! | [`Level::PlanFollowed`] | plant | a control period passed without a new valid command | a valid command |
//! | [`Level::StopInLane`] | plant | the plan was followed for `plant.fallback.follow_plan_s`, or the launcher asked for it | a valid command; never, if the launcher asked |
//! | [`Level::Emergency`] | plant | the emergency brake brakes, or holds the brakes | it has let go |
//! | [`Level::AebsLost`] | plant | no valid `safety/brake` for three of its periods, or one that says that it sees nothing | a valid one that sees |
//!
//! Each service is on one level at a time: the lowest one (furthest down this table) that applies. The loss
//! of the emergency brake is an exception: it shows only where nothing else does.

use crate::numbered;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

numbered! {
    /// A level of the ladder, by its number in messages. Numbers never change, so that new levels come last.
    #[derive(Default, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Level {
        /// All inputs are there and in time.
        #[default]
        Full = 0 "full",
        /// Only what the last signal timing still proves is used; a light not known to be green stops.
        SignalsLost = 1 "signals-lost",
        /// The law's backup, or the last plan, commands.
        SolveFailed = 2 "solve-failed",
        /// The target is predicted from its last state.
        LeadPredicted = 3 "lead-predicted",
        /// The road ahead is unknown: braking for what was last seen, the driver is asked to take over.
        LeadLost = 4 "lead-lost",
        /// No command, except a last one that brakes: the ego's own motion is not known.
        Silent = 5 "silent",
        /// The plant follows the rest of the last plan.
        PlanFollowed = 6 "plan-followed",
        StopInLane = 7 "stop-in-lane",
        /// The emergency brake acts.
        Emergency = 8 "emergency",
        /// There is no emergency brake; the controller's commands still act.
        AebsLost = 9 "aebs-lost",
        /// The state is outside the range of the law, and its fall-back commands. As far down as `SolveFailed`.
        OutsideEnvelope = 10 "outside-envelope",
        /// The ego's motion is estimated without its odometry.
        EgoEstimated = 11 "ego-estimated",
        /// The radar sees less than it should; its tracks are used.
        SensorLimited = 12 "sensor-limited",
        /// Announced ends of signals are not used, or with a margin; the shown phases are. Milder than `SignalsLost`.
        SignalsDoubted = 13 "signals-doubted",
    }
}

/// Changes that are kept; the time on each level is counted on.
const MAX_CHANGES: usize = 1024;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelChange {
    /// Run time, s.
    pub t_s: f64,
    pub from: Level,
    pub to: Level,
}

/// Report of a service on its ladder.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Levels {
    /// Time on each level that was entered, s.
    pub time_s: BTreeMap<String, f64>,
    pub changes: Vec<LevelChange>,
}

/// Follows a service on its ladder; allocates nothing once made.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LevelLog {
    pub now: Level,
    last_s: f64,
    time_s: [f64; Level::ALL.len()],
    changes: Vec<LevelChange>,
}

impl Default for LevelLog {
    fn default() -> Self {
        Self {
            now: Level::Full,
            last_s: 0.0,
            time_s: [0.0; Level::ALL.len()],
            changes: Vec::with_capacity(MAX_CHANGES),
        }
    }
}

impl LevelLog {
    /// Begins at `time_s` on `level`, for a service that joins late.
    pub fn begin(&mut self, time_s: f64, level: Level) {
        (self.last_s, self.now) = (time_s, level);
    }

    pub fn observe(&mut self, time_s: f64, level: Level) {
        self.time_s[self.now as usize] += (time_s - self.last_s).max(0.0);
        self.last_s = time_s;
        if level != self.now {
            if self.changes.len() < MAX_CHANGES {
                self.changes.push(LevelChange { t_s: time_s, from: self.now, to: level });
            }
            self.now = level;
        }
    }

    pub fn report(&self) -> Levels {
        let entered = Level::ALL.iter().filter(|&&level| self.time_s[level as usize] > 0.0);
        Levels {
            time_s: entered
                .map(|&level| (level.name().to_owned(), self.time_s[level as usize]))
                .collect(),
            changes: self.changes.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_charged_to_the_rung_that_was_left() {
        let mut log = LevelLog::default();
        for (time_s, level) in
            [(1.0, Level::Full), (2.0, Level::LeadLost), (2.5, Level::LeadLost), (4.0, Level::Full)]
        {
            log.observe(time_s, level);
        }
        let report = log.report();
        assert_eq!(report.time_s["full"], 2.0);
        assert_eq!(report.time_s["lead-lost"], 2.0);
        assert_eq!(report.changes.len(), 2);
        assert_eq!(
            report.changes[1],
            LevelChange { t_s: 4.0, from: Level::LeadLost, to: Level::Full }
        );
    }

    #[test]
    fn numbers_and_names_are_one_to_one() {
        for (number, level) in Level::ALL.into_iter().enumerate() {
            let number = u32::try_from(number).expect("few");
            assert_eq!(Level::by_number(number), Some(level));
            assert_eq!(level as u32, number);
        }
        assert_eq!(Level::by_number(Level::ALL.len() as u32), None);
    }
}
