//! Errors of scenario files, shown with the line, a caret and what was expected.

use std::fmt;
use std::ops::Range;

use super::problem::Problem;

/// Reason why a scenario was refused.
///
/// `Display` writes what a person needs to correct it:
///
/// ```text
/// error: corridor.toml:12:13: -50 is out of range
///    |
/// 12 | period_ms = -50
///    |             ^^^ expected a period from 1 to 10000 ms, a whole number
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScenarioError {
    message: String,
    expected: Option<String>,
    /// A file, or an option of the command line.
    source: String,
    /// The place in it; none: the whole.
    mark: Option<Box<Mark>>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Mark {
    /// Line and column, from 1. An option of the command line has one line and shows no number.
    line: Option<usize>,
    column: usize,
    text: String,
    /// Characters that are marked.
    length: usize,
}

impl ScenarioError {
    /// An error about a whole file or argument.
    pub(crate) fn whole(source: &str, message: impl Into<String>) -> Self {
        Self { message: message.into(), expected: None, source: source.to_owned(), mark: None }
    }

    /// An error of another format's reader, which names the place itself.
    pub fn whole_of(error: &impl fmt::Display) -> Self {
        let text = error.to_string();
        let (source, message) = text.split_once(": ").unwrap_or(("", &text));
        Self::whole(source, message)
    }

    /// An error at a byte range of a file's text.
    pub(crate) fn at(source: &str, text: &str, span: Range<usize>, message: &str) -> Self {
        let start = floor_char_boundary(text, span.start);
        let end = floor_char_boundary(text, span.end.max(start));
        // A byte order mark is not a character of the first line.
        let first = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
        let start = start.max(first);
        let end = end.max(start);
        let line_start = text[..start].rfind('\n').map_or(first, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let mark = Mark {
            line: Some(text[..line_start].matches('\n').count() + 1),
            column: text[line_start..start].chars().count() + 1,
            text: text[line_start..line_end].trim_end_matches('\r').to_owned(),
            length: text[start..end.clamp(start, line_end)].chars().count().max(1),
        };
        Self { mark: Some(Box::new(mark)), ..Self::whole(source, message) }
    }

    /// An error at a byte range of an option of the command line.
    pub(crate) fn in_option(option: &str, span: Range<usize>, message: &str) -> Self {
        let error = Self::at(option, option, span, message);
        let without_line = |mark: Box<Mark>| Box::new(Mark { line: None, ..*mark });
        Self { mark: error.mark.map(without_line), ..error }
    }

    /// Says what would have been right.
    pub(crate) fn expecting(mut self, expected: impl Into<String>) -> Self {
        let expected = expected.into();
        if !expected.is_empty() {
            self.expected = Some(expected);
        }
        self
    }

    /// The fault, without its place.
    pub fn message(&self) -> &str {
        &self.message
    }

    pub fn expected(&self) -> Option<&str> {
        self.expected.as_deref()
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (source, message) = (printable(&self.source), printable(&self.message));
        let expected = self.expected.as_ref().map(|expected| printable(expected));
        let Some(mark) = &self.mark else {
            write!(f, "error: {source}: {message}")?;
            return expected.map_or(Ok(()), |expected| write!(f, ", expected {expected}"));
        };
        match mark.line {
            Some(line) => writeln!(f, "error: {source}:{line}:{}: {message}", mark.column)?,
            None => writeln!(f, "error: {source}: {message}")?,
        }
        let number = mark.line.map_or_else(String::new, |line| line.to_string());
        let (text, column, length) = excerpt(&mark.text, mark.column, mark.length);
        let gutter = " ".repeat(number.len());
        let (indent, carets) = (" ".repeat(column - 1), "^".repeat(length));
        write!(f, "{gutter} |\n{number} | {text}\n{gutter} | {indent}{carets}")?;
        expected.map_or(Ok(()), |expected| write!(f, " expected {expected}"))
    }
}

impl std::error::Error for ScenarioError {}

/// Reason why something in a file is not taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A key is wrong; its place is looked up by its path.
    #[error(transparent)]
    Key(#[from] Problem),
    /// Something in another file is wrong, or in the command line.
    #[error(transparent)]
    File(#[from] ScenarioError),
}

/// Most characters of a source line shown before and after the fault.
const CONTEXT: usize = 100;

/// Cuts a long line around the mark and makes it printable, character for character.
fn excerpt(text: &str, column: usize, mark: usize) -> (String, usize, usize) {
    let skipped = column.saturating_sub(CONTEXT);
    let shown: String =
        text.chars().skip(skipped).take(2 * CONTEXT).map(|c| visible(c, ' ')).collect();
    (shown, column - skipped, mark.min(CONTEXT))
}

/// Most characters of a name or a message: lists of what was expected are shorter.
const LONGEST: usize = 1000;

/// Replaces control characters, so that a hostile file cannot write to the terminal, and what is longer than
/// helps.
fn printable(text: &str) -> String {
    let shown = |text: &str| text.chars().map(|c| visible(c, '\u{fffd}')).collect::<String>();
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => shown(&text[..end]) + "…",
        None => shown(text),
    }
}

fn visible(c: char, tab: char) -> char {
    match c {
        '\t' => tab,
        c if c.is_control() => '\u{fffd}',
        c => c,
    }
}

fn floor_char_boundary(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (0..=at).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_caret_stands_under_the_fault() {
        let text = "a = 1\nperiod_ms = -50 # ms\n";
        let error = ScenarioError::at("x.toml", text, 18..21, "-50 is out of range");
        let error = error.expecting("more");
        assert_eq!(
            error.to_string(),
            "error: x.toml:2:13: -50 is out of range\n  \
               |\n\
             2 | period_ms = -50 # ms\n  \
               |             ^^^ expected more"
        );
    }

    #[test]
    fn columns_count_characters_and_marks_stay_on_their_line() {
        let text = "name = \"grün\" x\nnext";
        let error = ScenarioError::at("x", text, 15..text.len(), "bad");
        assert!(error.to_string().starts_with("error: x:1:15: bad\n"), "{error}");
        assert!(error.to_string().ends_with("              ^"), "{error}");
    }

    #[test]
    fn a_byte_order_mark_is_no_column() {
        let error = ScenarioError::at("x", "\u{feff}a = 9", 7..8, "bad");
        assert!(error.to_string().starts_with("error: x:1:5: bad\n"), "{error}");
        assert!(error.to_string().ends_with("1 | a = 9\n  |     ^"), "{error}");
        let _ = ScenarioError::at("x", "\u{feff}", 0..1, "bad").to_string();
    }

    #[test]
    fn a_position_past_the_end_or_inside_a_character_is_survived() {
        for (start, end) in [(3, 4), (4, 2), (99, 120)] {
            let _ = ScenarioError::at("x", "grün", start..end, "bad").to_string();
        }
        let _ = ScenarioError::at("x", "", 0..0, "bad").to_string();
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let error = ScenarioError::at("a\u{1b}[2J", "x = \u{1b}]", 4..5, "bad\u{7} thing");
        assert!(!error.to_string().contains(['\u{1b}', '\u{7}']));
    }

    #[test]
    fn a_long_key_is_cut_in_the_message_too() {
        let message = format!("unknown key `{}`", "a".repeat(1_000_000));
        let shown = ScenarioError::at("x", "a = 1", 0..1, &message).to_string();
        assert!(shown.len() < 1_500 && shown.contains("aaa…"), "{} bytes", shown.len());
    }

    #[test]
    fn a_long_line_is_cut_around_the_mark() {
        let text = format!("{}!{}", "x".repeat(5000), "y".repeat(5000));
        let shown = ScenarioError::at("x", &text, 5000..5001, "bad").to_string();
        assert!(shown.len() < 500);
        let lines: Vec<&str> = shown.lines().collect();
        assert_eq!(lines[2].find('!'), lines[3].find('^'));
    }
}
