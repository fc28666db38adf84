//! A case as a scenario for a control law.
//!
//! The ego drives at the case's speed, which is also the set speed. All vehicles have the regulation's length. Behind a
//! lead the ego begins at the gap that its law keeps there. With that set speed a law has no reason to close up from a
//! larger gap, so the gap is found by one drive for each law and speed. The run ends when no contact can follow any
//! more.

use std::collections::BTreeMap;
use std::sync::Mutex;

use frame::{DriveOptions, batch};
use scenario::{Scenario, Setting, Table, table};
use supervise::{Error, GroupOptions};

use super::matrix::Case;
use crate::cut_in::{CLEARANCE_M, LATERAL_ACCELERATION_MPS2};
use crate::{STEP_S, VEHICLE_LENGTH_M, VEHICLE_WIDTH_M, cut_in, cut_out, following, mps};

/// Time before a cut-in: the ego drives alone, and sees the other.
const CRUISE_S: f64 = 3.0;
/// Time before a lead brakes or leaves. Law and emergency brake need it to settle; the tracker has the lead from the
/// start. It is long enough. After 25 s gap, speed and acceleration differ by at most 0.05 m, 0.11 m/s and 0.03 m/s².
const RUN_IN_S: f64 = 2.0;
/// Time after which the ego stands or has matched the speed, from the last point at which something can happen.
const AFTER_S: f64 = 4.0;
/// Deceleration by which every law stops at the latest.
const GENTLE_MPS2: f64 = 2.5;
/// Time for which the ego is clear of all others before a run ends, s. It is five cycles of every law, so that a law
/// that turns back to another vehicle shows it.
const CLEAR_S: f64 = 0.5;
/// Time in which a law closes up or falls back to its own gap, s.
const CLOSES_UP_S: f64 = 25.0;
/// Time gap and distance from which it does.
const FIRST_TIME_GAP_S: f64 = 2.0;
const FIRST_DISTANCE_M: f64 = 5.0;

/// The common part of a study's drives, and the gaps that were found so far.
#[derive(Debug, Default)]
pub struct Scenes {
    pub seed: u64,
    pub drives: DriveOptions,
    /// By law and speed, km/h.
    gaps_m: Mutex<BTreeMap<(String, u32), f64>>,
}

struct Traffic {
    /// Time after which nothing scripted comes any more, s.
    scripted_s: f64,
    duration_s: f64,
    actors: Vec<Table>,
}

impl Scenes {
    pub fn new(seed: u64, drives: DriveOptions) -> Self {
        Self { seed, drives, gaps_m: Mutex::default() }
    }

    /// The scenario of `case` for a law, with the emergency brake or without it.
    pub fn scenario(&self, case: &Case, law: &str, aebs: bool) -> Result<Scenario, Error> {
        let gap_m = || self.gap_m(law, case.ego_kmh());
        let traffic = match case {
            Case::CutIn(case) => cut_in(case),
            Case::Following(case) => following(case, gap_m()?),
            Case::CutOut(case) => cut_out(case, gap_m()?),
        };
        self.drive(traffic, case.ego_kmh(), law, aebs)
    }

    /// The gap that `law` keeps at `speed_kmh`, m. The first to ask drives; two at once drive the same.
    pub fn gap_m(&self, law: &str, speed_kmh: u32) -> Result<f64, Error> {
        let key = (law.to_owned(), speed_kmh);
        if let Some(gap_m) = self.gaps_m.lock().expect("no drive panics here").get(&key) {
            return Ok(*gap_m);
        }
        let scenario = self.behind_a_lead(law, speed_kmh)?;
        let group = GroupOptions { programs: Vec::new(), ready_timeout: 1.0, processes: false };
        let done = batch::lockstep(&scenario, &group, &|| true)?;
        batch::whole(&done.summary)?;
        let last = done.drive.steps.iter().rev().find_map(|step| step.gap_m);
        let gap_m = last.expect("the lead is ahead");
        self.gaps_m.lock().expect("no drive panics here").insert(key, gap_m);
        Ok(gap_m)
    }

    fn behind_a_lead(&self, law: &str, speed_kmh: u32) -> Result<Scenario, Error> {
        let speed_mps = mps(speed_kmh);
        let gap_m = FIRST_TIME_GAP_S * speed_mps + FIRST_DISTANCE_M;
        let actors = vec![actor("lead", gap_m, table! { initial_speed_mps: speed_mps })];
        let traffic = Traffic { scripted_s: CLOSES_UP_S, duration_s: CLOSES_UP_S, actors };
        self.drive(traffic, speed_kmh, law, false)
    }

    fn drive(
        &self,
        traffic: Traffic,
        speed_kmh: u32,
        law: &str,
        aebs: bool,
    ) -> Result<Scenario, Error> {
        let Traffic { scripted_s, duration_s, actors } = traffic;
        let speed_mps = mps(speed_kmh);
        let plant = table! {
            initial_speed_mps: speed_mps,
            length_m: VEHICLE_LENGTH_M,
            powertrain: table! { mass_kg: 1600, max_power_kw: 110 },
        };
        let ends = table! { after_s: scripted_s, for_s: CLEAR_S };
        self.drives.scenario(&[
            Setting::new("name", "r157"),
            Setting::new("duration_s", duration_s),
            Setting::new("seed", self.seed as i64),
            Setting::new("set_speed_mps", speed_mps),
            Setting::new("actors", actors),
            Setting::new("plant", plant),
            Setting::new("aebs.enabled", aebs),
            Setting::new("referee.ends_when_clear", ends),
            Setting::new("controller.name", law),
        ])
    }
}

/// A vehicle `gap_m` ahead of the ego, with these keys.
fn actor(name: &str, gap_m: f64, keys: Table) -> Table {
    let mut actor = table! { name: name, gap_m: gap_m, length_m: VEHICLE_LENGTH_M };
    actor.extend(keys);
    actor
}

/// The vehicle that comes in. It keeps its speed, so that a motion aside has no part in whether the ego comes nearer.
fn cut_in(case: &cut_in::Case) -> Traffic {
    let other_mps = mps(case.other_kmh);
    let closing_mps = mps(case.ego_kmh) - other_mps;
    let lateral_mps = case.lateral_mps();
    let rise_s = lateral_mps / LATERAL_ACCELERATION_MPS2;
    let lane_m = CLEARANCE_M + VEHICLE_WIDTH_M;
    let start_m = lane_m + lateral_mps * rise_s / 2.0;
    let gap_m = f64::from(case.distance_m) + closing_mps * (CRUISE_S + rise_s);
    // Time from the case's distance until the sides overlap; without lateral speed until it is passed.
    let passed_s = (f64::from(case.distance_m) + 2.0 * VEHICLE_LENGTH_M) / closing_mps;
    let overlap_s = if lateral_mps > 0.0 { CLEARANCE_M / lateral_mps } else { passed_s };
    let duration_s = CRUISE_S + rise_s + overlap_s + closing_mps / GENTLE_MPS2 + AFTER_S;
    let mut keys = table! { initial_speed_mps: other_mps, lateral_offset_m: start_m };
    if lateral_mps > 0.0 {
        let lasts_s = rise_s + lane_m / lateral_mps;
        let comes = table! { time_s: CRUISE_S, to_m: 0, duration_s: lasts_s, rise_s: rise_s };
        keys.extend(table! { lateral: vec![comes] });
    }
    let actors = vec![actor("other", gap_m, keys)];
    Traffic { scripted_s: CRUISE_S + rise_s, duration_s, actors }
}

fn following(case: &following::Case, gap_m: f64) -> Traffic {
    let (speed_mps, deceleration_mps2) = (mps(case.speed_kmh), case.lead_deceleration_mps2());
    let stop_s = speed_mps / deceleration_mps2.min(GENTLE_MPS2);
    let brakes = table! { time_s: RUN_IN_S, acceleration_mps2: -deceleration_mps2 };
    let profile = table! { piecewise: vec![brakes] };
    let keys = table! { initial_speed_mps: speed_mps, profile: profile };
    Traffic {
        scripted_s: RUN_IN_S + speed_mps / deceleration_mps2,
        duration_s: RUN_IN_S + stop_s + AFTER_S,
        actors: vec![actor("lead", gap_m, keys)],
    }
}

/// The lead that leaves and the vehicle that stands in front of it. A lead that does not get past in the matrix's steps
/// stands where it touches the other.
fn cut_out(case: &cut_out::Case, gap_m: f64) -> Traffic {
    let (speed_mps, lateral_mps) = (mps(case.speed_kmh), case.lateral_mps());
    let standing_distance_m = f64::from(case.standing_distance_m);
    let standing_m = gap_m + VEHICLE_LENGTH_M + speed_mps * RUN_IN_S + standing_distance_m;
    let hits = case.lead_hits();
    let leaves_s = match hits {
        true => standing_distance_m / speed_mps,
        false => (VEHICLE_WIDTH_M + CLEARANCE_M) / lateral_mps,
    };
    let end_s = RUN_IN_S + leaves_s;
    let mut keys = if hits {
        let stands_s = end_s + STEP_S / 10.0;
        let speeds = [[0.0, speed_mps], [end_s, speed_mps], [stands_s, 0.0]];
        table! { profile: table! { speeds: speeds.map(Vec::from).to_vec() } }
    } else {
        table! { initial_speed_mps: speed_mps }
    };
    let to_m = lateral_mps * leaves_s;
    let leaves = table! { time_s: RUN_IN_S, to_m: to_m, duration_s: leaves_s, rise_s: 0 };
    keys.extend(table! { lateral: vec![leaves] });
    let standing = actor("standing", standing_m, table! { initial_speed_mps: 0 });
    let actors = vec![actor("lead", gap_m, keys), standing];
    let distance_m = gap_m + standing_distance_m + VEHICLE_LENGTH_M;
    let duration_s = RUN_IN_S + distance_m / speed_mps + speed_mps / GENTLE_MPS2 + AFTER_S;
    Traffic { scripted_s: end_s + STEP_S, duration_s, actors }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;
    use controller::laws;
    use perception_sim::radar::scene::Ego;
    use perception_sim::traffic::Traffic;

    use super::super::matrix::Matrix;
    use super::*;

    fn scenes() -> Scenes {
        Scenes::new(1, DriveOptions::default())
    }

    #[test]
    fn every_case_is_a_scenario() {
        let scenes = scenes();
        for matrix in Matrix::value_variants() {
            for case in matrix.cases().iter().step_by(97) {
                let scenario = scenes.scenario(case, "acc-mpc", false);
                let scenario = scenario.unwrap_or_else(|error| panic!("{error}"));
                assert!(scenario.duration_s.value() < 100.0, "{case:?}");
            }
        }
    }

    #[test]
    fn an_unknown_law_is_refused() {
        for matrix in Matrix::value_variants() {
            let refused = scenes().scenario(&matrix.cases()[0], "acc", false);
            let refused = refused.expect_err("no such law");
            assert!(refused.to_string().contains("acc-mpc"), "{refused}");
        }
    }

    #[test]
    fn a_cut_in_is_at_its_distance_when_it_has_its_lateral_speed() {
        let case =
            cut_in::Case { ego_kmh: 60, other_kmh: 20, distance_m: 25, lateral_tenths_mps: 15 };
        let scenario = scenes().scenario(&Case::CutIn(case), "acc-mpc", false);
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
            let scenario = scenes().scenario(&Case::CutOut(case), "acc-mpc", false);
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
        let group = supervise::in_process::run_watched(
            scenario,
            runtime::Sealing::Unsealed,
            &|| false,
            &mut |_| {},
        )
        .expect("it runs");
        let steps = group.drive.steps.iter().take_while(|step| step.time_s <= time_s + 1e-9);
        let last = steps.filter(|step| step.gap_m.is_some()).last().expect("it has begun");
        [last.gap_m.expect("there is a lead"), last.speed_mps, last.acceleration_mps2]
    }

    #[test]
    fn the_state_at_the_onset_is_the_one_after_a_long_time_behind_the_lead() {
        for law in laws::driving(false) {
            let scenes = scenes();
            for speed_kmh in [12, 30, 60, 90, 128] {
                let long = scenes.behind_a_lead(law.name, speed_kmh).expect("a law");
                let long = state_at(&long, CLOSES_UP_S);
                let case = following::Case { speed_kmh, lead_hundredths_g: 50 };
                let case = scenes.scenario(&Case::Following(case), law.name, false).expect("a law");
                let onset = state_at(&case, RUN_IN_S);
                for (i, most) in [0.05, 0.11, 0.03].into_iter().enumerate() {
                    let off = (onset[i] - long[i]).abs();
                    assert!(off < most, "{} at {speed_kmh}: {onset:?} {long:?}", law.name);
                }
            }
        }
    }
}
