//! An error in a scenario, before its place in a text is looked up.

use std::ops::Range;

/// An error in a readable value: it contradicts another key, or the law that it is for refuses it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {message}, expected {expected}")]
pub struct Problem {
    /// Dotted path of the offending key, array elements by their index: `actors.0.gap_m`.
    pub path: String,
    /// Fault.
    pub message: String,
    /// Expected value.
    pub expected: String,
    /// The key that `path` contradicts; shown instead when only that one was written, or was set on
    /// the command line.
    pub against: Option<String>,
    /// Position in the document, where it is known more closely than by `path`.
    place: Option<Range<usize>>,
}

impl Problem {
    /// A problem at `path`.
    pub fn new(
        path: impl Into<String>,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let (path, message, expected) = (path.into(), message.into(), expected.into());
        Self { path, message, expected, against: None, place: None }
    }

    /// The same at a position of the document.
    #[must_use]
    pub(super) fn at(mut self, place: Range<usize>) -> Self {
        self.place = Some(place);
        self
    }

    /// Position in the document, where it is known more closely than by the path.
    pub(super) fn place(&self) -> Option<&Range<usize>> {
        self.place.as_ref()
    }

    /// Names the key that this one contradicts.
    #[must_use]
    pub fn against(mut self, path: &str) -> Self {
        self.against = Some(path.to_owned());
        self
    }
}
