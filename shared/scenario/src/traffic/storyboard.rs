//! `[storyboard]`: the content of an OpenSCENARIO file, carried in the scenario.
//!
//! The storyboard is carried as it was resolved: parameters, catalogs and road included. A service that receives the
//! scenario needs no other file. The module `translation` makes a scenario of an OpenSCENARIO file.

use std::collections::BTreeMap;

use openscenario::model::Script;
use serde::{Deserialize, Serialize};

/// A storyboard with where it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Storyboard {
    /// The file that it was read from.
    pub source: String,
    /// Remarks on its simulation, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notices: Vec<String>,
    /// Reason why its story cannot happen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hindrance: Option<String>,
    /// The file's parameters with the values that took effect.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, String>,
    pub script: Script,
}
