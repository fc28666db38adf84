//! The command under test: `timegap` with its studies, and with an allocator that counts.

#[cfg(feature = "count-allocations")]
mod allocations;

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(feature = "count-allocations")]
    allocations::report();
    timegap_command::main()
}
