//! `--seeds`: the seeds with which a study drives each of its scenarios.
//!
//! ```
//! let seeds = |text| -> Vec<u64> {
//!     frame::seeds::read(text).unwrap().into_iter().map(|seed| seed.value()).collect()
//! };
//! assert_eq!(seeds("3"), [1, 2, 3], "a number of seeds");
//! assert_eq!(seeds("5..7"), [5, 6, 7]);
//! assert_eq!(seeds("4,2"), [4, 2]);
//! assert!(frame::seeds::read("0").is_err());
//! ```

use group::Failure;
use scenario::quantity::Seed;

use crate::param::{self, ValuesError};

/// Seeds that cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SeedsError {
    /// The text is not a list.
    #[error("--seeds {text}: {reason}, expected a number of seeds, A..B or a,b,c")]
    List {
        /// The argument.
        text: String,
        /// The mistake in it.
        #[source]
        reason: ValuesError,
    },
    /// One of them is not a seed.
    #[error("--seeds {text}: `{value}` is not a seed, expected whole numbers of 0 or more")]
    Seed {
        /// The argument.
        text: String,
        /// The value.
        value: String,
    },
    /// There is none.
    #[error("--seeds {text}: no seeds, expected a number of 1 or more, A..B or a,b,c")]
    None {
        /// The argument.
        text: String,
    },
}

impl Failure for SeedsError {}

/// Reads the argument: a number N of seeds means 1 to N.
///
/// # Errors
/// [`SeedsError`].
pub fn read(text: &str) -> Result<Vec<Seed>, SeedsError> {
    let list = match text.trim().parse::<u64>() {
        Ok(0) => return Err(SeedsError::None { text: text.to_owned() }),
        Ok(count) => &format!("1..{count}"),
        Err(_) => text,
    };
    let values = param::values(list, Some("1"));
    let values = values.map_err(|reason| SeedsError::List { text: text.to_owned(), reason })?;
    let seed = |value: String| {
        let seed = value.parse::<i64>().ok().and_then(|seed| Seed::try_from(seed).ok());
        seed.ok_or_else(|| SeedsError::Seed { text: text.to_owned(), value })
    };
    values.into_iter().map(seed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_seeds_are_refused_with_what_was_expected() {
        for (text, words) in [
            ("0", "no seeds"),
            ("1..x", "`x` is not a number"),
            ("1,,2", "a value is missing"),
            ("3..1", "after its end"),
            ("1,1", "1 is there twice"),
            ("1.5,2", "`1.5` is not a seed"),
            ("-1,2", "`-1` is not a seed"),
            ("1000000", "1000000 values, more than 10000"),
        ] {
            let said = read(text).expect_err(text).to_string();
            assert!(said.contains(words) && said.contains("expected"), "{said}");
        }
    }
}
