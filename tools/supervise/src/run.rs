//! One scenario: opened with the options laid over it, and driven through a process group.

use crate::refusal::check_faults_in_lockstep;
use crate::{
    Error, GroupOptions, GroupOutcome, Launch, Moment, ScenarioOptions, UsageError, launch,
};
use controller::laws;
use openscenario::{Assignment, Choices, LaneHeadings};
use runtime::Mode;
use scenario::radio::Radio;
use scenario::{Overrides, Scenario, Setting, Source};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Opens a scenario and lays the options over it.
pub fn open(name: &str, options: &ScenarioOptions) -> Result<Scenario, Error> {
    open_with(name, options, "--set", &[])
}

/// The same with more settings, on behalf of the option that errors name.
pub fn open_with(
    name: &str,
    options: &ScenarioOptions,
    option: &'static str,
    settings: &[Setting],
) -> Result<Scenario, Error> {
    Opening::of(name, options)?.with(option, settings)
}

/// A scenario's file with the options, to be opened many times with other keys: it is read and parsed once.
#[derive(Clone, Debug)]
pub struct Opening {
    file: File,
    options: ScenarioOptions,
    /// The keys that the options set.
    overrides: Overrides,
}

#[derive(Clone, Debug)]
enum File {
    Own(Box<Source>),
    OpenScenario(PathBuf, Choices),
}

impl Opening {
    /// Reads the file and the options.
    pub fn of(name: &str, options: &ScenarioOptions) -> Result<Self, Error> {
        let overrides = Overrides::new();
        let mut overrides = if options.is_for_one_law { overrides } else { overrides.shared() };
        let named = |option| if options.are_from_python { in_python(option) } else { option };
        options.laws.check()?;
        options.laws.lay_over(named("--law"), &mut overrides);
        match (&options.controller, options.laws.only()) {
            (Some(controller), _) => {
                overrides.option(named("--controller"), "controller.name", controller.as_str())
            }
            // The only law of the user's that was named is meant.
            (None, Some(law)) => overrides.option(named("--law"), "controller.name", law),
            (None, None) => {}
        }
        if let Some(seed) = &options.seed {
            overrides.option(named("--seed"), "seed", seed.clone());
        }
        if let Some(duration) = &options.duration {
            overrides.option(named("--duration"), "duration_s", duration.clone());
        }
        for setting in &options.set {
            overrides.set_by(named("--set"), setting.clone());
        }
        if let Some(radio) = &options.radio {
            overrides.option("--radio", "v2x.radio", from_here(radio));
        }
        let parameters = options.parameters.iter().map(|argument| assignment(argument));
        let assigned = parameters.collect::<Result<Vec<_>, _>>()?;
        let (headings, ego) = (options.lane_headings.map(LaneHeadings::from), options.ego.clone());
        let choices = Choices { assigned, headings, ego };
        let file = if is_openscenario(name) {
            File::OpenScenario(name.into(), choices)
        } else if Path::new(name).extension().is_some_and(|extension| extension == "sumocfg") {
            let Some(ego) = &choices.ego else {
                let expected =
                    "--ego ROUTE (a route, vehicle, trip or flow), or --ego from=EDGE,to=EDGE";
                return Err(UsageError::at(name, "no way for the ego", expected).into());
            };
            File::Own(Box::new(Source::of_sumo(Path::new(name), ego)))
        } else {
            let is_none = format_args!("{name} is not an OpenSCENARIO file");
            let refuse = |option, value, expected| {
                Err(UsageError::option(option, value, is_none, expected).into())
            };
            if let Some(argument) = options.parameters.first() {
                return refuse("--param", argument.as_str(), "--set KEY=VALUE");
            }
            if let Some(ego) = &choices.ego {
                return refuse("--ego", ego.as_str(), "one (.xosc)");
            }
            if let Some(headings) = choices.headings {
                let name = format!("{headings:?}").to_lowercase();
                return refuse("--lane-headings", &name, "one (.xosc)");
            }
            File::Own(Box::new(Source::read(name)?))
        };
        Ok(Self { file, options: options.clone(), overrides })
    }

    /// The scenario with more settings, on behalf of the option that errors name.
    pub fn with(&self, option: &'static str, settings: &[Setting]) -> Result<Scenario, Error> {
        let Self { file, options, overrides } = self;
        let mut overrides = overrides.clone();
        for setting in settings {
            overrides.set_by(option, setting.clone());
        }
        let check = |scenario: &Scenario| {
            let reads = laws::check(scenario)?;
            if options.is_in_lockstep {
                check_faults_in_lockstep(scenario)?;
            }
            Ok(reads)
        };
        let mut scenario = match file {
            File::Own(source) => source.open(&overrides, &check)?,
            File::OpenScenario(path, choices) => {
                Scenario::open_openscenario(path, choices, &overrides, &check)?
            }
        };
        scenario.require.formulas.extend(options.require.iter().cloned());
        crate::requirements(&scenario)?;
        if options.is_for_one_law {
            options.laws.expect_all_in(&[scenario.controller.name.as_str()])?;
        }
        Ok(scenario)
    }
}

/// Name of an option among the arguments of Python's functions.
fn in_python(option: &str) -> &'static str {
    match option {
        "--seed" => "seed:",
        "--duration" => "duration_s:",
        "--set" => "set:",
        _ => "law:",
    }
}

/// A radio whose file is given from the present directory, as that of a scenario is from its own.
fn from_here(radio: &str) -> String {
    let mut here = Radio::try_from(radio.to_owned());
    if let Ok(Radio::Carrier(address)) = &mut here {
        address.place(&std::env::current_dir().unwrap_or_default());
    }
    here.map_or_else(|_| radio.to_owned(), String::from)
}

/// True if a scenario's name is the path of an OpenSCENARIO file.
pub fn is_openscenario(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension == "xosc")
}

/// A value for a parameter of an OpenSCENARIO file.
fn assignment(argument: &str) -> Result<Assignment, UsageError> {
    let no_value = || UsageError::option("--param", argument, "no value", "NAME=VALUE");
    let (name, value) = argument.split_once('=').ok_or_else(no_value)?;
    Ok(Assignment { name: name.trim_start_matches('$').to_owned(), value: value.to_owned() })
}

/// Outputs of a run during and after the drive.
#[derive(Debug, Default)]
pub struct Keep {
    /// Shows others how to join while the run drives.
    pub live_file: Option<PathBuf>,
    pub recording: Option<PathBuf>,
    /// Address at which viewers find the run.
    pub bridge: Option<OsString>,
}

/// Drives a scenario through a process group. `watch` sees it go.
pub fn drive(
    scenario: &Scenario,
    mode: Mode,
    options: &GroupOptions,
    keep: Option<Keep>,
    watch: &mut dyn FnMut(&Moment<'_>),
) -> Result<GroupOutcome, Error> {
    let start_delay = match mode {
        Mode::Realtime => Duration::from_millis(scenario.runtime.start_delay_ms.value().into()),
        Mode::Lockstep => Duration::ZERO,
    };
    let keep = keep.unwrap_or_default();
    let launching = Launch {
        mode,
        scenario: scenario.clone(),
        programs: options.programs()?,
        ready_timeout: Duration::from_secs_f64(options.ready_timeout),
        start_delay,
        live_file: keep.live_file,
        recording: keep.recording,
        bridge: keep.bridge,
    };
    launch(launching, watch)
}
