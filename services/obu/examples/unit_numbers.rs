//! Effect of each number of the on-board unit.
//!
//! ```sh
//! cargo run --release -p obu --example unit_numbers
//! ```
//!
//! Each number is halved and doubled, within its range, while all others keep their values. A vehicle drives with
//! 15 m/s past a signal at 600 m, once for each condition of [`CONDITIONS`]. The service's own numbers act outside the
//! receiver, and so do not change these figures.

use bytemuck::Zeroable;
use its::geonetworking::{Source, StationType};
use its::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem, STRAIGHT};
use its::spatem::{IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing};
use its::time::{Stamp, TimeMark, its_timestamp};
use its::{Frame, Message};
use messages::{Map, Spat};
use obu::clock::Moment;
use obu::lanes::road_plane;
use obu::numbers::Numbers;
use obu::receiver::Receiver;
use parameters::effect::{Figure, effects};
use scenario::radio::Origin;

const START_NS: i64 = 1_780_315_200_000_000_000;
const STEP_MS: i64 = 100;
const END_MS: i64 = 80_000;
const SPEED_MPS: f64 = 15.0;
const LINE_M: f64 = 600.0;
const UNIT: u32 = 100_001;
const OTHER: u32 = 200_001;

/// Condition of a drive.
#[derive(Clone, Copy, PartialEq)]
enum Condition {
    /// A map without a width, with a neighbouring lane and one at 45 degrees.
    NoWidth,
    /// Another unit contradicts once.
    ContradictedOnce,
    /// Another unit contradicts for five seconds.
    ContradictedLong,
    /// The first map comes after 20 s.
    LateMap,
    /// The countdown slides by up to 0.5 s.
    Sliding,
    /// The unit falls silent after 10 s, and another one has the line 20 m nearer.
    Replaced,
    /// The unit is 60 m beside the road and sends no map.
    Aside,
    /// The maps are 300 s old.
    OldMap,
}

const CONDITIONS: [Condition; 8] = [
    Condition::NoWidth,
    Condition::ContradictedOnce,
    Condition::ContradictedLong,
    Condition::LateMap,
    Condition::Sliding,
    Condition::Replaced,
    Condition::Aside,
    Condition::OldMap,
];

/// The figures, in the order of [`figures`]: times over all drives.
static FIGURES: [Figure; 4] = [
    Figure::difference("right line with timing", "s", 0.06),
    Figure::difference("right line without timing", "s", 0.06),
    Figure::difference("wrong line", "s", 0.06),
    Figure::difference("line behind", "s", 0.06),
];

fn main() {
    let base = figures(&Numbers::DEFAULT);
    for (figure, value) in FIGURES.iter().zip(&base) {
        println!("{}", figure.text(*value));
    }
    effects(&Numbers::DEFAULT, &FIGURES, &base, figures).for_each(|line| println!("{line}"));
}

fn figures(numbers: &Numbers) -> Vec<f64> {
    let mut sums = vec![0.0; FIGURES.len()];
    for condition in CONDITIONS {
        drive(condition, numbers, &mut sums);
    }
    sums
}

fn drive(condition: Condition, numbers: &Numbers, sums: &mut [f64]) {
    let plane = road_plane(&Origin::default());
    let mut receiver = Receiver::new(4711, 500, plane);
    receiver.numbers = *numbers;
    let replaced = condition == Condition::Replaced;
    for ms in (0..END_MS).step_by(STEP_MS as usize) {
        let ego_m = SPEED_MPS * ms as f64 / 1e3;
        for bytes in sent(condition, ms) {
            receiver.take(&bytes, &at(ms));
        }
        receiver.forget(at(ms).now_ns, ego_m);
        let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
        receiver.write(at(ms).now_ns, ego_m, &mut map, &mut spat);
        let line_m = if replaced && ms > 12_000 { LINE_M - 20.0 } else { LINE_M };
        let step_s = STEP_MS as f64 / 1e3;
        for lane in &map.lanes[..map.count as usize] {
            let timed = spat.signals[..spat.count as usize]
                .iter()
                .any(|signal| signal.signal_group == lane.signal_group && signal.count > 0);
            let is_right = (lane.stop_line_m - line_m).abs() < 1.0 && lane.signal_group == 7;
            match (lane.stop_line_m < ego_m, is_right, timed) {
                (true, ..) => sums[3] += step_s,
                (_, true, true) => sums[0] += step_s,
                (_, true, false) => sums[1] += step_s,
                (_, false, _) => sums[2] += step_s,
            }
        }
    }
}

/// The frames of a step.
fn sent(condition: Condition, ms: i64) -> Vec<Vec<u8>> {
    let replaced = condition == Condition::Replaced && ms >= 12_000;
    let silent = condition == Condition::Replaced && ms >= 10_000;
    let mut frames = Vec::new();
    let left_m = if condition == Condition::Aside { 60.0 } else { 5.0 };
    let slides_ms = match condition {
        // Repeatable, between 0 and 0.5 s.
        Condition::Sliding => (ms / STEP_MS).wrapping_mul(7919) % 501,
        _ => 0,
    };
    if !silent {
        frames.push(frame(spatem(UNIT, ms, slides_ms), ms, left_m));
    }
    if replaced {
        frames.push(frame(spatem(OTHER, ms, 0), ms, left_m));
    }
    let contradicts = match condition {
        Condition::ContradictedOnce => ms == 15_000,
        Condition::ContradictedLong => (15_000..20_000).contains(&ms),
        _ => false,
    };
    if contradicts {
        frames.push(frame(spatem(OTHER, ms, 9_000), ms, left_m));
    }
    if ms % 1_000 == 500 {
        let late = condition == Condition::LateMap && ms < 20_000;
        let old_ms = if condition == Condition::OldMap { 300_000 } else { 0 };
        if !silent && !late && condition != Condition::Aside {
            let width_cm = (condition != Condition::NoWidth).then_some(350);
            frames.push(frame(mapem(UNIT, LINE_M, width_cm), ms - old_ms, left_m));
        }
        if replaced {
            frames.push(frame(mapem(OTHER, LINE_M - 20.0, Some(350)), ms, left_m));
        }
    }
    frames
}

fn at(ms: i64) -> Moment {
    Moment { now_ns: ms * 1_000_000, utc_start_ns: START_NS, ahead_ns: 0 }
}

fn frame(message: Message, ms: i64, left_m: f64) -> Vec<u8> {
    let source = Source {
        station_type: StationType::RoadsideUnit,
        address: 1,
        timestamp: its_timestamp(at(ms).utc_ms()) as u32,
        position: road_plane(&Origin::default()).position(LINE_M + 10.0, left_m),
        accurate: true,
        speed: 0,
        heading: 0,
    };
    Frame { source, message }.encode().expect("in range")
}

/// Green until the next multiple of 30 s and `later_ms`, then red for 30 s.
fn spatem(station_id: u32, ms: i64, later_ms: i64) -> Message {
    let event = |state, end_ms: i64| {
        let mark = TimeMark::of(at(end_ms).utc_ms(), at(ms).utc_ms());
        let (min_end, max_end, likely_end) = (mark, Some(mark), Some(mark));
        let confidence = Some(15);
        let timing = Timing { start: None, min_end, max_end, likely_end, confidence, next: None };
        MovementEvent { state, timing: Some(timing) }
    };
    let ends_ms = (ms / 30_000 + 1) * 30_000 + later_ms;
    let is_green = (ms / 30_000) % 2 == 0;
    let (now, next) = match is_green {
        true => (MovementPhase::ProtectedMovementAllowed, MovementPhase::StopAndRemain),
        false => (MovementPhase::StopAndRemain, MovementPhase::ProtectedMovementAllowed),
    };
    let events = vec![event(now, ends_ms), event(next, ends_ms + 30_000)];
    let movements =
        [6, 7, 8].map(|signal_group| MovementState { signal_group, events: events.clone() });
    let state = IntersectionState {
        region: None,
        id: 1,
        revision: 0,
        status: 0,
        stamp: Some(Stamp::of(at(ms).utc_ms())),
        movements: movements.to_vec(),
    };
    Message::Spatem(Spatem { station_id, intersections: vec![state] })
}

/// The vehicle's lane, its neighbour to the left, and a lane that comes in at 45 degrees.
fn mapem(station_id: u32, line_m: f64, lane_width_cm: Option<u16>) -> Message {
    let lane = |id, first: (i16, i16), second, signal_group| Lane {
        id,
        approach: Approach::Ingress(1),
        maneuvers: STRAIGHT,
        nodes: vec![first, second],
        connections: vec![Connection {
            lane: 9,
            maneuver: Some(STRAIGHT),
            signal_group: Some(signal_group),
        }],
    };
    let geometry = IntersectionGeometry {
        region: None,
        id: 1,
        revision: 0,
        reference: road_plane(&Origin::default()).position(line_m + 10.0, 0.0),
        lane_width_cm,
        lanes: vec![
            lane(1, (-1000, 350), (-9000, 0), 8),
            lane(2, (-1000, 0), (-9000, 0), 7),
            lane(3, (-500, 0), (-6000, -6000), 6),
        ],
        unread_lanes: 0,
    };
    Message::Mapem(Mapem { station_id, revision: 0, intersections: vec![geometry] })
}
