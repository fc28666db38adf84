//! Critical phases of drives: those that a fault can turn into an accident, and the phases in which faults struck.
//!
//! A campaign whose faults strike where nothing happens shows nothing.

use messages::PhaseState;
use scenario::Scenario;
use scenario::faults::STANDSTILL_MPS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use supervise::{DriveStep, FaultRecord};

/// Time to collision below which a phase is critical, s.
pub const CRITICAL_TTC_S: f64 = 4.0;
/// Braking above which a phase is critical, m/s².
pub const CRITICAL_BRAKING_MPS2: f64 = 1.5;
/// Distance to a red line below which a phase is critical, m.
pub const CRITICAL_LINE_M: f64 = 80.0;
/// Assumed length of a process fault without a known recovery, s.
const PROCESS_FAULT_S: f64 = 0.1;

/// A phase of the drive in which a fault can do harm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The time to collision is short.
    Closing,
    RedLine,
    Braking,
    /// A vehicle moves into the ego's lane.
    CutIn,
    /// The ego stands.
    Standstill,
}

impl Phase {
    pub const ALL: [Self; 5] =
        [Self::Closing, Self::RedLine, Self::Braking, Self::CutIn, Self::Standstill];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Closing => "closing",
            Self::RedLine => "red-line",
            Self::Braking => "braking",
            Self::CutIn => "cut-in",
            Self::Standstill => "standstill",
        }
    }

    /// True if a drive is in this phase at `step`.
    pub fn holds(self, step: &DriveStep) -> bool {
        match self {
            Self::Closing => step.time_to_collision_s < CRITICAL_TTC_S,
            Self::RedLine => {
                step.signal == Some(PhaseState::StopAndRemain) && step.stop_line_m < CRITICAL_LINE_M
            }
            Self::Braking => step.acceleration_mps2 < -CRITICAL_BRAKING_MPS2,
            Self::CutIn => step.cut_in,
            Self::Standstill => step.speed_mps < STANDSTILL_MPS,
        }
    }
}

/// The phases in which the faults of a run struck.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Struck {
    pub faults: u64,
    /// Faults that acted in a critical phase.
    pub critical: u64,
    /// Faults that acted in each phase.
    pub phases: BTreeMap<String, u64>,
}

impl Struck {
    pub fn of(scenario: &Scenario, faults: &[FaultRecord], steps: &[DriveStep]) -> Self {
        let mut struck = Self::default();
        for record in faults {
            let asked = scenario.faults.get(record.number as usize);
            // A fault that disturbed no message met nothing.
            let Some(fault) = asked.filter(|_| record.messages != Some(0)) else { continue };
            struck.faults += 1;
            let end_s = match (record.recovered_after_us, fault.effect.extent()) {
                (Some(after_us), _) => record.t_s + after_us / 1e6,
                (None, Some(extent)) => {
                    extent.for_s.map_or(f64::INFINITY, |for_s| record.t_s + for_s.value())
                }
                (None, None) => record.t_s + PROCESS_FAULT_S,
            };
            let from = steps.partition_point(|step| step.time_s < record.t_s).saturating_sub(1);
            let mut met = [false; Phase::ALL.len()];
            for step in &steps[from..] {
                if step.time_s > end_s {
                    break;
                }
                for (phase, met) in Phase::ALL.iter().zip(&mut met) {
                    *met |= phase.holds(step);
                }
            }
            struck.critical += u64::from(met.contains(&true));
            for (phase, _) in Phase::ALL.iter().zip(met).filter(|(_, met)| *met) {
                *struck.phases.entry(phase.name().to_owned()).or_insert(0) += 1;
            }
        }
        struck
    }
}

/// Critical phases of a drive without faults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Exposure {
    pub scenario: String,
    pub controller: String,
    /// Hardest braking, m/s².
    pub hardest_braking_mps2: f64,
    /// Least time to collision, s; null if the ego never closed in.
    pub min_ttc_s: Option<f64>,
    /// Signals that were yellow when the ego was near.
    pub yellows_met: u64,
    /// Signals that were red when the ego was near.
    pub reds_met: u64,
    /// Times that the ego came to a standstill.
    pub standstills: u64,
    /// Times that a vehicle began to come into the lane.
    pub cut_ins: u64,
    /// Time in standstill, s.
    pub standstill_s: f64,
    /// Time with a vehicle on its way into the lane, s.
    pub cut_in_s: f64,
    /// Share of the drive in a critical phase.
    pub critical_share: f64,
}

impl Exposure {
    /// The phases of a drive with evenly spaced steps.
    pub fn of(scenario: String, controller: String, steps: &[DriveStep]) -> Self {
        let period_s = match steps {
            [first, second, ..] => second.time_s - first.time_s,
            _ => 0.0,
        };
        let time_s = |in_it: &dyn Fn(&DriveStep) -> bool| {
            steps.iter().filter(|step| in_it(step)).count() as f64 * period_s
        };
        let critical = |step: &DriveStep| Phase::ALL.iter().any(|phase| phase.holds(step));
        let braking = steps.iter().map(|step| -step.acceleration_mps2);
        let ttc = steps.iter().map(|step| step.time_to_collision_s).filter(|ttc| ttc.is_finite());
        Self {
            scenario,
            controller,
            hardest_braking_mps2: braking.fold(0.0, f64::max),
            min_ttc_s: ttc.reduce(f64::min),
            yellows_met: met(steps, PhaseState::ProtectedClearance),
            reds_met: met(steps, PhaseState::StopAndRemain),
            standstills: beginnings(steps, |step| Phase::Standstill.holds(step)),
            cut_ins: beginnings(steps, |step| step.cut_in),
            standstill_s: time_s(&|step| Phase::Standstill.holds(step)),
            cut_in_s: time_s(&|step| step.cut_in),
            critical_share: time_s(&critical) / (steps.len() as f64 * period_s).max(f64::EPSILON),
        }
    }
}

/// Number of steps at which a state begins.
fn beginnings(steps: &[DriveStep], holds: fn(&DriveStep) -> bool) -> u64 {
    let now = steps.iter().map(holds);
    let before = std::iter::once(false).chain(now.clone());
    now.zip(before).filter(|(now, before)| *now && !before).count() as u64
}

/// Number of stop lines that were near while their signal showed `state`.
fn met(steps: &[DriveStep], state: PhaseState) -> u64 {
    let mut count = 0;
    let mut last_m = None::<f64>;
    for step in
        steps.iter().filter(|step| step.signal == Some(state) && step.stop_line_m < CRITICAL_LINE_M)
    {
        let line_m = step.position_m + step.stop_line_m;
        if last_m.is_none_or(|last_m| (line_m - last_m).abs() > 1.0) {
            count += 1;
        }
        last_m = Some(line_m);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 s at 20 m/s; from 4 s to 6 s it brakes towards a red line at 130 m.
    fn steps() -> Vec<DriveStep> {
        (0..100_u32)
            .map(|k| {
                let time_s = 0.1 * f64::from(k);
                let brakes = (4.0..6.0).contains(&time_s);
                DriveStep {
                    time_s,
                    position_m: 20.0 * time_s,
                    speed_mps: 20.0,
                    acceleration_mps2: if brakes { -3.0 } else { 0.0 },
                    time_to_collision_s: if brakes { 5.0 } else { f64::INFINITY },
                    stop_line_m: if time_s < 6.5 { 130.0 - 20.0 * time_s } else { f64::INFINITY },
                    signal: (time_s < 6.5).then_some(PhaseState::StopAndRemain),
                    ..DriveStep::default()
                }
            })
            .collect()
    }

    #[test]
    fn a_fault_counts_in_the_phases_that_it_met() {
        let text = "schema_version = 1\nname = \"x\"\n[[faults]]\nkind = \"drop\"\n\
            topic = \"radar/tracks\"\nat_s = 1\nfor_s = 1\n[[faults]]\nkind = \"drop\"\n\
            topic = \"radar/tracks\"\nat_s = 3.5\nfor_s = 1\n[[faults]]\nkind = \"drop\"\n\
            topic = \"v2x/spat\"\nat_s = 4\nfor_s = 1\n";
        let scenario = Scenario::parse("x.toml", text).expect("it is right");
        let record = |number: u32, t_s: f64, messages| FaultRecord {
            t_s,
            kind: "drop".into(),
            service: None,
            topic: None,
            helper: None,
            while_starting: false,
            messages: Some(messages),
            undetected: 0,
            detected_after_us: None,
            recovered_after_us: None,
            recovered_by: None,
            number,
            awaits: None,
        };
        let faults = [record(0, 1.0, 20), record(1, 3.5, 20), record(2, 4.0, 0)];
        let struck = Struck::of(&scenario, &faults, &steps());
        assert_eq!((struck.faults, struck.critical), (2, 1));
        let phases: Vec<_> = struck.phases.into_iter().collect();
        assert_eq!(phases, [("braking".to_owned(), 1), ("red-line".to_owned(), 1)]);
    }

    #[test]
    fn a_drive_is_identified_by_its_events() {
        let met = Exposure::of("x".into(), "y".into(), &steps());
        assert_eq!((met.hardest_braking_mps2, met.min_ttc_s), (3.0, Some(5.0)));
        assert_eq!((met.reds_met, met.yellows_met, met.standstill_s), (1, 0, 0.0));
        assert_eq!((met.standstills, met.cut_ins), (0, 0));
        assert_eq!(beginnings(&steps(), |step| Phase::Braking.holds(step)), 1);
        assert!((met.critical_share - 0.4).abs() < 0.02, "{met:?}");
    }
}
