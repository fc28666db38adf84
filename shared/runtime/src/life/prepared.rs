//! A process that is started ahead. It has loaded its libraries and read the scenario. It opens its ports when the
//! process before it is gone.
//!
//! Until then it is not a service, and cannot be found under a service's name. Its own name has another beginning,
//! which it replaces in its own memory.

use crate::RuntimeError;
use crate::life::link::Link;
use std::fs::OpenOptions;
use std::os::unix::fs::FileExt;

/// The last argument of a process that is started ahead.
pub const PREPARED: &str = "prepared";
/// Beginning of the name of a service's process.
pub const NAME_PREFIX: &str = "timegap-";
/// Beginning of the name of a process that is started ahead.
pub const PREPARED_PREFIX: &str = "prepare-";

// One takes the place of the other.
const _: () = assert!(NAME_PREFIX.len() == PREPARED_PREFIX.len());

/// Field of `/proc/self/stat` with the address of the arguments, counted from the one behind the name.
const ARGUMENTS_FIELD: usize = 45;

/// Waits until the launcher lets this process into the run.
pub(crate) fn wait(link: &Link) -> Result<(), RuntimeError> {
    link.wait_to_join()?;
    // Only `ps` shows the name.
    let _ = take_name();
    Ok(())
}

/// Writes the beginning of a service's name over that of this process.
fn take_name() -> std::io::Result<()> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let address = fields.into_iter().nth(ARGUMENTS_FIELD).and_then(|field| field.parse().ok());
    let address: u64 = address.ok_or(std::io::ErrorKind::InvalidData)?;
    let memory = OpenOptions::new().read(true).write(true).open("/proc/self/mem")?;
    let mut name = [0; PREPARED_PREFIX.len()];
    memory.read_exact_at(&mut name, address)?;
    if name == *PREPARED_PREFIX.as_bytes() {
        memory.write_all_at(NAME_PREFIX.as_bytes(), address)?;
    }
    Ok(())
}
