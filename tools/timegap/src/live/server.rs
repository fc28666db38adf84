//! `--serve`: the run in browsers of this machine.
//!
//! A token begins both paths: `/TOKEN/` is the page, `/TOKEN/events` the stream of frames (server-sent
//! events). The server listens on the loopback interface and answers only requests that name it. So no page of another
//! origin can read along. The token keeps other users of this machine out.
//!
//! A browser cannot hold the run up. [`MAX_CLIENTS`], [`BACKLOG`] and the limits of [`super::http`] bound it. All
//! connections are closed [`END_PATIENCE`] after the run.

use super::feed::{Frame, Update};
use super::history::WINDOW_S;
use super::http::{Request, begin_events, receive, respond};
use group::{Failure, Status};
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The page, with the report's colours.
const PAGE: &str = include_str!("page.html");
/// Most browsers at once.
const MAX_CLIENTS: usize = 16;
/// Messages that wait for one browser; a slower one is disconnected.
const BACKLOG: usize = 4096;
/// Time after the end of the run in which browsers get the rest.
const END_PATIENCE: Duration = Duration::from_secs(2);
/// Bytes of the token.
const TOKEN_BYTES: usize = 16;

/// A port that cannot be served.
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
    /// Its address.
    pub address: SocketAddr,
    token: Arc<str>,
    feeder: JoinHandle<()>,
}

/// State that all threads of a server share.
#[derive(Default)]
struct Hub {
    /// Newest frames as messages with their run time, for browsers that connect late.
    past: VecDeque<(f64, Arc<str>)>,
    clients: Vec<SyncSender<Arc<str>>>,
    threads: Vec<(JoinHandle<()>, TcpStream)>,
    over: bool,
}

impl Server {
    /// Listens on `port` of the loopback interface; 0 takes any that is free. `ground` is what the view from above
    /// stands on, as JSON.
    pub fn start(
        title: &str,
        ground: &str,
        port: u16,
        updates: Receiver<Update>,
    ) -> Result<Self, ServeError> {
        let failed = |reason| ServeError { port, reason };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let hub = Arc::new(Mutex::new(Hub::default()));
        let token = token().map_err(failed)?;
        let served = Served { page: page(title, ground).into(), token: Arc::clone(&token) };
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

    /// Waits until every browser was informed of the run's end, is gone, or was too slow.
    pub fn finish(self) {
        // A panic was reported where it happened.
        let _ = self.feeder.join();
    }
}

/// The page, and the token that opens it.
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
        // A thread that waits for its browser gets an error and ends.
        let _ = stream.shutdown(Shutdown::Both);
        drop(thread.join());
    }
}

fn lock(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

fn page(title: &str, ground: &str) -> String {
    PAGE.replace("WINDOW_S", &WINDOW_S.to_string())
        .replace("TITLE", &report::chart::escape(title))
        .replace("/*STYLE*/", &report::html::style())
        .replace("/*SCRIPTS*/", &(report::html::scripts() + &report::html::plane_script()))
        .replace("/*GROUND*/null", ground)
}

/// Passes the updates to all clients until the run is over.
fn feed(hub: &Mutex<Hub>, updates: &Receiver<Update>) {
    let mut how: Arc<str> = "the run was interrupted".into();
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
        // A minute is 600 frames in realtime. A run whose time stands still keeps no more than this.
        while self.past.len() > BACKLOG / 2 {
            self.past.pop_front();
        }
    }

    fn send(&mut self, message: &Arc<str>) {
        self.clients.retain(|client| client.try_send(Arc::clone(message)).is_ok());
    }
}

/// Starts a connection's thread; false if the machine has no thread left.
fn admit(hub: &Arc<Mutex<Hub>>, stream: TcpStream, served: &Served) -> bool {
    let mut shared = lock(hub);
    shared.threads.retain(|(thread, _)| !thread.is_finished());
    if shared.threads.len() >= MAX_CLIENTS {
        // Too many: dropping the stream closes it.
        return true;
    }
    let Ok(handle) = stream.try_clone() else { return false };
    let (hub, served) = (Arc::clone(hub), served.clone());
    let thread = std::thread::Builder::new().name("browser".into());
    let thread = thread.spawn(move || {
        // A closed browser is not an error.
        let _ = answer(&hub, &stream, &served);
        // The second handle, which disconnects a slow browser, would keep it open.
        let _ = stream.shutdown(Shutdown::Both);
    });
    let Ok(thread) = thread else { return false };
    shared.threads.push((thread, handle));
    true
}

/// Answers one request.
fn answer(hub: &Mutex<Hub>, stream: &TcpStream, served: &Served) -> std::io::Result<()> {
    let Some(Request { path, host, body }) = receive(stream)? else { return Ok(()) };
    let is_local = matches!(host.as_deref(), Some("127.0.0.1" | "localhost"));
    let below = path.strip_prefix('/').and_then(|path| path.strip_prefix(&*served.token));
    match below.filter(|_| is_local) {
        Some("/") => respond(stream, "200 OK", "text/html; charset=utf-8", &served.page, body),
        Some("/events") if body => stream_events(hub, stream),
        Some("/events") => respond(stream, "200 OK", "text/event-stream", "", body),
        _ => {
            let text = "open the whole address that the run printed\n";
            respond(stream, "403 Forbidden", "text/plain", text, body)
        }
    }
}

fn stream_events(hub: &Mutex<Hub>, mut stream: &TcpStream) -> std::io::Result<()> {
    let (sender, messages) = sync_channel(BACKLOG);
    {
        let mut hub = lock(hub);
        for (_, message) in &hub.past {
            // The channel has room for the whole past.
            let _ = sender.try_send(Arc::clone(message));
        }
        // After the end of the run the channel closes here: the past is all there is to send.
        if hub.over { drop(sender) } else { hub.clients.push(sender) }
    }
    begin_events(stream)?;
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
        let server = Server::start("a <run>", "null", 0, updates).expect("a free port");
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
    fn a_head_has_no_body_and_other_methods_learn_what_is_answered() {
        let (_sender, updates) = sync_channel(1);
        let server = Server::start("a <run>", "null", 0, updates).expect("a free port");
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
    fn a_request_that_is_too_long_is_refused() {
        let (_sender, updates) = sync_channel(1);
        let server = Server::start("a run", "null", 0, updates).expect("a free port");
        let answer = get(server.address, "/", &"x".repeat(20 * crate::live::http::MAX_REQUEST));
        assert!(answer.starts_with("HTTP/1.1 431 "), "{answer}");
    }

    #[test]
    fn the_page_needs_nothing_else_and_is_for_this_machine_only() {
        let (sender, updates) = sync_channel(1);
        let server = Server::start("a <run>", "null", 0, updates).expect("a free port");
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
        // The stream of an interrupted run just ends.
        drop(sender);
        server.finish();
    }

    #[test]
    fn slow_clients_do_not_hold_up_the_end() {
        let (sender, updates) = sync_channel(1);
        let server = Server::start("run", "null", 0, updates).expect("a free port");
        // One never ends its request, one takes no events.
        let mut slow = TcpStream::connect(server.address).expect("it listens");
        slow.write_all(b"GET / HT").expect("it reads");
        let mut deaf = TcpStream::connect(server.address).expect("it listens");
        write!(deaf, "GET /{}/events HTTP/1.1\r\nHost: localhost\r\n\r\n", server.token)
            .expect("it reads");
        sender.send(Update::Ended("completed".into())).expect("it listens");
        // Both clients stay until the server has closed them.
        server.finish();
        let mut rest = Vec::new();
        let _ = slow.read_to_end(&mut rest);
        assert!(rest.is_empty(), "it was answered without a whole request");
        drop(deaf);
    }
}
