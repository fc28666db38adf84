//! An error in a scenario, before its place in a text is looked up, and the words that it says are accepted.

/// A value does not fit its key, contradicts another key, or is refused by the law that it is for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {message}, expected {expected}")]
pub struct Problem {
    /// Dotted path of the offending key, array elements by their index: `actors.0.gap_m`.
    pub path: String,
    pub message: String,
    /// Expected value; empty if the message says it.
    pub expected: String,
    /// The key that `path` contradicts; shown instead when only that one was written, or was set on
    /// the command line.
    pub against: Option<String>,
    /// True if the key itself is wrong, not its value.
    pub(crate) is_of_key: bool,
}

impl Problem {
    pub fn new(
        path: impl Into<String>,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let (path, message, expected) = (path.into(), message.into(), expected.into());
        Self { path, message, expected, against: None, is_of_key: false }
    }

    /// A file of a scenario that is not a file itself.
    pub(crate) fn unread(path: &str, expected: &str) -> Self {
        let message = "the file has not been read, for this scenario is not a file itself";
        Self::new(path, message, expected)
    }

    /// A way that is not a road.
    pub(crate) fn of_axis(path: &str, error: &road::AxisError) -> Self {
        Self::new(path, error.to_string(), error.expected())
    }

    /// Names the key that this one contradicts.
    pub fn against(self, path: &str) -> Self {
        Self { against: Some(path.to_owned()), ..self }
    }

    /// The same about the key itself.
    pub(crate) fn of_key(self) -> Self {
        Self { is_of_key: true, ..self }
    }
}

/// Refuses a value where a condition holds: `refuse!(if condition, "path": "message", "expected", against "other")`.
/// The texts are format strings.
macro_rules! refuse {
    (if let $found:pat = $in:expr, $($problem:tt)+) => {
        if let $found = $in {
            refuse!($($problem)+);
        }
    };
    (if $wrong:expr, $($problem:tt)+) => {
        if $wrong {
            refuse!($($problem)+);
        }
    };
    ($path:literal: $message:literal, $expected:literal $(, against $other:literal)?) => {
        return Err($crate::Problem::new(format!($path), format!($message), format!($expected))
            $(.against(&format!($other)))?)
    };
}

pub(crate) use refuse;

/// The accepted words as an author writes them, with the nearest one where `refused` may be a slip of it.
pub fn accepted<'a>(refused: &str, words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<&str> = words.into_iter().collect();
    let quoted: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
    let listed = match quoted.as_slice() {
        [] => "no key here".to_owned(),
        [a, b] => format!("{a} or {b}"),
        all => all.join(", "),
    };
    match nearest(refused, words) {
        Some(near) => format!("{listed} (did you mean `{near}`?)"),
        None => listed,
    }
}

/// The word nearest to the refused one, when it is near enough to be a slip.
pub(crate) fn nearest<'a>(
    refused: &str,
    words: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let limit = 1 + refused.chars().count() / 4;
    let distances = words.into_iter().map(|word| (edit_distance(refused, word), word));
    let (distance, word) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= limit).then_some(word)
}

/// Levenshtein's distance, on the first 64 characters of each word.
fn edit_distance(a: &str, b: &str) -> usize {
    let cut = |word: &str| word.chars().take(64).collect::<String>();
    strsim::levenshtein(&cut(a), &cut(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_pen_gets_a_suggestion() {
        let words = ["period_ms", "range_m", "core"];
        let listed = "`period_ms`, `range_m`, `core`";
        assert_eq!(accepted("perod_ms", words), format!("{listed} (did you mean `period_ms`?)"));
        assert_eq!(accepted("colour", words), listed);
        assert_eq!(accepted("a", ["pause", "stop"]), "`pause` or `stop`");
        assert_eq!(accepted("a", []), "no key here");
    }

    #[test]
    fn edit_distances() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("gap_m", "gap_m"), 0);
    }
}
