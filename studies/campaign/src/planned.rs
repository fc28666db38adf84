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

impl Planned {
    /// The faults of the run in words, each once: kind, and what it acts on.
    pub fn faults(&self) -> Vec<String> {
        let keys = self.keys.iter().rev().find(|key| key.starts_with("faults="));
        let table: toml::Table = keys.and_then(|keys| keys.parse().ok()).unwrap_or_default();
        let faults = table.get("faults").and_then(toml::Value::as_array);
        let word = |fault: &toml::Value| {
            let of = |key: &str| fault.get(key).and_then(toml::Value::as_str);
            let words = ["kind", "service", "helper", "topic", "field"].into_iter().filter_map(of);
            words.collect::<Vec<_>>().join(" ")
        };
        let mut words: Vec<String> = faults.into_iter().flatten().map(word).collect();
        words.sort();
        words.dedup();
        words
    }
}
