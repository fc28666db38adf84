//! The numbers of a design, as its file holds them.

use super::model::{DISTURBANCES, Parameters, RULES, STATES};
use serde::{Deserialize, Serialize};

/// Largest accepted file, bytes; a design needs about 8000.
pub(super) const LARGEST: usize = 64 * 1024;
/// What the file says it is.
pub(super) const FORMAT: &str = "timegap quadratic-bounded design 1";

/// Numbers of a design, before verification.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Content {
    pub(super) parameters: Parameters,
    pub(super) alpha: f64,
    pub(super) multipliers: [f64; DISTURBANCES],
    pub(super) p: [[f64; 2 * STATES]; 2 * STATES],
    pub(super) rules: [RuleContent; RULES],
}

/// Gains of one rule, by rows.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RuleContent {
    pub(super) ac: [[f64; STATES]; STATES],
    pub(super) l: [[f64; STATES]; STATES],
    pub(super) fx: [f64; STATES],
    pub(super) fy: [f64; STATES],
}
