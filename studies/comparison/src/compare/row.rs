//! A run of a comparison: its record.

use group::RequirementVerdict;
use group::report::Outcome;
use report::summary::{Aebs, Control, LawAccount, Summary, Timing};
use serde::{Deserialize, Serialize};

use crate::figure::Measured;

/// A run.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    pub scenario: String,
    pub controller: String,
    pub seed: u64,
    pub mode: String,
    pub outcome: Outcome,
    pub control: Control,
    pub timing: Timing,
    pub aebs: Braking,
    #[serde(default)]
    pub law: Option<LawAccount>,
    #[serde(default)]
    pub requirements: Vec<RequirementVerdict>,
}

impl Row {
    /// The row of a run of the scenario that is named `label` in results.
    pub fn new(label: &str, summary: Summary) -> Self {
        Self {
            scenario: label.to_owned(),
            controller: summary.controller,
            seed: summary.seed,
            mode: summary.mode.to_owned(),
            outcome: summary.outcome,
            control: summary.control,
            timing: summary.timing,
            aebs: Braking::of(&summary.aebs),
            law: summary.law,
            requirements: summary.requirements,
        }
    }
}

impl<'a> From<&'a Row> for Measured<'a> {
    fn from(row: &'a Row) -> Self {
        let Row { control, timing, aebs, .. } = row;
        Self { control, timing, interventions: aebs.interventions }
    }
}

/// Interventions of the emergency brake in a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Braking {
    pub enabled: bool,
    pub warnings: Option<u64>,
    pub interventions: Option<u64>,
    pub braking_s: Option<f64>,
}

impl Braking {
    fn of(aebs: &Aebs) -> Self {
        let Aebs { enabled, warnings, interventions, braking_s, .. } = *aebs;
        Self { enabled, warnings, interventions, braking_s }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use group::report::ControlFigures;
    use report::{Following, Trip};

    /// A row of a car: without fuel, and without deadlines, since it was driven in lockstep.
    pub fn row(controller: &str, seed: u64, min_gap_m: f64) -> Row {
        let figures = ControlFigures {
            min_gap_m: Some(min_gap_m),
            rms_gap_error_m: Some(0.5),
            ..ControlFigures::default()
        };
        let following = Following { min_time_gap_s: Some(1.25), median_time_gap_s: Some(1.5) };
        Row {
            scenario: "following".into(),
            controller: controller.into(),
            seed,
            mode: "lockstep".into(),
            outcome: Outcome::Completed,
            control: Control { figures, following, trip: Trip::default(), mode_changes: None },
            timing: Timing::default(),
            aebs: Braking { interventions: Some(2), ..Braking::default() },
            law: None,
            requirements: Vec::new(),
        }
    }
}
