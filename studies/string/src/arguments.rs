//! The command's arguments, read and checked.

use std::fmt::Display;
use std::num::NonZeroUsize;

use clap::Args;
use runtime::Mode;
use scenario::Setting;
use serde::{Deserialize, Serialize};
use supervise::{Error, GroupOptions, ScenarioOptions, UsageError};

use super::results::STABILITY;
use super::scene::Plan;
use frame::batch;
use frame::param::{self, Param};

/// Frequencies that are swept unless others are given.
const USUAL_FREQUENCIES: &str = "0.005..0.5:log:13";
/// Lowest frequency: a longer period would outlast the run's longest duration, Hz.
const LOWEST_HZ: f64 = 1e-4;
/// Highest frequency: a car's speed hardly moves at it, Hz.
const HIGHEST_HZ: f64 = 5.0;
/// Most frequencies of a sweep.
const MAX_FREQUENCIES: usize = 1_000;
/// Most cars of a string.
const MAX_VEHICLES: usize = 1_000;
/// Most runs of the command.
const MAX_RUNS: usize = 1_000_000;

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct StringArguments {
    /// Scenario of the first car: name of a built-in one (see `timegap list`), or a TOML file
    pub scenario: String,
    /// Cars in the string
    #[arg(long, value_name = "N")]
    pub vehicles: NonZeroUsize,
    /// Control laws by commas, repeated along the string [default: the scenario's]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "controller")]
    pub controllers: Vec<String>,
    /// Sweep a sine of the lead's speed: a range or a list of frequencies, Hz
    /// [default without a value: 0.005..0.5:log:13]
    #[arg(
        long,
        value_name = "A..B:log:N",
        num_args = 0..=1,
        default_missing_value = USUAL_FREQUENCIES
    )]
    pub frequencies: Option<String>,
    /// Find the value of a key at which each law stops to be string stable: `KEY=A..B/STEP` or
    /// `KEY=a,b,c`
    #[arg(long = "vary", value_name = "KEY=VALUES")]
    pub param: Option<String>,
    /// Options of all cars.
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
}

/// The strings to drive, read and checked.
#[derive(Debug)]
pub struct Task {
    /// The string behind what the scenario says.
    pub plan: Plan,
    /// Frequencies at which the string is driven, Hz.
    pub frequencies: Vec<f64>,
    /// The swept key, and each law's scenarios over its values.
    pub sweep: Option<(Param, Vec<Swept>)>,
    /// Frequencies of the sweep of a key, Hz.
    pub sweep_frequencies: Vec<f64>,
    /// `string-stable` is required.
    pub requires_stability: bool,
}

/// A law with a string of one car for each value of the swept key.
#[derive(Debug)]
pub struct Swept {
    /// Name of the law.
    pub controller: String,
    /// In the order of the values.
    pub plans: Vec<Plan>,
}

impl Task {
    /// Reads the arguments.
    ///
    /// # Errors
    /// A string that cannot be driven, or an error of the scenario.
    pub fn read(arguments: &StringArguments, group: &GroupOptions) -> Result<Self, Error> {
        let vehicles = arguments.vehicles.get();
        if vehicles > MAX_VEHICLES {
            let expected = format_args!("at most {MAX_VEHICLES} cars");
            return Err(UsageError::option("--vehicles", vehicles, "too many", expected).into());
        }
        let laws: Vec<Option<String>> = match arguments.controllers.as_slice() {
            [] => vec![arguments.scenario_options.controller.clone()],
            names => names.iter().cloned().map(Some).collect(),
        };
        // A limit is found of each law, in however short a string.
        if laws.len() > vehicles && arguments.param.is_none() {
            let why = format_args!("{} laws, and --vehicles {vehicles}", laws.len());
            return Err(UsageError::at("--controllers", why, "a car for each law").into());
        }
        let mut shared = arguments.scenario_options.clone();
        shared.require.retain(|requirement| requirement.trim() != STABILITY);
        let requires_stability = shared.require.len() < arguments.scenario_options.require.len();
        let open = |law: &Option<String>, settings: &[Setting]| {
            let options = ScenarioOptions { controller: law.clone(), ..shared.clone() };
            let scenario = supervise::open_with(&arguments.scenario, &options, "--vary", settings)?;
            batch::check(&scenario, Mode::Lockstep, group)?;
            Ok::<_, Error>(scenario)
        };
        let scenarios = laws.iter().map(|law| open(law, &[])).collect::<Result<Vec<_>, _>>()?;
        let names: Vec<&str> = scenarios.iter().map(|law| law.controller.name.as_str()).collect();
        shared.laws.expect_all_in(&names)?;
        let plan = Plan { laws: scenarios, vehicles, wave: None };
        let frequencies = match &arguments.frequencies {
            Some(list) => frequencies(list)?,
            None => Vec::new(),
        };
        let sweep_frequencies = if frequencies.is_empty() {
            self::frequencies(USUAL_FREQUENCIES)?
        } else {
            frequencies.clone()
        };
        let sweep = match &arguments.param {
            None => None,
            Some(argument) => {
                let param = Param::parse(argument)?;
                if param.key == "controller.name" {
                    let why = "each law has a limit of its own";
                    let expected = "laws by --controllers";
                    return Err(UsageError::option("--vary", param.key, why, expected).into());
                }
                param::refuse_if_set(
                    &format!("--vary {}", param.key),
                    &param.key,
                    &arguments.scenario_options,
                )?;
                let mut distinct: Vec<&Option<String>> = Vec::new();
                for law in &laws {
                    if !distinct.contains(&law) {
                        distinct.push(law);
                    }
                }
                let mut swept = Vec::new();
                for law in distinct {
                    let mut plans = Vec::new();
                    for setting in &param.settings {
                        let scenario = open(law, std::slice::from_ref(setting))?;
                        plans.push(Plan { laws: vec![scenario], vehicles: 1, wave: None });
                    }
                    let controller = plans[0].laws[0].controller.name.as_str().to_owned();
                    swept.push(Swept { controller, plans });
                }
                Some((param, swept))
            }
        };
        let task = Self { plan, frequencies, sweep, sweep_frequencies, requires_stability };
        if task.runs() > MAX_RUNS {
            let why = format_args!("the sweeps have {} runs", task.runs());
            return Err(UsageError::at("--vary", why, format_args!("at most {MAX_RUNS}")).into());
        }
        Ok(task)
    }

    /// Runs in all: one for each car of each string.
    pub fn runs(&self) -> usize {
        let swept =
            self.sweep.as_ref().map_or(0, |(param, laws)| param.settings.len() * laws.len());
        self.plan.vehicles * (1 + self.frequencies.len()) + swept * self.sweep_frequencies.len()
    }
}

/// Frequencies of a range or a list, in order, Hz.
fn frequencies(list: &str) -> Result<Vec<f64>, UsageError> {
    let refuse = |why: &dyn Display| {
        let expected = "A..B:log:N, A..B:N, A..B/STEP or a,b,c in Hz";
        UsageError::option("--frequencies", list, why, expected)
    };
    let number = |text: &String| match text.parse::<f64>() {
        Ok(hz) if (LOWEST_HZ..=HIGHEST_HZ).contains(&hz) => Ok(hz),
        Ok(hz) => Err(refuse(&format_args!("{hz} Hz is not from {LOWEST_HZ} to {HIGHEST_HZ} Hz"))),
        Err(_) => Err(refuse(&format_args!("`{text}` is not a number"))),
    };
    let all = param::values(list, None).map_err(|why| refuse(&why))?;
    if all.len() > MAX_FREQUENCIES {
        return Err(refuse(&format_args!("more than {MAX_FREQUENCIES} frequencies")));
    }
    let mut all = all.iter().map(number).collect::<Result<Vec<_>, _>>()?;
    all.sort_by(f64::total_cmp);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_frequencies_has_both_ends_and_even_ratios() {
        let all = frequencies("0.005..0.5:log:5").expect("a range");
        assert_eq!((all.len(), all[0], all[4]), (5, 0.005, 0.5));
        assert!(all.windows(2).all(|pair| (pair[1] / pair[0] - 100f64.powf(0.25)).abs() < 1e-9));
        assert_eq!(frequencies("0.2,0.1").expect("a list"), [0.1, 0.2]);
    }

    #[test]
    fn a_bad_range_is_refused_with_what_was_expected() {
        for (list, what) in [
            ("0.1..0.5", "has no step"),
            ("0.5..0.1:3", "after its end"),
            ("0.1..0.5:1", "not a number of values"),
            ("0.01..0.3/7", "longer than the range"),
            ("0..0.5:3", "0 Hz is not from"),
            ("a,b", "`a` is not a number"),
            ("0.1,,0.2", "a value is missing"),
            ("nan", "NaN Hz is not from"),
        ] {
            let said = frequencies(list).expect_err(list).to_string();
            assert!(said.contains(what) && said.contains("expected A..B:log:N"), "{said}");
        }
    }
}
