//! The directory of the results. It has one owner.
//!
//! The command locks its directory until it ends, so that no second command mixes its files with the first one's. A
//! directory that holds results is refused and not changed. `--force` replaces all earlier results. They are put aside
//! until the first new result is written, and put back if no result is written. Other files are left alone.

use clap::Args;
use runtime::histogram_log;
use runtime::statistics::Latencies;
use rustix::fs::{FlockOperation, flock};
use std::cell::Cell;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use supervise::{Error, UsageError};

/// Files that commands write into their directory; a name without a dot is a directory.
const RESULTS: [&str; 38] = [
    "begun.jsonl",
    "bench.json",
    "campaign.json",
    "campaign.toml",
    "compare.json",
    "csv",
    "everyday.json",
    "failure-1.toml",
    "failure-2.toml",
    "failure-3.toml",
    "failure-4.toml",
    "failure-5.toml",
    "gains.csv",
    "graph.json",
    "histograms.hlog",
    "iso15622.json",
    "live.json",
    "metadata.yaml",
    "parquet",
    "part.json",
    "plausibility.json",
    "r157.json",
    "radio.pcap",
    "recording.mcap",
    "replay.csv",
    "report.html",
    "reproduce.json",
    "runs.jsonl",
    "scenario.toml",
    "search.json",
    "signals.json",
    "string.csv",
    "string.json",
    "summary.json",
    "sweep.json",
    "trace.pftrace",
    "trajectories.parquet",
    "trajectory.csv",
];

pub const HISTOGRAMS: &str = "histograms.hlog";

/// Tagged histograms as [`HISTOGRAMS`], which the tools of the HdrHistogram family read.
pub fn histogram_log(histograms: &[(String, Latencies)]) -> Vec<u8> {
    let mut log = Vec::new();
    let tagged = histograms.iter().map(|(tag, histogram)| (tag.as_str(), histogram));
    histogram_log::write(&mut log, tagged).expect("memory takes all, and our tags are words");
    log
}

/// Directory of earlier results until new ones replace them.
const REPLACED: &str = ".replaced";

/// Options for the directory of the results.
#[derive(Clone, Debug, Default, Args)]
pub struct OutputOptions {
    /// Directory for the results; by default below `runs`, named after time and subject
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the results that the directory holds
    #[arg(long, requires = "out")]
    pub force: bool,
}

/// A directory for results, made before the run so that nothing can be lost after it.
#[derive(Debug)]
pub struct OutputDirectory {
    path: PathBuf,
    _directory: File,
    /// Directories that were made for it, the innermost first.
    made: Vec<PathBuf>,
    /// It was taken without results in it: those that are there now are this command's.
    is_cleared: bool,
    /// A result was written, or another file that is to be kept.
    is_used: Cell<bool>,
}

impl OutputDirectory {
    /// Makes the chosen directory, or a new one below `runs` named after the time and `name`.
    ///
    /// # Errors
    /// If it cannot be written, belongs to a command that is running, or holds results.
    pub fn create(options: &OutputOptions, name: &str) -> Result<Self, Error> {
        let Some(path) = &options.out else { return Self::create_new(name) };
        let mut output = Self::take(path)?;
        // A command was killed before it had a result.
        output.put_back()?;
        let found: Vec<_> = results_in(path).collect();
        match found.first() {
            None => {}
            Some(_) if options.force => output.put_aside(&found)?,
            Some(first) => {
                let why = format_args!("it holds results ({first})");
                let expected = "another directory, or --force to replace them";
                return Err(UsageError::at(path.display(), why, expected).into());
            }
        }
        output.is_cleared = true;
        Ok(output)
    }

    /// Opens the directory of a command that was broken off, with its contents; the file `begun` describes them.
    ///
    /// # Errors
    /// If it cannot be written, belongs to a command that is running, or holds results without that file.
    pub fn resume(path: &Path, begun: &'static str) -> Result<Self, Error> {
        let output = Self::take(path)?;
        if let Some(first) = results_in(path).next().filter(|_| !path.join(begun).exists()) {
            let why = format_args!("it holds results ({first}) but no {begun}");
            let expected = "another directory: nothing in it can be gone on with";
            return Err(UsageError::at(path.display(), why, expected).into());
        }
        output.keep();
        Ok(output)
    }

    fn take(path: &Path) -> Result<Self, Error> {
        let error = error(path);
        let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        std::fs::create_dir_all(path).map_err(error)?;
        let output = Self::lock(path.to_owned(), made)?;
        // Refused now rather than after the run.
        output.write_input(".writable", b"")?;
        remove(&path.join(".writable"))?;
        Ok(output)
    }

    fn create_new(name: &str) -> Result<Self, Error> {
        let runs = Path::new("runs");
        std::fs::create_dir_all(runs).map_err(error(runs))?;
        let time = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S").to_string();
        for attempt in 1.. {
            let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
            let path = runs.join(format!("{time}-{name}{suffix}"));
            match std::fs::create_dir(&path) {
                Ok(()) => {
                    let mut output = Self::lock(path.clone(), vec![path, runs.to_owned()])?;
                    output.is_cleared = true;
                    return Ok(output);
                }
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                Err(e) => return Err(error(&path)(e)),
            }
        }
        unreachable!("some attempt finds a free name or fails")
    }

    fn lock(path: PathBuf, made: Vec<PathBuf>) -> Result<Self, Error> {
        let directory = File::open(&path).map_err(error(&path))?;
        match flock(&directory, FlockOperation::NonBlockingLockExclusive) {
            Err(rustix::io::Errno::WOULDBLOCK) => {
                let why = "it belongs to a command that is still running";
                Err(UsageError::at(path.display(), why, "another directory").into())
            }
            // A file system without locks has directories all the same.
            _ => Ok(Self {
                path,
                _directory: directory,
                made,
                is_cleared: false,
                is_used: Cell::new(false),
            }),
        }
    }

    fn put_aside(&self, names: &[&str]) -> Result<(), Error> {
        let aside = self.path.join(REPLACED);
        std::fs::create_dir_all(&aside).map_err(error(&aside))?;
        names.iter().try_for_each(|name| {
            let from = self.path.join(name);
            std::fs::rename(&from, aside.join(name)).map_err(error(&from))
        })
    }

    /// Puts back what was put aside.
    fn put_back(&self) -> Result<(), Error> {
        let aside = self.path.join(REPLACED);
        for name in results_in(&aside) {
            let to = self.path.join(name);
            remove(&to)?;
            std::fs::rename(aside.join(name), &to).map_err(error(&to))?;
        }
        remove(&aside)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Two lines that say where the results and their page are, for the end of a command's output.
    pub fn places(&self) -> String {
        let page = self.path.join(crate::FILE);
        let report = match page.exists() {
            true => format!("report:  {}\n", page.display()),
            // A full disk.
            false => String::new(),
        };
        format!("results: {}\n{report}", self.path.display())
    }

    /// Keeps the directory also if no result is written into it. Results that were to be replaced are gone then.
    pub fn keep(&self) {
        if !self.is_used.replace(true) {
            // A file that cannot be removed stays aside.
            let _ = remove(&self.path.join(REPLACED));
        }
    }

    /// Writes a result, whole or not at all.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), Error> {
        self.write_by(name, |file| file.add(contents))
    }

    /// Writes what a command is about to run. A command that fails before its first result takes it
    /// away again.
    pub fn write_input(&self, name: &str, contents: &[u8]) -> Result<(), Error> {
        self.fill_file(name, |file| file.add(contents))
    }

    /// Writes a result bit by bit, whole or not at all. It serves results that are too long for memory.
    pub fn write_by(
        &self,
        name: &str,
        fill: impl FnOnce(&mut ResultFile) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.keep();
        self.fill_file(name, fill)
    }

    fn fill_file(
        &self,
        name: &str,
        fill: impl FnOnce(&mut ResultFile) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let path = self.path.join(name);
        let temporary = self.path.join(format!(".{name}.part"));
        let written = ResultFile::create(&temporary, &path).and_then(|mut file| {
            fill(&mut file)?;
            file.finish(&temporary)
        });
        written.inspect_err(|_| {
            let _ = std::fs::remove_file(&temporary);
        })
    }
}

impl Drop for OutputDirectory {
    /// Leaves nothing of a command that did not get as far as a result.
    fn drop(&mut self) {
        if self.is_used.get() {
            return;
        }
        if self.is_cleared {
            for name in results_in(&self.path) {
                // A file that cannot be removed stays; the command has failed anyway.
                let _ = remove(&self.path.join(name));
            }
            let _ = self.put_back();
        }
        for directory in &self.made {
            // A directory that holds another file stays.
            let _ = std::fs::remove_dir(directory);
        }
    }
}

/// A result that is being written.
pub struct ResultFile {
    /// Its path when it is whole.
    path: PathBuf,
    file: BufWriter<File>,
}

impl ResultFile {
    fn create(temporary: &Path, path: &Path) -> Result<Self, Error> {
        let file = BufWriter::new(File::create(temporary).map_err(Error::path("write", path))?);
        Ok(Self { path: path.to_owned(), file })
    }

    pub fn add(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.file.write_all(bytes).map_err(Error::path("write", &self.path))
    }

    fn finish(mut self, temporary: &Path) -> Result<(), Error> {
        let path = &self.path;
        let written = (self.file.flush())
            .and_then(|()| self.file.get_ref().sync_all())
            .and_then(|()| std::fs::rename(temporary, path));
        written.map_err(Error::path("write", path))
    }
}

fn error(path: &Path) -> impl Fn(std::io::Error) -> Error + Copy {
    Error::path("write results to", path)
}

fn results_in(directory: &Path) -> impl Iterator<Item = &'static str> {
    RESULTS.into_iter().filter(move |name| is_ours(&directory.join(name)))
}

/// True if there is a file or a directory: links and devices are the user's.
fn is_ours(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|found| found.is_file() || found.is_dir())
}

/// Removes a file or a directory, if it is there.
fn remove(path: &Path) -> Result<(), Error> {
    let removed = match std::fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => std::fs::remove_dir_all(path),
        Ok(_) => std::fs::remove_file(path),
        Err(error) => Err(error),
    };
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed.map_err(Error::path("remove", path)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory of this test's own.
    fn place(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("timegap-output-{}-{name}", std::process::id()))
    }

    fn options(out: &Path, force: bool) -> OutputOptions {
        OutputOptions { out: Some(out.to_owned()), force }
    }

    #[test]
    fn a_directory_has_one_owner_at_a_time() {
        let path = place("owner");
        let first = OutputDirectory::create(&options(&path, false), "x").expect("writable");
        for force in [false, true] {
            let second = OutputDirectory::create(&options(&path, force), "x");
            let refusal = second.expect_err("it has an owner").to_string();
            assert!(refusal.contains("still running"), "{refusal}");
        }
        first.write("summary.json", b"{}").expect("ours");
        drop(first);
        let refusal = OutputDirectory::create(&options(&path, false), "x").expect_err("finished");
        assert!(refusal.to_string().contains("--force"), "{refusal}");
        std::fs::create_dir(path.join("csv")).expect("ours");
        std::fs::write(path.join("notes.txt"), "mine").expect("ours");
        assert!(path.join("summary.json").exists(), "what was refused is left alone");
        let third = OutputDirectory::create(&options(&path, true), "x").expect("forced");
        assert!(!path.join("summary.json").exists() && !path.join("csv").exists());
        drop(third);
        assert!(path.join("summary.json").exists(), "put back, since nothing took its place");
        let fourth = OutputDirectory::create(&options(&path, true), "x").expect("forced");
        fourth.write("sweep.json", b"{}").expect("ours");
        drop(fourth);
        let left = |name: &str| path.join(name).exists();
        assert!(left("sweep.json") && !left("summary.json") && !left(REPLACED));
        assert!(left("notes.txt"), "the user's own files stay");
        std::fs::remove_dir_all(&path).expect("ours");
    }

    #[test]
    fn a_command_without_a_result_leaves_nothing() {
        let path = place("failed").join("a/b");
        let output = OutputDirectory::create(&options(&path, false), "x").expect("writable");
        output.write_input("scenario.toml", b"").expect("ours");
        drop(output);
        assert!(!place("failed").exists());
    }
}
