use super::*;
use crate::law::{Ego, Target};
use proptest::prelude::*;
use scenario::sumo_traffic::Limit;

const PERIOD_S: f64 = 0.1;
/// Cells of the map, m.
const CELL_M: f64 = 25.0;
/// Time constant and jerk of a driver who follows the set speed.
const FOLLOWS_S: f64 = 1.0;
const JERK_MPS3: f64 = 2.0;

fn input(time_s: f64, speed_mps: f64, set_speed_mps: f64) -> Input {
    let ego = Ego { speed_mps, ..Ego::default() };
    let speed_limit_mps = f64::INFINITY;
    Input { time_s, period_s: PERIOD_S, ego, set_speed_mps, speed_limit_mps, ..Input::default() }
}

fn own(radius_m: f64) -> RoadAhead<'static> {
    RoadAhead { own_perm: Some(1.0 / radius_m), ..RoadAhead::default() }
}

#[test]
fn the_comfortable_speed_is_that_of_the_standard_s_radii() {
    let comfort = Comfort::default();
    for (radius_m, speed_mps) in [(500.0, 31.7), (250.0, 23.3), (125.0, 16.96)] {
        let found = comfortable_mps(&comfort, -1.0 / radius_m);
        assert!((found - speed_mps).abs() < 0.05, "{radius_m}: {found}");
    }
    // Both ends, and no step between.
    let lateral = |k: f64| k * comfortable_mps(&comfort, k) * comfortable_mps(&comfort, k);
    assert!((lateral(0.05) - 2.3).abs() < 1e-9 && (lateral(1e-4) - 2.0).abs() < 1e-9);
    let mut before = f64::INFINITY;
    for k in 1..1000 {
        let speed_mps = comfortable_mps(&comfort, 2e-5 * f64::from(k));
        assert!(speed_mps < before, "{k}");
        before = speed_mps;
    }
}

#[test]
fn an_ego_that_is_too_fast_comes_down_with_the_braking_that_the_curve_needs() {
    let profile = |from_m: f64| {
        let mut curvatures_perm = [0.0; 40];
        curvatures_perm[(from_m / CELL_M) as usize..][..8].fill(1.0 / 125.0);
        let map = Cells { first_m: 0.0, cell_m: CELL_M, curvatures_perm: &curvatures_perm };
        let road = RoadAhead { map: Some(map), ..RoadAhead::default() };
        let mut input = input(0.0, 25.0, 36.0);
        CurveSpeed::new(&Keys::default()).cap(&mut input, &road, 0.0);
        input.profile.expect("there is a plan")
    };
    // 17 m/s from 12.5 m before the first cell on. From 25 m/s it takes 168 m with 1 m/s².
    let far = profile(300.0);
    assert!((far.at_mps(300.0) - 16.96).abs() < 0.01 && far.at_mps(0.0) > 28.0);
    let near = profile(100.0);
    let fall = (near.at_mps(20.0).powi(2) - near.at_mps(70.0).powi(2)) / 100.0;
    assert!((2.1..2.4).contains(&fall), "{fall}");
    assert_eq!(near.at_mps(330.0), 36.0, "free behind the curve");
}

#[test]
fn a_speed_limit_is_met_where_it_begins_by_a_law_that_follows_late() {
    let limits = [(0.0, 25.0), (300.0, 8.0), (330.0, 14.0)];
    let limits = limits.map(|(from_m, speed_mps)| Limit { from_m, speed_mps });
    let mut curve = CurveSpeed::new(&Keys::default());
    let (mut place_m, mut speed_mps, mut hardest_mps2) = (0.0, 25.0, 0.0_f64);
    for k in 0..400 {
        let mut input = input(PERIOD_S * f64::from(k), speed_mps, 36.0);
        let road = RoadAhead { limits: &limits, place_m, ..RoadAhead::default() };
        curve.cap(&mut input, &road, hardest_mps2.min(0.0));
        let request = ((input.set_speed_mps - speed_mps) / 8.0).min(curve.most_mps2);
        hardest_mps2 = hardest_mps2.min(request);
        place_m += PERIOD_S * speed_mps;
        speed_mps += PERIOD_S * request;
        let limit = limits.iter().rfind(|limit| limit.from_m <= place_m).expect("from 0 m on");
        assert!(speed_mps < limit.speed_mps + 0.3, "{speed_mps} m/s at {place_m} m");
    }
    assert!(place_m > 330.0 && speed_mps > 8.0, "{speed_mps} m/s at {place_m} m");
    assert!(hardest_mps2 > -1.3, "{hardest_mps2}");
}

#[test]
fn a_slower_ego_is_not_slowed_down_further() {
    let mut curve = CurveSpeed::new(&Keys::default());
    for k in 0..200 {
        let mut input = input(0.1 * f64::from(k), 10.0, 36.0);
        curve.cap(&mut input, &own(125.0), 0.0);
        assert!((input.set_speed_mps - 16.96).abs() < 0.01, "{k}: {}", input.set_speed_mps);
    }
}

#[test]
fn a_target_lost_in_a_curve_holds_the_speed_for_two_seconds() {
    let target = Target { gap_m: 40.0, ..Target::default() };
    let caps = |road: RoadAhead<'_>, found_again: bool| {
        let mut curve = CurveSpeed::new(&Keys::default());
        let mut caps = Vec::new();
        for k in 0..40 {
            let time_s = 0.1 * f64::from(k);
            let mut input = input(time_s, 15.0, 36.0);
            let is_there = k < 5 || (found_again && k >= 10);
            input.target = is_there.then_some(target);
            curve.cap(&mut input, &road, 0.0);
            caps.push(input.set_speed_mps);
        }
        caps
    };
    let lost = caps(own(1000.0), false);
    assert!(lost[4] == 36.0 && lost[5] < 15.01 && (lost[20] - 15.0).abs() < 1e-9, "{lost:?}");
    assert_eq!((lost[24], lost[36]), (15.0, 36.0));
    assert_eq!(caps(own(1000.0), true)[21], 36.0, "it is there again");
    assert!(caps(own(1e5), false).iter().all(|cap_mps| *cap_mps == 36.0), "no curve");
    // The bend is where the target was, and not at the ego.
    let curvatures_perm = [0.0, 1e-3];
    let map = Cells { first_m: 0.0, cell_m: 25.0, curvatures_perm: &curvatures_perm };
    let ahead = RoadAhead { map: Some(map), ..RoadAhead::default() };
    assert!(caps(ahead, false)[20] < 15.01);
}

#[test]
fn the_acceleration_is_bounded_in_a_curve_alone() {
    let bound = |radius_m: f64, speed_mps: f64| {
        let mut curve = CurveSpeed::new(&Keys::default());
        for k in 0..100 {
            let mut input = input(0.1 * f64::from(k), speed_mps, 36.0);
            curve.cap(&mut input, &own(radius_m), 1.5);
        }
        curve.most_mps2
    };
    assert!(bound(250.0, 20.0) > 1.0, "23 m/s is allowed");
    assert!((-0.5..0.0).contains(&bound(175.0, 20.0)), "a little too fast");
    assert_eq!(bound(100.0, 20.0), -HARDEST_MPS2, "it came too late");
    assert_eq!(bound(1000.0, 20.0), FREE_MPS2);
}

#[test]
fn the_bound_moves_with_the_jerk_of_the_standard() {
    let mut curve = CurveSpeed::new(&Keys::default());
    let mut before = 1.5;
    for k in 0..60 {
        let radius_m = if k < 30 { 100.0 } else { 1e6 };
        let mut input = input(0.1 * f64::from(k), 20.0, 36.0);
        curve.cap(&mut input, &own(radius_m), before);
        let now = curve.most_mps2.min(1.5);
        assert!((now - before).abs() < 0.25 + 1e-9, "{k}: {before} {now}");
        before = now;
    }
    assert_eq!(before, 1.5);
}

/// A road of arcs and straights with clothoids between; its curvature at a place.
struct Arcs(Vec<(f64, f64)>);

impl Arcs {
    /// Nodes (place, curvature), linear between.
    fn new(bends: &[(f64, f64, f64, f64)]) -> Self {
        // From 42 m/s to 17 m/s with 1 m/s² it takes 738 m.
        let mut nodes = vec![(0.0, 0.0), (900.0, 0.0)];
        let mut place_m = 900.0;
        for (curvature_perm, spiral_m, arc_m, line_m) in bends {
            for (length_m, to_perm) in [
                (*spiral_m, *curvature_perm),
                (*arc_m, *curvature_perm),
                (*spiral_m, 0.0),
                (*line_m, 0.0),
            ] {
                place_m += length_m;
                nodes.push((place_m, to_perm));
            }
        }
        Self(nodes)
    }

    fn at(&self, place_m: f64) -> f64 {
        let next = self.0.partition_point(|node| node.0 <= place_m).clamp(1, self.0.len() - 1);
        let ((a_m, a), (b_m, b)) = (self.0[next - 1], self.0[next]);
        a + (b - a) * ((place_m - a_m) / (b_m - a_m)).clamp(0.0, 1.0)
    }

    /// Means of all cells of the road's map, which is `shift_m` too far ahead.
    fn cells(&self, shift_m: f64) -> Vec<f64> {
        let count = (self.0[self.0.len() - 1].0 / CELL_M) as u32 + 90;
        let mean = |cell: u32| {
            let begin_m = CELL_M * f64::from(cell) - shift_m;
            let inside = (0..10).map(|k| begin_m + CELL_M * (f64::from(k) + 0.5) / 10.0);
            inside.map(|place_m| self.at(place_m)).sum::<f64>() / 10.0
        };
        (0..count).map(mean).collect()
    }
}

/// Knowledge of the controller in a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Knows {
    Map(f64),
    OwnWay,
}

/// Largest lateral acceleration, jerk and braking of a drive.
struct Most {
    lateral_mps2: f64,
    jerk_mps3: f64,
    braking_mps2: f64,
}

/// A drive along a road. Its driver follows the set speed with a lag of `follows_s`.
fn drive(road: &Arcs, set_mps: f64, follows_s: f64, knows: Knows) -> Most {
    let mut curve = CurveSpeed::new(&Keys::default());
    let (mut place_m, mut speed_mps, mut request) = (0.0, set_mps, 0.0_f64);
    let (mut lateral, mut jerk, mut braking) = (0.0_f64, 0.0_f64, 0.0_f64);
    let end_m = road.0[road.0.len() - 1].0;
    let cells = match knows {
        Knows::Map(shift_m) => road.cells(shift_m),
        Knows::OwnWay => Vec::new(),
    };
    let mut cycle = 0;
    while place_m < end_m {
        let mut input = input(PERIOD_S * f64::from(cycle), speed_mps, set_mps);
        cycle += 1;
        let first = (place_m / CELL_M) as usize;
        let map = (knows != Knows::OwnWay).then(|| Cells {
            first_m: CELL_M * first as f64 - place_m,
            cell_m: CELL_M,
            curvatures_perm: &cells[first..first + 80],
        });
        let own_perm = Some(road.at(place_m));
        let ahead = RoadAhead { own_perm, map, ..RoadAhead::default() };
        curve.cap(&mut input, &ahead, request);
        let wanted = ((input.set_speed_mps - speed_mps) / follows_s).clamp(-3.0, 1.5);
        let most = JERK_MPS3 * PERIOD_S;
        let free = request + (wanted - request).clamp(-most, most);
        let before = request;
        request = if curve.most_mps2 < FREE_MPS2 { free.min(curve.most_mps2) } else { free };
        jerk = jerk.max((request - before).abs() / PERIOD_S);
        place_m += speed_mps * PERIOD_S + 0.5 * request * PERIOD_S * PERIOD_S;
        speed_mps = (speed_mps + request * PERIOD_S).max(0.0);
        lateral = lateral.max(speed_mps * speed_mps * road.at(place_m).abs());
        braking = braking.max(-request);
    }
    Most { lateral_mps2: lateral, jerk_mps3: jerk, braking_mps2: braking }
}

fn bend() -> impl Strategy<Value = (f64, f64, f64, f64)> {
    let radius = (125.0..2000.0_f64, proptest::bool::ANY);
    let curvature = radius.prop_map(|(r, left)| if left { 1.0 / r } else { -1.0 / r });
    (curvature, 30.0..200.0_f64, 20.0..400.0_f64, 0.0..400.0_f64)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn with_a_map_no_curve_is_taken_too_fast(
        bends in proptest::collection::vec(bend(), 1..6), set in 15.0..42.0_f64,
    ) {
        let most = drive(&Arcs::new(&bends), set, FOLLOWS_S, Knows::Map(0.0));
        prop_assert!(most.lateral_mps2 <= 2.6, "{} m/s²", most.lateral_mps2);
        prop_assert!(most.jerk_mps3 <= 2.5 + 1e-9, "{} m/s³", most.jerk_mps3);
    }

    #[test]
    fn without_a_map_or_with_a_shifted_one_the_jerk_is_comfortable(
        bends in proptest::collection::vec(bend(), 1..6), set in 15.0..42.0_f64,
        shift in -50.0..50.0_f64,
    ) {
        let road = Arcs::new(&bends);
        for knows in [Knows::OwnWay, Knows::Map(shift)] {
            let jerk = drive(&road, set, FOLLOWS_S, knows).jerk_mps3;
            prop_assert!(jerk <= 2.5 + 1e-9, "{knows:?}: {jerk} m/s³");
        }
    }

    /// This law follows the set speed 8 s late, so the bound alone keeps the curve. The map shows arcs of two
    /// cells, and blurs where they begin.
    #[test]
    fn a_law_that_follows_late_takes_no_curve_too_fast(
        radius_m in 30.0..500.0_f64, left in proptest::bool::ANY, spiral_m in 30.0..100.0_f64,
        arc_m in 2.0 * CELL_M..300.0, set in 15.0..40.0_f64,
    ) {
        let curvature_perm = if left { 1.0 / radius_m } else { -1.0 / radius_m };
        let road = Arcs::new(&[(curvature_perm, spiral_m, arc_m, 100.0)]);
        let most = drive(&road, set, 8.0, Knows::Map(0.0));
        prop_assert!(most.lateral_mps2 <= 2.6, "{} m/s²", most.lateral_mps2);
        prop_assert!(most.braking_mps2 <= HARD_MPS2, "{} m/s²", most.braking_mps2);
    }
}
