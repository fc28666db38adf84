//! Tests that need more than a Rust toolchain: a Python with packages from PyPI, a browser, a kernel that
//! grants mount namespaces.
//!
//! Rust's own harness cannot skip a test once it runs, and a test that returns early counts as passed. The
//! files that use this module have `harness = false` and look for what is needed first: a test without it
//! is *ignored*, with the reason in its line and in the count of the closing line. `.ci/run` prints those
//! lines again at its end, and fails on one that is not expected. cargo-nextest does not run what is ignored in its
//! list: for it, what is needed is looked for when it asks for the list.

use libtest_mimic::{Arguments, Trial};
use std::path::Path;
use std::process::{Command, ExitCode};

/// What a test needs is there, or why it is not.
pub type Needed = Result<(), String>;

/// A test and what it needs.
pub struct Case {
    name: &'static str,
    needs: fn() -> Needed,
    run: fn(),
}

/// A test that needs nothing more.
#[must_use]
pub const fn case(name: &'static str, run: fn()) -> Case {
    Case { name, needs: || Ok(()), run }
}

/// A test that needs something more.
#[must_use]
pub const fn needing(needs: fn() -> Needed, name: &'static str, run: fn()) -> Case {
    Case { name, needs, run }
}

/// Runs the cases as Rust's own harness would; what is needed is looked for in cases that were asked for.
#[must_use]
pub fn run(cases: &[Case]) -> ExitCode {
    let arguments = Arguments::from_args();
    let looks = !arguments.list || std::env::var_os("NEXTEST").is_some();
    let asked = |case: &Case| match &arguments.filter {
        Some(filter) if arguments.exact => case.name == filter,
        Some(filter) => case.name.contains(filter.as_str()),
        None => true,
    };
    let trial = |case: &Case| {
        let missing = if asked(case) && looks { (case.needs)().err() } else { None };
        let run = case.run;
        let trial = Trial::test(case.name, move || {
            run();
            Ok(())
        });
        match missing {
            Some(reason) => trial.with_kind(format!("SKIPPED: {reason}")).with_ignored_flag(true),
            None => trial,
        }
    };
    libtest_mimic::run(&arguments, cases.iter().map(trial).collect()).exit_code()
}

/// A mount namespace of one's own, with a file system in it.
///
/// # Errors
/// The reason where the kernel does not grant one.
pub fn mount_namespace() -> Needed {
    let script = "mount -t tmpfs -o size=64k none /mnt";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script])
        .output();
    match output {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            Err(format!("no mount namespace: {said}"))
        }
        Err(error) => Err(format!("unshare: {error}")),
    }
}

/// A program on the search path.
///
/// # Errors
/// Its name where there is none.
pub fn program(name: &str) -> Needed {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).any(|directory| directory.join(name).is_file());
    if found { Ok(()) } else { Err(format!("no {name}")) }
}

/// The Python of [`crate::python`] below `directory`.
///
/// # Errors
/// The reason where there is no Python, no pip or no network.
pub fn python(directory: &Path) -> Needed {
    crate::python::interpreter(directory).map(|_| ()).map_err(|why| why.0)
}
