//! Two hosts, as network namespaces with simulated air between them. Losses equal the air's exactly, a cut
//! link recovers, clocks are compared throughout, and nothing is left behind.
//!
//! Needs root, network namespaces and Python for the air (`air.py`); without them the tests are skipped.

mod namespaces;
#[path = "../../examples/station.rs"]
#[allow(dead_code, reason = "its main is the example's")]
mod station;

use libtest_mimic::Failed;
use namespaces::{Hosts, Process};
use radio::{RadioReport, StationReport};
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, rest @ ..] = arguments.as_slice()
        && first == "station"
    {
        return station::status(rest);
    }
    namespaces::conclude(&[
        ("udp_loses_what_the_air_drops_and_nothing_else", udp),
        #[cfg(feature = "zenoh")]
        ("zenoh_with_router_and_tls_comes_back", zenoh),
    ])
}

/// Good air, 5 % loss, 30 % loss for 2 s, no link for 1.5 s, 5 %, good air. The vehicle receives frames in each
/// part except the cut.
fn drive(hosts: &mut Hosts, vehicle: &mut Process) -> Result<(), Failed> {
    vehicle.frames(50)?;
    hosts.air("air 20 10 0.05")?;
    vehicle.frames(200)?;
    hosts.air("air 20 10 0.3")?;
    std::thread::sleep(Duration::from_secs(2));
    hosts.air("cut")?;
    // Frames still in the air.
    std::thread::sleep(Duration::from_millis(500));
    let before = vehicle.heard();
    std::thread::sleep(Duration::from_millis(1000));
    if vehicle.heard() != before {
        return Err("frames arrived over a cut link".into());
    }
    hosts.air("air 20 10 0.05")?;
    vehicle.frames(200)?;
    hosts.air("air 20 0 0")?;
    vehicle.frames(50)
}

fn only_station(report: &RadioReport) -> Result<&StationReport, Failed> {
    match report.stations.as_slice() {
        [station] => Ok(station),
        _ => Err(format!("one station was expected: {report:?}").into()),
    }
}

/// Both stations run on one machine with one clock.
fn check_clock(station: &StationReport) -> Result<(), Failed> {
    let clock = station.clock.ok_or("no clock was compared")?;
    let is_right = clock.offset_us.abs() <= clock.uncertainty_us;
    // The shortest path was in a good part.
    if is_right && clock.answers >= 5 { Ok(()) } else { Err(format!("{clock:?}").into()) }
}

fn udp() -> Result<(), Failed> {
    let mut hosts = Hosts::new()?;
    let group = "udp://239.255.31.9:5520?interface=";
    let mut vehicle = hosts.station("b", &[&format!("{group}b0"), "vehicle"])?;
    vehicle.line("ready")?;
    let mut unit = hosts.station("a", &[&format!("{group}a0"), "roadside", "5"])?;
    unit.line("ready")?;
    drive(&mut hosts, &mut vehicle)?;
    let sent = unit.finish()?;
    hosts.quiet()?;
    let dropped = hosts.dropped_frames()?;
    vehicle.until_quiet();
    let received = vehicle.finish()?;
    let station = only_station(&received)?;
    check_clock(station)?;
    let told = format!("{sent:?} {received:?} {dropped}");
    if station.received + station.lost != sent.sent || station.lost != dropped {
        return Err(format!("losses differ from the air's: {told}").into());
    }
    if dropped == 0 || station.reordered == 0 || station.duplicates != 0 {
        return Err(format!("the air dropped nothing: {told}").into());
    }
    hosts.remove()
}

#[cfg(feature = "zenoh")]
fn zenoh() -> Result<(), Failed> {
    let mut hosts = Hosts::new()?;
    let router = hosts.configuration("router")?;
    let client = hosts.configuration("client")?;
    let mut router = hosts.station("a", &[&router, "vehicle"])?;
    router.line("ready")?;
    let mut vehicle = hosts.station("b", &[&client, "vehicle"])?;
    vehicle.line("ready")?;
    let mut unit = hosts.station("a", &[&client, "roadside"])?;
    unit.line("ready")?;
    drive(&mut hosts, &mut vehicle)?;
    let sent = unit.finish()?;
    vehicle.until_quiet();
    let received = vehicle.finish()?;
    let station = only_station(&received)?;
    check_clock(station)?;
    if station.duplicates != 0 || station.received + station.lost > sent.sent {
        return Err(format!("{sent:?} {received:?}").into());
    }
    router.finish()?;
    hosts.remove()
}
