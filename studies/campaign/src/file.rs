//! Campaign files: what is run how often, and what must hold.
//!
//! ```toml
//! schema_version = 1
//! name = "mine"
//! mode = "lockstep"                      # or "realtime"
//! scenarios = ["following", "./my.toml"] # built-in names, or files beside this one
//! controllers = ["cacc-mpc", "acc-mpc"]  # left out: each scenario's own
//! seeds = 20                             # runs of every combination
//! set = ["duration_s=10"]                # keys set in all runs
//! faults_per_run = [2, 4]                # so many of the faults below in each run, drawn from all
//! variation = "./cut_in_variation.xosc"  # instead of scenarios: OpenSCENARIO parameter values
//! sample = 200                           # so many of the runs, drawn by the first seed
//! record = true                          # in realtime: record the runs, to files that go with them
//!
//! [[faults]]                             # one of these per run; left out: none
//! kind = "drop"                          # keys as in a scenario
//! topic = ["radar/tracks", "v2x/spat"]   # a list of words: one of them is drawn
//! at_s = [1.0, 5.0]                      # two numbers: one between them is drawn
//! for_s = 2.0
//! count = 3                              # so many of them in one run, drawn anew
//! together = 2                           # instead of count: so many at the same instant, of services
//!                                        # of which no two are the same
//! alone = true                           # with faults_per_run: in runs of its own
//! when = { ttc_below_s = [2.0, 4.0] }    # instead of at_s: a phase of the drive; a list of tables: one
//!                                        # of them is drawn
//!
//! [settings.corridor]                    # keys set in the runs of one scenario, drawn for each
//! "v2x.signals.0.offset_s" = [5, 35]
//!
//! [require]                              # max_ or min_ and a figure of the verdict
//! max_collisions = 0
//! min_gap_m = 1.0
//! ```

use super::tally::{FIGURES, Figure, limit_of_part};
use super::variation::Variants;
use frame::parts::Shard;
use group::{Error, Failure};
use runtime::Mode;
use scenario::Problem;
use scenario::name::{Line, Name, NotALine, NotAName};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};

/// The campaign as it took effect, in its directory.
pub const FILE: &str = "campaign.toml";

/// Name of the campaign of radio frames, which has no file.
pub const RADIO: &str = "radio";

/// Longest description that is taken from a variation file, characters.
const MAX_LINE: usize = 500;
/// Longest campaign file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Most faults that are drawn for a run.
const MAX_FAULTS_PER_RUN: u32 = 16;

/// A campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// Version of the schema: 1.
    pub schema_version: u32,
    /// Name.
    pub name: Name,
    /// What it is about, in one line.
    #[serde(default)]
    pub description: Line,
    /// Clock.
    #[serde(default = "lockstep")]
    pub mode: Mode,
    /// Names of built-in scenarios, or files; with a variation, its scenario.
    #[serde(default)]
    pub scenarios: Vec<String>,
    /// A parameter variation file of OpenSCENARIO: a run for each of its combinations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variation: Option<PathBuf>,
    /// How many of the runs are done; left out: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<NonZeroUsize>,
    /// Controllers; empty: each scenario's own.
    #[serde(default)]
    pub controllers: Vec<String>,
    /// Runs of every combination, each with a seed of its own.
    #[serde(default = "one")]
    pub seeds: NonZeroU32,
    /// The first of these seeds.
    #[serde(default = "first_seed")]
    pub first_seed: u32,
    /// Keys set in all runs, as for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Keys set in the runs of one scenario, by the name that it has in `scenarios`; a value is drawn for each
    /// run as for faults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<String, toml::Table>,
    /// Time between two samples of memory and descriptors during a run, s; left out: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_every_s: Option<f64>,
    /// Runs are recorded, each to a file that is removed with the run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub record: bool,
    /// Which part of the runs this is, `i/n`: set by `--shard`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// Least and largest number of faults in a run, each drawn from all of `faults`; left out: a run has
    /// one of them, and every one has its runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faults_per_run: Option<[u32; 2]>,
    /// What goes wrong: one of these in each run.
    #[serde(default)]
    pub faults: Vec<toml::Table>,
    /// What must hold: `max_` or `min_` and the name of a figure.
    #[serde(default)]
    pub require: BTreeMap<String, f64>,
}

/// Why there is no campaign of a name.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It is neither built in nor a file.
    #[error(
        "{argument}: no built-in campaign and no file of this name, expected a path or {}",
        scenario::accepted(
            argument,
            BUILTIN
                .iter()
                .map(|builtin| builtin.name)
                .chain(super::WITHOUT_FILE.iter().map(|(name, _)| *name))
        )
    )]
    Unknown {
        /// The argument.
        argument: String,
    },
    /// It is no file, or too long for one.
    #[error("{}: expected a file of at most {MAX_BYTES} bytes", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// A variation file gives its campaign no name.
    #[error(transparent)]
    Name(NotAName),
    /// A variation file gives its campaign no description.
    #[error(transparent)]
    Description(NotALine),
}

impl Failure for FileError {}

fn lockstep() -> Mode {
    Mode::Lockstep
}

fn one() -> NonZeroU32 {
    NonZeroU32::MIN
}

fn first_seed() -> u32 {
    1
}

/// A campaign compiled into the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Name, as given on the command line.
    pub name: &'static str,
    /// What it is about, in one line.
    pub summary: &'static str,
    /// The campaign file.
    pub text: &'static str,
}

/// Every built-in campaign.
pub const BUILTIN: [Builtin; 5] = [
    Builtin {
        name: "kills",
        summary: "1,000 SIGKILLs over all processes of a run, most of them in critical phases, in realtime",
        text: include_str!("../campaigns/kills.toml"),
    },
    Builtin {
        name: "messages",
        summary: "10,000 runs in lockstep, each with 2 to 4 seeded faults of messages of up to 20 s",
        text: include_str!("../campaigns/messages.toml"),
    },
    Builtin {
        name: "restarts",
        summary: "1,000 SIGKILLs of services without a standby, each replaced at once",
        text: include_str!("../campaigns/restarts.toml"),
    },
    Builtin {
        name: "soak",
        summary: "half an hour of realtime with random kills: nothing grows",
        text: include_str!("../campaigns/soak.toml"),
    },
    Builtin {
        name: "takeovers",
        summary: "1,000 SIGKILLs of a controller with a standby, at control periods of 10 ms",
        text: include_str!("../campaigns/takeovers.toml"),
    },
];

impl Campaign {
    /// Other seeds than the file's. Of fewer its share of the required least numbers is asked for.
    pub(super) fn limit_seeds(&mut self, seeds: NonZeroU32) {
        let share = (f64::from(seeds.get()) / f64::from(self.seeds.get())).min(1.0);
        for (key, limit) in &mut self.require {
            *limit = limit_of_part(key, *limit, share);
        }
        self.seeds = seeds;
    }

    /// The built-in campaign of that name, or the file at that path.
    pub fn open(argument: &str) -> Result<Self, Error> {
        if let Some(builtin) = BUILTIN.iter().find(|builtin| builtin.name == argument) {
            return Self::parse(&format!("built-in {argument}"), builtin.text);
        }
        let path = Path::new(argument);
        if !path.exists() {
            return Err(FileError::Unknown { argument: argument.to_owned() }.into());
        }
        if group::is_openscenario(argument) {
            return of_variation(path);
        }
        let mut campaign = Self::read(path)?;
        let directory = path.parent().unwrap_or(path);
        // From now on wherever the campaign is resumed.
        let absolute = |file: &Path| {
            let file = directory.join(file);
            std::fs::canonicalize(&file).map_err(|reason| Error::Path {
                action: "read",
                path: file,
                reason,
            })
        };
        for scenario in &mut campaign.scenarios {
            let is_file = [".toml", ".xosc"].iter().any(|end| scenario.ends_with(end));
            if scenario.contains('/') || is_file {
                let file = absolute(Path::new(scenario))?.to_string_lossy().into_owned();
                // The scenario's settings follow its name.
                if let Some(settings) = campaign.settings.remove(scenario) {
                    campaign.settings.insert(file.clone(), settings);
                }
                *scenario = file;
            }
        }
        if let Some(variation) = &mut campaign.variation {
            *variation = absolute(variation)?;
            campaign.scenarios = of_variation(variation)?.scenarios;
        }
        Ok(campaign)
    }

    /// Reads a campaign file as it is.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let error = |reason| Error::Path { action: "read", path: path.to_owned(), reason };
        let metadata = std::fs::metadata(path).map_err(error)?;
        if !metadata.is_file() || metadata.len() > MAX_BYTES {
            return Err(FileError::TooLong { path: path.to_owned() }.into());
        }
        let text = std::fs::read_to_string(path).map_err(error)?;
        Self::parse(&path.display().to_string(), &text)
    }

    fn parse(file: &str, text: &str) -> Result<Self, Error> {
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
                let figures = FIGURES.map(|figure| figure.name).join(", ");
                let expected = format!("max_ or min_ and one of {figures}");
                return Err(Problem::new(path, "it requires no figure", expected));
            };
            if !limit.is_finite() {
                return Err(Problem::new(path, format!("{limit} is no limit"), "a number"));
            }
            if limit < 0.0 && figure.is_count() {
                let message = format!("{limit} is no limit of a number of things");
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

/// The campaign that runs a variation file.
pub(super) fn of_variation(path: &Path) -> Result<Campaign, Error> {
    let file = std::fs::canonicalize(path).map_err(|reason| Error::Path {
        action: "read",
        path: path.to_owned(),
        reason,
    })?;
    let variants = Variants::open(&file)?;
    let good = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = stem.chars().map(good).take(64).collect();
    let printable = variants.description.chars().filter(|c| !c.is_control());
    let required = ["max_avoidable_collisions", "max_aborted", "max_driven_by_backup"]
        .map(|key| (key.to_owned(), 0.0));
    Ok(Campaign {
        schema_version: 1,
        name: Name::try_from(name).map_err(FileError::Name)?,
        description: Line::try_from(printable.take(MAX_LINE).collect::<String>())
            .map_err(FileError::Description)?,
        mode: Mode::Lockstep,
        scenarios: vec![variants.scenario],
        variation: Some(file),
        sample: None,
        controllers: Vec::new(),
        seeds: NonZeroU32::MIN,
        first_seed: 1,
        set: Vec::new(),
        sample_every_s: None,
        record: false,
        settings: BTreeMap::new(),
        shard: None,
        faults_per_run: None,
        faults: Vec::new(),
        require: BTreeMap::from(required),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        Campaign::parse("c.toml", text).expect_err("the file is wrong").to_string()
    }

    #[test]
    fn the_built_in_campaigns_read_back_as_they_are() {
        for Builtin { name, summary, .. } in BUILTIN {
            let campaign = Campaign::open(name).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(campaign.name.as_str(), name);
            assert_eq!(campaign.description.as_str(), summary);
            let again = Campaign::parse("again", &campaign.to_toml());
            assert_eq!(again.expect("it was written by us"), campaign);
        }
    }

    #[test]
    fn of_fewer_seeds_their_share_of_a_least_number_is_required() {
        let mut campaign = Campaign::open("messages").expect("it is built in");
        let least = |campaign: &Campaign| campaign.require["min_critical_faults"];
        let (all, seeds) = (least(&campaign), campaign.seeds.get());
        campaign.limit_seeds(NonZeroU32::new(2 * seeds).expect("some"));
        assert_eq!(least(&campaign), all);
        campaign.limit_seeds(NonZeroU32::new(seeds / 5).expect("some"));
        assert_eq!((least(&campaign), campaign.require["max_red_lights"]), (all / 10.0, 0.0));
    }

    #[test]
    fn settings_of_a_scenario_file_reach_its_runs() {
        let folder = std::env::temp_dir().join(format!("timegap-settings-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("writable");
        let scenario = "schema_version = 1\nname = \"mine\"\n";
        std::fs::write(folder.join("mine.toml"), scenario).expect("writable");
        let text = "schema_version = 1\nname = \"x\"\nscenarios = [\"./mine.toml\"]\n\
            [settings.\"./mine.toml\"]\nduration_s = 7\n";
        std::fs::write(folder.join("c.toml"), text).expect("writable");
        let campaign = Campaign::open(&folder.join("c.toml").to_string_lossy());
        let other = text.replace("settings.\"./mine.toml\"", "settings.\"./other.toml\"");
        let refused = refusal(&other);
        let plan = crate::plan::plan(&campaign.expect("a campaign")).expect("a plan");
        let _ = std::fs::remove_dir_all(&folder);
        assert_eq!(plan.get(0).keys, ["duration_s=7"]);
        assert!(refused.contains("`./other.toml` is not run"), "{refused}");
    }

    #[test]
    fn faults_in_the_file_are_shown_with_their_place() {
        let head = "schema_version = 1\nname = \"x\"\nscenarios = [\"cacc-a\"]\n";
        for (text, words) in [
            ("", ["c.toml:1:1", "missing key"]),
            (&format!("{head}colour = 1\n"), ["c.toml:4:1", "colour"]),
            (&format!("{head}mode = \"fast\"\n"), ["c.toml:4:8", "realtime"]),
            (&format!("{head}seeds = 0\n"), ["c.toml:4:9", "expected a whole number of 1 or more"]),
            (&format!("{head}shard = \"3/2\"\n"), ["c.toml:4:9", "I from 1 to N"]),
            (&format!("{head}[require]\nmax_fun = 1\n"), ["c.toml:5:11", "one of collisions"]),
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
