//! Arithmetic on the variables of a search: the right sides of `[set]`.
//!
//! ```text
//! sum     = product { ( "+" | "-" | "−" ) product }
//! product = factor { ( "*" | "×" | "/" | "÷" ) factor }
//! factor  = ( "-" | "−" ) factor | number | variable | "(" sum ")" | ( "min" | "max" ) "(" sum { "," sum } ")"
//! ```

use std::ops::Range;

use thiserror::Error;

/// Deepest nesting. It bounds the stack.
const MOST_DEPTH: usize = 64;

/// A formula over numbers, with its text.
#[derive(Clone, Debug, PartialEq)]
pub struct Arithmetic {
    text: String,
    root: Node,
}

#[derive(Clone, Debug, PartialEq)]
enum Node {
    Number(f64),
    Variable(usize),
    Negative(Box<Node>),
    Both(Operation, Box<Node>, Box<Node>),
    Least(Vec<Node>),
    Most(Vec<Node>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    Plus,
    Minus,
    Times,
    Over,
}

/// A text that is not a formula.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("column {column}: {problem}\n  | {text}\n  | {marks}", marks = self.marks())]
pub struct ArithmeticError {
    /// First column concerned, counted in characters from 1.
    pub column: usize,
    width: usize,
    pub problem: Problem,
    text: String,
}

/// The fault of a formula.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Problem {
    /// Another word was expected.
    #[error("{found}, expected {expected}")]
    Unexpected {
        /// The word that stands there.
        found: String,
        /// The words that may stand there.
        expected: &'static str,
    },
    /// A variable that does not exist.
    #[error("unknown variable `{name}`, expected one of {}{}", known.join(", "), hint(nearest))]
    Unknown {
        name: String,
        /// The variables that are numbers.
        known: Vec<String>,
        /// The most similar one.
        nearest: Option<String>,
    },
    /// More nesting than a reader could follow.
    #[error("nested more than {MOST_DEPTH} deep")]
    Depth,
}

fn hint(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!(", did you mean `{name}`?"))
}

impl ArithmeticError {
    fn marks(&self) -> String {
        " ".repeat(self.column - 1) + &"^".repeat(self.width)
    }
}

impl Arithmetic {
    /// Reads a formula over the variables `names`; a name that is `None` is not a number.
    ///
    /// # Errors
    /// [`ArithmeticError`] with the column.
    ///
    /// ```
    /// use search::problem::Arithmetic;
    ///
    /// let gap = Arithmetic::parse("max(5, thw*v0 + 2*slower)", &[Some("slower"), Some("thw"), Some("v0")]).unwrap();
    /// assert_eq!(gap.value(&[4.0, 1.0, 20.0]), 28.0);
    /// let error = Arithmetic::parse("thw*v1", &[Some("thw"), Some("v0")]).unwrap_err();
    /// assert!(error.to_string().starts_with("column 5: unknown variable `v1`, expected one of thw, v0"));
    /// ```
    pub fn parse(text: &str, names: &[Option<&str>]) -> Result<Self, ArithmeticError> {
        let mut reader = Reader { text, names, at: 0, depth: 0 };
        let root = reader.sum()?;
        reader.skip_spaces();
        match reader.rest() {
            "" => Ok(Self { text: text.to_owned(), root }),
            _ => Err(reader.unexpected("an operator or the end")),
        }
    }

    /// The text that was read.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The value with these variables, in the order of the names. It is not finite after a division by zero.
    #[must_use]
    pub fn value(&self, variables: &[f64]) -> f64 {
        self.root.value(variables)
    }

    /// True if the formula reads this variable.
    #[must_use]
    pub fn reads(&self, variable: usize) -> bool {
        self.root.reads(variable)
    }
}

impl Node {
    fn value(&self, of: &[f64]) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Variable(place) => of[*place],
            Self::Negative(inner) => -inner.value(of),
            Self::Both(operation, a, b) => {
                let (a, b) = (a.value(of), b.value(of));
                match operation {
                    Operation::Plus => a + b,
                    Operation::Minus => a - b,
                    Operation::Times => a * b,
                    Operation::Over => a / b,
                }
            }
            Self::Least(all) => all.iter().map(|one| one.value(of)).fold(f64::INFINITY, f64::min),
            Self::Most(all) => {
                all.iter().map(|one| one.value(of)).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }

    fn reads(&self, variable: usize) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Variable(place) => *place == variable,
            Self::Negative(inner) => inner.reads(variable),
            Self::Both(_, a, b) => a.reads(variable) || b.reads(variable),
            Self::Least(all) | Self::Most(all) => all.iter().any(|one| one.reads(variable)),
        }
    }
}

struct Reader<'a> {
    text: &'a str,
    names: &'a [Option<&'a str>],
    /// Bytes that were read.
    at: usize,
    depth: usize,
}

impl Reader<'_> {
    fn sum(&mut self) -> Result<Node, ArithmeticError> {
        if self.depth == MOST_DEPTH {
            return Err(self.error(self.at..self.at + 1, Problem::Depth));
        }
        self.depth += 1;
        let mut left = self.product()?;
        while let Some(operation) =
            self.take(&[("+", Operation::Plus), ("-", Operation::Minus), ("−", Operation::Minus)])
        {
            left = Node::Both(operation, Box::new(left), Box::new(self.product()?));
        }
        self.depth -= 1;
        Ok(left)
    }

    fn product(&mut self) -> Result<Node, ArithmeticError> {
        let mut left = self.factor()?;
        while let Some(operation) = self.take(&[
            ("*", Operation::Times),
            ("×", Operation::Times),
            ("/", Operation::Over),
            ("÷", Operation::Over),
        ]) {
            left = Node::Both(operation, Box::new(left), Box::new(self.factor()?));
        }
        Ok(left)
    }

    fn factor(&mut self) -> Result<Node, ArithmeticError> {
        let mut is_negative = false;
        while self.take(&[("-", ()), ("−", ())]).is_some() {
            is_negative = !is_negative;
        }
        let inner = self.plain()?;
        Ok(if is_negative { Node::Negative(Box::new(inner)) } else { inner })
    }

    fn plain(&mut self) -> Result<Node, ArithmeticError> {
        const EXPECTED: &str = "a number, a variable, \"(\", \"min(\" or \"max(\"";
        if self.take(&[("(", ())]).is_some() {
            let inner = self.sum()?;
            self.expect(")", "\")\"")?;
            return Ok(inner);
        }
        let begin = self.at;
        let word = self.word();
        let place = begin..begin + word.len();
        match word.chars().next() {
            Some(first) if first.is_ascii_digit() || first == '.' => match word.parse::<f64>() {
                Ok(number) if number.is_finite() => {
                    self.at = place.end;
                    Ok(Node::Number(number))
                }
                _ => Err(self.unexpected(EXPECTED)),
            },
            Some(_) => {
                self.at = place.end;
                match word.as_str() {
                    "min" if self.take(&[("(", ())]).is_some() => Ok(Node::Least(self.list()?)),
                    "max" if self.take(&[("(", ())]).is_some() => Ok(Node::Most(self.list()?)),
                    name => self.variable(name, place),
                }
            }
            None => Err(self.unexpected(EXPECTED)),
        }
    }

    fn list(&mut self) -> Result<Vec<Node>, ArithmeticError> {
        let mut all = vec![self.sum()?];
        while self.take(&[(",", ())]).is_some() {
            all.push(self.sum()?);
        }
        self.expect(")", "\",\" or \")\"")?;
        Ok(all)
    }

    fn variable(&self, name: &str, place: Range<usize>) -> Result<Node, ArithmeticError> {
        if let Some(found) = self.names.iter().position(|known| *known == Some(name)) {
            return Ok(Node::Variable(found));
        }
        let known: Vec<String> = self.names.iter().flatten().map(|&name| name.to_owned()).collect();
        let distance = |known: &&String| strsim::osa_distance(name, known);
        let nearest =
            known.iter().min_by_key(distance).filter(|known| distance(known) <= 2).cloned();
        Err(self.error(place, Problem::Unknown { name: name.to_owned(), known, nearest }))
    }

    /// The number or name that comes next; empty if there is none. An exponent may have a sign.
    fn word(&self) -> String {
        let rest = self.rest();
        let is_number = rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        let mut word = String::new();
        for c in rest.chars() {
            let is_sign = is_number && matches!(c, '+' | '-') && word.ends_with(['e', 'E']);
            if !is_sign && !c.is_ascii_alphanumeric() && !matches!(c, '_' | '.') {
                break;
            }
            word.push(c);
        }
        word
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn skip_spaces(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    fn take<T: Copy>(&mut self, symbols: &[(&str, T)]) -> Option<T> {
        self.skip_spaces();
        let (symbol, meant) = symbols.iter().find(|(symbol, _)| self.rest().starts_with(symbol))?;
        self.at += symbol.len();
        self.skip_spaces();
        Some(*meant)
    }

    fn expect(&mut self, symbol: &str, cited: &'static str) -> Result<(), ArithmeticError> {
        self.take(&[(symbol, ())]).ok_or_else(|| self.unexpected(cited))
    }

    fn unexpected(&self, expected: &'static str) -> ArithmeticError {
        let word = self.word();
        let found = match (word.as_str(), self.rest().chars().next()) {
            ("", None) => "the end".to_owned(),
            ("", Some(symbol)) => format!("\"{symbol}\""),
            (word, _) => format!("\"{word}\""),
        };
        let width = word.len().max(1);
        self.error(self.at..self.at + width, Problem::Unexpected { found, expected })
    }

    fn error(&self, place: Range<usize>, problem: Problem) -> ArithmeticError {
        let column = self.text[..place.start].chars().count() + 1;
        ArithmeticError { column, width: place.len(), problem, text: self.text.to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [Option<&str>; 3] = [Some("a"), Some("actors.0.gap_m"), None];

    fn value(text: &str) -> f64 {
        Arithmetic::parse(text, &NAMES).expect(text).value(&[2.0, 30.0, f64::NAN])
    }

    #[test]
    fn operators_bind_as_in_school() {
        for (text, expected) in [
            ("1 + 2*3", 7.0),
            ("(1 + 2)*3", 9.0),
            ("10 - 4 - 3", 3.0),
            ("8 / 2 / 2", 2.0),
            ("8 ÷ 2 × 3 − 1", 11.0),
            ("-a*a", -4.0),
            ("2 - -3", 5.0),
            ("actors.0.gap_m/a + 1.5e1", 30.0),
            ("2e-1*10", 2.0),
            ("min(a, 5, max(1, 0))", 1.0),
        ] {
            assert_eq!(value(text), expected, "{text}");
        }
        assert!(!value("1/(a - 2)").is_finite());
    }

    #[test]
    fn errors_have_their_column_and_mark() {
        for (text, column, what) in [
            ("", 1, "the end, expected a number"),
            ("a +", 4, "the end, expected a number"),
            ("a b", 3, "\"b\", expected an operator or the end"),
            ("(a", 3, "the end, expected \")\""),
            ("min(a; 3)", 6, "\";\", expected \",\" or \")\""),
            (
                "a * bb",
                5,
                "unknown variable `bb`, expected one of a, actors.0.gap_m, did you mean `a`?",
            ),
            ("1.2.3", 1, "\"1.2.3\", expected a number"),
            ("a ÷ ü", 5, "\"ü\", expected a number"),
        ] {
            let error = Arithmetic::parse(text, &NAMES).expect_err(text);
            assert_eq!(error.column, column, "{error}");
            let said = error.to_string();
            assert!(said.contains(what), "{said}");
            let mark = said.lines().last().expect("a mark");
            assert_eq!(mark.chars().position(|c| c == '^'), Some(3 + column), "{said}");
        }
        let deep = "(".repeat(100) + "1" + &")".repeat(100);
        assert!(Arithmetic::parse(&deep, &NAMES).is_err_and(|e| e.problem == Problem::Depth));
    }
}
