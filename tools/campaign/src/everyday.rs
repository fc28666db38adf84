//! Random scenes of everyday driving, in which the emergency brake is to stay silent, and leads that brake
//! hard, where it is to help.
//!
//! | kind | scene |
//! |---|---|
//! | [`Kind::CutIn`] | a vehicle comes in with 1 to 2.5 s of time gap and at most 3 m/s slower, in 3 to 6 s |
//! | [`Kind::Stop`] | a lead brakes to standstill with 0.5 to 2.5 m/s², waits and moves off |
//! | [`Kind::Pass`] | slower vehicles in both neighbouring lanes wander in theirs and are passed |
//! | [`Kind::BrakingLead`] | after settled following a lead brakes with 3 to 9 m/s² |
//!
//! A scene is a function of its kind and its number alone.

use std::fmt::Write;

use controller::laws;
use group::{Drive, DriveStep, Error};
use rand_core::Rng;
use rand_pcg::Pcg64;
use report::summary::Summary;
use runtime::Mode;
use runtime::report::Outcome;
use scenario::{Overrides, Scenario};

/// Time before a scene begins, in which the law settles, s.
const SETTLE_S: f64 = 20.0;
/// Reaction time of the yardstick for braking leads, s.
const REACTION_S: f64 = 0.35;
/// Deceleration of the yardstick, m/s².
const YARDSTICK_MPS2: f64 = 6.0;

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Kind {
    /// A comfortable cut-in.
    CutIn,
    /// A comfortable stop behind a lead.
    Stop,
    /// Slower traffic in the neighbouring lanes.
    Pass,
    /// A lead that brakes hard.
    BrakingLead,
}

/// What came of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The ego touched another vehicle.
    pub collided: bool,
    /// 6 m/s², 0.35 s after a braking lead's onset, would have avoided that.
    pub avoidable: bool,
    /// Times that the emergency brake braked.
    pub interventions: u64,
}

/// The draws of one scene.
struct Draws(Pcg64);

impl Draws {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn side(&mut self) -> f64 {
        if self.0.next_u64().is_multiple_of(2) { 1.0 } else { -1.0 }
    }
}

impl Kind {
    /// Scene number `number` for `law`, with the emergency brake or without.
    ///
    /// # Errors
    /// [`Error::Scenario`] if there is no such law.
    pub fn scenario(self, number: u32, law: &str, aebs: bool) -> Result<Scenario, Error> {
        let mut draws = Draws(Pcg64::new(u128::from(number), 0x1501 + self as u128));
        let (speed_mps, set_mps, duration_s, actors) = match self {
            Self::CutIn => cut_in(&mut draws),
            Self::Stop => stop(&mut draws),
            Self::Pass => pass(&mut draws),
            Self::BrakingLead => braking_lead(&mut draws),
        };
        let text = format!(
            "schema_version = 1\nname = \"everyday\"\nduration_s = {duration_s}\nseed = {number}\n\
             set_speed_mps = {set_mps}\n\
             [plant]\ninitial_speed_mps = {speed_mps}\n\
             powertrain = {{ mass_kg = 1600, max_power_kw = 110 }}\n\
             [aebs]\nenabled = {aebs}\n\
             [controller]\nname = \"{law}\"\n{actors}"
        );
        Ok(Scenario::parse_with("everyday", &text, &Overrides::new(), &laws::check)?)
    }

    /// Drives `scenario`, a scene of this kind, in this thread.
    ///
    /// # Errors
    /// What keeps the run from beginning.
    pub fn drive(self, scenario: &Scenario) -> Result<Verdict, Error> {
        let group = group::in_process::run(scenario)?;
        let summary = Summary::new(scenario, Mode::Lockstep, &group, group.ran_for);
        let collided = summary.outcome == Outcome::Collision;
        Ok(Verdict {
            collided,
            avoidable: collided && self == Self::BrakingLead && avoids(&group.drive),
            interventions: summary.aebs.interventions.unwrap_or(0),
        })
    }
}

type Scene = (f64, f64, f64, String);

fn actor(text: &mut String, name: &str, gap_m: f64, keys: &str) {
    writeln!(text, "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m}\n{keys}")
        .expect("a string takes all");
}

fn cut_in(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(12.0, 36.0);
    let slower_mps = draws.between(-4.0, 3.0);
    let time_gap_s = draws.between(1.0, 2.5);
    let duration_s = draws.between(3.0, 6.0);
    let begins_s = draws.between(2.0, 4.0);
    let other_mps = speed_mps - slower_mps;
    // The gap is that at the end of the motion.
    let gap_m = time_gap_s * speed_mps + 2.0 + slower_mps.max(0.0) * (begins_s + duration_s);
    let lateral_m = 3.5 * draws.side();
    let keys = format!(
        "initial_speed_mps = {other_mps}\nlateral_offset_m = {lateral_m}\n\
         lateral = [{{ time_s = {begins_s}, to_m = 0, duration_s = {duration_s} }}]"
    );
    let mut actors = String::new();
    actor(&mut actors, "other", gap_m, &keys);
    (speed_mps, speed_mps, begins_s + duration_s + 10.0, actors)
}

fn stop(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(8.0, 30.0);
    let braking_mps2 = draws.between(0.5, 2.5);
    let going_mps2 = draws.between(0.5, 1.5);
    let stands_s = SETTLE_S + speed_mps / braking_mps2;
    let goes_s = stands_s + draws.between(2.0, 5.0);
    let keys = format!(
        "initial_speed_mps = {speed_mps}\nprofile.steps = [\
         {{ time_s = {SETTLE_S}, speed_mps = 0, acceleration_mps2 = {braking_mps2} }}, \
         {{ time_s = {goes_s}, speed_mps = {speed_mps}, acceleration_mps2 = {going_mps2} }}]"
    );
    let mut actors = String::new();
    actor(&mut actors, "lead", 2.0 * speed_mps + 6.0, &keys);
    (speed_mps, speed_mps + 4.0, goes_s + 10.0, actors)
}

fn pass(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(15.0, 36.0);
    let mut actors = String::new();
    let mut gap_m = 40.0;
    for (number, side) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
        let other_mps = speed_mps - draws.between(2.0, 12.0);
        let lateral_m = side * draws.between(3.2, 3.8);
        let near_m = side * draws.between(3.0, 3.5);
        let at_s = draws.between(1.0, 8.0);
        let keys = format!(
            "initial_speed_mps = {other_mps}\nlateral_offset_m = {lateral_m}\nlateral = [\
             {{ time_s = {at_s}, to_m = {near_m}, duration_s = 3 }}, \
             {{ time_s = {}, to_m = {lateral_m}, duration_s = 3 }}]",
            at_s + 4.0,
        );
        actor(&mut actors, &format!("lane-{number}"), gap_m, &keys);
        gap_m += draws.between(10.0, 40.0);
    }
    (speed_mps, speed_mps, 20.0, actors)
}

fn braking_lead(draws: &mut Draws) -> Scene {
    let braking_mps2 = draws.between(3.0, 9.0);
    let speed_mps = draws.between(8.0, 36.0);
    let keys = format!(
        "initial_speed_mps = {speed_mps}\nprofile.steps = [\
         {{ time_s = {SETTLE_S}, speed_mps = 0, acceleration_mps2 = {braking_mps2} }}]"
    );
    let mut actors = String::new();
    actor(&mut actors, "lead", 2.0 * speed_mps + 6.0, &keys);
    (speed_mps, speed_mps + 4.0, SETTLE_S + speed_mps / 2.5 + 6.0, actors)
}

/// Whether the yardstick stays behind a lead that brakes from [`SETTLE_S`] on.
fn avoids(drive: &Drive) -> bool {
    let begins = |step: &DriveStep| step.time_s > SETTLE_S - 1e-6 && step.gap_m.is_some();
    let Some(begun) = drive.steps.iter().position(begins) else { return false };
    let from = &drive.steps[begun];
    let (mut speed_mps, mut way_m, mut before_s) = (from.speed_mps, 0.0, from.time_s);
    let mut lead_m = from.gap_m.unwrap_or(f64::INFINITY);
    let Some(mut lead_mps) = from.lead_speed_mps else { return true };
    for step in &drive.steps[begun..] {
        let dt_s = step.time_s - before_s;
        before_s = step.time_s;
        let brakes = step.time_s - from.time_s > REACTION_S;
        let next_mps =
            if brakes { (speed_mps - YARDSTICK_MPS2 * dt_s).max(0.0) } else { speed_mps };
        way_m += 0.5 * dt_s * (speed_mps + next_mps);
        speed_mps = next_mps;
        let lead_next_mps = step.lead_speed_mps.unwrap_or(lead_mps);
        lead_m += 0.5 * dt_s * (lead_mps + lead_next_mps);
        lead_mps = lead_next_mps;
        if way_m >= lead_m {
            return false;
        }
    }
    // The drive ended with a contact: from there on both brake to standstill as they do.
    let last_s = drive.steps.last().map_or(0.0, |step| step.time_s);
    let lead_braking = (drive.steps[begun].lead_speed_mps.unwrap_or(0.0) - lead_mps)
        / (last_s - from.time_s).max(0.01);
    let lead_stop_m =
        if lead_braking > 0.1 { lead_mps * lead_mps / (2.0 * lead_braking) } else { 0.0 };
    way_m + speed_mps * speed_mps / (2.0 * YARDSTICK_MPS2) < lead_m + lead_stop_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_a_scenario_and_a_function_of_its_number() {
        for kind in [Kind::CutIn, Kind::Stop, Kind::Pass, Kind::BrakingLead] {
            for number in 0..200 {
                let scene = |number| {
                    kind.scenario(number, "acc-mpc", true).unwrap_or_else(|error| panic!("{error}"))
                };
                assert_eq!(scene(number), scene(number));
                assert_ne!(scene(number), scene(number + 1), "{kind:?} {number}");
            }
        }
    }
}
