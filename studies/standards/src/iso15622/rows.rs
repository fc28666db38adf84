//! Figures of a test's drive, each with its limit.

use group::{Drive, DriveStep};
use scenario::Scenario;

use super::limits::{
    ACCELERATION, CREEP_MPS, DECELERATION, HOLD_S, JERK, LEAST_GAP_M, LONGEST_TIME_GAP_S,
    MOVE_OFF_S, REACTION_MPS2, SHORTEST_TIME_GAP_S, SLOWER_BESIDE_MPS, STANDING_MPS,
};
use super::scenes::{APPROACH_MPS, BRAKES_AT_S, MOVES_OFF_AT_S, SIDE_BY_SIDE_MPS, Test};
use super::sheet::{Row, Sheet};

/// The rows of one test with one law, by the drive in its scenario.
pub fn rows(test: Test, law: &str, scenario: &Scenario, drive: &Drive) -> Vec<Row> {
    let steps = &drive.steps;
    let mut sheet = Sheet { law, rows: Vec::new() };
    match test {
        Test::Acquisition => acquisition(&mut sheet, steps),
        Test::Discrimination => discrimination(&mut sheet, drive),
        Test::StopAndGo => stop_and_go(&mut sheet, steps),
        Test::Curve(curve) => curve.judge(&mut sheet, scenario, drive),
    }
    sheet.rows
}

fn acquisition(sheet: &mut Sheet<'_>, steps: &[DriveStep]) {
    let test = "target-acquisition-range";
    let ranges = steps.iter().filter_map(|step| Some((step.gap_m?, step.request_mps2)));
    let mut gap_m = None;
    let mut reacted_m = None;
    for (here_m, request_mps2) in ranges {
        gap_m = Some(here_m);
        if reacted_m.is_none() && request_mps2.is_some_and(|request| request < -REACTION_MPS2) {
            reacted_m = gap_m;
        }
    }
    let range = (test, "range_at_first_reaction_m", "m");
    sheet.at_least(range, reacted_m, LONGEST_TIME_GAP_S * APPROACH_MPS);
    let time_gap_s = steps.last().and_then(|last| Some(gap_m? / last.speed_mps));
    sheet.at_least((test, "settled_time_gap_s", "s"), time_gap_s, SHORTEST_TIME_GAP_S);
    brakes_within_limits(sheet, test, steps);
}

fn discrimination(sheet: &mut Sheet<'_>, drive: &Drive) {
    let test = "target-discrimination";
    let slowest = drive.steps.iter().map(|step| step.speed_mps).reduce(f64::min);
    sheet.at_least((test, "least_speed_mps", "m/s"), slowest, SIDE_BY_SIDE_MPS - SLOWER_BESIDE_MPS);
    let last = drive.steps.last();
    let neighbour_m = drive.vehicles.last().map(|truth| truth.vehicles[1].rear_position_m);
    let ahead_m = last.zip(neighbour_m).map(|(last, rear_m)| last.position_m - rear_m);
    sheet.at_least((test, "past_the_neighbour_m", "m"), ahead_m, 0.0);
}

fn stop_and_go(sheet: &mut Sheet<'_>, steps: &[DriveStep]) {
    let test = "automatic-deceleration";
    let part = |from_s: f64, to_s: f64| {
        let from = steps.partition_point(|step| step.time_s < from_s);
        let to = steps.partition_point(|step| step.time_s < to_s);
        &steps[from..to.max(from)]
    };
    let braking = part(BRAKES_AT_S, MOVES_OFF_AT_S);
    brakes_within_limits(sheet, test, braking);
    let least_gap_m = steps.iter().filter_map(|step| step.gap_m).reduce(f64::min);
    sheet.at_least((test, "least_gap_m", "m"), least_gap_m, LEAST_GAP_M);

    let test = "stop-and-hold";
    let stopped = braking.iter().position(|step| step.speed_mps < STANDING_MPS);
    let standing = stopped.map_or(&[][..], |stopped| &braking[stopped..]);
    let held_s = standing.first().zip(standing.last()).map(|(a, b)| b.time_s - a.time_s);
    sheet.at_least((test, "standing_s", "s"), held_s, HOLD_S);
    let creep_mps = standing.iter().map(|step| step.speed_mps).reduce(f64::max);
    sheet.at_most((test, "largest_speed_while_standing_mps", "m/s"), creep_mps, CREEP_MPS);

    let test = "go";
    let going = part(MOVES_OFF_AT_S, f64::INFINITY);
    let moved = going.iter().find(|step| step.speed_mps > CREEP_MPS);
    let after_s = moved.filter(|_| stopped.is_some()).map(|step| step.time_s - MOVES_OFF_AT_S);
    sheet.at_most((test, "moves_off_after_s", "s"), after_s, MOVE_OFF_S);
    let names = (test, "mean_acceleration_over_2_s_mps2", "m/s²");
    sheet.within(names, ACCELERATION, going, |step| step.speed_mps);
}

fn brakes_within_limits(sheet: &mut Sheet<'_>, test: &'static str, steps: &[DriveStep]) {
    let names = (test, "mean_deceleration_over_2_s_mps2", "m/s²");
    sheet.within(names, DECELERATION, steps, |step| -step.speed_mps);
    let names = (test, "mean_jerk_over_1_s_mps3", "m/s³");
    sheet.within(names, JERK, steps, |step| -step.acceleration_mps2);
}

#[cfg(test)]
mod tests {
    use super::*;
    use group::LawOptions;

    fn scenario() -> Scenario {
        let scenario = Test::StopAndGo.scenario("acc-mpc", &LawOptions::default(), 1);
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
        let failed: Vec<_> = rows.iter().filter(|row| !row.ok).map(|row| &*row.figure).collect();
        assert_eq!(failed, ["standing_s", "largest_speed_while_standing_mps", "moves_off_after_s"]);
    }
}
