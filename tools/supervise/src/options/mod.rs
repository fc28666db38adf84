//! Options that several commands share.

pub mod laws;

use crate::{Error, LawOptions, UsageError};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use messages::Service;
use openscenario::LaneHeadings;
use runtime::Mode;
use scenario::{Setting, option_value};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use toml::Value;

/// Changes of a scenario.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize)]
pub struct ScenarioOptions {
    /// Control law (see `timegap list`)
    #[arg(long, value_name = "NAME")]
    pub controller: Option<String>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = |text: &str| option_value("--seed", text))]
    pub seed: Option<Value>,
    /// Length of the run, s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = |text: &str| option_value("--duration", text))]
    pub duration: Option<Value>,
    /// Change a key of the scenario, by its dotted path (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<Setting>,
    /// Laws of the user's own.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Judge the drive by a requirement too: a formula ('always gap_m > 2') or a name (min-gap:2) (repeatable;
    /// docs/search.md)
    #[arg(long = "require", value_name = "FORMULA")]
    pub require: Vec<String>,
    /// Headings in lanes of an OpenSCENARIO file count from the road, as in the standard, or from the lane's traffic, as
    /// in esmini [default: `traffic` if the file's author is esmini]
    #[arg(long, value_enum, value_name = "DIRECTION")]
    pub lane_headings: Option<HeadingsName>,
    /// The ego of an OpenSCENARIO file [default: `Ego`, `hero`, or the only entity with a controller]; in SUMO a route,
    /// vehicle, trip, flow, or from=EDGE,to=EDGE
    #[arg(long, value_name = "NAME")]
    pub ego: Option<String>,
    /// Parameters of an OpenSCENARIO file, `NAME=VALUE`: an option of the commands that take one.
    #[arg(skip)]
    pub parameters: Vec<String>,
    /// Carrier of the signals, for `v2x.radio`: an option of the commands that drive in realtime.
    #[arg(skip)]
    pub radio: Option<String>,
    /// Refuses a set key that the law does not read; a study of several laws notes it instead.
    #[arg(skip)]
    pub is_for_one_law: bool,
    /// Refuses a fault of a process at its place: in simulated time it shows nothing.
    #[arg(skip)]
    pub is_in_lockstep: bool,
    /// The options are arguments of a Python function: errors name them so.
    #[arg(skip)]
    #[serde(skip)]
    pub are_from_python: bool,
}

/// Names of the directions from which headings of lane positions count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeadingsName {
    /// The road's reference line.
    Road,
    /// The lane's traffic.
    Traffic,
}

impl From<HeadingsName> for LaneHeadings {
    fn from(name: HeadingsName) -> Self {
        match name {
            HeadingsName::Road => Self::Road,
            HeadingsName::Traffic => Self::Traffic,
        }
    }
}

/// Settings of a group's start.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
pub struct GroupOptions {
    /// Replace a service with PROGRAM (repeatable)
    #[arg(long = "service", value_name = "NAME=PROGRAM", value_parser = service_program)]
    pub programs: Vec<(Service, PathBuf)>,
    /// Longest time until all services are ready, s
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = number_within(0.001..=3600.0, "a number of seconds"))]
    pub ready_timeout: f64,
    /// Run every service as a separate process in lockstep too
    #[arg(long)]
    #[serde(skip)]
    pub processes: bool,
}

impl GroupOptions {
    pub fn programs(&self) -> Result<BTreeMap<Service, PathBuf>, UsageError> {
        let mut programs = BTreeMap::new();
        for (service, program) in &self.programs {
            if programs.insert(*service, program.clone()).is_some() {
                let why = "a program is given twice";
                return Err(UsageError::option("--service", service, why, "one in its place"));
            }
        }
        Ok(programs)
    }
}

/// A parser of a clock's name.
pub fn mode() -> impl TypedValueParser<Value = Mode> {
    let name = |mode: Mode, help: &'static str| PossibleValue::new(mode.name()).help(help);
    let names = [name(Mode::Realtime, "Wall-clock time"), name(Mode::Lockstep, "Simulated time")];
    let is_lockstep = |name: String| name == Mode::Lockstep.name();
    PossibleValuesParser::new(names)
        .map(move |name| if is_lockstep(name) { Mode::Lockstep } else { Mode::Realtime })
}

/// A service and the program in its place: `NAME=PROGRAM`.
pub fn service_program(argument: &str) -> Result<(Service, PathBuf), Error> {
    let (name, program) = argument
        .split_once('=')
        .ok_or_else(|| UsageError::at(format_args!("`{argument}`"), "no `=`", "NAME=PROGRAM"))?;
    Ok((name.parse()?, PathBuf::from(program)))
}

/// Reads the value of an option: `what`, in a range.
pub fn number_within(
    range: RangeInclusive<f64>,
    what: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected {what} from {} to {}", range.start(), range.end()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_service_program_names_a_service() {
        let (service, program) = service_program("controller=./mine").expect("a known service");
        assert_eq!((service, program), (Service::Controller, PathBuf::from("./mine")));
        let refused = service_program("radar=./mine").expect_err("no service");
        assert!(refused.to_string().contains("perception-sim"), "{refused}");
    }

    #[test]
    fn a_service_has_one_program_in_its_place() {
        let programs = |arguments: &[&str]| {
            let programs = arguments.iter().map(|a| service_program(a).expect("a known service"));
            let programs = programs.collect();
            GroupOptions { programs, ready_timeout: 1.0, processes: false }.programs()
        };
        assert_eq!(programs(&["controller=a", "plant=b"]).map(|all| all.len()), Ok(2));
        let refused = programs(&["controller=a", "controller=b"]);
        let said = refused.expect_err("two").to_string();
        assert!(said.starts_with("--service controller: a program is given twice"), "{said}");
    }
}
