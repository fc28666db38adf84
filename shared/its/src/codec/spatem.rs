//! SPATEM.

use super::dsrc::{
    ADVISORY_SPEEDS, ENABLED_LANES, MANEUVER_ASSIST, MINUTE, NAME, REGION, REGIONALS, REVISION,
    SIGNAL_GROUP,
};
use super::uper::{Number, Skip, Source, Writer};
use super::{read_header, write_header};
use crate::spatem::{
    IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing,
};
use crate::time::{Stamp, TimeMark};
use crate::{EncodeError, MessageKind, PayloadError};

/// Entries of a list of intersections.
pub(super) const INTERSECTIONS: Number = Number::new("intersections", 1, 32);
const INTERSECTION_ID: Number = Number::new("intersection", 0, 65_535);
const MILLISECOND: Number = Number::new("millisecond", 0, 65_535);
const SIGNAL_GROUPS: Number = Number::new("signal groups", 1, 255);
const PHASES: Number = Number::new("phases", 1, 16);
const PHASE: Number = Number::new("phase", 0, MovementPhase::ALL.len() as i64 - 1);
const START: Number = mark("start");
const MIN_END: Number = mark("earliest end");
const MAX_END: Number = mark("latest end");
const LIKELY_END: Number = mark("likely end");
const CONFIDENCE: Number = Number::new("confidence", 0, 15);
const NEXT: Number = mark("next time");
/// Size of `IntersectionStatusObject`.
const STATUS_BITS: u32 = 16;

const fn mark(what: &'static str) -> Number {
    Number::new(what, 0, 36_001)
}

pub(crate) fn encode(message: &Spatem) -> Result<Vec<u8>, EncodeError> {
    let mut to = write_header(MessageKind::Spatem, message.station_id)?;
    // SPAT: timeStamp, name, regional.
    to.not_extended();
    to.present([false; 3]);
    to.list(INTERSECTIONS, &message.intersections, write_intersection)?;
    Ok(to.finish())
}

pub(super) fn read(from: &mut impl Source) -> Result<Spatem, PayloadError> {
    let station_id = read_header(from)?;
    from.extensible(|from, [stamped, named, regional]| {
        let minute = from.some_number(stamped, MINUTE)?;
        from.skip(named, &NAME)?;
        let intersections = from.list(INTERSECTIONS, |from| read_intersection(from, minute))?;
        from.skip(regional, &REGIONALS)?;
        Ok(Spatem { station_id, intersections })
    })
}

/// `IntersectionReferenceID`.
pub(super) fn write_reference(
    to: &mut Writer,
    region: Option<u16>,
    id: u16,
) -> Result<(), EncodeError> {
    to.present([region.is_some()]);
    to.some_number(REGION, region)?;
    to.number(INTERSECTION_ID, id)
}

/// Region and id of an intersection.
pub(super) fn read_reference(from: &mut impl Source) -> Result<(Option<u16>, u16), PayloadError> {
    from.sequence(|from, [regional]| {
        Ok((from.some_number(regional, REGION)?, from.number(INTERSECTION_ID)?))
    })
}

fn write_intersection(to: &mut Writer, state: &IntersectionState) -> Result<(), EncodeError> {
    to.not_extended();
    let stamp = state.stamp;
    // name, moy, timeStamp, enabledLanes, maneuverAssistList, regional.
    to.present([false, stamp.is_some(), stamp.is_some(), false, false, false]);
    write_reference(to, state.region, state.id)?;
    to.number(REVISION, state.revision)?;
    to.flags(state.status, STATUS_BITS);
    to.some_number(MINUTE, stamp.map(|stamp| stamp.minute_of_year))?;
    to.some_number(MILLISECOND, stamp.map(|stamp| stamp.millisecond))?;
    to.list(SIGNAL_GROUPS, &state.movements, write_movement)
}

/// The minute is in the intersection, or once for all (`common_minute`).
fn read_intersection(
    from: &mut impl Source,
    common_minute: Option<u32>,
) -> Result<IntersectionState, PayloadError> {
    from.extensible(|from, [named, own_minute, timed, enabled, assisted, regional]| {
        from.skip(named, &NAME)?;
        let (region, id) = read_reference(from)?;
        let revision = from.number(REVISION)?;
        let status = from.flags("status", STATUS_BITS)?;
        let minute = from.some_number(own_minute, MINUTE)?.or(common_minute);
        let millisecond = from.some_number(timed, MILLISECOND)?;
        from.skip(enabled, &ENABLED_LANES)?;
        let movements = from.list(SIGNAL_GROUPS, read_movement)?;
        from.skip(assisted, &MANEUVER_ASSIST)?;
        from.skip(regional, &REGIONALS)?;
        let stamp = minute
            .zip(millisecond)
            .map(|(minute_of_year, millisecond)| Stamp { minute_of_year, millisecond });
        Ok(IntersectionState { region, id, revision, status, stamp, movements })
    })
}

fn write_movement(to: &mut Writer, state: &MovementState) -> Result<(), EncodeError> {
    to.not_extended();
    // movementName, maneuverAssistList, regional.
    to.present([false; 3]);
    to.number(SIGNAL_GROUP, state.signal_group)?;
    to.list(PHASES, &state.events, write_event)
}

fn read_movement(from: &mut impl Source) -> Result<MovementState, PayloadError> {
    from.extensible(|from, [named, assisted, regional]| {
        from.skip(named, &NAME)?;
        let signal_group = from.number(SIGNAL_GROUP)?;
        let events = from.list(PHASES, read_event)?;
        from.skip(assisted, &MANEUVER_ASSIST)?;
        from.skip(regional, &REGIONALS)?;
        Ok(MovementState { signal_group, events })
    })
}

fn write_event(to: &mut Writer, event: &MovementEvent) -> Result<(), EncodeError> {
    to.not_extended();
    // timing, speeds, regional.
    to.present([event.timing.is_some(), false, false]);
    to.number(PHASE, event.state as u8)?;
    event.timing.as_ref().map_or(Ok(()), |timing| write_timing(to, timing))
}

fn read_event(from: &mut impl Source) -> Result<MovementEvent, PayloadError> {
    from.extensible(|from, [timed, advised, regional]| {
        let state = MovementPhase::ALL[from.number::<usize>(PHASE)?];
        let timing = timed.then(|| read_timing(from)).transpose()?;
        from.skip(advised, &ADVISORY_SPEEDS)?;
        from.skip(regional, &REGIONALS)?;
        Ok(MovementEvent { state, timing })
    })
}

fn write_timing(to: &mut Writer, timing: &Timing) -> Result<(), EncodeError> {
    let Timing { start, min_end, max_end, likely_end, confidence, next } = *timing;
    let there = [start.is_some(), max_end.is_some(), likely_end.is_some()];
    to.present(there);
    to.present([confidence.is_some(), next.is_some()]);
    to.some_number(START, start.map(TimeMark::value))?;
    to.number(MIN_END, min_end.value())?;
    to.some_number(MAX_END, max_end.map(TimeMark::value))?;
    to.some_number(LIKELY_END, likely_end.map(TimeMark::value))?;
    to.some_number(CONFIDENCE, confidence)?;
    to.some_number(NEXT, next.map(TimeMark::value))
}

fn read_timing(from: &mut impl Source) -> Result<Timing, PayloadError> {
    from.sequence(|from, [started, latest, likely, confident, again]| {
        Ok(Timing {
            start: read_mark(from, started, START)?,
            min_end: read_mark(from, true, MIN_END)?.unwrap_or(TimeMark::UNKNOWN),
            max_end: read_mark(from, latest, MAX_END)?,
            likely_end: read_mark(from, likely, LIKELY_END)?,
            confidence: from.some_number(confident, CONFIDENCE)?,
            next: read_mark(from, again, NEXT)?,
        })
    })
}

fn read_mark(
    from: &mut impl Source,
    there: bool,
    number: Number,
) -> Result<Option<TimeMark>, PayloadError> {
    Ok(from.some_number(there, number)?.and_then(TimeMark::new))
}
