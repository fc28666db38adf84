use super::*;

fn limits() -> PathLimits {
    PathLimits::new(&TargetSelection::default(), false, &Numbers::DEFAULT)
}

fn history(laterals: &[f64]) -> Vec<bool> {
    let (limits, mut membership) = (limits(), Membership::default());
    laterals
        .iter()
        .map(|&lateral_m| {
            limits.observe(&mut membership, &Across::resting(lateral_m), 0.05);
            membership.in_path()
        })
        .collect()
}

#[test]
fn a_cut_in_is_a_target_when_it_is_confirmed() {
    assert_eq!(history(&[3.0, 2.0, 1.7, 1.6, 1.5, 1.0]), [false, false, false, false, true, true]);
}

#[test]
fn one_noisy_scan_makes_no_target() {
    assert_eq!(history(&[1.9, 1.5, 1.9, -1.5, 1.9]), [false; 5]);
}

#[test]
fn a_cut_out_ends_at_the_wider_limit() {
    assert_eq!(history(&[0.0, 0.0, 1.9, -2.2, 2.3, 1.9]), [false, true, true, true, false, false]);
}

#[test]
fn a_cut_in_is_recognised_before_the_bodies_overlap() {
    let within = |across: &Across| {
        let mut membership = Membership::default();
        for _ in 0..2 {
            limits().observe(&mut membership, across, 0.05);
        }
        membership.in_path()
    };
    let moving = |lateral_m, speed_mps| Across {
        speed_mps,
        speed_sigma_mps: 0.1,
        ..Across::resting(lateral_m)
    };
    assert!(within(&moving(2.7, -1.0)) && within(&moving(-2.7, 1.0)));
    assert!(!within(&moving(3.1, -1.0)), "that is more than 1.2 s ahead");
    assert!(!within(&moving(2.7, 1.0)) && !within(&moving(-2.7, -1.0)), "it moves away");
    assert!(!within(&moving(2.0, -0.25)), "it wanders in its lane");
    let vague = Across { speed_sigma_mps: 0.6, ..moving(2.7, -1.0) };
    assert!(!within(&vague), "the motion is not certain");
    let on_course = |speed_mps: f64| moving(2.7, speed_mps).on_course(0.1, 0.24);
    assert!(within(&on_course(-1.2)) && !within(&on_course(-1.0)), "the course is not certain");
}

#[test]
fn threats_that_braking_does_not_avoid_stay_out() {
    let within = |gap_m: f64, relative_speed_mps: f64, lateral_m: f64| {
        let approach = Approach { gap_m, relative_speed_mps };
        let across = Across {
            lateral_m,
            speed_mps: -1.0,
            speed_sigma_mps: 0.1,
            in_way: None,
            drives: true,
            has_moved: true,
            approach,
        };
        let mut membership = Membership::default();
        for _ in 0..2 {
            limits().observe(&mut membership, &across, 0.05);
        }
        membership.in_path()
    };
    // 0.9 m to the side take 0.9 s, in which the cruise control wins 0.4 m.
    assert!(!within(-1.0, -10.0, 2.7), "it is passed by then");
    assert!(!within(8.4, -10.0, 2.7), "the ego is beside it by then");
    assert!(within(8.8, -10.0, 2.7), "the ego stays behind it if it brakes");
    assert!(within(-1.0, -10.0, 1.5), "it is in the way already");
    assert!(within(1.0, 0.5, 2.7), "it goes away");
}

#[test]
fn prices_decide_where_the_path_is_doubtful() {
    // 20 m/s towards what stands: 2.5 m/s² at 80 m, 5 m/s² at 40 m.
    let of = |gap_m: f64, probability: f64, has_moved: bool| {
        let approach = Approach { gap_m, relative_speed_mps: -20.0 };
        let in_way = Some(probability);
        limits().within(&Across { in_way, approach, has_moved, ..Across::resting(0.0) })
    };
    let within = |gap_m: f64, probability: f64| of(gap_m, probability, true);
    assert_eq!(within(80.0, 0.81), (true, true));
    assert_eq!(within(80.0, 0.79), (false, true), "braking for nothing is four times as bad");
    assert_eq!(within(80.0, 0.19), (false, false));
    assert_eq!(within(40.0, 0.51), (true, true), "as bad as braking with 5 m/s²");
    assert_eq!((within(40.0, 0.49), within(40.0, 0.12)), ((false, true), (false, false)));
    // 6 m/s² at 33.3 m; no law brakes harder.
    assert_eq!((within(33.3, 0.42), within(33.3, 0.40)), ((true, true), (false, true)));
    assert_eq!(
        (within(1.0, 0.40), within(1.0, 0.10)),
        ((false, true), (false, false)),
        "beside it"
    );
    // The law eases off for a track that has never moved, at a quarter of the price.
    assert_eq!((of(80.0, 0.51, false), of(80.0, 0.49, false)), ((true, true), (false, true)));
    // A lead that goes along needs no braking.
    let in_way = Some(0.81);
    let lead = Across { in_way, ..Across::resting(3.5) };
    assert_eq!(limits().within(&lead), (true, true), "the probability alone decides");
}

#[test]
fn what_stands_has_a_doubt_and_what_has_moved_has_none() {
    let doubt_share = |in_way: Option<f64>, has_moved: bool| {
        let mut membership = Membership::default();
        let across = Across { in_way, has_moved, ..Across::resting(0.0) };
        limits().observe(&mut membership, &across, 0.05);
        membership.doubt_share
    };
    assert!((doubt_share(Some(0.7), false) - 0.3).abs() < 1e-12);
    assert_eq!(doubt_share(Some(0.7), true), 0.0);
    assert_eq!(doubt_share(None, false), 0.0, "without a belief nothing is doubtful");
}

#[test]
fn an_estimated_path_is_left_after_a_time() {
    let limits = limits();
    let mut membership = Membership { in_path: true, ..Membership::default() };
    let mut scans_in_path = |in_way: f64, scans: u32| {
        let across = Across::resting(0.0).on_course(in_way, 0.0);
        (0..scans)
            .filter(|_| {
                limits.observe(&mut membership, &across, 0.05);
                membership.in_path()
            })
            .count()
    };
    assert_eq!(scans_in_path(0.1, 9), 9, "it may come back");
    assert_eq!(scans_in_path(0.3, 1), 1);
    let stays = scans_in_path(0.1, 20);
    assert!((9..=10).contains(&stays), "{stays} scans");
}

#[test]
fn exact_tracks_count_at_once() {
    let exact = PathLimits::new(&TargetSelection::default(), true, &Numbers::DEFAULT);
    let mut membership = Membership::default();
    exact.observe(&mut membership, &Across::resting(1.0), 0.0);
    assert!(membership.in_path());
}

#[test]
fn an_approach_ends_beside_the_track() {
    let approach = Approach { gap_m: 10.0, relative_speed_mps: -10.0 };
    let beside = |gap_m: f64, time_s: f64| {
        Approach { gap_m, ..approach }.is_beside_in(time_s, &Numbers::DEFAULT)
    };
    // From 0.5 s on the ego brakes with 5 m/s²: it gains 2.5 m in a second.
    assert!(beside(12.4, 1.5) && !beside(12.6, 1.5));
    assert!(beside(3.9, 0.4) && !beside(4.1, 0.4));
}

#[test]
fn a_heading_that_is_not_known_makes_a_lateral_speed_uncertain() {
    let across = Across { speed_sigma_mps: 0.3, ..Across::resting(1.0) };
    let on_course = across.on_course(0.7, 0.4);
    assert!((on_course.speed_sigma_mps - 0.5).abs() < 1e-12 && on_course.in_way == Some(0.7));
}

/// In the path for its motion: it goes on at half of the speed, and for twice the time.
#[test]
fn an_object_that_moves_in_still_comes_if_more_slowly() {
    let comes = |lateral_m: f64, speed_mps: f64| {
        let across = Across { speed_mps, ..Across::resting(lateral_m) };
        limits().comes(&across, 0.15, 2.0 * limits().predict_s)
    };
    // 1.8 m, the bodies' width, and 2.4 s.
    assert!(comes(2.3, -0.25) && !comes(2.5, -0.25) && comes(-2.3, 0.25) && !comes(-2.5, 0.25));
    assert!(comes(1.9, -0.16) && !comes(1.9, -0.14) && !comes(2.3, 0.25));
}
