//! The words of a formula.

use crate::error::{FormulaError, Problem};
use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Token<'a> {
    Name(&'a str),
    Number(f64),
    Symbol(&'static str),
    End,
}

impl Token<'_> {
    /// The word as an error cites it.
    pub(crate) fn cited(&self) -> String {
        match self {
            Self::Name(name) => format!("\"{name}\""),
            Self::Number(number) => format!("{number}"),
            Self::Symbol(symbol) => format!("\"{symbol}\""),
            Self::End => "the end".to_owned(),
        }
    }
}

/// All symbols, longer ones first.
const SYMBOLS: [&str; 12] = ["<=", ">=", "<", ">", "+", "-", "*", "(", ")", "[", "]", ","];

/// Splits `text` into words with their bytes; the last one is [`Token::End`].
pub(crate) fn tokens(text: &str) -> Result<Vec<(Token<'_>, Range<usize>)>, FormulaError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        }
        let rest = &text[at..];
        let (token, bytes) = if first.is_ascii_alphabetic() || first == '_' {
            let bytes = length(rest, |c| c.is_ascii_alphanumeric() || c == '_');
            (Token::Name(&rest[..bytes]), bytes)
        } else if first.is_ascii_digit() || first == '.' {
            let bytes = number(rest);
            let value: f64 =
                rest[..bytes].parse().map_err(|_| unexpected(text, at, bytes, "a number"))?;
            if !value.is_finite() {
                return Err(unexpected(text, at, bytes, "a finite number"));
            }
            (Token::Number(value), bytes)
        } else if let Some(symbol) = SYMBOLS.into_iter().find(|symbol| rest.starts_with(symbol)) {
            (Token::Symbol(symbol), symbol.len())
        } else {
            return Err(unexpected(
                text,
                at,
                first.len_utf8(),
                "a signal, a number or an operator",
            ));
        };
        tokens.push((token, at..at + bytes));
        at += bytes;
    }
    tokens.push((Token::End, text.len()..text.len()));
    Ok(tokens)
}

fn unexpected(text: &str, at: usize, bytes: usize, expected: &'static str) -> FormulaError {
    let found = format!("\"{}\"", &text[at..at + bytes]);
    FormulaError::at(text, at..at + bytes, Problem::Unexpected { found, expected })
}

/// Bytes at the beginning of `text` whose characters are `part`s.
fn length(text: &str, part: impl Fn(char) -> bool) -> usize {
    text.find(|c| !part(c)).unwrap_or(text.len())
}

/// Bytes of the number that begins `text`: digits, a point, an exponent.
fn number(text: &str) -> usize {
    let mantissa = length(text, |c| c.is_ascii_digit() || c == '.');
    let exponent = &text[mantissa..];
    if !exponent.starts_with(['e', 'E']) {
        return mantissa;
    }
    let sign = usize::from(exponent[1..].starts_with(['+', '-']));
    match length(&exponent[1 + sign..], |c| c.is_ascii_digit()) {
        0 => mantissa,
        digits => mantissa + 1 + sign + digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_have_their_places() {
        let words: Vec<_> = tokens("a_1 >=-1.5e-3").expect("reads").into_iter().collect();
        let expected = [
            (Token::Name("a_1"), 0..3),
            (Token::Symbol(">="), 4..6),
            (Token::Symbol("-"), 6..7),
            (Token::Number(0.0015), 7..13),
            (Token::End, 13..13),
        ];
        assert_eq!(words, expected);
    }

    #[test]
    fn other_characters_are_refused_at_their_column() {
        let error = tokens("gäp > 1").expect_err("not a name");
        assert_eq!(error.column, 2);
        assert!(tokens("1.2.3").is_err() && tokens("1e999").is_err());
    }
}
