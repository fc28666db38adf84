//! The signals behind the nearest. They have no programs of their own. They need none while each green that the drive
//! without them reaches is driven through.
//!
//! A program of its own could only gain a green that the present drive misses. The drive with all later lights green is
//! the earliest that the law makes. So its arrivals show which greens can be reached.

use law::Output;

use super::law;
use crate::world::{Signal, World};

/// A pass is planned for this long before the end of green, s.
const MARGIN_S: f64 = 0.5;
/// Time that caution may cost at a pass near the end of green, s.
const SLACK_S: f64 = 0.5;
/// Longer than any drive here, s.
const FOR_EVER_S: f64 = 200.0;

/// Red at first for this time, then green to the end.
fn opens(id: u32, line_m: f64, red_s: f64) -> Signal {
    let lengths_s = [FOR_EVER_S, 3.0, FOR_EVER_S];
    let (phase, left_s) = if red_s > 0.0 { (2, red_s) } else { (0, FOR_EVER_S) };
    Signal { id, line_m, lengths_s, phase, left_s }
}

/// Green for this time, then yellow and red to the end.
fn closes(id: u32, line_m: f64, green_s: f64) -> Signal {
    Signal { id, line_m, lengths_s: [FOR_EVER_S, 3.0, FOR_EVER_S], phase: 0, left_s: green_s }
}

/// Time when the ego, from 12 m/s, is past each line, s.
fn arrivals(signals: &[Signal]) -> Vec<Option<f64>> {
    let mut world = World::new(12.0, 13.9);
    world.signals = signals.to_vec();
    let (mut law, mut output) = (law(), Output::default());
    let mut past = vec![None; signals.len()];
    while world.time_s < 90.0 {
        world.step(&mut law, &mut output).expect("no red light is crossed");
        for (past, signal) in past.iter_mut().zip(signals) {
            if world.ego.position_m >= signal.line_m {
                past.get_or_insert(world.time_s);
            }
        }
    }
    past
}

#[test]
fn a_later_green_is_driven_through_whenever_the_drive_without_it_reaches_it() {
    let mut driven = 0;
    // Starts from a standstill at the first light, from a glide to it, and past it.
    for red_s in [20.0, 9.0, 0.0] {
        for (second_m, third_m) in [(140.0, 180.0), (180.0, 300.0), (250.0, 500.0), (400.0, 470.0)]
        {
            let first = opens(1, 100.0, red_s);
            let free = [first, opens(2, second_m, 0.0), opens(3, third_m, 0.0)];
            let free = arrivals(&free);
            let (second_s, third_s) = (free[1].expect("green"), free[2].expect("green"));
            for spare_s in [MARGIN_S + 0.25, 1.0, 2.0, 4.0, 8.0] {
                let past = arrivals(&[
                    first,
                    closes(2, second_m, second_s + spare_s),
                    closes(3, third_m, third_s + spare_s),
                ]);
                let late =
                    |at: Option<f64>, free_s: f64| at.map_or(f64::INFINITY, |at| at - free_s);
                let (second, third) = (late(past[1], second_s), late(past[2], third_s));
                assert!(
                    second < SLACK_S && third < SLACK_S,
                    "red {red_s}, lines {second_m} and {third_m}, {spare_s} to spare: {second} and {third} s late"
                );
                driven += 1;
            }
        }
    }
    assert_eq!(driven, 60);
}

#[test]
fn a_later_green_that_cannot_be_reached_is_stopped_for() {
    let first = opens(1, 100.0, 20.0);
    let free = arrivals(&[first, opens(2, 250.0, 0.0)]);
    let past = arrivals(&[first, closes(2, 250.0, free[1].expect("green") - 4.0)]);
    assert_eq!((past[0].is_some(), past[1]), (true, None));
}
