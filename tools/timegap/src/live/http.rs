//! HTTP/1.1 as far as the live page needs it: one request a connection, no bodies.
//!
//! `httparse` reads the request. A whole server would bound less. `tiny_http` 0.12 limits neither the time nor the
//! length of a request, nor the time of a write. It cannot close the connection of a browser that takes no events.

use httparse::Status;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// Longest request that is read, bytes.
pub const MAX_REQUEST: usize = 8192;
/// Most header fields of a request.
const MAX_FIELDS: usize = 64;
/// Largest rest of a refused request that is read before the connection is closed, bytes.
const MAX_DRAINED: usize = 1 << 20;
/// Time for a whole request.
const REQUEST_TIME: Duration = Duration::from_secs(2);
/// Time for one write, and for the rest of a refused request.
const PATIENCE: Duration = Duration::from_secs(1);

/// A request for a path.
#[derive(Debug, PartialEq, Eq)]
pub struct Request {
    /// The path.
    pub path: String,
    /// Name of the machine that the browser asks for, without its port.
    pub host: Option<String>,
    /// True if the answer has its text; `HEAD` asks only how long that would be.
    pub body: bool,
}

/// A request, or the answer that refuses it.
type Parsed = Result<Request, Refusal>;
/// Status line and text of a refusal.
type Refusal = (&'static str, &'static str);

/// Reads a request and sets the time limits of the connection. One that cannot be answered is refused here.
pub fn receive(mut stream: &TcpStream) -> std::io::Result<Option<Request>> {
    stream.set_write_timeout(Some(PATIENCE))?;
    let begun = Instant::now();
    let (mut text, mut chunk) = (Vec::new(), [0; 1024]);
    loop {
        match parse(&text) {
            None if text.len() <= MAX_REQUEST => {}
            None => {
                refuse(
                    stream,
                    ("431 Request Header Fields Too Large", "the request is too long\n"),
                )?;
                return Ok(None);
            }
            Some(Ok(request)) => return Ok(Some(request)),
            Some(Err(refusal)) => {
                refuse(stream, refusal)?;
                return Ok(None);
            }
        }
        let left = REQUEST_TIME.saturating_sub(begun.elapsed());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut chunk)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            count => text.extend_from_slice(&chunk[..count]),
        }
    }
}

/// The request in `text`; `None` while its end is missing.
fn parse(text: &[u8]) -> Option<Parsed> {
    let mut fields = [httparse::EMPTY_HEADER; MAX_FIELDS];
    let mut request = httparse::Request::new(&mut fields);
    match request.parse(text) {
        Ok(Status::Partial) => return None,
        Ok(Status::Complete(_)) => {}
        Err(_) => return Some(Err(("400 Bad Request", "this is not an HTTP request\n"))),
    }
    let body = match request.method {
        Some("GET") => true,
        Some("HEAD") => false,
        _ => return Some(Err(("405 Method Not Allowed", "only GET and HEAD are answered\n"))),
    };
    let host = request.headers.iter().find(|field| field.name.eq_ignore_ascii_case("host"));
    let host = host.map(|field| String::from_utf8_lossy(field.value));
    let host = host.map(|host| host.rsplit_once(':').map_or(&*host, |(name, _)| name).to_owned());
    Some(Ok(Request { path: request.path.unwrap_or_default().to_owned(), host, body }))
}

/// Refuses a request and reads its rest: a connection that is closed before loses the answer.
fn refuse(mut stream: &TcpStream, (status, text): Refusal) -> std::io::Result<()> {
    respond(stream, status, "text/plain", text, true)?;
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let (mut left, mut chunk) = (MAX_DRAINED, [0; 4096]);
    while left > 0 {
        match stream.read(&mut chunk)? {
            0 => return Ok(()),
            count => left = left.saturating_sub(count),
        }
    }
    Ok(())
}

/// Sends an answer; without its `body` only its header.
pub fn respond(
    mut stream: &TcpStream,
    status: &str,
    kind: &str,
    text: &str,
    body: bool,
) -> std::io::Result<()> {
    let sent = if body { text } else { "" };
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

/// Begins a stream of server-sent events.
pub fn begin_events(mut stream: &TcpStream) -> std::io::Result<()> {
    stream.write_all(
        b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
          Connection: close\r\n\r\n",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read_when_it_is_whole() {
        let text = b"HEAD /a/ HTTP/1.1\r\nAccept: *\r\nHost: localhost:8170\r\n\r\n";
        for end in 0..text.len() {
            assert_eq!(parse(&text[..end]), None, "{end} bytes");
        }
        let host = Some("localhost".to_owned());
        assert_eq!(parse(text), Some(Ok(Request { path: "/a/".into(), host, body: false })));
    }

    #[test]
    fn other_methods_and_other_protocols_are_refused() {
        for (text, status) in [("POST / HTTP/1.1\r\n\r\n", "405"), ("\x16\x03\x01\x02\x00", "400")]
        {
            let refused = parse(text.as_bytes()).expect("it is clear").expect_err("refused");
            assert!(refused.0.starts_with(status), "{refused:?}");
        }
    }
}
