//! One viewer: a thread that reads, a thread that writes, and a bounded queue before the writer.

use crate::guard::Refusal;
use crate::pace::{Pace, Reading};
use crate::protocol::{self, Asked, SERVICE};
use crate::subject::{Subject, report};
use std::collections::{BTreeMap, VecDeque};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tungstenite::error::ProtocolError;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

/// Most bytes of messages that wait for a viewer; beyond them the oldest are lost.
const MOST_QUEUED: usize = 16 << 20;
/// Most answers that wait for a viewer.
const MOST_ANSWERS: usize = 256;
/// Most subscriptions of a viewer.
const MOST_SUBSCRIPTIONS: usize = 100;
/// Time without room in a viewer's connection after which it is dropped.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest message of a viewer, bytes.
const LONGEST: usize = 64 << 10;

/// A viewer, as the server and both of its threads see it.
#[derive(Debug)]
pub(crate) struct Client {
    address: SocketAddr,
    stream: TcpStream,
    queue: Mutex<Queue>,
    came: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    /// Channels by the numbers of the subscriptions.
    subscriptions: BTreeMap<u32, u16>,
    answers: VecDeque<Message>,
    messages: VecDeque<Vec<u8>>,
    bytes: usize,
    /// Messages were lost since it was last empty.
    has_lost: bool,
    /// The connection ends with these words, when all else is written.
    end: Option<String>,
    is_gone: bool,
}

impl Client {
    pub(crate) fn new(stream: TcpStream, address: SocketAddr) -> Self {
        let (queue, came) = Default::default();
        Self { address, stream, queue, came }
    }

    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues a message of `channel`, for each of its subscriptions.
    pub(crate) fn send(&self, channel: u16, time: u64, payload: &[u8]) {
        let mut queue = self.queue();
        let asked = queue.subscriptions.iter().filter(|(_, of)| **of == channel);
        let ids: Vec<u32> = asked.map(|(id, _)| *id).collect();
        for id in ids {
            queue.put(protocol::message_data(id, time, payload));
            self.came.notify_one();
        }
    }

    /// Queues the present time, if it subscribes to anything.
    pub(crate) fn send_time(&self, time: u64) {
        let mut queue = self.queue();
        if !queue.subscriptions.is_empty() {
            queue.put(protocol::time(time));
            self.came.notify_one();
        }
    }

    pub(crate) fn has_subscriptions(&self) -> bool {
        !self.queue().subscriptions.is_empty()
    }

    /// True when nothing waits for it any more.
    pub(crate) fn is_served(&self) -> bool {
        let queue = self.queue();
        queue.is_gone || queue.messages.is_empty() && queue.answers.is_empty()
    }

    /// Ends the connection with these words when all that waits is written.
    pub(crate) fn end(&self, words: &str) {
        self.queue().end.get_or_insert_with(|| words.to_owned());
        self.came.notify_one();
    }

    pub(crate) fn is_gone(&self) -> bool {
        self.queue().is_gone
    }

    pub(crate) fn drop_connection(&self) {
        self.queue().is_gone = true;
        // It may be closed by now.
        let _ = self.stream.shutdown(Shutdown::Both);
        self.came.notify_one();
    }

    fn answer(&self, message: impl Into<Message>) -> Result<(), Refusal> {
        let mut queue = self.queue();
        if queue.answers.len() >= MOST_ANSWERS {
            return Err(Refusal::Answers);
        }
        queue.answers.push_back(message.into());
        self.came.notify_one();
        Ok(())
    }

    /// Reads what the viewer asks for until it is gone.
    pub(crate) fn read(&self, stream: TcpStream, subject: &Subject) {
        let config = WebSocketConfig::default()
            .max_message_size(Some(LONGEST))
            .max_frame_size(Some(LONGEST));
        let mut socket =
            WebSocket::from_raw_socket(Reading::new(stream), Role::Server, Some(config));
        let (mut pace, mut is_slowed) = (Pace::of_messages(), false);
        let refusal = loop {
            let done = match socket.read() {
                Ok(Message::Text(text)) => self.take_text(&text, subject),
                Ok(Message::Binary(bytes)) => self.take_binary(&bytes, subject),
                Ok(Message::Ping(data)) => self.answer(Message::Pong(data)),
                Ok(Message::Pong(_) | Message::Frame(_)) => Ok(()),
                Ok(Message::Close(_)) => return self.end("as asked"),
                // A viewer that dies takes no leave.
                Err(
                    Error::ConnectionClosed
                    | Error::Io(_)
                    | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake),
                ) => return self.drop_connection(),
                Err(error) => Err(Refusal::Protocol(Box::new(error))),
            };
            if let Err(refusal) = done {
                break refusal.to_string();
            }
            if pace.count(1) && !is_slowed {
                is_slowed = true;
                report(self.address, "slowed down", "it asks too often");
            }
        };
        report(self.address, "dropped", &refusal);
        self.end(&refusal);
    }

    fn take_text(&self, text: &str, subject: &Subject) -> Result<(), Refusal> {
        match serde_json::from_str(text)? {
            Asked::Subscribe { subscriptions } => subscriptions.iter().try_for_each(|one| {
                let mut queue = self.queue();
                if usize::from(one.channel_id) >= subject.channels.len() {
                    drop(queue);
                    let text = format!("there is no channel {}", one.channel_id);
                    return self.answer(protocol::status(&text));
                }
                queue.subscriptions.insert(one.id, one.channel_id);
                let count = queue.subscriptions.len();
                if count > MOST_SUBSCRIPTIONS { Err(Refusal::Subscriptions) } else { Ok(()) }
            }),
            Asked::Unsubscribe { subscription_ids } => {
                let subscriptions = &mut self.queue().subscriptions;
                subscriptions.retain(|id, _| !subscription_ids.contains(id));
                Ok(())
            }
            Asked::GetParameters { parameter_names, id } => {
                let all = &subject.parameters;
                self.answer(protocol::parameter_values(all, &parameter_names, id.as_deref()))
            }
            Asked::SetParameters { id } => {
                let text = "the keys of a run are fixed when it starts";
                self.answer(protocol::status(text))?;
                self.answer(protocol::parameter_values(&subject.parameters, &[], id.as_deref()))
            }
            Asked::Other => Ok(()),
        }
    }

    fn take_binary(&self, bytes: &[u8], subject: &Subject) -> Result<(), Refusal> {
        let (service, call, encoding, request) = protocol::call(bytes).ok_or(Refusal::Binary)?;
        let answered = match &subject.service {
            Some((_, answer)) if service == SERVICE && encoding == b"json" => answer(request),
            Some(_) if service == SERVICE => Err("expected a request in JSON".to_owned()),
            _ => Err(format!("there is no service {service}")),
        };
        match answered {
            Ok(response) => self.answer(protocol::service_response(call, &response)),
            Err(why) => self.answer(protocol::service_failure(call, &why)),
        }
    }

    /// Writes what is queued until the viewer is gone.
    pub(crate) fn write(&self, mut socket: WebSocket<TcpStream>) {
        // Failure leaves a viewer that never reads its thread: the run has its end.
        let _ = self.stream.set_write_timeout(Some(PATIENCE));
        while let Some(message) = self.next() {
            let is_end = matches!(message, Message::Close(_));
            match socket.send(message) {
                Ok(()) if !is_end => {}
                Err(Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {
                    let text = format!("it reads nothing for {} s", PATIENCE.as_secs());
                    report(self.address, "dropped", &text);
                    break;
                }
                Ok(()) | Err(_) => break,
            }
        }
        self.drop_connection();
    }

    /// The next message; `None` at the end.
    fn next(&self) -> Option<Message> {
        let mut queue = self.queue();
        loop {
            if queue.is_gone {
                return None;
            }
            if let Some(answer) = queue.answers.pop_front() {
                return Some(answer);
            }
            if let Some(message) = queue.messages.pop_front() {
                queue.bytes -= message.len();
                return Some(Message::binary(message));
            }
            queue.has_lost = false;
            if let Some(words) = &queue.end {
                // A close frame has room for 123 bytes.
                let reason: String = words.chars().filter(char::is_ascii).take(120).collect();
                let frame = CloseFrame { code: CloseCode::Away, reason: reason.into() };
                return Some(Message::Close(Some(frame)));
            }
            queue = self.came.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Queue {
    /// Adds a message, and removes the oldest beyond the limit.
    fn put(&mut self, message: Vec<u8>) {
        self.bytes += message.len();
        self.messages.push_back(message);
        while self.bytes > MOST_QUEUED
            && let Some(oldest) = self.messages.pop_front()
        {
            self.bytes -= oldest.len();
            if !std::mem::replace(&mut self.has_lost, true) {
                let text = "messages are lost: they come faster than they are read";
                self.answers.push_back(protocol::status(text).into());
            }
        }
    }
}
