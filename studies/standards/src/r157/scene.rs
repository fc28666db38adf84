//! A case as a scenario for a control law.
//!
//! The ego drives at the case's speed, which is also the set speed. Behind a lead it begins at the gap that its law
//! keeps there ([`super::settled`]). The run ends when no contact can follow any more.

use std::fmt::Write;

use crate::cut_in::{CLEARANCE_M, LATERAL_ACCELERATION_MPS2};
use crate::{STEP_S, VEHICLE_LENGTH_M, VEHICLE_WIDTH_M, cut_in, cut_out, following};
use group::Error;
use scenario::Scenario;

use super::drive::{Driver, Scene, actor, parse};
use super::matrix::Case;
use super::settled::Settled;

/// Time before a cut-in: the ego drives alone, and sees the other.
const CRUISE_S: f64 = 3.0;
/// Time before a lead brakes or leaves. Law and emergency brake need it to settle; the tracker has the lead from the
/// start. It is long enough. After 25 s gap, speed and acceleration differ by at most 0.05 m, 0.11 m/s and 0.03 m/s².
pub const RUN_IN_S: f64 = 2.0;
/// Time after which the ego stands or has matched the speed, from the last point at which something
/// can happen.
const AFTER_S: f64 = 4.0;
/// Deceleration by which every law stops at the latest.
const GENTLE_MPS2: f64 = 2.5;
/// The scenario of `case` for `driver`.
///
/// # Errors
/// [`Error::Scenario`] if there is no such law; as [`Settled::gap_m`].
pub fn scenario(case: &Case, driver: &Driver, settled: &Settled) -> Result<Scenario, Error> {
    let speed_mps = f64::from(case.ego_kmh()) / 3.6;
    let gap_m = || settled.gap_m(&driver.law, case.ego_kmh());
    let scene = match case {
        Case::CutIn(case) => cut_in_scene(case, speed_mps),
        Case::Following(case) => following_scene(case, speed_mps, gap_m()?),
        Case::CutOut(case) => cut_out_scene(case, speed_mps, gap_m()?),
    };
    parse(&scene, speed_mps, driver, settled.conditions())
}

/// The vehicle that comes in. It keeps its speed, so that a motion aside has no part in whether the ego comes nearer.
fn cut_in_scene(case: &cut_in::Case, speed_mps: f64) -> Scene {
    let other_mps = f64::from(case.other_kmh) / 3.6;
    let closing_mps = speed_mps - other_mps;
    let lateral_mps = case.lateral_mps();
    let rise_s = lateral_mps / LATERAL_ACCELERATION_MPS2;
    let lane_m = CLEARANCE_M + VEHICLE_WIDTH_M;
    let start_m = lane_m + lateral_mps * rise_s / 2.0;
    let gap_m = f64::from(case.distance_m) + closing_mps * (CRUISE_S + rise_s);
    // Time from the case's distance until the sides overlap; without lateral speed until it is passed.
    let passed_s = (f64::from(case.distance_m) + 2.0 * VEHICLE_LENGTH_M) / closing_mps;
    let overlap_s = if lateral_mps > 0.0 { CLEARANCE_M / lateral_mps } else { passed_s };
    let duration_s = CRUISE_S + rise_s + overlap_s + closing_mps / GENTLE_MPS2 + AFTER_S;
    let mut actors = actor("other", gap_m, &format!("initial_speed_mps = {other_mps}"));
    writeln!(actors, "lateral_offset_m = {start_m}").expect("a string takes all");
    if lateral_mps > 0.0 {
        writeln!(
            actors,
            "lateral = [{{ time_s = {CRUISE_S}, to_m = 0, duration_s = {}, rise_s = {rise_s} }}]",
            rise_s + lane_m / lateral_mps,
        )
        .expect("a string takes all");
    }
    Scene { scripted_s: CRUISE_S + rise_s, duration_s, actors }
}

/// The lead that brakes.
fn following_scene(case: &following::Case, speed_mps: f64, gap_m: f64) -> Scene {
    let deceleration_mps2 = case.lead_deceleration_mps2();
    let stop_s = speed_mps / deceleration_mps2.min(GENTLE_MPS2);
    let profile = format!(
        "initial_speed_mps = {speed_mps}\nprofile.piecewise = [\
         {{ time_s = {RUN_IN_S}, acceleration_mps2 = {} }}]",
        -deceleration_mps2
    );
    Scene {
        scripted_s: RUN_IN_S + speed_mps / deceleration_mps2,
        duration_s: RUN_IN_S + stop_s + AFTER_S,
        actors: actor("lead", gap_m, &profile),
    }
}

/// The lead that leaves and the vehicle that stands in front of it. A lead that does not get past in the matrix's steps
/// stands where it touches the other.
fn cut_out_scene(case: &cut_out::Case, speed_mps: f64, gap_m: f64) -> Scene {
    let lateral_mps = case.lateral_mps();
    let standing_m =
        gap_m + VEHICLE_LENGTH_M + speed_mps * RUN_IN_S + f64::from(case.standing_distance_m);
    let reaches_s = f64::from(case.standing_distance_m) / speed_mps;
    let hits = case.lead_hits();
    let leaves_s = if hits { reaches_s } else { (VEHICLE_WIDTH_M + CLEARANCE_M) / lateral_mps };
    let end_s = RUN_IN_S + leaves_s;
    let profile = if hits {
        let stands_s = end_s + STEP_S / 10.0;
        format!("profile.speeds = [[0, {speed_mps}], [{end_s}, {speed_mps}], [{stands_s}, 0]]")
    } else {
        format!("initial_speed_mps = {speed_mps}")
    };
    let mut actors = actor("lead", gap_m, &profile);
    writeln!(
        actors,
        "lateral = [{{ time_s = {RUN_IN_S}, to_m = {}, duration_s = {leaves_s}, rise_s = 0 }}]",
        lateral_mps * leaves_s,
    )
    .expect("a string takes all");
    actors += &actor("standing", standing_m, "initial_speed_mps = 0");
    let distance_m = gap_m + f64::from(case.standing_distance_m) + VEHICLE_LENGTH_M;
    let duration_s = RUN_IN_S + distance_m / speed_mps + speed_mps / GENTLE_MPS2 + AFTER_S;
    Scene { scripted_s: end_s + STEP_S, duration_s, actors }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;
    use controller::laws;
    use perception_sim::radar::scene::Ego;
    use perception_sim::traffic::Traffic;

    use super::super::drive::behind_a_lead;
    use super::super::matrix::Matrix;
    use super::super::settled::CLOSES_UP_S;
    use super::*;

    fn driver(law: &str) -> Driver {
        Driver { law: law.into(), aebs: false }
    }

    #[test]
    fn every_case_is_a_scenario() {
        let (driver, settled) = (driver("acc-mpc"), Settled::new(1));
        for matrix in Matrix::value_variants() {
            for case in matrix.cases().iter().step_by(97) {
                let scenario = scenario(case, &driver, &settled);
                let scenario = scenario.unwrap_or_else(|error| panic!("{error}"));
                assert!(scenario.duration_s.value() < 100.0, "{case:?}");
            }
        }
    }

    #[test]
    fn an_unknown_law_is_refused() {
        for matrix in Matrix::value_variants() {
            let refused = scenario(&matrix.cases()[0], &driver("acc"), &Settled::new(1));
            let refused = refused.expect_err("no such law");
            assert!(refused.to_string().contains("acc-mpc"), "{refused}");
        }
    }

    #[test]
    fn a_cut_in_is_at_its_distance_when_it_has_its_lateral_speed() {
        let case =
            cut_in::Case { ego_kmh: 60, other_kmh: 20, distance_m: 25, lateral_tenths_mps: 15 };
        let scenario = scenario(&Case::CutIn(case), &driver("acc-mpc"), &Settled::new(1));
        let scenario = scenario.expect("the case is right");
        let other = &scenario.actors[0];
        let time_s = CRUISE_S + 1.0;
        let gap_m = other.gap_m.value() - time_s * 40.0 / 3.6;
        assert!((gap_m - 25.0).abs() < 1e-9, "{gap_m}");
        let motion = other.lateral[0];
        let lateral_m = |at_s| other.lateral_offset_m.value() * (1.0 - motion.progress(at_s).0);
        assert!((lateral_m(time_s) - 3.5).abs() < 1e-9);
        assert!((lateral_m(time_s + 1.0) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn a_lead_that_hits_the_standing_vehicle_stands_at_it_and_another_drives_on() {
        // 2.18 s to the standing vehicle, 2.11 s to be clear of it. The other is not clear, and touches it after 1.26
        // s.
        for (standing_distance_m, stands) in [(67, false), (39, true)] {
            let case = cut_out::Case { speed_kmh: 110, standing_distance_m, lateral_tenths_mps: 9 };
            let scenario = scenario(&Case::CutOut(case), &driver("acc-mpc"), &Settled::new(1));
            let scenario = scenario.expect("the case is right");
            let mut traffic = Traffic::new(&scenario);
            let ego = Ego::default();
            for step in 0..600 {
                traffic.advance(step * 10_000_000, &ego);
            }
            let [lead, standing] = [0, 1].map(|place| traffic.vehicles()[place]);
            let between_m = standing.rear_position_m - lead.rear_position_m - VEHICLE_LENGTH_M;
            assert_eq!(lead.speed_mps == 0.0, stands, "{lead:?}");
            assert_eq!((-0.2..0.001).contains(&between_m), stands, "{between_m}");
        }
    }

    /// Gap, m, speed, m/s, and acceleration, m/s², when the lead has driven evenly for `time_s`.
    fn state_at(scenario: &Scenario, time_s: f64) -> [f64; 3] {
        let group = group::in_process::run_unsealed(scenario, &|| false).expect("it runs");
        let steps = group.drive.steps.iter().take_while(|step| step.time_s <= time_s + 1e-9);
        let last = steps.filter(|step| step.gap_m.is_some()).last().expect("it has begun");
        [last.gap_m.expect("there is a lead"), last.speed_mps, last.acceleration_mps2]
    }

    #[test]
    fn the_state_at_the_onset_is_the_one_after_a_long_time_behind_the_lead() {
        for law in laws::own() {
            let (driver, settled) = (driver(law.name), Settled::new(1));
            for speed_kmh in [12, 30, 60, 90, 128] {
                let long = behind_a_lead(speed_kmh, &driver, settled.conditions(), CLOSES_UP_S)
                    .expect("a law");
                let long = state_at(&long, CLOSES_UP_S);
                let case = following::Case { speed_kmh, lead_hundredths_g: 50 };
                let case = scenario(&Case::Following(case), &driver, &settled).expect("a law");
                let onset = state_at(&case, RUN_IN_S);
                for (i, most) in [0.05, 0.11, 0.03].into_iter().enumerate() {
                    let off = (onset[i] - long[i]).abs();
                    assert!(off < most, "{} at {speed_kmh}: {onset:?} {long:?}", law.name);
                }
            }
        }
    }
}
