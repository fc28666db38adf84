//! Time to encode and decode a frame: `cargo bench -p its`.
//!
//! Each is timed repeatedly ("warm"), and after reading other memory ("cold"). The second is like a unit that decodes a
//! few frames in 100 ms between other work.

use its::cam::{Cam, LowFrequency, Motion};
use its::geodesy::Position;
use its::geonetworking::{Source, StationType};
use its::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem, STRAIGHT};
use its::spatem::{IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing};
use its::time::{Stamp, TimeMark};
use its::{Frame, Message};
use std::hint::black_box;
use std::time::Instant;

const WARM: usize = 5_000;
const COLD: usize = 200;
/// More than the caches of most processors, bytes.
const OTHER_MEMORY: usize = 64 << 20;

fn main() {
    let other = vec![1_u8; OTHER_MEMORY];
    println!("| frame | bytes | encode warm us | cold us | decode warm us | cold us |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for (name, frame) in frames() {
        let bytes = frame.encode().expect("in range");
        let encode = || drop(black_box(frame.encode()));
        let decode = || drop(black_box(Frame::decode(black_box(&bytes))));
        let figures = [
            median_us(WARM, &[], &encode),
            median_us(COLD, &other, &encode),
            median_us(WARM, &[], &decode),
            median_us(COLD, &other, &decode),
        ];
        let figures = figures.map(|us| format!("{us:.1}")).join(" | ");
        println!("| {name} | {} | {figures} |", bytes.len());
    }
}

/// The median time of `what`, µs. All of `other` is read before each time.
fn median_us(times: usize, other: &[u8], what: &dyn Fn()) -> f64 {
    let mut taken: Vec<f64> = (0..times)
        .map(|_| {
            black_box(other.iter().step_by(64).map(|byte| u64::from(*byte)).sum::<u64>());
            let begun = Instant::now();
            what();
            begun.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    taken.sort_by(f64::total_cmp);
    taken[times / 2]
}

/// Frames as from `v2x-sim`: two signal groups, three lanes.
fn frames() -> [(&'static str, Frame); 3] {
    let source = Source {
        station_type: StationType::RoadsideUnit,
        address: 1,
        timestamp: 694_310_405,
        position: Position { latitude: 487_000_000, longitude: 91_000_000 },
        accurate: true,
        speed: 0,
        heading: 0,
    };
    [
        ("SPATEM", Message::Spatem(spatem())),
        ("MAPEM", Message::Mapem(mapem())),
        ("CAM", Message::Cam(cam())),
    ]
    .map(|(name, message)| (name, Frame { source, message }))
}

fn spatem() -> Spatem {
    let mark = |value| TimeMark::new(value).expect("in range");
    let event = |state, end| {
        let (min_end, max_end, likely_end) = (mark(end), Some(mark(end)), Some(mark(end)));
        let (start, confidence, next) = (None, Some(15), None);
        let timing = Timing { start, min_end, max_end, likely_end, confidence, next };
        MovementEvent { state, timing: Some(timing) }
    };
    let events = [
        MovementPhase::ProtectedMovementAllowed,
        MovementPhase::ProtectedClearance,
        MovementPhase::StopAndRemain,
        MovementPhase::ProtectedMovementAllowed,
    ];
    let events: Vec<_> =
        events.into_iter().zip(1..).map(|(state, n)| event(state, 100 * n)).collect();
    let turning = vec![event(MovementPhase::StopAndRemain, 36_000)];
    let movement = |signal_group, events| MovementState { signal_group, events };
    let state = IntersectionState {
        region: None,
        id: 1,
        revision: 0,
        status: 0,
        stamp: Some(Stamp { minute_of_year: 218_159, millisecond: 30_000 }),
        movements: vec![movement(1, events), movement(2, turning)],
    };
    Spatem { station_id: 100_001, intersections: vec![state] }
}

fn mapem() -> Mapem {
    let lane = |id, approach, nodes: [(i16, i16); 2], signal_group: Option<u8>| Lane {
        id,
        approach,
        maneuvers: STRAIGHT,
        nodes: nodes.to_vec(),
        connections: signal_group
            .map(|group| Connection {
                lane: 201,
                maneuver: Some(STRAIGHT),
                signal_group: Some(group),
            })
            .into_iter()
            .collect(),
    };
    let lanes = vec![
        lane(1, Approach::Ingress(1), [(-1000, 0), (-10_000, 0)], Some(1)),
        lane(101, Approach::Ingress(1), [(-1000, 350), (-10_000, 0)], Some(2)),
        lane(201, Approach::Egress(2), [(1000, 0), (10_000, 0)], None),
    ];
    let geometry = IntersectionGeometry {
        region: None,
        id: 1,
        revision: 0,
        reference: Position { latitude: 487_000_000, longitude: 91_000_000 },
        lane_width_cm: Some(350),
        lanes,
        unread_lanes: 0,
    };
    Mapem { station_id: 100_001, revision: 0, intersections: vec![geometry] }
}

fn cam() -> Cam {
    Cam {
        station_id: 4711,
        generation_delta: 1000,
        station_type: 5,
        position: Position { latitude: 487_000_000, longitude: 91_000_000 },
        motion: Motion {
            heading: 900,
            speed: 1389,
            acceleration: 0,
            yaw_rate: 0,
            length: 45,
            width: 19,
        },
        low_frequency: Some(LowFrequency { role: 0, lights: 0 }),
    }
}
