//! Driver of a run: the law that was asked for, or its backup.

use crate::report::{AebsReport, ControllerReport, Hops, Outcome, PlantReport, ServiceReport};
use runtime::statistics::Percentiles;
use scenario::Scenario;
use serde::{Deserialize, Serialize};

/// Cycles of a drive by who commanded in them.
///
/// ```
/// # use drive::summary::LawAccount;
/// let law = LawAccount { name: "mine".into(), cycles: 600, answered: 50, backup: 550, ..Default::default() };
/// assert_eq!(law.to_string(), "550 of 600 cycles by the backup, not by mine");
/// assert!(law.backup_share() > 0.9);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LawAccount {
    pub name: String,
    pub cycles: u64,
    /// Cycles that the law commanded itself.
    pub answered: u64,
    /// Cycles that the law's backup commanded.
    pub backup: u64,
    /// Answers that no vehicle can follow; null for laws of timegap's own.
    pub refused: Option<u64>,
    /// Answers that came too late; null for laws of timegap's own.
    pub late: Option<u64>,
}

impl LawAccount {
    pub(super) fn of(name: String, cycles: u64, controller: &ControllerReport) -> Self {
        let program = controller.program.as_ref();
        Self {
            name,
            cycles,
            answered: cycles.saturating_sub(controller.backup + controller.braked),
            backup: controller.backup,
            refused: program.map(|program| program.refused),
            late: program.map(|program| program.late),
        }
    }

    /// Share of the cycles that the backup commanded.
    pub fn backup_share(&self) -> f64 {
        if self.cycles == 0 { 0.0 } else { self.backup as f64 / self.cycles as f64 }
    }

    /// The outcome of a run that ended as `reached`: a program of the user's must have driven a completed one. Laws of
    /// timegap's own are counted alone: their backup belongs to them, and drives on purpose where inputs are faulty.
    pub(super) fn judge(&self, reached: Outcome, scenario: &Scenario) -> Outcome {
        let allowed = scenario.require.max_backup_share.value();
        match reached {
            Outcome::Completed if self.refused.is_some() && self.backup_share() > allowed => {
                Outcome::DrivenByBackup
            }
            _ => reached,
        }
    }
}

impl std::fmt::Display for LawAccount {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, cycles, backup, .. } = self;
        write!(f, "{backup} of {cycles} cycles by the backup, not by {name}")
    }
}

/// The emergency brake in a run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Aebs {
    /// True if the scenario has an emergency brake.
    pub enabled: bool,
    /// Number of warnings to the driver; null without an emergency brake.
    pub warnings: Option<u64>,
    pub interventions: Option<u64>,
    /// Time for which it braked or held the brakes, s.
    pub braking_s: Option<f64>,
    /// Time without an emergency brake or without its radar, s.
    pub unavailable_s: Option<f64>,
    /// Radar acquisition to the first cycle of the brake path that uses it, µs.
    pub reaction_time_us: Option<Percentiles>,
    /// Parts of the reaction time.
    pub hops_us: Hops,
    /// Deadline of its cycle after the scheduled release, µs.
    pub deadline_us: Option<f64>,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: Option<u64>,
    /// Time to track objects and decide, µs.
    pub decide_us: Option<Percentiles>,
}

/// Number of interventions, in words.
pub fn braked(interventions: u64) -> String {
    match interventions {
        0 => "the emergency brake never braked".into(),
        1 => "the emergency brake braked once".into(),
        times => format!("the emergency brake braked {times} times"),
    }
}

impl Aebs {
    pub(super) fn of(
        scenario: &Scenario,
        plant: Option<&PlantReport>,
        report: Option<&ServiceReport>,
    ) -> Self {
        let figures = plant.and_then(|plant| plant.aebs.as_ref());
        let own: Option<AebsReport> = report.and_then(|report| report.details.read());
        let own = own.as_ref();
        Self {
            enabled: scenario.has_aebs(),
            warnings: figures.map(|figures| figures.warnings),
            interventions: figures.map(|figures| figures.interventions),
            braking_s: figures.map(|figures| figures.braking_s),
            unavailable_s: figures.map(|figures| figures.unavailable_s),
            reaction_time_us: plant.and_then(|plant| plant.brake_reaction_time_us),
            hops_us: plant.map_or_else(Hops::default, |plant| plant.brake_hops_us),
            deadline_us: own.map(|own| own.deadline_us),
            deadline_misses: own.map(|own| own.deadline_misses),
            decide_us: own.and_then(|own| own.decide_us),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario() -> Scenario {
        Scenario::parse("a.toml", "schema_version = 1\nname = \"a\"").expect("it is valid")
    }

    #[test]
    fn a_completed_run_of_the_backup_is_named_so_and_a_worse_outcome_stays() {
        let by =
            |backup| LawAccount { cycles: 100, backup, refused: Some(0), ..LawAccount::default() };
        let judged = |backup, reached| by(backup).judge(reached, &scenario());
        assert_eq!(judged(10, Outcome::Completed), Outcome::Completed);
        assert_eq!(judged(11, Outcome::Completed), Outcome::DrivenByBackup);
        assert_eq!(judged(90, Outcome::Collision), Outcome::Collision);
        assert_eq!(
            LawAccount::default().judge(Outcome::Completed, &scenario()),
            Outcome::Completed
        );
    }
}
