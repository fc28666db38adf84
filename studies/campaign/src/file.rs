//! Campaign files: which runs are done how often, and the limits that they must keep.
//!
//! ```toml
//! schema_version = 1
//! name = "mine"
//! mode = "lockstep"                      # or "realtime"
//! scenarios = ["following", "./my.toml"] # built-in names, or files beside this one
//! controllers = ["cacc-mpc", "acc-mpc"]  # without the key: each scenario's own
//! seeds = 20                             # runs of every combination
//! set = ["duration_s=10"]                # keys set in all runs
//! formulas = ["min-gap:1"]               # requirements of all runs (docs/search.md)
//! faults_per_run = [2, 4]                # number of faults in each run, drawn from all below
//! variation = "./cut_in_variation.xosc"  # instead of scenarios: OpenSCENARIO parameter values
//! sample = 200                           # number of runs that are done, drawn by the first seed
//! record = true                          # in realtime: record each run to a file that is removed with it
//!
//! [[faults]]                             # each run has one of these tables
//! kind = "drop"                          # keys as in a scenario
//! topic = ["radar/tracks", "v2x/spat"]   # a list of words: one of them is drawn
//! at_s = [1.0, 5.0]                      # two numbers: one between them is drawn
//! for_s = 2.0
//! count = 3                              # number of them in one run, each drawn anew
//! together = 2                           # instead of count: number at the same instant, of different
//!                                        # services
//! alone = true                           # with faults_per_run: in runs of its own
//! when = { ttc_below_s = [2.0, 4.0] }    # instead of at_s: a phase of the drive; a list of tables: one
//!                                        # of them is drawn
//!
//! [settings.corridor]                    # keys set in the runs of one scenario, drawn for each
//! "v2x.signals.0.offset_s" = [5, 35]
//!
//! [[cases]]                              # fixed runs beside the drawn ones
//! name = "late-clock"
//! scenario = "tight-brake"
//! set = ['faults=[{ kind = "clock-step", service = "perception-sim", amount = 0.11, at_s = 0, for_s = 3 }]']
//! seeds = 10                             # without the key: 10
//! from = "timegap search tight-brake"    # where it comes from
//!
//! [require]                              # max_ or min_ and a figure of the verdict
//! max_collisions = 0
//! min_gap_m = 1.0
//! ```

use super::sums::{Figure, Limit, figures};
use runtime::Mode;
use scenario::name::{Line, Name};
use scenario::{Problem, Setting};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};
use supervise::Error;

/// Largest number of faults that are drawn for a run.
const MAX_FAULTS_PER_RUN: u32 = 16;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    pub schema_version: u32,
    pub name: Name,
    #[serde(default)]
    pub description: Line,
    #[serde(default = "lockstep")]
    pub mode: Mode,
    /// Names of built-in scenarios, or files; with a variation, its scenario.
    #[serde(default)]
    pub scenarios: Vec<String>,
    /// A parameter variation file of OpenSCENARIO: one run for each of its combinations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variation: Option<PathBuf>,
    /// Number of runs that are done; none: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<NonZeroUsize>,
    /// Controllers; empty: each scenario's own.
    #[serde(default)]
    pub controllers: Vec<String>,
    /// Runs of every combination, each with a seed of its own.
    #[serde(default = "one")]
    pub seeds: NonZeroU32,
    #[serde(default = "first_seed")]
    pub first_seed: u32,
    /// Keys set in all runs, as for `--set`.
    #[serde(default)]
    pub set: Vec<Setting>,
    /// Requirements of all runs beside those of their scenarios.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub formulas: Vec<String>,
    /// Keys set in the runs of one scenario, by its name in `scenarios`. A value is drawn for each run, as for faults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<String, toml::Table>,
    /// Time between two samples of memory and descriptors during a run, s; none: no samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_every_s: Option<f64>,
    /// Each run is recorded, to a file that is removed with the run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub record: bool,
    /// Least and largest number of faults in a run, each drawn from all of `faults`. Without it a run has one fault,
    /// and each fault has its own runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faults_per_run: Option<[u32; 2]>,
    /// Faults, as in a scenario, with values that are drawn for each run.
    #[serde(default)]
    pub faults: Vec<toml::Table>,
    /// Fixed runs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<Case>,
    /// Limits: `max_` or `min_` and the name of a figure.
    #[serde(default)]
    pub require: BTreeMap<String, f64>,
}

/// A scene with its faults, as a search found it. Nothing of it is drawn but the noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    pub name: Name,
    /// Name of a built-in scenario, or a file.
    pub scenario: String,
    /// Keys of the scene and its faults, as for `--set`.
    pub set: Vec<Setting>,
    /// Runs, each with a seed of its own.
    #[serde(default = "ten")]
    pub seeds: NonZeroU32,
    pub from: Line,
}

fn lockstep() -> Mode {
    Mode::Lockstep
}

fn one() -> NonZeroU32 {
    NonZeroU32::MIN
}

fn ten() -> NonZeroU32 {
    NonZeroU32::new(10).expect("above 0")
}

fn first_seed() -> u32 {
    1
}

impl Campaign {
    /// Other seeds than the file's. With fewer seeds the least numbers shrink in proportion.
    pub fn limit_seeds(&mut self, seeds: NonZeroU32) {
        let share = (f64::from(seeds.get()) / f64::from(self.seeds.get())).min(1.0);
        for (key, limit) in &mut self.require {
            *limit = Limit::of(key, *limit).for_share(share).value;
        }
        self.seeds = seeds;
    }

    /// Reads a campaign file as it is.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::parse(&path.display().to_string(), &Error::text_of(path, "campaign")?)
    }

    /// Reads the text of a campaign file.
    pub fn parse(file: &str, text: &str) -> Result<Self, Error> {
        Ok(scenario::read_as(file, text, Self::check)?)
    }

    fn check(&self) -> Result<(), Problem> {
        if self.schema_version != 1 {
            let message = format!("version {} of the schema is not known", self.schema_version);
            return Err(Problem::new("schema_version", message, "1"));
        }
        if self.scenarios.is_empty() && self.variation.is_none() {
            return Err(Problem::new("scenarios", "nothing is run", "at least one scenario"));
        }
        if let Some(every) = self.sample_every_s.filter(|every| !(0.1..=3600.0).contains(every)) {
            let message = format!("{every} is out of range");
            return Err(Problem::new("sample_every_s", message, "0.1 to 3600 s"));
        }
        if let Some(name) = self.settings.keys().find(|name| !self.scenarios.contains(name)) {
            let message = format!("`{}` is not run", name.escape_debug());
            return Err(Problem::new("settings", message, "the name of one of the scenarios"));
        }
        if self.record && self.mode != Mode::Realtime {
            let message = "a run in simulated time keeps no recording";
            return Err(Problem::new("record", message, "mode = \"realtime\""));
        }
        if let Some([least, most]) = self.faults_per_run
            && (least > most || most == 0 || most > MAX_FAULTS_PER_RUN || self.faults.is_empty())
        {
            let expected = format!(
                "two numbers up to {MAX_FAULTS_PER_RUN}, the smaller first, and [[faults]] to draw from"
            );
            return Err(Problem::new("faults_per_run", "nothing can be drawn", expected));
        }
        for (key, &limit) in &self.require {
            let path = format!("require.{key}");
            let name = key.strip_prefix("max_").or_else(|| key.strip_prefix("min_"));
            let Some(figure) = name.and_then(Figure::named) else {
                let figures: Vec<_> = figures().map(|figure| figure.name).collect();
                let figures = figures.join(", ");
                let expected = format!("max_ or min_ and one of {figures}");
                return Err(Problem::new(path, "unknown figure", expected));
            };
            if !limit.is_finite() {
                return Err(Problem::new(path, format!("{limit} is not finite"), "a number"));
            }
            if limit < 0.0 && figure.is_count() {
                let message = format!("{limit} limits a count");
                return Err(Problem::new(path, message, "0 or more"));
            }
        }
        Ok(())
    }

    /// The campaign as it took effect; reading it gives an equal one.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("every value of a campaign has a form in TOML")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        Campaign::parse("c.toml", text).expect_err("the file is wrong").to_string()
    }

    #[test]
    fn faults_in_the_file_are_shown_with_their_place() {
        let head = "schema_version = 1\nname = \"x\"\nscenarios = [\"cacc-a\"]\n";
        for (text, words) in [
            ("", ["c.toml:1:1", "missing key"]),
            (&format!("{head}colour = 1\n"), ["c.toml:4:1", "colour"]),
            (&format!("{head}mode = \"fast\"\n"), ["c.toml:4:8", "realtime"]),
            (&format!("{head}set = [\"seed\"]\n"), ["c.toml:4:8", "`seed`: no `=`"]),
            (&format!("{head}seeds = 0\n"), ["c.toml:4:9", "expected a whole number of 1 or more"]),
            (
                &format!("{head}[require]\nmax_fun = 1\n"),
                ["c.toml:5:11", "one of safe_stops, collisions"],
            ),
            (&format!("{head}[require]\ncollisions = 1\n"), ["c.toml:5:14", "max_ or min_"]),
            (&format!("{head}[require]\nmax_collisions = nan\n"), ["c.toml:5:18", "a number"]),
            (&format!("{head}[require]\nmax_collisions = -1\n"), ["c.toml:5:18", "0 or more"]),
            (&format!("{head}faults_per_run = [2, 4]\n"), ["c.toml:4:18", "to draw from"]),
            (&head.replace("= 1", "= 2"), ["c.toml:1:18", "expected 1"]),
            (&head.replace("\"cacc-a\"", ""), ["c.toml:3:13", "at least one"]),
        ] {
            let said = refusal(text);
            assert!(words.iter().all(|word| said.contains(word)), "{text}\n{said}");
        }
    }
}
