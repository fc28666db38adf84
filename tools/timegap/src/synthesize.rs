//! `timegap synthesize`: designs a controller from its parameters, offline.

use clap::{Args, ValueEnum};
use group::{Error, Failure};
use std::path::PathBuf;
use std::process::ExitCode;
#[cfg(feature = "synthesize")]
use synthesis::{DesignRequest, SynthesisError, synthesize};

/// Arguments of `synthesize`.
#[derive(Debug, Args)]
pub struct SynthesizeArguments {
    /// Controller to design
    #[arg(value_enum)]
    pub controller: DesignName,
    /// Parameters in TOML (see services/controller/designs/quadratic-bounded.toml)
    pub file: PathBuf,
    /// File for the design
    #[arg(long, value_name = "FILE", default_value = "design.json")]
    pub out: PathBuf,
    /// Print the design as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// A controller with an offline design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DesignName {
    /// Gao, Yan, Li, Hu 2015.
    QuadraticBounded,
}

/// A parameter file without a feasible design.
#[cfg(feature = "synthesize")]
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct Refused {
    path: PathBuf,
    #[source]
    reason: SynthesisError,
}

#[cfg(feature = "synthesize")]
impl Failure for Refused {}

/// Runs the command.
#[cfg(feature = "synthesize")]
pub fn run(arguments: &SynthesizeArguments) -> Result<ExitCode, Error> {
    let DesignName::QuadraticBounded = arguments.controller;
    let path = &arguments.file;
    let text = std::fs::read_to_string(path).map_err(|reason| Error::Path {
        action: "read",
        path: path.clone(),
        reason,
    })?;
    let usage = |reason| Refused { path: path.clone(), reason };
    let request = DesignRequest::from_toml(&text).map_err(usage)?;
    let synthesis = match synthesize(&request) {
        Ok(synthesis) => synthesis,
        Err(error @ SynthesisError::Infeasible(_)) => {
            eprintln!("error: {}: {error}", path.display());
            return Ok(ExitCode::FAILURE);
        }
        Err(error) => return Err(usage(error).into()),
    };
    let json = synthesis.design.to_json();
    std::fs::write(&arguments.out, &json).map_err(|reason| Error::Path {
        action: "write",
        path: arguments.out.clone(),
        reason,
    })?;
    if arguments.json {
        println!("{json}");
        return Ok(ExitCode::SUCCESS);
    }
    for trial in &synthesis.trials {
        let outcome = match &trial.outcome {
            Ok(objective) => format!("certified, objective {objective:.4}"),
            Err(why) => why.to_string(),
        };
        println!("alpha {:.5}: {outcome} ({} iterations)", trial.alpha, trial.iterations);
    }
    println!("design: {}", arguments.out.display());
    println!(
        "use it: timegap run SCENARIO --controller quadratic-bounded \
         --set controller.quadratic_bounded.design={}",
        arguments.out.display()
    );
    Ok(ExitCode::SUCCESS)
}

/// This build lacks the solver.
#[cfg(not(feature = "synthesize"))]
#[derive(Debug, thiserror::Error)]
#[error(
    "this build cannot design controllers: it needs OpenBLAS (on Debian: apt-get install \
     libopenblas-dev pkg-config gfortran) and the cargo feature, as in\n  \
     cargo run --release --features synthesize -- synthesize quadratic-bounded {}",
    file.display()
)]
pub struct NotBuilt {
    file: PathBuf,
}

#[cfg(not(feature = "synthesize"))]
impl Failure for NotBuilt {}

/// Reports the missing solver.
#[cfg(not(feature = "synthesize"))]
pub fn run(arguments: &SynthesizeArguments) -> Result<ExitCode, Error> {
    Err(NotBuilt { file: arguments.file.clone() }.into())
}
