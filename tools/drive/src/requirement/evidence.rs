//! The facts that a drive is judged by, and a rule's finding.

use crate::Drive;
use scenario::Scenario;
use temporal_logic::Unit;

/// A drive with what judges it: the ground truth, and nothing of radar, law and emergency brake.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// The scenario that was driven.
    pub scenario: &'a Scenario,
    pub drive: &'a Drive,
    /// The referee's speed difference at the contact, m/s; `None` without a collision.
    pub impact_speed_mps: Option<f64>,
}

/// Margin by which a rule holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Finding {
    /// Distance to violation, in `unit`.
    pub value: f64,
    pub unit: Unit,
    /// Run time of the instant that decides, s.
    pub time_s: f64,
    pub met: bool,
}

impl Finding {
    /// A rule that nothing of the drive decides.
    pub(super) const UNDECIDED: Self =
        Self { value: f64::INFINITY, unit: Unit::METRE, time_s: 0.0, met: true };
}
