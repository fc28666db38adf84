//! The roadside unit's signals, as messages carry them.
//!
//! The programs are fixed: earliest, likely and latest end are equal and certain. An end is infinite for a phase that
//! lasts for ever.

use bytemuck::Zeroable;
use messages::{
    AnnouncedMotion, Interval, Lane, Lights, MAX_SIGNALS, PhaseState, Signal, SignalTruth,
};
use scenario::v2x::{Phase, V2x};

use crate::numbers::NUMBERS;
use crate::program::Program;
use crate::unit_clock::UnitClock;

/// Highest confidence of a predicted time: 0 to 15 of the standard mean 21 % to 100 %.
pub const CERTAIN: u8 = 15;

/// All signals along the road.
#[derive(Clone, Debug)]
pub struct RoadsideUnit {
    pub(crate) range_m: f64,
    signals: Vec<(Lane, Program)>,
}

impl RoadsideUnit {
    pub fn new(v2x: &V2x) -> Self {
        let signals = v2x.signals.iter().map(|signal| {
            let lane = Lane {
                intersection_id: signal.intersection_id.value().into(),
                signal_group: signal.signal_group.value().into(),
                stop_line_m: signal.stop_line_m.value(),
            };
            (lane, Program::new(signal))
        });
        Self { range_m: v2x.range_m.value(), signals: signals.collect() }
    }

    /// Signals received at a place and time, without a header: those within radio range ahead, and those just passed.
    pub fn received(&self, time_ns: u64, ego_m: f64) -> SignalTruth {
        self.signals_within(self.range_m, &UnitClock::OWN, time_ns, ego_m)
    }

    /// Signals without regard to the radio's range: the next ones ahead and those just passed, up to a message's room.
    /// The programs run by `clock`.
    pub fn truth(&self, clock: &UnitClock, time_ns: u64, ego_m: f64) -> SignalTruth {
        self.signals_within(f64::INFINITY, clock, time_ns, ego_m)
    }

    fn signals_within(
        &self,
        range_m: f64,
        clock: &UnitClock,
        time_ns: u64,
        ego_m: f64,
    ) -> SignalTruth {
        let near = self.signals.iter().filter(|(lane, _)| is_near(lane, ego_m, range_m));
        told(near.map(|(lane, program)| (*lane, signal(lane, program, clock, time_ns))))
    }
}

/// Signals of another simulator that are up to `range_m` ahead of the ego, and those just passed.
pub fn near(lights: &Lights, ego_m: f64, range_m: f64) -> SignalTruth {
    let all = lights.lanes().iter().zip(lights.signals());
    let near = all.filter(|(lane, _)| is_near(lane, ego_m, range_m));
    told(near.map(|(lane, signal)| (*lane, *signal)))
}

/// The radio of another simulator's vehicle reaches the ego.
pub fn is_audible(motion: &AnnouncedMotion, ego_m: f64, range_m: f64) -> bool {
    motion.station_id > 0 && (motion.rear_position_m - ego_m).abs() <= range_m
}

fn is_near(lane: &Lane, ego_m: f64, range_m: f64) -> bool {
    (-NUMBERS.passed_m..=range_m).contains(&(lane.stop_line_m - ego_m))
}

fn told(signals: impl Iterator<Item = (Lane, Signal)>) -> SignalTruth {
    let mut told = SignalTruth::zeroed();
    for (slot, (lane, signal)) in signals.take(MAX_SIGNALS).enumerate() {
        (told.lanes[slot], told.signals[slot]) = (lane, signal);
        told.count += 1;
    }
    told
}

/// A program's present phase and those behind it.
fn signal(lane: &Lane, program: &Program, clock: &UnitClock, time_ns: u64) -> Signal {
    let mut signal = Signal::zeroed();
    signal.intersection_id = lane.intersection_id;
    signal.signal_group = lane.signal_group;
    let intervals = program.intervals(clock.unit_ns(time_ns));
    for (place, interval) in signal.intervals.iter_mut().zip(intervals) {
        let end_s = interval.end_ns.map_or(f64::INFINITY, |ns| clock.vehicle_ns(ns) as f64 / 1e9);
        let state = match interval.phase {
            Phase::Green => PhaseState::ProtectedMovementAllowed,
            Phase::Yellow => PhaseState::ProtectedClearance,
            Phase::Red => PhaseState::StopAndRemain,
        };
        *place = Interval {
            state: state.to_wire(),
            confidence: CERTAIN.into(),
            min_end_s: end_s,
            likely_end_s: end_s,
            max_end_s: end_s,
        };
        signal.count += 1;
    }
    signal
}

#[cfg(test)]
mod tests {
    use scenario::{Scenario, builtin};

    use super::*;
    use messages::MAX_INTERVALS;

    const SECOND: u64 = 1_000_000_000;

    fn unit(name: &str) -> RoadsideUnit {
        let builtin = builtin::find(name).expect("it is built in");
        RoadsideUnit::new(&Scenario::parse(name, builtin.text).expect("it is right").v2x)
    }

    fn pairs(signals: &SignalTruth) -> impl Iterator<Item = (&Lane, &Signal)> {
        signals.lanes().iter().zip(signals.signals())
    }

    fn ids(signals: &SignalTruth) -> Vec<u32> {
        pairs(signals).map(|(lane, _)| lane.intersection_id).collect()
    }

    #[test]
    fn signals_come_into_range_and_fall_behind_in_order() {
        let unit = unit("corridor");
        assert_eq!(unit.received(0, -1.0), SignalTruth::zeroed());
        assert_eq!(ids(&unit.received(0, 0.0)), [1]);
        assert_eq!(ids(&unit.received(0, 350.0)), [1, 2]);
        assert_eq!(ids(&unit.received(0, 351.0)), [2]);
        assert_eq!(unit.received(0, 1051.0), SignalTruth::zeroed());
        assert_eq!(ids(&unit.truth(&UnitClock::OWN, 0, 0.0)), [1, 2, 3]);
    }

    #[test]
    fn lanes_and_movements_belong_together() {
        for (lane, movement) in pairs(&unit("corridor").truth(&UnitClock::OWN, 0, 0.0)) {
            assert_eq!(lane.intersection_id, movement.intersection_id);
            assert_eq!(lane.signal_group, movement.signal_group);
            assert_eq!(movement.count, MAX_INTERVALS as u64);
        }
    }

    #[test]
    fn the_paper_sees_one_switch_at_five_seconds() {
        let signals = unit("cacc-a").received(1_300_000_000, 20.0);
        let (lane, movement) = pairs(&signals).next().expect("it is in range");
        assert_eq!(lane.stop_line_m, 80.0);
        assert_eq!(movement.count, 2);
        let [green, red] = [movement.intervals[0], movement.intervals[1]];
        assert_eq!(green.state, PhaseState::ProtectedMovementAllowed.to_wire());
        assert_eq!(green.likely_end_s, 5.0);
        assert_eq!(red.state, PhaseState::StopAndRemain.to_wire());
        assert_eq!(red.likely_end_s, f64::INFINITY);
    }

    /// A failure seen in the field: each message repeats the cycle of the first, so that announced times are past.
    #[test]
    fn announced_ends_lie_ahead_in_every_message() {
        let unit = unit("corridor");
        for k in 0..5000u64 {
            let now_ns = k * 100_000_000;
            for (_, movement) in pairs(&unit.truth(&UnitClock::OWN, now_ns, 0.0)) {
                let mut from_s = now_ns as f64 / 1e9;
                for interval in movement.intervals() {
                    let end_s = interval.likely_end_s;
                    assert!(end_s.is_finite(), "these programs repeat");
                    assert!(end_s > from_s);
                    assert!(interval.min_end_s <= end_s && end_s <= interval.max_end_s);
                    from_s = end_s;
                }
            }
        }
    }

    /// Another failure: the announced end slides by one period with each message.
    #[test]
    fn an_announced_end_does_not_slide() {
        let unit = unit("corridor");
        let end = |time_ns| {
            let signals = unit.truth(&UnitClock::OWN, time_ns, 0.0);
            let (_, movement) = pairs(&signals).next().expect("there are three");
            movement.intervals[0].likely_end_s
        };
        for k in 0..270 {
            assert_eq!(end(k * 100_000_000), 27.0);
        }
        assert_eq!(end(27 * SECOND), 30.0);
    }
}
