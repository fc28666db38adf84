//! The server: its port, and the messages that wait for its viewers in one queue.
//!
//! ```text
//! run ─► newest 16 MiB of messages ─┬─► viewer: its place among them, its subscriptions
//!                                   └─► viewer
//! ```

use crate::protocol::Subject;
use crate::viewer::{self, Hub, lock, report};
use std::collections::BTreeMap;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Most viewers at a time, those that only connect included.
const MOST_VIEWERS: usize = 16;

/// A server on 127.0.0.1. Viewers come and go; sending never waits for one.
#[derive(Debug)]
pub struct Server {
    port: u16,
    hub: Arc<Mutex<Hub>>,
}

impl Server {
    /// Opens the port, any free one for 0.
    ///
    /// # Errors
    /// If the port is taken, or a thread cannot be started.
    pub fn open(port: u16, subject: Subject) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let port = listener.local_addr()?.port();
        let hub: Arc<Mutex<Hub>> = Arc::default();
        let (own, subject) = (Arc::clone(&hub), Arc::new(subject));
        std::thread::Builder::new().name("accept".into()).spawn(move || {
            for stream in listener.incoming() {
                match stream.and_then(|stream| Ok((stream.peer_addr()?, stream))) {
                    Ok((address, stream)) => welcome(stream, address, &own, &subject),
                    // Without a descriptor: the connection waits until there is one.
                    Err(_) => std::thread::sleep(Duration::from_millis(100)),
                }
            }
        })?;
        Ok(Self { port, hub })
    }

    pub fn port(&self) -> u16 {
        self.port
    }

    /// Hands a message of `channel` with its time, ns since 1970, to the viewers that subscribe to it. All
    /// of them show that time once they have what was sent.
    pub fn send(&self, channel: u16, unix_ns: u64, payload: &[u8]) {
        let mut hub = lock(&self.hub);
        hub.unix_ns = unix_ns;
        if hub.viewers.values().flat_map(BTreeMap::values).any(|of| *of == channel) {
            hub.put((channel, unix_ns, payload.to_vec()));
        }
    }

    /// True if a viewer subscribes to anything.
    pub fn is_watched(&self) -> bool {
        lock(&self.hub).viewers.values().any(|own| !own.is_empty())
    }

    /// Ends all connections with these words, and waits until the viewers have what was sent, or `waits` says no.
    pub fn end(&self, words: &str, waits: impl Fn() -> bool) {
        lock(&self.hub).end = Some(words.to_owned());
        while !lock(&self.hub).viewers.is_empty() && waits() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Takes in a connection, in a thread of its own.
fn welcome(stream: TcpStream, address: SocketAddr, hub: &Arc<Mutex<Hub>>, subject: &Arc<Subject>) {
    let mut open = lock(hub);
    if open.viewers.len() >= MOST_VIEWERS {
        return report(address, "refused", &format!("there are {MOST_VIEWERS} others"));
    }
    open.newest += 1;
    let id = open.newest;
    open.viewers.insert(id, BTreeMap::new());
    drop(open);
    let (own, subject) = (Arc::clone(hub), Arc::clone(subject));
    let serve = move || {
        viewer::serve(&stream, address, (id, &own), &subject);
        lock(&own).viewers.remove(&id);
    };
    if let Err(why) = std::thread::Builder::new().name("viewer".into()).spawn(serve) {
        lock(hub).viewers.remove(&id);
        report(address, "refused", &why.to_string());
    }
}
