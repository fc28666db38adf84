//! The queue of messages that all viewers share, and one viewer: a thread that hands them on and answers requests.

use crate::guard::{self, PATIENCE, Refusal};
use crate::protocol::{self, Asked, SERVICE, SUBPROTOCOLS, Subject, TIME};
use serde_json::json;
use std::collections::{BTreeMap, VecDeque};
use std::io::ErrorKind;
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tungstenite::error::ProtocolError;
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, WebSocketConfig};
use tungstenite::{Error, HandshakeError, Message, WebSocket, accept_hdr_with_config};

/// Silence of a client that connects after which it is dropped.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Longest wait for a question before the next look at what was sent.
const LOOK: Duration = Duration::from_millis(10);
/// Most messages that are handed on between two looks at its questions.
const MOST_AT_ONCE: u32 = 1_000;
/// Most subscriptions of a viewer.
const MOST_SUBSCRIPTIONS: usize = 100;
/// Longest message of a viewer, bytes.
const LONGEST: usize = 64 << 10;

/// Bytes and messages a second that are taken from a viewer, and the time for which it may be ahead of its rate.
const BYTES_PER_S: f64 = (1 << 20) as f64;
const MESSAGES_PER_S: f64 = 200.0;
const BURST: Duration = Duration::from_secs(2);

type Socket = WebSocket<TcpStream>;

/// Most bytes of messages that wait for viewers; beyond them the oldest are lost.
const MOST_WAITING: usize = 16 << 20;

/// A message on its way to viewers: its channel, its time in ns since 1970, its payload.
type Sent = (u16, u64, Vec<u8>);

/// All that the threads of a server share.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    sent: VecDeque<Sent>,
    bytes: usize,
    /// Messages that were dropped from the front of `sent`.
    dropped: u64,
    /// Viewers by their numbers: the channel of each subscription, by the number that the viewer gave it.
    pub(crate) viewers: BTreeMap<u64, BTreeMap<u32, u16>>,
    pub(crate) newest: u64,
    /// Time of the newest message, ns since 1970, in whatever channel.
    pub(crate) unix_ns: u64,
    /// The connections end with these words, when all else is written.
    pub(crate) end: Option<String>,
}

pub(crate) fn lock(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    pub(crate) fn put(&mut self, message: Sent) {
        self.bytes += size_of::<Sent>() + message.2.len();
        self.sent.push_back(message);
        while self.bytes > MOST_WAITING
            && let Some((_, _, payload)) = self.sent.pop_front()
        {
            self.bytes -= size_of::<Sent>() + payload.len();
            self.dropped += 1;
        }
    }

    /// Number of the message that is sent next.
    pub(crate) fn next(&self) -> u64 {
        self.dropped + self.sent.len() as u64
    }

    /// Message number `*next` in the viewer's words, once for each of its subscriptions, or `None` if it was not sent
    /// yet. `*next` moves on. True beside the words if messages before it are lost.
    pub(crate) fn take(&self, viewer: u64, next: &mut u64) -> Option<(bool, Vec<Vec<u8>>)> {
        let is_late = *next < self.dropped;
        *next = self.dropped.max(*next);
        let place = usize::try_from(*next - self.dropped).ok()?;
        let (channel, unix_ns, payload) = self.sent.get(place)?;
        *next += 1;
        let subscribed = self.viewers.get(&viewer)?.iter().filter(|(_, of)| *of == channel);
        let words = subscribed.map(|(id, _)| protocol::message_data(*id, *unix_ns, payload));
        Some((is_late, words.collect()))
    }
}

/// Writes a line about a viewer, unless viewers have given reason for many.
pub(crate) fn report(address: SocketAddr, what: &str, why: &str) {
    const MOST: usize = 10;
    static LINES: AtomicUsize = AtomicUsize::new(0);
    match LINES.fetch_add(1, Ordering::Relaxed) {
        line if line < MOST => tracing::warn!("viewer {address} was {what}: {why}"),
        MOST => tracing::warn!("no more lines about viewers"),
        _ => {}
    }
}

/// Serves a connection to its end. `id` is the viewer's number.
pub(crate) fn serve(
    stream: &TcpStream,
    address: SocketAddr,
    (id, hub): (u64, &Mutex<Hub>),
    subject: &Subject,
) {
    let next = lock(hub).next();
    let mut viewer = Viewer { id, hub, subject, address, next, shown_ns: 0, has_lost: false };
    let outcome = accept(stream).map_err(|why| ("refused", why)).and_then(|mut socket| {
        viewer.attend(&mut socket).map_err(|why| {
            close(&mut socket, &why.to_string());
            ("dropped", why)
        })
    });
    match outcome {
        Ok(()) | Err((_, Refusal::Gone)) => {}
        Err((what, why)) => report(address, what, &why.to_string()),
    }
    // It may be closed by now.
    let _ = stream.shutdown(Shutdown::Both);
}

/// Takes in a client of this user's, from a page that may look, in a protocol that both sides know.
fn accept(stream: &TcpStream) -> Result<Socket, Refusal> {
    guard::check_user(stream)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(HANDSHAKE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut refusal = None;
    #[expect(clippy::result_large_err, reason = "the handshake's own type")]
    let choose = |request: &Request, response: Response| {
        choose(request, response).map_err(|why| {
            let mut answer = ErrorResponse::new(Some(why.to_string()));
            *answer.status_mut() = StatusCode::FORBIDDEN;
            refusal = Some(why);
            answer
        })
    };
    let config =
        WebSocketConfig::default().max_message_size(Some(LONGEST)).max_frame_size(Some(LONGEST));
    let accepted = accept_hdr_with_config(stream.try_clone()?, choose, Some(config));
    let accepted = accepted.map_err(|error| match error {
        HandshakeError::Failure(error) => error.to_string(),
        HandshakeError::Interrupted(_) => "the client is silent".to_owned(),
    });
    let socket = accepted.map_err(|why| refusal.unwrap_or(Refusal::Handshake(why)))?;
    stream.set_read_timeout(Some(LOOK))?;
    Ok(socket)
}

fn choose(request: &Request, mut response: Response) -> Result<Response, Refusal> {
    const PROTOCOL: &str = "sec-websocket-protocol";
    let origin = request.headers().get("origin").map(|value| value.to_str().unwrap_or("?"));
    if !guard::is_trusted(origin) {
        return Err(Refusal::Origin(origin.unwrap_or("?").to_owned()));
    }
    let values = request.headers().get_all(PROTOCOL).iter().filter_map(|value| value.to_str().ok());
    let offered: Vec<&str> = values.flat_map(|value| value.split(',')).map(str::trim).collect();
    let chosen = SUBPROTOCOLS.iter().find(|known| offered.contains(known));
    let chosen = HeaderValue::from_static(chosen.ok_or(Refusal::Subprotocol)?);
    response.headers_mut().insert(PROTOCOL, chosen);
    Ok(response)
}

/// Ends a connection with these words; it may be gone.
fn close(socket: &mut Socket, words: &str) {
    // A close frame has room for 123 bytes.
    let reason: String = words.chars().filter(char::is_ascii).take(120).collect();
    let _ = socket.close(Some(CloseFrame { code: CloseCode::Away, reason: reason.into() }));
    let _ = socket.flush();
}

fn send(socket: &mut Socket, message: impl Into<Message>) -> Result<(), Refusal> {
    socket.send(message.into()).map_err(|error| match error {
        Error::Io(error) if error.kind() == ErrorKind::WouldBlock => Refusal::Deaf,
        _ => Refusal::Gone,
    })
}

struct Viewer<'a> {
    id: u64,
    hub: &'a Mutex<Hub>,
    subject: &'a Subject,
    address: SocketAddr,
    /// Number of the message that it gets next.
    next: u64,
    /// Time that it shows, ns since 1970.
    shown_ns: u64,
    /// Messages were lost since it last had all.
    has_lost: bool,
}

impl Viewer<'_> {
    /// Serves the viewer until it leaves or the server ends.
    fn attend(&mut self, socket: &mut Socket) -> Result<(), Refusal> {
        for text in self.subject.welcome() {
            send(socket, text)?;
        }
        let (mut level, mut is_slowed) = (Instant::now(), false);
        loop {
            if self.hand_on(socket)? {
                return Ok(());
            }
            let read = socket.read();
            let bytes = read.as_ref().map_or(0, Message::len);
            match read {
                Ok(Message::Text(text)) => self.take_text(&text, socket)?,
                Ok(Message::Binary(bytes)) => self.take_binary(&bytes, socket)?,
                // The next write answers a ping.
                Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => {}
                Ok(Message::Close(_)) => {
                    close(socket, "as asked");
                    return Ok(());
                }
                Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => continue,
                // A viewer that dies takes no leave.
                Err(
                    Error::ConnectionClosed
                    | Error::Io(_)
                    | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake),
                ) => return Err(Refusal::Gone),
                Err(error) => return Err(Refusal::Protocol(Box::new(error))),
            }
            let wait = ahead(&mut level, bytes, Instant::now());
            // The client notices it as a connection that takes no more.
            std::thread::sleep(wait);
            if !wait.is_zero() && !std::mem::replace(&mut is_slowed, true) {
                report(self.address, "slowed down", "it asks too often");
            }
        }
    }

    /// Hands on what waits for the viewer; true if the server ends. A slow viewer is asked in between.
    fn hand_on(&mut self, socket: &mut Socket) -> Result<bool, Refusal> {
        for _ in 0..MOST_AT_ONCE {
            let hub = lock(self.hub);
            let Some((is_late, messages)) = hub.take(self.id, &mut self.next) else {
                self.has_lost = false;
                let (end, unix_ns) = (hub.end.clone(), hub.unix_ns);
                drop(hub);
                if std::mem::replace(&mut self.shown_ns, unix_ns) != unix_ns {
                    send(socket, [&[TIME], &unix_ns.to_le_bytes()[..]].concat())?;
                }
                end.iter().for_each(|words| close(socket, words));
                return Ok(end.is_some());
            };
            drop(hub);
            if is_late && !std::mem::replace(&mut self.has_lost, true) {
                let text = "messages are lost: they come faster than they are read";
                send(socket, protocol::status(text))?;
            }
            messages.into_iter().try_for_each(|message| send(socket, message))?;
        }
        Ok(false)
    }

    fn take_text(&self, text: &str, socket: &mut Socket) -> Result<(), Refusal> {
        let all = &self.subject.parameters;
        let asked: Asked = serde_json::from_str(text)?;
        match asked.op.as_str() {
            "subscribe" => asked.subscriptions.iter().try_for_each(|one| {
                if usize::from(one.channel_id) >= self.subject.channels.len() {
                    let text = format!("there is no channel {}", one.channel_id);
                    return send(socket, protocol::status(&text));
                }
                let mut hub = lock(self.hub);
                let own = hub.viewers.entry(self.id).or_default();
                own.insert(one.id, one.channel_id);
                if own.len() > MOST_SUBSCRIPTIONS { Err(Refusal::Subscriptions) } else { Ok(()) }
            }),
            "unsubscribe" => {
                let mut hub = lock(self.hub);
                let own = hub.viewers.entry(self.id).or_default();
                own.retain(|id, _| !asked.subscription_ids.contains(id));
                Ok(())
            }
            "getParameters" => send(socket, protocol::parameter_values(all, &asked)),
            "setParameters" => {
                send(socket, protocol::status("the keys of a run are fixed when it starts"))?;
                send(socket, protocol::parameter_values(all, &asked))
            }
            // A request of a part of the protocol that this server does not offer.
            _ => Ok(()),
        }
    }

    fn take_binary(&self, bytes: &[u8], socket: &mut Socket) -> Result<(), Refusal> {
        let (service, call, encoding, request) = protocol::call(bytes).ok_or(Refusal::Binary)?;
        let answered = match &self.subject.service {
            Some((_, answer)) if service == SERVICE && encoding == b"json" => answer(request),
            Some(_) if service == SERVICE => Err("expected a request in JSON".to_owned()),
            _ => Err(format!("there is no service {service}")),
        };
        match answered {
            Ok(response) => send(socket, protocol::service_response(call, &response)),
            Err(why) => {
                let op = "serviceCallFailure";
                let failure =
                    json!({ "op": op, "serviceId": SERVICE, "callId": call, "message": why });
                send(socket, failure.to_string())
            }
        }
    }
}

/// Time to wait after a message of `bytes` that came at `now`. The rate alone would have reached all so far at `level`.
fn ahead(level: &mut Instant, bytes: usize, now: Instant) -> Duration {
    let cost_s = bytes as f64 / BYTES_PER_S + 1.0 / MESSAGES_PER_S;
    *level = (*level).max(now) + Duration::from_secs_f64(cost_s);
    level.saturating_duration_since(now + BURST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_without_content_fill_the_queue_no_further_than_others_do() {
        let mut hub = Hub::default();
        (0..1_000_000).for_each(|unix_ns| hub.put((0, unix_ns, Vec::new())));
        assert!(hub.sent.len() < 500_000 && hub.next() == 1_000_000, "{}", hub.sent.len());
    }

    #[test]
    fn a_burst_is_free_and_a_flood_is_slowed_to_the_rate() {
        let now = Instant::now();
        let mut level = now;
        let few = (0..300).map(|_| ahead(&mut level, 0, now)).max();
        assert_eq!(few, Some(Duration::ZERO), "1.5 s of messages");
        let wait = (0..400).map(|_| ahead(&mut level, 0, now)).max().expect("a flood");
        assert!((1.4..1.6).contains(&wait.as_secs_f64()), "3.5 s of messages: {wait:?}");
        let later = now + Duration::from_secs(60);
        assert_eq!(ahead(&mut level, 0, later), Duration::ZERO, "the debt is over");
        let wait = ahead(&mut level, 3 << 20, later);
        assert!((0.9..1.1).contains(&wait.as_secs_f64()), "3 s of bytes: {wait:?}");
    }
}
