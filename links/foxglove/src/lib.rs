//! A run or a recording, live in Foxglove (or another viewer that speaks its WebSocket protocol).
//!
//! ```text
//!   topics ─► taps ─► encoder ─► server: newest messages ─┬─► viewer's thread ◄─► viewer
//!   (shared memory)  (as in a file)                       └─► viewer's thread ◄─► viewer
//!   supervisor ◄──────────────── faults ◄─────────────────────────┘
//! ```
//!
//! The bridge is a process of its own beside the recorder. No sender waits for it: it misses what it does not take in
//! time. Messages wait for viewers in a queue of bounded size, which loses its oldest. So neither the bridge nor a viewer
//! can hold up a control loop, whatever becomes of them.
//!
//! The server listens on 127.0.0.1 alone. A viewer must be a process of the same user ([`guard`]), and a web page must
//! come from Foxglove or from this machine.
//!
//! * [`Server`]: the protocol
//! * [`run`]: the bridge of a group, which the supervisor starts
//! * [`serve`]: the bridge of a run in progress, or of a recording

mod guard;
mod inject;
mod live;
mod protocol;
mod server;
mod viewer;

pub use live::{run, serve};
pub use protocol::{Answer, Parameter, Subject};
pub use server::Server;

use supervise::UsageError;

/// Port at which Foxglove looks first.
const USUAL_PORT: &str = "8765";

/// Reads `foxglove[:PORT]`, the value of `option`; port 0 is any free one.
///
/// # Errors
/// If it is another viewer or no port.
///
/// ```
/// assert_eq!(foxglove_bridge::port("--bridge", "foxglove"), Ok(8765));
/// assert_eq!(foxglove_bridge::port("--bridge", "foxglove:9000"), Ok(9000));
/// let error = foxglove_bridge::port("--bridge", "foxglove:http").unwrap_err().to_string();
/// assert_eq!(error, "--bridge foxglove:http: `http` is not a port, expected a number from 0 to 65535");
/// ```
pub fn port(option: &str, viewer: &str) -> Result<u16, UsageError> {
    let (name, port) = viewer.split_once(':').unwrap_or((viewer, USUAL_PORT));
    if name != "foxglove" {
        let why = format_args!("there is no viewer `{name}`");
        return Err(UsageError::option(option, viewer, why, "foxglove[:PORT]"));
    }
    let why = format_args!("`{port}` is not a port");
    let refuse = |_| UsageError::option(option, viewer, why, "a number from 0 to 65535");
    port.parse().map_err(refuse)
}
