//! A Python for the tests, with packages that read timegap's files.

use crate::missing::Missing;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Packages from PyPI.
const PACKAGES: [&str; 7] = [
    "autosar-e2e==1.0.0",
    "iceoryx2==0.10.0",
    "mcap==1.6.0",
    "mcap-ros2-support==0.6.0",
    "pandas==3.1.1",
    "pyarrow==26.0.1",
    "rosbags==0.11.9",
];

/// Packages that run a notebook.
const NOTEBOOK_PACKAGES: [&str; 2] = ["ipykernel==6.29.5", "nbclient==0.10.2"];
/// Packages that write units of FMI, and a master that validates and runs them.
const FMI_PACKAGES: [&str; 3] = ["fmpy==0.3.32", "pythonfmu==0.7.0", "pythonfmu3==0.3.4"];
/// Packages that read Perfetto's traces.
const TRACE_PACKAGES: [&str; 2] = ["perfetto", "protobuf"];

/// Packages that speak DDS.
const DDS_PACKAGES: [&str; 1] = ["cyclonedds==11.0.1"];
/// Packages that speak Foxglove's protocol.
const BRIDGE_PACKAGES: [&str; 2] = ["mcap-ros2-support==0.6.0", "websockets==17.4"];

/// The interpreter of a virtual environment below `directory` that speaks with a bridge, created at the first call.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn bridge_interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| prepare(&directory.join("bridge-venv"), &BRIDGE_PACKAGES)).clone()
}

/// The interpreter of a virtual environment below `directory` that speaks DDS, created at the first call.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn dds_interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| prepare(&directory.join("dds-venv"), &DDS_PACKAGES)).clone()
}

/// SUMO, and nothing beside it.
const SUMO_PACKAGES: [&str; 1] = ["eclipse-sumo==1.28.0"];

/// The interpreter of a virtual environment below `directory` with SUMO beside it, created at the first call.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn sumo_interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| prepare(&directory.join("sumo-venv"), &SUMO_PACKAGES)).clone()
}

/// The interpreter of a virtual environment below `directory` that runs notebooks, created at the first call.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn notebook_interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| prepare(&directory.join("notebook-venv"), &NOTEBOOK_PACKAGES)).clone()
}

/// The interpreter of a virtual environment below `directory`, created at the first call.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| prepare(&directory.join("interop-venv"), &PACKAGES)).clone()
}

/// The interpreter of a virtual environment below `directory` that reads Perfetto's traces, created at the first call.
///
/// # Errors
/// The reason: no Python, no pip or no network.
pub fn trace_interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| prepare(&directory.join("perfetto-venv"), &TRACE_PACKAGES)).clone()
}

/// The interpreter of a virtual environment below `directory` with units of FMI, created at the first call.
///
/// # Errors
/// The reason: no Python, no shared library of it, no pip or no network.
pub fn fmi_interpreter(directory: &Path) -> Result<PathBuf, Missing> {
    static FOUND: OnceLock<Result<PathBuf, Missing>> = OnceLock::new();
    FOUND
        .get_or_init(|| {
            let script = "import os, sysconfig as c\n\
                          assert os.path.exists(c.get_config_var('LIBDIR') + '/' + c.get_config_var('INSTSONAME'))";
            let shared = Command::new("python3").args(["-c", script]).output();
            if !shared.is_ok_and(|output| output.status.success()) {
                return Err(Missing("python3 has no shared library".to_owned()));
            }
            prepare(&directory.join("fmi-venv"), &FMI_PACKAGES)
        })
        .clone()
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
