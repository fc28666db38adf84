//! `--serve`: the run in browsers of this machine.
//!
//! Two paths below a token: `/TOKEN/` is the page, `/TOKEN/events` the stream of frames (server-sent
//! events). Only the loopback interface is listened on, only requests that name it are answered, so that
//! no page of another origin can read along, and the token keeps other users of this machine out.
//!
//! Written by hand, since it is less than a library's configuration: two answers, no keep-alive, no
//! bodies. Everything a client could hold up is bounded: a request by [`REQUEST_TIME`] and
//! [`MAX_REQUEST`], clients by [`MAX_CLIENTS`], what waits for one by [`BACKLOG`], and the end of the run
//! by [`END_PATIENCE`], after which all connections are closed.

use super::feed::{Frame, Update};
use super::history::WINDOW_S;
use group::{Failure, Status};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The page, with the report's colours.
const PAGE: &str = include_str!("page.html");
/// Most browsers at once.
const MAX_CLIENTS: usize = 16;
/// Messages that wait for one browser; one that is slower is let go.
const BACKLOG: usize = 4096;
/// Longest request that is read, bytes.
const MAX_REQUEST: usize = 8192;
/// Most of the rest of a longer one that is taken before the connection is closed, bytes.
const MAX_DRAINED: usize = 1 << 20;
/// Time for a whole request.
const REQUEST_TIME: Duration = Duration::from_secs(2);
/// A browser that takes nothing for so long is let go.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time after the end of the run in which browsers get the rest.
const END_PATIENCE: Duration = Duration::from_secs(2);
/// Bytes of the token.
const TOKEN_BYTES: usize = 16;

/// The port cannot be served.
#[derive(Debug, thiserror::Error)]
#[error("cannot serve 127.0.0.1:{port}: {reason}")]
pub struct ServeError {
    port: u16,
    #[source]
    reason: std::io::Error,
}

impl Failure for ServeError {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// A served run.
pub struct Server {
    /// Where it is.
    pub address: SocketAddr,
    token: Arc<str>,
    feeder: JoinHandle<()>,
}

/// What all threads of a server share.
#[derive(Default)]
struct Hub {
    /// Newest frames as messages with their run time, for those who come late.
    past: VecDeque<(f64, Arc<str>)>,
    clients: Vec<SyncSender<Arc<str>>>,
    threads: Vec<(JoinHandle<()>, TcpStream)>,
    over: bool,
}

impl Server {
    /// Listens on `port` of the loopback interface; 0 takes any that is free.
    pub fn start(title: &str, port: u16, updates: Receiver<Update>) -> Result<Self, ServeError> {
        let failed = |reason| ServeError { port, reason };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let hub = Arc::new(Mutex::new(Hub::default()));
        let token = token().map_err(failed)?;
        let served = Served { page: page(title).into(), token: Arc::clone(&token) };
        let accepting = Arc::clone(&hub);
        let acceptor = std::thread::Builder::new().name("serve".into()).spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                if lock(&accepting).over || !admit(&accepting, stream, &served) {
                    return;
                }
            }
        });
        let acceptor = acceptor.map_err(failed)?;
        let feeder = std::thread::Builder::new().name("serve-feed".into());
        let feeder = feeder.spawn(move || {
            feed(&hub, &updates);
            // Wakes the acceptor, which then sees that it is over.
            let _ = TcpStream::connect(address);
            let _ = acceptor.join();
            let threads = std::mem::take(&mut lock(&hub).threads);
            close(threads);
        });
        Ok(Self { address, token, feeder: feeder.map_err(failed)? })
    }

    /// Its address with the token.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }

    /// Waits until every browser knows that the run is over, is gone, or was too slow.
    pub fn finish(self) {
        // A panic of it has been told where it happened.
        let _ = self.feeder.join();
    }
}

/// What is served, and to whom.
#[derive(Clone)]
struct Served {
    page: Arc<str>,
    token: Arc<str>,
}

/// Random digits, new for each run.
fn token() -> std::io::Result<Arc<str>> {
    let mut bytes = [0; TOKEN_BYTES];
    std::fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>().into())
}

/// Waits for the browsers' threads, and closes the connections of those that take too long.
fn close(threads: Vec<(JoinHandle<()>, TcpStream)>) {
    let begun = Instant::now();
    while begun.elapsed() < END_PATIENCE && threads.iter().any(|(thread, _)| !thread.is_finished())
    {
        std::thread::sleep(Duration::from_millis(1));
    }
    for (thread, stream) in threads {
        // A thread that waits for its browser gets an error.
        let _ = stream.shutdown(Shutdown::Both);
        drop(thread.join());
    }
}

fn lock(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

fn page(title: &str) -> String {
    PAGE.replace("WINDOW_S", &WINDOW_S.to_string())
        .replace("TITLE", &report::chart::escape(title))
        .replace("/*STYLE*/", &report::html::style())
        .replace("/*SCRIPTS*/", &report::html::scripts())
}

/// Hands the updates to all clients until the run is over.
fn feed(hub: &Mutex<Hub>, updates: &Receiver<Update>) {
    let mut how: Arc<str> = "the run was broken off".into();
    for update in updates {
        match update {
            Update::Frame(frame) => lock(hub).broadcast(&frame),
            Update::Ended(ending) => {
                how = ending;
                break;
            }
        }
    }
    let mut hub = lock(hub);
    let text = serde_json::to_string(&*how).expect("a text is plain data");
    hub.send(&format!("event: end\ndata: {text}\n\n").into());
    hub.over = true;
    // Their threads write the rest and end.
    hub.clients.clear();
}

impl Hub {
    fn broadcast(&mut self, frame: &Frame) {
        let json = serde_json::to_string(frame).expect("a frame is plain data");
        let message: Arc<str> = format!("data: {json}\n\n").into();
        self.send(&message);
        while self.past.front().is_some_and(|(time_s, _)| *time_s < frame.time_s - WINDOW_S) {
            self.past.pop_front();
        }
        self.past.push_back((frame.time_s, message));
        // A minute is 600 frames in realtime; a run whose time stands still keeps no more.
        while self.past.len() > BACKLOG / 2 {
            self.past.pop_front();
        }
    }

    fn send(&mut self, message: &Arc<str>) {
        self.clients.retain(|client| client.try_send(Arc::clone(message)).is_ok());
    }
}

/// Gives a connection a thread; false when none can be had.
fn admit(hub: &Arc<Mutex<Hub>>, stream: TcpStream, served: &Served) -> bool {
    let mut shared = lock(hub);
    shared.threads.retain(|(thread, _)| !thread.is_finished());
    if shared.threads.len() >= MAX_CLIENTS {
        // Too many: the connection closes.
        return true;
    }
    let Ok(handle) = stream.try_clone() else { return false };
    let (hub, served) = (Arc::clone(hub), served.clone());
    let thread = std::thread::Builder::new().name("browser".into());
    let thread = thread.spawn(move || {
        // A browser that went away is no error.
        let _ = answer(&hub, &stream, &served);
        // The other handle on it, by which a slow browser is let go, would keep it open.
        let _ = stream.shutdown(Shutdown::Both);
    });
    let Ok(thread) = thread else { return false };
    shared.threads.push((thread, handle));
    true
}

/// Reads a request up to the empty line that ends it; none when it is too long.
fn request(mut stream: &TcpStream) -> std::io::Result<Option<String>> {
    let begun = Instant::now();
    let (mut text, mut chunk) = (Vec::new(), [0; 1024]);
    while !text.windows(4).any(|end| end == b"\r\n\r\n") {
        let left = REQUEST_TIME.saturating_sub(begun.elapsed());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        if text.len() > MAX_REQUEST {
            return Ok(None);
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut chunk)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            count => text.extend_from_slice(&chunk[..count]),
        }
    }
    Ok(Some(String::from_utf8_lossy(&text).into_owned()))
}

/// Takes the rest of what was sent: a connection that is closed before takes the answer with it.
fn drain(mut stream: &TcpStream) -> std::io::Result<()> {
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut left = MAX_DRAINED;
    let mut chunk = [0; 4096];
    while left > 0 {
        match stream.read(&mut chunk)? {
            0 => return Ok(()),
            count => left = left.saturating_sub(count),
        }
    }
    Ok(())
}

/// Answers one request.
fn answer(hub: &Mutex<Hub>, stream: &TcpStream, served: &Served) -> std::io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    let Some(request) = request(stream)? else {
        let (status, text) = ("431 Request Header Fields Too Large", "the request is too long\n");
        respond(stream, status, "text/plain", text, Body::Sent)?;
        return drain(stream);
    };
    let mut lines = request.lines();
    let first = lines.next().unwrap_or_default();
    let host = lines
        .filter_map(|line| line.split_once(':'))
        .find_map(|(name, value)| name.eq_ignore_ascii_case("host").then(|| value.trim()));
    let host = host.map(|host| host.rsplit_once(':').map_or(host, |(host, _)| host));
    let local = host.is_some_and(|host| matches!(host, "127.0.0.1" | "localhost"));
    let mut words = first.split(' ');
    let (body, path) = match (words.next(), words.next()) {
        (Some("GET"), Some(path)) => (Body::Sent, path),
        (Some("HEAD"), Some(path)) => (Body::Left, path),
        _ => {
            let text = "only GET and HEAD are answered\n";
            return respond(stream, "405 Method Not Allowed", "text/plain", text, Body::Sent);
        }
    };
    let below = path.strip_prefix('/').and_then(|path| path.strip_prefix(&*served.token));
    match below {
        Some("/") if local => {
            respond(stream, "200 OK", "text/html; charset=utf-8", &served.page, body)
        }
        Some("/events") if local && body == Body::Sent => stream_events(hub, stream),
        Some("/events") if local => respond(stream, "200 OK", "text/event-stream", "", body),
        _ => {
            let text = "open the whole address that the run printed\n";
            respond(stream, "403 Forbidden", "text/plain", text, body)
        }
    }
}

/// Whether an answer has its text, or only says how long it would be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Body {
    Sent,
    Left,
}

fn respond(
    mut stream: &TcpStream,
    status: &str,
    kind: &str,
    text: &str,
    body: Body,
) -> std::io::Result<()> {
    let sent = if body == Body::Sent { text } else { "" };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
         Allow: GET, HEAD\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
         Content-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; \
         script-src 'unsafe-inline'; connect-src 'self'\r\nConnection: close\r\n\r\n{sent}",
        text.len()
    )?;
    stream.flush()
}

fn stream_events(hub: &Mutex<Hub>, mut stream: &TcpStream) -> std::io::Result<()> {
    let (sender, messages) = sync_channel(BACKLOG);
    {
        let mut hub = lock(hub);
        for (_, message) in &hub.past {
            // There is room for all of the past.
            let _ = sender.try_send(Arc::clone(message));
        }
        if hub.over {
            // What is left in the channel is the end of the stream.
            drop(sender);
        } else {
            hub.clients.push(sender);
        }
    }
    stream.write_all(
        b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
          Connection: close\r\n\r\n",
    )?;
    for message in messages {
        stream.write_all(message.as_bytes())?;
    }
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};

    fn get(address: SocketAddr, path: &str, host: &str) -> String {
        let mut stream = TcpStream::connect(address).expect("it listens");
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").expect("it reads");
        let mut text = String::new();
        stream.read_to_string(&mut text).expect("it answers and closes");
        text
    }

    fn frame(time_s: f64) -> Update {
        Update::Frame(Arc::new(Frame { time_s, ..Frame::default() }))
    }

    #[test]
    fn browsers_get_the_past_the_present_and_the_end() {
        let (sender, updates) = sync_channel(16);
        let server = Server::start("a <run>", 0, updates).expect("a free port");
        let (address, token) = (server.address, Arc::clone(&server.token));
        assert!(address.ip().is_loopback());
        sender.send(frame(0.5)).expect("it listens");
        let (seen, all_seen) = std::sync::mpsc::channel();
        let browsers: Vec<_> = (0..3)
            .map(|_| {
                let (seen, token) = (seen.clone(), Arc::clone(&token));
                std::thread::spawn(move || {
                    let mut stream = TcpStream::connect(address).expect("it listens");
                    write!(stream, "GET /{token}/events HTTP/1.1\r\nHost: localhost:1\r\n\r\n")
                        .expect("it reads");
                    let mut lines = BufReader::new(stream).lines().map_while(Result::ok);
                    let first = lines.find(|line| line.starts_with("data: ")).expect("a frame");
                    seen.send(()).expect("the test waits");
                    (first, lines.collect::<Vec<_>>())
                })
            })
            .collect();
        for _ in &browsers {
            all_seen.recv().expect("every browser sees the first frame");
        }
        sender.send(frame(1.5)).expect("it listens");
        sender.send(Update::Ended("completed".into())).expect("it listens");
        for browser in browsers {
            let (first, rest) = browser.join().expect("no panic");
            assert!(first.contains("\"time_s\":0.5"), "the past comes first: {first}");
            let at = |line: &str| rest.iter().position(|other| other.starts_with(line));
            let present = rest.iter().position(|line| line.contains("\"time_s\":1.5"));
            assert!(present.is_some() && present < at("event: end"), "{rest:?}");
            assert!(at("data: \"completed\"") > at("event: end"), "{rest:?}");
        }
        server.finish();
        assert!(TcpStream::connect(address).is_err(), "nothing is left");
    }

    #[test]
    fn a_head_has_no_body_and_other_methods_are_told_what_is_answered() {
        let (_sender, updates) = sync_channel(1);
        let server = Server::start("a <run>", 0, updates).expect("a free port");
        let answer_to = |method: &str, path: &str| {
            let mut stream = TcpStream::connect(server.address).expect("it listens");
            let path = format!("/{}/{path}", server.token);
            write!(stream, "{method} {path} HTTP/1.1\r\nHost: localhost\r\n\r\n")
                .expect("it reads");
            let mut text = String::new();
            stream.read_to_string(&mut text).expect("it answers and closes");
            text
        };
        let page = answer_to("GET", "");
        let head = answer_to("HEAD", "");
        assert!(head.ends_with("\r\n\r\n") && page.starts_with(&head), "{head}");
        assert!(answer_to("HEAD", "events").contains("text/event-stream"));
        let other = answer_to("POST", "");
        assert!(
            other.starts_with("HTTP/1.1 405 ") && other.contains("\r\nAllow: GET, HEAD\r\n"),
            "{other}"
        );
    }

    #[test]
    fn a_request_that_is_too_long_is_told_so() {
        let (_sender, updates) = sync_channel(1);
        let server = Server::start("a run", 0, updates).expect("a free port");
        let answer = get(server.address, "/", &"x".repeat(20 * MAX_REQUEST));
        assert!(answer.starts_with("HTTP/1.1 431 "), "{answer}");
    }

    #[test]
    fn the_page_needs_nothing_else_and_is_for_this_machine_only() {
        let (sender, updates) = sync_channel(1);
        let server = Server::start("a <run>", 0, updates).expect("a free port");
        let home = format!("/{}/", server.token);
        assert_eq!(server.url(), format!("http://{}{home}", server.address));
        let page = get(server.address, &home, "127.0.0.1:80");
        assert!(page.starts_with("HTTP/1.1 200") && page.contains("a &lt;run&gt;"), "{page}");
        for sign in ["http://", "https://", "@import", "src="] {
            assert!(!page.contains(sign), "{sign}");
        }
        let refused =
            |path: &str, host| get(server.address, path, host).starts_with("HTTP/1.1 403");
        assert!(refused(&home, "evil.example"), "another origin");
        assert!(refused("/", "localhost") && refused("/events", "localhost"), "no token");
        assert!(refused(&format!("{home}x"), "localhost"), "no such page");
        // A run that is broken off just ends.
        drop(sender);
        server.finish();
    }

    #[test]
    fn slow_clients_do_not_hold_up_the_end() {
        let (sender, updates) = sync_channel(1);
        let server = Server::start("run", 0, updates).expect("a free port");
        // One that never ends its request, and one that takes no events.
        let mut slow = TcpStream::connect(server.address).expect("it listens");
        slow.write_all(b"GET / HT").expect("it reads");
        let mut deaf = TcpStream::connect(server.address).expect("it listens");
        write!(deaf, "GET /{}/events HTTP/1.1\r\nHost: localhost\r\n\r\n", server.token)
            .expect("it reads");
        sender.send(Update::Ended("completed".into())).expect("it listens");
        // The watchdog is the test's own: both clients stay until the server has let them go.
        server.finish();
        let mut rest = Vec::new();
        let _ = slow.read_to_end(&mut rest);
        assert!(rest.is_empty(), "it was answered without a whole request");
        drop(deaf);
    }
}
