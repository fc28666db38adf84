//! zenoh on the loopback interface: peers, a router with TLS, its absence, an untrusted certificate.
#![cfg(feature = "zenoh")]

use radio::{Carrier, OpenError, Role, wall_clock_ns};
use scenario::carrier::CarrierAddress;
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const WATCHDOG: Duration = Duration::from_secs(60);

fn free_port() -> u16 {
    let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    socket.local_addr().expect("it is bound").port()
}

/// A directory of configuration files, removed in the end.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("timegap-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("room for small files");
        Self(path)
    }

    fn address(&self, name: &str, text: &str) -> CarrierAddress {
        let path = self.0.join(name);
        std::fs::write(&path, text).expect("room for a small file");
        format!("zenoh:{}", path.display()).parse().expect("an address")
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        // It may have been removed by hand.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn certificate(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/certificates").join(name);
    path.display().to_string()
}

/// A router that requires certificates from its clients.
fn router(port: u16) -> String {
    format!(
        r#"{{ mode: "router", listen: {{ endpoints: ["tls/127.0.0.1:{port}"] }},
             scouting: {{ multicast: {{ enabled: false }} }},
             transport: {{ link: {{ tls: {{ root_ca_certificate: "{}", enable_mtls: true,
                 listen_certificate: "{}", listen_private_key: "{}" }} }} }} }}"#,
        certificate("ca.pem"),
        certificate("router.pem"),
        certificate("router.key.pem"),
    )
}

/// A client of that router with the certificate `name`.
fn client(port: u16, name: &str) -> String {
    format!(
        r#"{{ mode: "client", connect: {{ endpoints: ["tls/127.0.0.1:{port}"] }},
             scouting: {{ multicast: {{ enabled: false }} }},
             transport: {{ link: {{ tls: {{ root_ca_certificate: "{}", enable_mtls: true,
                 connect_certificate: "{}", connect_private_key: "{}" }} }} }} }}"#,
        certificate("ca.pem"),
        certificate(&format!("{name}.pem")),
        certificate(&format!("{name}.key.pem")),
    )
}

fn open(address: &CarrierAddress, role: Role) -> Carrier {
    Carrier::open(address, role).unwrap_or_else(|error| panic!("{address}: {error}"))
}

fn roadside() -> Role {
    Role::Roadside { start_ns: wall_clock_ns() }
}

/// Sends until `vehicle` has received `count` more frames. Those sent before both ends are connected are lost.
fn drive(unit: &mut Carrier, vehicle: &mut Carrier, count: usize) {
    let begun = Instant::now();
    let mut heard = 0;
    while heard < count {
        assert!(begun.elapsed() < WATCHDOG, "{heard} of {count} frames: {:?}", vehicle.report());
        // A full queue is one that is not emptied yet.
        let _ = unit.send(&[7; 134]);
        std::thread::sleep(Duration::from_millis(5));
        while let Some(frame) = vehicle.receive(0) {
            assert_eq!(frame.bytes(), [7; 134]);
            heard += 1;
        }
    }
}

#[test]
fn two_peers_without_a_router() {
    let directory = Directory::new("peers");
    let port = free_port();
    let listens = format!(
        r#"{{ mode: "peer", listen: {{ endpoints: ["tcp/127.0.0.1:{port}"] }},
             scouting: {{ multicast: {{ enabled: false }} }} }}"#
    );
    let connects = format!(
        r#"{{ mode: "peer", connect: {{ endpoints: ["tcp/127.0.0.1:{port}"] }},
             listen: {{ endpoints: [] }}, scouting: {{ multicast: {{ enabled: false }} }} }}"#
    );
    let mut unit = open(&directory.address("unit.json5", &listens), roadside());
    let mut vehicle = open(&directory.address("vehicle.json5", &connects), Role::Vehicle);
    drive(&mut unit, &mut vehicle, 100);
    let begun = Instant::now();
    let clock = loop {
        if let Some(clock) = vehicle.report().stations[0].clock {
            break clock;
        }
        assert!(begun.elapsed() < WATCHDOG, "no answer");
        drive(&mut unit, &mut vehicle, 1);
    };
    assert!(clock.offset_us.abs() <= clock.uncertainty_us, "{clock:?}");
    assert_eq!(vehicle.report().stations[0].lost, 0);
    // Remains of a process that is killed here.
    let maps = std::fs::read_to_string("/proc/self/maps").expect("our own");
    assert!(!maps.contains(".zenoh"), "no segment of shared memory: {maps}");
}

#[test]
fn clients_of_a_router_with_mutual_tls_find_it_again() {
    let directory = Directory::new("tls");
    let port = free_port();
    let at_router = directory.address("router.json5", &router(port));
    let at_client = directory.address("client.json5", &client(port, "vehicle"));
    let first = open(&at_router, Role::Vehicle);
    let mut unit = open(&at_client, roadside());
    let mut vehicle = open(&at_client, Role::Vehicle);
    drive(&mut unit, &mut vehicle, 100);
    drop(first);
    let _second = open(&at_router, Role::Vehicle);
    drive(&mut unit, &mut vehicle, 100);
    assert_eq!(vehicle.report().stations.len(), 1, "the unit is the same");
}

#[test]
fn an_untrusted_certificate_an_absent_router_and_a_bad_file_are_one_error_each() {
    let directory = Directory::new("refused");
    let port = free_port();
    let absent =
        Carrier::open(&directory.address("absent.json5", &client(port, "vehicle")), Role::Vehicle);
    let absent = absent.expect_err("there is no router");
    assert!(matches!(absent, OpenError::ZenohSession { .. }), "{absent}");
    let _router = open(&directory.address("router.json5", &router(port)), Role::Vehicle);
    let untrusted = directory.address("untrusted.json5", &client(port, "intruder"));
    let untrusted = Carrier::open(&untrusted, Role::Vehicle).expect_err("it is not trusted");
    assert!(matches!(untrusted, OpenError::ZenohSession { .. }), "{untrusted}");
    for text in ["{ mode: \"spaceship\" }", "no JSON at all"] {
        let error = Carrier::open(&directory.address("bad.json5", text), Role::Vehicle);
        let error = error.expect_err("not a configuration");
        assert!(matches!(error, OpenError::ZenohConfiguration { .. }), "{error}");
    }
    let missing = "zenoh:/no/such/file.json5".parse().expect("an address");
    let missing = Carrier::open(&missing, Role::Vehicle).expect_err("no such file");
    assert!(matches!(missing, OpenError::ZenohConfiguration { .. }), "{missing}");
}
