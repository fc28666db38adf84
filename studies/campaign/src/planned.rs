//! One run of a campaign, before it is driven.

/// A run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its number, from 0.
    pub run: usize,
    /// Scenario as the campaign names it.
    pub scenario: String,
    /// Controller, if the campaign names one.
    pub controller: Option<String>,
    /// What goes wrong, in a word.
    pub fault: String,
    /// Seed.
    pub seed: u32,
    /// Keys set, as for `--set`.
    pub keys: Vec<String>,
    /// Parameters of an OpenSCENARIO file, as for `--param`.
    pub parameters: Vec<String>,
}
