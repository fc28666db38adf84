//! Parts joined, and the parts that are missing.

use std::path::{Path, PathBuf};

use group::{Error, Failure};
use serde::de::DeserializeOwned;

use super::{FILE, Records, Shard, Study, holds, journal, read_file, take};
use crate::batch::ProcessesSample;
use runtime::command_line;

/// Reason why directories are not joined.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A directory belongs to another command.
    #[error("{} holds no part of a {name}", directory.display())]
    NoPart {
        /// The directory.
        directory: PathBuf,
        /// Name of the command.
        name: String,
    },
    /// A directory holds a part of something else.
    #[error("{} is part of another {name} than the directories before it", directory.display())]
    OtherStudy {
        /// The directory.
        directory: PathBuf,
        /// Name of the command.
        name: String,
    },
    /// Two directories hold the same part.
    #[error("{} holds the same part as {}", directory.display(), before.display())]
    SamePart {
        /// The directory.
        directory: PathBuf,
        /// The one before it.
        before: PathBuf,
    },
    /// The result would replace one of the parts.
    #[error("--out {}: it is one of the parts; expected a directory of its own for the result", directory.display())]
    IntoPart {
        /// The directory.
        directory: PathBuf,
    },
    /// A scenario file was changed after the parts were done.
    #[error(
        "timegap {}: the scenario is another one now than when the parts were done",
        command_line(words)
    )]
    Changed {
        /// The command's words.
        words: Vec<String>,
    },
}

impl Failure for MergeError {}

/// Refuses a result that would replace one of `parts`.
///
/// # Errors
/// [`MergeError::IntoPart`].
pub fn refuse_into_part(parts: &[PathBuf], out: Option<&Path>) -> Result<(), MergeError> {
    let Some(out) = out else { return Ok(()) };
    let Ok(place) = out.canonicalize() else { return Ok(()) };
    let is_part = |part: &PathBuf| part.canonicalize().is_ok_and(|part| part == place);
    match parts.iter().any(is_part) {
        true => Err(MergeError::IntoPart { directory: out.into() }),
        false => Ok(()),
    }
}

/// Parts joined.
pub struct Merged<T> {
    /// Their study.
    pub study: Study,
    /// Records of the finished runs.
    pub records: Records<T>,
    /// Runs that were repeated in process groups.
    pub sample: ProcessesSample,
    /// Parts that are missing or unfinished.
    pub incomplete: Vec<Incomplete>,
}

/// A part that is missing or not finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incomplete {
    /// The part.
    pub shard: Shard,
    /// Number of its missing runs.
    pub runs: usize,
    /// Its directory; none: it was not begun.
    pub directory: Option<PathBuf>,
    /// The command that completes it.
    pub command: String,
}

impl<T: DeserializeOwned> Merged<T> {
    /// Reads the parts of one study of the command `name`, whose result goes to `out`.
    ///
    /// # Errors
    /// [`MergeError`], [`JournalError`](super::journal::JournalError), or a file cannot be read.
    pub fn read(name: &str, directories: &[PathBuf], out: Option<&Path>) -> Result<Self, Error> {
        refuse_into_part(directories, out)?;
        let mut study: Option<Study> = None;
        let mut parts: Vec<(Option<Shard>, &Path)> = Vec::new();
        let mut records = None;
        let mut sample = ProcessesSample::default();
        for directory in directories {
            let part = read_file(&directory.join(FILE))?;
            if part.study.words.first().is_none_or(|word| word != name) {
                return Err(
                    MergeError::NoPart { directory: directory.clone(), name: name.into() }.into()
                );
            }
            let other_count =
                |known: &Option<Shard>| known.map(|k| k.count) != part.shard.map(|p| p.count);
            if study.as_ref().is_some_and(|study| *study != part.study)
                || parts.iter().any(|(known, _)| other_count(known))
            {
                return Err(MergeError::OtherStudy {
                    directory: directory.clone(),
                    name: name.into(),
                }
                .into());
            }
            if let Some((_, before)) = parts.iter().find(|(known, _)| *known == part.shard) {
                return Err(MergeError::SamePart {
                    directory: directory.clone(),
                    before: (*before).into(),
                }
                .into());
            }
            let records = records.get_or_insert_with(|| Records::new(part.study.runs));
            let journal = directory.join(journal::FILE);
            records.begin(&journal);
            journal::read(&journal, &mut |place, line| {
                Ok(take::<T>(records, &mut sample, part.shard, place, line)?)
            })?;
            parts.push((part.shard, directory));
            study = Some(part.study);
        }
        let study = study.expect("clap asks for at least one directory");
        let records = records.expect("it has a part");
        let done = |run: usize| records.has(run);
        let incomplete = incomplete(&parts, study.runs, &done, &|shard, directory| {
            if let Some(directory) = directory {
                return study.resume(directory);
            }
            let own = format!("part-{}-of-{}", shard.index, shard.count);
            let more = ["--shard".into(), String::from(shard), "--resume".into(), own];
            format!("timegap {}", command_line(&[study.words.as_slice(), &more].concat()))
        });
        Ok(Self { study, records, sample, incomplete })
    }
}

impl<T> Merged<T> {
    /// Checks that the command still means the same as its parts. `subject` is the content of all that its words name.
    ///
    /// # Errors
    /// [`MergeError::Changed`].
    pub fn check(&self, runs: usize, subject: &str) -> Result<(), MergeError> {
        if self.study.now(runs, subject) == self.study {
            return Ok(());
        }
        Err(MergeError::Changed { words: self.study.words.clone() })
    }
}

/// The parts that miss runs, in their order.
pub fn incomplete(
    parts: &[(Option<Shard>, &Path)],
    runs: usize,
    done: &dyn Fn(usize) -> bool,
    command: &dyn Fn(Shard, Option<&Path>) -> String,
) -> Vec<Incomplete> {
    let count = parts.first().and_then(|part| part.0).map_or(1, |shard| shard.count);
    let all = (1..=count).map(|index| Shard { index, count });
    all.filter_map(|shard| {
        let left = (0..runs).filter(|run| holds(Some(shard), *run) && !done(*run)).count();
        let own = |part: &&(Option<Shard>, &Path)| part.0.is_none_or(|known| known == shard);
        let directory = parts.iter().find(own).map(|part| part.1);
        (left > 0).then(|| Incomplete {
            shard,
            runs: left,
            directory: directory.map(Path::to_owned),
            command: command(shard, directory),
        })
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

    #[test]
    fn missing_and_unfinished_parts_come_with_their_commands() {
        let shard = |index| Shard { index, count: 3 };
        let parts = [(Some(shard(1)), Path::new("a")), (Some(shard(3)), Path::new("c"))];
        // Shard 1 has runs 0, 3, 6; shard 3 has runs 2, 5.
        let done = |run: usize| [0, 3, 6, 2].contains(&run);
        let command = |shard: Shard, directory: Option<&Path>| {
            format!(
                "{} {}",
                shard.index,
                directory.map_or("new".into(), |d| d.display().to_string())
            )
        };
        let found = incomplete(&parts, 8, &done, &command);
        let commands: Vec<_> = found.iter().map(|part| part.command.as_str()).collect();
        assert_eq!(commands, ["2 new", "3 c"]);
        assert_eq!(found.iter().map(|part| part.runs).collect::<Vec<_>>(), [3, 1]);
    }

    #[test]
    fn parts_that_do_not_belong_together_are_refused() {
        let base = std::env::temp_dir().join(format!("merge-{}", std::process::id()));
        let write = |name: &str, words: &[&str], shard: &str, lines: &str| {
            let directory = base.join(name);
            std::fs::create_dir_all(&directory).expect("writable");
            let part = serde_json::json!({
                "study": {"schema_version": 1, "words": words, "runs": 4, "scenario": "0"},
                "shard": shard,
            });
            std::fs::write(directory.join(FILE), part.to_string()).expect("writable");
            std::fs::write(directory.join(journal::FILE), lines).expect("writable");
            directory
        };
        let one = write("one", &["sweep", "a"], "1/2", "{\"run\":0,\"result\":7}\n");
        let two = write(
            "two",
            &["sweep", "a"],
            "2/2",
            "{\"run\":1,\"result\":8}\n{\"run\":3,\"result\":9}\n{\"run\":",
        );
        let merged =
            Merged::<u32>::read("sweep", &[two.clone(), one.clone()], None).expect("parts of one");
        let into = Merged::<u32>::read("sweep", &[two.clone(), one.clone()], Some(&one)).map(drop);
        assert!(into.expect_err("it is a part").to_string().contains("is one of the parts"));
        let incomplete = merged.incomplete.clone();
        let records = merged.records.all().expect("readable");
        assert_eq!(records, [(0, 7), (1, 8), (3, 9)]);
        let [left] = incomplete.as_slice() else { panic!("{incomplete:?}") };
        assert!(left.command.starts_with("timegap sweep --resume "), "{left:?}");
        for (directory, words) in [
            (write("other", &["sweep", "b"], "2/2", ""), "part of another sweep"),
            (write("counts", &["sweep", "a"], "2/3", ""), "part of another sweep"),
            (write("again", &["sweep", "a"], "1/2", ""), "the same part as"),
            (write("alien", &["compare", "a"], "2/2", ""), "no part of a sweep"),
            (write("torn", &["sweep", "a"], "2/2", "{\"run\":1}\n"), "runs.jsonl:1"),
            (
                write(
                    "twice",
                    &["sweep", "a"],
                    "2/2",
                    "{\"run\":1,\"result\":8}\n{\"run\":1,\"result\":8}\n",
                ),
                "is there twice",
            ),
            (
                write("wrong", &["sweep", "a"], "2/2", "{\"run\":2,\"result\":8}\n"),
                "does not belong",
            ),
            (
                write("far", &["sweep", "a"], "2/2", "{\"run\":99,\"result\":8}\n"),
                "does not belong",
            ),
        ] {
            let refused = Merged::<u32>::read("sweep", &[one.clone(), directory], None);
            let said = refused.err().expect(words).to_string();
            assert!(said.contains(words), "{said}");
        }
        std::fs::remove_dir_all(&base).expect("ours");
    }
}
