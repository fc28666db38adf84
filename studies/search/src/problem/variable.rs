//! Variables: what a search may choose, and the unit interval that stands for it.

use frame::param::{ListError, values};
use serde::{Deserialize, Serialize};

/// A quantity that a search chooses.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name: a word of `[vary]`, or the dotted path of a key.
    pub name: String,
    pub domain: Domain,
    /// The harmless value, from which a minimal case departs as little as it can.
    pub nominal: Value,
}

/// The values of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Domain {
    /// The numbers between two ends.
    Range {
        from: f64,
        to: f64,
        /// Its logarithm is spread evenly.
        is_log: bool,
    },
    /// Numbers in ascending order.
    Numbers(Vec<f64>),
    /// Words, none of which is nearer to another.
    Words(Vec<String>),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    Number(f64),
    Word(String),
}

impl Domain {
    /// Reads `A..B`, `A..B:log`, or the values of a list as [`frame::param::values`] does.
    pub fn parse(text: &str) -> Result<Self, ListError> {
        let text = text.trim();
        let (ends, is_log) = text.strip_suffix(":log").map_or((text, false), |ends| (ends, true));
        if let Some((from, to)) = ends.split_once("..")
            && from.trim().parse::<f64>().is_ok()
            && !to.contains(['/', ':'])
        {
            // The ends are the range's only values.
            let ends = values(&format!("{text}:2"), None)?;
            let end = |place: usize| ends[place].parse().expect("the end of a range");
            return Ok(Self::Range { from: end(0), to: end(1), is_log });
        }
        let all = values(text, None)?;
        if all.len() < 2 {
            return Err(ListError("one value leaves nothing to choose".to_owned()));
        }
        let number = |value: &String| value.parse().ok().filter(|number: &f64| number.is_finite());
        Ok(match all.iter().map(number).collect::<Option<Vec<f64>>>() {
            Some(mut numbers) => {
                numbers.sort_by(f64::total_cmp);
                Self::Numbers(numbers)
            }
            None => Self::Words(all),
        })
    }

    /// True if its values are words.
    pub fn is_of_words(&self) -> bool {
        matches!(self, Self::Words(_))
    }

    /// Number of values of a list.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Range { .. } => None,
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Words(words) => Some(words.len()),
        }
    }

    /// The value at a place of the unit interval. Numbers have seven digits, so that a file is readable.
    ///
    /// ```
    /// use search::problem::{Domain, Value};
    ///
    /// let delay = Domain::parse("1..100:log").unwrap();
    /// assert_eq!(delay.at(0.5), Value::Number(10.0));
    /// let law = Domain::parse("acc-mpc,six-mode").unwrap();
    /// assert_eq!(law.at(0.7), Value::Word("six-mode".into()));
    /// ```
    pub fn at(&self, place: f64) -> Value {
        let place = place.clamp(0.0, 1.0);
        let index = |count: usize| ((place * count as f64) as usize).min(count - 1);
        match self {
            Self::Range { from, to, .. } => {
                Value::Number(rounded(self.drawn_at(place), 7).clamp(*from, *to))
            }
            Self::Numbers(numbers) => Value::Number(numbers[index(numbers.len())]),
            Self::Words(words) => Value::Word(words[index(words.len())].clone()),
        }
    }

    /// The place of a point on an axis of the values. The point may lie a little outside of the unit interval.
    pub fn drawn_at(&self, point: f64) -> f64 {
        match self {
            Self::Range { from, to, is_log: false } => from + point * (to - from),
            Self::Range { from, to, is_log: true } => {
                libm::exp(libm::log(*from) + point * (libm::log(*to) - libm::log(*from)))
            }
            Self::Numbers(numbers) => point * numbers.len() as f64,
            Self::Words(words) => point * words.len() as f64,
        }
    }

    /// The place of a value; a value of a list is in the middle of its share. A value outside stands for the nearest.
    pub fn place(&self, value: &Value) -> f64 {
        let middle = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
        match (self, value) {
            (Self::Range { from, to, is_log: false }, Value::Number(number)) => {
                ((number - from) / (to - from)).clamp(0.0, 1.0)
            }
            (Self::Range { from, to, is_log: true }, Value::Number(number)) => {
                let log = |number: f64| libm::log(number.clamp(*from, *to));
                (log(*number) - log(*from)) / (log(*to) - log(*from))
            }
            (Self::Numbers(numbers), Value::Number(number)) => {
                let distance = |one: &f64| (one - number).abs();
                let nearest = numbers.iter().enumerate();
                let nearest = nearest.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
                middle(nearest.map_or(0, |(index, _)| index), numbers.len())
            }
            (Self::Words(words), Value::Word(word)) => {
                let index = words.iter().position(|one| one == word).unwrap_or(0);
                middle(index, words.len())
            }
            _ => 0.5,
        }
    }

    pub fn nearest(&self, value: &Value) -> Value {
        match (self, value) {
            (Self::Range { from, to, .. }, Value::Number(number)) => {
                Value::Number(number.clamp(*from, *to))
            }
            _ => self.at(self.place(value)),
        }
    }

    /// The middle of a range, the first value of a list.
    pub fn middle(&self) -> Value {
        self.at(if self.count().is_some() { 0.0 } else { 0.5 })
    }
}

pub fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits - 1).parse().unwrap_or(number)
}

impl Value {
    /// The value of a TOML number, word or truth value.
    pub(super) fn of_toml(value: &toml::Value) -> Option<Self> {
        match value {
            toml::Value::Integer(number) => Some(Self::Number(*number as f64)),
            toml::Value::Float(number) => Some(Self::Number(*number)),
            toml::Value::String(word) => Some(Self::Word(word.clone())),
            toml::Value::Boolean(flag) => Some(Self::Word(flag.to_string())),
            _ => None,
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Word(_) => None,
        }
    }
}

impl std::fmt::Display for Domain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Range { from, to, is_log } => {
                write!(f, "{from}..{to}{}", if *is_log { ":log" } else { "" })
            }
            Self::Numbers(numbers) => {
                let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
                f.write_str(&words.join(","))
            }
            Self::Words(words) => f.write_str(&words.join(",")),
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{}", rounded(*number, 7)),
            Self::Word(word) => f.write_str(word),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_values_lead_back_to_each_other() {
        for text in ["12..36", "0.8..2:log", "1,2,5", "a,b,c"] {
            let domain = Domain::parse(text).expect(text);
            for place in [0.0, 0.2, 0.5, 0.99, 1.0] {
                let value = domain.at(place);
                assert_eq!(domain.at(domain.place(&value)), value, "{text} at {place}");
                assert_eq!(domain.nearest(&value), value);
            }
        }
        let range = Domain::parse("-1..3").expect("a range");
        assert_eq!(range.at(0.5), Value::Number(1.0));
        assert_eq!(range.nearest(&Value::Number(9.0)), Value::Number(3.0));
    }

    #[test]
    fn a_list_of_numbers_is_ordered() {
        let steps = Domain::parse("10..30/10").expect("a range with steps");
        assert_eq!(steps, Domain::Numbers(vec![10.0, 20.0, 30.0]));
        let list = Domain::parse("5, 1, 2").expect("a list");
        assert_eq!(list, Domain::Numbers(vec![1.0, 2.0, 5.0]));
        assert_eq!((list.at(0.0), list.at(0.9)), (Value::Number(1.0), Value::Number(5.0)));
    }

    #[test]
    fn bad_domains_are_refused() {
        for (text, what) in [
            ("5..5", "begins at 5, after its end 5"),
            ("9..2", "begins at 9, after its end 2"),
            ("0..2:log", "begins above 0, not at 0"),
            ("0..2:lin", "`lin` is not a number of values"),
            ("0..x", "`x` is not a number"),
            ("0..inf", "`inf` is not a number"),
            ("a", "leaves nothing to choose"),
            ("a,,b", "a value is missing"),
            ("1,2,1", "1 is there twice"),
        ] {
            let said = Domain::parse(text).expect_err(text);
            assert!(said.0.contains(what), "{text}: {said}");
        }
    }
}
