//! The program `timegap`.

use std::process::ExitCode;

fn main() -> ExitCode {
    timegap_command::main()
}
