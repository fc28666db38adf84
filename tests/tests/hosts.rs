//! A vehicle and a roadside unit on two hosts, as network namespaces with simulated air. They drive through
//! `corridor` with delay, jitter, losses, and a cut link that recovers.
//!
//! Needs root, network namespaces and Python for the air (`shared/radio/tests/hosts/air.py`); without them the
//! tests are skipped.

#[path = "../../shared/radio/tests/hosts/namespaces.rs"]
#[allow(dead_code, reason = "stations are for the carriers' own tests")]
mod namespaces;
#[path = "../../shared/radio/examples/station.rs"]
#[allow(dead_code, reason = "its main is the example's")]
mod station;

use libtest_mimic::Failed;
use namespaces::Hosts;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::process::{Child, ExitCode};
use std::time::Duration;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn main() -> ExitCode {
    // A router of zenoh is this program again.
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, rest @ ..] = arguments.as_slice()
        && first == "station"
    {
        return station::status(rest);
    }
    namespaces::conclude(&[
        ("corridor_over_udp_loses_what_the_air_drops_and_nothing_else", udp),
        #[cfg(feature = "zenoh")]
        ("corridor_over_zenoh_with_router_and_tls_comes_back", zenoh),
    ])
}

/// A command of timegap on a host, which ends by itself or with this handle.
struct Running(Option<Child>);

impl Running {
    fn start(corner: &Corner, hosts: &Hosts, host: &str, arguments: &[&str]) -> Self {
        let name = hosts.name(host);
        let inside = ["netns", "exec", &name, PROGRAM];
        Self(Some(corner.start(&[&inside, arguments].concat())))
    }

    fn pid(&self) -> Result<Pid, Failed> {
        let id = self.0.as_ref().map(Child::id).ok_or("it has ended")?;
        Ok(Pid::from_raw(i32::try_from(id)?).ok_or("no process")?)
    }

    /// Waits for its successful end and parses its output.
    fn finish(mut self) -> Result<Value, Failed> {
        let child = self.0.take().ok_or("it has ended")?;
        let output = child.wait_with_output()?;
        if !output.status.success() {
            return Err(text(&output).into());
        }
        Ok(serde_json::from_slice(&output.stdout)?)
    }

    fn stop_and_finish(self) -> Result<Value, Failed> {
        kill_process(self.pid()?, Signal::TERM)?;
        self.finish()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            // It may have ended already.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn pause(seconds: u64) {
    std::thread::sleep(Duration::from_secs(seconds));
}

/// The vehicle starts before the unit, so that it receives all; the unit ends before the vehicle, over good air. The
/// link between them: 10 % loss, 30 % for 2 s, no link for 2 s, 10 % again.
fn drive(hosts: &mut Hosts, unit: &str, vehicle: &str) -> Result<(Value, Value), Failed> {
    let corner = Corner::new("ip");
    let arguments = ["run", "corridor", "--radio", vehicle, "--duration", "26"];
    let options = ["--out", "out", "--no-record", "--json"];
    let vehicle = Running::start(&corner, hosts, "b", &[&arguments[..], &options].concat());
    let live = corner.path().join("out/live.json");
    if !wait_for(|| live.exists()) {
        return Err("the vehicle does not drive".into());
    }
    let roots = corner.roots();
    let arguments = ["rsu", "corridor", "--radio", unit, "--json"];
    let unit = Running::start(&corner, hosts, "a", &arguments);
    pause(2);
    hosts.air("air 20 10 0.1")?;
    pause(6);
    hosts.air("air 20 10 0.3")?;
    pause(2);
    hosts.air("cut")?;
    pause(2);
    hosts.air("air 20 10 0.1")?;
    pause(6);
    hosts.air("air 20 0 0")?;
    pause(2);
    let unit = unit.stop_and_finish()?;
    let vehicle = vehicle.finish()?;
    corner.expect_nothing_left(&roots);
    if vehicle["outcome"] != "completed" || vehicle["link"]["truth_known"] != true {
        return Err(format!("{vehicle:#}").into());
    }
    Ok((unit, vehicle))
}

fn count(of: &Value, key: &str) -> Result<u64, Failed> {
    of[key].as_u64().ok_or_else(|| format!("no {key} in {of:#}").into())
}

fn only_station(of: &Value) -> Result<&Value, Failed> {
    match of["stations"].as_array().map(Vec::as_slice) {
        Some([station]) => Ok(station),
        _ => Err(format!("one station was expected: {of:#}").into()),
    }
}

/// Both hosts are one machine with one clock.
fn check_clock(station: &Value) -> Result<(), Failed> {
    let offset_us = station["clock_offset_us"].as_f64().ok_or("no clock was compared")?;
    let uncertainty_us = station["clock_uncertainty_us"].as_f64().ok_or("no uncertainty")?;
    if offset_us.abs() <= uncertainty_us { Ok(()) } else { Err(format!("{station:#}").into()) }
}

/// The unit receives the vehicle's frames, at most as many as it sent.
fn check_vehicle(unit: &Value, link: &Value) -> Result<(), Failed> {
    let back = only_station(unit)?;
    let heard = count(back, "received")?;
    if heard == 0 || heard + count(back, "lost")? > count(link, "sent")? {
        return Err(format!("{back:#} {link:#}").into());
    }
    match unit["vehicles"].as_array().map(Vec::as_slice) {
        Some([vehicle]) if vehicle["cams"] == heard => Ok(()),
        other => Err(format!("one vehicle was expected: {other:?}").into()),
    }
}

fn udp() -> Result<(), Failed> {
    let mut hosts = Hosts::new()?;
    let group = "udp://239.255.31.9:5520?interface=";
    let (unit, vehicle) = drive(&mut hosts, &format!("{group}a0"), &format!("{group}b0"))?;
    let dropped = hosts.dropped_frames()?;
    let link = &vehicle["link"];
    let station = only_station(link)?;
    check_clock(station)?;
    check_vehicle(&unit, link)?;
    let sent = count(&unit, "spatem")? + count(&unit, "mapem")?;
    let (received, lost) = (count(station, "received")?, count(station, "lost")?);
    if received + lost != sent || lost != dropped {
        let told = format!("{sent} sent, {received} received, {lost} lost, {dropped} dropped");
        return Err(format!("something else was lost than the air dropped: {told}").into());
    }
    if dropped == 0 || count(station, "reordered")? == 0 || station["duplicates"] != 0 {
        return Err(format!("the air did not do its part: {station:#}").into());
    }
    let unread = count(link, "dropped")? + count(link, "malformed")?;
    if unread + count(&vehicle["radio"], "left_out")? > 0 {
        return Err(format!("frames were not read: {link:#}").into());
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
    let (unit, vehicle) = drive(&mut hosts, &client, &client)?;
    let link = &vehicle["link"];
    let station = only_station(link)?;
    check_clock(station)?;
    check_vehicle(&unit, link)?;
    let sent = count(&unit, "spatem")? + count(&unit, "mapem")?;
    if count(station, "received")? + count(station, "lost")? > sent || station["duplicates"] != 0 {
        return Err(format!("{unit:#} {link:#}").into());
    }
    router.finish()?;
    hosts.remove()
}
