//! Tests that need more than a Rust toolchain. Examples are a Python with packages from PyPI, a browser, and a kernel
//! that grants mount namespaces.
//!
//! Rust's own harness cannot skip a running test, and a test that returns early counts as passed. Files with this
//! module have `harness = false` and check the needs first. A test without them is *ignored*, with the reason in its
//! line and in the count of the closing line. `.ci/run` repeats these lines at its end, and fails on an unexpected one.
//! cargo-nextest skips tests that its list marks as ignored. So needs are checked when it asks for the list.

use crate::missing::Missing;
use libtest_mimic::{Arguments, Trial};
use std::path::Path;
use std::process::{Command, ExitCode};

/// Result of the check of a need: met, or the reason why not.
pub type Needed = Result<(), Missing>;

/// A test and its need.
pub struct Case {
    name: &'static str,
    needs: fn() -> Needed,
    run: fn(),
    is_long: bool,
}

/// A test without further needs.
#[must_use]
pub const fn case(name: &'static str, run: fn()) -> Case {
    Case { name, needs: || Ok(()), run, is_long: false }
}

/// A test with a need.
#[must_use]
pub const fn needing(needs: fn() -> Needed, name: &'static str, run: fn()) -> Case {
    Case { name, needs, run, is_long: false }
}

/// A test with a need that takes a minute: it runs with `--ignored` only, as in `.ci/extended`.
#[must_use]
pub const fn long(needs: fn() -> Needed, name: &'static str, run: fn()) -> Case {
    Case { name, needs, run, is_long: true }
}

/// Runs the cases like Rust's own harness; checks the needs of the requested ones.
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
        let left_out = case.is_long && (arguments.list || !arguments.ignored);
        let looks = looks && asked(case) && !left_out;
        let missing = if looks { (case.needs)().err() } else { None };
        let run = case.run;
        let trial = Trial::test(case.name, move || {
            run();
            Ok(())
        });
        match missing {
            // With `--ignored` this leaves it out.
            Some(reason) if case.is_long => {
                println!("test {} [SKIPPED: {reason}]", case.name);
                trial
            }
            Some(reason) => trial.with_kind(format!("SKIPPED: {reason}")).with_ignored_flag(true),
            None => trial.with_ignored_flag(case.is_long),
        }
    };
    libtest_mimic::run(&arguments, cases.iter().map(trial).collect()).exit_code()
}

/// A mount namespace with a file system of its own.
///
/// # Errors
/// The reason, if the kernel refuses.
pub fn mount_namespace() -> Needed {
    let script = "mount -t tmpfs -o size=64k none /mnt";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script])
        .output();
    match output {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            Err(Missing(format!("no mount namespace: {said}")))
        }
        Err(error) => Err(Missing(format!("unshare: {error}"))),
    }
}

/// A program on the search path.
///
/// # Errors
/// Its name, if it is missing.
pub fn program(name: &str) -> Needed {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).any(|directory| directory.join(name).is_file());
    if found { Ok(()) } else { Err(Missing(format!("no {name}"))) }
}

/// The Python of [`crate::python`] below `directory`.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn python(directory: &Path) -> Needed {
    crate::python::INTEROP.interpreter(directory).map(|_| ())
}
