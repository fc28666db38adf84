//! `timegap bridge`, and `--bridge` of `timegap run`: a run or a recording, live in a viewer.

use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use supervise::Error;

#[derive(Debug, Args)]
pub struct BridgeArguments {
    /// Viewer and port: foxglove or foxglove:PORT
    pub viewer: String,
    /// Results directory of a run in progress, a recording, or `latest` for the newest results below `runs`
    #[arg(long, value_name = "DIR", default_value = "latest")]
    pub run: PathBuf,
    /// Pace of a recording, times its own
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub speed: f64,
}

/// Serves a run in progress or a recording until its end.
pub fn run(BridgeArguments { viewer, run, speed }: &BridgeArguments) -> Result<ExitCode, Error> {
    #[cfg(feature = "foxglove")]
    return foxglove_bridge::serve(viewer, run, *speed);
    #[cfg(not(feature = "foxglove"))]
    return Err(refusal(format_args!("{viewer} {} {speed}", run.display())));
}

/// Address of `--bridge` in the form that the bridge's process takes.
pub fn address(viewer: &str) -> Result<OsString, Error> {
    #[cfg(feature = "foxglove")]
    return Ok(foxglove_bridge::port("--bridge", viewer)?.to_string().into());
    #[cfg(not(feature = "foxglove"))]
    return Err(refusal(viewer));
}

#[cfg(not(feature = "foxglove"))]
fn refusal(asked: impl std::fmt::Display) -> Error {
    let expected = "a program that was built with `--features bridge`";
    supervise::UsageError::at(asked, "this one has no bridge", expected).into()
}
