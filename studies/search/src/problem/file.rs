//! Search files: a problem that is written down. docs/search.md has the format.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use scenario::name::{Line, Name};
use serde::Deserialize;
use supervise::{Error, ScenarioOptions, UsageError};
use toml::{Table, Value as Toml};

use super::term::{FaultChoice, Rule, Term};
use super::variable::{Domain, Value};
use super::{FAULT, NO_FAULT, Problem, SearchError};
use crate::reference::ReferenceName;

/// Keys of a fault that are words.
const WORDS: [&str; 6] = ["kind", "topic", "service", "field", "helper", "name"];

/// Forms of a variable's values.
const DOMAINS: &str = "\"A..B\", \"A..B:log\", \"a,b,c\", a list, or { values, nominal }";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    schema_version: u32,
    name: Name,
    #[serde(default)]
    #[allow(dead_code, reason = "for readers of the file")]
    description: Line,
    scenario: String,
    #[serde(default)]
    reference: ReferenceName,
    #[serde(default)]
    vary: Table,
    #[serde(default)]
    set: Table,
    #[serde(default)]
    faults: Vec<Table>,
    #[serde(default)]
    require: Require,
    probability: Option<Stated>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Require {
    #[serde(default)]
    formulas: Vec<String>,
}

/// `[probability]`, as it is written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Stated {
    #[serde(default)]
    pub distributions: BTreeMap<String, String>,
    #[serde(default)]
    pub correlations: Vec<Correlation>,
    pub exposure: Option<Exposure>,
    /// Rows for Sobol's indices.
    #[serde(default)]
    pub indices: u16,
    /// Points of Monte Carlo, all of which are done; none: half of the budget, until enough failures are there.
    pub monte_carlo: Option<NonZeroUsize>,
}

/// A correlation of two variables.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Correlation {
    pub variables: [String; 2],
    /// Spearman's correlation of their ranks.
    pub rank: f64,
}

/// Rate at which scenes of the problem are met, by the user's account.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Exposure {
    /// The unit: hour, km, year.
    pub per: String,
    pub events: f64,
    pub source: String,
}

/// Reads a search file; none if the argument is a scenario. A search file is TOML with `scenario` or `[vary]`.
pub(super) fn read(argument: &str) -> Result<Option<File>, Error> {
    let path = Path::new(argument);
    if !argument.ends_with(".toml") || !path.exists() {
        return Ok(None);
    }
    let text = Error::text_of(path, "search file")?;
    // A scenario has its own reader, which shows the places of its mistakes.
    match text.parse::<Table>() {
        Ok(table) if table.contains_key("scenario") || table.contains_key("vary") => {}
        _ => return Ok(None),
    }
    let wrong = |reason: toml::de::Error| SearchError::part(argument, reason);
    let file: File = toml::from_str(&text).map_err(wrong)?;
    if file.schema_version != 1 {
        let place = format_args!("{argument}: schema_version {}", file.schema_version);
        return Err(UsageError::at(place, "an unknown version", 1).into());
    }
    Ok(Some(file))
}

impl File {
    /// The scenario with the file's variables, keys and faults.
    pub(super) fn problem(self, path: &Path, options: &ScenarioOptions) -> Result<Problem, Error> {
        let mut options = options.clone();
        options.require.extend(self.require.formulas.iter().cloned());
        let mut problem = Problem::new(&beside(path, &self.scenario), &options)?;
        self.lay_over(&mut problem).map_err(|error| {
            let place = format!("{}: {}", path.display(), error.place);
            UsageError { place, ..error }
        })?;
        self.name.as_str().clone_into(&mut problem.name);
        problem.reference = self.reference.driver();
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        problem.stated = self.probability.map(|stated| (stated, folder));
        Ok(problem)
    }

    fn lay_over(&self, problem: &mut Problem) -> Result<(), UsageError> {
        for (name, value) in &self.vary {
            let refuse = |why| UsageError::at(format_args!("vary.{name}"), why, DOMAINS);
            if name == FAULT && !self.faults.is_empty() {
                let why = "the name is kept for the choice among [[faults]]";
                return Err(refuse(why.to_owned()));
            }
            let (domain, nominal) = varied(value).map_err(refuse)?;
            problem.add(name, domain, nominal);
        }
        for (key, value) in &self.set {
            let term = term(&format!("set.\"{key}\""), value, problem)?;
            problem.rules.push(Rule::new(key, term));
        }
        for table in &self.faults {
            let fault = fault(table, problem)?;
            let is_taken = problem.faults.iter().any(|known| known.name == fault.name);
            if is_taken || fault.name == NO_FAULT {
                let why = format_args!("the name `{}` is taken", fault.name);
                return Err(UsageError::at("faults", why, "a name for each fault"));
            }
            problem.faults.push(fault);
        }
        // A variable that no term reads is a key itself.
        for (place, variable) in problem.variables.iter().enumerate() {
            let in_faults = problem.faults.iter().flat_map(|fault| &fault.keys);
            if !problem.rules.iter().chain(in_faults).any(|one| one.term.reads(place)) {
                problem.rules.push(Rule::new(&variable.name, Term::Variable(place)));
            }
        }
        Ok(())
    }
}

/// A file beside the search file; a built-in name stays.
fn beside(path: &Path, scenario: &str) -> String {
    let is_file = scenario.contains('/') || scenario.contains('.');
    let folder = path.parent().filter(|_| is_file && Path::new(scenario).is_relative());
    folder.map_or_else(|| scenario.to_owned(), |f| f.join(scenario).to_string_lossy().into_owned())
}

/// The word that stands for a value on a command line.
fn word(value: &Toml) -> Option<String> {
    match value {
        Toml::String(word) => Some(word.clone()),
        Toml::Integer(_) | Toml::Float(_) | Toml::Boolean(_) => Some(value.to_string()),
        _ => None,
    }
}

/// A domain and its nominal value, or the reason why the value of `[vary]` is neither.
fn varied(value: &Toml) -> Result<(Domain, Option<Value>), String> {
    let form = || format!("{value} is not a domain");
    let parse = |text: &str| Domain::parse(text).map_err(|error| error.to_string());
    match value {
        Toml::String(text) => Ok((parse(text)?, None)),
        Toml::Array(list) => {
            let words: Option<Vec<String>> = list.iter().map(word).collect();
            Ok((parse(&words.ok_or_else(form)?.join(","))?, None))
        }
        Toml::Table(table) if table.keys().all(|key| key == "values" || key == "nominal") => {
            let (domain, _) = varied(table.get("values").ok_or_else(form)?)?;
            let Some(nominal) = table.get("nominal") else { return Ok((domain, None)) };
            let nominal = Value::of_toml(nominal).ok_or_else(form)?;
            if domain.nearest(&nominal) != nominal {
                return Err(format!("the nominal value {nominal} is not one of {domain}"));
            }
            Ok((domain, Some(nominal)))
        }
        _ => Err(form()),
    }
}

fn fault(table: &Table, problem: &Problem) -> Result<FaultChoice, UsageError> {
    let word = |key: &str| table.get(key).and_then(Toml::as_str);
    let default = || {
        let parts = ["kind", "service", "topic", "field"].into_iter().filter_map(word);
        parts.collect::<Vec<_>>().join(" ")
    };
    let name = word("name").map_or_else(default, str::to_owned);
    let mut keys = Vec::new();
    for (key, value) in table.iter().filter(|(key, _)| *key != "name") {
        let term = match value {
            Toml::Table(_) => Term::Constant(value.clone()),
            Toml::String(_) if WORDS.contains(&key.as_str()) => Term::Constant(value.clone()),
            value => term(&format!("faults.{key}"), value, problem)?,
        };
        keys.push(Rule::of_fault(key, term));
    }
    Ok(FaultChoice { name, keys })
}

fn term(key: &str, value: &Toml, problem: &Problem) -> Result<Term, UsageError> {
    match value {
        Toml::Integer(_) | Toml::Float(_) | Toml::Boolean(_) => Ok(Term::Constant(value.clone())),
        Toml::String(text) => Term::parse(key, text, &problem.variables),
        other => Err(UsageError::at(key, other, "a number or arithmetic in a text")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Problem, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        let problem = file.problem(Path::new("x/search.toml"), &ScenarioOptions::default());
        problem.map_err(|error| error.to_string())
    }

    const HEAD: &str = "schema_version = 1\nname = \"x\"\nscenario = \"tight-brake\"\n";

    #[test]
    fn a_variable_that_no_term_reads_is_a_key() {
        let text = format!(
            "{HEAD}[vary]\nv = \"1..2\"\n\"plant.mass_factor\" = [0.8, 1.2]\n\
             slow = {{ values = \"0..1\", nominal = 0.25 }}\n[set]\nset_speed_mps = \"v*slow\"\n"
        );
        let problem = of(&text).expect("a good file");
        let keys: Vec<&str> = problem.rules.iter().map(|rule| rule.key.as_str()).collect();
        assert_eq!(keys, ["set_speed_mps", "plant.mass_factor"]);
        let slow = problem.variables.iter().find(|one| one.name == "slow").expect("a variable");
        assert_eq!(slow.nominal, Value::Number(0.25));
        assert_eq!(beside(Path::new("x/search.toml"), "./y.toml"), "x/./y.toml");
    }

    #[test]
    fn faults_are_a_choice_with_terms() {
        let text = format!(
            "{HEAD}[vary]\nbegin = \"1..2\"\n[[faults]]\nkind = \"delay\"\ntopic = \"radar/tracks\"\n\
             at_s = \"begin + 1\"\ndelay_ms = 100\n"
        );
        let problem = of(&text).expect("a good file");
        assert_eq!(problem.faults[0].name, "delay radar/tracks");
        assert!(problem.rules.is_empty(), "a fault reads the variable");
        let twice = format!("{text}[[faults]]\nkind = \"delay\"\ntopic = \"radar/tracks\"\n");
        assert!(of(&twice).expect_err("one name").contains("is taken"));
    }

    #[test]
    fn mistakes_name_their_key_and_column() {
        for (rest, what) in [
            ("[vary]\nv = \"2..1\"", "vary.v: the range begins at 2, after its end 1"),
            ("[vary]\nv = 3", "vary.v: 3 is not a domain"),
            (
                "[vary]\nv = { values = \"1..2\", nominal = 3 }",
                "vary.v: the nominal value 3 is not one of 1..2",
            ),
            ("[vary]\nv = { values = \"a,b\", nominal = \"c\" }", "value c is not one of a,b"),
            (
                "[vary]\nv = \"1..2\"\n[set]\na = \"v*w\"",
                "set.\"a\": column 3: unknown variable `w`",
            ),
            (
                "[vary]\nv = \"a,b\"\n[set]\na = \"v + 1\"",
                "set.\"a\": column 1: unknown variable `v`",
            ),
            ("[vary]\nv = \"1..2\"\n[set]\na = []", "set.\"a\": [], expected a number"),
            ("[vary]\nv = \"1..2\"\nw = ", "expected"),
            ("wrong = 1", "unknown field `wrong`"),
        ] {
            let said = of(&format!("{HEAD}{rest}\n")).expect_err(rest);
            assert!(said.contains(what), "{rest}: {said}");
        }
    }
}
