//! A timeline as a Perfetto trace.

use super::proto::{
    Clock, ClockSnapshot, CounterDescriptor, DebugAnnotation, EXPLICIT, EventType, RUN_TIME_CLOCK,
    STATE_CLEARED, Trace, TracePacket, TrackDescriptor, TrackEvent, WALL_CLOCK,
};
use super::timeline::{self, Cycle, Timeline};
use messages::Service;
use prost::Message;
use std::collections::BTreeMap;
use std::ops::Range;

/// Track above all others.
const RUN: u64 = 1;
/// Track of incidents without a service.
const INCIDENTS: u64 = 2;
/// First of the services' tracks.
const SERVICES: u64 = 10_000;
/// First of the counters' tracks.
const COUNTERS: u64 = 20_000;

/// Names of the tracks, and settings of the run.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    pub title: String,
    /// Run time 0 in ns since 1970.
    pub started_unix_ns: i64,
    /// Scheduling of each service as the kernel granted it, in words.
    pub granted: BTreeMap<Service, String>,
    /// Deadline of the control cycles, ns.
    pub deadline_ns: i64,
}

/// Start of a trace: clocks and tracks.
pub fn begin(frame: &Frame) -> Vec<u8> {
    let mut packets = vec![first_packet(frame)];
    packets.extend(
        tracks(frame)
            .into_iter()
            .map(|track| TracePacket { track_descriptor: Some(track), ..packet() }),
    );
    Trace { packet: packets }.encode_to_vec()
}

/// Events of `timeline` that begin in `within`, ns of run time. A trace is the output of [`begin`] and any
/// number of these, one after the other.
pub fn events(timeline: &Timeline, frame: &Frame, within: &Range<i64>) -> Vec<u8> {
    let mut events = cycles(timeline, frame, within);
    events.extend(publications(timeline).into_iter().filter(|event| within.contains(&event.0)));
    let incidents = timeline.incidents.iter().filter(|incident| within.contains(&incident.at_ns));
    events.extend(incidents.map(|incident| {
        let track = incident.service.map_or(INCIDENTS, service_track);
        let category =
            if incident.what == "deadline missed" { "deadline-miss" } else { "incident" };
        (incident.at_ns, event(EventType::Instant, track, category, &incident.what))
    }));
    for (index, counter) in timeline.counters.iter().enumerate() {
        let samples = counter.iter().filter(|(at_ns, _)| within.contains(at_ns));
        events.extend(samples.map(|(at_ns, value)| {
            let track_event = TrackEvent {
                r#type: Some(EventType::Counter as i32),
                track_uuid: Some(COUNTERS + index as u64),
                double_counter_value: Some(*value),
                ..TrackEvent::default()
            };
            (*at_ns, track_event)
        }));
    }
    // Stable: begin and end at one instant on one track keep their order.
    events.sort_by_key(|event| event.0);
    let packets = events.into_iter().map(|(at_ns, track_event)| TracePacket {
        timestamp: Some(at_ns.max(0).unsigned_abs()),
        track_event: Some(track_event),
        ..packet()
    });
    Trace { packet: packets.collect() }.encode_to_vec()
}

fn packet() -> TracePacket {
    TracePacket { trusted_packet_sequence_id: Some(1), ..TracePacket::default() }
}

fn first_packet(frame: &Frame) -> TracePacket {
    let clock = |id, timestamp: i64| Clock {
        clock_id: Some(id),
        timestamp: Some(timestamp.max(0).unsigned_abs()),
    };
    TracePacket {
        sequence_flags: Some(STATE_CLEARED),
        clock_snapshot: Some(ClockSnapshot {
            clocks: vec![clock(RUN_TIME_CLOCK, 0), clock(WALL_CLOCK, frame.started_unix_ns)],
            primary_trace_clock: Some(RUN_TIME_CLOCK),
        }),
        ..packet()
    }
}

fn service_track(service: Service) -> u64 {
    SERVICES + service.index() as u64
}

/// The run, and below it incidents, services in the order of the data flow, and figures.
fn tracks(frame: &Frame) -> Vec<TrackDescriptor> {
    let mut rank = 0;
    let mut child = |uuid: u64, name: String| {
        rank += 1;
        TrackDescriptor {
            uuid: Some(uuid),
            name: Some(name),
            parent_uuid: Some(RUN),
            sibling_order_rank: Some(rank),
            ..TrackDescriptor::default()
        }
    };
    let mut tracks = vec![
        TrackDescriptor {
            uuid: Some(RUN),
            name: Some(frame.title.clone()),
            child_ordering: Some(EXPLICIT),
            ..TrackDescriptor::default()
        },
        child(INCIDENTS, "faults".into()),
    ];
    let mut in_order = Service::ALL;
    in_order.sort_by_key(|service| service.descriptor().track);
    for service in in_order {
        let granted = frame.granted.get(&service).map_or("", String::as_str);
        let name = format!("{service} {granted}").trim_end().to_owned();
        tracks.push(child(service_track(service), name));
    }
    for (index, (name, unit)) in timeline::COUNTERS.into_iter().enumerate() {
        let track = child(COUNTERS + index as u64, name.into());
        let unit = CounterDescriptor { unit_name: Some(unit.into()) };
        tracks.push(TrackDescriptor { counter: Some(unit), ..track });
    }
    tracks
}

type Event = (i64, TrackEvent);

fn event(kind: EventType, track: u64, category: &str, name: &str) -> TrackEvent {
    TrackEvent {
        r#type: Some(kind as i32),
        track_uuid: Some(track),
        categories: vec![category.into()],
        name: Some(name.into()),
        ..TrackEvent::default()
    }
}

fn end(track: u64) -> TrackEvent {
    TrackEvent {
        r#type: Some(EventType::SliceEnd as i32),
        track_uuid: Some(track),
        ..TrackEvent::default()
    }
}

/// A slice for every cycle, with its wait for the start inside if known. The arrows are the chains through controller
/// and plant.
fn cycles(timeline: &Timeline, frame: &Frame, within: &Range<i64>) -> Vec<Event> {
    let mut leaving: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
    let mut arriving: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
    for chain in &timeline.chains {
        leaving.entry(chain.control).or_default().push(chain.flow);
        if let Some(cycle) = chain.plant {
            arriving.entry(cycle).or_default().push(chain.flow);
        }
    }
    let mut events = Vec::new();
    let mut last: Option<(Service, i64)> = None;
    for (index, cycle) in timeline.cycles.iter().enumerate() {
        let track = service_track(cycle.service);
        // A cycle whose predecessor overran its release begins at the predecessor's end.
        let free_ns = last.filter(|(service, _)| *service == cycle.service).map(|(_, ns)| ns);
        let begin_ns = cycle.release_ns.max(free_ns.unwrap_or(i64::MIN));
        let finish_ns = cycle.finish_ns.max(begin_ns);
        last = Some((cycle.service, finish_ns));
        if !within.contains(&cycle.release_ns) {
            continue;
        }
        let missed = cycle.missed(frame.deadline_ns);
        let category = if missed { "cycle,deadline-miss" } else { "cycle" };
        let mut begin = event(EventType::SliceBegin, track, category, "cycle");
        begin.categories = category.split(',').map(Into::into).collect();
        let flows = leaving.remove(&index).unwrap_or_default();
        let started = cycle.start_ns.filter(|ns| (begin_ns..finish_ns).contains(ns));
        if started.is_none() {
            begin.flow_ids.clone_from(&flows);
        }
        begin.terminating_flow_ids = arriving.remove(&index).unwrap_or_default();
        begin.debug_annotations = annotations(cycle);
        events.push((begin_ns, begin));
        if let Some(start_ns) = started {
            // Arrows end at the slice that processes the sample.
            let mut compute = event(EventType::SliceBegin, track, "compute", "compute");
            compute.flow_ids = flows;
            events.push((begin_ns, event(EventType::SliceBegin, track, "wait", "wait")));
            events.push((start_ns, end(track)));
            events.push((start_ns, compute));
            events.push((finish_ns, end(track)));
        }
        events.push((finish_ns, end(track)));
    }
    events
}

fn annotations(cycle: &Cycle) -> Vec<DebugAnnotation> {
    let number = |name: &str, value: i64| DebugAnnotation {
        name: Some(name.into()),
        int_value: Some(value),
    };
    vec![
        number("step", cycle.step.cast_signed()),
        number("release_ns", cycle.release_ns),
        number("latency_ns", cycle.finish_ns - cycle.release_ns),
        number("incarnation", cycle.incarnation.into()),
    ]
}

/// Publications of the radar messages behind commands, where the arrows begin.
fn publications(timeline: &Timeline) -> Vec<Event> {
    let mut flows: BTreeMap<(usize, i64), Vec<u64>> = BTreeMap::new();
    for chain in &timeline.chains {
        if let Some(radar) = chain.radar {
            flows.entry((radar, chain.radar_publish_ns)).or_default().push(chain.flow);
        }
    }
    let publication = |((radar, at_ns), flow_ids): ((usize, i64), Vec<u64>)| {
        let track = service_track(timeline.cycles[radar].service);
        let instant = event(EventType::Instant, track, "publication", "radar published");
        (at_ns, TrackEvent { flow_ids, ..instant })
    };
    flows.into_iter().map(publication).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::timeline::{Chain, Incident};

    fn cycle(service: Service, step: u64, release_ns: i64, finish_ns: i64) -> Cycle {
        Cycle { service, incarnation: 0, step, release_ns, start_ns: None, finish_ns }
    }

    fn decoded(timeline: &Timeline) -> Vec<TracePacket> {
        let frame = Frame { deadline_ns: 100, ..Frame::default() };
        let bytes = [begin(&frame), events(timeline, &frame, &(i64::MIN..i64::MAX))].concat();
        Trace::decode(bytes.as_slice()).expect("what was encoded").packet
    }

    /// Depth of every track after each event; never below zero, zero at the end.
    fn balanced(packets: &[TracePacket]) {
        let mut depth: BTreeMap<u64, i32> = BTreeMap::new();
        let mut time = 0;
        for packet in packets {
            let Some(event) = &packet.track_event else { continue };
            let at = packet.timestamp.expect("events have a time");
            assert!(at >= time, "in order of time");
            time = at;
            let depth = depth.entry(event.track_uuid.expect("on a track")).or_default();
            match event.r#type() {
                EventType::SliceBegin => *depth += 1,
                EventType::SliceEnd => *depth -= 1,
                EventType::Instant | EventType::Counter => {}
            }
            assert!(*depth >= 0, "a slice ended before it began");
        }
        assert!(depth.values().all(|depth| *depth == 0), "{depth:?}");
    }

    #[test]
    fn slices_nest_and_arrows_join_the_chain() {
        let mut control = cycle(Service::Controller, 0, 0, 90);
        control.start_ns = Some(40);
        let timeline = Timeline {
            cycles: vec![
                cycle(Service::Plant, 0, 0, 10),
                cycle(Service::Plant, 1, 100, 110),
                cycle(Service::PerceptionSim, 0, 0, 30),
                control,
            ],
            chains: vec![Chain {
                flow: 1,
                radar: Some(2),
                radar_publish_ns: 25,
                control: 3,
                plant: Some(1),
            }],
            ..Timeline::default()
        };
        let packets = decoded(&timeline);
        balanced(&packets);
        let events: Vec<_> = packets.iter().filter_map(|p| p.track_event.as_ref()).collect();
        let with_flow = events.iter().filter(|event| event.flow_ids == [1]).count();
        let ending: Vec<_> = events.iter().filter(|e| e.terminating_flow_ids == [1]).collect();
        assert_eq!((with_flow, ending.len()), (2, 1));
        assert_eq!(ending[0].track_uuid, Some(service_track(Service::Plant)));
        assert!(events.iter().any(|event| event.name() == "compute"));
        let radar = packets.iter().find(|packet| {
            packet.track_event.as_ref().is_some_and(|event| event.name() == "radar published")
        });
        let radar = radar.expect("the arrow begins at the publication");
        assert_eq!(radar.timestamp, Some(25), "neither at the release nor at the cycle's end");
        assert_eq!(radar.track_event.as_ref().map(|e| e.flow_ids.clone()), Some(vec![1]));
    }

    #[test]
    fn no_track_pretends_to_show_a_processor() {
        let timeline =
            Timeline { cycles: vec![cycle(Service::Plant, 0, 0, 10)], ..Timeline::default() };
        let names =
            decoded(&timeline).into_iter().filter_map(|packet| packet.track_descriptor?.name);
        let names: Vec<_> = names.collect();
        assert!(names.iter().all(|name| !name.starts_with("core")), "{names:?}");
    }

    #[test]
    fn an_overrun_does_not_tear_its_track() {
        let timeline = Timeline {
            cycles: vec![
                cycle(Service::Controller, 0, 0, 250),
                cycle(Service::Controller, 1, 100, 260),
                cycle(Service::Controller, 2, 200, 240),
            ],
            incidents: vec![Incident {
                service: Some(Service::Controller),
                at_ns: 100,
                what: "deadline missed".into(),
            }],
            ..Timeline::default()
        };
        let packets = decoded(&timeline);
        balanced(&packets);
        let missed = packets.iter().filter_map(|packet| packet.track_event.as_ref());
        let missed = missed.filter(|event| event.categories.iter().any(|c| c == "deadline-miss"));
        assert_eq!(missed.count(), 3, "two slices and the instant");
    }
}
