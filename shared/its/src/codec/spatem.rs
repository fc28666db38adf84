//! SPATEM.

use super::uper::Writer;
use super::{PROTOCOL_VERSION, flags, from_uper};
use crate::spatem::{
    IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing,
};
use crate::time::{Stamp, TimeMark};
use crate::{DecodeError, EncodeError, MessageKind};
use c_its_parser::standards::dsrc_2_2_1::etsi_its_dsrc as dsrc;
use c_its_parser::standards::spatem_2_2_1::spatem_pdu_descriptions::SPATEM;
use dsrc::MovementPhaseState as P;

/// Every state with the generated one.
const PHASES: [(MovementPhase, P); 10] = [
    (MovementPhase::Unavailable, P::unavailable),
    (MovementPhase::Dark, P::dark),
    (MovementPhase::StopThenProceed, P::stop_Then_Proceed),
    (MovementPhase::StopAndRemain, P::stop_And_Remain),
    (MovementPhase::PreMovement, P::pre_Movement),
    (MovementPhase::PermissiveMovementAllowed, P::permissive_Movement_Allowed),
    (MovementPhase::ProtectedMovementAllowed, P::protected_Movement_Allowed),
    (MovementPhase::PermissiveClearance, P::permissive_clearance),
    (MovementPhase::ProtectedClearance, P::protected_clearance),
    (MovementPhase::CautionConflictingTraffic, P::caution_Conflicting_Traffic),
];

pub(crate) fn encode(message: &Spatem) -> Result<Vec<u8>, EncodeError> {
    let mut to = header(MessageKind::Spatem, message.station_id)?;
    // SPAT: timeStamp, name, regional.
    to.not_extended();
    to.present([false; 3]);
    to.list("intersections", &message.intersections, 1..=32, intersection)?;
    Ok(to.finish())
}

pub(crate) fn decode(payload: &[u8]) -> Result<Spatem, DecodeError> {
    let SPATEM { header, spat } = from_uper(payload)?;
    Ok(Spatem {
        station_id: header.station_id.0,
        intersections: spat
            .intersections
            .0
            .iter()
            .map(|state| read_intersection(state, spat.time_stamp.as_ref()))
            .collect(),
    })
}

/// A message with its `ItsPduHeader`.
pub(super) fn header(kind: MessageKind, station_id: u32) -> Result<Writer, EncodeError> {
    let mut to = Writer::default();
    to.number("protocol version", PROTOCOL_VERSION, 0..=255)?;
    to.number("message id", kind.message_id(), 0..=255)?;
    to.number("station id", station_id, 0..=4_294_967_295)?;
    Ok(to)
}

/// `IntersectionReferenceID`.
pub(super) fn reference(to: &mut Writer, region: Option<u16>, id: u16) -> Result<(), EncodeError> {
    to.present([region.is_some()]);
    to.some_number("region", region, 0..=65_535)?;
    to.number("intersection", id, 0..=65_535)
}

fn intersection(to: &mut Writer, state: &IntersectionState) -> Result<(), EncodeError> {
    to.not_extended();
    let stamp = state.stamp;
    // name, moy, timeStamp, enabledLanes, maneuverAssistList, regional.
    to.present([false, stamp.is_some(), stamp.is_some(), false, false, false]);
    reference(to, state.region, state.id)?;
    to.number("revision", state.revision, 0..=127)?;
    to.flags(state.status, 16);
    to.some_number("minute", stamp.map(|stamp| stamp.minute_of_year), 0..=527_040)?;
    to.some_number("millisecond", stamp.map(|stamp| stamp.millisecond), 0..=65_535)?;
    to.list("signal groups", &state.movements, 1..=255, movement)
}

fn movement(to: &mut Writer, state: &MovementState) -> Result<(), EncodeError> {
    to.not_extended();
    // movementName, maneuverAssistList, regional.
    to.present([false; 3]);
    to.number("signal group", state.signal_group, 0..=255)?;
    to.list("phases", &state.events, 1..=16, event)
}

fn event(to: &mut Writer, event: &MovementEvent) -> Result<(), EncodeError> {
    to.not_extended();
    // timing, speeds, regional.
    to.present([event.timing.is_some(), false, false]);
    to.number("phase", event.state as u8, 0..=9)?;
    event.timing.as_ref().map_or(Ok(()), |details| timing(to, details))
}

fn timing(to: &mut Writer, timing: &Timing) -> Result<(), EncodeError> {
    let Timing { start, min_end, max_end, likely_end, confidence, next } = timing;
    let there = [start.is_some(), max_end.is_some(), likely_end.is_some()];
    to.present(there);
    to.present([confidence.is_some(), next.is_some()]);
    let mut mark = |what: &str, mark: &Option<TimeMark>| {
        to.some_number(what, mark.map(TimeMark::value), 0..=36_001)
    };
    mark("start", start)?;
    mark("earliest end", &Some(*min_end))?;
    mark("latest end", max_end)?;
    mark("likely end", likely_end)?;
    to.some_number("confidence", *confidence, 0..=15)?;
    to.some_number("next time", next.map(TimeMark::value), 0..=36_001)
}

/// The minute may stand in the intersection or once in front of all.
fn read_intersection(
    state: &dsrc::IntersectionState,
    minute: Option<&dsrc::MinuteOfTheYear>,
) -> IntersectionState {
    let minute = state.moy.as_ref().or(minute);
    let stamp = minute.zip(state.time_stamp.as_ref());
    IntersectionState {
        region: state.id.region.as_ref().map(|region| region.0),
        id: state.id.id.0,
        revision: state.revision.0,
        status: flags(&state.status.0),
        stamp: stamp
            .map(|(minute, second)| Stamp { minute_of_year: minute.0, millisecond: second.0 }),
        movements: state.states.0.iter().map(read_movement).collect(),
    }
}

fn read_movement(state: &dsrc::MovementState) -> MovementState {
    MovementState {
        signal_group: state.signal_group.0,
        events: state.state_time_speed.0.iter().map(read_event).collect(),
    }
}

fn read_event(event: &dsrc::MovementEvent) -> MovementEvent {
    let found = PHASES.into_iter().find(|(_, state)| *state == event.event_state);
    MovementEvent {
        state: found.map_or(MovementPhase::Unavailable, |(phase, _)| phase),
        timing: event.timing.as_ref().map(read_timing),
    }
}

fn read_timing(timing: &dsrc::TimeChangeDetails) -> Timing {
    let mark = |mark: &dsrc::TimeMark| TimeMark::new(mark.0).unwrap_or(TimeMark::UNKNOWN);
    Timing {
        start: timing.start_time.as_ref().map(mark),
        min_end: mark(&timing.min_end_time),
        max_end: timing.max_end_time.as_ref().map(mark),
        likely_end: timing.likely_time.as_ref().map(mark),
        confidence: timing.confidence.as_ref().map(|confidence| confidence.0),
        next: timing.next_time.as_ref().map(mark),
    }
}
