//! Begin and end of each level: ages at their bounds, releases until a recovery is proven, which level comes first.

use super::*;
use crate::law::Target;
use messages::Track;

/// Bounds of this scenario, s: radar 3 · 0.05 + 0.05, signals 3 · 0.2, odometry 0.1.
const RADAR_S: f64 = 0.2;
const SPAT_S: f64 = 0.6;
const ODOMETRY_S: f64 = 0.1;

fn ladder_of(keys: &str) -> Ladder {
    let text = format!("schema_version = 1\nname = \"ladder\"\n{keys}");
    Ladder::new(&Scenario::parse("ladder", &text).expect("a scenario"))
}

const SIGNAL: &str = "[[v2x.signals]]\nintersection_id = 1\nstop_line_m = 500\n\
                      program = [{ phase = \"green\", duration_s = 5 }]";

fn ladder() -> Ladder {
    ladder_of(&format!(
        "[perception]\nperiod_ms = 50\nradar.latency_ms = 50\n[v2x]\nperiod_ms = 200\n{SIGNAL}"
    ))
}

fn ages(odometry_s: f64, radar_s: f64, spat_s: f64) -> Ages {
    let [odometry_s, radar_s, spat_s] = [odometry_s, radar_s, spat_s].map(Some);
    Ages { odometry_s, radar_s, spat_s, ..Ages::default() }
}

const GOOD: (f64, f64, f64) = (0.0, 0.0, 0.0);

/// Level and validity of a first release.
fn first(ages: &Ages) -> (Level, SignalTrust) {
    let mut ladder = ladder();
    let trust = ladder.look(ages, 3.0);
    (ladder.level, trust)
}

#[test]
fn an_input_is_stale_above_its_bound() {
    use SignalTrust::{Announced, None, Proven};
    let more = 1e-6;
    let cases = [
        (ages(ODOMETRY_S, RADAR_S, SPAT_S), Level::Full, Announced),
        (ages(ODOMETRY_S + more, 0.0, 0.0), Level::Silent, Announced),
        (ages(0.0, RADAR_S + more, 0.0), Level::LeadPredicted, Announced),
        (ages(0.0, RADAR_S + PREDICT_S, 0.0), Level::LeadPredicted, Announced),
        (ages(0.0, RADAR_S + PREDICT_S + more, 0.0), Level::LeadLost, Announced),
        (ages(0.0, 0.0, SPAT_S + more), Level::SignalsLost, Proven),
        (ages(0.0, 0.0, BELIEVE_SIGNALS_S), Level::SignalsLost, Proven),
        (ages(0.0, 0.0, BELIEVE_SIGNALS_S + more), Level::SignalsLost, None),
        (Ages { odometry_s: Option::None, ..ages(0.0, 0.0, 0.0) }, Level::Silent, Announced),
        (Ages { spat_s: Option::None, ..ages(0.0, 0.0, 0.0) }, Level::SignalsLost, None),
        (Ages { radar_s: Option::None, ..ages(0.0, 0.0, 0.0) }, Level::LeadPredicted, Announced),
        // The strictest level comes first.
        (ages(9.0, 9.0, 9.0), Level::Silent, None),
        (ages(0.0, 9.0, 9.0), Level::LeadLost, None),
        (ages(0.0, 0.5, 9.0), Level::LeadPredicted, None),
        (Ages { ego_is_estimated: true, ..ages(0.0, 0.5, 9.0) }, Level::LeadPredicted, None),
        (Ages { ego_is_estimated: true, ..ages(0.0, 0.0, 9.0) }, Level::EgoEstimated, None),
        (Ages { signals_doubted: true, ..ages(0.0, 0.0, 0.0) }, Level::SignalsDoubted, Announced),
    ];
    for (ages, level, trust) in cases {
        assert_eq!(first(&ages), (level, trust), "{ages:?}");
    }
}

#[test]
fn bounds_follow_the_periods_of_the_sources() {
    let level = |keys: &str, radar_s: f64| {
        let mut ladder = ladder_of(keys);
        ladder.look(&ages(0.0, radar_s, 9.0), 0.0);
        ladder.level
    };
    // Without a signal ahead none is reported.
    assert_eq!(level("", 0.0), Level::Full);
    let slow = "[perception]\nperiod_ms = 100\nradar.latency_ms = 100";
    assert_eq!((level(slow, 0.4), level(slow, 0.401)), (Level::Full, Level::LeadPredicted));
    let ideal = "[perception]\nperiod_ms = 100\nideal = true\nradar.latency_ms = 100";
    assert_eq!((level(ideal, 0.3), level(ideal, 0.301)), (Level::Full, Level::LeadPredicted));
    // Never below 0.1 s.
    let quick = "[perception]\nperiod_ms = 10\nideal = true";
    assert_eq!((level(quick, 0.1), level(quick, 0.101)), (Level::Full, Level::LeadPredicted));
    assert!((ladder().stale_odometry_s - ODOMETRY_S).abs() < 1e-12);
}

#[test]
fn a_radar_that_never_spoke_is_waited_for_as_long_as_one_that_fell_silent() {
    let mut ladder = ladder();
    let none = Ages { radar_s: None, ..ages(0.0, 0.0, 0.0) };
    let mut level = |time_s: f64| {
        ladder.look(&none, time_s);
        ladder.level
    };
    assert_eq!(level(5.0), Level::LeadPredicted);
    assert_eq!(level(5.0 + RADAR_S + PREDICT_S - 1e-6), Level::LeadPredicted);
    assert_eq!(level(5.0 + RADAR_S + PREDICT_S + 1e-6), Level::LeadLost);
}

/// Levels after a failure, while all inputs are good again.
fn way_back(failed: &Ages) -> Vec<Level> {
    let mut ladder = ladder();
    ladder.look(failed, 0.0);
    let (odometry_s, radar_s, spat_s) = GOOD;
    let good = ages(odometry_s, radar_s, spat_s);
    let mut levels = vec![ladder.level];
    for k in 1..8 {
        ladder.look(&good, 0.1 * f64::from(k));
        levels.push(ladder.level);
    }
    levels
}

#[test]
fn each_recovery_is_proven_by_its_number_of_releases() {
    use Level::{Full, LeadLost, LeadPredicted, SignalsLost, Silent};
    let back = |level: Level, count: usize| {
        let mut levels = vec![level; 8];
        levels[count..].fill(Full);
        levels
    };
    // The release of the failure, and those before the last one of the proof.
    assert_eq!(way_back(&ages(9.0, 0.0, 0.0)), back(Silent, 2));
    assert_eq!(way_back(&ages(0.0, 1.0, 0.0)), back(LeadPredicted, 2));
    assert_eq!(way_back(&ages(0.0, 9.0, 0.0)), back(LeadLost, 5));
    assert_eq!(way_back(&ages(0.0, 0.0, 9.0)), back(SignalsLost, 3));
    // A relapse begins anew.
    let mut ladder = ladder();
    let levels = [0.0, 9.0, 0.0, 9.0, 0.0, 0.0].map(|odometry_s| {
        ladder.look(&ages(odometry_s, 0.0, 0.0), 0.0);
        ladder.level
    });
    assert_eq!(levels, [Full, Silent, Silent, Silent, Silent, Full]);
}

#[test]
fn a_lost_lead_is_found_by_fresh_samples_alone() {
    let mut ladder = ladder();
    let mut level = |radar_s: f64| {
        ladder.look(&ages(0.0, radar_s, 0.0), 0.0);
        ladder.level
    };
    assert_eq!(level(9.0), Level::LeadLost);
    // Samples that are not too old to predict from, but stale, prove nothing.
    assert!((0..10).all(|_| level(1.0) == Level::LeadLost));
    assert_eq!([0.0; 5].map(&mut level)[3..], [Level::LeadLost, Level::Full]);
}

fn input(time_s: f64, gap_m: Option<f64>) -> Input {
    Input {
        time_s,
        period_s: 0.1,
        ego: Ego { position_m: 20.0 * time_s, speed_mps: 20.0, acceleration_mps2: 0.0 },
        target: gap_m.map(|gap_m| Target { track_id: 1, gap_m, ..Target::default() }),
        set_speed_mps: 30.0,
        ..Input::default()
    }
}

fn scan(seen_share: f64, ids: &[u32]) -> RadarTracks {
    let mut scan =
        RadarTracks { seen_share, count: ids.len() as u64, ..bytemuck::Zeroable::zeroed() };
    for (track, id) in scan.tracks.iter_mut().zip(ids) {
        *track = Track { id: *id, in_path: 1, ..*track };
    }
    scan
}

/// One release: ages, target and scan; returns what the law is given.
fn release(
    ladder: &mut Ladder,
    time_s: f64,
    radar_s: f64,
    gap_m: Option<f64>,
    scan: &RadarTracks,
) -> (Admission, Input) {
    ladder.look(&ages(0.0, radar_s, 0.0), time_s);
    let mut input = input(time_s, gap_m);
    let admission = ladder.admit(&mut input, Some(scan));
    (admission, input)
}

#[test]
fn a_radar_that_sees_a_part_limits_the_speed_and_shows() {
    for (share, level, set_speed_mps) in [
        (1.0, Level::Full, 30.0),
        (0.5, Level::SensorLimited, 22.0),
        (0.1, Level::SensorLimited, 8.0),
    ] {
        let mut ladder = ladder();
        let (admission, input) = release(&mut ladder, 0.0, 0.0, None, &scan(share, &[]));
        assert_eq!((admission, ladder.level), (Admission::Law, level));
        assert_eq!(input.set_speed_mps, set_speed_mps);
        // Blind, the ego hardly accelerates and slows down.
        let mut output = Output::default();
        output.set_request(1.5);
        output.bound_from_above(ladder.most_mps2());
        let most_mps2 = if share < 0.3 { -0.25 } else { 1.5 };
        assert_eq!(output.request_mps2(), most_mps2, "{share}");
    }
}

#[test]
fn a_mild_level_gives_way_and_a_hard_one_does_not() {
    let limited = scan(0.5, &[]);
    let level = |ages: &Ages| {
        let mut ladder = ladder();
        ladder.look(ages, 0.0);
        ladder.admit(&mut input(0.0, None), Some(&limited));
        ladder.level
    };
    assert_eq!(level(&ages(0.0, 0.0, 9.0)), Level::SensorLimited);
    let estimated = Ages { ego_is_estimated: true, ..ages(0.0, 0.0, 0.0) };
    assert_eq!(level(&estimated), Level::SensorLimited);
    assert_eq!(level(&ages(0.0, 1.0, 0.0)), Level::LeadPredicted);
    assert_eq!(level(&ages(0.0, 9.0, 0.0)), Level::LeadLost);
    assert_eq!(level(&ages(9.0, 0.0, 0.0)), Level::Silent);
}

#[test]
fn a_lead_that_is_missing_in_a_fresh_scan_is_assumed_to_be_there() {
    let mut ladder = ladder();
    for k in 0..20 {
        release(&mut ladder, 0.1 * f64::from(k), 0.0, Some(30.0), &scan(1.0, &[1]));
    }
    let (admission, given) = release(&mut ladder, 2.0, 0.0, None, &scan(1.0, &[]));
    assert_eq!((admission, ladder.level), (Admission::Law, Level::LeadPredicted));
    let target = given.target.expect("it is assumed");
    assert!((target.gap_m - 30.0).abs() < 1e-9, "it keeps its speed: {target:?}");
    assert_eq!(given.set_speed_mps, 20.0, "no faster than when it was lost");
    let mut output = Output::default();
    output.set_request(1.0);
    output.bound_from_above(ladder.most_mps2());
    assert_eq!(output.request_mps2(), 0.0);
}

#[test]
fn a_silent_radar_is_predicted_from_and_then_braked_for() {
    let mut ladder = ladder();
    for k in 0..20 {
        release(&mut ladder, 0.1 * f64::from(k), 0.0, Some(30.0), &scan(1.0, &[1]));
    }
    let seen_s = 1.9;
    let mut after = |age_s: f64| {
        let (admission, given) = release(&mut ladder, seen_s + age_s, age_s, None, &scan(1.0, &[]));
        (admission, given.target.map(|target| (target.gap_m, target.age_s)))
    };
    // The lead keeps the ego's speed of then, 20 m/s, as the ego does.
    for age_s in [0.5, 1.0, RADAR_S + PREDICT_S - 1e-6] {
        let (admission, target) = after(age_s);
        let (gap_m, old_s) = target.expect("it is predicted");
        assert_eq!(admission, Admission::Law);
        assert!((gap_m - 30.0).abs() < 1e-6 && (old_s - age_s).abs() < 1e-9, "{gap_m} {old_s}");
    }
    assert_eq!(after(RADAR_S + PREDICT_S + 1e-6).0, Admission::Brake);
}

#[test]
fn radar_that_came_while_the_ego_was_unknown_is_of_no_use() {
    let mut ladder = ladder();
    release(&mut ladder, 0.0, 0.0, Some(30.0), &scan(1.0, &[1]));
    let mut at = |time_s: f64, odometry_s: f64, radar_s: f64| {
        ladder.look(&ages(odometry_s, radar_s, 0.0), time_s);
        (ladder.admit(&mut input(time_s, None), None), ladder.level)
    };
    // The ego is unknown for 3 s: the first release brakes, the others are silent.
    assert_eq!(at(0.1, 9.0, 0.0), (Admission::Brake, Level::Silent));
    assert!(
        (2..30).all(|k| at(0.1 * f64::from(k), 9.0, 0.0) == (Admission::Silence, Level::Silent))
    );
    // It is known again, and radar has fallen silent for less than it is predicted for.
    assert_eq!(at(3.0, 0.0, 0.5).0, Admission::Silence);
    assert_eq!(at(3.1, 0.0, 0.6), (Admission::Brake, Level::LeadLost));
    let back = [3.2, 3.3, 3.4, 3.5, 3.6].map(|time_s| at(time_s, 0.0, 0.0).1);
    assert_eq!(back[3..], [Level::LeadLost, Level::Full]);
}

#[test]
fn an_ego_that_stands_close_behind_a_vehicle_waits() {
    let mut ladder = ladder();
    ladder.look(&ages(0.0, 0.0, 0.0), 0.0);
    let mut standing = input(0.0, Some(5.0));
    standing.ego.speed_mps = 0.0;
    ladder.admit(&mut standing, Some(&scan(1.0, &[1])));
    let mut output = Output::default();
    output.set_request(1.0);
    output.bound_from_above(ladder.most_mps2());
    assert_eq!(output.request_mps2(), 0.0);
}

#[test]
fn a_law_that_fails_or_is_late_shows_until_three_cycles_in_order() {
    let backup = Output { quality: Quality::Backup, ..Output::default() };
    for (output, in_time) in [(backup, true), (Output::default(), false)] {
        let mut ladder = ladder();
        let mut settle = |output: &Output, in_time: bool| {
            ladder.look(&ages(0.0, 0.0, 0.0), 0.0);
            ladder.settle(output, in_time)
        };
        assert_eq!(settle(&Output::default(), true), Level::Full);
        assert_eq!(settle(&output, in_time), Level::SolveFailed);
        let good = [(); 3].map(|()| settle(&Output::default(), true));
        assert_eq!(good, [Level::SolveFailed, Level::SolveFailed, Level::Full]);
    }
}

#[test]
fn a_laws_figures_give_way_to_those_of_its_inputs() {
    let settled = |ages: &Ages, quality: Quality| {
        let mut ladder = ladder();
        ladder.look(ages, 0.0);
        ladder.settle(&Output { quality, ..Output::default() }, true)
    };
    let (good, no_signals, no_radar) =
        (ages(0.0, 0.0, 0.0), ages(0.0, 0.0, 9.0), ages(0.0, 1.0, 0.0));
    assert_eq!(settled(&good, Quality::Relaxed), Level::Full);
    assert_eq!(settled(&no_signals, Quality::Backup), Level::SolveFailed);
    assert_eq!(settled(&no_radar, Quality::Backup), Level::LeadPredicted);
    assert_eq!(settled(&good, Quality::FallBack), Level::OutsideEnvelope);
    assert_eq!(settled(&no_signals, Quality::FallBack), Level::OutsideEnvelope);
    assert_eq!(settled(&no_radar, Quality::FallBack), Level::LeadPredicted);
    let estimated = Ages { ego_is_estimated: true, ..good };
    assert_eq!(settled(&estimated, Quality::FallBack), Level::EgoEstimated);
}

#[test]
fn braking_blind_stays_within_the_laws_bounds_and_goes_on_as_hard_as_before() {
    let plan = |last_mps2: f64, least_mps2: f64, speed_mps: f64| {
        let mut ladder = ladder();
        release(&mut ladder, 0.0, 0.0, Some(10.0), &scan(1.0, &[1]));
        let mut output = Output { mode: 5, ..Output::default() };
        output.set_request(last_mps2);
        ladder.settle(&output, true);
        let ego = Ego { position_m: 0.0, speed_mps, acceleration_mps2: 0.0 };
        ladder.brake(&ego, 0.1, (least_mps2, 2.0), &mut output);
        assert_eq!((output.quality, output.mode, output.plan_len), (Quality::Backup, 5, MAX_PLAN));
        (output.plan_mps2[0], output.plan_mps2[MAX_PLAN - 1])
    };
    // 10 m behind a lead of 20 m/s: a minimum risk manoeuvre, with 5 m/s³ from the last request on.
    assert_eq!(plan(0.0, -6.0, 20.0), (-0.5, -4.0));
    assert_eq!(plan(1.5, -6.0, 20.0), (-0.5, -4.0), "it begins at 0");
    assert_eq!(plan(-3.0, -6.0, 20.0), (-3.5, -4.0));
    assert_eq!(plan(-5.0, -6.0, 20.0), (-5.0, -5.0));
    assert_eq!(plan(-7.0, -6.0, 20.0), (-6.0, -6.0));
    assert_eq!(plan(0.0, -3.0, 20.0), (-0.5, -3.0));
}
