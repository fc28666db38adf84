//! Figures of a test's drive, each with its limit.

use report::targets::{self, JudgedScan};
use scenario::Scenario;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use supervise::{Drive, DriveStep};

use super::limits::{
    ACCELERATION, BEGINS_TO_SLOW_MPS2, BEND_BRAKING_MPS2, BEND_LATERAL_SHARE, CREEP_MPS,
    CURVE_LATERAL_MARGIN_MPS2, DECELERATION, HOLD_S, JERK, LEAST_GAP_M, LEAST_SHARE_OF_TIME_GAP,
    LONGEST_TIME_GAP_S, Limit, MAX_TARGET_LOST_S, MOVE_OFF_S, REACTION_MPS2, SHORTEST_TIME_GAP_S,
    SLOWER_BESIDE_MPS, STANDING_MPS, STEADY_S,
};
use super::scenes::{
    APPROACH_MPS, BRAKES_AT_S, Bend, Curve, MOVES_OFF_AT_S, SIDE_BY_SIDE_MPS, Test,
};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Control law that drove.
    pub law: String,
    /// Test of the standard.
    pub test: String,
    pub figure: String,
    pub unit: String,
    /// Value; null if the event did not happen.
    pub value: Option<f64>,
    /// Least accepted value.
    pub least: Option<f64>,
    /// Largest accepted value.
    pub most: Option<f64>,
    /// The value is inside its limits.
    pub ok: bool,
}

pub fn rows(test: Test, law: &str, scenario: &Scenario, drive: &Drive) -> Vec<Row> {
    let mut sheet = Sheet { law: law.to_owned(), test: test.name(), rows: Vec::new() };
    match test {
        Test::Acquisition => sheet.acquisition(&drive.steps),
        Test::Discrimination => sheet.discrimination(drive),
        Test::StopAndGo => sheet.stop_and_go(&drive.steps),
        Test::Curve(curve) => sheet.curve(curve, scenario, drive),
        Test::Bend(bend) => sheet.bend(bend, drive),
    }
    sheet.rows
}

/// The largest lateral acceleration of a drive, m/s².
fn lateral_mps2(drive: &Drive) -> Option<f64> {
    drive.plane.iter().map(|scene| scene.ego.lateral_acceleration_mps2.abs()).reduce(f64::max)
}

struct Sheet {
    law: String,
    test: String,
    rows: Vec<Row>,
}

impl Sheet {
    fn acquisition(&mut self, steps: &[DriveStep]) {
        "target-acquisition-range".clone_into(&mut self.test);
        let mut ranges = steps.iter().filter_map(|step| Some((step.gap_m?, step.request_mps2)));
        let reacts = |request_mps2: Option<f64>| request_mps2.is_some_and(|a| a < -REACTION_MPS2);
        let reacted_m = ranges.clone().find(|(_, request_mps2)| reacts(*request_mps2));
        let reacted_m = reacted_m.map(|(gap_m, _)| gap_m);
        self.at_least(
            "range_at_first_reaction_m",
            "m",
            reacted_m,
            LONGEST_TIME_GAP_S * APPROACH_MPS,
        );
        let time_gap_s =
            ranges.next_back().zip(steps.last()).map(|((gap_m, _), s)| gap_m / s.speed_mps);
        self.at_least("settled_time_gap_s", "s", time_gap_s, SHORTEST_TIME_GAP_S);
        self.brakes(steps);
    }

    fn discrimination(&mut self, drive: &Drive) {
        "target-discrimination".clone_into(&mut self.test);
        let slowest_mps = drive.steps.iter().map(|step| step.speed_mps).reduce(f64::min);
        let least_mps = SIDE_BY_SIDE_MPS - SLOWER_BESIDE_MPS;
        self.at_least("least_speed_mps", "m/s", slowest_mps, least_mps);
        let neighbour_m = drive.vehicles.last().map(|truth| truth.vehicles[1].rear_position_m);
        let ahead_m = drive.steps.last().zip(neighbour_m).map(|(ego, m)| ego.position_m - m);
        self.at_least("past_the_neighbour_m", "m", ahead_m, 0.0);
    }

    fn stop_and_go(&mut self, steps: &[DriveStep]) {
        let index = |time_s: f64| steps.partition_point(|step| step.time_s < time_s);
        let (brakes, moves_off) = (index(BRAKES_AT_S), index(MOVES_OFF_AT_S));
        let (braking, going) = (&steps[brakes..moves_off], &steps[moves_off..]);
        "automatic-deceleration".clone_into(&mut self.test);
        self.brakes(braking);
        let least_gap_m = steps.iter().filter_map(|step| step.gap_m).reduce(f64::min);
        self.at_least("least_gap_m", "m", least_gap_m, LEAST_GAP_M);

        "stop-and-hold".clone_into(&mut self.test);
        let stopped = braking.iter().position(|step| step.speed_mps < STANDING_MPS);
        let standing = stopped.map_or(&[][..], |stopped| &braking[stopped..]);
        let held_s = standing.first().zip(standing.last()).map(|(a, b)| b.time_s - a.time_s);
        self.at_least("standing_s", "s", held_s, HOLD_S);
        let creep_mps = standing.iter().map(|step| step.speed_mps).reduce(f64::max);
        self.at_most("largest_speed_while_standing_mps", "m/s", creep_mps, CREEP_MPS);

        "go".clone_into(&mut self.test);
        let moved = going.iter().find(|step| step.speed_mps > CREEP_MPS);
        let after_s = moved.filter(|_| stopped.is_some()).map(|step| step.time_s - MOVES_OFF_AT_S);
        self.at_most("moves_off_after_s", "s", after_s, MOVE_OFF_S);
        let speed = |step: &DriveStep| step.speed_mps;
        self.within("mean_acceleration_over_2_s_mps2", "m/s²", ACCELERATION, going, speed);
    }

    fn curve(&mut self, curve: Curve, scenario: &Scenario, drive: &Drive) {
        let slows_s = curve.slows_at_s();
        let steady = |step: &&DriveStep| (slows_s - STEADY_S..slows_s).contains(&step.time_s);
        let gaps = drive.steps.iter().filter(steady).filter_map(DriveStep::time_gap_s);
        let (sum_s, count) = gaps.fold((0.0, 0.0), |(sum, n), gap_s| (sum + gap_s, n + 1.0));
        let kept_s = (count > 0.0).then(|| sum_s / count);
        // The truth about vehicles comes with some steps only.
        let mut after = drive.steps.iter().filter(|s| s.time_s >= slows_s && s.gap_m.is_some());
        let answer = after.find(|step| step.acceleration_mps2 <= -BEGINS_TO_SLOW_MPS2);
        let answer_s = answer.and_then(DriveStep::time_gap_s);
        let share = answer_s.zip(kept_s).map(|(gap_s, kept_s)| gap_s / kept_s);
        self.at_least("time_gap_share_when_it_slows", "1", share, LEAST_SHARE_OF_TIME_GAP);

        let axis = scenario.road.plan().map(scenario::plan::Plan::axis);
        let curvature = |place_m: f64| axis.map_or(0.0, |axis| axis.curvature_perm(place_m));
        let scans = targets::judge(drive, &curvature).into_iter();
        // The tracker has confirmed its tracks by then.
        let settled: Vec<_> = scans.filter(|scan| scan.time_s > STEADY_S).collect();
        let time_s = |finding: fn(&JudgedScan) -> bool| {
            let spans = targets::spans(&settled, finding);
            let sum_s = spans.iter().map(|(from_s, to_s)| to_s - from_s).sum::<f64>();
            (!settled.is_empty()).then_some(sum_s)
        };
        let lost_s = time_s(JudgedScan::is_lead_lost);
        self.at_most("target_lost_s", "s", lost_s, MAX_TARGET_LOST_S);
        let taken_s = time_s(JudgedScan::is_neighbour_taken);
        self.at_most("neighbour_followed_s", "s", taken_s, MAX_TARGET_LOST_S);

        let most = curve.class.lateral_mps2 + CURVE_LATERAL_MARGIN_MPS2;
        self.at_most("lateral_acceleration_mps2", "m/s²", lateral_mps2(drive), most);
    }

    fn bend(&mut self, bend: Bend, drive: &Drive) {
        let accepted_mps2 = bend.comfortable_mps() * bend.comfortable_mps() / bend.radius_m;
        let share = lateral_mps2(drive).map(|lateral_mps2| lateral_mps2 / accepted_mps2);
        let braking = drive.steps.iter().map(|step| -step.acceleration_mps2).reduce(f64::max);
        let (in_time_mps2, late_mps2) = BEND_BRAKING_MPS2;
        if bend.has_map || share.is_none_or(|share| share <= BEND_LATERAL_SHARE) {
            self.at_most("lateral_share", "1", share, BEND_LATERAL_SHARE);
        } else {
            // It showed too late, if the braking was as hard as for a curve in time.
            self.at_least("braking_for_a_late_bend_mps2", "m/s²", braking, in_time_mps2);
        }
        let most_mps2 = if bend.has_map { in_time_mps2 } else { late_mps2 };
        self.at_most("hardest_braking_mps2", "m/s²", braking, most_mps2);
    }

    fn brakes(&mut self, steps: &[DriveStep]) {
        let speed = |step: &DriveStep| -step.speed_mps;
        self.within("mean_deceleration_over_2_s_mps2", "m/s²", DECELERATION, steps, speed);
        let acceleration = |step: &DriveStep| -step.acceleration_mps2;
        self.within("mean_jerk_over_1_s_mps3", "m/s³", JERK, steps, acceleration);
    }

    /// A mean over a window against a limit over speed.
    fn within(
        &mut self,
        figure: &str,
        unit: &str,
        limit: Limit,
        steps: &[DriveStep],
        quantity: impl Fn(&DriveStep) -> f64,
    ) {
        let worst = limit.worst(steps, quantity);
        let most = worst.map_or_else(|| limit.at(0.0), |(_, limit)| limit);
        self.at_most(figure, unit, worst.map(|(mean, _)| mean), most);
    }

    fn at_least(&mut self, figure: &str, unit: &str, value: Option<f64>, least: f64) {
        let ok = value.is_some_and(|value| value >= least);
        self.push(figure, unit, Row { value, least: Some(least), ok, ..Row::default() });
    }

    fn at_most(&mut self, figure: &str, unit: &str, value: Option<f64>, most: f64) {
        let ok = value.is_some_and(|value| value <= most);
        self.push(figure, unit, Row { value, most: Some(most), ok, ..Row::default() });
    }

    fn push(&mut self, figure: &str, unit: &str, row: Row) {
        let (law, test) = (self.law.clone(), self.test.clone());
        self.rows.push(Row { law, test, figure: figure.into(), unit: unit.into(), ..row });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frame::DriveOptions;

    fn scenario() -> Scenario {
        let scenario = Test::StopAndGo.scenario("acc-mpc", &DriveOptions::default(), 1);
        scenario.expect("it is a scenario")
    }

    #[test]
    fn a_drive_that_stops_holds_and_goes_is_inside() {
        let step = |k: u32| {
            let time_s = 0.01 * f64::from(k);
            let speed_mps = if time_s < 25.5 {
                20.0
            } else if time_s < 51.0 {
                (20.0 - 2.6 * (time_s - 25.5)).max(0.0)
            } else {
                (time_s - 51.0).min(10.0)
            };
            let gap_m = Some(if time_s < 40.0 { 30.0 } else { 5.0 });
            DriveStep { time_s, speed_mps, gap_m, ..DriveStep::default() }
        };
        let drive = Drive { steps: (0..7000).map(step).collect(), ..Drive::default() };
        let rows = rows(Test::StopAndGo, "x", &scenario(), &drive);
        assert_eq!(rows.len(), 7);
        assert!(rows.iter().all(|row| row.ok), "{rows:#?}");
        let value = |figure| rows.iter().find(|row| row.figure == figure).and_then(|r| r.value);
        assert!((value("moves_off_after_s").expect("it moves off") - 1.1).abs() < 0.02);
        assert!((value("mean_deceleration_over_2_s_mps2").expect("it brakes") - 2.6).abs() < 1e-9);
    }

    #[test]
    fn a_drive_that_never_stops_holds_nothing() {
        let step = |k: u32| DriveStep {
            time_s: 0.01 * f64::from(k),
            speed_mps: 9.0,
            gap_m: Some(9.0),
            ..DriveStep::default()
        };
        let drive = Drive { steps: (0..7000).map(step).collect(), ..Drive::default() };
        let rows = rows(Test::StopAndGo, "x", &scenario(), &drive);
        let failed: Vec<_> =
            rows.iter().filter(|row| !row.ok).map(|row| row.figure.as_str()).collect();
        assert_eq!(failed, ["standing_s", "largest_speed_while_standing_mps", "moves_off_after_s"]);
    }
}
