//! The emergency brake as a program of its own: `timegap run --service aebs=PROGRAM`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    runtime::run_service(messages::Service::Aebs, &arguments, aebs::run)
}
