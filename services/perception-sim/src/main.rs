//! The traffic and radar as a program of its own: `timegap run --service perception-sim=PROGRAM`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    runtime::run_service(messages::Service::PerceptionSim, &arguments, perception_sim::run)
}
