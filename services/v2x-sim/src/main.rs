//! The roadside unit as a program of its own: `timegap run --service v2x-sim=PROGRAM`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    runtime::run_service(messages::Service::V2xSim, &arguments, v2x_sim::run)
}
