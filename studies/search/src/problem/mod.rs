//! A problem: a scenario, the variables of it, and what is to hold.
//!
//! ```text
//! variables ─ at a point ─► values ─ [set], faults ─► settings ─ over the scenario ─► a run
//! ```
//!
//! A *point* is a place in the unit cube, one coordinate a variable.

mod file;
mod term;
mod variable;

pub(crate) use file::{Exposure, Stated};
pub(crate) use term::FaultChoice;
pub use term::{Rule, Term, is_whole};
pub use variable::{Domain, Value, Variable, rounded};

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use gaussian_process::Kind;
use runtime::Mode;
use scenario::{Scenario, Setting, faults};
use supervise::{
    Error, Failure, GroupOptions, Opening, ReferenceDriver, ScenarioOptions, UsageError,
};
use thiserror::Error;

use crate::SearchArguments;
use crate::method::MOST_VARIABLES;
use crate::reference::{self, MOST};

/// Name of the variable that chooses a fault.
pub const FAULT: &str = "fault";

/// The value of [`FAULT`] without a fault.
pub const NO_FAULT: &str = "none";

/// The scene, the choices, and the requirements.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its name: that of the file, or of the scenario.
    pub name: String,
    /// The variables, in the order of a point's coordinates.
    pub variables: Vec<Variable>,
    /// The driver who must be able to avoid a scene that counts; none: every scene counts.
    pub reference: Option<ReferenceDriver>,
    /// The scenario with every variable at its nominal value, without a fault of `[[faults]]`.
    pub nominal: Scenario,
    opening: Opening,
    /// The nominal scenario as it is written.
    written: toml::Table,
    pub(crate) rules: Vec<Rule>,
    pub(crate) faults: Vec<FaultChoice>,
    /// `[probability]` of the file, and the file's folder.
    pub(crate) stated: Option<(Stated, PathBuf)>,
}

#[derive(Debug, Error)]
pub enum SearchError {
    #[error(transparent)]
    Usage(#[from] UsageError),
    /// A mistake whose reason says what was expected.
    #[error("{place}: {reason}")]
    Part { place: String, reason: String },
    /// A point that the scenario refuses, or where a formula has no value.
    #[error("the scenario refuses {point}: {reason}")]
    Refused { point: String, reason: String },
}

impl SearchError {
    pub(crate) fn part(place: &str, reason: impl ToString) -> Self {
        Self::Part { place: place.to_owned(), reason: reason.to_string() }
    }
}

impl Failure for SearchError {}

/// True if the scenario refuses the values of a point, or a formula has no value there.
pub fn is_refusal(error: &Error) -> bool {
    let Error::Operation(failure) = error else { return false };
    let failure: &(dyn std::error::Error + 'static) = failure.as_ref();
    matches!(failure.downcast_ref(), Some(SearchError::Refused { .. }))
}

impl Problem {
    /// The problem of a command: a search file, or a scenario with `--vary`.
    pub fn open(arguments: &SearchArguments, group: &GroupOptions) -> Result<Self, Error> {
        let (name, options) = (arguments.scenario.as_str(), &arguments.scenario_options);
        let mut problem = match file::read(name)? {
            Some(file) => file.problem(Path::new(name), options)?,
            None => Self::new(name, options)?,
        };
        for argument in &arguments.vary {
            problem.vary(argument)?;
        }
        if let Some(reference) = arguments.reference {
            problem.reference = reference.driver();
        }
        let problem = problem.with_choice_of_fault();
        let count = problem.dimensions();
        if !(1..=MOST_VARIABLES).contains(&count) {
            let most = format!("1 to {MOST_VARIABLES}, by --vary KEY=A..B or a file with [vary]");
            let why =
                if count == 0 { "nothing varies".to_owned() } else { format!("{count} variables") };
            return Err(UsageError::at(name, why, most).into());
        }
        let laws = problem.check(group)?;
        options.laws.expect_all_in(&Vec::from_iter(laws))?;
        Ok(problem)
    }

    /// A scenario of which nothing varies yet.
    pub(crate) fn new(scenario: &str, options: &ScenarioOptions) -> Result<Self, Error> {
        let mut options = options.clone();
        if supervise::open(scenario, &options)?.require.formulas.is_empty() {
            options.require.push("no-collision".to_owned());
        }
        let opening = Opening::of(scenario, &options)?;
        let nominal = opening.with("--set", &[])?;
        let stem = Path::new(scenario).file_stem().unwrap_or(scenario.as_ref());
        Ok(Self {
            name: stem.to_string_lossy().into_owned(),
            variables: Vec::new(),
            reference: Some(ReferenceDriver::REGULATION),
            written: toml::Table::try_from(&nominal).unwrap_or_default(),
            nominal,
            opening,
            rules: Vec::new(),
            faults: Vec::new(),
            stated: None,
        })
    }

    /// Adds a variable. Without a nominal value a key keeps the value that the scenario has.
    pub(crate) fn add(&mut self, name: &str, domain: Domain, nominal: Option<Value>) -> Term {
        let nominal = nominal.or_else(|| written(&self.written, name));
        let nominal = nominal.map_or_else(|| domain.middle(), |value| domain.nearest(&value));
        self.variables.push(Variable { name: name.to_owned(), domain, nominal });
        Term::Variable(self.variables.len() - 1)
    }

    fn vary(&mut self, argument: &str) -> Result<(), UsageError> {
        let refuse = |why: &dyn std::fmt::Display| {
            UsageError::option("--vary", argument, why, "KEY=A..B, KEY=A..B:log or KEY=a,b,c")
        };
        let (key, list) = argument.split_once('=').ok_or_else(|| refuse(&"no `=`"))?;
        let key = key.trim();
        if self.variables.iter().any(|known| known.name == key) {
            return Err(refuse(&"the key varies already"));
        }
        let term = self.add(key, Domain::parse(list).map_err(|error| refuse(&error))?, None);
        self.rules.push(Rule::new(key, term));
        Ok(())
    }

    /// The same with a variable that chooses among the faults, if there are any.
    pub(crate) fn with_choice_of_fault(mut self) -> Self {
        let none = NO_FAULT.to_owned();
        if !self.faults.is_empty() {
            let names = self.faults.iter().map(|fault| fault.name.clone());
            let names = std::iter::once(none.clone()).chain(names).collect();
            self.add(FAULT, Domain::Words(names), Some(Value::Word(none)));
        }
        self
    }

    /// Number of variables.
    pub fn dimensions(&self) -> usize {
        self.variables.len()
    }

    /// The variables as a Gaussian process sees them: a number that only faults read matters where a fault acts.
    pub fn kinds(&self) -> Vec<Kind> {
        let kind = |(place, variable): (usize, &Variable)| match &variable.domain {
            Domain::Words(words) if variable.name == FAULT => Kind::Branch(words.len()),
            Domain::Words(words) => Kind::Word(words.len()),
            _ => {
                let mut keys = self.faults.iter().flat_map(|fault| &fault.keys);
                let is_read = |rule: &Rule| rule.term.reads(place);
                let is_own = keys.any(is_read) && !self.rules.iter().any(is_read);
                if is_own { Kind::Own } else { Kind::Number }
            }
        };
        self.variables.iter().enumerate().map(kind).collect()
    }

    pub fn values(&self, point: &[f64]) -> Vec<Value> {
        self.variables.iter().zip(point).map(|(variable, at)| variable.domain.at(*at)).collect()
    }

    pub fn point(&self, values: &[Value]) -> Vec<f64> {
        let place = |(variable, value): (&Variable, &Value)| variable.domain.place(value);
        self.variables.iter().zip(values).map(place).collect()
    }

    fn fault(&self, values: &[Value]) -> Option<&FaultChoice> {
        let place = self.variables.iter().position(|variable| variable.name == FAULT)?;
        self.faults.iter().find(|fault| values[place] == Value::Word(fault.name.clone()))
    }

    /// The keys that the rules give with these values.
    fn settings(&self, values: &[Value]) -> Result<Vec<Setting>, Error> {
        let mut settings = Vec::with_capacity(self.rules.len() + 2);
        for rule in &self.rules {
            settings.push(Setting::new(&rule.key, rule.value(values)?));
        }
        if let Some(fault) = self.fault(values) {
            let pair = |rule: &Rule| Ok((rule.key.clone(), rule.value(values)?));
            let keys: Result<toml::Table, UsageError> = fault.keys.iter().map(pair).collect();
            let refuse = |problem: scenario::Problem| {
                let place = format_args!("{}, {}", fault.name, problem.path);
                UsageError::at(place, problem.message, problem.expected)
            };
            let mut all = self.nominal.faults.clone();
            all.push(faults::read(keys?).map_err(refuse)?);
            settings.push(Setting::faults(&all));
        }
        Ok(settings)
    }

    pub fn scenario(&self, values: &[Value], seed: u64) -> Result<Scenario, Error> {
        let refused = |reason: &str| {
            let pairs =
                self.named(values).into_iter().map(|(name, value)| format!("{name} = {value}"));
            let point = pairs.collect::<Vec<_>>().join(", ");
            let reason = reason.strip_prefix("error: ").unwrap_or(reason).to_owned();
            Error::from(SearchError::Refused { point, reason })
        };
        let mut settings = self.settings(values).map_err(|error| refused(&error.to_string()))?;
        settings.push(Setting::new("seed", seed as i64));
        self.opening.with("--set", &settings).map_err(|error| refused(&error.to_string()))
    }

    /// Value of a scene by the reference alone, tolerances. It is above 0 where the driver does not avoid the scene.
    pub fn by_reference(&self, scenario: &Scenario) -> f64 {
        self.reference.map_or(-MOST, |driver| reference::drive(driver, scenario, false).value())
    }

    /// The same at a point. Below 0 the point is admissible.
    pub fn admit(&self, point: &[f64]) -> Result<f64, Error> {
        Ok(self.by_reference(&self.scenario(&self.values(point), 1)?))
    }

    pub fn nominal_values(&self) -> Vec<Value> {
        self.variables.iter().map(|variable| variable.nominal.clone()).collect()
    }

    /// Values by the names of their variables, for tables.
    pub fn named(&self, values: &[Value]) -> Vec<(String, String)> {
        let pair =
            |(variable, value): (&Variable, &Value)| (variable.name.clone(), value.to_string());
        self.variables.iter().zip(values).map(pair).collect()
    }

    /// Values in the middle of the variables' domains.
    pub fn middle(&self) -> Vec<Value> {
        self.values(&vec![0.5; self.dimensions()])
    }

    /// Text that distinguishes this problem from others.
    pub fn subject(&self) -> String {
        format!(
            "{}\n{:?}\n{:?}\n{:?}\n{:?}",
            self.nominal.to_toml(),
            self.variables,
            self.rules,
            self.faults,
            self.reference
        )
    }

    /// Tries the nominal values, and each variable at its ends. Gives the laws that drive.
    fn check(&self, group: &GroupOptions) -> Result<BTreeSet<String>, Error> {
        let nominal = self.nominal_values();
        let mut all = vec![nominal.clone()];
        for (place, variable) in self.variables.iter().enumerate() {
            let places: Vec<f64> = match variable.domain.count() {
                None => vec![0.0, 1.0],
                Some(count) => (0..count).map(|k| (k as f64 + 0.5) / count as f64).collect(),
            };
            all.extend(places.into_iter().map(|at| {
                let mut values = nominal.clone();
                values[place] = variable.domain.at(at);
                values
            }));
        }
        let mut laws = BTreeSet::new();
        for values in all {
            let scenario = self.scenario(&values, 1)?;
            frame::batch::check(&scenario, Mode::Lockstep, group)?;
            laws.insert(scenario.controller.name.as_str().to_owned());
        }
        Ok(laws)
    }
}

/// The number or word that a scenario has at a dotted path.
fn written(table: &toml::Table, path: &str) -> Option<Value> {
    let mut segments = path.split(['.', '[']).map(|part| part.trim_end_matches(']'));
    let mut value = table.get(segments.next()?)?;
    for segment in segments {
        value = match value {
            toml::Value::Array(list) => list.get(segment.parse::<usize>().ok()?)?,
            value => value.get(segment)?,
        };
    }
    Value::of_toml(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_value_is_found_by_its_path() {
        let table: toml::Table =
            "a = 3\n[[actors]]\ngap_m = 2.5\nname = \"x\"".parse().expect("TOML");
        assert_eq!(written(&table, "a"), Some(Value::Number(3.0)));
        assert_eq!(written(&table, "actors.0.gap_m"), Some(Value::Number(2.5)));
        assert_eq!(written(&table, "actors[0].name"), Some(Value::Word("x".into())));
        assert_eq!(written(&table, "actors.1.name"), None);
    }
}
