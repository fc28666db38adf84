//! The server with clients of every kind: one that asks, one that never reads, one that floods, strangers.

use foxglove_bridge::{Server, Subject};
use recorder::Channel;
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket, client};

/// First byte of a message that is a time.
const TIME: u8 = 2;
/// A watchdog, not a measurement.
const PATIENCE: Duration = Duration::from_secs(60);

fn server() -> Server {
    let channel = |topic| Channel {
        topic,
        type_name: "std_msgs/msg/UInt8MultiArray",
        definition: "uint8[] data\n".into(),
    };
    let answer = |request: &[u8]| match request {
        b"{}" => Err("no kind".to_owned()),
        request => Ok(request.to_vec()),
    };
    let subject = Subject {
        name: "test".into(),
        session: "1".into(),
        channels: vec![channel("a"), channel("b")],
        parameters: vec![("x.y".into(), json!(2.5)), ("z".into(), json!("text"))],
        service: Some((json!({ "op": "advertiseServices" }).to_string(), Box::new(answer))),
    };
    Server::open(0, subject).expect("a free port")
}

fn connection(server: &Server) -> TcpStream {
    let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, server.port())).expect("it listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    stream
}

fn request(server: &Server, protocol: &str, origin: Option<&str>) -> Result<Viewer, String> {
    let url = format!("ws://127.0.0.1:{}/", server.port());
    let mut request = url.into_client_request().expect("an address");
    let headers = request.headers_mut();
    headers.insert("sec-websocket-protocol", protocol.parse().expect("text"));
    origin.map(|origin| headers.insert("origin", origin.parse().expect("text")));
    let (socket, _) = client(request, connection(server)).map_err(|why| why.to_string())?;
    Ok(Viewer(socket))
}

struct Viewer(WebSocket<TcpStream>);

impl Viewer {
    fn of(server: &Server) -> Self {
        let mut viewer = request(server, "foxglove.sdk.v1", None).expect("it is taken in");
        for op in ["serverInfo", "advertise", "advertiseServices"] {
            assert_eq!(viewer.text()["op"], op);
        }
        viewer
    }

    fn ask(&mut self, text: &Value) {
        self.0.send(Message::text(text.to_string())).expect("it is read");
    }

    fn text(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().expect("an answer") {
                return serde_json::from_str(&text).expect("JSON");
            }
        }
    }

    /// The next binary message that is a time, or that is none.
    fn bytes(&mut self, is_time: bool) -> Vec<u8> {
        loop {
            match self.0.read().expect("a message") {
                Message::Binary(bytes) if is_time == (bytes[0] == TIME) => return bytes.to_vec(),
                _ => {}
            }
        }
    }

    /// Subscribes, and waits until the server knows it.
    fn subscribe(&mut self, id: u32, channel: u32) {
        let subscriptions = json!([{ "id": id, "channelId": channel }]);
        self.ask(&json!({ "op": "subscribe", "subscriptions": subscriptions }));
        self.ask(&json!({ "op": "getParameters", "parameterNames": ["z"], "id": "q" }));
        assert_eq!(self.text()["parameters"], json!([{ "name": "z", "value": "text" }]));
    }

    /// Reads to the end of the connection.
    fn end(mut self) -> String {
        loop {
            match self.0.read() {
                Ok(Message::Close(Some(frame))) => return frame.reason.to_string(),
                Ok(_) => {}
                Err(why) => return why.to_string(),
            }
        }
    }
}

fn wait_until(mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "it never holds");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_viewer_gets_what_it_subscribes_to_until_it_does_not() {
    let server = server();
    let mut viewer = Viewer::of(&server);
    assert!(!server.is_watched());
    viewer.subscribe(70, 1);
    server.send(0, 5, b"of another channel");
    server.send(1, 6, b"payload");
    let head = [&[1_u8][..], &70_u32.to_le_bytes(), &6_u64.to_le_bytes()].concat();
    assert_eq!(viewer.bytes(false), [&head[..], b"payload"].concat());
    server.send(0, 9, b"of another channel");
    let time = [&[TIME][..], &9_u64.to_le_bytes()].concat();
    while viewer.bytes(true) != time {}
    viewer.ask(&json!({ "op": "unsubscribe", "subscriptionIds": [70] }));
    wait_until(|| !server.is_watched());
    let subscriptions = json!([{ "id": 1, "channelId": 2 }]);
    viewer.ask(&json!({ "op": "subscribe", "subscriptions": subscriptions }));
    assert_eq!(viewer.text()["message"], "there is no channel 2");
    server.end("the run has ended", || false);
    assert_eq!(viewer.end(), "the run has ended");
}

#[test]
fn parameters_are_read_and_not_set_and_a_service_answers() {
    let server = server();
    let mut viewer = Viewer::of(&server);
    viewer.ask(&json!({ "op": "getParameters", "parameterNames": [], "id": "7" }));
    let answer = viewer.text();
    let number = json!({ "name": "x.y", "value": 2.5, "type": "float64" });
    assert_eq!((&answer["id"], &answer["parameters"][0]), (&json!("7"), &number));
    let set = json!([{ "name": "z", "value": 1 }]);
    viewer.ask(&json!({ "op": "setParameters", "parameters": set, "id": "8" }));
    assert_eq!(viewer.text()["op"], "status");
    assert_eq!(viewer.text()["parameters"][1]["value"], "text");
    // This server passes over texts that it does not know.
    viewer.ask(&json!({ "op": "subscribeConnectionGraph" }));
    let mut call = |service: u32, encoding: &str, request: &str| {
        let head = [service, 3, encoding.len() as u32].map(u32::to_le_bytes).concat();
        let bytes = [&[2], &head[..], encoding.as_bytes(), request.as_bytes()].concat();
        viewer.0.send(Message::binary(bytes)).expect("it is read");
    };
    call(1, "json", "{\"a\":1}");
    call(1, "json", "{}");
    call(1, "cdr", "{}");
    call(4, "json", "{}");
    let head = [1_u32, 3, 4].map(u32::to_le_bytes).concat();
    assert_eq!(viewer.bytes(false), [&[3], &head[..], b"json{\"a\":1}"].concat());
    for why in ["no kind", "expected a request in JSON", "there is no service 4"] {
        let failure = viewer.text();
        assert_eq!((&failure["callId"], &failure["message"]), (&json!(3), &json!(why)));
    }
}

#[test]
fn strangers_are_refused_and_others_are_served_all_the_same() {
    let server = server();
    for (protocol, origin) in [
        ("foxglove.sdk.v1", Some("https://example.org")),
        ("foxglove.sdk.v1", Some("null")),
        ("chat", None),
    ] {
        let why = request(&server, protocol, origin).err().expect("it is refused");
        assert!(why.contains("403"), "{why}");
    }
    let page = Some("https://app.foxglove.dev");
    request(&server, "chat, foxglove.websocket.v1", page).expect("an older viewer");
    for garbage in [&b"GET / HTTP/1.1\r\n\r\n"[..], b"\x00\xff\x00", &[b'x'; 100_000]] {
        let mut stream = connection(&server);
        // It may be refused before all is written.
        let _ = stream.write_all(garbage);
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let mut rest = Vec::new();
        let _ = stream.read_to_end(&mut rest);
        assert!(!rest.starts_with(b"HTTP/1.1 101"), "{} bytes", garbage.len());
    }
    for garbage in [Message::text("{"), Message::text("[]"), Message::binary(vec![1, 2, 3])] {
        let mut viewer = Viewer::of(&server);
        viewer.0.send(garbage.clone()).expect("it is read");
        let why = viewer.end();
        let is_said = why.contains("protocol's JSON") || why.contains("no call of a service");
        assert!(is_said, "{garbage:?}: {why}");
    }
    Viewer::of(&server).subscribe(1, 0);
}

#[test]
fn a_viewer_that_never_reads_loses_the_oldest_and_holds_up_nothing() {
    let server = server();
    let mut deaf = Viewer::of(&server);
    deaf.subscribe(1, 0);
    let mut other = Viewer::of(&server);
    other.subscribe(2, 1);
    let large = vec![7; 1 << 20];
    for _ in 0..64 {
        server.send(0, 1, &large);
    }
    server.send(1, 2, b"to the other");
    assert!(other.bytes(false).ends_with(b"to the other"));
    // It reads at last what the queue and the connection hold, and how much was lost.
    let (mut received, mut lost) = (0, String::new());
    server.send(0, 3, b"last");
    loop {
        match deaf.0.read().expect("it is still connected") {
            Message::Binary(bytes) if bytes.ends_with(b"last") => break,
            Message::Binary(bytes) => received += usize::from(bytes[0] != TIME),
            Message::Text(text) => lost = text.to_string(),
            _ => {}
        }
    }
    assert!((1..60).contains(&received), "{received} of 64");
    assert!(lost.contains("messages are lost"), "{lost}");
}

#[test]
fn a_flood_of_questions_does_not_keep_others_from_being_served() {
    let server = server();
    let mut flood = Viewer::of(&server);
    let mut other = Viewer::of(&server);
    let question = json!({ "op": "getParameters", "parameterNames": [] }).to_string();
    for _ in 0..2_000 {
        // Its connection takes no more at some time.
        if flood.0.send(Message::text(question.clone())).is_err() {
            break;
        }
    }
    other.subscribe(1, 0);
    server.send(0, 1, b"served");
    assert!(other.bytes(false).ends_with(b"served"));
}

#[test]
fn a_port_that_is_taken_is_an_error_and_too_many_viewers_are_refused() {
    let server = server();
    let port = server.port();
    let subject = Subject {
        name: String::new(),
        session: String::new(),
        channels: Vec::new(),
        parameters: Vec::new(),
        service: None,
    };
    let error = Server::open(port, subject).expect_err("the port is taken");
    assert_eq!(error.kind(), std::io::ErrorKind::AddrInUse);
    let viewers: Vec<Viewer> = (0..16).map(|_| Viewer::of(&server)).collect();
    assert!(request(&server, "foxglove.sdk.v1", None).is_err(), "one too many");
    drop(viewers);
    wait_until(|| request(&server, "foxglove.sdk.v1", None).is_ok());
}
