//! The plant as a program of its own: `timegap run --service plant=PROGRAM`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    runtime::run_service(messages::Service::Plant, &arguments, plant::run)
}
