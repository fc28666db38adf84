//! Laws as units of FMI 2.0, for masters such as Simulink, OpenModelica and fmpy.
//!
//! ```text
//! unit.fmu ── binaries/linux64/unit.so      FMI 2.0's functions, one file of Rust without a crate (library/unit.rs)
//!          ├─ resources/timegap             this program, or a script that starts it where it stands
//!          ├─ resources/scenario.toml       the law with its keys; `resources/loop` if it is in the loop
//!          └─ modelDescription.xml
//! ```
//!
//! The library starts the program, and asks it through pipes. So the unit computes what timegap computes, a master
//! meets no foreign threads and no allocator but its own, and the export needs no compiler.

mod model;
mod ports;

use clap::Args;
use model::Model;
use scenario::{Overrides, Scenario, Setting};
use sha2::{Digest, Sha256};
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::{Error, UsageError};

/// The library, compiled for this machine by the build script.
const LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/unit.so"));
/// Values of a question and of an answer.
const VALUES: usize = 64;

#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Law of timegap's own that the unit computes
    #[arg(long, value_name = "NAME")]
    pub law: String,
    /// Put the law into a loop: vehicle, actuator gateway, and the delays, losses and restarts of a deployment
    #[arg(long)]
    pub plant: bool,
    /// Unit to write
    #[arg(long, value_name = "FILE.fmu")]
    pub file: PathBuf,
    /// Set a key of the law or the vehicle, by its dotted path (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<Setting>,
    /// Let the unit start this program where it stands, in place of a copy: a small unit for this machine
    #[arg(long)]
    pub link: bool,
}

/// Runs `timegap export-fmu`.
///
/// # Errors
/// When there is no such law, a key is wrong, or the unit cannot be written.
pub fn run(arguments: &ExportArguments) -> Result<ExitCode, Error> {
    let (law, file) = (&arguments.law, &arguments.file);
    if file.extension().is_none_or(|end| end != "fmu") {
        let expected = "a name that ends with .fmu";
        return Err(UsageError::option("--file", file.display(), "not a unit", expected).into());
    }
    if !laws::ALL.iter().any(|own| own.name == law) {
        let names = scenario::accepted(law, laws::ALL.iter().map(|own| own.name));
        return Err(UsageError::option("--law", law, "not a law of timegap's own", names).into());
    }
    let mut overrides = Overrides::new();
    arguments.set.iter().cloned().for_each(|setting| overrides.set(setting));
    let text = format!("schema_version = 1\nname = \"unit\"\n[controller]\nname = {law:?}\n");
    let check = &controller::laws::check;
    let scenario = Scenario::parse_with("the unit", &text, &overrides, check)?;
    let period_s = 1e-3 * f64::from(scenario.controller.period_ms.value());
    let text = scenario.to_toml();
    let ports = if arguments.plant { ports::LOOP } else { ports::LAW };
    let name = format!("{law}{}", if arguments.plant { "-loop" } else { "" });
    let hash = Sha256::digest(format!("{text}{name}{}", env!("CARGO_PKG_VERSION")));
    let token: String = hash[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    let description = ports::description(ports, &name, &token, period_s);
    let library = format!("binaries/{}/unit.so", fmi::platform(fmi::Version::Two));
    let program =
        std::env::current_exe().map_err(Error::path("find", Path::new("this program")))?;
    let quoted = program.display().to_string().replace('\'', r"'\''");
    let own = match arguments.link {
        true => format!("#!/bin/sh\nexec '{quoted}' \"$@\"\n").into_bytes(),
        false => fs::read(&program).map_err(Error::path("read", &program))?,
    };
    let mut files = vec![
        ("modelDescription.xml", description.as_bytes()),
        (library.as_str(), LIBRARY),
        ("resources/scenario.toml", text.as_bytes()),
        ("resources/timegap", own.as_slice()),
    ];
    if arguments.plant {
        files.push(("resources/loop", b"\n"));
    }
    let unit = fmi::pack(&files).map_err(Error::path("pack", file))?;
    fs::write(file, unit).map_err(Error::path("write", file))?;
    Ok(ExitCode::SUCCESS)
}

/// Runs the process of an exported unit, whose resources are in `directory`.
pub fn serve(directory: &Path) -> ExitCode {
    let served = || -> Result<(), Box<dyn std::error::Error>> {
        let text = fs::read_to_string(directory.join("scenario.toml"))?;
        let scenario = Scenario::parse("scenario.toml", &text)?;
        let mut model = Model::new(scenario, directory.join("loop").exists())?;
        let (mut questions, mut answers) = (io::stdin().lock(), io::stdout().lock());
        let mut question = [0.0; 2 + VALUES];
        while questions.read_exact(bytemuck::cast_slice_mut(&mut question)).is_ok() {
            let [what, step_s, values @ ..] = &mut question;
            match *what == 1.0 {
                true => model.begin(values),
                false => model.step(values, *step_s),
            }
            answers.write_all(bytemuck::cast_slice(values))?;
            answers.flush()?;
        }
        Ok(())
    };
    fmi::ended(served().map_err(|error| format!("{}: {error}", directory.display())))
}
