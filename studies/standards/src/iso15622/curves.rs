//! The curve tests: following through a curve of constant radius, after ISO 15622 from secondary sources.
//!
//! ```text
//! line, 30 s ── clothoid ── arc of the class's radius ────────────────────────────►
//!               target and neighbour abreast, ego follows │ 12 s   │ the target loses 3.5 m/s in 2 s
//!                                                          ego on the arc
//! ```
//!
//! | class | radius R | design value a | speed √(a R) |
//! | --- | --- | --- | --- |
//! | II | 500 m | 2.0 m/s² | 31.6 m/s |
//! | III | 250 m | 2.3 m/s² | 24.0 m/s |
//! | IV | 125 m | 2.3 m/s² | 17.0 m/s |
//!
//! The standard allows a radius of 80 to 100 % of the class's and a speed within 1 m/s. The target drives 1 m/s slower
//! than √(a R) here, so the cap of the curve speed is above it. The neighbour in the outer lane keeps its speed: an ego
//! that follows it does not slow down.

use super::limits::{
    BEGINS_TO_SLOW_MPS2, CURVE_LATERAL_MARGIN_MPS2, DESIGN_LATERAL_MPS2, LEAST_SHARE_OF_TIME_GAP,
    MAX_TARGET_LOST_S, STEADY_S,
};
use super::sheet::Sheet;
use group::{Drive, DriveStep};
use report::targets;
use scenario::Scenario;

/// Time on the line, in which the law settles, s.
const SETTLES_S: f64 = 30.0;
/// Length of the clothoids, m.
const SPIRAL_M: f64 = 80.0;
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

/// A class of curve capability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Radii from 500 m on.
    Ii,
    /// Radii from 250 m on.
    Iii,
    /// Radii from 125 m on.
    Iv,
}

/// A curve test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Curve {
    /// The class.
    pub class: Class,
    /// The curve bends to the left.
    pub is_left: bool,
}

impl Class {
    /// Radius of its curve, m.
    fn radius_m(self) -> f64 {
        match self {
            Self::Ii => 500.0,
            Self::Iii => 250.0,
            Self::Iv => 125.0,
        }
    }

    /// Design value of the lateral acceleration, m/s².
    fn lateral_mps2(self) -> f64 {
        DESIGN_LATERAL_MPS2[self as usize]
    }
}

impl Curve {
    /// All tests.
    pub const ALL: [Self; 6] = [
        Self { class: Class::Ii, is_left: true },
        Self { class: Class::Ii, is_left: false },
        Self { class: Class::Iii, is_left: true },
        Self { class: Class::Iii, is_left: false },
        Self { class: Class::Iv, is_left: true },
        Self { class: Class::Iv, is_left: false },
    ];

    /// Name of the test in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.class, self.is_left) {
            (Class::Ii, true) => "curve-class-ii-left",
            (Class::Ii, false) => "curve-class-ii-right",
            (Class::Iii, true) => "curve-class-iii-left",
            (Class::Iii, false) => "curve-class-iii-right",
            (Class::Iv, true) => "curve-class-iv-left",
            (Class::Iv, false) => "curve-class-iv-right",
        }
    }

    /// Speed of target and neighbour, m/s.
    fn speed_mps(self) -> f64 {
        libm::sqrt(self.class.lateral_mps2() * self.class.radius_m()) - SLOWER_MPS
    }

    /// Distance of the target's rear at the start, m: that from which every law settles.
    fn gap_m(self) -> f64 {
        2.0 * self.speed_mps() + 6.0
    }

    /// Beginning of the arc, m.
    fn arc_m(self) -> f64 {
        SETTLES_S * self.speed_mps() + SPIRAL_M
    }

    /// Time at which the target slows down, s.
    fn slows_at_s(self) -> f64 {
        self.arc_m() / self.speed_mps() + ON_ARC_S
    }

    /// Length of the drive, s.
    pub fn duration_s(self) -> f64 {
        self.slows_at_s() + ANSWERS_S
    }

    /// The road and the vehicles, as tables of a scenario.
    pub fn tables(self) -> String {
        let (speed_mps, gap_m) = (self.speed_mps(), self.gap_m());
        let (loses_mps, in_s) = LOSES;
        let (turn, outer) = if self.is_left { ("left", -1.0) } else { ("right", 1.0) };
        let on_arc_m = speed_mps * (ON_ARC_S + ANSWERS_S) + gap_m + 20.0;
        format!(
            "[road.plan]\npieces = [{{ line_m = {} }}, {{ spiral_m = {SPIRAL_M} }}, \
             {{ arc_m = {on_arc_m}, radius_m = {}, turn = \"{turn}\" }}, {{ spiral_m = {SPIRAL_M} }}, \
             {{ line_m = 500 }}]\n\
             [[actors]]\nname = \"target\"\ngap_m = {gap_m}\ninitial_speed_mps = {speed_mps}\n\
             profile.steps = [{{ time_s = {}, speed_mps = {}, acceleration_mps2 = {} }}]\n\
             [[actors]]\nname = \"neighbour\"\ngap_m = {gap_m}\ninitial_speed_mps = {speed_mps}\n\
             lateral_offset_m = {}\n",
            SETTLES_S * speed_mps,
            self.class.radius_m(),
            self.slows_at_s(),
            speed_mps - loses_mps,
            loses_mps / in_s,
            outer * LANE_M,
        )
    }

    /// Set speed and speed at the start, m/s.
    pub fn speeds_mps(self) -> (f64, f64) {
        (self.speed_mps() + SET_ABOVE_MPS, self.speed_mps())
    }

    /// Adds the rows of a drive.
    pub(super) fn judge(self, sheet: &mut Sheet<'_>, scenario: &Scenario, drive: &Drive) {
        let test = self.name();
        let slows_s = self.slows_at_s();
        let steady = |step: &&DriveStep| (slows_s - STEADY_S..slows_s).contains(&step.time_s);
        let gaps = drive.steps.iter().filter(steady).filter_map(DriveStep::time_gap_s);
        let (sum_s, count) = gaps.fold((0.0, 0.0), |(sum, n), gap_s| (sum + gap_s, n + 1.0));
        let kept_s = (count > 0.0).then(|| sum_s / count);
        let answer = drive
            .steps
            .iter()
            // The truth about vehicles comes with some steps only.
            .filter(|step| step.time_s >= slows_s && step.gap_m.is_some())
            .find(|step| step.acceleration_mps2 <= -BEGINS_TO_SLOW_MPS2);
        let share = answer
            .and_then(DriveStep::time_gap_s)
            .zip(kept_s)
            .map(|(gap_s, kept_s)| gap_s / kept_s);
        let names = (test, "time_gap_share_when_it_slows", "1");
        sheet.at_least(names, share, LEAST_SHARE_OF_TIME_GAP);

        let axis = scenario.road.plan().map(scenario::plan::Plan::axis);
        let curvature = |place_m: f64| axis.map_or(0.0, |axis| axis.curvature_perm(place_m));
        let scans = targets::judge(drive, &curvature);
        // The tracker has confirmed its tracks by then.
        let settled: Vec<_> = scans.into_iter().filter(|scan| scan.time_s > STEADY_S).collect();
        let time_s = |finding: fn(&targets::JudgedScan) -> bool| {
            let spans = targets::spans(&settled, finding);
            let sum = spans.iter().map(|(from_s, to_s)| to_s - from_s).sum::<f64>();
            (!settled.is_empty()).then_some(sum)
        };
        let lost_s = time_s(targets::JudgedScan::is_lead_lost);
        sheet.at_most((test, "target_lost_s", "s"), lost_s, MAX_TARGET_LOST_S);
        let taken_s = time_s(targets::JudgedScan::is_neighbour_taken);
        sheet.at_most((test, "neighbour_followed_s", "s"), taken_s, MAX_TARGET_LOST_S);

        let lateral = drive.plane.iter().map(|scene| scene.ego.lateral_acceleration_mps2.abs());
        let most = self.class.lateral_mps2() + CURVE_LATERAL_MARGIN_MPS2;
        sheet.at_most((test, "lateral_acceleration_mps2", "m/s²"), lateral.reduce(f64::max), most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_those_of_the_design_values() {
        let speed_mps = |class| Curve { class, is_left: true }.speed_mps() + SLOWER_MPS;
        for (class, expected_mps) in [(Class::Ii, 31.6), (Class::Iii, 24.0), (Class::Iv, 17.0)] {
            assert!((speed_mps(class) - expected_mps).abs() < 0.05, "{class:?}");
        }
    }

    #[test]
    fn the_vehicles_stay_on_the_arc_until_the_end() {
        for curve in Curve::ALL {
            let end_m = curve.gap_m() + curve.speed_mps() * curve.duration_s();
            let arc_m = curve.speed_mps() * (ON_ARC_S + ANSWERS_S) + curve.gap_m() + 20.0;
            assert!(end_m <= curve.arc_m() + arc_m, "{curve:?}");
        }
    }
}
