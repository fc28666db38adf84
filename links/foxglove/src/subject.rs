//! The offer to viewers, and the line about one that is not served.

use crate::protocol::{self, Parameter};
use recorder::Channel;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Answers a request of the service; an error is for the viewer's user.
pub type Answer = Box<dyn Fn(&[u8]) -> Result<Vec<u8>, String> + Send + Sync>;

/// The offer to viewers.
pub struct Subject {
    /// Name of the server.
    pub name: String,
    /// Another one for each run: a viewer that comes back knows whether it sees the same run.
    pub session: String,
    /// Channels, by the numbers that their messages have.
    pub channels: Vec<Channel>,
    /// Values that do not change.
    pub parameters: Vec<Parameter>,
    /// The announcement of a service, and the function that answers.
    pub service: Option<(String, Answer)>,
}

impl Subject {
    /// Texts for a client that has connected.
    pub(crate) fn welcome(&self) -> Vec<String> {
        let info = protocol::server_info(&self.name, &self.session, self.service.is_some());
        let service = self.service.as_ref().map(|(announcement, _)| announcement.clone());
        let texts = [info, protocol::advertise(&self.channels)];
        texts.into_iter().chain(service).collect()
    }
}

/// Writes a line about a client, unless clients have given reason for many.
pub(crate) fn report(address: SocketAddr, what: &str, why: &str) {
    const MOST: usize = 10;
    static LINES: AtomicUsize = AtomicUsize::new(0);
    match LINES.fetch_add(1, Ordering::Relaxed) {
        line if line < MOST => tracing::warn!("viewer {address} was {what}: {why}"),
        MOST => tracing::warn!("no more lines about viewers"),
        _ => {}
    }
}
