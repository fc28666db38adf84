//! SPATEM.

use super::STATION_ID;
use super::dsrc::{
    ADVISORY_SPEEDS, ENABLED_LANES, MANEUVER_ASSIST, MINUTE, NAME, REGION, REGIONALS, REVISION,
    SIGNAL_GROUP,
};
use super::uper::{Fields, Number, Skip};
use crate::PayloadError;
use crate::spatem::{
    IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing,
};
use crate::time::{Stamp, TimeMark};

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

pub(super) fn walk(fields: &mut impl Fields, message: &mut Spatem) -> Result<(), PayloadError> {
    fields.number(STATION_ID, &mut message.station_id)?;
    fields.extensible([false; 3], |fields, [stamped, named, regional]| {
        let mut minute = None;
        fields.some_number(stamped, MINUTE, &mut minute)?;
        fields.skip(named, &NAME)?;
        fields.list(INTERSECTIONS, &mut message.intersections, |fields, state| {
            intersection(fields, state, minute)
        })?;
        fields.skip(regional, &REGIONALS)
    })
}

/// `IntersectionReferenceID`: region and id of an intersection.
pub(super) fn reference(
    fields: &mut impl Fields,
    region: &mut Option<u16>,
    id: &mut u16,
) -> Result<(), PayloadError> {
    fields.sequence([region.is_some()], |fields, [regional]| {
        fields.some_number(regional, REGION, region)?;
        fields.number(INTERSECTION_ID, id)
    })
}

/// The minute is in the intersection, or once for all (`common_minute`).
fn intersection(
    fields: &mut impl Fields,
    state: &mut IntersectionState,
    common_minute: Option<u32>,
) -> Result<(), PayloadError> {
    let is_stamped = state.stamp.is_some();
    let there = [false, is_stamped, is_stamped, false, false, false];
    fields.extensible(there, |fields, [named, own_minute, timed, enabled, assisted, regional]| {
        fields.skip(named, &NAME)?;
        reference(fields, &mut state.region, &mut state.id)?;
        fields.number(REVISION, &mut state.revision)?;
        fields.flags("status", STATUS_BITS, &mut state.status)?;
        let mut minute = state.stamp.map(|stamp| stamp.minute_of_year);
        let mut millisecond = state.stamp.map(|stamp| stamp.millisecond);
        fields.some_number(own_minute, MINUTE, &mut minute)?;
        fields.some_number(timed, MILLISECOND, &mut millisecond)?;
        let stamp = minute.or(common_minute).zip(millisecond);
        state.stamp =
            stamp.map(|(minute_of_year, millisecond)| Stamp { minute_of_year, millisecond });
        fields.skip(enabled, &ENABLED_LANES)?;
        fields.list(SIGNAL_GROUPS, &mut state.movements, movement)?;
        fields.skip(assisted, &MANEUVER_ASSIST)?;
        fields.skip(regional, &REGIONALS)
    })
}

fn movement(fields: &mut impl Fields, state: &mut MovementState) -> Result<(), PayloadError> {
    fields.extensible([false; 3], |fields, [named, assisted, regional]| {
        fields.skip(named, &NAME)?;
        fields.number(SIGNAL_GROUP, &mut state.signal_group)?;
        fields.list(PHASES, &mut state.events, event)?;
        fields.skip(assisted, &MANEUVER_ASSIST)?;
        fields.skip(regional, &REGIONALS)
    })
}

fn event(fields: &mut impl Fields, event: &mut MovementEvent) -> Result<(), PayloadError> {
    let there = [event.timing.is_some(), false, false];
    fields.extensible(there, |fields, [timed, advised, regional]| {
        let phase = fields.whole(PHASE, event.state as i64)?;
        event.state = MovementPhase::ALL[phase as usize];
        if timed {
            timing(fields, event.timing.get_or_insert_default())?;
        }
        fields.skip(advised, &ADVISORY_SPEEDS)?;
        fields.skip(regional, &REGIONALS)
    })
}

fn timing(fields: &mut impl Fields, timing: &mut Timing) -> Result<(), PayloadError> {
    let Timing { start, min_end, max_end, likely_end, confidence, next } = timing;
    let latest = [max_end.is_some(), likely_end.is_some()];
    let there = [start.is_some(), latest[0], latest[1], confidence.is_some(), next.is_some()];
    fields.sequence(there, |fields, [started, latest, likely, confident, again]| {
        some_mark(fields, started, START, start)?;
        let mut least = Some(*min_end);
        some_mark(fields, true, MIN_END, &mut least)?;
        *min_end = least.unwrap_or_default();
        some_mark(fields, latest, MAX_END, max_end)?;
        some_mark(fields, likely, LIKELY_END, likely_end)?;
        fields.some_number(confident, CONFIDENCE, confidence)?;
        some_mark(fields, again, NEXT, next)
    })
}

fn some_mark(
    fields: &mut impl Fields,
    there: bool,
    number: Number,
    mark: &mut Option<TimeMark>,
) -> Result<(), PayloadError> {
    let mut value = mark.map(TimeMark::value);
    fields.some_number(there, number, &mut value)?;
    *mark = value.and_then(TimeMark::new);
    Ok(())
}
