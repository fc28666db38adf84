//! The draws of the kinds. Ranges are chosen: what public roads have, not what is mastered.

use scenario::{Setting, table};

use crate::scene::{Actor, CAR_LENGTH_M, Draws, LANE_M, LateralChange, Scene, SpeedChange};

/// Time before something happens behind a lead, in which the law settles, s.
const SETTLE_S: f64 = 10.0;

/// A lead of the ego's speed, at a gap from which every law settles.
fn settled(speed_mps: f64) -> Actor {
    Actor::car("lead", 2.0 * speed_mps + 6.0, speed_mps)
}

fn brakes(from_s: f64, rate_mps2: f64) -> SpeedChange {
    SpeedChange { from_s, to_mps: 0.0, rate_mps2 }
}

/// A vehicle that comes in with 1 to 2.5 s of time gap and at most 3 m/s slower.
pub fn cut_in(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(12.0, 36.0);
    let slower_mps = draws.between(-4.0, 3.0);
    let time_gap_s = draws.between(1.0, 2.5);
    let (from_s, lasts_s) = (draws.between(2.0, 4.0), draws.between(3.0, 6.0));
    // The gap is that at the end of the motion.
    let gap_m = time_gap_s * speed_mps + 2.0 + slower_mps.max(0.0) * (from_s + lasts_s);
    Scene::new(speed_mps, speed_mps, from_s + lasts_s + 10.0).with(Actor {
        lateral_m: LANE_M * draws.side(),
        laterals: vec![LateralChange { from_s, to_m: 0.0, lasts_s }],
        ..Actor::car("other", gap_m, speed_mps - slower_mps)
    })
}

/// A vehicle that comes in with 0.5 to 1.5 s of time gap, 2 to 10 m/s slower. It then brakes.
pub fn cut_in_that_brakes(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(14.0, 33.0);
    let other_mps = speed_mps - draws.between(2.0, 10.0);
    let (from_s, lasts_s) = (draws.between(2.0, 4.0), draws.between(1.5, 4.0));
    let half_in_s = from_s + 0.5 * lasts_s;
    let gap_m = draws.between(0.5, 1.5) * speed_mps + (speed_mps - other_mps) * half_in_s;
    let brakes_s = half_in_s + draws.between(0.5, 3.0);
    let rate_mps2 = draws.between(2.0, 5.0);
    Scene::new(speed_mps, speed_mps, brakes_s + other_mps / rate_mps2 + 5.0).with(Actor {
        lateral_m: LANE_M * draws.side(),
        laterals: vec![LateralChange { from_s, to_m: 0.0, lasts_s }],
        speeds: vec![brakes(brakes_s, rate_mps2)],
        ..Actor::car("other", gap_m, other_mps)
    })
}

/// A faster car that comes in close ahead and pulls away.
pub fn pulls_away(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(12.0, 34.0);
    let other_mps = speed_mps + draws.between(0.5, 6.0);
    let (from_s, lasts_s) = (draws.between(2.0, 4.0), draws.between(2.0, 5.0));
    Scene::new(speed_mps, speed_mps, from_s + lasts_s + 10.0).with(Actor {
        lateral_m: LANE_M * draws.side(),
        laterals: vec![LateralChange { from_s, to_m: 0.0, lasts_s }],
        ..Actor::car("other", draws.between(3.0, 15.0), other_mps)
    })
}

/// A car in the lane that is 2 to 12 m/s slower, seen from afar.
pub fn slower(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(14.0, 36.0);
    let other_mps = speed_mps - draws.between(2.0, 12.0);
    Scene::new(speed_mps, speed_mps, 35.0).with(Actor::car(
        "slower",
        draws.between(80.0, 250.0),
        other_mps,
    ))
}

/// A car that stands in the lane.
pub fn standing(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 30.0);
    let gap_m = draws.between(150.0, 300.0);
    Scene::new(speed_mps, speed_mps, gap_m / speed_mps + 15.0)
        .with(Actor::car("standing", gap_m, 0.0))
}

/// A car that is 12 to 28 m/s slower, 70 to 120 m ahead.
pub fn fast_closing(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(26.0, 36.0);
    let other_mps = (speed_mps - draws.between(12.0, 28.0)).max(0.0);
    Scene::new(speed_mps, speed_mps, 25.0).with(Actor::car(
        "slow",
        draws.between(70.0, 120.0),
        other_mps,
    ))
}

/// A lead that brakes to standstill with 0.5 to 2.5 m/s², waits and moves off.
pub fn stop(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 30.0);
    let braking_mps2 = draws.between(0.5, 2.5);
    let going_mps2 = draws.between(0.5, 1.5);
    let goes_s = SETTLE_S + speed_mps / braking_mps2 + draws.between(2.0, 5.0);
    let goes = SpeedChange { from_s: goes_s, to_mps: speed_mps, rate_mps2: going_mps2 };
    let speeds = vec![brakes(SETTLE_S, braking_mps2), goes];
    Scene::new(speed_mps, speed_mps + 4.0, goes_s + 10.0)
        .with(Actor { speeds, ..settled(speed_mps) })
}

/// A lead that stops and goes four times.
pub fn stop_and_go(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(4.0, 14.0);
    let (mut time_s, mut speeds) = (SETTLE_S, Vec::new());
    for _ in 0..4 {
        for to_mps in [0.0, speed_mps * draws.between(0.6, 1.0)] {
            let rate_mps2 = draws.between(0.8, 2.5);
            speeds.push(SpeedChange { from_s: time_s, to_mps, rate_mps2 });
            time_s += speed_mps / rate_mps2 + draws.between(1.0, 6.0);
        }
    }
    Scene::new(speed_mps, speed_mps + 6.0, time_s + 5.0)
        .with(Actor { speeds, ..settled(speed_mps) })
}

/// A lead that brakes with 3 to 9 m/s² after settled following.
pub fn braking_lead(draws: &mut Draws) -> Scene {
    let braking_mps2 = draws.between(3.0, 9.0);
    let speed_mps = draws.between(8.0, 36.0);
    let speeds = vec![brakes(SETTLE_S, braking_mps2)];
    Scene::new(speed_mps, speed_mps + 4.0, SETTLE_S + speed_mps / 2.5 + 6.0)
        .with(Actor { speeds, ..settled(speed_mps) })
}

/// Slower vehicles in both neighbouring lanes, which wander in theirs and are passed.
pub fn pass(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(15.0, 36.0);
    let mut scene = Scene::new(speed_mps, speed_mps, 20.0);
    let mut gap_m = 40.0;
    for (number, side) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
        let other_mps = speed_mps - draws.between(2.0, 12.0);
        let lateral_m = side * draws.between(3.2, 3.8);
        let near_m = side * draws.between(3.0, 3.5);
        let from_s = draws.between(1.0, 8.0);
        scene.actors.push(Actor {
            lateral_m,
            laterals: vec![
                LateralChange { from_s, to_m: near_m, lasts_s: 3.0 },
                LateralChange { from_s: from_s + 4.0, to_m: lateral_m, lasts_s: 3.0 },
            ],
            ..Actor::car(format!("lane-{number}"), gap_m, other_mps)
        });
        gap_m += draws.between(10.0, 40.0);
    }
    scene
}

/// Vehicles that stand beside an empty lane, cars and lorries.
pub fn queue(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 36.0);
    beside(draws, speed_mps, 0.0, 8)
}

/// The same vehicles, crawling.
pub fn crawling_queue(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 36.0);
    let other_mps = draws.between(0.5, 0.4 * speed_mps);
    beside(draws, speed_mps, other_mps, 8)
}

/// Either of them behind a lead that drives past.
pub fn led_queue(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 36.0);
    let crawls = draws.chance(0.5);
    let other_mps = if crawls { draws.between(0.5, 0.4 * speed_mps) } else { 0.0 };
    let scene = beside(draws, speed_mps, other_mps, 7);
    scene.with(Actor::car("lead", draws.between(1.5, 2.5) * speed_mps + 5.0, speed_mps))
}

/// Vehicles at one speed: in a column on one side, in turn left and right, or in pairs exactly abreast.
fn beside(draws: &mut Draws, speed_mps: f64, other_mps: f64, count: u32) -> Scene {
    let (side, order, lane_m) = (draws.side(), draws.between(0.0, 3.0), draws.between(3.2, 3.75));
    let (abreast, in_turn) = (order < 1.0, order < 2.0);
    let room_m = draws.between(4.0, 40.0);
    let mut gap_m = 120.0;
    let mut scene = Scene::new(speed_mps, speed_mps, 10.0);
    for number in 0..count {
        let lorry = draws.chance(0.3);
        let length_m = if lorry { draws.between(8.0, 18.0) } else { CAR_LENGTH_M };
        let lateral_m = if in_turn && number % 2 == 1 { -side * lane_m } else { side * lane_m };
        let car = Actor::car(format!("queue-{number}"), gap_m, other_mps);
        scene.actors.push(Actor { lateral_m, length_m, ..car });
        if !abreast || number % 2 == 1 {
            // The longest vehicle fits, so the length of the first of a pair does not count.
            gap_m += room_m + if abreast { 18.0 } else { length_m };
        }
        scene.duration_s = (gap_m / (speed_mps - other_mps) + 2.0).min(40.0);
    }
    scene
}

/// A two-wheeler that stands 0.5 to 1 m beside the ego's side.
pub fn two_wheeler(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(6.0, 22.0);
    let width_m = draws.between(0.5, 0.8);
    let lateral_m = draws.side() * (0.9 + draws.between(0.5, 1.0) + 0.5 * width_m);
    let gap_m = draws.between(50.0, 140.0);
    let rider = Actor::car("rider", gap_m, 0.0);
    Scene::new(speed_mps, speed_mps, gap_m / speed_mps + 4.0).with(Actor {
        lateral_m,
        width_m,
        length_m: 1.9,
        ..rider
    })
}

/// A lead that leaves for the next lane, in time, before a vehicle that stands or is slow.
pub fn cut_out(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(10.0, 36.0);
    let stands = draws.chance(0.5);
    let other_mps = if stands { 0.0 } else { draws.between(0.1, 0.5) * speed_mps };
    let leaves_in_s = draws.between(2.5, 4.5);
    let left_s = draws.between(1.0, 3.0);
    let lead = settled(speed_mps);
    let end_s = SETTLE_S + leaves_in_s;
    let front_m = lead.gap_m + CAR_LENGTH_M + speed_mps * end_s;
    let gap_m = front_m + left_s * (speed_mps - other_mps) - other_mps * end_s;
    let to_m = LANE_M * draws.side();
    let laterals = vec![LateralChange { from_s: SETTLE_S, to_m, lasts_s: leaves_in_s }];
    Scene::new(speed_mps, speed_mps, end_s + left_s + 15.0)
        .with(Actor { laterals, ..lead })
        .with(Actor::car("other", gap_m, other_mps))
}

/// A car 3 to 8 m/s slower, or a lead that brakes gently. The radar misses 30 to 90 % of what it should see.
pub fn half_blind(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(14.0, 30.0);
    let dropout = draws.between(0.3, 0.9);
    let mut scene = Scene::new(speed_mps, speed_mps, 40.0);
    if draws.chance(0.5) {
        let other_mps = speed_mps - draws.between(3.0, 8.0);
        scene.actors.push(Actor::car("slower", draws.between(80.0, 200.0), other_mps));
    } else {
        let speeds = vec![brakes(SETTLE_S, draws.between(1.0, 3.0))];
        scene.actors.push(Actor { speeds, ..settled(speed_mps) });
    }
    scene.keys.push(Setting::new("perception.radar.dropout_probability", dropout));
    scene
}

/// A lead at constant speed, seen among 10 to 60 false detections in each scan.
pub fn false_detections(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 34.0);
    let alarms = draws.between(10.0, 60.0);
    let mut scene = Scene::new(speed_mps, speed_mps + 2.0, 30.0);
    let gap_m = draws.between(1.0, 2.5) * speed_mps + 5.0;
    scene.actors.push(Actor::car("lead", gap_m, speed_mps));
    scene.keys.push(Setting::new("perception.radar.detections.false_alarms_per_scan", alarms));
    scene
}

/// A lead that brakes while no tracks arrive for 1 to 3 s, once or again and again. The braking begins 0.5 s before, so that it
/// can be known.
pub fn lost_tracks(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(12.0, 32.0);
    let brakes_s = SETTLE_S + draws.between(0.0, 2.0);
    let to_mps = speed_mps * draws.between(0.0, 0.6);
    let slows = SpeedChange { from_s: brakes_s, to_mps, rate_mps2: draws.between(1.0, 4.0) };
    let mut scene = Scene::new(speed_mps, speed_mps + 3.0, brakes_s + 25.0);
    scene.actors.push(Actor { speeds: vec![slows], ..settled(speed_mps) });
    let first_s = brakes_s + draws.between(0.5, 2.0);
    let again = if draws.chance(0.3) { 4 } else { 1 };
    let lost_s = draws.between(1.0, 3.0);
    let lost = |number: i32| {
        let at_s = first_s + f64::from(number) * 4.0;
        table! { kind: "drop", topic: "radar/tracks", at_s: at_s, for_s: lost_s }
    };
    scene.keys.push(Setting::new("faults", (0..again).map(lost).collect::<Vec<_>>()));
    scene
}

/// A lead that brakes while the controller's clock is ahead by 0.1 to 2 ms.
pub fn clock_ahead(draws: &mut Draws) -> Scene {
    let mut scene = braking_lead(draws);
    let (at_s, amount) = (SETTLE_S - 2.0, draws.between(1e-4, 2e-3));
    let step = table! { kind: "clock-step", service: "controller", at_s: at_s, amount: amount };
    scene.keys.push(Setting::new("faults", vec![step]));
    scene
}

/// A vehicle in the next lane that brakes. It is 0 to 40 m ahead of an ego which then passes it, or farther ahead.
pub fn brakes_beside(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(10.0, 34.0);
    let other_mps = speed_mps * draws.between(0.7, 1.3);
    let from_s = draws.between(2.0, 6.0);
    // Nothing starts behind the ego.
    let gap_m = (draws.between(0.0, 40.0) + (speed_mps - other_mps) * from_s).max(0.0);
    let rate_mps2 = draws.between(2.0, 8.0);
    let slows = SpeedChange { from_s, to_mps: other_mps * draws.between(0.0, 0.5), rate_mps2 };
    Scene::new(speed_mps, speed_mps, from_s + other_mps / rate_mps2 + 8.0).with(Actor {
        lateral_m: draws.side() * draws.between(3.2, 3.75),
        speeds: vec![slows],
        ..Actor::car("beside", gap_m, other_mps)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::CAR_WIDTH_M;

    #[test]
    fn a_two_wheeler_is_never_in_the_way() {
        for number in 0..200 {
            let scene = two_wheeler(&mut Draws::of(number, number.into(), 0x1501));
            let rider = &scene.actors[0];
            let beside_m = rider.lateral_m.abs() - 0.5 * (rider.width_m + CAR_WIDTH_M);
            assert!((0.5..=1.0).contains(&(beside_m + 1e-12)), "{number}: {beside_m}");
        }
    }

    #[test]
    fn a_cut_out_leaves_before_it_reaches_what_it_leaves_for() {
        for number in 0..200 {
            let scene = cut_out(&mut Draws::of(number, number.into(), 0x1501));
            let end_s = SETTLE_S + scene.actors[0].laterals[0].lasts_s;
            let (lead, other) = (scene.actors[0].at(end_s), scene.actors[1].at(end_s));
            assert!(lead.rear_m + CAR_LENGTH_M < other.rear_m, "{number}");
        }
    }
}
