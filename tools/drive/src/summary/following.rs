//! Time gaps of a drive, and its gap errors while following.
//!
//! ```text
//! time gap = gap / ego speed          gap error = gap - desired gap
//! ```
//!
//! One desired gap serves all laws, so that their errors can be compared. It is `referee.desired_gap` of the scenario,
//! or [`STATED_GAP`] without it. Errors count while the ego follows. Following begins when the ego first has the speed
//! of the vehicle ahead. It begins at the earliest 2 s after that vehicle came. It ends when that vehicle is gone, or
//! when another one takes its place. The approach before does not count.

use crate::DriveStep;
use crate::report::ControlFigures;
use scenario::Scenario;
use scenario::quantity::{Distance, TimeConstant};
use scenario::referee::DesiredGap;
use serde::{Deserialize, Serialize};

/// Desired gap of scenarios that name none. Chosen: the headway and distance that `acc-mpc` and `cacc-mpc`, the
/// default laws, aim at.
pub const STATED_GAP: DesiredGap = DesiredGap::Headway {
    time_headway_s: TimeConstant::of(1.5),
    standstill_distance_m: Distance::of(5.0),
};
/// Largest difference of speeds at which following begins, m/s. Chosen.
const SAME_SPEED_MPS: f64 = 1.0;
/// Time for which a vehicle is ahead before following begins, s. Chosen.
const SETTLES_S: f64 = 2.0;
/// Time without a gap after which the vehicle ahead is gone, s: several samples of the ground truth.
const GONE_S: f64 = 0.5;
/// Change of the gap between two samples that means another vehicle, m. Chosen: a vehicle's length.
const ANOTHER_M: f64 = 4.5;

/// Gap errors while following, m: null without following.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GapErrors {
    /// Root mean square over time.
    pub rms_m: Option<f64>,
    pub largest_m: Option<f64>,
    /// Error at the end of the drive.
    pub final_m: Option<f64>,
}

impl GapErrors {
    pub fn of(scenario: &Scenario, steps: &[DriveStep]) -> Self {
        let desired = scenario.referee.desired_gap.unwrap_or(STATED_GAP);
        let mut errors = Self::default();
        let (mut squares, mut time_s) = (0.0, 0.0);
        let (mut ahead_since_s, mut has_matched) = (0.0, false);
        let mut last: Option<(f64, f64)> = None;
        for step in steps {
            let Some((gap_m, lead_mps)) = step.gap_m.zip(step.lead_speed_mps) else {
                // The gap is absent between its samples too.
                if last.is_some_and(|(then_s, _)| step.time_s - then_s > GONE_S) {
                    last = None;
                }
                continue;
            };
            if last.is_none_or(|(_, before_m)| (gap_m - before_m).abs() > ANOTHER_M) {
                (ahead_since_s, has_matched) = (step.time_s, false);
            }
            has_matched |= (step.speed_mps - lead_mps).abs() <= SAME_SPEED_MPS;
            let follows = has_matched && step.time_s - ahead_since_s >= SETTLES_S;
            if follows {
                let error_m = gap_m - desired.at(step.speed_mps);
                let since_s = last.map_or(0.0, |(then_s, _)| step.time_s - then_s);
                squares += error_m * error_m * since_s;
                time_s += since_s;
                errors.largest_m = Some(errors.largest_m.unwrap_or(0.0).max(error_m.abs()));
                errors.final_m = Some(error_m);
            } else {
                errors.final_m = None;
            }
            last = Some((step.time_s, gap_m));
        }
        errors.final_m = errors.final_m.filter(|_| last.is_some());
        errors.rms_m = (time_s > 0.0).then(|| (squares / time_s).sqrt());
        errors
    }

    /// Replaces the referee's errors, which have another desired gap for each law.
    pub fn write(self, figures: &mut ControlFigures) {
        figures.rms_gap_error_m = self.rms_m;
        figures.max_abs_gap_error_m = self.largest_m;
        figures.final_gap_error_m = self.final_m;
    }
}

/// Time gaps behind a vehicle, s; null without one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Following {
    /// Shortest time gap, s; 0 in a contact.
    pub min_time_gap_s: Option<f64>,
    /// Median over the samples of the drive, s.
    pub median_time_gap_s: Option<f64>,
}

impl Following {
    /// Evaluates the samples with a gap at 1 m/s or faster.
    pub fn of(steps: &[DriveStep]) -> Self {
        let mut gaps_s: Vec<f64> = steps.iter().filter_map(DriveStep::time_gap_s).collect();
        gaps_s.sort_by(f64::total_cmp);
        let median = match gaps_s.len() {
            0 => None,
            n => Some((gaps_s[(n - 1) / 2] + gaps_s[n / 2]) / 2.0),
        };
        Self { min_time_gap_s: gaps_s.first().copied(), median_time_gap_s: median }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ego at 20 m/s behind a lead: gap and lead speed by the time, every 0.1 s.
    fn drive(duration_s: f64, lead: impl Fn(f64) -> Option<(f64, f64)>) -> Vec<DriveStep> {
        let samples = (0..).map(|k| 0.1 * f64::from(k)).take_while(|time_s| *time_s <= duration_s);
        let step = |time_s| {
            let (gap_m, lead_speed_mps) = lead(time_s).unzip();
            DriveStep { time_s, speed_mps: 20.0, gap_m, lead_speed_mps, ..DriveStep::default() }
        };
        samples.map(step).collect()
    }

    fn errors(steps: &[DriveStep]) -> GapErrors {
        let text = "schema_version = 1\nname = \"a\"";
        GapErrors::of(&Scenario::parse("a.toml", text).expect("it is valid"), steps)
    }

    #[test]
    fn the_way_to_the_gap_does_not_count() {
        // The ego closes in from 90 m with 5 m/s for 10 s, then keeps 40 m. That is 5 m more than the stated gap.
        let approach = |time_s: f64| {
            Some(if time_s < 10.0 { (90.0 - 5.0 * time_s, 15.0) } else { (40.0, 20.0) })
        };
        let found = errors(&drive(30.0, approach));
        assert_eq!((found.largest_m, found.final_m), (Some(5.0), Some(5.0)));
        assert!((found.rms_m.expect("it follows") - 5.0).abs() < 1e-9);
        assert_eq!(errors(&drive(9.0, approach)), GapErrors::default(), "it never follows");
    }

    #[test]
    fn another_lead_begins_anew_and_one_that_is_gone_has_no_final_error() {
        let cut_in = |time_s: f64| Some((if time_s < 5.0 { 35.0 } else { 20.0 }, 20.0));
        let found = errors(&drive(6.0, cut_in));
        assert_eq!((found.largest_m, found.final_m), (Some(0.0), None));
        let leaves = |time_s: f64| (time_s < 5.0).then_some((36.0, 20.0));
        let found = errors(&drive(6.0, leaves));
        assert_eq!((found.largest_m, found.final_m), (Some(1.0), None));
    }

    #[test]
    fn a_time_gap_is_the_gap_over_the_speed_and_does_not_exist_at_a_stand() {
        let step = |gap_m, speed_mps| DriveStep { gap_m, speed_mps, ..DriveStep::default() };
        let steps = [
            step(Some(20.0), 10.0),
            step(Some(30.0), 10.0),
            step(Some(15.0), 10.0),
            step(None, 10.0),
            step(Some(3.0), 0.0),
        ];
        let following = Following::of(&steps);
        assert_eq!(following.min_time_gap_s, Some(1.5));
        assert_eq!(following.median_time_gap_s, Some(2.0));
        assert_eq!(Following::of(&steps[3..]), Following::default());
        assert_eq!(Following::of(&[step(Some(-1.4), 10.0)]).min_time_gap_s, Some(0.0));
    }
}
