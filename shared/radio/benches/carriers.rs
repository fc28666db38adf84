//! Cost of a carrier on one host. It prints the time of a frame from the sender to the receiver's queue. It also prints
//! the processor time of 20 vehicles that receive one roadside unit.
//!
//! `cargo bench -p radio`, with `--features zenoh` for zenoh's rows. Sender and vehicles are separate
//! processes with one clock.

mod peer;

use peer::{Peer, router};
use radio::{Carrier, Role, wall_clock_ns};
use scenario::carrier::CarrierAddress;
use std::io::Read;
use std::time::Duration;

/// A SPATEM and a MAPEM ten times a second.
const PERIOD: Duration = Duration::from_millis(50);
/// Length of two intersections with their headers, bytes.
const FRAME: [u8; 176] = [0x11; 176];
const FRAMES: usize = 200;
const VEHICLES: usize = 20;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [role, count, address] = arguments.as_slice()
        && role == "vehicles"
    {
        return vehicles(count.parse().expect("a number"), address);
    }
    if let [role, address] = arguments.as_slice()
        && role == "router"
    {
        return router(address);
    }
    println!("{FRAMES} frames of {} bytes, one every {} ms", FRAME.len(), PERIOD.as_millis());
    println!(
        "{:<34} {:>9} {:>9} {:>9} {:>9}   {:>14}",
        "carrier", "p50 us", "p99 us", "max us", "received", "us CPU/frame"
    );
    let multicast = "udp://239.255.31.11:5521?interface=lo";
    row("UDP to an address", "udp://127.0.0.1:5521", None, 1);
    row("UDP to a group", multicast, None, 1);
    row("UDP to a group, 20 vehicles", multicast, None, VEHICLES);
    zenoh_rows();
}

/// Measures one carrier and prints its row; `router` is the address of a router to start first.
fn row(name: &str, address: &str, router: Option<&str>, count: usize) {
    let _router = router.map(|address| Peer::start(&["router", address]));
    row_between(name, address, address, count);
}

fn row_between(name: &str, at_unit: &str, at_vehicle: &str, count: usize) {
    let mut peer = Peer::start(&["vehicles", &count.to_string(), at_vehicle]);
    let start_ns = wall_clock_ns();
    let address: CarrierAddress = at_unit.parse().expect("an address");
    let mut unit = Carrier::open(&address, Role::Roadside { start_ns }).expect(name);
    // Until all have found each other.
    std::thread::sleep(Duration::from_secs(2));
    for _ in 0..FRAMES {
        std::thread::sleep(PERIOD);
        // Unsent frames are missing in the table.
        let _ = unit.send(&FRAME);
    }
    std::thread::sleep(Duration::from_millis(200));
    println!("{name:<34} {}", peer.finish());
}

/// Vehicles in one process until its input ends. Prints the percentiles of the frames' times, each vehicle's
/// number of frames, and the processor time per frame and vehicle.
fn vehicles(count: usize, address: &str) {
    let address: CarrierAddress = address.parse().expect("an address");
    let open = |_| Carrier::open(&address, Role::Vehicle).expect("a vehicle");
    let mut all: Vec<Carrier> = (0..count).map(open).collect();
    println!("ready");
    let ended = std::thread::spawn(|| std::io::stdin().read_to_end(&mut Vec::new()));
    let mut times_us = Vec::with_capacity(count * FRAMES);
    let begun_ms = processor_ms();
    while !ended.is_finished() {
        std::thread::sleep(Duration::from_millis(20));
        for vehicle in &mut all {
            while let Some(frame) = vehicle.receive(0) {
                // One clock: the difference is exact.
                let sent_ns = frame.sent_ns.expect("it is ours");
                times_us.push((frame.received_ns - sent_ns) as f64 / 1e3);
            }
        }
    }
    let spent_ms = processor_ms() - begun_ms;
    times_us.sort_by(f64::total_cmp);
    let heard = times_us.len();
    let at = |share: f64| times_us.get((share * (heard.max(1) - 1) as f64) as usize);
    let text = |value: Option<&f64>| value.map_or("-".into(), |us| format!("{us:.0}"));
    println!(
        "{:>9} {:>9} {:>9} {:>9}   {:>14.0}",
        text(at(0.5)),
        text(at(0.99)),
        text(at(1.0)),
        format!("{}/{}", heard, count * FRAMES),
        spent_ms * 1e3 / heard.max(1) as f64
    );
}

/// Processor time of all threads of this process, ms.
fn processor_ms() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let ns = tasks.flatten().filter_map(|task| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    ns.sum::<f64>() / 1e6
}

#[cfg(not(feature = "zenoh"))]
fn zenoh_rows() {
    println!("zenoh: with --features zenoh");
}

#[cfg(feature = "zenoh")]
fn zenoh_rows() {
    let directory = std::env::temp_dir().join(format!("timegap-carriers-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("room for small files");
    let certificates = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/certificates");
    let configuration = |name: &str, mode: &str, place: &str, end: &str, owner: &str| {
        let at = |file: &str| certificates.join(file).display().to_string();
        let text = format!(
            r#"{{ mode: "{mode}", {place}: {{ endpoints: ["{end}"] }},
                 scouting: {{ multicast: {{ enabled: false }} }},
                 transport: {{ link: {{ tls: {{ root_ca_certificate: "{}", enable_mtls: true,
                     {place}_certificate: "{}", {place}_private_key: "{}" }} }} }} }}"#,
            at("ca.pem"),
            at(&format!("{owner}.pem")),
            at(&format!("{owner}.key.pem")),
        );
        let path = directory.join(format!("{name}.json5"));
        std::fs::write(&path, text).expect("room for a small file");
        format!("zenoh:{}", path.display())
    };
    let listens = configuration("l", "peer", "listen", "tcp/127.0.0.1:5522", "router");
    let connects = configuration("c", "peer", "connect", "tcp/127.0.0.1:5522", "vehicle");
    row_between("zenoh, two peers", &connects, &listens, 1);
    for (name, link, port) in [("zenoh, router", "tcp", 5523), ("zenoh, router, TLS", "tls", 5524)]
    {
        let end = format!("{link}/127.0.0.1:{port}");
        let router = configuration(&format!("{link}-r"), "router", "listen", &end, "router");
        let client = configuration(&format!("{link}-c"), "client", "connect", &end, "vehicle");
        row(name, &client, Some(&router), 1);
        if link == "tls" {
            row("zenoh, router, TLS, 20 vehicles", &client, Some(&router), VEHICLES);
        }
    }
    // Created above.
    let _ = std::fs::remove_dir_all(&directory);
}
