//! A service as a process.
//!
//! A process can be started ahead. It has loaded its libraries and read the scenario. It opens its ports when the
//! process before it is gone. Until then it is not a service, and cannot be found under a service's name. Its own name
//! has another beginning, which it replaces in its own memory.

use crate::life::link::Link;
use crate::{FromService, Runtime, RuntimeError};
use messages::Service;
use std::fs::OpenOptions;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::process::ExitCode;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// The last argument of a process that is started ahead.
pub const PREPARED: &str = "prepared";
/// Beginning of the name of a service's process.
pub const NAME_PREFIX: &str = "timegap-";
/// Beginning of the name of a process that is started ahead.
pub const PREPARED_PREFIX: &str = "prepare-";

// One takes the place of the other.
const _: () = assert!(NAME_PREFIX.len() == PREPARED_PREFIX.len());

/// Field of `/proc/self/stat` with the address of the arguments, counted from the one behind the name.
const ARGUMENTS_FIELD: usize = 45;

/// Exit status of a process whose standby took over.
const REPLACED: u8 = 3;

/// Sends warnings to standard error; once in a process. Those of iceoryx2, which are about its own
/// objects, only where the environment sets `TIMEGAP_LOG`.
pub fn log_warnings() {
    let library = match std::env::var_os("TIMEGAP_LOG") {
        Some(_) => LevelFilter::WARN,
        None => LevelFilter::OFF,
    };
    let filter = Targets::new().with_default(LevelFilter::WARN).with_target("iceoryx2", library);
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .without_time()
        .with_ansi(false)
        .with_target(false);
    tracing_subscriber::registry().with(lines.with_filter(filter)).init();
}

/// A service process from its start to its exit status. `arguments` are the run's root, the incarnation,
/// and [`PREPARED`] for a process that is started ahead.
pub fn run_service(
    service: Service,
    arguments: &[String],
    run: impl FnOnce(Runtime) -> Result<(), RuntimeError>,
) -> ExitCode {
    let parsed = match arguments {
        [root, incarnation] => Some((root, incarnation, false)),
        [root, incarnation, last] if last == PREPARED => Some((root, incarnation, true)),
        _ => None,
    };
    let parsed = parsed.and_then(|(root, text, is)| Some((root, text.parse::<u32>().ok()?, is)));
    let Some((root, incarnation, is_prepared)) = parsed else {
        eprintln!("{service} is a service of timegap: start it with `timegap run`");
        return ExitCode::from(2);
    };
    log_warnings();
    let wait = |link: &Link| if is_prepared { wait(link) } else { Ok(()) };
    end_of_process(Runtime::join(service, Path::new(root), incarnation, wait).and_then(run))
}

/// The exit status of a process that lived so. The launcher gets the error.
pub fn end_of_process(lived: Result<(), RuntimeError>) -> ExitCode {
    match lived {
        Ok(()) | Err(RuntimeError::Stopped) => ExitCode::SUCCESS,
        // Not an orderly end of the service: the launcher may see it before the report of the take-over.
        Err(RuntimeError::Replaced) => ExitCode::from(REPLACED),
        Err(error) => {
            if std::env::var_os("TIMEGAP_LOG").is_some() {
                eprintln!("{error:?}");
            }
            let line = serde_json::to_string(&FromService::Failed(error.to_string()));
            println!("{}", line.expect("a string is plain data"));
            ExitCode::FAILURE
        }
    }
}

/// Waits until the launcher lets this process into the run.
fn wait(link: &Link) -> Result<(), RuntimeError> {
    link.wait_to_join()?;
    // Only `ps` shows the name.
    let _ = take_name();
    Ok(())
}

/// Writes the beginning of a service's name over that of this process.
fn take_name() -> std::io::Result<()> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let address = fields.into_iter().nth(ARGUMENTS_FIELD).and_then(|field| field.parse().ok());
    let address: u64 = address.ok_or(std::io::ErrorKind::InvalidData)?;
    let memory = OpenOptions::new().read(true).write(true).open("/proc/self/mem")?;
    let mut name = [0; PREPARED_PREFIX.len()];
    memory.read_exact_at(&mut name, address)?;
    if name == *PREPARED_PREFIX.as_bytes() {
        memory.write_all_at(NAME_PREFIX.as_bytes(), address)?;
    }
    Ok(())
}
