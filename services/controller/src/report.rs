//! Figures that the controller reports at its end.

use law::ProgramReport;
use messages::level::Levels;
use runtime::statistics::Percentiles;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Figures of the law and its loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerReport {
    /// Deadline after each scheduled release, µs.
    pub deadline_us: f64,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: u64,
    /// Time inside the law, on the wall clock in both modes.
    pub solve_us: Option<Percentiles>,
    /// Cycles whose command was relaxed.
    pub relaxed: u64,
    /// Cycles whose command came from the law's backup.
    pub backup: u64,
    /// Cycles in which the degradation ladder braked in the law's place.
    #[serde(default)]
    pub braked: u64,
    /// Planning beside the loop, of laws that do.
    pub planning: Option<PlanningReport>,
    /// Name of the law that drove; empty where only the launcher counted.
    #[serde(default)]
    pub law: String,
    /// Counts of the program of a foreign law.
    #[serde(default)]
    pub program: Option<ProgramReport>,
    /// Changes of the law's mode.
    pub mode_changes: Vec<ModeChange>,
    /// The controller's way on the degradation ladder.
    pub rungs: Levels,
    /// Findings of the checks of its inputs.
    #[serde(default)]
    pub checks: Vec<CheckReport>,
}

/// Findings of one check of the controller's inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckReport {
    /// The check.
    pub check: String,
    /// Cycles in which it found a contradiction.
    pub cycles: u64,
    /// Release of the first of them, s.
    pub first_s: Option<f64>,
    /// Largest value in a cycle without a contradiction, as a share of the threshold.
    pub nearest: f64,
}

/// Timeliness of the planning beside a control loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanningReport {
    /// Plans asked for.
    pub asked: u64,
    /// Plans that were late: the loop went on with the previous plan.
    pub late: u64,
    /// Time after which a plan is due, µs.
    pub deadline_us: f64,
    /// Time that a plan took, on the wall clock in both modes.
    pub plan_us: Option<Percentiles>,
}

/// A change of the law's mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeChange {
    /// Run time, s.
    pub t_s: f64,
    /// Mode left.
    pub from: String,
    /// Mode entered.
    pub to: String,
    /// Why.
    pub reason: String,
    /// The law's figures in the cycle of the change, by name.
    pub figures: BTreeMap<String, f64>,
}
