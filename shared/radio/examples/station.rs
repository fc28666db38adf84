//! One end of a carrier without a vehicle, to try a link between two hosts.
//!
//! ```text
//! station ADDRESS vehicle                    prints a line for each received frame
//! station ADDRESS roadside [PERIOD_MS]       sends a frame every period, by default 20 ms
//! ```
//!
//! Both end with their standard input and print their counts as JSON. A vehicle with a configuration of `mode:
//! "router"` is a zenoh router.

use radio::{Carrier, Role, wall_clock_ns};
use scenario::carrier::CarrierAddress;
use std::error::Error;
use std::io::{Read, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    status(&arguments)
}

/// Runs a station and returns its exit status.
pub fn status(arguments: &[String]) -> ExitCode {
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let (address, role, period_ms) = match arguments {
        [address, role] => (address, role, 20),
        [address, role, period] => (address, role, period.parse()?),
        _ => return Err("expected ADDRESS and vehicle or roadside".into()),
    };
    let address: CarrierAddress = address.parse()?;
    let ended = until_input_ends();
    match role.as_str() {
        "vehicle" => listen(Carrier::open(&address, Role::Vehicle)?, &ended),
        "roadside" => {
            let role = Role::Roadside { start_ns: wall_clock_ns() };
            send(Carrier::open(&address, role)?, Duration::from_millis(period_ms), &ended)
        }
        other => Err(format!("`{other}` is not a role, expected vehicle or roadside").into()),
    }
}

fn until_input_ends() -> Arc<AtomicBool> {
    let ended = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&ended);
    std::thread::spawn(move || {
        // A broken input is an ended one.
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        seen.store(true, Ordering::Relaxed);
    });
    ended
}

fn listen(mut carrier: Carrier, ended: &AtomicBool) -> Result<(), Box<dyn Error>> {
    say("ready")?;
    while !ended.load(Ordering::Relaxed) {
        while let Some(frame) = carrier.receive(0) {
            match frame.travelled_ns() {
                Some((ns, uncertainty_ns)) => say(&format!(
                    "frame of {} bytes after {:.3} ms, known to {:.3} ms",
                    frame.bytes().len(),
                    ns as f64 / 1e6,
                    uncertainty_ns as f64 / 1e6
                ))?,
                None => say(&format!("frame of {} bytes", frame.bytes().len()))?,
            }
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    report(&carrier)
}

fn send(mut carrier: Carrier, period: Duration, ended: &AtomicBool) -> Result<(), Box<dyn Error>> {
    say("ready")?;
    let mut number: u32 = 0;
    while !ended.load(Ordering::Relaxed) {
        number = number.wrapping_add(1);
        // Unsent frames are counted.
        let _ = carrier.send(&[number.to_be_bytes().as_slice(), &[0x11; 130]].concat());
        std::thread::sleep(period);
    }
    report(&carrier)
}

fn report(carrier: &Carrier) -> Result<(), Box<dyn Error>> {
    say(&serde_json::to_string(&carrier.report())?)
}

fn say(line: &str) -> Result<(), Box<dyn Error>> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}")?;
    Ok(out.flush()?)
}
