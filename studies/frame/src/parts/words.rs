//! The words of a command line that define a study.

use std::ffi::OsString;

/// Options for place and manner of a study, with a value.
const WITH_VALUE: [&str; 7] =
    ["--shard", "--resume", "--out", "--jobs", "--junit", "--markdown", "--keep"];
/// The same without a value.
const ALONE: [&str; 3] = ["--json", "--force", "--processes"];

/// The words without the options for place and manner.
pub fn of_study(arguments: impl Iterator<Item = OsString>) -> Vec<String> {
    let mut words = Vec::new();
    let mut arguments = arguments.map(|word| word.to_string_lossy().into_owned());
    while let Some(word) = arguments.next() {
        let name = word.split_once('=').map_or(word.as_str(), |(name, _)| name);
        if WITH_VALUE.contains(&name) {
            // Its value is the next word unless it is in this one.
            if name == word {
                arguments.next();
            }
        } else if !ALONE.contains(&word.as_str()) {
            words.push(word);
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_and_way_of_a_run_are_not_part_of_a_study() {
        let line = "sweep cacc-a --param a=1,2 --shard 1/3 --out x --json --jobs=2 --junit j.xml --seeds 1..3";
        let words = of_study(line.split(' ').map(OsString::from));
        assert_eq!(words.join(" "), "sweep cacc-a --param a=1,2 --seeds 1..3");
    }
}
