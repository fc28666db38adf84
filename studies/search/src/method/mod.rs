//! Choice of the points of the runs.
//!
//! ```text
//! random   each run draws for itself
//! sobol    run r is the r-th admissible point of a shifted Sobol sequence
//! gp       2 (d + 2) points as `sobol`, in whole half batches; then half batches of 5 by a Gaussian process, every fourth point as `sobol`
//! ```
//!
//! A point is *admissible* if the reference driver avoids it. Others cost no run. A choice depends on the seed and on
//! results of runs with smaller numbers alone, never on their timing. The results before half batch `h - 1` choose half
//! batch `h`. Points of half batch `h - 1` count with their expected values. So the next points are chosen while the
//! last ones are driven.

mod chooser;
mod gaussian;
mod scan;
mod sobol;

pub use chooser::Chooser;
pub(crate) use scan::random as independent;
pub use scan::{Admit, Proposal};
pub use sobol::{MOST_VARIABLES, Sobol};

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Names of the methods.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MethodName {
    /// A Gaussian process with expected improvement
    #[default]
    Gp,
    /// The Sobol sequence
    Sobol,
    /// Independent uniform points
    Random,
}

impl MethodName {
    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gp => "gp",
            Self::Sobol => "sobol",
            Self::Random => "random",
        }
    }
}

/// A seed for one of many uses, by splitmix64's finaliser (Steele, Lea, Flood 2014). At most 2⁶³ − 1, the largest seed
/// of a scenario.
pub fn seed_of(seed: u64, usage: u64, index: u64) -> u64 {
    let mut z = seed
        ^ usage.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ index.wrapping_mul(0xd1b5_4a32_d192_ed03);
    for _ in 0..2 {
        z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
    }
    z >> 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_use_has_a_seed_of_its_own() {
        let seeds: BTreeSet<u64> = (0..10)
            .flat_map(|seed| {
                (0..10).flat_map(move |usage| (0..100).map(move |k| seed_of(seed, usage, k)))
            })
            .collect();
        assert_eq!(seeds.len(), 10_000);
        assert!(seeds.iter().all(|seed| *seed <= i64::MAX as u64));
    }
}
