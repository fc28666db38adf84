//! The roadside unit's signals, in the terms of SPATEM and MAPEM.
//!
//! | here | SAE J2735 / ISO TS 19091 |
//! |---|---|
//! | [`Movement`] | `MovementState` of an `IntersectionState` |
//! | [`Event`] | `MovementEvent` with its `TimeChangeDetails` |
//! | `start_ns`, `min_end_ns`, `max_end_ns`, `likely_end_ns`, `confidence` | `startTime`, `minEndTime`, `maxEndTime`, `likelyTime`, `confidence` |
//! | [`Lane`] | `GenericLane` with its stop line and the signal group of its connection |
//!
//! Times are nanoseconds since the start of the run. The programs are fixed: earliest, likely and
//! latest end are equal and certain.

use messages::{MAX_INTERVALS, MAX_SIGNALS};
use scenario::v2x::{Phase, V2x};

use crate::numbers::NUMBERS;
use crate::program::Program;

/// Highest confidence of a predicted time: 0 to 15 of the standard mean 21 % to 100 %.
pub const CERTAIN: u8 = 15;

/// Present and coming phases of one signal group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Movement {
    /// Id of the intersection.
    pub intersection_id: u16,
    /// Id of the signal group.
    pub signal_group: u8,
    /// The present phase and the phases behind it; `count` are valid.
    pub events: [Event; MAX_INTERVALS],
    /// Valid entries of `events`, at least 1.
    pub count: usize,
}

/// One phase of a movement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Shown phase: `protected-Movement-Allowed`, `protected-clearance` or `stop-And-Remain`.
    pub phase: Phase,
    /// Earliest end, ns; `None` without a planned end.
    pub min_end_ns: Option<u64>,
    /// Likely end, ns; `None` without a planned end.
    pub likely_end_ns: Option<u64>,
    /// Latest end, ns; `None` without a planned end.
    pub max_end_ns: Option<u64>,
    /// Confidence in the likely end, 0 to 15.
    pub confidence: u8,
}

/// A lane's stop line and the signal group that governs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lane {
    /// Id of the intersection.
    pub intersection_id: u16,
    /// Id of the signal group.
    pub signal_group: u8,
    /// Position of the stop line along the road, m.
    pub stop_line_m: f64,
}

/// Signals for the ego, in the order of their stop lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signals {
    /// Stop lines; `count` are valid.
    pub lanes: [Lane; MAX_SIGNALS],
    /// Their timing, in the same order.
    pub movements: [Movement; MAX_SIGNALS],
    /// Valid entries of both.
    pub count: usize,
}

/// All signals along the road.
#[derive(Clone, Debug)]
pub struct RoadsideUnit {
    range_m: f64,
    signals: Vec<(Lane, Program)>,
}

impl RoadsideUnit {
    /// The roadside unit of a scenario.
    #[must_use]
    pub fn new(v2x: &V2x) -> Self {
        let signals = v2x
            .signals
            .iter()
            .map(|signal| {
                let lane = Lane {
                    intersection_id: signal.intersection_id.value(),
                    signal_group: signal.signal_group.value(),
                    stop_line_m: signal.stop_line_m.value(),
                };
                (lane, Program::new(signal))
            })
            .collect();
        Self { range_m: v2x.range_m.value(), signals }
    }

    /// Signals received at a place and time: those within radio range ahead, and those just passed.
    #[must_use]
    pub fn received(&self, time_ns: u64, ego_position_m: f64) -> Signals {
        self.signals_within(self.range_m, time_ns, ego_position_m)
    }

    /// Signals without regard to the radio's range: the next ones ahead and those just passed, up to a message's room.
    #[must_use]
    pub fn truth(&self, time_ns: u64, ego_position_m: f64) -> Signals {
        self.signals_within(f64::INFINITY, time_ns, ego_position_m)
    }

    fn signals_within(&self, range_m: f64, time_ns: u64, ego_position_m: f64) -> Signals {
        let mut told = Signals::NONE;
        let near = self.signals.iter().filter(|(lane, _)| {
            (-NUMBERS.passed_m..=range_m).contains(&(lane.stop_line_m - ego_position_m))
        });
        for (slot, (lane, program)) in near.take(MAX_SIGNALS).enumerate() {
            told.lanes[slot] = *lane;
            told.movements[slot] = movement(lane, program, time_ns);
            told.count = slot + 1;
        }
        told
    }
}

impl Signals {
    /// No signal in reach.
    pub const NONE: Self = Self {
        lanes: [Lane { intersection_id: 0, signal_group: 0, stop_line_m: 0.0 }; MAX_SIGNALS],
        movements: [Movement {
            intersection_id: 0,
            signal_group: 0,
            events: [Event::NONE; MAX_INTERVALS],
            count: 0,
        }; MAX_SIGNALS],
        count: 0,
    };

    /// The valid signals with their stop lines.
    pub fn iter(&self) -> impl Iterator<Item = (&Lane, &Movement)> {
        self.lanes.iter().zip(&self.movements).take(self.count)
    }
}

impl Event {
    const NONE: Self = Self {
        phase: Phase::Red,
        min_end_ns: None,
        likely_end_ns: None,
        max_end_ns: None,
        confidence: 0,
    };
}

fn movement(lane: &Lane, program: &Program, time_ns: u64) -> Movement {
    let mut movement = Movement {
        intersection_id: lane.intersection_id,
        signal_group: lane.signal_group,
        events: [Event::NONE; MAX_INTERVALS],
        count: 0,
    };
    for (event, interval) in movement.events.iter_mut().zip(program.intervals(time_ns)) {
        *event = Event {
            phase: interval.phase,
            min_end_ns: interval.end_ns,
            likely_end_ns: interval.end_ns,
            max_end_ns: interval.end_ns,
            confidence: CERTAIN,
        };
        movement.count += 1;
    }
    movement
}

#[cfg(test)]
mod tests {
    use scenario::{Scenario, builtin};

    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn unit(name: &str) -> RoadsideUnit {
        let builtin = builtin::find(name).expect("it is built in");
        RoadsideUnit::new(&Scenario::parse(name, builtin.text).expect("it is right").v2x)
    }

    fn ids(signals: &Signals) -> Vec<u16> {
        signals.iter().map(|(lane, _)| lane.intersection_id).collect()
    }

    #[test]
    fn signals_come_into_range_and_fall_behind_in_order() {
        let unit = unit("corridor");
        assert_eq!(unit.received(0, -1.0), Signals::NONE);
        assert_eq!(ids(&unit.received(0, 0.0)), [1]);
        assert_eq!(ids(&unit.received(0, 350.0)), [1, 2]);
        assert_eq!(ids(&unit.received(0, 351.0)), [2]);
        assert_eq!(unit.received(0, 1051.0), Signals::NONE);
        assert_eq!(ids(&unit.truth(0, 0.0)), [1, 2, 3]);
    }

    #[test]
    fn lanes_and_movements_belong_together() {
        for (lane, movement) in unit("corridor").truth(0, 0.0).iter() {
            assert_eq!(lane.intersection_id, movement.intersection_id);
            assert_eq!(lane.signal_group, movement.signal_group);
            assert_eq!(movement.count, MAX_INTERVALS);
        }
    }

    #[test]
    fn the_paper_sees_one_switch_at_five_seconds() {
        let signals = unit("cacc-a").received(1_300_000_000, 20.0);
        let (lane, movement) = signals.iter().next().expect("it is in range");
        assert_eq!(lane.stop_line_m, 80.0);
        assert_eq!(movement.count, 2);
        assert_eq!(movement.events[0].phase, Phase::Green);
        assert_eq!(movement.events[0].likely_end_ns, Some(5 * SECOND));
        assert_eq!(movement.events[1].phase, Phase::Red);
        assert_eq!(movement.events[1].likely_end_ns, None);
    }

    /// A failure seen in the field: each message repeats the cycle of the first, so that announced times are past.
    #[test]
    fn announced_ends_lie_ahead_in_every_message() {
        let unit = unit("corridor");
        for k in 0..5000u64 {
            let now_ns = k * 100_000_000;
            for (_, movement) in unit.truth(now_ns, 0.0).iter() {
                let mut from_ns = now_ns;
                for event in &movement.events[..movement.count] {
                    let end_ns = event.likely_end_ns.expect("these programs repeat");
                    assert!(end_ns > from_ns);
                    assert!(event.min_end_ns <= event.likely_end_ns);
                    assert!(event.likely_end_ns <= event.max_end_ns);
                    from_ns = end_ns;
                }
            }
        }
    }

    /// Another failure: the announced end slides by one period with each message.
    #[test]
    fn an_announced_end_does_not_slide() {
        let unit = unit("corridor");
        let end = |time_ns| {
            let signals = unit.truth(time_ns, 0.0);
            let (_, movement) = signals.iter().next().expect("there are three");
            movement.events[0].likely_end_ns
        };
        for k in 0..270 {
            assert_eq!(end(k * 100_000_000), Some(27 * SECOND));
        }
        assert_eq!(end(27 * SECOND), Some(30 * SECOND));
    }
}
