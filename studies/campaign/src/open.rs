//! Way from the command's argument to a campaign: a built-in one, a file, or an OpenSCENARIO
//! variation.

use super::file::Campaign;
use super::variation::Variants;
use scenario::name::{Line, Name};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use supervise::{Error, UsageError};

/// Longest description that is taken from a variation file, characters.
const MAX_LINE: usize = 500;
/// Longest name that is taken from it, characters.
const MAX_NAME: usize = 64;

/// Limits of a campaign that comes from a variation file.
const REQUIRED: &str = "require = { max_avoidable_collisions = 0, max_aborted = 0, max_driven_by_backup = 0, \
                        max_requirements_broken = 0 }";

/// The built-in campaign of that name, or the file at that path.
pub fn open(argument: &str) -> Result<Campaign, Error> {
    if let Some((_, text)) = BUILTIN.iter().find(|(name, _)| *name == argument) {
        return Campaign::parse(&format!("built-in {argument}"), text);
    }
    let path = Path::new(argument);
    if !path.exists() {
        let why = "no built-in campaign and no file of this name";
        let names = scenario::accepted(argument, BUILTIN.iter().map(|(name, _)| *name));
        return Err(UsageError::at(argument, why, format_args!("a path or {names}")).into());
    }
    if supervise::is_openscenario(argument) {
        return of_variation(path);
    }
    let mut campaign = Campaign::read(path)?;
    let directory = path.parent().unwrap_or(path);
    // The campaign may be continued in another working directory.
    for scenario in &mut campaign.scenarios {
        let is_file = [".toml", ".xosc"].iter().any(|end| scenario.ends_with(end));
        if scenario.contains('/') || is_file {
            let file = absolute(&directory.join(&scenario))?.to_string_lossy().into_owned();
            // The scenario's settings follow its name.
            if let Some(settings) = campaign.settings.remove(scenario) {
                campaign.settings.insert(file.clone(), settings);
            }
            *scenario = file;
        }
    }
    for case in &mut campaign.cases {
        if case.scenario.contains('/') || case.scenario.ends_with(".toml") {
            let file = absolute(&directory.join(&case.scenario))?;
            case.scenario = file.to_string_lossy().into_owned();
        }
    }
    if let Some(variation) = &mut campaign.variation {
        *variation = absolute(&directory.join(&variation))?;
        campaign.scenarios = vec![Variants::open(variation)?.scenario];
    }
    Ok(campaign)
}

fn absolute(file: &Path) -> Result<PathBuf, Error> {
    std::fs::canonicalize(file).map_err(Error::path("read", file))
}

/// The campaign that runs a variation file.
pub fn of_variation(path: &Path) -> Result<Campaign, Error> {
    let file = absolute(path)?;
    let variants = Variants::open(&file)?;
    let good = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = stem.chars().map(good).take(MAX_NAME).collect();
    let printable = variants.description.chars().filter(|c| !c.is_control());
    let description = printable.take(MAX_LINE).collect::<String>();
    // The defaults of all other keys are those of a file.
    let least = format!("schema_version = 1\nname = \"x\"\n{REQUIRED}\n");
    let unnamed = |what: &dyn Display| {
        UsageError::at(path.display(), what, "a file with a name and a description")
    };
    Ok(Campaign {
        name: Name::try_from(name).map_err(|error| unnamed(&error))?,
        description: Line::try_from(description).map_err(|error| unnamed(&error))?,
        scenarios: vec![variants.scenario],
        variation: Some(file),
        ..toml::from_str(&least).expect("it has all keys that a campaign needs")
    })
}

/// Every built-in campaign: its name, as given on the command line, and its file.
pub const BUILTIN: [(&str, &str); 6] = [
    ("kills", include_str!("../campaigns/kills.toml")),
    ("messages", include_str!("../campaigns/messages.toml")),
    ("radio", include_str!("../campaigns/radio.toml")),
    ("restarts", include_str!("../campaigns/restarts.toml")),
    ("soak", include_str!("../campaigns/soak.toml")),
    ("takeovers", include_str!("../campaigns/takeovers.toml")),
];

/// The built-in campaigns with their purpose in one line.
pub fn summaries() -> impl Iterator<Item = (&'static str, String)> {
    BUILTIN.into_iter().map(|(name, text)| {
        let campaign = Campaign::parse(name, text).expect("a test reads each");
        (name, campaign.description.as_str().to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::num::NonZeroU32;

    #[test]
    fn the_built_in_campaigns_read_back_as_they_are() {
        for (name, summary) in summaries() {
            let campaign = open(name).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(campaign.name.as_str(), name);
            assert_eq!(campaign.description.as_str(), summary);
            let again = Campaign::parse("again", &campaign.to_toml());
            assert_eq!(again.expect("it was written by us"), campaign);
        }
    }

    #[test]
    fn fewer_seeds_require_their_share_of_a_least_number() {
        let mut campaign = open("messages").expect("it is built in");
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
        let campaign = open(&folder.join("c.toml").to_string_lossy());
        let other = text.replace("settings.\"./mine.toml\"", "settings.\"./other.toml\"");
        let refused = Campaign::parse("c.toml", &other).expect_err("it is wrong").to_string();
        let plan = crate::plan::plan(&campaign.expect("a campaign")).expect("a plan");
        let _ = std::fs::remove_dir_all(&folder);
        let run = plan.get(0).expect("no faults");
        assert_eq!(run.settings[0].to_string(), "duration_s=7");
        assert!(refused.contains("`./other.toml` is not run"), "{refused}");
    }
}
