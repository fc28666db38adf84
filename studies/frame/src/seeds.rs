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

use std::fmt::Display;

use scenario::quantity::Seed;
use supervise::UsageError;

use crate::param;

/// Reads the argument: a number N of seeds means 1 to N.
pub fn read(text: &str) -> Result<Vec<Seed>, UsageError> {
    let refuse = |why: &dyn Display| {
        UsageError::option("--seeds", text, why, "a number of seeds of 1 or more, A..B or a,b,c")
    };
    let list = match text.trim().parse::<u64>() {
        Ok(0) => return Err(refuse(&"no seeds")),
        Ok(count) => &format!("1..{count}"),
        Err(_) => text,
    };
    let values = param::values(list, Some("1")).map_err(|why| refuse(&why))?;
    let seed = |value: String| {
        let seed = value.parse::<i64>().ok().and_then(|seed| Seed::try_from(seed).ok());
        seed.ok_or_else(|| refuse(&format_args!("`{value}` is not a seed")))
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
