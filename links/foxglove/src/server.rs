//! The server: its port, its viewers, and what they are offered.

use crate::client::Client;
use crate::guard::{self, Refusal};
use crate::protocol::SUBPROTOCOLS;
use crate::subject::{Subject, report};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::{HandshakeError, Message, accept_hdr};

/// Most viewers at a time, those that only connect included.
const MOST_CLIENTS: usize = 16;
/// Silence of a client that connects after which it is dropped.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Time for what still waits for viewers at the end.
const LEAVE: Duration = Duration::from_secs(1);

/// A server on 127.0.0.1. Viewers come and go; sending never waits for one.
#[derive(Debug)]
pub struct Server {
    port: u16,
    clients: Arc<Clients>,
}

type Clients = Mutex<Vec<Arc<Client>>>;

impl Server {
    /// Opens the port, any free one for 0.
    ///
    /// # Errors
    /// If the port is taken, or a thread cannot be started.
    pub fn open(port: u16, subject: Subject) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let port = listener.local_addr()?.port();
        let clients: Arc<Clients> = Arc::default();
        let (list, subject) = (Arc::clone(&clients), Arc::new(subject));
        std::thread::Builder::new().name("accept".into()).spawn(move || {
            for stream in listener.incoming() {
                match stream.and_then(|stream| Ok((stream.peer_addr()?, stream))) {
                    Ok((address, stream)) => welcome(stream, address, &list, &subject),
                    // Without a descriptor: the connection waits until there is one.
                    Err(_) => std::thread::sleep(Duration::from_millis(100)),
                }
            }
        })?;
        Ok(Self { port, clients })
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Hands a message of `channel` with its time, ns since 1970, to the viewers that subscribe to it.
    pub fn send(&self, channel: u16, unix_ns: u64, payload: &[u8]) {
        lock(&self.clients).iter().for_each(|client| client.send(channel, unix_ns, payload));
    }

    /// Hands the time that viewers show, ns since 1970, to all.
    pub fn send_time(&self, unix_ns: u64) {
        lock(&self.clients).iter().for_each(|client| client.send_time(unix_ns));
    }

    /// True if a viewer subscribes to anything.
    pub fn is_watched(&self) -> bool {
        lock(&self.clients).iter().any(|client| client.has_subscriptions())
    }

    /// True when nothing waits for a viewer.
    pub fn is_idle(&self) -> bool {
        lock(&self.clients).iter().all(|client| client.is_served())
    }

    /// Ends all connections with these words, and waits a moment until the viewers have what was sent.
    pub fn end(self, words: &str) {
        let clients = lock(&self.clients).clone();
        clients.iter().for_each(|client| client.end(words));
        let begun = Instant::now();
        while begun.elapsed() < LEAVE && !clients.iter().all(|client| client.is_gone()) {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn lock(clients: &Clients) -> MutexGuard<'_, Vec<Arc<Client>>> {
    clients.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes in a connection, in a thread of its own.
fn welcome(stream: TcpStream, address: SocketAddr, clients: &Arc<Clients>, subject: &Arc<Subject>) {
    let mut list = lock(clients);
    list.retain(|client| !client.is_gone());
    if list.len() >= MOST_CLIENTS {
        return report(address, "refused", &format!("there are {MOST_CLIENTS} others"));
    }
    let Ok(own) = stream.try_clone() else { return };
    let client = Arc::new(Client::new(own, address));
    list.push(Arc::clone(&client));
    drop(list);
    let subject = Arc::clone(subject);
    let serve = move || {
        match serve(&stream, &client, &subject) {
            Err(Refusal::Gone) | Ok(()) => {}
            Err(why) => report(address, "refused", &why.to_string()),
        }
        client.drop_connection();
    };
    if let Err(why) = std::thread::Builder::new().name("reader".into()).spawn(serve) {
        report(address, "refused", &why.to_string());
    }
}

/// Serves one viewer to its end. An error is the reason why it was not taken in.
fn serve(stream: &TcpStream, client: &Arc<Client>, subject: &Subject) -> Result<(), Refusal> {
    guard::check_user(stream)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(HANDSHAKE))?;
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
    let mut socket = match accept_hdr(stream.try_clone()?, choose) {
        Ok(socket) => socket,
        Err(error) => {
            let why = match error {
                HandshakeError::Failure(error) => error.to_string(),
                HandshakeError::Interrupted(_) => "the client is silent".to_owned(),
            };
            return Err(refusal.unwrap_or(Refusal::Handshake(why)));
        }
    };
    stream.set_read_timeout(None)?;
    for text in subject.welcome() {
        socket.send(Message::text(text)).map_err(|_| Refusal::Gone)?;
    }
    let reading = stream.try_clone()?;
    let writes = Arc::clone(client);
    let writer = std::thread::Builder::new().name("writer".into());
    let writer = writer.spawn(move || writes.write(socket))?;
    client.read(reading, subject);
    // It ends with the connection.
    let _ = writer.join();
    Ok(())
}

/// Accepts a request from a page that may look, in a protocol that both sides know.
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
