//! SPATEM.

use super::{PROTOCOL_VERSION, bits, flags, from_uper, to_uper};
use crate::spatem::{
    IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing,
};
use crate::time::{Stamp, TimeMark};
use crate::{DecodeError, EncodeError, MessageKind};
use c_its_parser::standards::cdd_2_2_1::etsi_its_cdd as cdd;
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
    let intersections = message.intersections.iter().map(intersection).collect();
    to_uper(&SPATEM::new(
        header(MessageKind::Spatem, message.station_id),
        dsrc::SPAT::new(None, None, dsrc::IntersectionStateList(intersections), None),
    ))
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

pub(super) fn header(kind: MessageKind, station_id: u32) -> cdd::ItsPduHeader {
    cdd::ItsPduHeader::new(
        cdd::OrdinalNumber1B(PROTOCOL_VERSION),
        cdd::MessageId(kind.message_id()),
        cdd::StationId(station_id),
    )
}

pub(super) fn reference(region: Option<u16>, id: u16) -> dsrc::IntersectionReferenceID {
    dsrc::IntersectionReferenceID::new(region.map(dsrc::RoadRegulatorID), dsrc::IntersectionID(id))
}

fn intersection(state: &IntersectionState) -> dsrc::IntersectionState {
    dsrc::IntersectionState::new(
        None,
        reference(state.region, state.id),
        dsrc::MsgCount(state.revision),
        dsrc::IntersectionStatusObject(bits(state.status)),
        state.stamp.map(|stamp| dsrc::MinuteOfTheYear(stamp.minute_of_year)),
        state.stamp.map(|stamp| dsrc::DSecond(stamp.millisecond)),
        None,
        dsrc::MovementList(state.movements.iter().map(movement).collect()),
        None,
        None,
    )
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

fn movement(state: &MovementState) -> dsrc::MovementState {
    dsrc::MovementState::new(
        None,
        dsrc::SignalGroupID(state.signal_group),
        dsrc::MovementEventList(state.events.iter().map(event).collect()),
        None,
        None,
    )
}

fn read_movement(state: &dsrc::MovementState) -> MovementState {
    MovementState {
        signal_group: state.signal_group.0,
        events: state.state_time_speed.0.iter().map(read_event).collect(),
    }
}

fn event(event: &MovementEvent) -> dsrc::MovementEvent {
    let (_, state) = PHASES[event.state as usize];
    dsrc::MovementEvent::new(state, event.timing.as_ref().map(timing), None, None)
}

fn read_event(event: &dsrc::MovementEvent) -> MovementEvent {
    let found = PHASES.into_iter().find(|(_, state)| *state == event.event_state);
    MovementEvent {
        state: found.map_or(MovementPhase::Unavailable, |(phase, _)| phase),
        timing: event.timing.as_ref().map(read_timing),
    }
}

fn timing(timing: &Timing) -> dsrc::TimeChangeDetails {
    let mark = |mark: TimeMark| dsrc::TimeMark(mark.value());
    dsrc::TimeChangeDetails::new(
        timing.start.map(mark),
        mark(timing.min_end),
        timing.max_end.map(mark),
        timing.likely_end.map(mark),
        timing.confidence.map(dsrc::TimeIntervalConfidence),
        timing.next.map(mark),
    )
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
