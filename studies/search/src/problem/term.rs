//! Terms: what becomes of the variables' values in the scenario.

use super::variable::{Value, Variable, rounded};
use openscenario::expression::{self, Fault, evaluate};
use scenario::schema::{Key, Shape};
use supervise::UsageError;
use toml::Value as Toml;

/// A key of the scenario and the term that gives its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Dotted path.
    pub key: String,
    pub term: Term,
    /// The key holds whole numbers.
    is_whole: bool,
}

/// The right side of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    Constant(Toml),
    Variable(usize),
    /// Arithmetic on variables, and the same with `$k` for the variable at place `k`.
    Formula {
        text: String,
        numbered: String,
        reads: Vec<usize>,
    },
}

/// A fault that a search may choose.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaultChoice {
    /// Its name, a value of the variable `fault`.
    pub name: String,
    /// Its keys, as in a scenario's `[[faults]]`.
    pub keys: Vec<Rule>,
}

impl Rule {
    pub(crate) fn new(key: &str, term: Term) -> Self {
        Self { key: key.to_owned(), term, is_whole: is_whole(key) }
    }

    pub(crate) fn of_fault(key: &str, term: Term) -> Self {
        Self { key: key.to_owned(), term, is_whole: is_whole(&format!("faults.0.{key}")) }
    }

    pub(crate) fn value(&self, values: &[Value]) -> Result<Toml, UsageError> {
        let number = |number: f64| {
            let number = if self.is_whole { number.round() } else { rounded(number, 9) };
            // A key of a law's table may hold whole numbers, which is not known here.
            let is_whole = number.fract() == 0.0 && number.abs() < 9e15;
            if is_whole { Toml::Integer(number as i64) } else { Toml::Float(number) }
        };
        match &self.term {
            Term::Constant(value) => Ok(value.clone()),
            Term::Variable(place) => Ok(match &values[*place] {
                Value::Number(value) => number(*value),
                // A truth value is not a word to TOML.
                Value::Word(word) => match word.parse() {
                    Ok(flag) => Toml::Boolean(flag),
                    Err(_) => Toml::String(word.clone()),
                },
            }),
            Term::Formula { text, numbered, .. } => {
                let mut variable = |name: &str| {
                    let value = name.parse().ok().and_then(|place: usize| values.get(place));
                    let value = value.and_then(Value::number).map(expression::Value::Number);
                    value.ok_or_else(|| name.to_owned())
                };
                let (why, expected) = match evaluate(numbered, &mut variable) {
                    Ok(expression::Value::Number(value)) => return Ok(number(value)),
                    Ok(other) => (format!("`{}` is not a number", other.text()), "a number".into()),
                    Err(Fault::Parameter(name)) => (format!("`${name}`"), "a variable".into()),
                    Err(Fault::Expression(why, expected)) => (why, expected),
                };
                Err(UsageError::at(format_args!("{} = \"{text}\"", self.key), why, expected))
            }
        }
    }
}

impl Term {
    /// Reads the text of `key`: a variable's name, or arithmetic on variables that are numbers. Whether it is arithmetic
    /// shows when it is evaluated.
    ///
    /// # Errors
    /// A name that is not a variable's, with its column.
    pub fn parse(key: &str, text: &str, variables: &[Variable]) -> Result<Self, UsageError> {
        if let Some(place) = variables.iter().position(|one| one.name == text.trim()) {
            return Ok(Self::Variable(place));
        }
        let numbers = || variables.iter().enumerate().filter(|(_, one)| !one.domain.is_of_words());
        let is_in_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
        let (mut numbered, mut reads, mut rest) = (String::new(), Vec::new(), text);
        while let Some(first) = rest.chars().next() {
            let length = rest.find(|c| !is_in_name(c)).unwrap_or(rest.len());
            let (word, after) = rest.split_at(length.max(first.len_utf8()));
            let is_name = first.is_ascii_alphabetic() || first == '_';
            if is_name && !after.trim_start().starts_with('(') {
                let Some((place, _)) = numbers().find(|(_, one)| one.name == word) else {
                    let column = text[..text.len() - rest.len()].chars().count() + 1;
                    let why = format_args!("column {column}: unknown variable `{word}`");
                    let known = numbers().map(|(_, one)| one.name.as_str());
                    return Err(UsageError::at(key, why, scenario::accepted(word, known)));
                };
                numbered.push_str(&format!("${place}"));
                reads.push(place);
            } else {
                numbered.push_str(word);
            }
            rest = after;
        }
        Ok(Self::Formula { text: text.to_owned(), numbered, reads })
    }

    pub(crate) fn reads(&self, variable: usize) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Variable(place) => *place == variable,
            Self::Formula { reads, .. } => reads.contains(&variable),
        }
    }
}

/// True if the key at a dotted path holds whole numbers.
///
/// ```
/// assert!(search::problem::is_whole("runtime.extra_delay_ms"));
/// assert!(!search::problem::is_whole("actors.0.gap_m"));
/// ```
pub fn is_whole(path: &str) -> bool {
    let segments: Vec<&str> =
        path.split(['.', '[']).map(|part| part.trim_end_matches(']')).collect();
    below(scenario::keys(), &segments)
}

fn below(keys: &[Key], path: &[&str]) -> bool {
    let Some((first, rest)) = path.split_first() else { return false };
    keys.iter().filter(|key| key.name == *first).any(|key| of_shape(&key.shape, rest))
}

fn of_shape(shape: &Shape, path: &[&str]) -> bool {
    match (shape, path.split_first()) {
        (Shape::Number { is_whole, .. }, None) => *is_whole,
        (Shape::List(element), Some((_, rest))) => of_shape(element, rest),
        (Shape::Tuple(elements, _), Some((place, rest))) => {
            let element = place.parse().ok().and_then(|place: usize| elements.get(place));
            element.is_some_and(|element| of_shape(element, rest))
        }
        (Shape::Table(keys), Some(_)) => below(keys, path),
        (Shape::Choice(variants), Some((name, rest))) => variants
            .iter()
            .filter(|variant| variant.name == *name)
            .any(|variant| variant.shape.as_ref().is_some_and(|shape| of_shape(shape, rest))),
        (Shape::Kinds(kinds), Some(_)) => kinds.iter().any(|(_, keys)| below(keys, path)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Domain;
    use super::*;

    fn variables() -> Vec<Variable> {
        let of = |name: &str, text: &str| {
            let domain = Domain::parse(text).expect(text);
            Variable { name: name.to_owned(), nominal: domain.middle(), domain }
        };
        vec![of("a", "0..9"), of("actors.0.gap_m", "0..90"), of("law", "x,true")]
    }

    fn text(term: Term, key: &str) -> Result<String, String> {
        let values = [Value::Number(2.25), Value::Number(30.0), Value::Word("true".into())];
        let value = Rule::new(key, term).value(&values).map_err(|error| error.to_string())?;
        Ok(value.to_string())
    }

    #[test]
    fn values_become_toml() {
        assert_eq!(text(Term::Variable(0), "set_speed_mps").as_deref(), Ok("2.25"));
        assert_eq!(text(Term::Variable(0), "seed").as_deref(), Ok("2"));
        assert_eq!(text(Term::Variable(2), "name").as_deref(), Ok("true"));
        let word = Rule::new("name", Term::Variable(0)).value(&[Value::Word("acc-mpc".into())]);
        assert_eq!(word.expect("a word"), "acc-mpc".into());
    }

    #[test]
    fn operators_bind_as_in_school() {
        for (formula, expected) in [
            ("1 + 2*3", "7"),
            ("(1 + 2)*3", "9"),
            ("10 - 4 - 3", "3"),
            ("8 / 2 / 2", "2"),
            ("-a*a", "-5.0625"),
            ("2 - -3", "5"),
            ("actors.0.gap_m/a + 1.5e1", "28.3333333"),
            ("2e-1*10", "2"),
            ("min(a, min(5, max(1, 0)))", "1"),
            ("0.1*3*a", "0.675"),
        ] {
            let term = Term::parse("key", formula, &variables()).expect(formula);
            assert_eq!(text(term, "set_speed_mps").as_deref(), Ok(expected), "{formula}");
        }
    }

    #[test]
    fn what_is_no_number_says_why() {
        for (formula, what) in [
            ("", "ends too early"),
            ("a +", "ends too early"),
            ("a 3", "left over, expected an operator"),
            ("(a", "is not closed, expected `)`"),
            ("min(a; 3)", "`min` has one argument, expected two"),
            ("1.2.3", "`1.2.3` is not a number"),
            ("1/(a - 2.25)", "a division by 0"),
            ("$9 + 1", "`$9`, expected a variable"),
            ("half(a)", "`half` is not a function"),
        ] {
            let term = Term::parse("key", formula, &variables()).expect(formula);
            let said = text(term, "set_speed_mps").expect_err(formula);
            let place = format!("set_speed_mps = \"{formula}\": ");
            assert!(said.starts_with(&place) && said.contains(what), "{said}");
        }
        let deep = "(".repeat(200) + "1" + &")".repeat(200);
        assert!(text(Term::parse("key", &deep, &[]).expect("no names"), "seed").is_err());
        for (formula, column, word) in [("a * bb", 5, "bb"), ("2 × law", 5, "law")] {
            let found = Term::parse("key", formula, &variables()).expect_err(formula);
            let expected =
                format!("key: column {column}: unknown variable `{word}`, expected `a` or");
            assert!(found.to_string().starts_with(&expected), "{found}");
        }
    }

    #[test]
    fn whole_numbers_are_found_below_lists_kinds_and_choices() {
        for path in ["seed", "plant.period_ms", "faults.0.delay_ms", "faults[2].bits"] {
            assert!(is_whole(path), "{path}");
        }
        for path in ["duration_s", "faults.0.at_s", "actors.0.profile.sine.period_s", "no.such", ""]
        {
            assert!(!is_whole(path), "{path}");
        }
    }
}
