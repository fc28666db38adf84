//! One run of a campaign, before it is driven.

/// A run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its number, from 0.
    pub run: usize,
    /// Scenario, as the campaign names it.
    pub scenario: String,
    /// Controller, if the campaign names one.
    pub controller: Option<String>,
    pub fault: String,
    pub seed: u32,
    /// Keys set, as for `--set`.
    pub keys: Vec<String>,
    /// Requirements beside the scenario's, as for `--require`.
    pub formulas: Vec<String>,
    /// Parameters of an OpenSCENARIO file, as for `--param`.
    pub parameters: Vec<String>,
}

impl Planned {
    /// The command that repeats the run.
    pub fn repeat(&self, mode: &str) -> String {
        let seed = self.seed.to_string();
        let mut words = vec!["timegap", "run", &self.scenario];
        if let Some(controller) = &self.controller {
            words.extend(["--controller", controller]);
        }
        words.extend(["--mode", mode, "--seed", &seed]);
        words.extend(self.keys.iter().flat_map(|key| ["--set", key]));
        words.extend(self.parameters.iter().flat_map(|parameter| ["--param", parameter]));
        words.extend(self.formulas.iter().flat_map(|formula| ["--require", formula]));
        runtime::command_line(&words)
    }

    /// The faults of the run in words, each once: kind and target.
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
