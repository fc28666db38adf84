//! `[require]`: what a run must keep to count as completed, beside the referee's rules.

use scenario_derive::tables;

use crate::quantity::{AccelerationMagnitude, Share};

tables! {
    /// Requirements on a run.
    pub struct Require {
        /// Largest share of the control cycles in which the backup of a law that is a program may drive. Beyond it the
        /// outcome is `driven_by_backup`.
        // A program in Python needs about 0.5 s to start again. This is 5 % of the default run of 10 s. Twice that leaves
        // room for late answers, and nine cycles of ten still belong to the law that is judged.
        pub max_backup_share: Share = 0.1,
        /// Largest lateral acceleration on a road with a plan, m/s². Beyond it the outcome is `requirement_broken`.
        // Drivers stay below 3 m/s² in curves: it is 1.3 times the largest design value of ISO 15622.
        pub max_lateral_mps2: AccelerationMagnitude = 3.0,
        /// Requirements that the drive is judged by: formulas over its signals, such as `always gap_m > 2`, or names,
        /// such as `min-gap:2`. A drive that breaks one has the outcome `requirement_broken`. docs/search.md lists
        /// both.
        pub formulas: Vec<String> = default,
    }
}
