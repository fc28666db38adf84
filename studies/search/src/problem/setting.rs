//! Terms: what becomes of the variables' values in the scenario.

use scenario::Scenario;

use super::arithmetic::Arithmetic;
use super::keys::is_whole;
use super::variable::{Value, rounded};

/// A key of the scenario and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Dotted path.
    pub key: String,
    pub term: Term,
    /// The key holds whole numbers.
    is_whole: bool,
}

impl Setting {
    /// A key of the scenario.
    #[must_use]
    pub fn new(key: &str, term: Term) -> Self {
        Self { key: key.to_owned(), term, is_whole: is_whole(key) }
    }

    pub(crate) fn of_fault(key: &str, term: Term) -> Self {
        Self { key: key.to_owned(), term, is_whole: is_whole(&format!("faults.0.{key}")) }
    }

    /// TOML text of the value; none if a formula has no finite value.
    pub(crate) fn text(&self, values: &[Value]) -> Option<String> {
        self.term.text(values, self.is_whole)
    }
}

/// The right side of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// TOML text that stays.
    Constant(String),
    Variable(usize),
    /// A number computed from variables.
    Formula(Arithmetic),
}

/// A fault that a search may choose.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaultChoice {
    /// Its name, a value of the variable `fault`.
    pub name: String,
    /// Its keys, as in a scenario's `[[faults]]`.
    pub keys: Vec<Setting>,
}

impl Term {
    /// TOML text of the value; none if a formula has no finite value. A formula that reads a word cannot have one.
    pub(crate) fn text(&self, values: &[Value], is_whole: bool) -> Option<String> {
        let number = |number: f64| {
            let number = if is_whole { number.round() } else { rounded(number, 9) };
            number.is_finite().then(|| number.to_string())
        };
        match self {
            Self::Constant(text) => Some(text.clone()),
            Self::Variable(place) => match &values[*place] {
                Value::Number(value) => number(*value),
                // A truth value is not a word to TOML.
                Value::Word(word) if matches!(word.as_str(), "true" | "false") => {
                    Some(word.clone())
                }
                Value::Word(word) => Some(toml::Value::String(word.clone()).to_string()),
            },
            Self::Formula(formula) => {
                let of = |value: &Value| value.number().unwrap_or(f64::NAN);
                number(formula.value(&values.iter().map(of).collect::<Vec<_>>()))
            }
        }
    }

    /// True if the term reads this variable.
    pub(crate) fn reads(&self, variable: usize) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Variable(place) => *place == variable,
            Self::Formula(formula) => formula.reads(variable),
        }
    }

    /// The formula's text; empty for other terms.
    pub(crate) fn formula(&self) -> &str {
        match self {
            Self::Formula(formula) => formula.text(),
            Self::Constant(_) | Self::Variable(_) => "",
        }
    }
}

/// The faults of a scenario as inline tables.
pub(crate) fn faults_of(scenario: &Scenario) -> Vec<String> {
    if scenario.faults.is_empty() {
        return Vec::new();
    }
    let table: toml::Table = scenario.to_toml().parse().unwrap_or_default();
    let faults = table.get("faults").and_then(toml::Value::as_array);
    faults.into_iter().flatten().map(toml::Value::to_string).collect()
}

/// The number or word that a scenario has at a dotted path.
pub(crate) fn written(table: &toml::Table, path: &str) -> Option<Value> {
    let mut segments = path.split(['.', '[']).map(|part| part.trim_end_matches(']'));
    let mut value = table.get(segments.next()?)?;
    for segment in segments {
        value = match value {
            toml::Value::Array(list) => list.get(segment.parse::<usize>().ok()?)?,
            value => value.get(segment)?,
        };
    }
    match value {
        toml::Value::Integer(number) => Some(Value::Number(*number as f64)),
        toml::Value::Float(number) => Some(Value::Number(*number)),
        toml::Value::String(word) => Some(Value::Word(word.clone())),
        toml::Value::Boolean(flag) => Some(Value::Word(flag.to_string())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_toml() {
        let values =
            [Value::Number(2.25), Value::Word("acc-mpc".into()), Value::Word("true".into())];
        let text = |term: Term, is_whole| term.text(&values, is_whole);
        assert_eq!(text(Term::Variable(0), false).as_deref(), Some("2.25"));
        assert_eq!(text(Term::Variable(0), true).as_deref(), Some("2"));
        assert_eq!(text(Term::Variable(1), false).as_deref(), Some("\"acc-mpc\""));
        assert_eq!(text(Term::Variable(2), false).as_deref(), Some("true"));
        let over = |text: &str| Arithmetic::parse(text, &[Some("a"), None, None]).expect(text);
        assert_eq!(text(Term::Formula(over("0.1*3*a")), false).as_deref(), Some("0.675"));
        assert_eq!(text(Term::Formula(over("1/(a - 2.25)")), false), None);
    }

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
