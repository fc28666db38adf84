//! The numbers of a design, as its file holds them.

use super::model::{DISTURBANCES, Parameters, RULES, STATES};
use serde::{Deserialize, Serialize};

/// Largest accepted file, bytes; a design needs about 8000.
pub(super) const LARGEST: usize = 64 * 1024;
/// Claims of the file.
pub(super) const FORMAT: &str = "timegap quadratic-bounded design 1";

/// Numbers of a design, before verification.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Content {
    /// Purpose of the design.
    pub parameters: Parameters,
    /// Rate of contraction.
    pub alpha: f64,
    /// Multipliers of the disturbances, a.
    pub multipliers: [f64; DISTURBANCES],
    /// P of the ellipsoid.
    pub p: [[f64; 2 * STATES]; 2 * STATES],
    /// Gains of the two rules.
    pub rules: [RuleContent; RULES],
}

/// Gains of one rule, by rows.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RuleContent {
    /// Ac.
    pub ac: [[f64; STATES]; STATES],
    /// L.
    pub l: [[f64; STATES]; STATES],
    /// Fx.
    pub fx: [f64; STATES],
    /// Fy.
    pub fy: [f64; STATES],
}
