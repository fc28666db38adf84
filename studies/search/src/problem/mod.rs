//! A problem: a scenario, the variables of it, and what is to hold.
//!
//! ```text
//! variables ─ at a point ─► values ─ [set], faults ─► keys ─ over the scenario ─► a run
//! ```
//!
//! A *point* is a place in the unit cube, one coordinate a variable.

mod arithmetic;
mod file;
mod keys;
mod setting;
mod stated;
mod variable;

pub use arithmetic::{Arithmetic, ArithmeticError};
pub use file::FileError;
pub(crate) use file::read;
pub use keys::is_whole;
pub use setting::{Setting, Term};
pub use variable::{Domain, DomainError, Value, Variable, rounded};

use gaussian_process::Kind;
use group::{Error, Failure, GroupOptions, Opening, ScenarioOptions};
use runtime::Mode;
use scenario::Scenario;
use thiserror::Error;

use crate::reference::Reference;
pub(crate) use setting::FaultChoice;
pub(crate) use stated::{Exposure, Stated};
use std::path::{Path, PathBuf};

/// Most variables: the dimensions of the Sobol sequence.
pub const MOST_VARIABLES: usize = 21;

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
    pub reference: Option<Reference>,
    /// The scenario with every variable at its nominal value, without a fault of `[[faults]]`.
    pub nominal: Scenario,
    opening: Opening,
    settings: Vec<Setting>,
    faults: Vec<FaultChoice>,
    /// `[probability]` of the file, and the file's folder.
    stated: Option<(Stated, PathBuf)>,
}

/// Reason why there is no problem.
#[derive(Debug, Error)]
pub enum ProblemError {
    /// Nothing is varied.
    #[error("nothing varies, expected --vary KEY=A..B, --faults all, or a file with [vary]")]
    NoVariable,
    /// More variables than the Sobol sequence has dimensions.
    #[error("{0} variables, expected at most {MOST_VARIABLES}")]
    TooMany(usize),
    #[error("--vary {argument}: {reason}, expected KEY=A..B, KEY=A..B:log or KEY=a,b,c")]
    Vary { argument: String, reason: VaryError },
    /// A point that the scenario refuses.
    #[error("the scenario refuses {point}: {reason}")]
    Refused {
        point: String,
        /// The scenario's words.
        reason: String,
    },
    /// A formula without a value.
    #[error("{key} = \"{formula}\" has no value at {point}")]
    NoValue { key: String, formula: String, point: String },
}

/// Reason why an argument of `--vary` names no variable.
#[derive(Debug, Error)]
pub enum VaryError {
    /// Values without a key.
    #[error("no `=`")]
    NoKey,
    /// Another argument has the same key.
    #[error("the key varies already")]
    Twice,
    #[error(transparent)]
    Domain(#[from] DomainError),
}

impl Failure for ProblemError {}

/// True if the scenario refuses the values of a point, or a formula has no value there.
#[must_use]
pub fn is_refusal(error: &Error) -> bool {
    let Error::Operation(failure) = error else { return false };
    let failure: &(dyn std::error::Error + 'static) = failure.as_ref();
    matches!(
        failure.downcast_ref(),
        Some(ProblemError::Refused { .. } | ProblemError::NoValue { .. })
    )
}

impl Problem {
    /// `[probability]` of the search file, and the file's folder.
    pub(crate) fn stated(&self) -> Option<(&Stated, &Path)> {
        self.stated.as_ref().map(|(stated, folder)| (stated, folder.as_path()))
    }

    /// Number of variables.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.variables.len()
    }

    /// The variables as a Gaussian process sees them: a number that only faults read matters where a fault acts.
    #[must_use]
    pub fn kinds(&self) -> Vec<Kind> {
        let kind = |(place, variable): (usize, &Variable)| match &variable.domain {
            Domain::Words(words) if variable.name == FAULT => Kind::Branch(words.len()),
            Domain::Words(words) => Kind::Word(words.len()),
            _ => {
                let mut keys = self.faults.iter().flat_map(|fault| &fault.keys);
                let is_read = |setting: &Setting| setting.term.reads(place);
                let is_own = keys.any(is_read) && !self.settings.iter().any(is_read);
                if is_own { Kind::Own } else { Kind::Number }
            }
        };
        self.variables.iter().enumerate().map(kind).collect()
    }

    /// Number of variables, in words.
    pub(crate) fn count_in_words(&self) -> String {
        match self.dimensions() {
            1 => "1 variable".to_owned(),
            many => format!("{many} variables"),
        }
    }

    #[must_use]
    pub fn values(&self, point: &[f64]) -> Vec<Value> {
        self.variables.iter().zip(point).map(|(variable, at)| variable.domain.at(*at)).collect()
    }

    /// The point of some values.
    #[must_use]
    pub fn point(&self, values: &[Value]) -> Vec<f64> {
        let place = |(variable, value): (&Variable, &Value)| variable.domain.place(value);
        self.variables.iter().zip(values).map(place).collect()
    }

    /// The keys of the scenario with these values, as for `--set`.
    ///
    /// # Errors
    /// [`ProblemError::NoValue`].
    pub fn keys(&self, values: &[Value]) -> Result<Vec<String>, ProblemError> {
        let mut keys = Vec::with_capacity(self.settings.len() + 1);
        for setting in &self.settings {
            let value = self.text(setting, values)?;
            keys.push(format!("{}={value}", setting.key));
        }
        if let Some(fault) = self.fault(values) {
            let mut all = setting::faults_of(&self.nominal);
            let mut pairs = Vec::with_capacity(fault.keys.len());
            for setting in &fault.keys {
                let value = self.text(setting, values)?;
                pairs.push(format!("{} = {value}", setting.key));
            }
            all.push(format!("{{ {} }}", pairs.join(", ")));
            keys.push(format!("faults=[{}]", all.join(", ")));
        }
        Ok(keys)
    }

    fn text(&self, setting: &Setting, values: &[Value]) -> Result<String, ProblemError> {
        setting.text(values).ok_or_else(|| ProblemError::NoValue {
            key: setting.key.clone(),
            formula: setting.term.formula().to_owned(),
            point: self.words(values),
        })
    }

    fn fault(&self, values: &[Value]) -> Option<&FaultChoice> {
        let place = self.variables.iter().position(|variable| variable.name == FAULT)?;
        self.faults.iter().find(|fault| values[place] == Value::Word(fault.name.clone()))
    }

    /// The scenario with these values and this seed.
    ///
    /// # Errors
    /// [`ProblemError::Refused`], [`ProblemError::NoValue`].
    pub fn scenario(&self, values: &[Value], seed: u64) -> Result<Scenario, Error> {
        let mut keys = self.keys(values)?;
        keys.push(format!("seed={seed}"));
        self.opening.with("--set", &keys).map_err(|error| {
            let said = error.to_string();
            let reason = said.strip_prefix("error: ").unwrap_or(&said).to_owned();
            ProblemError::Refused { point: self.words(values), reason }.into()
        })
    }

    #[must_use]
    pub fn nominal_values(&self) -> Vec<Value> {
        self.variables.iter().map(|variable| variable.nominal.clone()).collect()
    }

    /// Values with the names of their variables.
    #[must_use]
    pub fn words(&self, values: &[Value]) -> String {
        let pair = |(variable, value): (&Variable, &Value)| format!("{} = {value}", variable.name);
        self.variables.iter().zip(values).map(pair).collect::<Vec<_>>().join(", ")
    }

    /// Values by the names of their variables, for tables.
    #[must_use]
    pub fn named(&self, values: &[Value]) -> Vec<(String, String)> {
        let pair =
            |(variable, value): (&Variable, &Value)| (variable.name.clone(), value.to_string());
        self.variables.iter().zip(values).map(pair).collect()
    }

    /// Values in the middle of the variables' domains.
    #[must_use]
    pub fn middle(&self) -> Vec<Value> {
        self.values(&vec![0.5; self.dimensions()])
    }

    /// Text that distinguishes this problem from others.
    #[must_use]
    pub fn subject(&self) -> String {
        format!(
            "{}\n{:?}\n{:?}\n{:?}\n{:?}",
            self.nominal.to_toml(),
            self.variables,
            self.settings,
            self.faults,
            self.reference
        )
    }

    /// Tries the nominal values, and each variable at its ends.
    pub(crate) fn check(&self, group: &GroupOptions) -> Result<(), Error> {
        let nominal = self.nominal_values();
        frame::batch::check(&self.scenario(&nominal, 1)?, Mode::Lockstep, group)?;
        for (place, variable) in self.variables.iter().enumerate() {
            let all: Vec<f64> = match variable.domain.count() {
                None => vec![0.0, 1.0],
                Some(count) => (0..count).map(|k| (k as f64 + 0.5) / count as f64).collect(),
            };
            for at in all {
                let mut values = nominal.clone();
                values[place] = variable.domain.at(at);
                let scenario = self.scenario(&values, 1)?;
                frame::batch::check(&scenario, Mode::Lockstep, group)?;
            }
        }
        Ok(())
    }
}

/// A problem before its scenario is opened.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub name: String,
    pub scenario: String,
    /// Name, values, and the nominal value where it is given.
    pub variables: Vec<(String, Domain, Option<Value>)>,
    /// Key and term; the variables that no term reads are keys themselves.
    pub settings: Vec<Setting>,
    pub faults: Vec<FaultChoice>,
    pub require: Vec<String>,
    /// The driver; none: the default one, `Some(None)`: no driver.
    pub reference: Option<Option<Reference>>,
    pub stated: Option<(Stated, PathBuf)>,
}

impl Draft {
    pub(crate) fn vary(&mut self, argument: &str) -> Result<(), ProblemError> {
        let refuse = |reason| ProblemError::Vary { argument: argument.to_owned(), reason };
        let (key, list) = argument.split_once('=').ok_or_else(|| refuse(VaryError::NoKey))?;
        let key = key.trim();
        if self.variables.iter().any(|(known, ..)| known == key) {
            return Err(refuse(VaryError::Twice));
        }
        let domain = Domain::parse(list).map_err(|error| refuse(error.into()))?;
        let place = self.variables.len();
        self.variables.push((key.to_owned(), domain, None));
        self.settings.push(Setting::new(key, Term::Variable(place)));
        Ok(())
    }

    /// Opens the scenario. The ends of the variables are not tried.
    pub(crate) fn finish(self, mut options: ScenarioOptions) -> Result<Problem, Error> {
        let Self { name, scenario, mut variables, settings, faults, require, reference, stated } =
            self;
        if !faults.is_empty() {
            let none = std::iter::once(NO_FAULT.to_owned());
            let names = none.chain(faults.iter().map(|fault| fault.name.clone())).collect();
            let none = Value::Word(NO_FAULT.to_owned());
            variables.push((FAULT.to_owned(), Domain::Words(names), Some(none)));
        }
        options.require.extend(require);
        // First the scenario: a file that is neither is shown with its mistake.
        let base = group::open(&scenario, &options)?;
        match variables.len() {
            0 => return Err(ProblemError::NoVariable.into()),
            1..=MOST_VARIABLES => {}
            many => return Err(ProblemError::TooMany(many).into()),
        }
        if base.require.formulas.is_empty() {
            options.require.push(crate::value::DEFAULT_REQUIREMENT.to_owned());
        }
        let opening = Opening::of(&scenario, &options)?;
        let base = opening.with("--set", &[])?;
        let written: toml::Table = base.to_toml().parse().unwrap_or_default();
        let variables = variables.into_iter().map(|(name, domain, nominal)| {
            let written = || setting::written(&written, &name);
            let nominal = nominal.or_else(written).map(|value| domain.nearest(&value));
            let nominal = nominal.unwrap_or_else(|| domain.middle());
            Variable { name, domain, nominal }
        });
        Ok(Problem {
            name,
            variables: variables.collect(),
            reference: reference.unwrap_or(Some(Reference::REGULATION)),
            nominal: base,
            opening,
            settings,
            faults,
            stated,
        })
    }
}

/// A scenario's name for titles: that of a file without its folder and ending.
pub(crate) fn scenario_name(argument: &str) -> String {
    let path = std::path::Path::new(argument);
    path.file_stem().map_or_else(|| argument.to_owned(), |name| name.to_string_lossy().into_owned())
}
