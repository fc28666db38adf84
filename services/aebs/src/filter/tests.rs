//! Tests of the lateral filter.

use super::*;

const PERIOD_S: f64 = 0.05;

/// Repeatable errors with a standard deviation of about 1.
fn error(k: u32) -> f64 {
    let mixed = u64::from(k).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    (mixed as f64 / f64::from(1 << 24) - 0.5) * 12f64.sqrt()
}

/// Follows a motion measured with `sigma_m`; calls back after each scan.
fn follow(sigma_m: f64, motion: impl Fn(f64) -> f64, mut see: impl FnMut(f64, &Lateral)) {
    let mut filter = Lateral::first(motion(0.0) + sigma_m * error(0), sigma_m);
    for k in 1..400 {
        let time_s = f64::from(k) * PERIOD_S;
        filter.predict(PERIOD_S, f64::INFINITY);
        filter.update(motion(time_s) + sigma_m * error(k), sigma_m * sigma_m);
        see(time_s, &filter);
    }
}

#[test]
fn a_vehicle_in_its_lane_has_little_lateral_speed_and_says_how_little() {
    let (mut squares, mut believed, mut count) = (0.0, 0.0, 0.0);
    follow(
        0.08,
        |_| 3.5,
        |time_s, filter| {
            if time_s > 2.0 {
                squares += filter.rate_mps * filter.rate_mps;
                believed += filter
                    .states
                    .iter()
                    .map(|h| h.probability * h.rate_mps * h.rate_mps)
                    .sum::<f64>();
                count += 1.0;
            }
        },
    );
    assert!(f64::sqrt(squares / count) < 0.15, "{}", squares / count);
    assert!(believed > squares, "it claims no more than it knows: {believed} {squares}");
}

#[test]
fn a_lane_change_is_seen_within_two_fifths_of_a_second() {
    let mut seen_s = f64::INFINITY;
    let motion = |time_s: f64| 3.5 - 1.2 * (time_s - 5.0).max(0.0);
    follow(0.08, motion, |time_s, filter| {
        if time_s > 5.0 && filter.rate_mps < -0.6 {
            seen_s = seen_s.min(time_s - 5.0);
        }
    });
    assert!(seen_s < 0.41, "{seen_s} s");
}

#[test]
fn the_probabilities_are_those_of_a_distribution() {
    let motion = |time_s: f64| 3.5 - 0.7 * (time_s - 5.0).max(0.0);
    follow(0.3, motion, |_, filter| {
        let sum: f64 = filter.states.iter().map(|h| h.probability).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        assert!(filter.states.iter().all(|h| h.variance_m2.is_finite() && h.probability > 0.0));
    });
}

#[test]
fn a_measured_rate_counts_and_a_wild_one_hardly() {
    let mut filter = Lateral::first(3.5, 0.1);
    for _ in 0..4 {
        filter.update_rate(-1.0, 0.04);
    }
    assert!((filter.rate_mps + 1.0).abs() < 0.2, "{}", filter.rate_mps);
    let before_mps = filter.rate_mps;
    filter.update_rate(60.0, 1e-6);
    assert!((filter.rate_mps - before_mps).abs() < 1e-6);
}

#[test]
fn a_known_motion_has_its_rate() {
    for rate_mps in [-2.0, -0.73, 0.0, 0.1, 1.99] {
        let known = Lateral::known(2.0, rate_mps);
        assert!((known.rate_mps - rate_mps).abs() < 1e-6, "{rate_mps} {}", known.rate_mps);
    }
}

#[test]
fn a_way_that_moves_is_no_lateral_speed() {
    let mut filter = Lateral::first(0.0, 0.1);
    for k in 1..100 {
        filter.predict(PERIOD_S, f64::INFINITY);
        filter.shift(0.1);
        filter.update(0.1 * f64::from(k), 0.01);
    }
    assert!((filter.position_m - 9.9).abs() < 1e-9, "{}", filter.position_m);
    assert!(filter.rate_mps.abs() < 1e-9, "{}", filter.rate_mps);
}

#[test]
fn one_wild_position_moves_it_little() {
    let mut filter = Lateral::first(0.0, 0.1);
    for _ in 0..100 {
        filter.predict(PERIOD_S, f64::INFINITY);
        filter.update(0.0, 0.01);
    }
    filter.update(50.0, 0.01);
    assert!(filter.position_m < 0.3, "{filter:?}");
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    // Each state keeps a probability of 1e-9.
    assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
}

/// A motion of these states alone: number, probability, mean and variance.
fn of_states(of: &[(usize, f64, f64, f64)]) -> Lateral {
    let mut lateral = Lateral::first(0.0, 0.1);
    lateral.states.iter_mut().for_each(|state| state.probability = 0.0);
    for &(k, probability, position_m, variance_m2) in of {
        let state = &mut lateral.states[k];
        *state = State { probability, position_m, variance_m2, ..*state };
    }
    lateral.normalise();
    lateral
}

/// The number of the state with a rate.
fn state(rate_mps: f64) -> usize {
    RATES_MPS.iter().position(|rate| (rate - rate_mps).abs() < 1e-9).expect("a rate of the row")
}

#[test]
fn the_row_of_rates_is_even_and_keeping_the_lane_is_the_first_state() {
    let rates = RATES_MPS;
    assert_eq!(rates[0], 0.0);
    for k in 1..=10 {
        assert_near(rates[k], -2.2 + 0.2 * k as f64);
        assert_near(rates[10 + k], 0.2 * k as f64);
    }
}

#[test]
fn a_known_rate_is_shared_by_its_neighbours_in_the_row() {
    let known = Lateral::known(2.0, 0.73);
    assert_near(known.states[state(0.6)].probability, 0.35);
    assert_near(known.states[state(0.8)].probability, 0.65);
    assert_near(known.states[state(0.4)].probability, 0.0);
    let keeps = Lateral::known(2.0, 0.0);
    assert_near(keeps.states[0].probability, 1.0);
    assert_near(keeps.states[state(0.2)].probability, 0.0);
    assert_near(keeps.position_m, 2.0);
    assert_near(keeps.position_sigma_m(), 0.01);
}

#[test]
fn a_new_vehicle_probably_keeps_its_lane() {
    let first = Lateral::first(3.5, 0.7);
    let states = first.states;
    assert_near(states[0].probability, 0.8);
    assert!(states[1..].iter().all(|h| (h.probability - 0.01).abs() < 1e-12));
    assert!(states.iter().all(|h| h.position_m == 3.5 && (h.variance_m2 - 0.49).abs() < 1e-12));
    assert_eq!((first.position_m, first.rate_mps), (3.5, 0.0));
}

#[test]
fn an_uncertain_rate_makes_a_place_uncertain_in_time() {
    let state = State { probability: 1.0, rate_mps: 0.4, position_m: 0.0, variance_m2: 0.09 };
    assert_near(state.sigma_after_m(4.0), f64::sqrt(0.09 + 0.22 * 0.22));
}

/// 0.0075 in 50 ms from 10 m/s on, shared by all speeds that are no faster than the vehicle.
#[test]
fn a_lane_change_begins_with_each_speed_alike() {
    let begun = |fastest_mps: f64| {
        let mut keeps = Lateral::known(0.0, 0.0);
        keeps.predict(PERIOD_S, fastest_mps);
        (1..STATES).map(|k| keeps.states[k].probability).filter(|p| *p > 1e-6).collect::<Vec<_>>()
    };
    for (fastest_mps, states, all) in
        [(10.0, 20, 0.0075), (f64::INFINITY, 20, 0.0075), (3.0, 20, 0.00225), (1.0, 10, 0.00075)]
    {
        let begun = begun(fastest_mps);
        assert_eq!(begun.len(), states, "{fastest_mps}");
        let left = 1.0 - all * (1.0 - states as f64 / 20.0);
        begun.iter().for_each(|p| assert_near(*p, all / 20.0 / left));
    }
    assert!(begun(0.0).is_empty(), "what stands does not move");
}

#[test]
fn a_lane_change_ends_or_varies_its_speed() {
    let after = |from: usize| {
        let mut lateral = of_states(&[(from, 1.0, 0.5, 0.02)]);
        lateral.predict(PERIOD_S, f64::INFINITY);
        lateral
    };
    let lateral = after(state(1.0));
    for (rate_mps, probability) in [(0.8, 0.2), (1.0, 0.585), (1.2, 0.2), (1.4, 0.0)] {
        let state = state(rate_mps);
        assert_near(lateral.states[state].probability, probability);
        if probability > 0.0 {
            assert_near(lateral.states[state].position_m, 0.5 + 0.05 * rate_mps);
            assert_near(lateral.states[state].variance_m2, 0.02 + 5e-4);
        }
    }
    assert_near(lateral.states[0].probability, 0.015);
    assert_near(lateral.states[0].position_m, 0.5);
    // The fastest ones have one neighbour.
    assert_near(after(STATES - 1).states[STATES - 1].probability, 0.785);
    assert_near(after(STATES - 1).states[STATES - 2].probability, 0.2);
    assert_near(after(1).states[1].probability, 0.785);
    assert_near(after(1).states[2].probability, 0.2);
}

#[test]
fn no_vehicle_moves_across_faster_than_along() {
    let mut lateral = of_states(&[(state(1.0), 0.5, 0.0, 0.01), (state(-0.6), 0.5, 0.0, 0.01)]);
    lateral.predict(PERIOD_S, 0.9);
    assert_near(lateral.states[state(1.0)].probability, 0.0);
    assert_near(lateral.states[state(1.2)].probability, 0.0);
    assert!(lateral.states[state(-0.6)].probability > 0.4);
}

#[test]
fn a_state_that_others_become_is_their_mixture() {
    let mut lateral = of_states(&[(0, 0.5, 0.0, 0.01), (state(1.0), 0.5, 2.0, 0.03)]);
    lateral.predict(PERIOD_S, f64::INFINITY);
    // 0.015 of the lane change end, at 2 m. 0.9925 of the other stay.
    let (stay, end) = (0.5 * 0.9925, 0.5 * 0.015);
    let share = end / (stay + end);
    assert_near(lateral.states[0].probability, stay + end);
    assert_near(lateral.states[0].position_m, 2.0 * share);
    let within = 0.01 * (1.0 - share) + 0.03 * share;
    assert_near(lateral.states[0].variance_m2, within + 4.0 * share * (1.0 - share) + 5e-4);
}

fn normal(off: f64, variance: f64) -> f64 {
    libm::exp(-0.5 * off * off / variance) / libm::sqrt(2.0 * std::f64::consts::PI * variance)
}

#[test]
fn a_position_corrects_means_by_kalman_and_probabilities_by_bayes() {
    let mut lateral = of_states(&[(0, 0.6, 0.0, 0.01), (state(1.0), 0.4, 0.5, 0.02)]);
    lateral.update(0.1, 0.03);
    let inliers = [0.95 * normal(0.1, 0.04), 0.95 * normal(-0.4, 0.05)];
    let likelihoods = inliers.map(|inlier| inlier + 0.05 * 0.25);
    let sum = 0.6 * likelihoods[0] + 0.4 * likelihoods[1];
    assert_near(lateral.states[0].probability, 0.6 * likelihoods[0] / sum);
    assert_near(lateral.states[state(1.0)].probability, 0.4 * likelihoods[1] / sum);
    let gains = [inliers[0] / likelihoods[0] * 0.25, inliers[1] / likelihoods[1] * 0.4];
    assert_near(lateral.states[0].position_m, gains[0] * 0.1);
    assert_near(lateral.states[state(1.0)].position_m, 0.5 - gains[1] * 0.4);
    assert_near(lateral.states[0].variance_m2, 0.01 * (1.0 - gains[0]));
    assert_near(lateral.states[state(1.0)].variance_m2, 0.02 * (1.0 - gains[1]));
    let mean_m = lateral.states[0].probability * lateral.states[0].position_m
        + lateral.states[state(1.0)].probability * lateral.states[state(1.0)].position_m;
    assert_near(lateral.position_m, mean_m);
    assert_near(lateral.rate_mps, lateral.states[state(1.0)].probability);
}

/// A rate of the row stands for 0.2 m/s around it.
#[test]
fn a_rate_corrects_the_probabilities() {
    let mut lateral = of_states(&[(0, 0.5, 0.0, 0.01), (state(0.4), 0.5, 0.0, 0.01)]);
    lateral.update_rate(0.3, 0.01);
    let spread = 0.01 + 0.04 / 12.0;
    let likelihoods = [0.3, -0.1].map(|off| 0.95 * normal(off, spread) + 0.05 * 0.25);
    let sum = likelihoods[0] + likelihoods[1];
    assert_near(lateral.states[0].probability, likelihoods[0] / sum);
    assert_near(lateral.states[state(0.4)].probability, likelihoods[1] / sum);
    assert_near(lateral.rate_mps, 0.4 * likelihoods[1] / sum);
}

#[test]
fn an_overlap_is_a_normal_deviate_of_the_room() {
    for (reach_m, off_m, sigma_m, expected) in [
        (1.0, 1.0, 0.5, 0.5),
        (2.0, 1.0, 1.0, 0.841_344_746),
        (1.0, 2.0, 1.0, 0.158_655_254),
        (1.0, 0.0, 0.5, 0.977_249_868),
        (1.0, 0.999, 1e-3, 0.841_344_746),
    ] {
        assert_near(overlap(reach_m, off_m, sigma_m), expected);
    }
}
