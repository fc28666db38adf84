//! `[require]`: what a run must keep to count as completed, beside the referee's rules.

use serde::{Deserialize, Serialize};

use super::quantity::{AccelerationMagnitude, Share};
use super::schema::Schema;

/// Requirements on a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Require {
    /// Largest share of the control cycles in which the backup of a law that is a program may drive. Beyond it the
    /// outcome is `driven_by_backup`.
    pub max_backup_share: Share,
    /// Largest lateral acceleration on a road with a plan, m/s². Beyond it the outcome is `requirement_broken`.
    pub max_lateral_mps2: AccelerationMagnitude,
    /// Requirements that the drive is judged by: formulas over its signals, such as `always gap_m > 2`, or names, such as
    /// `min-gap:2`. A drive that breaks one has the outcome `requirement_broken`. docs/search.md lists both.
    pub formulas: Vec<String>,
}

impl Default for Require {
    /// A program in Python needs about 0.5 s to start again. This is 5 % of the default run of 10 s. Twice
    /// that leaves room for late answers, and nine cycles of ten still belong to the law that is judged.
    ///
    /// Drivers stay below 3 m/s² in curves: it is 1.3 times the largest design value of ISO 15622.
    fn default() -> Self {
        Self {
            max_backup_share: Share::of(0.1),
            max_lateral_mps2: AccelerationMagnitude::of(3.0),
            formulas: Vec::new(),
        }
    }
}
