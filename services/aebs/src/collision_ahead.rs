//! A vehicle ahead is about to hit another one in the ego's path. It then stands at once, nearer than the other by its
//! own length.
//!
//! The ego may have to stop behind either of the two. The probability of the first is a sum over its lateral speeds
//! ([`crate::filter`]). Each term is the probability that the first is still before the second when it gets there. On
//! the way it keeps its acceleration; one that brakes enough to stop short hits nothing. From the contact on it moves
//! with the second.
//!
//! With that probability the first is an object where it will stand.

use crate::filter::{Lateral, overlap};
use crate::object::{Object, WIDTH_M};

/// Slower than this above the other's speed it is not a collision, m/s.
const LEAST_CLOSING_MPS: f64 = 2.0;
/// Standard deviation of the place across the lanes where it then stands, m.
const SIGMA_M: f64 = 0.1;
/// A collision that is less probable than this is left out.
const LEAST_PROBABILITY: f64 = 0.05;

/// `first` as it will be where it hits `second`; `None` if it will not, or not in the ego's path. Its lateral motion is
/// carried on for `horizon_s` at most.
pub(crate) fn where_it_stands(first: &Object, second: &Object, horizon_s: f64) -> Option<Object> {
    if second.lateral.position_m.abs() > WIDTH_M {
        return None;
    }
    let time_s = time_to_contact_s(first, second)?;
    let second_sigma_m = second.lateral.position_sigma_m();
    let carried_s = time_s.min(horizon_s);
    let (mut touching, mut moment_m) = (0.0, 0.0);
    for h in &first.lateral.states {
        let position_m = h.position_m + h.rate_mps * carried_s;
        let off_m = (position_m - second.lateral.position_m).abs();
        let sigma_m = libm::hypot(h.sigma_after_m(carried_s), second_sigma_m);
        let touches = overlap(WIDTH_M, off_m, sigma_m);
        touching += h.probability * touches;
        moment_m += h.probability * touches * position_m;
    }
    let probability = touching * first.probability * second.probability;
    (probability > LEAST_PROBABILITY).then(|| Object {
        distance_m: second.distance_m - first.length_m,
        speed_mps: second.speed_mps,
        acceleration_mps2: second.acceleration_mps2,
        lateral: Lateral::first(moment_m / touching, SIGMA_M),
        probability,
        ..*first
    })
}

/// Time until the front of `first` is at the rear of `second`, s; `None` if it does not come there.
fn time_to_contact_s(first: &Object, second: &Object) -> Option<f64> {
    let closing_mps = first.speed_mps - second.speed_mps;
    if first.distance_m >= second.distance_m || closing_mps < LEAST_CLOSING_MPS {
        return None;
    }
    let room_m = (second.distance_m - first.distance_m - first.length_m).max(0.0);
    let braking_mps2 = (-first.acceleration_mps2).max(0.0);
    // It gets there if it is still faster by then.
    let left = closing_mps * closing_mps - 2.0 * braking_mps2 * room_m;
    (left > 0.0).then(|| 2.0 * room_m / (closing_mps + left.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn where_it_stands(first: &Object, second: &Object) -> Option<Object> {
        super::where_it_stands(first, second, 3.0)
    }

    #[test]
    fn a_lateral_motion_is_carried_on_as_far_as_the_horizon_says() {
        // Out of the way after 2 s with 1 m/s, not after 0.5 s.
        assert!(super::where_it_stands(&lead(0.5, 1.0), &standing(0.0), 0.5).is_some());
    }

    /// A lead at 20 m with 25 m/s, and what stands 50 m before it.
    fn lead(offset_m: f64, lateral_mps: f64) -> Object {
        Object::at(20.0, 25.0, offset_m, lateral_mps)
    }

    fn standing(offset_m: f64) -> Object {
        Object::at(74.3, 0.0, offset_m, 0.0)
    }

    #[test]
    fn a_lead_that_stays_in_the_way_stands_a_length_before_what_it_hits() {
        // 50 m at 25 m/s take 2 s, in which 0.4 m/s to the side are 0.8 m.
        let there = where_it_stands(&lead(0.5, 0.4), &standing(0.0)).expect("it hits it");
        assert!((there.distance_m - 70.0).abs() < 1e-9 && there.speed_mps == 0.0, "{there:?}");
        assert!((there.lateral.position_m - 1.3).abs() < 0.05, "{there:?}");
        assert!(there.probability > 0.99, "{there:?}");
        assert!(there.lateral.rate_mps.abs() < 1e-6, "{there:?}");
    }

    #[test]
    fn one_that_is_out_of_the_way_by_then_hits_nothing() {
        assert_eq!(where_it_stands(&lead(0.5, 1.0), &standing(0.0)), None);
        let there = where_it_stands(&lead(0.5, 0.7), &standing(0.0)).expect("it may hit it");
        assert!((0.4..0.6).contains(&there.probability), "{there:?}");
        assert_eq!(where_it_stands(&lead(0.5, 0.6), &standing(-0.5)), None, "that is farther");
    }

    #[test]
    fn one_that_brakes_enough_or_is_no_faster_hits_nothing() {
        // 25 m/s need 6.25 m/s² in 50 m.
        for (braking_mps2, hits) in [(0.0, true), (5.5, true), (6.5, false)] {
            let braking = Object { acceleration_mps2: -braking_mps2, ..lead(0.0, 0.0) };
            let there = where_it_stands(&braking, &standing(0.0));
            assert_eq!(there.is_some(), hits, "{braking_mps2}");
        }
        let slow = Object { speed_mps: 1.0, ..lead(0.0, 0.0) };
        assert_eq!(where_it_stands(&slow, &standing(0.0)), None);
        assert_eq!(where_it_stands(&standing(0.0), &lead(0.0, 0.0)), None, "it is behind");
    }

    #[test]
    fn a_collision_beside_the_path_does_not_concern_the_ego() {
        assert_eq!(where_it_stands(&lead(3.5, 0.0), &standing(3.5)), None);
        assert!(where_it_stands(&lead(1.5, 0.0), &standing(1.5)).is_some());
    }

    #[test]
    fn the_time_to_the_contact_is_that_of_the_constant_braking() {
        let time_s = |first: Object, second: Object| time_to_contact_s(&first, &second);
        assert_eq!(time_s(lead(0.0, 0.0), standing(0.0)), Some(2.0));
        // 6.2 of the 6.25 m/s² that would be enough: 25 m/s become √5 m/s over 50 m.
        let braking = Object { acceleration_mps2: -6.2, ..lead(0.0, 0.0) };
        let found_s = time_s(braking, standing(0.0)).expect("it gets there");
        assert!((found_s - (25.0 - f64::sqrt(5.0)) / 6.2).abs() < 1e-9, "{found_s}");
        let enough = Object { acceleration_mps2: -6.25, ..lead(0.0, 0.0) };
        assert_eq!(time_s(enough, standing(0.0)), None);
        let faster = Object { acceleration_mps2: 3.0, ..lead(0.0, 0.0) };
        assert_eq!(time_s(faster, standing(0.0)), Some(2.0), "it may stop to accelerate");
        // 2 m/s are a collision.
        for (speed_mps, expected) in [(2.0, Some(25.0)), (1.99, None)] {
            assert_eq!(time_s(Object { speed_mps, ..lead(0.0, 0.0) }, standing(0.0)), expected);
        }
        let touching = Object { distance_m: 72.0, ..lead(0.0, 0.0) };
        assert_eq!(time_s(touching, standing(0.0)), Some(0.0), "they overlap");
        let beside = Object { distance_m: 74.3, ..lead(0.0, 0.0) };
        assert_eq!(time_s(beside, standing(0.0)), None);
    }

    #[test]
    fn a_collision_counts_that_is_in_the_path_and_not_improbable() {
        // Half a width of both is 1.9 m.
        assert!(where_it_stands(&lead(1.89, 0.0), &standing(1.89)).is_some());
        assert_eq!(where_it_stands(&lead(1.91, 0.0), &standing(1.91)), None);
        assert!(where_it_stands(&lead(-1.89, 0.0), &standing(-1.89)).is_some());
        let hits = |probability: f64| {
            let first = Object { probability, ..lead(0.0, 0.0) };
            let second = Object { probability: 0.5, ..standing(0.0) };
            where_it_stands(&first, &second).map(|there| there.probability)
        };
        assert_eq!(hits(0.09), None);
        assert!(hits(0.11).is_some_and(|found| (found - 0.055).abs() < 1e-3));
    }
}
