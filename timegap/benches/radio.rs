//! Age of the signals at the controller on each path, with its parts. The bench also measures the delay of a signal's
//! change to the actuators. It also measures the cost of an on-board unit among 20 that receive one roadside unit.
//!
//! `cargo bench -p timegap --bench radio`, with `--features zenoh` for zenoh's rows. Both ends run on this
//! host. Roadside unit, vehicle radio and controller have cycles of 100 ms each. Their relative phase is
//! random in each session, so that several sessions alternate.

mod age;
#[path = "../../shared/radio/benches/peer/mod.rs"]
mod peer;

use bytemuck::Zeroable;
use messages::{Map, Spat};
use obu::clock::Moment;
use obu::lanes::road_plane;
use obu::receiver::Receiver;
use peer::{Peer, router};
use radio::{Carrier, Role, wall_clock_ns};
use rustix::time::{ClockId, clock_gettime};
use scenario::carrier::CarrierAddress;
use scenario::radio::Origin;
use serde_json::Value;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap");
const SESSIONS: usize = 5;
const SESSION_S: &str = "12";
const VEHICLES: usize = 20;
const VEHICLES_S: &str = "20";
/// An intersection is ahead from start to end, and its signal changes every one or two seconds.
const SCENE: [&str; 8] = [
    "--set",
    "v2x.range_m=2000",
    "--set",
    "v2x.signals.0.program.0.duration_s=2",
    "--set",
    "v2x.signals.0.program.1.duration_s=1",
    "--set",
    "v2x.signals.0.program.2.duration_s=2",
];
const GROUP: &str = "udp://239.255.31.13:5525?interface=lo";

/// A path from the roadside unit to the controller.
struct Way {
    name: &'static str,
    /// The vehicle's `v2x.radio`, and the unit's if it is a process of its own.
    vehicle: String,
    unit: Option<String>,
    /// Address of zenoh's router, if needed.
    router: Option<String>,
    sessions: Vec<Value>,
    /// Parts of the age of each session's signals, ms.
    parts: Vec<Vec<[f64; 5]>>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.as_slice() {
        [role, address] if role == "vehicle" => return vehicle(address),
        [role, address] if role == "router" => return router(address),
        _ => {}
    }
    let directory = std::env::temp_dir().join(format!("timegap-radio-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("room for small files");
    let mut ways = ways(&directory);
    for session in 0..SESSIONS {
        for way in &mut ways {
            eprintln!("session {} of {SESSIONS}: {}", session + 1, way.name);
            let (summary, parts) = drive(way, &directory);
            way.sessions.push(summary);
            way.parts.push(parts);
        }
    }
    println!("{SESSIONS} sessions of {SESSION_S} s each, load {}", load());
    println!(
        "| way | age at the controller p50 ms | p99 ms | network p50 ms | p99 ms | control cycles |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for way in &ways {
        row(way);
    }
    where_the_age_comes_from(&ways);
    way_of_a_change(&ways);
    many_vehicles();
    // Created above.
    let _ = std::fs::remove_dir_all(&directory);
}

fn ways(directory: &Path) -> Vec<Way> {
    let way = |name, vehicle: &str, unit: Option<&str>, router: Option<String>| Way {
        name,
        vehicle: vehicle.to_owned(),
        unit: unit.map(str::to_owned),
        router,
        sessions: Vec::new(),
        parts: Vec::new(),
    };
    let mut ways = vec![
        way("structs (`direct`)", "direct", None, None),
        way("frames in shared memory", "frames", None, None),
        way("frames by UDP to a group", GROUP, Some(GROUP), None),
    ];
    if cfg!(feature = "zenoh") {
        let zenoh = |name: &str, mode, place, end: &str, owner| {
            configuration(directory, name, [mode, place, end, owner])
        };
        let listens = zenoh("listens", "peer", "listen", "tcp/127.0.0.1:5526", "router");
        let connects = zenoh("connects", "peer", "connect", "tcp/127.0.0.1:5526", "vehicle");
        ways.push(way("frames by zenoh, two peers", &listens, Some(&connects), None));
        let router = zenoh("router", "router", "listen", "tls/127.0.0.1:5527", "router");
        let client = zenoh("client", "client", "connect", "tls/127.0.0.1:5527", "vehicle");
        ways.push(way("frames by zenoh, router, TLS", &client, Some(&client), Some(router)));
    }
    ways
}

fn configuration(directory: &Path, name: &str, [mode, place, end, owner]: [&str; 4]) -> String {
    let certificates =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/radio/tests/certificates");
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
}

/// One drive by `way`: its summary, and the parts of the age of its signals.
fn drive(way: &Way, directory: &Path) -> (Value, Vec<[f64; 5]>) {
    let _router = way.router.as_deref().map(|address| Peer::start(&["router", address]));
    let results = directory.join("run");
    let mut vehicle = Command::new(PROGRAM);
    vehicle.args(["run", "corridor", "--duration", SESSION_S, "--json"]);
    vehicle.args(SCENE).args(["--radio", &way.vehicle, "--out"]).arg(&results);
    let vehicle = vehicle.stdout(Stdio::piped()).spawn().expect("the command starts");
    let unit = way.unit.as_deref().map(|address| {
        let mut unit = Command::new(PROGRAM);
        unit.args(["rsu", "corridor", "--radio", address, "--duration", "60"]).args(SCENE);
        unit.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the command starts")
    });
    let output = vehicle.wait_with_output().expect("it ends");
    if let Some(mut unit) = unit {
        // It still runs: longer than the vehicle.
        let _ = unit.kill();
        let _ = unit.wait();
    }
    let parts = age::parts_ms(&results.join(recorder::FILE));
    let _ = std::fs::remove_dir_all(&results);
    (serde_json::from_slice(&output.stdout).expect("a summary"), parts)
}

/// Parts of the age of another process's frames: medians of each session.
fn where_the_age_comes_from(ways: &[Way]) {
    println!("\n| way | session | {} ms | age ms |", age::PARTS.join(" ms | "));
    println!("| --- | --- {}|", "| --- ".repeat(age::PARTS.len() + 1));
    for way in ways.iter().filter(|way| way.unit.is_some()) {
        for (parts, session) in way.parts.iter().zip(1..) {
            if parts.is_empty() {
                continue;
            }
            let columns = (0..age::PARTS.len()).map(|part| median(parts.iter().map(|p| p[part])));
            let age = median(parts.iter().map(|p| p.iter().sum()));
            let columns: Vec<_> = columns.chain([age]).map(|ms| format!("{ms:.1}")).collect();
            println!("| {} | {session} | {} |", way.name, columns.join(" | "));
        }
    }
}

/// Time from a signal's change to the first actuation that uses it, and its parts. The figures are
/// medians of p50 over the sessions, ms.
fn way_of_a_change(ways: &[Way]) {
    println!("\n| way | changes | change to actuation | announce | receive | control | actuate |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for way in ways {
        let figure = |pointer: &str| {
            let figures = way.sessions.iter().filter_map(|s| s.pointer(pointer)?.as_f64());
            figures.collect::<Vec<f64>>()
        };
        let changes: f64 = figure("/timing/signal_reaction_us/count").iter().sum();
        if changes == 0.0 {
            continue;
        }
        let hops = ["announce", "receive", "control", "actuate"];
        let hops = hops.map(|hop| format!("/timing/signal_hops_us/{hop}/p50"));
        let columns = ["/timing/signal_reaction_us/p50".to_owned()].into_iter().chain(hops);
        let columns: Vec<_> =
            columns.map(|at| format!("{:.1}", median(figure(&at).into_iter()) / 1e3)).collect();
        println!("| {} | {changes} | {} |", way.name, columns.join(" | "));
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median of p50 over the sessions, and the largest p99.
fn row(way: &Way) {
    let figure = |pointer: &str| {
        let figures = way.sessions.iter().filter_map(|summary| summary.pointer(pointer)?.as_f64());
        let mut figures: Vec<f64> = figures.collect();
        figures.sort_by(f64::total_cmp);
        figures
    };
    let ms = |us: Option<&f64>| us.map_or_else(|| "-".to_owned(), |us| format!("{:.1}", us / 1e3));
    let median = |pointer| {
        let all = figure(pointer);
        ms(all.get(all.len() / 2))
    };
    let largest = |pointer| ms(figure(pointer).last());
    println!(
        "| {} | {} | {} | {} | {} | {} |",
        way.name,
        median("/timing/signal_age_us/p50"),
        largest("/timing/signal_age_us/p99"),
        median("/radio/air_us/p50"),
        largest("/radio/air_us/p99"),
        figure("/timing/signal_age_us/count").iter().sum::<f64>(),
    );
}

/// 20 on-board units, one process each, and one roadside unit.
fn many_vehicles() {
    let mut vehicles: Vec<Peer> = (0..VEHICLES).map(|_| Peer::start(&["vehicle", GROUP])).collect();
    let unit = Command::new(PROGRAM)
        .args(["rsu", "corridor", "--radio", GROUP, "--duration", VEHICLES_S, "--json"])
        .output()
        .expect("the command starts");
    let unit: Value = serde_json::from_slice(&unit.stdout).expect("its summary");
    let lines: Vec<Value> = vehicles
        .iter_mut()
        .map(|vehicle| serde_json::from_str(&vehicle.finish()).expect("its figures"))
        .collect();
    let sum = |key: &str| lines.iter().filter_map(|line| line[key].as_f64()).sum::<f64>();
    let sent = unit["spatem"].as_f64().unwrap_or(0.0) + unit["mapem"].as_f64().unwrap_or(0.0);
    let (frames, accepted) = (sum("frames"), sum("accepted"));
    println!(
        "\n{VEHICLES} on-board units, one roadside unit, UDP to a group, {VEHICLES_S} s: {frames} of {} frames \
         received, {accepted} accepted; processor time of a vehicle {:.0} us/s, {:.0} us/frame; load {}",
        sent * VEHICLES as f64,
        sum("cpu_us") / VEHICLES as f64 / VEHICLES_S.parse::<f64>().expect("a number"),
        sum("cpu_us") / frames.max(1.0),
        load(),
    );
}

/// An on-board unit without a vehicle: receives, decodes and checks until its input ends.
fn vehicle(address: &str) {
    let address: CarrierAddress = address.parse().expect("an address");
    let mut carrier = Carrier::open(&address, Role::Vehicle).expect("a vehicle");
    let mut receiver = Receiver::new(std::process::id(), 500, road_plane(&Origin::default()));
    let start_ns = wall_clock_ns();
    println!("ready");
    let ended = std::thread::spawn(|| std::io::stdin().read_to_end(&mut Vec::new()));
    let (mut frames, mut accepted) = (0_u64, 0_u64);
    let begun_us = processor_us();
    while !ended.is_finished() {
        std::thread::sleep(Duration::from_millis(100));
        let now_ns = wall_clock_ns() - start_ns;
        while let Some(frame) = carrier.receive(0) {
            let ahead_ns = frame.clock.map_or(0, |clock| clock.offset_ns);
            let moment = Moment { now_ns, utc_start_ns: start_ns, ahead_ns };
            let verdict = receiver.take(frame.bytes(), &moment);
            frames += 1;
            accepted += u64::from(verdict == obu::verdict::Verdict::Accepted);
        }
        receiver.forget(now_ns, 0.0);
        let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
        receiver.write(now_ns, 0.0, &mut map, &mut spat);
    }
    let cpu_us = processor_us() - begun_us;
    let figures = serde_json::json!({ "frames": frames, "accepted": accepted, "cpu_us": cpu_us });
    println!("{figures}");
}

/// Processor time of this process, us.
fn processor_us() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 / 1e3
}

fn load() -> String {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    load.split_whitespace().next().unwrap_or("unknown").to_owned()
}
