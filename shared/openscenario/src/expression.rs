//! Expressions in attributes: `${...}`.
//!
//! Operators by precedence, highest first: unary `-` and `not`, functions; `*`, `/`, `%`; `+`, `-`;
//! `and`; `or`. Functions: round, floor, ceil, sqrt, pow, sign, abs, max, min, sin, cos, tan, asin, acos,
//! atan. Names of parameters begin with `$`.

use serde::{Deserialize, Serialize};

const MAX_DEPTH: usize = 100;

/// A value of a parameter, variable or attribute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Value {
    Boolean(bool),
    Number(f64),
    Text(String),
}

impl Value {
    /// Reads a literal: a number, `true` or `false`, or else text.
    pub fn literal(text: &str) -> Self {
        match text.trim() {
            "true" => Self::Boolean(true),
            "false" => Self::Boolean(false),
            trimmed => match number(trimmed) {
                Some(value) => Self::Number(value),
                None => Self::Text(text.to_owned()),
            },
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Text(text) => number(text.trim()),
            Self::Boolean(_) => None,
        }
    }

    /// The text as an attribute holds it.
    pub fn text(&self) -> String {
        match self {
            Self::Boolean(value) => value.to_string(),
            Self::Number(value) => value.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

/// A finite number, or an infinite one spelt `INF`.
fn number(text: &str) -> Option<f64> {
    match text {
        "INF" | "inf" => Some(f64::INFINITY),
        "-INF" | "-inf" => Some(f64::NEG_INFINITY),
        _ => text.parse::<f64>().ok().filter(|value| value.is_finite()),
    }
}

/// Reason why an expression has no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault<E> {
    /// A fault of the expression: its reason, and what was expected.
    Expression(String, String),
    Parameter(E),
}

/// Operators by level, the closest last.
static LEVELS: [&[&str]; 4] = [&["or"], &["and"], &["+", "-"], &["*", "/", "%"]];

type OfOne = (&'static str, fn(f64) -> f64);
type OfTwo = (&'static str, fn(f64, f64) -> f64);

static OF_ONE: [OfOne; 12] = [
    ("round", libm::round),
    ("floor", libm::floor),
    ("ceil", libm::ceil),
    ("sqrt", libm::sqrt),
    ("sign", |value| if value == 0.0 { 0.0 } else { value.signum() }),
    ("abs", f64::abs),
    ("sin", libm::sin),
    ("cos", libm::cos),
    ("tan", libm::tan),
    ("asin", libm::asin),
    ("acos", libm::acos),
    ("atan", libm::atan),
];
static OF_TWO: [OfTwo; 3] = [("pow", libm::pow), ("max", f64::max), ("min", f64::min)];

type Result<E> = std::result::Result<Value, Fault<E>>;

/// Evaluates the text between `${` and `}`. `parameter` gives the value of a name.
///
/// # Errors
/// When the text is not an expression, a type does not fit, or a parameter has no value.
pub fn evaluate<E>(
    text: &str,
    parameter: &mut dyn FnMut(&str) -> std::result::Result<Value, E>,
) -> Result<E> {
    let mut parser = Parser { text, at: 0, depth: 0, parameter };
    let value = parser.binary(0)?;
    parser.space();
    if parser.at < text.len() {
        return wrong(format!("`{}` is left over", &text[parser.at..]), "an operator");
    }
    match value {
        Value::Number(number) if !number.is_finite() => {
            wrong(format!("`{text}` is not a finite number"), "a finite number")
        }
        value => Ok(value),
    }
}

fn wrong<E>(what: impl Into<String>, expected: &str) -> Result<E> {
    Err(Fault::Expression(what.into(), expected.to_owned()))
}

struct Parser<'a, E> {
    text: &'a str,
    at: usize,
    depth: usize,
    parameter: &'a mut dyn FnMut(&str) -> std::result::Result<Value, E>,
}

impl<'a, E> Parser<'a, E> {
    /// Operators of a level and those that bind more closely.
    fn binary(&mut self, level: usize) -> Result<E> {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        while let Some(operator) = operators.iter().find(|operator| self.take(operator)) {
            let right = self.binary(level + 1)?;
            left = self.apply(operator, &left, &right)?;
        }
        Ok(left)
    }

    fn apply(&self, operator: &str, left: &Value, right: &Value) -> Result<E> {
        if let "or" | "and" = operator {
            let (a, b) = (self.boolean(left)?, self.boolean(right)?);
            return Ok(Value::Boolean(if operator == "or" { a | b } else { a & b }));
        }
        let (a, b) = (self.number(left)?, self.number(right)?);
        Ok(Value::Number(match operator {
            "+" => a + b,
            "-" => a - b,
            "*" => a * b,
            _ if b == 0.0 => return wrong("a division by 0", "a divisor other than 0"),
            "/" => a / b,
            _ => a % b,
        }))
    }

    fn unary(&mut self) -> Result<E> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return wrong("it is nested too deeply", "at most 100 levels");
        }
        let value = if self.take("-") {
            let value = self.unary()?;
            Ok(Value::Number(-self.number(&value)?))
        } else if self.take("not") {
            let value = self.unary()?;
            Ok(Value::Boolean(!self.boolean(&value)?))
        } else {
            self.primary()
        };
        self.depth -= 1;
        value
    }

    fn primary(&mut self) -> Result<E> {
        self.space();
        let rest = &self.text[self.at..];
        match rest.chars().next() {
            Some('(') => {
                self.at += 1;
                let value = self.binary(0)?;
                self.close()?;
                Ok(value)
            }
            Some('$') => {
                let name = self.name(1);
                (self.parameter)(name).map_err(Fault::Parameter)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.literal(),
            Some(c) if c.is_ascii_alphabetic() => {
                let name = self.name(0);
                match name {
                    "true" => Ok(Value::Boolean(true)),
                    "false" => Ok(Value::Boolean(false)),
                    _ => self.call(name),
                }
            }
            _ => wrong(
                format!("`{}` ends too early", self.text),
                "a number, a `$parameter`, a function or a parenthesis",
            ),
        }
    }

    fn literal(&mut self) -> Result<E> {
        let rest = &self.text[self.at..];
        let mut before = ' ';
        let ends = |c: char| {
            let is_sign = matches!(c, '+' | '-') && matches!(before, 'e' | 'E');
            before = c;
            !(c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E') || is_sign)
        };
        let text = &rest[..rest.find(ends).unwrap_or(rest.len())];
        self.at += text.len();
        match number(text) {
            Some(value) => Ok(Value::Number(value)),
            None => wrong(format!("`{text}` is not a number"), "a number"),
        }
    }

    fn call(&mut self, name: &str) -> Result<E> {
        let of_two = OF_TWO.iter().find(|(known, _)| *known == name);
        let of_one = OF_ONE.iter().find(|(known, _)| *known == name);
        if of_one.is_none() && of_two.is_none() {
            return wrong(
                format!("`{name}` is not a function (a parameter begins with `$`)"),
                "round, floor, ceil, sqrt, pow, sign, abs, max, min, sin, cos, tan, asin, acos or atan",
            );
        }
        if !self.take("(") {
            return wrong(format!("`{name}` has no arguments"), "`(`");
        }
        let first = self.argument()?;
        let value = match (of_one, of_two) {
            (_, Some((_, function))) if self.take(",") => function(first, self.argument()?),
            (Some((_, function)), _) => function(first),
            _ => return wrong(format!("`{name}` has one argument"), "two"),
        };
        self.close()?;
        Ok(Value::Number(value))
    }

    fn argument(&mut self) -> std::result::Result<f64, Fault<E>> {
        let value = self.binary(0)?;
        self.number(&value)
    }

    fn close(&mut self) -> std::result::Result<(), Fault<E>> {
        if self.take(")") {
            return Ok(());
        }
        let reason = format!("a parenthesis of `{}` is not closed", self.text);
        Err(Fault::Expression(reason, "`)`".to_owned()))
    }

    fn number(&self, value: &Value) -> std::result::Result<f64, Fault<E>> {
        value.number().ok_or_else(|| {
            Fault::Expression(format!("`{}` is not a number", value.text()), "a number".to_owned())
        })
    }

    fn boolean(&self, value: &Value) -> std::result::Result<bool, Fault<E>> {
        match value {
            Value::Boolean(value) => Ok(*value),
            other => Err(Fault::Expression(
                format!("`{}` is not a truth value", other.text()),
                "true or false".to_owned(),
            )),
        }
    }

    fn space(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    /// Takes a sign or a word, if it is next.
    fn take(&mut self, token: &str) -> bool {
        self.space();
        let ends = |c: char| !(c.is_alphanumeric() || c == '_');
        let is_word = !token.starts_with(ends);
        let after = self.text[self.at..].strip_prefix(token);
        let found = after.is_some_and(|it| !is_word || it.chars().next().is_none_or(ends));
        self.at += if found { token.len() } else { 0 };
        found
    }

    /// Takes a name, `skip` bytes from here.
    fn name(&mut self, skip: usize) -> &'a str {
        let start = self.at + skip;
        let text: &'a str = self.text;
        let length = text[start..]
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(text.len() - start);
        self.at = start + length;
        &text[start..self.at]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<String> {
        evaluate(text, &mut |name| match name {
            "v" => Ok(Value::Number(60.0)),
            "rate" => Ok(Value::Number(-5.0)),
            "model" => Ok(Value::Text("car".to_owned())),
            other => Err(other.to_owned()),
        })
    }

    #[test]
    fn arithmetic_follows_the_usual_precedence() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("$v / 3.6", 60.0 / 3.6),
            ("-$v", -60.0),
            ("2 * -$rate", 10.0),
            ("2 - -3", 5.0),
            ("7 % 4 - 1", 2.0),
            ("sqrt( $rate * $rate )", 5.0),
            ("pow(2, 3) + max(1, min(5, 4))", 12.0),
            ("2.1E-1 * 10", 2.1),
            ("round(2.5) + floor(-0.5) + ceil(0.5) + sign(-3) + abs(-1)", 3.0),
        ] {
            assert_eq!(value(text), Ok(Value::Number(expected)), "{text}");
        }
    }

    #[test]
    fn truth_values_combine() {
        assert_eq!(value("true and not false"), Ok(Value::Boolean(true)));
        assert_eq!(value("false or (true and false)"), Ok(Value::Boolean(false)));
    }

    #[test]
    fn what_has_no_value_says_why() {
        assert_eq!(value("$w + 1"), Err(Fault::Parameter("w".to_owned())));
        let parentheses = "(".repeat(200);
        for text in [
            "",
            "1 +",
            "1 2",
            "(1",
            "foo(1)",
            "pow(1)",
            "1 / 0",
            "$model * 2",
            "not 1",
            "1e",
            &parentheses,
            "sqrt(-1)",
            "é",
        ] {
            assert!(matches!(value(text), Err(Fault::Expression(..))), "{text}: {:?}", value(text));
        }
    }
}
