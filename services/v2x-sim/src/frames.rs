//! The roadside units' frames. Each intersection has one unit, with a SPATEM in each period and a MAPEM in each second.
//!
//! Plain code: the frames are a function of the scenario, the time and UTC.
//!
//! ```text
//!               lane 1 ─► ego's lane, signal group of the scenario  │ stop line │ ─► egress
//!               lane 101 ─► left turn, 3.5 m to the left, another signal group, always red
//! ```

mod along;

use crate::numbers::NUMBERS;
use crate::program::{Interval, Program};
use crate::roadside_unit::CERTAIN;
use its::geonetworking::{Source, StationType};
use its::mapem::{Approach, Connection, Lane};
use its::spatem::{IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing};
use its::time::{Stamp, TimeMark, its_timestamp};
use its::{EncodeError, Frame, Message, MessageKind};
use messages::{Lights, MAX_INTERVALS};
use obu::lanes::Path;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::Scenario;
use scenario::quantity::Time;
use scenario::radio::Unit;
use scenario::v2x::Phase;

/// Station id of the unit at intersection 0; intersection n adds n.
pub const FIRST_STATION: u32 = 100_000;
/// The same for units that contradict.
pub const FIRST_CONTRADICTING_STATION: u32 = 200_000;
/// Stream of the random errors of announced ends.
const JITTER_STREAM: u64 = 0x5a17_c0de_0a1b_0003;
/// Lane ids: the ego's lanes count from 1, the turning lanes from here.
const TURNING: u8 = 101;
const EXITS: u8 = 201;

/// All roadside units of a scenario.
#[derive(Clone, Debug)]
pub struct Frames {
    sites: Vec<Site>,
    wrong: Unit,
    seed: u64,
    range_m: f64,
    period_ns: u64,
    /// The road, or the ego's route through a net, along which the lanes of the maps lie.
    pub path: Path,
}

/// A frame as its unit sends it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SentFrame {
    pub station: u32,
    pub kind: MessageKind,
    /// Bytes from the GeoNetworking header on.
    pub bytes: Vec<u8>,
}

/// An intersection with its unit.
#[derive(Clone, Debug)]
struct Site {
    intersection: u16,
    signals: Vec<(u8, f64, Program)>,
    turning_group: u8,
}

impl Frames {
    pub fn new(scenario: &Scenario) -> Self {
        let v2x = &scenario.v2x;
        let mut sites: Vec<Site> = Vec::new();
        for signal in &v2x.signals {
            let (id, group) = (signal.intersection_id.value(), signal.signal_group.value());
            let entry = (group, signal.stop_line_m.value(), Program::new(signal));
            match sites.iter_mut().find(|site| site.intersection == id) {
                Some(site) => site.signals.push(entry),
                None => {
                    sites.push(Site { intersection: id, signals: vec![entry], turning_group: 0 });
                }
            }
        }
        for site in &mut sites {
            let is_free = |group: &u8| site.signals.iter().all(|(used, ..)| used != group);
            site.turning_group = (1..=254).find(is_free).unwrap_or(254);
        }
        Self {
            sites,
            wrong: v2x.unit,
            seed: scenario.seed.value(),
            range_m: v2x.range_m.value(),
            period_ns: v2x.period_ms.nanoseconds(),
            path: Path::of(scenario),
        }
    }

    /// The frames at `time_ns` of the run, which started at `utc_start_ns`. They are of all units, or of those that
    /// reach a vehicle at `ego_m`. The lights of another simulator, if there are any, take the place of programs.
    ///
    /// # Errors
    /// [`EncodeError`] if a value of the scenario does not fit into the standards' messages.
    pub fn at(
        &self,
        time_ns: u64,
        utc_start_ns: i64,
        ego_m: Option<f64>,
        lights: Option<&Lights>,
    ) -> Result<Vec<SentFrame>, EncodeError> {
        let clock = Now::of(time_ns, utc_start_ns, &self.wrong);
        let mut sent = Vec::new();
        for (site, index) in self.sites.iter().zip(0_u64..) {
            let now = clock.of_intersection(site.intersection, &self.wrong);
            if ego_m.is_some_and(|ego_m| !site.reaches(ego_m, self.range_m)) {
                continue;
            }
            let station = FIRST_STATION + u32::from(site.intersection);
            let spatem = site.spatem(station, &now, |group, program| match lights {
                Some(lights) => along::shown(lights, (site.intersection, group), &now),
                None => self.events(program, &now),
            });
            sent.push(self.frame(site, Message::Spatem(spatem), &now)?);
            if begun(self.wrong.contradicted_from_s, time_ns) {
                let other = FIRST_CONTRADICTING_STATION + u32::from(site.intersection);
                let green_ms = Some(now.utc_ms + (1e3 * NUMBERS.false_green_s) as i64);
                let green = |_, _: &_| vec![event(Phase::Green, green_ms, &now)];
                let spatem = site.spatem(other, &now, green);
                sent.push(self.frame(site, Message::Spatem(spatem), &now)?);
            }
            // The units send their maps in turns.
            let map_period_ns = (1e9 * NUMBERS.map_period_s) as u64;
            if (time_ns + index * self.period_ns) % map_period_ns < self.period_ns {
                let shift_m = if now.revision > 0 { self.wrong.map_shift_m.value() } else { 0.0 };
                let mapem = site.mapem(station, &now, &self.path, shift_m)?;
                sent.push(self.frame(site, Message::Mapem(mapem), &now)?);
            }
        }
        Ok(sent)
    }

    fn frame(&self, site: &Site, message: Message, now: &Now) -> Result<SentFrame, EncodeError> {
        let (station, kind) = (message.station_id(), message.kind());
        let source = Source {
            station_type: StationType::RoadsideUnit,
            address: 0x0200_0000_0000 | u64::from(station),
            timestamp: its_timestamp(now.utc_ms) as u32,
            position: self.path.plane.position(site.middle_m(), 0.0),
            accurate: true,
            speed: 0,
            heading: 0,
        };
        Ok(SentFrame { station, kind, bytes: Frame { source, message }.encode()? })
    }

    /// The present phase of a program and the phases behind it, up to the room of a message.
    fn events(&self, program: &Program, now: &Now) -> Vec<MovementEvent> {
        let end_ns = program.intervals(now.time_ns).next().and_then(|shown| shown.end_ns);
        let is_wrong = begun(self.wrong.countdown_wrong_from_s, now.time_ns);
        let off_ms = if is_wrong { self.off_ms(end_ns, now) } else { 0 };
        let room = if is_wrong && self.wrong.countdown_lacks_next { 1 } else { MAX_INTERVALS };
        let of_interval = |interval: Interval| {
            event(interval.phase, interval.end_ns.map(|end_ns| now.of_run(end_ns) + off_ms), now)
        };
        program.intervals(now.time_ns).take(room).map(of_interval).collect()
    }

    /// Error of the ends of a signal whose shown phase ends at `end_ns`, ms.
    fn off_ms(&self, end_ns: Option<u64>, now: &Now) -> i64 {
        let wrong = &self.wrong;
        let from_ns = wrong.countdown_wrong_from_s.map_or(0, Time::nanoseconds);
        let slid_s = wrong.countdown_slide.value() * (now.time_ns - from_ns) as f64 / 1e9;
        // The end belongs to the signal, so that signals of one unit differ.
        let stream = now.time_ns.rotate_left(32) ^ end_ns.unwrap_or(0) ^ self.seed ^ JITTER_STREAM;
        let draw = 2.0 * random::uniform(&mut Pcg64::seed_from_u64(stream)) - 1.0;
        let jitter_s = draw * wrong.countdown_jitter_s.value();
        let early_ns = match (end_ns, wrong.countdown_extends_s.nanoseconds()) {
            (None, _) | (_, 0) => 0,
            (Some(end_ns), step_ns) => end_ns.saturating_sub((now.time_ns / step_ns + 1) * step_ns),
        };
        let off_s = wrong.countdown_jump_s.value() + slid_s + jitter_s - early_ns as f64 / 1e9;
        (off_s * 1e3).round() as i64
    }
}

impl Site {
    fn reaches(&self, ego_m: f64, range_m: f64) -> bool {
        let mut ahead_m = self.signals.iter().map(|(_, stop_line_m, _)| stop_line_m - ego_m);
        ahead_m.any(|ahead_m| (-NUMBERS.passed_m..=range_m).contains(&ahead_m))
    }

    fn middle_m(&self) -> f64 {
        self.signals[0].1 + NUMBERS.to_middle_m
    }

    fn spatem(
        &self,
        station_id: u32,
        now: &Now,
        events: impl Fn(u8, &Program) -> Vec<MovementEvent>,
    ) -> Spatem {
        let ego = self.signals.iter().map(|(signal_group, _, program)| MovementState {
            signal_group: *signal_group,
            events: events(*signal_group, program),
        });
        let ego = ego.filter(|movement| !movement.events.is_empty());
        let turning = MovementState {
            signal_group: self.turning_group,
            events: vec![event(Phase::Red, None, now)],
        };
        let state = IntersectionState {
            region: None,
            id: self.intersection,
            revision: now.revision,
            status: 0,
            stamp: Some(Stamp::of(now.utc_ms)),
            movements: ego.chain([turning]).collect(),
        };
        Spatem { station_id, intersections: vec![state] }
    }
}

/// A lane to an intersection, with the exit that it leads to and the way there.
fn ingress_lane(id: u8, nodes: Vec<(i16, i16)>, (exit, way): (u8, u16), group: u8) -> Lane {
    let connection = Connection { lane: exit, maneuver: Some(way), signal_group: Some(group) };
    let approach = Approach::Ingress(1);
    Lane { id, approach, maneuvers: way, nodes, connections: vec![connection] }
}

fn egress_lane(id: u8, nodes: Vec<(i16, i16)>) -> Lane {
    Lane { id, approach: Approach::Egress(2), maneuvers: 0, nodes, connections: Vec::new() }
}

/// The present by the units' clocks.
#[derive(Clone, Copy, Debug)]
struct Now {
    time_ns: u64,
    utc_ms: i64,
    /// UTC of run time 0 by these clocks at present, ns.
    start_ns: i64,
    revision: u8,
}

impl Now {
    fn of(time_ns: u64, utc_start_ns: i64, wrong: &Unit) -> Self {
        let drift_ns = time_ns as f64 * f64::from(wrong.clock_drift_ppm.value()) / 1e6;
        let offset_ns = i64::from(wrong.clock_offset_ms.value()) * 1_000_000;
        let start_ns = utc_start_ns + offset_ns + drift_ns.round() as i64;
        let this = Self { time_ns, utc_ms: 0, start_ns, revision: 0 };
        Self { utc_ms: this.of_run(time_ns), ..this }
    }

    /// The same with the revision of an intersection's map.
    fn of_intersection(&self, intersection: u16, wrong: &Unit) -> Self {
        let is_meant = wrong.map_changes_of.is_none_or(|id| id.value() == intersection);
        Self {
            revision: u8::from(is_meant && begun(wrong.map_changes_at_s, self.time_ns)),
            ..*self
        }
    }

    fn of_run(&self, time_ns: u64) -> i64 {
        self.start_ns.saturating_add_unsigned(time_ns).div_euclid(1_000_000)
    }
}

fn begun(from: Option<Time>, time_ns: u64) -> bool {
    from.is_some_and(|from| time_ns >= from.nanoseconds())
}

/// A phase with its end in UTC, ms, or without a planned end. Marks are tenths of a second: the earliest end is
/// rounded down, the latest up.
fn event(phase: Phase, end_ms: Option<i64>, now: &Now) -> MovementEvent {
    timed(phase, [end_ms; 3], CERTAIN, now)
}

/// The same with the earliest, the likely and the latest end.
fn timed(
    phase: Phase,
    [least_ms, likely_ms, most_ms]: [Option<i64>; 3],
    confidence: u8,
    now: &Now,
) -> MovementEvent {
    let state = match phase {
        Phase::Green => MovementPhase::ProtectedMovementAllowed,
        Phase::Yellow => MovementPhase::ProtectedClearance,
        Phase::Red => MovementPhase::StopAndRemain,
    };
    let mark = |ms: Option<i64>| ms.map_or(TimeMark::BEYOND, |ms| TimeMark::of(ms, now.utc_ms));
    let timing = Timing {
        start: None,
        min_end: mark(least_ms.map(|ms| ms.div_euclid(100) * 100)),
        max_end: Some(mark(most_ms.map(|ms| (ms + 99).div_euclid(100) * 100))),
        likely_end: Some(mark(likely_ms)),
        confidence: Some(confidence),
        next: None,
    };
    MovementEvent { state, timing: Some(timing) }
}

#[cfg(test)]
mod tests;
