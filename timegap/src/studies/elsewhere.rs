//! What this program does not know is in `timegap-studies`, beside it.

use crate::cli::{Cli, Command};
use clap::CommandFactory;
use std::ffi::OsString;
use std::fmt::Display;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{self, ExitCode};
use supervise::{Error, UsageError};

/// The words behind a word of the other program, which reads them.
#[derive(Debug, clap::Args)]
pub struct Words {
    words: Vec<OsString>,
}

pub type Compare = Words;
pub type Sweep = Words;
pub type String = Words;
pub type Search = Words;
pub type Campaign = Words;
pub type Test = Words;
pub type Papers = Words;
pub type Merge = Words;
pub type Resume = Words;
pub type Bench = Words;
pub type ExportFmu = Words;
pub type List = Words;
pub type Print = Words;

/// Goes on as the other program where only that one knows the word.
pub fn hand_over(words: &[OsString]) -> Result<(), Error> {
    let command = Cli::command();
    let word = words.get(1).and_then(|word| command.find_subcommand(word));
    let elsewhere =
        word.filter(|word| word.get_arguments().any(|argument| argument.get_id() == "words"));
    elsewhere.map_or(Ok(()), |word| go_on(words, word.get_name()))
}

/// Returns only where the other program cannot be started.
fn go_on(words: &[OsString], word: &str) -> Result<(), Error> {
    let usage =
        |why: &dyn Display, expected| UsageError::at(format_args!("timegap {word}"), why, expected);
    let own = std::env::current_exe().map_err(Error::path("find", Path::new("this program")))?;
    let other = own.with_file_name("timegap-studies");
    // `cargo run` has built this program alone.
    if std::env::var_os("CARGO_MANIFEST_DIR").is_some_and(|it| it == env!("CARGO_MANIFEST_DIR")) {
        build(&own, !other.exists()).map_err(|why| usage(&why, "a build without errors"))?;
    }
    let reason = process::Command::new(&other).arg0(&words[0]).args(&words[1..]).exec();
    if reason.kind() != std::io::ErrorKind::NotFound {
        return Err(Error::path("start", &other)(reason));
    }
    let why = format_args!("it is in another program, and {} is not there", other.display());
    let all = "one program with all: `cargo install --path timegap --locked --features studies --bin timegap`";
    Err(usage(&why, all).into())
}

/// Builds the other program beside this one, as `cargo run` built this one.
fn build(own: &Path, is_first: bool) -> Result<(), std::string::String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let place: Vec<&Path> = own.ancestors().skip(1).take(2).collect();
    let [profile, target] = place[..] else { return Err("it is not in cargo's directory".into()) };
    let profile = match profile.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    if is_first {
        eprintln!("note: cargo builds timegap-studies, which has this command");
    }
    let mut command = process::Command::new(cargo);
    command.args(["build", "--locked", "--package", "timegap", "--bin", "timegap-studies"]);
    command.args(["--features", "studies", "--profile", profile, "--target-dir"]).arg(target);
    command.arg("--manifest-path").arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"));
    if !is_first {
        command.arg("--quiet");
    }
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("cargo could not build timegap-studies: {status}")),
        Err(reason) => Err(format!("cargo does not start: {reason}")),
    }
}

/// Never called: the other program reads these words.
pub fn run(command: Command) -> Result<ExitCode, Error> {
    unreachable!("{command:?} was handed over")
}

/// The processes that only studies and the bench start. This program has none.
pub fn serve(_: &str, _: &[&str]) -> Option<Result<ExitCode, Error>> {
    None
}
