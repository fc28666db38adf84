//! An error in a scenario, before its place in a text is looked up.

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
