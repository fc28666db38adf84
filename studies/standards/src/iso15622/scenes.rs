//! The tests as scenarios.
//!
//! The curve tests have one of constant radius:
//!
//! ```text
//! line, 30 s ── clothoid ── arc of the class's radius ────────────────────────────►
//!               target and neighbour abreast, ego follows │ 12 s   │ the target loses 3.5 m/s in 2 s
//!                                                          ego on the arc
//! ```
//!
//! The speed is √(a R), by the class's design value a and its radius R. The standard allows a radius of 80 to 100 % of
//! that and a speed within 1 m/s. The target drives 1 m/s slower than √(a R) here, so the cap of the curve speed is above
//! it. The neighbour in the outer lane keeps its speed: an ego that follows it does not slow down.

use controller::curve_speed::comfortable_mps;
use frame::DriveOptions;
use scenario::controller::Comfort;
use scenario::{Scenario, Setting, Table, table};
use supervise::Error;

use super::limits::{BENDS, Class, STEADY_S};

/// Time when the lead of [`Test::StopAndGo`] brakes, s.
pub const BRAKES_AT_S: f64 = 25.0;
/// Time when it moves off again, s.
pub const MOVES_OFF_AT_S: f64 = 50.0;
/// Speed of the two vehicles beside each other in [`Test::Discrimination`], m/s.
pub const SIDE_BY_SIDE_MPS: f64 = 24.0;
/// Set speed in [`Test::Acquisition`], m/s.
pub const APPROACH_MPS: f64 = 30.0;

/// Time on the line of a curve test, in which the law settles, s.
const SETTLES_S: f64 = 30.0;
const CLOTHOID_M: f64 = 80.0;
/// Line before a bend, m: from 40 to 8 m/s it takes 770 m with 1 m/s². Time in which the slowest is through, s.
const BEND_AFTER_M: f64 = 900.0;
const BEND_S: f64 = 90.0;
/// Clothoid of a bend, m: as short as those of tight curves on public roads.
const SHORT_CLOTHOID_M: f64 = 30.0;
/// Time of the ego on the arc before the target slows down, s.
const ON_ARC_S: f64 = STEADY_S + 2.0;
/// Time after that, s.
const ANSWERS_S: f64 = 8.0;
/// Loss of the target's speed, m/s, and its time, s.
const LOSES: (f64, f64) = (3.5, 2.0);
/// The target is slower than the speed of the design value by this, m/s.
const SLOWER_MPS: f64 = 1.0;
/// The set speed is above the target's by this, m/s. Chosen: the ego follows.
const SET_ABOVE_MPS: f64 = 3.0;
/// Distance of the next lane, m.
const LANE_M: f64 = 3.5;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// A slower vehicle comes into the radar's range.
    Acquisition,
    /// Two vehicles drive side by side. The one in the lane speeds up, and the ego with it.
    Discrimination,
    /// A lead brakes to standstill, waits and moves off.
    StopAndGo,
    /// The ego follows through a curve.
    Curve(Curve),
    /// The ego comes to a curve on an empty road, faster than it may drive there.
    Bend(Bend),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    pub radius_m: f64,
    /// Speed before the bend, m/s.
    speed_mps: f64,
    pub has_map: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// The class of curve capability.
    pub class: Class,
    is_left: bool,
}

impl Test {
    pub fn all() -> impl Iterator<Item = Self> {
        let curve = |class| [true, false].map(|is_left| Self::Curve(Curve { class, is_left }));
        let curves = Class::ALL.into_iter().flat_map(curve);
        let bends = BENDS.into_iter().flat_map(|(radius_m, speed_mps)| {
            let (radius_m, speed_mps) = (radius_m.into(), speed_mps.into());
            [true, false].map(|has_map| Self::Bend(Bend { radius_m, speed_mps, has_map }))
        });
        let straight = [Self::Acquisition, Self::Discrimination, Self::StopAndGo];
        straight.into_iter().chain(curves).chain(bends)
    }

    pub fn name(self) -> String {
        match self {
            Self::Acquisition => "acquisition".to_owned(),
            Self::Discrimination => "discrimination".to_owned(),
            Self::StopAndGo => "stop-and-go".to_owned(),
            Self::Curve(Curve { class, is_left }) => {
                format!("curve-class-{}-{}", class.name, if is_left { "left" } else { "right" })
            }
            Self::Bend(Bend { radius_m, speed_mps, has_map }) => {
                let by = if has_map { "map" } else { "radar" };
                format!("bend-{radius_m}m-{speed_mps}mps-{by}")
            }
        }
    }

    pub fn scenario(self, law: &str, drives: &DriveOptions, seed: u32) -> Result<Scenario, Error> {
        let (duration_s, set_mps, initial_mps, keys) = match self {
            Self::Acquisition => {
                let target = actor("target", 250.0, 22.0, table! {});
                let keys = vec![Setting::new("actors", vec![target])];
                (60.0, APPROACH_MPS, APPROACH_MPS, keys)
            }
            Self::Discrimination => {
                let lead = steps(&[(20.0, 27.0, 0.5)]);
                let lead = actor("lead", 50.0, SIDE_BY_SIDE_MPS, lead);
                let beside = table! { lateral_offset_m: LANE_M };
                let neighbour = actor("neighbour", 50.0, SIDE_BY_SIDE_MPS, beside);
                let keys = vec![Setting::new("actors", vec![lead, neighbour])];
                (90.0, APPROACH_MPS, SIDE_BY_SIDE_MPS, keys)
            }
            Self::StopAndGo => {
                let goes = steps(&[(BRAKES_AT_S, 0.0, 2.5), (MOVES_OFF_AT_S, 10.0, 1.0)]);
                let lead = actor("lead", 40.0, 20.0, goes);
                (70.0, 25.0, 20.0, vec![Setting::new("actors", vec![lead])])
            }
            Self::Curve(curve) => {
                let speed_mps = curve.speed_mps();
                let duration_s = curve.slows_at_s() + ANSWERS_S;
                (duration_s, speed_mps + SET_ABOVE_MPS, speed_mps, curve.keys())
            }
            Self::Bend(bend) => (BEND_S, bend.speed_mps, bend.speed_mps, bend.keys()),
        };
        let engine = table! { mass_kg: 1600, max_power_kw: 110 };
        let own = [
            Setting::new("name", "iso15622"),
            Setting::new("duration_s", duration_s),
            Setting::new("seed", seed),
            Setting::new("set_speed_mps", set_mps),
            Setting::new("plant", table! { initial_speed_mps: initial_mps, powertrain: engine }),
            Setting::new("aebs.enabled", false),
            Setting::new("controller.name", law),
        ];
        drives.scenario(&[&own[..], &keys].concat())
    }
}

/// A vehicle `gap_m` ahead of the ego, with further keys.
fn actor(name: &str, gap_m: f64, speed_mps: f64, keys: Table) -> Table {
    let mut actor = table! { name: name, gap_m: gap_m, initial_speed_mps: speed_mps };
    actor.extend(keys);
    actor
}

/// The profile of changes of speed: time, s, speed, m/s, and acceleration, m/s².
fn steps(steps: &[(f64, f64, f64)]) -> Table {
    let step = |&(time_s, speed_mps, acceleration_mps2): &(f64, f64, f64)| {
        table! { time_s: time_s, speed_mps: speed_mps, acceleration_mps2: acceleration_mps2 }
    };
    table! { profile: table! { steps: steps.iter().map(step).collect::<Vec<_>>() } }
}

/// Pieces of a road with one curve.
fn pieces(line_m: f64, spiral_m: f64, arc_m: f64, radius_m: f64, turn: &str) -> Setting {
    let spiral = || table! { spiral_m: spiral_m };
    let arc = table! { arc_m: arc_m, radius_m: radius_m, turn: turn };
    let line = |line_m: f64| table! { line_m: line_m };
    let pieces = vec![line(line_m), spiral(), arc, spiral(), line(500.0)];
    Setting::new("road.plan.pieces", pieces)
}

impl Bend {
    /// Speed of the accepted lateral acceleration, m/s.
    pub fn comfortable_mps(self) -> f64 {
        comfortable_mps(&Comfort::default(), 1.0 / self.radius_m)
    }

    /// The road, and what is known of it.
    fn keys(self) -> Vec<Setting> {
        let arc_m = 4.0 * self.comfortable_mps();
        let mut keys = vec![pieces(BEND_AFTER_M, SHORT_CLOTHOID_M, arc_m, self.radius_m, "left")];
        if !self.has_map {
            keys.push(Setting::new("v2x.preview.ends_at_m", 0.0));
        }
        keys
    }
}

impl Curve {
    /// Speed of target and neighbour, m/s.
    fn speed_mps(self) -> f64 {
        libm::sqrt(self.class.lateral_mps2 * self.class.radius_m) - SLOWER_MPS
    }

    /// Distance of the target's rear at the start, m: that from which every law settles.
    fn gap_m(self) -> f64 {
        2.0 * self.speed_mps() + 6.0
    }

    fn arc_begins_m(self) -> f64 {
        SETTLES_S * self.speed_mps() + CLOTHOID_M
    }

    fn arc_m(self) -> f64 {
        self.speed_mps() * (ON_ARC_S + ANSWERS_S) + self.gap_m() + 20.0
    }

    /// Time at which the target slows down, s.
    pub fn slows_at_s(self) -> f64 {
        self.arc_begins_m() / self.speed_mps() + ON_ARC_S
    }

    /// The road and the vehicles.
    fn keys(self) -> Vec<Setting> {
        let (speed_mps, gap_m, radius_m) = (self.speed_mps(), self.gap_m(), self.class.radius_m);
        let (line_m, arc_m, slows_at_s) = (SETTLES_S * speed_mps, self.arc_m(), self.slows_at_s());
        let (loses_mps, in_s) = LOSES;
        let (slower_mps, loses_mps2) = (speed_mps - loses_mps, loses_mps / in_s);
        let (turn, beside_m) = if self.is_left { ("left", -LANE_M) } else { ("right", LANE_M) };
        let slows = steps(&[(slows_at_s, slower_mps, loses_mps2)]);
        let target = actor("target", gap_m, speed_mps, slows);
        let beside = table! { lateral_offset_m: beside_m };
        let neighbour = actor("neighbour", gap_m, speed_mps, beside);
        vec![
            pieces(line_m, CLOTHOID_M, arc_m, radius_m, turn),
            Setting::new("actors", vec![target, neighbour]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use scenario::actor::Profile;

    use super::*;

    fn curves() -> impl Iterator<Item = Curve> {
        Test::all().filter_map(|test| match test {
            Test::Curve(curve) => Some(curve),
            _ => None,
        })
    }

    #[test]
    fn every_test_is_a_scenario_and_its_times_are_those_named() {
        for test in Test::all() {
            test.scenario("acc-mpc", &DriveOptions::default(), 1)
                .unwrap_or_else(|error| panic!("{error}"));
        }
        let scenario =
            Test::StopAndGo.scenario("acc-mpc", &DriveOptions::default(), 1).expect("it is right");
        let Profile::Steps(steps) = &scenario.actors[0].profile else { panic!("it has steps") };
        let times: Vec<f64> = steps.iter().map(|step| step.time_s.value()).collect();
        assert_eq!(times, [BRAKES_AT_S, MOVES_OFF_AT_S]);
    }

    #[test]
    fn names_of_tests_stay() {
        let names: Vec<String> = Test::all().map(Test::name).collect();
        assert_eq!(
            names[..4],
            ["acquisition", "discrimination", "stop-and-go", "curve-class-ii-left"]
        );
        assert_eq!(names[8..10], ["curve-class-iv-right", "bend-30m-15mps-map"]);
        assert_eq!(names.last().map(String::as_str), Some("bend-500m-40mps-radar"));
    }

    #[test]
    fn speeds_are_those_of_the_design_values() {
        let speeds_mps = curves().map(|curve| curve.speed_mps() + SLOWER_MPS);
        for (speed_mps, expected_mps) in speeds_mps.zip([31.6, 31.6, 24.0, 24.0, 17.0, 17.0]) {
            assert!((speed_mps - expected_mps).abs() < 0.05, "{speed_mps}");
        }
    }

    #[test]
    fn the_vehicles_stay_on_the_arc_until_the_end() {
        for curve in curves() {
            let end_m = curve.gap_m() + curve.speed_mps() * (curve.slows_at_s() + ANSWERS_S);
            assert!(end_m <= curve.arc_begins_m() + curve.arc_m(), "{curve:?}");
        }
    }
}
