//! zenoh with a wrong configuration: one error of the vehicle and of the roadside unit, and no endless wait.

use super::{PROGRAM, refused_in};
use radio::{Carrier, Role};
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use system_tests::{Corner, text};

const VEHICLE: [&str; 4] = ["run", "corridor", "--radio", "zenoh:zenoh.json5"];
const UNIT: [&str; 4] = ["rsu", "corridor", "--radio", "zenoh:zenoh.json5"];

fn write(corner: &Corner, configuration: &str) {
    let text = format!("{{ scouting: {{ multicast: {{ enabled: false }} }}, {configuration} }}");
    std::fs::write(corner.path().join("zenoh.json5"), text).expect("our own directory");
}

/// Runs the vehicle and the roadside unit with this configuration.
fn refused_both(configuration: &str, words: &[&str]) {
    let corner = Corner::new(PROGRAM);
    write(&corner, configuration);
    for command in [VEHICLE, UNIT] {
        refused_in(&corner, &command, 2, words);
    }
}

fn free_port() -> (TcpListener, u16) {
    let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = socket.local_addr().expect("it is bound").port();
    (socket, port)
}

fn certificate(name: &str) -> String {
    let all = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/radio/tests/certificates");
    all.join(name).display().to_string()
}

/// TLS with a certificate and the issuer of the peer's certificate.
fn tls(place: &str, name: &str, root: &str) -> String {
    let [root, own, key] =
        [root, &format!("{name}.pem"), &format!("{name}.key.pem")].map(certificate);
    format!(
        "transport: {{ link: {{ tls: {{ root_ca_certificate: \"{root}\", enable_mtls: true, \
         {place}_certificate: \"{own}\", {place}_private_key: \"{key}\" }} }} }}"
    )
}

fn client(port: u16, name: &str, root: &str) -> String {
    let tls = tls("connect", name, root);
    format!("mode: \"client\", connect: {{ endpoints: [\"tls/127.0.0.1:{port}\"] }}, {tls}")
}

pub(super) fn configurations_that_are_none() {
    let corner = Corner::new(PROGRAM);
    for command in [VEHICLE, UNIT] {
        refused_in(&corner, &command, 2, &["zenoh.json5"]);
    }
    refused_both("mode: 7", &["zenoh.json5"]);
    refused_both("mode: \"client\", conect: {}", &["zenoh.json5", "conect"]);
}

pub(super) fn a_router_that_is_not_there() {
    let (socket, port) = free_port();
    drop(socket);
    let endpoints = format!("connect: {{ endpoints: [\"tcp/127.0.0.1:{port}\"] }}");
    refused_both(&format!("mode: \"client\", {endpoints}"), &["is the router there"]);
}

/// Another program listens at the router's port and never answers.
pub(super) fn a_router_that_says_nothing() {
    let (_silent, port) = free_port();
    let endpoints = format!("connect: {{ endpoints: [\"tcp/127.0.0.1:{port}\"] }}");
    let patience = "transport: { unicast: { open_timeout: 500 } }";
    refused_both(&format!("mode: \"client\", {endpoints}, {patience}"), &["is the router there"]);
}

/// A peer waits for others, which may come later: the vehicle drives and counts received frames.
pub(super) fn a_peer_that_is_not_there() {
    let corner = Corner::new(PROGRAM);
    let (socket, port) = free_port();
    drop(socket);
    let endpoints = format!("connect: {{ endpoints: [\"tcp/127.0.0.1:{port}\"] }}");
    write(&corner, &format!("mode: \"peer\", listen: {{ endpoints: [] }}, {endpoints}"));
    let vehicle = corner.json(&[&VEHICLE[..], &["--duration", "1", "--no-record"]].concat());
    let link = &vehicle["link"];
    assert_eq!((&link["received"], &link["truth_known"]), (&0.into(), &false.into()), "{link}");
    let unit = corner.run(&[&UNIT[..], &["--duration", "1"]].concat());
    assert!(unit.status.success(), "{}", text(&unit));
    assert!(text(&unit).contains("none heard"), "{}", text(&unit));
    corner.expect_nothing_left(&[]);
}

/// A router that requires client certificates. The cases are one of an unknown issuer, one that
/// does not accept the router, and missing files.
pub(super) fn wrong_certificates() {
    let (socket, port) = free_port();
    drop(socket);
    let corner = Corner::new(PROGRAM);
    let listen = format!("mode: \"router\", listen: {{ endpoints: [\"tls/127.0.0.1:{port}\"] }}");
    write(&corner, &format!("{listen}, {}", tls("listen", "router", "ca.pem")));
    let address = format!("zenoh:{}/zenoh.json5", corner.path().display());
    let address = address.parse().expect("an address");
    let _router = Carrier::open(&address, Role::Vehicle).expect("the router");
    let words = ["do the certificates belong"];
    refused_both(&client(port, "intruder", "ca.pem"), &words);
    refused_both(&client(port, "vehicle", "intruder.pem"), &words);
    refused_both(&client(port, "missing", "ca.pem"), &words);
}
