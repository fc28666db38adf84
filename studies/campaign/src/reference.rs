//! Whether a collision could have been avoided: the verdict of a reference that brakes perfectly.
//!
//! From the first instant at which the deceleration that the ego needed exceeded the comfortable one, the reference
//! keeps its speed for a reaction time. Then it brakes evenly until standstill. The motion of the vehicle ahead is
//! taken from the record; past its end it keeps its last deceleration until it stands.
//!
//! ```text
//! x(t) = x0 + v t                                 t <= reaction
//! x(t) = x0 + v t - a (t - reaction)² / 2         until v = a (t - reaction)
//! ```

use group::DriveStep;
use plant::ahead::{Ahead, required_deceleration};

/// Parameters of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Braking {
    /// Deceleration above which a driver would act, m/s².
    pub comfortable_mps2: f64,
    /// Time from the need to the reference's braking, s.
    pub reaction_s: f64,
    /// Deceleration of the reference, m/s².
    pub emergency_mps2: f64,
}

/// A sample of the drive with a vehicle ahead.
#[derive(Clone, Copy)]
struct Sample {
    time_s: f64,
    position_m: f64,
    speed_mps: f64,
    rear_m: f64,
    lead_speed_mps: f64,
    lead_mps2: f64,
}

/// True if the reference, driving in place of the ego, does not touch the vehicle ahead.
pub fn avoids_contact(steps: &[DriveStep], braking: &Braking) -> bool {
    let samples = samples(steps);
    let needs = |sample: &Sample| {
        let ahead = Ahead {
            gap_m: sample.rear_m - sample.position_m,
            speed_mps: sample.lead_speed_mps,
            acceleration_mps2: sample.lead_mps2,
        };
        required_deceleration(sample.speed_mps, &ahead)
    };
    let Some(first) = samples.iter().position(|s| needs(s) > braking.comfortable_mps2) else {
        // No braking was needed.
        return true;
    };
    let begin = samples[first];
    let brakes_s = begin.speed_mps / braking.emergency_mps2;
    let stop_s = braking.reaction_s + brakes_s;
    let position_m = |time_s: f64| {
        let since_s = time_s - begin.time_s;
        let braked_s = (since_s - braking.reaction_s).clamp(0.0, brakes_s);
        let reached_m = begin.speed_mps * since_s.min(stop_s);
        begin.position_m + reached_m - 0.5 * braking.emergency_mps2 * braked_s * braked_s
    };
    let clear = |sample: &Sample| position_m(sample.time_s) < sample.rear_m;
    samples[first..].iter().all(clear) && stays_clear(&begin, stop_s, position_m, &samples)
}

/// True if the reference stays clear from the end of the record until it stands.
fn stays_clear(
    begin: &Sample,
    stop_s: f64,
    position_m: impl Fn(f64) -> f64,
    samples: &[Sample],
) -> bool {
    /// Time between two checks, s.
    const CHECK_S: f64 = 0.01;
    let Some(last) = samples.last() else { return true };
    let braking = (-last.lead_mps2).max(0.0);
    let lead_stops_s = if braking > 0.0 { last.lead_speed_mps / braking } else { f64::INFINITY };
    let left_s = begin.time_s + stop_s - last.time_s;
    let checks = (left_s / CHECK_S).ceil().max(0.0) as u64;
    (1..=checks).map(|check| check as f64 * CHECK_S).all(|after_s| {
        let braked_s = after_s.min(lead_stops_s);
        let rear_m = last.rear_m + (last.lead_speed_mps - 0.5 * braking * braked_s) * braked_s;
        position_m(last.time_s + after_s) < rear_m
    })
}

/// The samples with a vehicle ahead. Its acceleration is the slope of its speed. Where the speed jumps, another
/// vehicle is ahead from then on.
fn samples(steps: &[DriveStep]) -> Vec<Sample> {
    /// Slope beyond that of any vehicle, m/s².
    const JUMP_MPS2: f64 = 30.0;
    let mut samples: Vec<Sample> = Vec::new();
    for step in steps {
        let (Some(gap_m), Some(lead_speed_mps)) = (step.gap_m, step.lead_speed_mps) else {
            continue;
        };
        let slope = samples.last().map_or(0.0, |last| {
            (lead_speed_mps - last.lead_speed_mps) / (step.time_s - last.time_s)
        });
        samples.push(Sample {
            time_s: step.time_s,
            position_m: step.position_m,
            speed_mps: step.speed_mps,
            rear_m: step.position_m + gap_m,
            lead_speed_mps,
            lead_mps2: if slope.abs() < JUMP_MPS2 { slope } else { 0.0 },
        });
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    const BRAKING: Braking =
        Braking { comfortable_mps2: 2.5, reaction_s: 0.0, emergency_mps2: 8.0 };

    /// An ego that keeps 20 m/s behind a vehicle that brakes, until they touch.
    fn drive(gap_m: f64, lead_mps2: f64, appears_s: f64) -> Vec<DriveStep> {
        let mut steps = Vec::new();
        for k in 0..2000_u32 {
            let time_s = f64::from(k) * 0.01;
            let braked_s = if lead_mps2 < 0.0 { time_s.min(20.0 / -lead_mps2) } else { time_s };
            let rear_m = gap_m + (20.0 + 0.5 * lead_mps2 * braked_s) * braked_s;
            let position_m = 20.0 * time_s;
            let there = time_s >= appears_s;
            steps.push(DriveStep {
                time_s,
                position_m,
                speed_mps: 20.0,
                gap_m: there.then_some(rear_m - position_m),
                lead_speed_mps: there.then_some(20.0 + lead_mps2 * braked_s),
                ..DriveStep::default()
            });
            if there && rear_m <= position_m {
                break;
            }
        }
        steps
    }

    #[test]
    fn braking_in_time_would_have_helped() {
        let steps = drive(30.0, -4.0, 0.0);
        assert!(steps.last().is_some_and(|step| step.gap_m.is_some_and(|gap| gap <= 0.0)));
        assert!(avoids_contact(&steps, &BRAKING));
    }

    #[test]
    fn a_vehicle_that_stops_dead_at_arms_length_cannot_be_avoided() {
        // Seen standing 10 m ahead of an ego at 20 m/s, which needs 25 m to stop at 8 m/s².
        let steps: Vec<_> = (0..60_u32)
            .map(|k| {
                let (time_s, position_m) = (f64::from(k) * 0.01, f64::from(k) * 0.2);
                let gap_m = Some(10.0 - position_m);
                let lead_speed_mps = Some(0.0);
                let speed_mps = 20.0;
                DriveStep {
                    time_s,
                    position_m,
                    speed_mps,
                    gap_m,
                    lead_speed_mps,
                    ..DriveStep::default()
                }
            })
            .collect();
        assert!(!avoids_contact(&steps, &BRAKING));
        let far: Vec<_> = steps
            .iter()
            .map(|step| DriveStep { gap_m: step.gap_m.map(|gap| gap + 20.0), ..*step })
            .collect();
        assert!(avoids_contact(&far, &BRAKING), "25 m suffice, 30 m are there");
    }

    /// Both stop from 20 m/s, the lead with 8 m/s² and the reference with 6: it needs 8.33 m, and 7 m more for its
    /// reaction of 0.35 s.
    #[test]
    fn the_reaction_time_costs_its_distance() {
        let braking = Braking { reaction_s: 0.35, emergency_mps2: 6.0, ..BRAKING };
        assert!(avoids_contact(&drive(16.0, -8.0, 0.0), &braking));
        assert!(!avoids_contact(&drive(14.5, -8.0, 0.0), &braking));
        assert!(avoids_contact(&drive(14.5, -8.0, 0.0), &Braking { reaction_s: 0.0, ..braking }));
    }

    #[test]
    fn a_vehicle_that_cuts_in_too_late_cannot_be_avoided() {
        // It appears when it stands 8.5 m ahead already.
        let steps = drive(30.0, -8.0, 2.3);
        let begin = steps.iter().find_map(|step| step.gap_m).expect("it appears");
        assert!((8.0..10.0).contains(&begin), "{begin}");
        assert!(!avoids_contact(&steps, &BRAKING));
    }

    #[test]
    fn without_a_vehicle_ahead_there_is_nothing_to_touch() {
        assert!(avoids_contact(&[], &BRAKING));
        assert!(avoids_contact(&drive(30.0, -4.0, 100.0), &BRAKING));
    }

    #[test]
    fn a_reference_that_still_rolls_at_the_records_end_is_followed_until_it_stands() {
        // The record ends just after the first need: the lead keeps braking as hard as the reference.
        let steps = drive(30.0, -8.0, 0.0);
        let short: Vec<_> = steps.into_iter().take(30).collect();
        assert!(avoids_contact(&short, &BRAKING));
        let close: Vec<_> = short
            .iter()
            .map(|step| DriveStep { gap_m: step.gap_m.map(|gap| gap - 29.0), ..*step })
            .collect();
        let weak = Braking { emergency_mps2: 5.0, ..BRAKING };
        assert!(!avoids_contact(&close, &weak), "weaker brakes than the lead's, 1 m behind it");
    }
}
