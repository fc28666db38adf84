//! `timegap rsu`: the roadside units of a scenario alone, for vehicles on other hosts.

use clap::Args;
use its::{EncodeError, Message, MessageKind};
use radio::{Carrier, Role, StationReport, wall_clock_ns};
use report::print;
use report::results::{Column, Document, Table, count, number};
use scenario::carrier::CarrierAddress;
use scenario::{Scenario, Setting};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use supervise::{Error, ScenarioOptions, UsageError, number_within, open};
use v2x_sim::frames::Frames;

/// Longest delay of an end by signal.
const SLICE: Duration = Duration::from_millis(50);
const MOST_VEHICLES: usize = 1000;

#[derive(Debug, Args)]
pub struct RsuArguments {
    /// Name of a built-in scenario (see `timegap list`) or a TOML file with the signals
    #[arg(default_value = "corridor")]
    pub scenario: String,
    /// Destination: udp://ADDRESS:PORT, zenoh, zenoh:FILE.json5 [default: the scenario's `v2x.radio`]
    #[arg(long, value_name = "ADDRESS")]
    pub radio: Option<String>,
    /// Duration, s [default: until Ctrl-C or SIGTERM]
    #[arg(long, value_name = "SECONDS", value_parser = number_within(0.001..=1e9, "a number of seconds"), allow_hyphen_values = true)]
    pub duration: Option<f64>,
    /// Change a key of the scenario, by its dotted path (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<Setting>,
    /// Print the counts as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct RsuSummary {
    schema_version: u32,
    scenario: String,
    carrier: String,
    duration_s: f64,
    /// SPATEM passed to the network.
    spatem: u64,
    /// MAPEM passed to the network.
    mapem: u64,
    not_sent: u64,
    /// Frames received, without repeats.
    received: u64,
    /// Received frames of other message types.
    not_read: u64,
    dropped: u64,
    vehicles: Vec<Vehicle>,
    /// Station ids that several senders use.
    shared_station_ids: Vec<u32>,
    /// Senders, by the numbers of their frames.
    stations: Vec<StationReport>,
}

/// Sender of a CAM: station id, number in timegap's envelope if any, and GeoNetworking address. Two vehicles
/// may share a station id.
type Sender = (u32, Option<u64>, u64);

#[derive(Clone, Copy, Debug, Serialize)]
struct Vehicle {
    station_id: u32,
    cams: u64,
    position_m: f64,
    speed_mps: f64,
}

pub fn run(arguments: &RsuArguments) -> Result<ExitCode, Error> {
    let options = ScenarioOptions {
        set: arguments.set.clone(),
        radio: arguments.radio.clone(),
        ..ScenarioOptions::default()
    };
    let scenario = open(&arguments.scenario, &options)?;
    let address = scenario.v2x.radio.carrier().ok_or_else(|| {
        let expected = "udp://ADDRESS:PORT, zenoh or zenoh:FILE.json5";
        UsageError::at("missing --radio", "the scenario has no `v2x.radio`", expected)
    })?;
    if scenario.v2x.signals.is_empty() {
        return Err(UsageError::at(scenario.name.as_str(), "no signals", "one at least").into());
    }
    let mut unit = RoadsideUnit::open(&scenario, address)?;
    let stop = Arc::new(AtomicBool::new(false));
    supervise::flag_end(&stop)?;
    print::note(&format!("{} on {address}", scenario.name.as_str()));
    unit.send_until(arguments.duration.map(Duration::from_secs_f64), &stop)?;
    let summary = unit.summary(&scenario);
    print::show(arguments.json, &document(&summary))?;
    Ok(ExitCode::SUCCESS)
}

fn not_encoded(why: EncodeError) -> UsageError {
    UsageError::at("v2x.signals", why, "signals that the standards can express")
}

struct RoadsideUnit {
    frames: Frames,
    carrier: Carrier,
    period: Duration,
    begun: Instant,
    start_ns: i64,
    sent: HashMap<MessageKind, u64>,
    vehicles: BTreeMap<Sender, Vehicle>,
    not_read: u64,
}

impl RoadsideUnit {
    fn open(scenario: &Scenario, address: &CarrierAddress) -> Result<Self, UsageError> {
        let frames = Frames::new(scenario);
        let (begun, start_ns) = (Instant::now(), wall_clock_ns());
        // Report signals that cannot be encoded at once.
        frames.at(0, start_ns, None, None).map_err(not_encoded)?;
        let carrier = Carrier::open(address, Role::Roadside { start_ns })
            .map_err(|why| UsageError::at("radio", why, "an address that can be used"))?;
        Ok(Self {
            frames,
            carrier,
            period: Duration::from_nanos(scenario.v2x.period_ms.nanoseconds()),
            begun,
            start_ns,
            sent: HashMap::new(),
            vehicles: BTreeMap::new(),
            not_read: 0,
        })
    }

    /// Sends the frames of each period; skips periods that are over before their turn.
    fn send_until(&mut self, end: Option<Duration>, stop: &AtomicBool) -> Result<(), UsageError> {
        let mut next = self.begun.elapsed().div_duration_f64(self.period).ceil();
        loop {
            let due = self.period.mul_f64(next);
            if end.is_some_and(|end| due >= end) {
                return Ok(());
            }
            while let Some(left) = due.checked_sub(self.begun.elapsed()) {
                if stop.load(Ordering::Relaxed) {
                    return Ok(());
                }
                self.receive();
                std::thread::sleep(left.min(SLICE));
            }
            let time_ns = u64::try_from(due.as_nanos()).unwrap_or(u64::MAX);
            for frame in self.frames.at(time_ns, self.start_ns, None, None).map_err(not_encoded)? {
                // The carrier counts unsent frames.
                if self.carrier.send(&frame.bytes).is_ok() {
                    *self.sent.entry(frame.kind).or_default() += 1;
                }
            }
            next = (next + 1.0).max(self.begun.elapsed().div_duration_f64(self.period).floor());
        }
    }

    fn receive(&mut self) {
        while let Some(frame) = self.carrier.receive(0) {
            let Ok((its::Frame { message: Message::Cam(cam), source }, _)) =
                its::signed::decode(frame.bytes())
            else {
                self.not_read += 1;
                continue;
            };
            let sender = (cam.station_id, frame.sender, source.address);
            if self.vehicles.len() == MOST_VEHICLES && !self.vehicles.contains_key(&sender) {
                self.not_read += 1;
                continue;
            }
            let cams = self.vehicles.get(&sender).map_or(0, |vehicle| vehicle.cams);
            let vehicle = Vehicle {
                station_id: cam.station_id,
                cams: cams + 1,
                position_m: self.frames.path.plane.point(cam.position).0,
                speed_mps: f64::from(cam.motion.speed) / 100.0,
            };
            self.vehicles.insert(sender, vehicle);
        }
    }

    /// Station ids that several senders use: two vehicles, or a restarted one.
    fn shared_station_ids(&self) -> Vec<u32> {
        let ids: Vec<u32> = self.vehicles.keys().map(|(station_id, ..)| *station_id).collect();
        let shared = ids.chunk_by(|a, b| a == b).filter(|senders| senders.len() > 1);
        shared.map(|senders| senders[0]).collect()
    }

    fn summary(&mut self, scenario: &Scenario) -> RsuSummary {
        self.receive();
        let report = self.carrier.report();
        let sent = |kind| self.sent.get(&kind).copied().unwrap_or(0);
        RsuSummary {
            schema_version: 1,
            scenario: scenario.name.as_str().to_owned(),
            carrier: report.carrier,
            duration_s: self.begun.elapsed().as_secs_f64(),
            spatem: sent(MessageKind::Spatem),
            mapem: sent(MessageKind::Mapem),
            not_sent: report.not_sent,
            received: report.received,
            not_read: self.not_read + report.malformed,
            dropped: report.dropped,
            vehicles: self.vehicles.values().copied().collect(),
            shared_station_ids: self.shared_station_ids(),
            stations: report.stations,
        }
    }
}

fn document(summary: &RsuSummary) -> Document {
    let RsuSummary { scenario, carrier, duration_s, spatem, mapem, not_sent, .. } = summary;
    let lost: u64 = summary.stations.iter().map(|station| station.lost).sum();
    let (received, not_read) = (summary.received, summary.not_read);
    let mut facts = vec![
        ("sent", format!("{spatem} SPATEM, {mapem} MAPEM; {not_sent} frames could not be sent")),
        ("received", format!("{received} frames, {lost} lost, {not_read} not read")),
    ];
    let shared = summary.shared_station_ids.iter();
    facts.extend(shared.map(|id| ("", format!("station id {id} is used by several senders"))));
    if summary.vehicles.is_empty() {
        facts.push(("vehicles", "none heard".to_owned()));
    }
    let columns: [Column<Vehicle>; 4] = [
        count("station_id", "station", "Station id of the vehicle"),
        count("cams", "CAMs", "Messages that were received"),
        number("position_m", "last at", "m", 1, "Last place along the road"),
        number("speed_mps", "with", "m/s", 1, "Last speed"),
    ];
    Document::new("rsu", "Roadside unit", summary)
        .about(format!("{scenario} on {carrier}, {duration_s:.1} s"))
        .facts("Frames", facts)
        .table(Table::new("Vehicles", &columns, &summary.vehicles))
}
