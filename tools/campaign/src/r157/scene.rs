//! A case as a scenario for a control law.
//!
//! The ego drives at the case's speed, which is also the set speed, and keeps the gap of its law. Before
//! the case begins it has time to settle. All vehicles are as long as the regulation says.

use std::fmt::Write;

use controller::laws;
use group::Error;
use regulation::cut_in::{CLEARANCE_M, LATERAL_ACCELERATION_MPS2};
use regulation::{STEP_S, VEHICLE_LENGTH_M, VEHICLE_WIDTH_M, cut_in, cut_out, following};
use scenario::{Overrides, Scenario};

use super::matrix::Case;

/// Time before a cut-in: the ego drives alone, and sees the other.
const CRUISE_S: f64 = 3.0;
/// Time before a lead brakes or leaves: the ego closes up to the gap that its law keeps.
const SETTLE_S: f64 = 25.0;
/// Time gap from which a law closes up or falls back to its own.
const FIRST_TIME_GAP_S: f64 = 2.0;
/// Distance added to that.
const FIRST_DISTANCE_M: f64 = 5.0;
/// Time after which the ego stands or has matched the speed, from the last point at which something
/// can happen.
const AFTER_S: f64 = 4.0;
/// Deceleration by which every law stops at the latest.
const GENTLE_MPS2: f64 = 2.5;

/// Who drives a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Driver {
    /// The control law.
    pub law: String,
    /// With the emergency brake.
    pub aebs: bool,
}

/// The scenario of `case` for `driver`.
///
/// # Errors
/// [`Error::Scenario`] if there is no such law.
pub fn scenario(case: &Case, driver: &Driver, seed: u64) -> Result<Scenario, Error> {
    let text = text(case, driver, seed);
    Ok(Scenario::parse_with("a case of UN R157", &text, &Overrides::new(), &laws::check)?)
}

fn text(case: &Case, driver: &Driver, seed: u64) -> String {
    let speed_mps = f64::from(case.ego_kmh()) / 3.6;
    let (duration_s, actors) = match case {
        Case::CutIn(case) => cut_in_actors(case, speed_mps),
        Case::Following(case) => following_actors(case, speed_mps),
        Case::CutOut(case) => cut_out_actors(case, speed_mps),
    };
    let Driver { law, aebs } = driver;
    format!(
        "schema_version = 1\nname = \"r157\"\nduration_s = {duration_s}\nseed = {seed}\n\
         set_speed_mps = {speed_mps}\n\
         [plant]\ninitial_speed_mps = {speed_mps}\n\
         length_m = {VEHICLE_LENGTH_M}\n\
         powertrain = {{ mass_kg = 1600, max_power_kw = 110 }}\n\
         [aebs]\nenabled = {aebs}\n\
         [controller]\nname = \"{law}\"\n{actors}"
    )
}

/// Duration, s, and the vehicle that comes in.
fn cut_in_actors(case: &cut_in::Case, speed_mps: f64) -> (f64, String) {
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
    (duration_s, actors)
}

/// Duration, s, and the lead that brakes.
fn following_actors(case: &following::Case, speed_mps: f64) -> (f64, String) {
    let deceleration_mps2 = case.lead_deceleration_mps2();
    let stop_s = speed_mps / deceleration_mps2.min(GENTLE_MPS2);
    let profile = format!(
        "initial_speed_mps = {speed_mps}\nprofile.piecewise = [\
         {{ time_s = {SETTLE_S}, acceleration_mps2 = {} }}]",
        -deceleration_mps2
    );
    (SETTLE_S + stop_s + AFTER_S, actor("lead", first_gap_m(speed_mps), &profile))
}

/// Duration, s, the lead that leaves and the vehicle that stands in front of it. A lead that does not
/// get past stands there.
fn cut_out_actors(case: &cut_out::Case, speed_mps: f64) -> (f64, String) {
    let lateral_mps = case.lateral_mps();
    let gap_m = first_gap_m(speed_mps);
    let standing_m =
        gap_m + VEHICLE_LENGTH_M + speed_mps * SETTLE_S + f64::from(case.standing_distance_m);
    let reaches_s = f64::from(case.standing_distance_m) / speed_mps;
    let clear_s = VEHICLE_WIDTH_M / lateral_mps;
    let hits = reaches_s < clear_s;
    let leaves_s = if hits { reaches_s } else { (VEHICLE_WIDTH_M + CLEARANCE_M) / lateral_mps };
    let end_s = SETTLE_S + leaves_s;
    let profile = if hits {
        let stands_s = end_s + STEP_S / 10.0;
        format!("profile.speeds = [[0, {speed_mps}], [{end_s}, {speed_mps}], [{stands_s}, 0]]")
    } else {
        format!("initial_speed_mps = {speed_mps}")
    };
    let mut actors = actor("lead", gap_m, &profile);
    writeln!(
        actors,
        "lateral = [{{ time_s = {SETTLE_S}, to_m = {}, duration_s = {leaves_s}, rise_s = 0 }}]",
        lateral_mps * leaves_s,
    )
    .expect("a string takes all");
    actors += &actor("standing", standing_m, "initial_speed_mps = 0");
    let distance_m = gap_m + f64::from(case.standing_distance_m) + VEHICLE_LENGTH_M;
    let duration_s = SETTLE_S + distance_m / speed_mps + speed_mps / GENTLE_MPS2 + AFTER_S;
    (duration_s, actors)
}

fn first_gap_m(speed_mps: f64) -> f64 {
    FIRST_TIME_GAP_S * speed_mps + FIRST_DISTANCE_M
}

fn actor(name: &str, gap_m: f64, keys: &str) -> String {
    format!(
        "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m}\nlength_m = {VEHICLE_LENGTH_M}\n{keys}\n"
    )
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::super::matrix::Matrix;
    use super::*;

    #[test]
    fn every_case_is_a_scenario() {
        let driver = Driver { law: "acc-mpc".into(), aebs: false };
        for matrix in Matrix::value_variants() {
            for case in matrix.cases().iter().step_by(97) {
                let scenario = scenario(case, &driver, 1).unwrap_or_else(|e| panic!("{e}"));
                assert!(scenario.duration_s.value() < 130.0, "{case:?}");
            }
        }
    }

    #[test]
    fn an_unknown_law_is_refused() {
        let driver = Driver { law: "acc".into(), aebs: false };
        let refused = scenario(&Matrix::CutIn.cases()[0], &driver, 1).expect_err("no such law");
        assert!(refused.to_string().contains("acc-mpc"), "{refused}");
    }

    #[test]
    fn a_cut_in_is_at_its_distance_when_it_has_its_lateral_speed() {
        let case =
            cut_in::Case { ego_kmh: 60, other_kmh: 20, distance_m: 25, lateral_tenths_mps: 15 };
        let driver = Driver { law: "acc-mpc".into(), aebs: false };
        let scenario = scenario(&Case::CutIn(case), &driver, 1).expect("the case is right");
        let other = &scenario.actors[0];
        let time_s = CRUISE_S + 1.0;
        let gap_m = other.gap_m.value() - time_s * 40.0 / 3.6;
        assert!((gap_m - 25.0).abs() < 1e-9, "{gap_m}");
        let motion = other.lateral[0];
        let lateral_m = |at_s| other.lateral_offset_m.value() * (1.0 - motion.progress(at_s).0);
        assert!((lateral_m(time_s) - 3.5).abs() < 1e-9);
        assert!((lateral_m(time_s + 1.0) - 2.0).abs() < 1e-9);
    }
}
