//! One track, with the numbers that follow by hand.

use super::super::association::Point;
use super::super::association::tests::point;
use super::super::longitudinal::Maneuver;
use super::*;
use crate::radar::scene::Ego;

const NUMBERS: Numbers = Numbers::DEFAULT;
const LIFE: Life = Life { hits: 3, scans: 4, coast_s: 0.5 };
/// A view of 0.5 rad to either side, less its margin of 0.05 rad.
const VIEW: FieldOfView = FieldOfView { half_rad: 0.5, resolution_rad: 0.01, edge_rad: 0.05 };

fn model() -> Model {
    Model::new(Maneuver { sigma_mps2: 1.0, tau_s: 2.0 }, 4.0, &NUMBERS)
}

fn step(dt_s: f64) -> Step {
    Step { dt_s, ego: Ego { speed_mps: 20.0, ..Ego::default() } }
}

fn sighting(points: &[Point]) -> Sighting {
    Sighting::of(points.iter(), 0.0, &NUMBERS).expect("points")
}

/// A new track of one echo.
fn track(gap_m: f64, lateral_m: f64, relative_mps: f64) -> DetectedTrack {
    DetectedTrack::begin(&model(), &sighting(&[point(gap_m, lateral_m, relative_mps)]), true)
}

/// A confirmed track in the path that the last 32 scans have shown.
fn firm(gap_m: f64, relative_mps: f64) -> DetectedTrack {
    let limits = super::super::path::PathLimits::new(
        &scenario::perception::TargetSelection::default(),
        true,
        &NUMBERS,
    );
    let mut track =
        DetectedTrack { id: 1, history: u32::MAX, age: 32, ..track(gap_m, 0.0, relative_mps) };
    limits.observe(&mut track.membership, &Across::resting(0.0), 0.0);
    assert!(track.membership.in_path());
    track
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
}

#[test]
fn the_view_shows_what_is_ahead_and_the_margin_inside() {
    let shows = |x_m: f64, rad: f64| VIEW.shows(x_m, x_m * libm::tan(rad));
    assert!(shows(20.0, 0.0) && shows(20.0, 0.449) && shows(20.0, -0.449));
    assert!(!shows(20.0, 0.451) && !shows(20.0, -0.451));
    assert!(shows(1.01, 0.0) && !shows(1.0, 0.0) && !shows(-20.0, 0.0));
}

#[test]
fn more_scans_are_asked_where_fewer_show_a_vehicle() {
    let scans = |share: f64| LIFE.with_sight(share).scans;
    assert_eq!(
        [1.0, 0.7, 0.69, 0.5, 0.3, 0.125, 0.1, 0.0].map(scans),
        [4, 4, 6, 8, 13, 32, 32, 32]
    );
    assert_eq!(Life { scans: 20, ..LIFE }.with_sight(0.01).scans, 32);
    assert_eq!((LIFE.with_sight(0.5).hits, LIFE.with_sight(0.5).coast_s), (3, 0.5));
}

#[test]
fn a_confirmation_takes_its_hits_and_twice_as_many_of_what_never_moved() {
    let deserves = |history: u32, moved: bool| {
        DetectedTrack { history, moved, ..track(40.0, 0.0, 0.0) }.deserves_confirmation(&LIFE)
    };
    assert!(deserves(0b1101, true) && !deserves(0b1001, true));
    assert!(!deserves(0b1_0101, true), "the fifth scan is too old");
    assert!(deserves(0b1101_1101, false) && !deserves(0b1101_1001, false));
    assert!(!deserves(0b1101, false) && !deserves(0b1_1100_1101, false));
}

#[test]
fn a_new_track_is_over_when_it_can_have_its_hits_no_more() {
    let is_over = |age: u32, history: u32, moved: bool| {
        DetectedTrack { age, history, moved, ..track(40.0, 0.0, 0.0) }.is_over(&LIFE, &NUMBERS)
    };
    // Three of four scans: one may miss.
    assert!(!is_over(1, 0b1, true) && !is_over(2, 0b10, true) && is_over(3, 0b100, true));
    assert!(!is_over(20, 0b0111, true) && is_over(20, 0b1010, true));
    // Six of eight.
    assert!(!is_over(3, 0b100, false) && is_over(4, 0b1000, false));
    assert!(!is_over(20, 0b0011_1111, false) && is_over(20, 0b0101_1101, false));
}

#[test]
fn a_confirmed_track_is_over_when_it_is_unseen_too_long_or_seen_rarely() {
    let is_over = |unseen_s: f64, age: u32, history: u32| {
        DetectedTrack { id: 1, unseen_s, age, history, ..track(40.0, 0.0, 0.0) }
            .is_over(&LIFE, &NUMBERS)
    };
    assert!(!is_over(0.5, 10, 1) && is_over(0.51, 10, 1));
    // Six hits of the last 32 scans.
    assert!(
        !is_over(0.0, 32, 0b11_1111) && is_over(0.0, 32, 0b1_1111) && !is_over(0.0, 31, 0b1_1111)
    );
    // A track lost in the path goes on for 2.5 s.
    let is_over = |unseen_s: f64, coast_s: f64| {
        DetectedTrack { unseen_s, ..firm(40.0, 0.0) }.is_over(&Life { coast_s, ..LIFE }, &NUMBERS)
    };
    assert!(!is_over(2.5, 0.5) && is_over(2.51, 0.5));
    assert!(!is_over(2.51, 3.0) && is_over(3.01, 3.0));
}

#[test]
fn a_scan_moves_a_track_on_and_ages_it() {
    let (model, mut track) = (model(), track(40.0, 1.0, -2.0));
    let step = step(0.05);
    assert!(track.is_seen());
    track.predict(&model, &step);
    assert_near(track.along.estimate().gap_m, 39.9);
    assert_near(track.unseen_s, 0.05);
    assert_eq!((track.is_seen(), track.history, track.age), (false, 0b10, 2));
    (0..40).for_each(|_| track.predict(&model, &step));
    assert_eq!(track.age, 32);
    assert_near(track.unseen_s, 41.0 * 0.05);
}

#[test]
fn a_firm_track_that_is_unseen_in_the_path_is_lost_after_two_missed_scans() {
    let is_lost =
        |track: DetectedTrack, unseen_s: f64| DetectedTrack { unseen_s, ..track }.is_lost(&NUMBERS);
    let firm = firm(40.0, -3.0);
    assert!(!is_lost(firm, 0.10) && !is_lost(firm, 0.12) && is_lost(firm, 0.13));
    assert!(!is_lost(DetectedTrack { age: 31, ..firm }, 0.13));
    assert!(!is_lost(DetectedTrack { id: 0, ..firm }, 0.13));
    assert!(!is_lost(DetectedTrack { membership: Membership::default(), ..firm }, 0.13));
}

#[test]
fn a_braking_lead_that_is_lost_brakes_on() {
    let model = model();
    let step = step(0.05);
    let mut track = firm(40.0, 0.0);
    track.predict(&model, &step);
    track.see(&model, &sighting(&[point(40.0, 0.0, -0.3)]), (&VIEW, &Course::STRAIGHT));
    (0..3).for_each(|_| track.predict(&model, &step));
    let braking_mps2 = track.along.estimate().acceleration_mps2;
    (0..20).for_each(|_| track.predict(&model, &step));
    assert!(braking_mps2 < -0.01);
    assert_near(track.along.estimate().acceleration_mps2, braking_mps2);
}

#[test]
fn a_new_track_has_moved_while_all_its_echoes_do_and_an_old_one_once_it_did() {
    let moved = |id: u32, before: bool, ground_mps: f64| {
        let mut track = DetectedTrack { id, moved: before, ..track(40.0, 0.0, 0.0) };
        track.observe_motion(ground_mps, &NUMBERS);
        track.moved
    };
    assert!(moved(0, true, 0.51) && !moved(0, true, 0.5) && !moved(0, false, 9.0));
    assert!(moved(1, false, 1.01) && !moved(1, false, 1.0) && moved(1, true, 0.0));
}

#[test]
fn what_never_moved_has_stood_until_it_is_confirmed() {
    let has_stood =
        |id: u32, moved: bool| DetectedTrack { id, moved, ..track(40.0, 2.5, 0.0) }.has_stood();
    assert!(has_stood(0, false) && !has_stood(1, false) && !has_stood(0, true));
    assert_eq!(track(40.0, 2.5, 0.0).place(), (40.0, 2.5));
}

#[test]
fn it_grows_by_a_tenth_of_what_is_beyond_its_size() {
    let grown = |depth_m: f64, width_m: f64, before: (f64, f64)| {
        let mut track = track(40.0, 0.0, 0.0);
        (track.length_m, track.width_m) = before;
        let half_m = 0.5 * width_m;
        let points =
            [point(40.0, half_m, 0.0), point(40.0, -half_m, 0.0), point(40.0 + depth_m, 0.0, 0.0)];
        track.extend(&sighting(&points), 40.0, &NUMBERS);
        (track.length_m, track.width_m)
    };
    let assert_grown = |found: (f64, f64), length_m: f64, width_m: f64| {
        assert_near(found.0, length_m);
        assert_near(found.1, width_m);
    };
    assert_grown(grown(6.5, 2.0, (4.5, 1.8)), 4.7, 1.82);
    assert_grown(grown(4.0, 1.6, (4.5, 1.8)), 4.5, 1.8);
    assert_grown(grown(60.0, 4.6, (23.0, 2.5)), 25.0, 2.6);
}

#[test]
fn the_older_track_takes_over_the_motion_that_is_nearer_to_the_rear() {
    let (model, step) = (model(), step(0.05));
    let older = || DetectedTrack { misfits: 2, nearest: 3, ..track(40.0, 0.0, 0.0) };
    let younger = |gap_m: f64| DetectedTrack { nearest: 8, ..track(gap_m, 0.0, -1.0) };
    let mut nearer = older();
    nearer.take_over(&younger(38.0), &NUMBERS);
    assert_eq!((nearer.along, nearer.misfits, nearer.nearest), (younger(38.0).along, 0, 8));
    assert_near(nearer.length_m, 6.5);
    let mut beside = older();
    beside.take_over(&younger(39.3), &NUMBERS);
    assert_eq!((beside.along, beside.misfits, beside.nearest), (older().along, 2, 8));
    assert_near(beside.length_m, 4.5);
    let mut long = DetectedTrack { length_m: 24.0, ..older() };
    long.take_over(&younger(38.0), &NUMBERS);
    assert_near(long.length_m, 25.0);
    // An unseen one takes the motion wherever it is, and is seen then.
    let mut unseen = older();
    unseen.predict(&model, &step);
    unseen.take_over(&younger(41.0), &NUMBERS);
    assert_eq!((unseen.along, unseen.unseen_s, unseen.history), (younger(41.0).along, 0.0, 0b11));
    assert_near(unseen.length_m, 4.5);
    // From a younger one that is not seen it takes no sight.
    let mut both = older();
    both.predict(&model, &step);
    let mut missed = younger(41.0);
    missed.predict(&model, &step);
    both.take_over(&missed, &NUMBERS);
    assert_eq!((both.unseen_s, both.nearest, both.is_seen()), (0.05, 3, false));
}
