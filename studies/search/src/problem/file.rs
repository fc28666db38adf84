//! Search files: a problem that is written down.
//!
//! ```toml
//! schema_version = 1
//! name = "cut-in-5"
//! scenario = "./cut-in-base.toml"        # a built-in name, or a file beside this one
//! reference = "regulation"               # or "careful", "none"
//!
//! [vary]                                 # names, or keys of the scenario
//! v0 = "12..36"                          # a range, evenly or with :log
//! thw = { values = "0.8..2", nominal = 1.5 }
//! law = "acc-mpc,cacc-mpc"               # a list
//! begin = "2..8"
//!
//! [set]                                  # keys of the scenario: arithmetic on the variables
//! "plant.initial_speed_mps" = "v0"
//! "actors.0.gap_m" = "max(5, thw*v0)"
//! "controller.name" = "law"
//!
//! [[faults]]                             # at most one of them acts: the variable `fault`
//! name = "late-tracks"
//! kind = "delay"                         # keys as in a scenario, with arithmetic where numbers stand
//! topic = "radar/tracks"
//! at_s = "begin"
//! for_s = 0.5
//! delay_ms = "100 + 20*begin"
//!
//! [require]
//! formulas = ["min-gap:1"]
//! ```
//!
//! A name of `[vary]` that no term reads is a key of the scenario itself.

use std::path::{Path, PathBuf};

use group::{Error, Failure};
use scenario::name::{Line, Name};
use serde::Deserialize;
use thiserror::Error;
use toml::{Table, Value as Toml};

use super::arithmetic::{Arithmetic, ArithmeticError};
use super::setting::{FaultChoice, Setting, Term};
use super::stated::Stated;
use super::variable::{Domain, DomainError, Value};
use super::{Draft, FAULT, NO_FAULT};
use crate::reference::{Reference, ReferenceName};

/// Longest search file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Keys of a fault that are words.
const WORDS: [&str; 6] = ["kind", "topic", "service", "field", "helper", "name"];

/// A file that is not a problem.
#[derive(Debug, Error)]
#[error("{}: {fault}", path.display())]
pub struct FileError {
    path: PathBuf,
    fault: Fault,
}

impl Failure for FileError {}

/// The fault of a search file.
#[derive(Debug, Error)]
enum Fault {
    #[error("more than {MAX_BYTES} bytes, expected a search file")]
    Long,
    #[error("{0}")]
    Toml(#[from] toml::de::Error),
    #[error("version {0} of the schema is not known, expected 1")]
    Version(u32),
    #[error(
        "vary.{name}: {reason}, expected \"A..B\", \"A..B:log\", \"a,b,c\", a list, or {{ values, nominal }}"
    )]
    Vary { name: String, reason: VaryFault },
    #[error("{key}: {reason}")]
    Set { key: String, reason: Box<ArithmeticError> },
    #[error("{key}: {found}, expected a number or arithmetic in a text")]
    Term { key: String, found: String },
    #[error("faults: {0}")]
    Name(String),
}

#[derive(Debug, Error)]
enum VaryFault {
    #[error(transparent)]
    Domain(#[from] DomainError),
    #[error("{0} is not a domain")]
    Form(String),
    #[error("the name is kept for the choice among [[faults]]")]
    Kept,
    #[error("the nominal value {nominal} is not one of {domain}")]
    Nominal { nominal: Value, domain: Domain },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
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

/// A search file that was read.
pub(crate) struct Read {
    path: PathBuf,
    file: File,
}

/// Reads a search file; none if the argument is a scenario. A search file is TOML with `scenario` or `[vary]`.
///
/// # Errors
/// [`FileError`], or the file cannot be read.
pub(crate) fn read(argument: &str) -> Result<Option<Read>, Error> {
    let path = Path::new(argument);
    if !argument.ends_with(".toml") || !path.exists() {
        return Ok(None);
    }
    let failed = |reason| Error::Path { action: "read", path: path.to_owned(), reason };
    let refuse = |fault| FileError { path: path.to_owned(), fault };
    if std::fs::metadata(path).map_err(failed)?.len() > MAX_BYTES {
        return Err(refuse(Fault::Long).into());
    }
    let text = std::fs::read_to_string(path).map_err(failed)?;
    // A scenario has its own reader, which shows the places of its mistakes.
    match text.parse::<Table>() {
        Ok(table) if table.contains_key("scenario") || table.contains_key("vary") => {}
        _ => return Ok(None),
    }
    let file: File = toml::from_str(&text).map_err(|error| refuse(error.into()))?;
    if file.schema_version != 1 {
        return Err(refuse(Fault::Version(file.schema_version)).into());
    }
    Ok(Some(Read { path: path.to_owned(), file }))
}

impl Read {
    /// The problem of the file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn draft(self) -> Result<Draft, FileError> {
        let Self { path, file } = self;
        draft(&path, file).map_err(|fault| FileError { path, fault })
    }
}

fn draft(path: &Path, file: File) -> Result<Draft, Fault> {
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    let mut variables = Vec::with_capacity(file.vary.len());
    for (name, value) in &file.vary {
        let refuse = |reason| Fault::Vary { name: name.clone(), reason };
        if name == FAULT && !file.faults.is_empty() {
            return Err(refuse(VaryFault::Kept));
        }
        let (domain, nominal) = varied(value).map_err(refuse)?;
        variables.push((name.clone(), domain, nominal));
    }
    let of_number = |(name, domain, _): &(String, Domain, Option<Value>)| {
        (!domain.is_of_words()).then(|| name.clone())
    };
    let numbers: Vec<Option<String>> = variables.iter().map(of_number).collect();
    let names: Vec<&str> = variables.iter().map(|(name, ..)| name.as_str()).collect();
    let reader = Terms { names: &names, numbers: &numbers };
    let mut settings = Vec::new();
    for (key, value) in &file.set {
        let term = reader.term(&format!("set.\"{key}\""), value)?;
        settings.push(Setting::new(key, term));
    }
    let mut faults: Vec<FaultChoice> = Vec::new();
    for table in &file.faults {
        let fault = fault(table, &reader)?;
        if fault.name == NO_FAULT || faults.iter().any(|known| known.name == fault.name) {
            return Err(Fault::Name(format!(
                "the name `{}` is taken, expected a name for each fault",
                fault.name
            )));
        }
        faults.push(fault);
    }
    let in_faults = faults.iter().flat_map(|fault| &fault.keys);
    let terms: Vec<&Setting> = settings.iter().chain(in_faults).collect();
    let is_read = |place: usize| {
        terms.iter().any(|setting| match &setting.term {
            Term::Constant(_) => false,
            Term::Variable(one) => *one == place,
            Term::Formula(formula) => formula.reads(place),
        })
    };
    let keys = (0..names.len()).filter(|place| !is_read(*place));
    let keys: Vec<_> =
        keys.map(|place| Setting::new(names[place], Term::Variable(place))).collect();
    settings.extend(keys);
    Ok(Draft {
        name: file.name.as_str().to_owned(),
        scenario: beside(path, &file.scenario),
        variables,
        settings,
        faults,
        require: file.require.formulas,
        reference: Some(Reference::named(file.reference)),
        stated: file.probability.map(|stated| (stated, folder)),
    })
}

/// A file beside the search file; a built-in name stays.
fn beside(path: &Path, scenario: &str) -> String {
    let is_file = scenario.contains('/') || scenario.contains('.');
    let folder = path.parent().filter(|_| is_file && Path::new(scenario).is_relative());
    folder.map_or_else(|| scenario.to_owned(), |f| f.join(scenario).to_string_lossy().into_owned())
}

fn varied(value: &Toml) -> Result<(Domain, Option<Value>), VaryFault> {
    let word = |value: &Toml| match value {
        Toml::String(word) => Some(word.clone()),
        Toml::Integer(number) => Some(number.to_string()),
        Toml::Float(number) => Some(number.to_string()),
        Toml::Boolean(flag) => Some(flag.to_string()),
        _ => None,
    };
    let form = || VaryFault::Form(value.to_string());
    match value {
        Toml::String(text) => Ok((Domain::parse(text)?, None)),
        Toml::Array(list) => {
            let words: Option<Vec<String>> = list.iter().map(word).collect();
            Ok((Domain::list(words.ok_or_else(form)?)?, None))
        }
        Toml::Table(table) if table.keys().all(|key| key == "values" || key == "nominal") => {
            let (domain, _) = varied(table.get("values").ok_or_else(form)?)?;
            let nominal = match table.get("nominal") {
                Some(Toml::Integer(number)) => Some(Value::Number(*number as f64)),
                Some(Toml::Float(number)) => Some(Value::Number(*number)),
                Some(other) => Some(Value::Word(word(other).ok_or_else(form)?)),
                None => None,
            };
            if let Some(nominal) = nominal.clone().filter(|value| domain.nearest(value) != *value) {
                return Err(VaryFault::Nominal { nominal, domain });
            }
            Ok((domain, nominal))
        }
        _ => Err(form()),
    }
}

fn fault(table: &Table, terms: &Terms<'_>) -> Result<FaultChoice, Fault> {
    let word = |key: &str| table.get(key).and_then(Toml::as_str);
    let default = || {
        let parts = ["kind", "service", "topic", "field"].into_iter().filter_map(word);
        parts.collect::<Vec<_>>().join(" ")
    };
    let name = word("name").map_or_else(default, str::to_owned);
    let mut keys = Vec::new();
    for (key, value) in table.iter().filter(|(key, _)| *key != "name") {
        let term = match value {
            Toml::Table(_) => Term::Constant(value.to_string()),
            Toml::String(_) if WORDS.contains(&key.as_str()) => Term::Constant(value.to_string()),
            value => terms.term(&format!("faults.{key}"), value)?,
        };
        keys.push(Setting::of_fault(key, term));
    }
    Ok(FaultChoice { name, keys })
}

/// Reads terms over the variables.
struct Terms<'a> {
    names: &'a [&'a str],
    /// The same where the variable is a number.
    numbers: &'a [Option<String>],
}

impl Terms<'_> {
    fn term(&self, key: &str, value: &Toml) -> Result<Term, Fault> {
        match value {
            Toml::Integer(_) | Toml::Float(_) | Toml::Boolean(_) => {
                Ok(Term::Constant(value.to_string()))
            }
            Toml::String(text) => {
                if let Some(place) = self.names.iter().position(|name| *name == text.trim()) {
                    return Ok(Term::Variable(place));
                }
                let numbers: Vec<Option<&str>> =
                    self.numbers.iter().map(Option::as_deref).collect();
                let formula = Arithmetic::parse(text, &numbers);
                let formula = formula.map_err(|reason| Fault::Set {
                    key: key.to_owned(),
                    reason: Box::new(reason),
                })?;
                Ok(Term::Formula(formula))
            }
            other => Err(Fault::Term { key: key.to_owned(), found: other.to_string() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Draft, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        draft(Path::new("x/search.toml"), file).map_err(|fault| fault.to_string())
    }

    const HEAD: &str = "schema_version = 1\nname = \"x\"\nscenario = \"./y.toml\"\n";

    #[test]
    fn a_variable_that_no_term_reads_is_a_key() {
        let text = format!(
            "{HEAD}[vary]\nv = \"1..2\"\n\"plant.mass_factor\" = [0.8, 1.2]\n\
             slow = {{ values = \"0..1\", nominal = 0.25 }}\n[set]\nset_speed_mps = \"v*slow\"\n"
        );
        let draft = of(&text).expect("a good file");
        let keys: Vec<&str> = draft.settings.iter().map(|setting| setting.key.as_str()).collect();
        assert_eq!(keys, ["set_speed_mps", "plant.mass_factor"]);
        let nominal = draft.variables.iter().map(|(_, _, nominal)| nominal.clone());
        assert!(nominal.into_iter().flatten().eq([Value::Number(0.25)]));
        assert_eq!(draft.scenario, "x/./y.toml");
    }

    #[test]
    fn faults_are_a_choice_with_terms() {
        let text = format!(
            "{HEAD}[vary]\nbegin = \"1..2\"\n[[faults]]\nkind = \"delay\"\ntopic = \"radar/tracks\"\n\
             at_s = \"begin + 1\"\ndelay_ms = 100\n"
        );
        let draft = of(&text).expect("a good file");
        assert_eq!(draft.faults[0].name, "delay radar/tracks");
        assert!(draft.settings.is_empty(), "a fault reads the variable");
        let twice = format!("{text}[[faults]]\nkind = \"delay\"\ntopic = \"radar/tracks\"\n");
        assert!(of(&twice).expect_err("one name").contains("is taken"));
    }

    #[test]
    fn mistakes_name_their_key_and_column() {
        for (rest, what) in [
            ("[vary]\nv = \"2..1\"", "vary.v: the range is empty"),
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
