//! Pass or stop.
//!
//! Both programs are solved. A pass is possible when its own plan crosses before the earliest announced end of green, or
//! in the part of the yellow in which a driver could not stop. The plan has the law's acceleration and the actuator's
//! lag. The safety filter must let it through as well: from the place where a stop
//! is no longer possible, the speed there is enough. No margin is added: an uncertain end is announced as an early one.
//! A green with a later likely end, or an unknown one, is driven to as a driver does. The vehicle goes on while it can
//! stop for the yellow or clear the line in it.
//!
//! The plans are then judged by one cost. A decision for a line stays until the other choice is better by the
//! hysteresis. At a dilemma the vehicle can neither pass the line in green nor stop comfortably. It then crosses in
//! yellow if that is possible, and brakes hard otherwise. Yellow counts as green for a vehicle that a driver with a reaction time could not stop
//! comfortably. Yellow is as long as such a driver needs (ITE 2020). A line whose phase is not known is taken for red
//! as long as the hardest braking stops before it. A vehicle that stands at the line starts when green is shown, if it
//! clears the line before red. The announcement has no part in it.

use law::{Figure, Formulation};

pub static FORMULATION: Formulation = Formulation {
    name: "road",
    caution: None,
    modes: &["cruise", "follow", "pass", "stop"],
    reasons: &[
        "start",
        "target-lost",
        "target-found",
        "green-in-reach",
        "green-out-of-reach",
        "stop-cheaper",
        "clears-in-yellow",
        "emergency",
        "signal-unknown",
    ],
    figures: &[
        Figure::new("gap_error_m", "m").meaning("desired minus real gap; positive: too close"),
        Figure::new("speed_error_mps", "m/s").meaning("speed minus the target's"),
        Figure::new("filter_correction_mps2", "m/s²"),
        Figure::new("solver_residual", "1"),
        Figure::new("pass_shortfall_m", "m"),
        Figure::new("pass_cost", "1"),
        Figure::new("stop_cost", "1"),
    ],
};

/// Treatment of the nearest line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// Cross it in the present or next green.
    Pass,
    Stop,
}

/// Why: the places of the words in the formulation's reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// The pass is possible and the better of the two.
    GreenInReach = 3,
    GreenOutOfReach,
    StopCheaper,
    /// Too late to stop comfortably, and clear before red.
    ClearsInYellow,
    /// Too late for either: brake.
    Emergency,
    Unknown,
}

/// Inputs of the choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Situation {
    pub(super) known: bool,
    /// The pass's plan crosses the line in time, and the safety filter lets it.
    pub(super) reaches: bool,
    /// It stands, or starts, close to a line that shows green now.
    pub(super) starts: bool,
    /// Going on clears the line before red, by what is or was last announced.
    pub(super) clears: bool,
    /// Braking with the comfort bound from now on stops before the line.
    pub(super) comfortable_stop: bool,
    /// Braking as hard as the law can stops before the line.
    pub(super) hard_stop: bool,
    pub(super) pass_cost: f64,
    pub(super) stop_cost: f64,
    /// Earlier choice for this line.
    pub(super) before: Option<Choice>,
}

/// Costs this close are alike; the line is then still far away.
const TIE: f64 = 1.0;

pub(super) fn choose(s: &Situation, hysteresis: f64) -> (Choice, Reason) {
    if s.known && s.starts && s.clears {
        return (Choice::Pass, Reason::GreenInReach);
    }
    if s.known && s.reaches {
        let share = 1.0 + hysteresis;
        let cheaper = match s.before {
            Some(Choice::Stop) => s.pass_cost * share <= s.stop_cost + TIE,
            Some(Choice::Pass) | None => s.pass_cost <= s.stop_cost * share + TIE,
        };
        if cheaper || !s.comfortable_stop {
            return (Choice::Pass, Reason::GreenInReach);
        }
        return (Choice::Stop, Reason::StopCheaper);
    }
    let reason = if s.known { Reason::GreenOutOfReach } else { Reason::Unknown };
    // An unknown phase may be red: comfort does not count then.
    if s.comfortable_stop || !s.known && s.hard_stop {
        (Choice::Stop, reason)
    } else if s.clears {
        (Choice::Pass, Reason::ClearsInYellow)
    } else {
        (Choice::Stop, Reason::Emergency)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Situation = Situation {
        known: true,
        reaches: true,
        starts: false,
        clears: true,
        comfortable_stop: true,
        hard_stop: true,
        pass_cost: 10.0,
        stop_cost: 11.0,
        before: None,
    };

    #[test]
    fn hysteresis_keeps_what_was_chosen() {
        assert_eq!(choose(&S, 0.2), (Choice::Pass, Reason::GreenInReach));
        let stopping = Situation { before: Some(Choice::Stop), stop_cost: 10.5, ..S };
        assert_eq!(choose(&stopping, 0.2), (Choice::Stop, Reason::StopCheaper));
        let passing = Situation { before: Some(Choice::Pass), stop_cost: 9.0, ..S };
        assert_eq!(choose(&passing, 0.2), (Choice::Pass, Reason::GreenInReach));
    }

    #[test]
    fn a_green_that_is_shown_starts_a_vehicle_at_the_line_if_it_clears_before_red() {
        let waits = Situation { reaches: false, before: Some(Choice::Stop), ..S };
        assert_eq!(choose(&waits, 0.2).0, Choice::Stop);
        assert_eq!(choose(&Situation { starts: true, ..waits }, 0.2).0, Choice::Pass);
        let late = Situation { starts: true, clears: false, ..waits };
        assert_eq!(choose(&late, 0.2).0, Choice::Stop);
        let unknown = Situation { starts: true, known: false, ..waits };
        assert_eq!(choose(&unknown, 0.2).0, Choice::Stop);
    }

    #[test]
    fn unknown_is_never_green() {
        let unknown = Situation { known: false, ..S };
        assert_eq!(choose(&unknown, 0.2), (Choice::Stop, Reason::Unknown));
        let hard = Situation { comfortable_stop: false, ..unknown };
        assert_eq!(choose(&hard, 0.2), (Choice::Stop, Reason::Unknown));
        let late = Situation { hard_stop: false, ..hard };
        assert_eq!(choose(&late, 0.2), (Choice::Pass, Reason::ClearsInYellow));
        let red = Situation { clears: false, ..late };
        assert_eq!(choose(&red, 0.2), (Choice::Stop, Reason::Emergency));
    }

    #[test]
    fn yellow_is_crossed_only_when_stopping_is_uncomfortable() {
        let yellow = Situation { reaches: false, ..S };
        assert_eq!(choose(&yellow, 0.2), (Choice::Stop, Reason::GreenOutOfReach));
        let late = Situation { comfortable_stop: false, ..yellow };
        assert_eq!(choose(&late, 0.2), (Choice::Pass, Reason::ClearsInYellow));
    }
}
