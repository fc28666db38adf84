//! `[probability]` of a search file, as it is written.
//!
//! ```toml
//! [probability.distributions]
//! v0 = "normal(24, 4)"
//! thw = "lognormal(1.3, 0.3)"            # median, standard deviation of the logarithm
//! lateral = "csv(cut-ins.csv, lateral_mps)"
//!
//! [[probability.correlations]]
//! variables = ["v0", "thw"]
//! rank = -0.3                            # Spearman's
//!
//! [probability.exposure]
//! per = "hour"
//! events = 0.4                           # scenes of this kind per hour
//! source = "own fleet, 2025, motorways"
//!
//! [probability]
//! indices = 100                          # rows for Sobol's indices
//! monte_carlo = 100000                   # points of Monte Carlo, beside the budget
//! ```

use serde::Deserialize;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Stated {
    #[serde(default)]
    pub(crate) distributions: BTreeMap<String, String>,
    #[serde(default)]
    pub(crate) correlations: Vec<Correlation>,
    /// Rate at which such scenes are met.
    pub(crate) exposure: Option<Exposure>,
    /// Rows for Sobol's indices.
    #[serde(default)]
    pub(crate) indices: u16,
    /// Points of Monte Carlo, all of which are done; none: half of the budget, until enough failures are there.
    pub(crate) monte_carlo: Option<NonZeroUsize>,
}

/// A correlation of two variables.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Correlation {
    /// Their names.
    pub variables: [String; 2],
    /// Spearman's correlation of their ranks.
    pub rank: f64,
}

/// Rate at which scenes of the problem are met, by the user's account.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Exposure {
    /// The unit: hour, km, year.
    pub per: String,
    pub events: f64,
    pub source: String,
}
