//! The program `timegap-studies`: `timegap` with its studies.

use std::process::ExitCode;

fn main() -> ExitCode {
    timegap_command::main()
}
