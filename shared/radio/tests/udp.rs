//! UDP on the loopback interface: frames, apparent losses, clocks, unavailable addresses.

#[cfg(not(feature = "zenoh"))]
use radio::OpenError;
use radio::{Carrier, Frame, MAX_FRAME, Role, SendError, wall_clock_ns};
use scenario::carrier::CarrierAddress;
use std::net::{Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

const WATCHDOG: Duration = Duration::from_secs(30);

/// A free port of the loopback interface.
fn free_port() -> u16 {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    socket.local_addr().expect("it is bound").port()
}

fn address(text: &str) -> CarrierAddress {
    text.parse().expect("an address")
}

fn open(address: &CarrierAddress, role: Role) -> Carrier {
    Carrier::open(address, role).expect("the loopback interface is there")
}

fn roadside() -> Role {
    Role::Roadside { start_ns: wall_clock_ns() }
}

/// Waits for `found`.
fn wait<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(begun.elapsed() < WATCHDOG, "waited for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn next(carrier: &mut Carrier) -> Frame {
    wait("a frame", || carrier.receive(0))
}

/// One roadside unit and `count` vehicles at a group or an address.
fn drive(text: &str, count: usize) {
    let address = address(text);
    let mut vehicles: Vec<Carrier> = (0..count).map(|_| open(&address, Role::Vehicle)).collect();
    let start_ns = wall_clock_ns();
    let mut unit = open(&address, Role::Roadside { start_ns });
    for k in 0..200u8 {
        unit.send(&vec![k; 1 + 7 * usize::from(k)]).expect("room");
        for vehicle in &mut vehicles {
            let frame = next(vehicle);
            assert_eq!(frame.bytes(), vec![k; 1 + 7 * usize::from(k)]);
            assert_eq!(frame.start_ns, Some(start_ns));
            assert!(frame.sent_ns.is_some_and(|sent_ns| sent_ns >= start_ns));
        }
    }
    assert_eq!(unit.report().sent, 200);
    for vehicle in &mut vehicles {
        let report = vehicle.report();
        assert_eq!((report.received, report.dropped, report.malformed), (200, 0, 0));
        let [station] = report.stations.as_slice() else { panic!("{report:?}") };
        assert_eq!((station.received, station.lost, station.duplicates), (200, 0, 0));
        // Its clock is this host's.
        let clock = wait("an answer", || vehicle.report().stations[0].clock);
        assert!(clock.offset_us.abs() <= clock.uncertainty_us, "{clock:?}");
    }
    unit.send(b"later").expect("room");
    for vehicle in &mut vehicles {
        let (travelled_ns, uncertainty_ns) = wait("a frame", || vehicle.receive(0)?.travelled_ns());
        assert!(travelled_ns + uncertainty_ns >= 0, "{travelled_ns} {uncertainty_ns}");
    }
}

#[test]
fn one_vehicle_at_its_address() {
    drive(&format!("udp://127.0.0.1:{}", free_port()), 1);
}

#[test]
fn three_vehicles_in_a_group() {
    drive(&format!("udp://239.255.31.7:{}?interface=lo", free_port()), 3);
}

#[test]
fn a_vehicle_at_an_address_of_ipv6() {
    if UdpSocket::bind("[::1]:0").is_err() {
        eprintln!("no IPv6 here: not tested");
        return;
    }
    drive(&format!("udp://[::1]:{}", free_port()), 1);
}

#[test]
fn a_vehicle_answers_the_station_that_it_received() {
    let address = address(&format!("udp://127.0.0.1:{}", free_port()));
    let mut vehicle = open(&address, Role::Vehicle);
    assert!(matches!(vehicle.send(b"early"), Err(SendError::NoTarget)));
    let mut unit = open(&address, roadside());
    unit.send(b"green").expect("room");
    assert_eq!(next(&mut vehicle).bytes(), b"green");
    vehicle.send(b"here").expect("it heard one");
    assert_eq!(next(&mut unit).bytes(), b"here");
    assert_eq!((vehicle.report().sent, vehicle.report().not_sent), (1, 1));
    let long = [0; MAX_FRAME + 1];
    assert!(matches!(unit.send(&long), Err(SendError::TooLong(1501))));
}

#[test]
fn a_datagram_of_another_program_is_a_frame_without_stamps() {
    let port = free_port();
    let mut vehicle = open(&address(&format!("udp://127.0.0.1:{port}")), Role::Vehicle);
    let other = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    for packet in [&b"\x11\x00\x1a\x01"[..], b"TGR1 and then nonsense", b"", &[7; 1501]] {
        other.send_to(packet, (Ipv4Addr::LOCALHOST, port)).expect("it is there");
    }
    let frame = next(&mut vehicle);
    assert_eq!(frame.bytes(), b"\x11\x00\x1a\x01");
    assert_eq!((frame.sender, frame.sent_ns, frame.clock), (None, None, None));
    let malformed = || Some(vehicle.report().malformed).filter(|&count| count == 3);
    wait("what is not a frame", malformed);
    assert_eq!(vehicle.report().stations, [], "its clock is not known");
}

#[test]
fn a_full_queue_drops_and_counts() {
    let address = address(&format!("udp://127.0.0.1:{}", free_port()));
    let mut vehicle = open(&address, Role::Vehicle);
    let mut unit = open(&address, roadside());
    // In turns, so that the socket's buffer does not overflow.
    for k in 1..=600 {
        unit.send(b"frame").expect("room");
        wait("its arrival", || (vehicle.report().received == k).then_some(()));
    }
    let report = vehicle.report();
    assert_eq!((report.received, report.dropped), (600, 600 - 512));
    assert_eq!(std::iter::from_fn(|| vehicle.receive(0)).count(), 512);
}

#[test]
fn a_unit_that_starts_anew_is_another_one_and_nothing_is_lost() {
    let address = address(&format!("udp://127.0.0.1:{}", free_port()));
    let mut vehicle = open(&address, Role::Vehicle);
    for _ in 0..2 {
        let mut unit = open(&address, roadside());
        for _ in 0..3 {
            unit.send(b"frame").expect("room");
            next(&mut vehicle);
        }
    }
    let report = vehicle.report();
    assert_eq!(report.stations.len(), 2);
    assert!(report.stations.iter().all(|station| (station.received, station.lost) == (3, 0)));
}

#[test]
fn an_address_that_cannot_be_bound_is_one_error() {
    let refused = |text: &str, role| {
        let error = Carrier::open(&address(text), role).expect_err(text);
        error.to_string()
    };
    // An address for documentation, which no host has.
    let elsewhere = refused("udp://192.0.2.1:5520", Role::Vehicle);
    assert!(elsewhere.starts_with("cannot listen on 192.0.2.1:5520: "), "{elsewhere}");
    let taken = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = taken.local_addr().expect("it is bound").port();
    let busy = refused(&format!("udp://127.0.0.1:{port}"), Role::Vehicle);
    assert!(busy.contains("cannot listen on 127.0.0.1"), "{busy}");
    if UdpSocket::bind("[::1]:0").is_ok() {
        let which = refused("udp://[ff02::114]:5520", Role::Vehicle);
        assert!(which.contains("name the interface, as in udp://[ff02::114]:5520?"), "{which}");
    }
    let unknown = refused("udp://239.255.31.7:5520?interface=none7", Role::Vehicle);
    assert!(unknown.starts_with("no network interface `none7`"), "{unknown}");
}

#[test]
#[cfg(not(feature = "zenoh"))]
fn without_its_feature_zenoh_is_one_error() {
    let error = Carrier::open(&address("zenoh"), Role::Vehicle).expect_err("it is not built in");
    assert!(matches!(error, OpenError::WithoutZenoh));
    let capture = Carrier::open(&address("pcap:x"), roadside()).expect_err("it cannot be sent to");
    assert!(matches!(capture, OpenError::CaptureIsNoTarget));
}
