//! A Python for the tests, with packages that read timegap's files.

use crate::missing::Missing;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// A virtual environment of Python with packages from PyPI.
#[derive(Debug)]
pub struct Environment {
    name: &'static str,
    packages: &'static [&'static str],
    /// It needs Python's shared library.
    is_shared: bool,
    found: OnceLock<Result<PathBuf, Missing>>,
}

/// Readers of timegap's files.
pub static INTEROP: Environment = Environment::new(
    "interop",
    &[
        "autosar-e2e==1.0.0",
        "iceoryx2==0.10.0",
        "mcap==1.6.0",
        "mcap-ros2-support==0.6.0",
        "pandas==3.1.1",
        "pyarrow==26.0.1",
        "rosbags==0.11.9",
    ],
);
/// Programs that run a notebook.
pub static NOTEBOOK: Environment =
    Environment::new("notebook", &["ipykernel==6.29.5", "nbclient==0.10.2"]);
/// Writers of units of FMI, and a master that validates and runs them.
pub static FMI: Environment = Environment {
    name: "fmi",
    packages: &["fmpy==0.3.32", "pythonfmu==0.7.0", "pythonfmu3==0.3.4"],
    is_shared: true,
    found: OnceLock::new(),
};
/// A reader of Perfetto's traces.
pub static TRACE: Environment = Environment::new("perfetto", &["perfetto", "protobuf"]);
/// A speaker of DDS.
pub static DDS: Environment = Environment::new("dds", &["cyclonedds==11.0.1"]);
/// A viewer by Foxglove's protocol.
pub static BRIDGE: Environment =
    Environment::new("bridge", &["mcap-ros2-support==0.6.0", "websockets==17.4"]);
/// SUMO, and nothing beside it.
pub static SUMO: Environment = Environment::new("sumo", &["eclipse-sumo==1.28.0"]);

impl Environment {
    const fn new(name: &'static str, packages: &'static [&'static str]) -> Self {
        Self { name, packages, is_shared: false, found: OnceLock::new() }
    }

    /// Its interpreter, below `directory`; created at the first call.
    ///
    /// # Errors
    /// The reason: no Python, no shared library of it, no pip or no network.
    pub fn interpreter(&self, directory: &Path) -> Result<PathBuf, Missing> {
        let create = || {
            if self.is_shared && !has_shared_library() {
                return Err(Missing("python3 has no shared library".to_owned()));
            }
            prepare(&directory.join(format!("{}-venv", self.name)), self.packages)
        };
        self.found.get_or_init(create).clone()
    }
}

fn has_shared_library() -> bool {
    let script = "import os, sysconfig as c\n\
                  assert os.path.exists(c.get_config_var('LIBDIR') + '/' + c.get_config_var('INSTSONAME'))";
    let output = Command::new("python3").args(["-c", script]).output();
    output.is_ok_and(|output| output.status.success())
}

/// Test processes run side by side: the first one creates the environment, and the others wait for it.
fn prepare(venv: &Path, packages: &[&str]) -> Result<PathBuf, Missing> {
    let system = |error: std::io::Error| Missing(format!("{}: {error}", venv.display()));
    std::fs::create_dir_all(venv.parent().unwrap_or(venv)).map_err(system)?;
    let lock = File::create(venv.with_extension("lock")).map_err(system)?;
    lock.lock().map_err(system)?;
    let python = venv.join("bin/python");
    let marker = venv.join("installed");
    let wanted = packages.join("\n");
    if std::fs::read_to_string(&marker).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    let failed = |output: Output| {
        let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        text.lines().last().unwrap_or("no reason given").to_owned()
    };
    let run = |command: &mut Command, what: &str| match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(Missing(format!("{what}: {}", failed(output)))),
        Err(error) => Err(Missing(format!("{what}: {error}"))),
    };
    // The remains of an interrupted attempt would be in the way.
    run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(venv), "python3 -m venv")?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    run(Command::new(&python).args(pip).args(packages), "pip install")?;
    std::fs::write(&marker, wanted).map_err(system)?;
    Ok(python)
}
