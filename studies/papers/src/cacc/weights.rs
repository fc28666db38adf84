//! Weights of the paper's cost that fit one of its scenarios each. The set that fits all of them is
//! [`JOINT`](controller::laws::cacc::weights::JOINT), the law's own.
//!
//! Source: calibrated against the figures that the paper prints, which has no weights. Figures of all scenarios are
//! rows of `timegap reproduce cacc`.

use controller::laws::cacc::weights::{Weights, set};

/// Fitted to scenario A alone.
pub const SCENARIO_A: Weights = set(19.5, 29.5, 1.29, 1.16e5, 43.8);
/// Fitted to scenario C alone.
pub const SCENARIO_C: Weights = set(1275.0, 9998.0, 0.001, 2.6e7, 306.0);
/// Fitted to Table 3 alone (lead acceleration 2.594 m/s²).
pub const TABLE_3: Weights = set(0.988, 0.516, 0.020, 1401.0, 37.5);
