//! Who may look: processes of this user, and pages that Foxglove or this machine serves.
//!
//! Any process of the machine can open a port of 127.0.0.1, and so can any page in a browser. A viewer can inject
//! faults, and so both are checked.

use crate::protocol::SUBPROTOCOLS;
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;
use std::{fs, io};

/// Time without room in a viewer's connection after which it is dropped.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

/// Reason why a client is refused or dropped.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Refusal {
    #[error("it is gone")]
    Gone,
    #[error("it belongs to user {0}, expected user {1}")]
    User(u32, u32),
    #[error("its page is from {0:?}, expected foxglove.dev or this machine")]
    Origin(String),
    #[error("no known subprotocol, expected {}", SUBPROTOCOLS.join(" or "))]
    Subprotocol,
    #[error("no WebSocket handshake: {0}")]
    Handshake(String),
    #[error("it reads nothing for {} s", PATIENCE.as_secs())]
    Deaf,
    #[error("it subscribes too often")]
    Subscriptions,
    #[error("not the protocol's JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("a binary message that is no call of a service")]
    Binary,
    #[error(transparent)]
    Protocol(Box<tungstenite::Error>),
    #[error(transparent)]
    System(#[from] io::Error),
}

/// Checks the user of the process at the other end. Root may do everything.
///
/// # Errors
/// [`Refusal::User`], or [`Refusal::Gone`].
pub(crate) fn check_user(stream: &TcpStream) -> Result<(), Refusal> {
    let (peer, local) = (stream.peer_addr()?, stream.local_addr()?);
    let tables = ["/proc/self/net/tcp", "/proc/self/net/tcp6"].map(fs::read_to_string);
    let own = rustix::process::getuid().as_raw();
    match tables.iter().flatten().find_map(|table| user_of(table, peer, local)) {
        Some(user) if user != own && user != 0 => Err(Refusal::User(user, own)),
        None if tables.iter().any(Result::is_ok) => Err(Refusal::Gone),
        // A sandbox without these tables has no other users.
        Some(_) | None => Ok(()),
    }
}

/// User whose socket `from` is connected to `to`, by the kernel's table. A socket for IPv6 has the IPv4 address at the
/// end of its own.
fn user_of(table: &str, from: SocketAddr, to: SocketAddr) -> Option<u32> {
    let (SocketAddr::V4(from), SocketAddr::V4(to)) = (from, to) else { return None };
    let [from, to] = [from, to]
        .map(|v4| format!("{:08X}:{:04X}", u32::from_ne_bytes(v4.ip().octets()), v4.port()));
    table.lines().find_map(|line| {
        let mut words = line.split_whitespace().skip(1);
        let ends = words.next()?.ends_with(&from) && words.next()?.ends_with(&to);
        ends.then(|| words.nth(4)?.parse().ok()).flatten()
    })
}

/// True for a request without an origin, which is not a browser's, and for one from a page that may look.
pub(crate) fn is_trusted(origin: Option<&str>) -> bool {
    let Some(origin) = origin else { return true };
    let Some((scheme, host)) = origin.split_once("://") else { return false };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.parse::<u16>().is_ok() => name,
        _ => host,
    };
    match scheme {
        // The desktop programs' pages are files.
        "file" => host.is_empty(),
        "https" if name == "foxglove.dev" || name.ends_with(".foxglove.dev") => true,
        "http" | "https" => ["localhost", "127.0.0.1", "[::1]"].contains(&name),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_others_are_not_trusted() {
        let trusted = [
            "https://app.foxglove.dev",
            "https://foxglove.dev",
            "http://localhost:8080",
            "http://127.0.0.1",
            "http://[::1]:3000",
            "file://",
        ];
        trusted.iter().for_each(|origin| assert!(is_trusted(Some(origin)), "{origin}"));
        assert!(is_trusted(None), "not a browser");
        for origin in [
            "null",
            "",
            "https://example.org",
            "https://foxglove.dev.example.org",
            "https://notfoxglove.dev",
            "http://app.foxglove.dev",
            "http://localhost.example.org",
            "http://127.0.0.1.example.org:8765",
            "file://elsewhere",
        ] {
            assert!(!is_trusted(Some(origin)), "{origin}");
        }
    }

    #[test]
    fn the_kernels_table_has_the_user_of_a_connection() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n   \
            1: 0100007F:A1B2 0100007F:223D 01 00000000:00000000 00:00000000 00000000  1000  0 77 1\n";
        let [from, to] = ["127.0.0.1:41394", "127.0.0.1:8765"].map(|a| a.parse().expect("one"));
        assert_eq!(user_of(table, from, to), cfg!(target_endian = "little").then_some(1000));
        assert_eq!(user_of(table, to, from), None);
        let mapped = table.replace("0100007F:", "0000000000000000FFFF00000100007F:");
        assert_eq!(user_of(&mapped, from, to), user_of(table, from, to));
    }
}
