//! Times in a recording: cycles of the services, chains through them, incidents.

use messages::{
    AllVehicles, Command, Header, Message, MoreVehicles, Odometry, RadarTracks, Service,
    VehicleTruth,
};
use recorder::Record;
use runtime::Timetable;
use scenario::Scenario;
use std::collections::BTreeMap;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Cycles of all services, in order of service and time.
    pub cycles: Vec<Cycle>,
    /// Chains from the radar through the controller to the plant.
    pub chains: Vec<Chain>,
    pub incidents: Vec<Incident>,
    /// Of each figure in [`COUNTERS`]: (ns of run time, value).
    pub counters: [Vec<(i64, f64)>; COUNTERS.len()],
}

/// A cycle, from its scheduled release to its last published message.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    pub service: Service,
    /// Number of its restart.
    pub incarnation: u32,
    pub step: u64,
    pub release_ns: i64,
    /// Start of its work, if the service's messages carry it.
    pub start_ns: Option<i64>,
    pub finish_ns: i64,
}

/// Cycles that processed a radar sample, as indices into the cycles; `None` for an unrecorded one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chain {
    /// Number, equal in every part of the recording.
    pub flow: u64,
    pub radar: Option<usize>,
    /// Publication of the radar's message.
    pub radar_publish_ns: i64,
    pub control: usize,
    /// The plant's first cycle that acted on it.
    pub plant: Option<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Incident {
    /// The affected service, if there is one.
    pub service: Option<Service>,
    pub at_ns: i64,
    pub what: String,
}

impl Timeline {
    /// Times of a part of a recording of `scenario`; `carried` are the latest cycles before it.
    pub fn of(records: &[Record], carried: &[Cycle], scenario: &Scenario) -> Self {
        let table = Timetable::of(scenario);
        let deadline_ns = i64::from(scenario.controller.deadline().value()) * 1_000_000;
        let cycles = cycles(records, carried);
        let chains = chains(records, &cycles);
        let mut incidents = misses(&cycles, deadline_ns);
        incidents.extend(left_out(&cycles, &table));
        incidents.extend(restarts(&cycles));
        incidents.sort_by_key(|incident| incident.at_ns);
        Self { cycles, chains, incidents, counters: counters(records) }
    }

    /// The last cycle of each service that was released before `at_ns`.
    pub fn last_before(&self, at_ns: i64) -> Vec<Cycle> {
        let before = self.cycles.iter().filter(|cycle| cycle.release_ns < at_ns);
        let last: BTreeMap<_, _> = before.map(|cycle| (cycle.service, cycle)).collect();
        last.into_values().cloned().collect()
    }
}

fn messages<T: Message>(records: &[Record]) -> impl Iterator<Item = T> + '_ {
    records.iter().filter_map(Record::message)
}

/// The cycles behind all messages; messages of one service, incarnation and step are of one cycle.
fn cycles(records: &[Record], carried: &[Cycle]) -> Vec<Cycle> {
    let key = |cycle: &Cycle| (cycle.service.index(), cycle.incarnation, cycle.step);
    let mut cycles: BTreeMap<(usize, u32, u64), Cycle> =
        carried.iter().map(|cycle| (key(cycle), cycle.clone())).collect();
    for record in records {
        // Heartbeats do not belong to a cycle.
        if record.topic.sources().is_empty() {
            continue;
        }
        let header = record.header();
        let start_ns = record.message::<Command>().map(|command| command.start_ns);
        let sender = |service: &Service| service.to_wire() == header.source;
        let Some(service) = Service::ALL.into_iter().find(sender) else { continue };
        let key = (service.index(), header.incarnation, header.step);
        let cycle = cycles.entry(key).or_insert(Cycle {
            service,
            incarnation: header.incarnation,
            step: header.step,
            release_ns: header.acquisition_ns,
            start_ns: None,
            finish_ns: header.publish_ns,
        });
        // A radar with latency acquires before its release.
        cycle.release_ns = cycle.release_ns.max(header.acquisition_ns);
        cycle.start_ns = cycle.start_ns.or(start_ns);
        cycle.finish_ns = cycle.finish_ns.max(header.publish_ns);
    }
    cycles.into_values().collect()
}

/// The chain of every command that was computed from a radar sample.
fn chains(records: &[Record], cycles: &[Cycle]) -> Vec<Chain> {
    let index: BTreeMap<(usize, u32, u64), usize> = (cycles.iter().enumerate())
        .map(|(at, cycle)| ((cycle.service.index(), cycle.incarnation, cycle.step), at))
        .collect();
    let cycle_of = |service: Service, header: &Header| {
        index.get(&(service.index(), header.incarnation, header.step)).copied()
    };
    // A sample is identified by its publication time, since numbers restart with the process.
    let radars: BTreeMap<i64, Option<usize>> = messages::<RadarTracks>(records)
        .map(|radar| radar.header)
        .map(|header| (header.publish_ns, cycle_of(Service::PerceptionSim, &header)))
        .collect();
    let acted = first_actuations(records, cycle_of);
    messages::<Command>(records)
        .filter(|command| command.header.origins.radar.is_some())
        .filter_map(|command| {
            let header = command.header;
            let radar_ns = header.origins.radar.publish_ns;
            Some(Chain {
                flow: u64::from(header.incarnation) << 40 | (header.step + 1),
                radar: radars.get(&radar_ns).copied().flatten(),
                radar_publish_ns: radar_ns,
                control: cycle_of(Service::Controller, &header)?,
                plant: acted.get(&radar_ns).copied(),
            })
        })
        .collect()
}

/// The plant's cycle in which each radar sample, by its publication, first reached the actuators. It is the cycle
/// before the odometry that first names it.
fn first_actuations(
    records: &[Record],
    cycle_of: impl Fn(Service, &Header) -> Option<usize>,
) -> BTreeMap<i64, usize> {
    let mut acted = BTreeMap::new();
    let mut before: Option<Header> = None;
    for odometry in messages::<Odometry>(records) {
        let header = odometry.header;
        if let Some(before) = &before
            && header.origins.radar.is_some()
            && let Some(cycle) = cycle_of(Service::Plant, before)
        {
            acted.entry(header.origins.radar.publish_ns).or_insert(cycle);
        }
        before = Some(header);
    }
    acted
}

/// Control cycles that finished after their deadline.
fn misses(cycles: &[Cycle], deadline_ns: i64) -> Vec<Incident> {
    let late = cycles.iter().filter(|cycle| cycle.missed(deadline_ns));
    late.map(|cycle| Incident {
        service: Some(cycle.service),
        at_ns: cycle.release_ns + deadline_ns,
        what: "deadline missed".into(),
    })
    .collect()
}

impl Cycle {
    /// True if a control cycle finished later than `deadline_ns` after its release.
    pub fn missed(&self, deadline_ns: i64) -> bool {
        self.service == Service::Controller && self.finish_ns - self.release_ns > deadline_ns
    }
}

/// Scheduled releases without a cycle, between two cycles of the same incarnation.
fn left_out(cycles: &[Cycle], table: &Timetable) -> Vec<Incident> {
    let mut incidents = Vec::new();
    for pair in cycles.windows(2) {
        let [before, after] = pair else { continue };
        if (before.service, before.incarnation) != (after.service, after.incarnation) {
            continue;
        }
        let stride = table.stride(before.service);
        let mut step = table.latest_release(before.service, before.step) + stride;
        while step < after.step {
            incidents.push(Incident {
                service: Some(before.service),
                at_ns: i64::try_from(step).map_or(i64::MAX, |step| step * table.step_ns),
                what: "release skipped".into(),
            });
            step += stride;
        }
    }
    incidents
}

/// First cycles of restarted services.
fn restarts(cycles: &[Cycle]) -> Vec<Incident> {
    let pairs = cycles.windows(2).filter(|pair| {
        pair[0].service == pair[1].service && pair[0].incarnation < pair[1].incarnation
    });
    pairs
        .map(|pair| Incident {
            service: Some(pair[1].service),
            at_ns: pair[1].release_ns,
            what: format!("back after restart {}", pair[1].incarnation),
        })
        .collect()
}

fn counters(records: &[Record]) -> [Vec<(i64, f64)>; COUNTERS.len()] {
    let odometry = |value: fn(&Odometry) -> f64| -> Vec<(i64, f64)> {
        let samples = messages::<Odometry>(records);
        samples.map(|odometry| (odometry.header.acquisition_ns, value(&odometry))).collect()
    };
    let mut ego_m = messages::<Odometry>(records).peekable();
    let mut position_m = None;
    let mut gaps = Vec::new();
    let mut more = messages::<MoreVehicles>(records).peekable();
    for truth in messages::<VehicleTruth>(records) {
        while more.next_if(|more| more.header.step < truth.header.step).is_some() {}
        let mut all = AllVehicles::of(&truth);
        all.take(&truth, more.peek().filter(|more| more.header.step == truth.header.step));
        while let Some(ego) = ego_m.next_if(|o| o.header.step <= truth.header.step) {
            position_m = Some(ego.position_m);
        }
        let gap = position_m.and_then(|ego_m| all.nearest_ahead(ego_m));
        gaps.extend(gap.map(|(gap_m, _)| (truth.header.acquisition_ns, gap_m)));
    }
    [odometry(|o| o.speed_mps), odometry(|o| o.request_mps2), gaps]
}

/// Names and units of the drive's figures.
pub const COUNTERS: [(&str, &str); 3] = [("speed", "m/s"), ("request", "m/s²"), ("gap", "m")];
