//! Random drives without faults, of many kinds: a check that finds something in one of them raises a false alarm.
//!
//! | kind | drive |
//! |---|---|
//! | `free-road` | nothing ahead |
//! | `steady-lead` | a lead at constant speed |
//! | `ideal-radar` | a lead at constant speed or in waves, seen by a radar without any error |
//! | `object-list` | a lead in waves, seen by a radar that reports objects |
//! | `wavy-lead` | a lead whose acceleration is a sine |
//! | `braking-lead` | a lead that brakes with 1 to 6 m/s², waits and moves off |
//! | `stop-and-go` | a lead that stops three times |
//! | `cut-in` | a vehicle that comes in and then keeps its speed or brakes |
//! | `pulls-away` | a faster vehicle that comes in close ahead |
//! | `cut-out` | a lead that leaves before a slow or standing vehicle |
//! | `slow-ahead` | a vehicle far ahead that drives up to 20 m/s slower |
//! | `queue-beside` | vehicles that stand or crawl beside the lane |
//! | `passing` | vehicles in both neighbouring lanes, slower and faster |
//! | `clutter` | a lead, seen by a radar with many false detections and losses |
//! | `signals` | a corridor of signals by frames |
//! | `lossy-air` | the same through air that loses, delays and repeats frames |
//! | `truck` | a truck on hills behind a lead |
//! | `cycle` | five minutes behind a lead that drives a standard cycle |
//!
//! A drive is a function of the seed and its number alone; the kinds take turns. The ranges are chosen: as wide as
//! public roads and sold radars are, not fitted to what the checks find.

mod following;
mod neighbours;
mod signals;
mod vehicles;

use controller::laws;
use group::{Error, LawOptions};
use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::plant::Vehicle;
use scenario::{Overrides, Scenario};

/// Selects the draws of this study.
const STREAM: u128 = 0x9a5b_11e7;

/// The kinds of drives, in the order in which they take turns.
pub const KINDS: [(&str, Draw); 18] = [
    ("free-road", following::free_road),
    ("steady-lead", following::steady_lead),
    ("ideal-radar", following::ideal_radar),
    ("object-list", following::object_list),
    ("wavy-lead", following::wavy_lead),
    ("braking-lead", following::braking_lead),
    ("stop-and-go", following::stop_and_go),
    ("cut-in", neighbours::cut_in),
    ("pulls-away", neighbours::pulls_away),
    ("cut-out", neighbours::cut_out),
    ("slow-ahead", neighbours::slow_ahead),
    ("queue-beside", neighbours::queue_beside),
    ("passing", neighbours::passing),
    ("clutter", following::clutter),
    ("signals", signals::signals),
    ("lossy-air", signals::lossy_air),
    ("truck", following::truck),
    ("cycle", following::cycle),
];

/// The scenario file of a drive of one kind, from its random numbers.
pub type Draw = fn(&mut Draws) -> String;

/// The kind of drive `number`, from 0, and the drive. A law of the user's own drives all cars.
///
/// # Errors
/// [`Error::Scenario`]: the generator has made an invalid scenario.
pub fn drive(
    seed: u32,
    number: usize,
    own: &LawOptions,
) -> Result<(&'static str, Scenario), Error> {
    let (kind, scenario) = KINDS[number % KINDS.len()];
    let mut draws = Draws::new(seed, number);
    let text = scenario(&mut draws);
    let name = format!("{kind}-{number}");
    let text = text.replacen("name = \"\"", &format!("name = \"{name}\""), 1);
    let scenario = Scenario::parse_with(&name, &text, &Overrides::new(), &laws::check)?;
    let Some(law) = own.only().filter(|_| scenario.plant.vehicle == Vehicle::Car) else {
        return Ok((kind, scenario));
    };
    let mut overrides = Overrides::new().shared();
    own.lay_over(&mut overrides)?;
    overrides.option("--law", "controller.name", law);
    Ok((kind, Scenario::parse_with(&name, &text, &overrides, &laws::check)?))
}

/// The kind of drive `number`, from 0.
pub fn kind(number: usize) -> &'static str {
    KINDS[number % KINDS.len()].0
}

/// The random numbers of one drive.
#[derive(Debug)]
pub struct Draws {
    random: Pcg64,
    number: usize,
}

impl Draws {
    fn new(seed: u32, number: usize) -> Self {
        let mut random = Pcg64::new(STREAM << 64 | number as u128, seed.into());
        random.next_u64();
        Self { random, number }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * random::uniform(&mut self.random)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.between(0.0, of.len() as f64)) as usize]
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    fn side(&mut self) -> f64 {
        self.one(&[-1.0, 1.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_drive_is_a_scenario_without_faults() {
        for number in 0..20 * KINDS.len() {
            let (kind, scenario) = drive(1, number, &LawOptions::default())
                .unwrap_or_else(|error| panic!("drive {number}: {error}"));
            assert_eq!(kind, KINDS[number % KINDS.len()].0);
            assert!(scenario.faults.is_empty());
        }
    }

    #[test]
    fn seed_and_number_make_the_drive() {
        let own = LawOptions::default();
        let text = |seed, number| drive(seed, number, &own).expect("a scenario").1.to_toml();
        assert_eq!(text(1, 4), text(1, 4));
        assert_ne!(text(1, 4), text(2, 4));
        assert_ne!(text(1, 4), text(1, 4 + KINDS.len()));
    }

    #[test]
    fn a_law_of_the_users_own_drives_every_car_and_no_truck() {
        let own = LawOptions { laws: vec!["mine=cat".parse().expect("a law")] };
        let mut trucks = 0;
        for number in 0..KINDS.len() {
            let (kind, scenario) = drive(1, number, &own).expect("a scenario");
            let (_, plain) = drive(1, number, &LawOptions::default()).expect("a scenario");
            let expected = if kind == "truck" { "predictive" } else { "mine" };
            trucks += usize::from(kind == "truck");
            assert_eq!(scenario.controller.name.as_str(), expected, "{kind}");
            assert_eq!(scenario.actors, plain.actors, "{kind}: the same drive");
        }
        assert_eq!(trucks, 1);
    }
}
