//! The `timegap` command.

fn main() -> std::process::ExitCode {
    timegap::main()
}
