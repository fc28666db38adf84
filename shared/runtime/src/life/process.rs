//! A service as a process.

use crate::life::prepared::{self, PREPARED};
use crate::{FromService, Runtime, RuntimeError};
use messages::Service;
use std::path::Path;
use std::process::ExitCode;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

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
    let (root, incarnation, is_prepared) = match arguments {
        [root, incarnation] if incarnation.parse::<u32>().is_ok() => (root, incarnation, false),
        [root, incarnation, last] if incarnation.parse::<u32>().is_ok() && last == PREPARED => {
            (root, incarnation, true)
        }
        _ => {
            eprintln!("{service} is a service of timegap: start it with `timegap run`");
            return ExitCode::from(2);
        }
    };
    let incarnation = incarnation.parse().expect("checked above");
    log_warnings();
    let root = Path::new(root);
    let joined = match is_prepared {
        true => Runtime::join_when(service, root, incarnation, prepared::wait),
        false => Runtime::join(service, root, incarnation),
    };
    match joined.and_then(run) {
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
