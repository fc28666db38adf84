//! The limits of all populations, in one table. A changed limit is an entry of its own in CHANGELOG.md.

use supervise::ReferenceDriver;

/// The largest accepted value of a figure.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    pub population: &'static str,
    pub figure: &'static str,
    pub most: f64,
    /// Day since when it holds.
    pub since: &'static str,
    pub source: &'static str,
}

const CHOSEN: &str = "chosen";

/// Declares [`ALL`]: `population figure: value, unit, since, source;`.
macro_rules! limits {
    ($($population:literal $figure:literal: $most:expr, $unit:literal, $since:literal, $source:expr;)+) => {
        pub const ALL: &[Limit] = &[$(Limit {
            population: $population, figure: $figure, most: $most, since: $since, source: $source
        },)+];
    };
}

limits! {
    "signals" "beyond_bound_led_s": 0.3, "s", "2026-11-28", "the bound over 100 other corridors";
    "signals" "beyond_bound_free_s": 1.0, "s", "2026-11-28", "the same: 1.2 to 2.0 s are left at each red that ends";
    "signals" "cycles_missed_ratio": 0.5, "", "2026-11-28", CHOSEN;
    "signals" "trip_ratio": 1.0, "", "2026-11-28", "a countdown is worth something";
    "signals" "wrong_trip_ratio": 1.03, "", "2026-11-28", "chosen: lost until they are known to be wrong";
    "curves" "lead_lost.share": LOST_SHARE, "", "2026-11-26", CHOSEN;
    "curves" "lead_lost.roads_share": 0.0, "", "2026-11-28", "the same limit on each road";
    "curves" "lead_lost.per_km": 0.1, "1/km", "2026-11-26", CHOSEN;
    "curves" "neighbour_taken.per_km": 0.1, "1/km", "2026-11-26", CHOSEN;
    "curves" "phantom_interventions": 0.0, "", "2026-11-26", CHOSEN;
    "curves" "braked_share": 0.02, "", "2026-11-28", "an observer of many roads rules them out from 94 m on";
    "curves" "beyond_comfort_share": 0.2, "", "2026-11-28", "that observer decides after 1.6 s in the median";
    "curves" "avoidable_collisions": 0.0, "", "2026-11-26", CHOSEN;
    "curves" "seen_late": 0.0, "", "2026-11-28", "that observer decides after 3.9 s at the latest";
    "everyday" "avoidable": 0.0, "", "2026-11-21", "UN R157, 5.2.5.2";
    "everyday" "needless": 0.0, "", "2026-11-26", CHOSEN;
    "everyday" "alone.avoidable_share": 0.01, "", "2026-11-26", CHOSEN;
    "plausibility" "alarmed": 0.0, "", "2026-11-25", CHOSEN;
}

pub fn of(population: &str) -> impl Iterator<Item = &'static Limit> {
    ALL.iter().filter(move |limit| limit.population == population)
}

// Thresholds of the judges.

/// `curves`: request below which the law brakes as before a vehicle, m/s² (2026-11-26, chosen).
pub const BRAKED_MPS2: f64 = -1.5;
/// `curves`: deceleration from sight that decides whether a collision was avoidable, m/s² (2026-11-26, UN R157,
/// 5.2.5.2).
pub const FROM_SIGHT_MPS2: f64 = 6.0;
/// `curves`: share of the time for which a lead may be lost (2026-11-26, chosen).
pub const LOST_SHARE: f64 = 0.005;
/// `curves`: braking before a queue that is comfortable, m/s² (2026-11-28, the prices of the target selection).
pub const COMFORT_MPS2: f64 = 2.5;
/// `curves`: hardest braking before a queue without the emergency brake, m/s² (2026-11-28, chosen).
pub const HARD_MPS2: f64 = 4.5;
/// `everyday`: braking beyond which there is a need, m/s² (2026-11-26, chosen: the moderate stop of the gateway).
pub const NEED_MPS2: f64 = ReferenceDriver::NEED_MPS2;
/// `everyday`: time from the need until the reference takes over, s (2026-11-21, UN R157, 5.2.5.2: the time in its
/// formula for cut-ins).
pub const REACTION_S: f64 = ReferenceDriver::REGULATION.reaction_s;
/// `everyday`: braking of the reference beside the emergency brake, m/s² (2026-11-21, UN R157, 5.2.5.2: the deceleration
/// in that formula).
pub const REFERENCE_MPS2: f64 = ReferenceDriver::REGULATION.deceleration_mps2;
/// `everyday`: braking with which no intervention was needed, m/s² (2026-11-26, chosen: half of the hardest braking that
/// passengers accept).
pub const GENTLE_MPS2: f64 = 1.5;
