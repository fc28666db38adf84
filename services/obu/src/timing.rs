//! The timing of a signal from a SPATEM, in run time.

use crate::clock::Moment;
use its::spatem::{MovementEvent, MovementPhase, MovementState};
use its::time::TimeMark;
use messages::{Interval, MAX_INTERVALS, PhaseState, Signal};

/// Largest difference between two announcements of the same end, s: three marks of a tenth of a second. Chosen.
const SAME_END_S: f64 = 0.35;
/// Time for which a green that outlasts its announced end still counts, s. It is the time until the next message, and
/// the difference of clocks.
const NEXT_MESSAGE_S: f64 = 0.4;
/// Confidence of a time that its bounds leave no choice of: 100 %.
const CERTAIN: u8 = 15;

/// A phase and its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Announced {
    pub state: PhaseState,
    /// Earliest, likely and latest end, s of run time; infinite if no end is planned.
    pub ends_s: [f64; 3],
    /// Confidence in the likely end, 0 to 15.
    pub confidence: u8,
}

impl Announced {
    fn is_open_green(&self) -> bool {
        self.state == PhaseState::ProtectedMovementAllowed && self.ends_s[1].is_infinite()
    }
}

/// Announced phases of one signal group.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    pub signal_group: u8,
    /// The present phase and those that follow.
    pub phases: Vec<Announced>,
}

impl Timing {
    /// Timing of a movement that was made at `made_ns` of run time. If the announced end of the present phase has
    /// passed, the phase still holds. Its end is open: a red lasts, and a green can end with each message. Its yellow is
    /// then as long as it was announced.
    pub fn of(movement: &MovementState, made_ns: i64, moment: &Moment) -> Self {
        let mut phases: Vec<Announced> = Vec::with_capacity(movement.events.len());
        for event in movement.events.iter().take(MAX_INTERVALS) {
            let Some(announced) = announced(event, moment) else { break };
            let made_s = made_ns as f64 / 1e9;
            if phases.is_empty() && announced.ends_s[1] <= made_s {
                let next = movement.events.get(1).and_then(|event| self::announced(event, moment));
                phases.extend(shown_alone(&announced, next.as_ref(), made_s));
                break;
            }
            // A phase that ends before it begins is unknown, and so are the phases behind it.
            if phases.last().is_some_and(|before| before.ends_s[1] > announced.ends_s[1]) {
                break;
            }
            phases.push(announced);
        }
        Self { signal_group: movement.signal_group, phases }
    }

    /// The phases that last beyond `now_s`.
    fn coming(&self, now_s: f64) -> impl Iterator<Item = &Announced> {
        let from_s = now_s + SAME_END_S;
        self.phases.iter().filter(move |phase| phase.ends_s[1] > from_s)
    }

    /// True if both show the same phase at `now_s`, whatever they say of its end.
    pub fn shows_as(&self, other: &Self, now_s: f64) -> bool {
        let mut shown = self.coming(now_s).zip(other.coming(now_s));
        shown.next().is_none_or(|(a, b)| a.state == b.state)
    }

    /// True if both are possible from `now_s` on.
    pub fn agrees_with(&self, other: &Self, now_s: f64) -> bool {
        for (a, b) in self.coming(now_s).zip(other.coming(now_s)) {
            let (a_s, b_s) = (a.ends_s[1], b.ends_s[1]);
            let is_open = a.is_open_green() || b.is_open_green();
            if a.state != b.state || !is_open && a_s != b_s && (a_s - b_s).abs() > SAME_END_S {
                return false;
            }
            if is_open {
                break;
            }
        }
        true
    }

    pub fn write(&self, intersection_id: u16, signal: &mut Signal) {
        signal.intersection_id = intersection_id.into();
        signal.signal_group = self.signal_group.into();
        signal.count = 0;
        for (place, phase) in signal.intervals.iter_mut().zip(&self.phases) {
            let [min_end_s, likely_end_s, max_end_s] = phase.ends_s;
            *place = Interval {
                state: phase.state.to_wire(),
                confidence: phase.confidence.into(),
                min_end_s,
                likely_end_s,
                max_end_s,
            };
            signal.count += 1;
        }
    }
}

/// True if each signal group of both lists `fits`.
pub fn every_group(a: &[Timing], b: &[Timing], fits: impl Fn(&Timing, &Timing) -> bool) -> bool {
    a.iter().all(|of_a| {
        let mut same = b.iter().filter(|of_b| of_b.signal_group == of_a.signal_group);
        same.all(|of_b| fits(of_a, of_b))
    })
}

/// The shown phase and what is certain after it, of a phase with an open end. A green behind which no yellow is
/// announced is unknown, unless nothing is announced there.
fn shown_alone(shown: &Announced, next: Option<&Announced>, made_s: f64) -> Vec<Announced> {
    let open = |min_s| Announced { ends_s: [min_s, f64::INFINITY, f64::INFINITY], ..*shown };
    match shown.state {
        PhaseState::StopAndRemain => vec![Announced { confidence: 0, ..open(f64::INFINITY) }],
        PhaseState::ProtectedMovementAllowed => {
            let green = Announced { confidence: 0, ..open(made_s + NEXT_MESSAGE_S) };
            let Some(next) = next else { return vec![green] };
            let lasts_s = next.ends_s[0] - shown.ends_s[0];
            let is_yellow = next.state == PhaseState::ProtectedClearance;
            if !is_yellow || !lasts_s.is_finite() || lasts_s <= NEXT_MESSAGE_S {
                return Vec::new();
            }
            let ends_s = [made_s + lasts_s, f64::INFINITY, f64::INFINITY];
            let state = PhaseState::ProtectedClearance;
            vec![green, Announced { state, ends_s, confidence: 0 }]
        }
        _ => Vec::new(),
    }
}

/// A phase with its ends; `None` if its certain length is unknown.
fn announced(event: &MovementEvent, moment: &Moment) -> Option<Announced> {
    let state = state(event.state);
    let Some(timing) = event.timing else {
        // Without an end only red is safe to accept.
        let endless = Announced { state, ends_s: [f64::INFINITY; 3], confidence: 0 };
        return (state == PhaseState::StopAndRemain).then_some(endless);
    };
    let end_s = |mark: TimeMark| match mark {
        TimeMark::UNKNOWN => None,
        mark => Some(
            mark.utc(moment.utc_ms())
                .map_or(f64::INFINITY, |utc_ms| moment.run_ns(utc_ms) as f64 / 1e9),
        ),
    };
    let min_s = end_s(timing.min_end)?;
    let max_s = timing.max_end.and_then(end_s).unwrap_or(f64::INFINITY);
    let likely_s = timing.likely_end.and_then(end_s).unwrap_or(match state {
        PhaseState::StopAndRemain => max_s,
        _ => min_s,
    });
    let unstated = if min_s == max_s { CERTAIN } else { 0 };
    let confidence = timing.confidence.unwrap_or(unstated);
    Some(Announced { state, ends_s: [min_s, likely_s, max_s], confidence })
}

/// Reduces a phase to the four that a cruise controller distinguishes. A permissive green is a green for the
/// straight way.
fn state(phase: MovementPhase) -> PhaseState {
    match phase {
        MovementPhase::PermissiveMovementAllowed | MovementPhase::ProtectedMovementAllowed => {
            PhaseState::ProtectedMovementAllowed
        }
        MovementPhase::PermissiveClearance | MovementPhase::ProtectedClearance => {
            PhaseState::ProtectedClearance
        }
        MovementPhase::StopThenProceed
        | MovementPhase::StopAndRemain
        | MovementPhase::PreMovement => PhaseState::StopAndRemain,
        MovementPhase::Unavailable
        | MovementPhase::Dark
        | MovementPhase::CautionConflictingTraffic => PhaseState::Unavailable,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use its::spatem::Timing as Details;

    /// Two seconds before twelve.
    const MOMENT: Moment =
        Moment { now_ns: 40_000_000_000, utc_start_ns: 1_780_315_158_000_000_000, ahead_ns: 0 };

    fn event(state: MovementPhase, in_s: [Option<i64>; 3]) -> MovementEvent {
        let mark = |s: i64| TimeMark::of(MOMENT.utc_ms() + 1000 * s, MOMENT.utc_ms());
        MovementEvent {
            state,
            timing: Some(Details {
                start: None,
                min_end: in_s[0].map_or(TimeMark::UNKNOWN, mark),
                likely_end: in_s[1].map(mark),
                max_end: in_s[2].map(mark),
                confidence: Some(15),
                next: None,
            }),
        }
    }

    fn timing(events: Vec<MovementEvent>) -> Timing {
        Timing::of(&MovementState { signal_group: 1, events }, MOMENT.now_ns, &MOMENT)
    }

    #[test]
    fn ends_are_in_run_time_across_the_hour() {
        let green = event(MovementPhase::ProtectedMovementAllowed, [Some(1), Some(3), Some(4)]);
        let red = event(MovementPhase::PreMovement, [Some(5), None, None]);
        let timing = timing(vec![green, red]);
        assert_eq!(timing.phases[0].ends_s, [41.0, 43.0, 44.0]);
        assert_eq!(timing.phases[1].ends_s, [45.0, f64::INFINITY, f64::INFINITY]);
        assert_eq!(timing.phases[1].state, PhaseState::StopAndRemain);
    }

    #[test]
    fn an_uncertain_interval_ends_the_list() {
        let unknown = event(MovementPhase::ProtectedMovementAllowed, [None, Some(3), None]);
        assert_eq!(timing(vec![unknown]).phases, []);
        let bare = |state| MovementEvent { state, timing: None };
        assert_eq!(timing(vec![bare(MovementPhase::ProtectedMovementAllowed)]).phases, []);
        assert_eq!(timing(vec![bare(MovementPhase::StopAndRemain)]).phases.len(), 1);
        let far = event(MovementPhase::ProtectedMovementAllowed, [Some(9); 3]);
        let near = event(MovementPhase::StopAndRemain, [Some(5); 3]);
        assert_eq!(timing(vec![far, near]).phases.len(), 1, "an end before the one before");
    }

    #[test]
    fn what_is_shown_after_its_announced_end_still_holds_and_its_end_is_open() {
        let green = |s| event(MovementPhase::ProtectedMovementAllowed, [Some(s); 3]);
        let red = |s| event(MovementPhase::StopAndRemain, [Some(s); 3]);
        let late = timing(vec![red(-1), green(9)]);
        assert_eq!(late.phases.len(), 1);
        assert_eq!(late.phases[0].ends_s, [f64::INFINITY; 3]);
        assert_eq!(timing(vec![green(-1), red(9)]).phases, [], "no yellow was announced");
        let yellow = |s| event(MovementPhase::ProtectedClearance, [Some(s); 3]);
        let late = timing(vec![green(-9), yellow(-6), red(9)]);
        let told: Vec<_> = late.phases.iter().map(|phase| (phase.state, phase.ends_s[0])).collect();
        let green_now = (PhaseState::ProtectedMovementAllowed, 40.4);
        assert_eq!(told, [green_now, (PhaseState::ProtectedClearance, 43.0)]);
        assert_eq!(timing(vec![yellow(-1), red(9)]).phases, [], "red may be shown at once");
        let agrees = |other: Vec<MovementEvent>| late.agrees_with(&timing(other), 40.0);
        assert!(agrees(vec![green(5), yellow(8), red(9)]), "green lasts for now");
        assert!(!agrees(vec![red(9)]));
    }

    #[test]
    fn announcements_agree_as_long_as_both_can_be_true() {
        let green = |s| event(MovementPhase::ProtectedMovementAllowed, [Some(s); 3]);
        let red = |s| event(MovementPhase::StopAndRemain, [Some(s); 3]);
        let told = timing(vec![green(2), red(9)]);
        assert!(told.agrees_with(&timing(vec![red(9)]), 42.0), "the green is over");
        assert!(!told.agrees_with(&timing(vec![red(9)]), 41.0));
        assert!(!told.agrees_with(&timing(vec![green(3), red(9)]), 40.0));
        assert!(told.agrees_with(&timing(vec![green(2), red(9), green(20)]), 40.0));
    }
}
