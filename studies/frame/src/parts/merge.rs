//! Parts joined, and the parts that are missing.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use supervise::{Error, UsageError};

use super::part::resume_command;
use super::{FILE, Line, PartFile, Records, Shard, holds, journal};
use runtime::command_line;

/// Parts joined.
pub struct Merged<T> {
    first: PartFile,
    /// Records of the finished runs.
    pub records: Records<T>,
    /// Parts that are missing or unfinished.
    pub incomplete: Vec<Incomplete>,
}

/// A part that is missing or not finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incomplete {
    pub shard: Shard,
    /// Number of its missing runs.
    pub runs: usize,
    /// Directory of the part; `None` if it was not begun.
    pub directory: Option<PathBuf>,
    pub command: String,
}

impl<T: DeserializeOwned> Merged<T> {
    /// Reads the parts of one study, whose result goes to `out`.
    pub fn read(directories: &[PathBuf], out: Option<&Path>) -> Result<Self, Error> {
        refuse_into_part(directories, out)?;
        let mut parts: Vec<(PartFile, &Path)> = Vec::new();
        let mut records: Option<Records<T>> = None;
        for directory in directories {
            let part = PartFile::read(directory)?;
            let refuse = |why: &str, expected: &str| {
                let study = &part.study;
                UsageError::at(directory.display(), why.replace("{}", study), expected)
            };
            if parts.first().is_some_and(|(first, _)| !part.is_of_the_study_of(first)) {
                let why = "it is part of another {} than the directories before it";
                return Err(refuse(why, "parts of one study").into());
            }
            if let Some((_, before)) = parts.iter().find(|(known, _)| known.shard == part.shard) {
                let why = format!("it holds the same part as {}", before.display());
                return Err(refuse(&why, "each part once").into());
            }
            let records = records.get_or_insert_with(|| Records::new(part.runs));
            let journal = directory.join(journal::FILE);
            records.begin(&journal);
            journal::read(&journal, &mut |place, line: Line<T>| {
                records.add(line.run, place, holds(part.shard, line.run))
            })?;
            parts.push((part, directory));
        }
        let records = records.expect("clap asks for at least one directory");
        let incomplete = incomplete(&parts, &|run| records.has(run));
        let (first, _) = parts.swap_remove(0);
        Ok(Self { first, records, incomplete })
    }

    /// Checks that the arguments still mean the same as when the parts were done.
    pub fn check(&self, now: &PartFile) -> Result<(), UsageError> {
        let why = "the scenario is another one now than when the parts were done";
        let same = *now == self.first;
        same.then_some(()).ok_or_else(|| UsageError::at(FILE, why, "the same files"))
    }
}

/// Refuses a result that would replace one of `parts`.
fn refuse_into_part(parts: &[PathBuf], out: Option<&Path>) -> Result<(), UsageError> {
    let Some(out) = out else { return Ok(()) };
    let Ok(place) = out.canonicalize() else { return Ok(()) };
    let is_part = |part: &PathBuf| part.canonicalize().is_ok_and(|part| part == place);
    if parts.iter().any(is_part) {
        let expected = "a directory of its own for the result";
        return Err(UsageError::option("--out", out.display(), "it is one of the parts", expected));
    }
    Ok(())
}

/// The parts that miss runs, in their order.
fn incomplete(parts: &[(PartFile, &Path)], done: &dyn Fn(usize) -> bool) -> Vec<Incomplete> {
    let (first, any) = &parts[0];
    let count = first.shard.map_or(1, |shard| shard.count);
    let all = (1..=count).map(|index| Shard { index, count });
    all.filter_map(|shard| {
        let runs = (0..first.runs).filter(|run| shard.holds(*run) && !done(*run)).count();
        let own = |part: &&(PartFile, &Path)| part.0.shard.is_none_or(|known| known == shard);
        let directory = parts.iter().find(own).map(|part| part.1);
        let command = || match directory {
            Some(directory) => resume_command(directory),
            None => {
                let own = format!("part-{}-of-{}", shard.index, shard.count);
                let own = ["--shard", &String::from(shard), "--out", &own];
                format!("{} {}", resume_command(any), command_line(&own))
            }
        };
        let directory = directory.map(Path::to_owned);
        (runs > 0).then(|| Incomplete { shard, runs, directory, command: command() })
    })
    .collect()
}

/// Names the incomplete parts on standard error, each with the command that completes it.
pub fn name_incomplete(incomplete: &[Incomplete]) {
    for Incomplete { shard, runs, directory, command } in incomplete {
        let name = String::from(*shard);
        match directory {
            Some(directory) => {
                let directory = directory.display();
                eprintln!("shard {name} in {directory} is not finished, {runs} runs are missing:");
            }
            None => eprintln!("shard {name} is missing, {runs} runs:"),
        }
        eprintln!("  {command}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part of a study of 4 runs in a directory below `base`.
    fn write(
        base: &Path,
        name: &str,
        (study, scenario): (&str, &str),
        shard: &str,
        lines: &str,
    ) -> PathBuf {
        let directory = base.join(name);
        std::fs::create_dir_all(&directory).expect("writable");
        let part = serde_json::json!({
            "schema_version": 2, "study": study, "arguments": {"scenario": scenario},
            "group": {"programs": [], "ready_timeout": 10.0}, "runs": 4, "subject": "0", "shard": shard,
        });
        std::fs::write(directory.join(FILE), part.to_string()).expect("writable");
        std::fs::write(directory.join(journal::FILE), lines).expect("writable");
        directory
    }

    #[test]
    fn missing_and_unfinished_parts_come_with_their_commands() {
        let base = std::env::temp_dir().join(format!("merge-missing-{}", std::process::id()));
        let one = write(&base, "a", ("sweep", "x"), "1/3", "{\"run\":0,\"result\":7}\n");
        let merged = Merged::<u32>::read(std::slice::from_ref(&one), None).expect("a part");
        let found: Vec<_> =
            merged.incomplete.iter().map(|part| (part.runs, &part.command)).collect();
        let resume = format!("timegap resume {}", one.display());
        let other = |index| format!("{resume} --shard {index}/3 --out part-{index}-of-3");
        assert_eq!(found, [(1, &resume), (1, &other(2)), (1, &other(3))]);
        std::fs::remove_dir_all(&base).expect("ours");
    }

    #[test]
    fn parts_that_do_not_belong_together_are_refused() {
        let base = std::env::temp_dir().join(format!("merge-{}", std::process::id()));
        let write = |name: &str, study: (&str, &str), shard: &str, lines: &str| {
            write(&base, name, study, shard, lines)
        };
        let sweep = ("sweep", "a");
        let one = write("one", sweep, "1/2", "{\"run\":0,\"result\":7}\n");
        let lines = "{\"run\":1,\"result\":8}\n{\"run\":3,\"result\":9}\n{\"run\":";
        let two = write("two", sweep, "2/2", lines);
        let both = [two, one.clone()];
        let merged = Merged::<u32>::read(&both, None).expect("parts of one");
        let into = Merged::<u32>::read(&both, Some(&one)).map(drop);
        assert!(into.expect_err("it is a part").to_string().contains("is one of the parts"));
        let [left] = merged.incomplete.as_slice() else { panic!("{:?}", merged.incomplete) };
        assert!(left.command.starts_with("timegap resume "), "{left:?}");
        assert_eq!(merged.records.all().expect("readable"), [(0, 7), (1, 8), (3, 9)]);
        let twice = "{\"run\":1,\"result\":8}\n{\"run\":1,\"result\":8}\n";
        for (directory, words) in [
            (write("other", ("sweep", "b"), "2/2", ""), "part of another sweep"),
            (write("counts", sweep, "2/3", ""), "part of another sweep"),
            (write("again", sweep, "1/2", ""), "the same part as"),
            (write("alien", ("compare", "a"), "2/2", ""), "part of another compare"),
            (write("torn", sweep, "2/2", "{\"run\":1}\n"), "runs.jsonl:1"),
            (write("twice", sweep, "2/2", twice), "is there twice"),
            (write("wrong", sweep, "2/2", "{\"run\":2,\"result\":8}\n"), "does not belong"),
            (write("far", sweep, "2/2", "{\"run\":99,\"result\":8}\n"), "does not belong"),
        ] {
            let refused = Merged::<u32>::read(&[one.clone(), directory], None);
            let said = refused.err().expect(words).to_string();
            assert!(said.contains(words), "{said}");
        }
        std::fs::remove_dir_all(&base).expect("ours");
    }
}
