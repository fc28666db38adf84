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

use crate::signals::corridor;
use controller::laws;
use group::Error;
use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::{Overrides, Scenario};
use std::fmt::Write;

/// Selects the draws of this study.
const STREAM: u128 = 0x9a5b_11e7;
/// Lane width, m.
const LANE_M: f64 = 3.5;

/// The kinds of drives, in the order in which they take turns.
pub const KINDS: [(&str, Draw); 18] = [
    ("free-road", free_road),
    ("steady-lead", steady_lead),
    ("ideal-radar", ideal_radar),
    ("object-list", object_list),
    ("wavy-lead", wavy_lead),
    ("braking-lead", braking_lead),
    ("stop-and-go", stop_and_go),
    ("cut-in", cut_in),
    ("pulls-away", pulls_away),
    ("cut-out", cut_out),
    ("slow-ahead", slow_ahead),
    ("queue-beside", queue_beside),
    ("passing", passing),
    ("clutter", clutter),
    ("signals", signals),
    ("lossy-air", lossy_air),
    ("truck", truck),
    ("cycle", cycle),
];

/// Laws that drive a car without signals.
const LAWS: [&str; 4] = ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded"];

/// The scenario file of a drive of one kind, from its random numbers.
pub type Draw = fn(&mut Draws) -> String;

/// The kind of drive `number`, from 0, and the drive.
///
/// # Errors
/// [`Error::Scenario`]: the generator has made an invalid scenario.
pub fn drive(seed: u32, number: usize) -> Result<(&'static str, Scenario), Error> {
    let (kind, scenario) = KINDS[number % KINDS.len()];
    let mut draws = Draws::new(seed, number);
    let text = scenario(&mut draws);
    let name = format!("{kind}-{number}");
    let text = text.replacen("name = \"\"", &format!("name = \"{name}\""), 1);
    Ok((kind, Scenario::parse_with(&name, &text, &Overrides::new(), &laws::check)?))
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

/// The common part of all kinds: vehicle, radar and law.
fn head(draws: &mut Draws, duration_s: f64, speed_mps: f64, set_mps: f64) -> String {
    let law = draws.one(&LAWS);
    let latency_ms = draws.one(&[0, 50, 100]);
    let dropout = if draws.chance(0.5) { draws.between(0.0, 0.1) } else { 0.0 };
    let radar = format!(
        "[perception.radar]\nlatency_ms = {latency_ms}\ndropout_probability = {dropout:.3}\n"
    );
    let roadside = format!(
        "[perception.radar.detections]\nstanding_objects_per_km = {:.1}\nguard_rail_share = {:.2}\n\
         false_alarms_per_scan = {:.2}\n",
        draws.between(0.0, 120.0),
        draws.between(0.0, 1.0),
        draws.between(0.0, 3.0),
    );
    let seen = radar + &roadside;
    with_radar(draws, (duration_s, speed_mps, set_mps), law, &seen)
}

/// A car with this law and this radar.
fn with_radar(
    draws: &mut Draws,
    (duration_s, speed_mps, set_mps): (f64, f64, f64),
    law: &str,
    radar: &str,
) -> String {
    format!(
        "schema_version = 1\nname = \"\"\nduration_s = {duration_s:.1}\nseed = {}\nset_speed_mps = {set_mps:.2}\n\
         [plant]\ninitial_speed_mps = {speed_mps:.2}\npowertrain = {{ mass_kg = {:.0}, max_power_kw = {:.0} }}\n\
         actuator_time_constant_s = {:.2}\n{radar}[controller]\nname = \"{law}\"\n",
        draws.number + 1,
        draws.between(1_000.0, 2_500.0),
        draws.between(60.0, 200.0),
        draws.between(0.2, 0.6),
    )
}

/// A vehicle; `keys` are its other lines.
fn actor(text: &mut String, name: &str, gap_m: f64, keys: &str) {
    writeln!(text, "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m:.2}\n{keys}")
        .expect("a string takes all");
}

/// A lead with this profile, at a settled gap.
fn led(draws: &mut Draws, text: &mut String, speed_mps: f64, profile: &str) {
    let gap_m = 5.0 + draws.between(1.2, 3.0) * speed_mps;
    let length_m = draws.one(&[4.5, 4.5, 12.0, 16.5]);
    let keys = format!("initial_speed_mps = {speed_mps:.2}\nlength_m = {length_m}\n{profile}");
    actor(text, "lead", gap_m, &keys);
}

fn free_road(draws: &mut Draws) -> String {
    let (speed_mps, set_mps) = (draws.between(0.0, 36.0), draws.between(8.0, 38.0));
    head(draws, 60.0, speed_mps, set_mps)
}

fn steady_lead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(3.0, 34.0);
    let mut text = head(draws, 60.0, speed_mps, speed_mps + 3.0);
    led(draws, &mut text, speed_mps, "");
    text
}

/// Waves of a lead around `speed_mps`.
fn waves(draws: &mut Draws, speed_mps: f64) -> String {
    let period_s = draws.between(6.0, 40.0);
    // Half of the speed's swing is amplitude x period / pi: the lead does not stop.
    let most_mps2 = (2.5 * speed_mps / period_s).min(2.5);
    let amplitude_mps2 = draws.between(0.1 * most_mps2, most_mps2);
    format!(
        "profile.sine = {{ amplitude_mps2 = {amplitude_mps2:.3}, period_s = {period_s:.2}, start_s = {:.1} }}",
        draws.between(0.0, 10.0)
    )
}

fn ideal_radar(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = "[perception]\nideal = true\n";
    let mut text = with_radar(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    let profile = if draws.chance(0.5) { String::new() } else { waves(draws, speed_mps) };
    led(draws, &mut text, speed_mps, &profile);
    text
}

fn object_list(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = format!(
        "[perception.radar]\nmodel = \"object-list\"\nlatency_ms = {}\nrange_sigma_m = {:.2}\n\
         range_rate_sigma_mps = {:.3}\n",
        draws.one(&[0, 50, 100]),
        draws.between(0.05, 0.8),
        draws.between(0.03, 0.3),
    );
    let mut text = with_radar(draws, (60.0, speed_mps, speed_mps + 3.0), law, &radar);
    let profile = waves(draws, speed_mps);
    led(draws, &mut text, speed_mps, &profile);
    text
}

fn wavy_lead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let mut text = head(draws, 80.0, speed_mps, speed_mps + 8.0);
    let profile = waves(draws, speed_mps);
    led(draws, &mut text, speed_mps, &profile);
    text
}

fn braking_lead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 32.0);
    let (begins_s, braking_mps2) = (draws.between(8.0, 20.0), draws.between(1.0, 6.0));
    let low_mps = if draws.chance(0.5) { 0.0 } else { draws.between(0.0, 0.8) * speed_mps };
    let goes_s = begins_s + (speed_mps - low_mps) / braking_mps2 + draws.between(1.0, 8.0);
    let profile = format!(
        "profile.steps = [{{ time_s = {begins_s:.2}, speed_mps = {low_mps:.2}, acceleration_mps2 = {braking_mps2:.2} }}, \
         {{ time_s = {goes_s:.2}, speed_mps = {speed_mps:.2}, acceleration_mps2 = {:.2} }}]",
        draws.between(0.5, 2.5)
    );
    let mut text = head(draws, goes_s + 15.0, speed_mps, speed_mps + 4.0);
    led(draws, &mut text, speed_mps, &profile);
    text
}

fn stop_and_go(draws: &mut Draws) -> String {
    let speed_mps = draws.between(4.0, 15.0);
    let mut time_s = draws.between(4.0, 10.0);
    let mut steps = Vec::new();
    for _ in 0..3 {
        for to_mps in [0.0, speed_mps] {
            let rate_mps2 = draws.between(0.6, 2.5);
            steps.push(format!(
                "{{ time_s = {time_s:.2}, speed_mps = {to_mps:.2}, acceleration_mps2 = {rate_mps2:.2} }}"
            ));
            time_s += speed_mps / rate_mps2 + draws.between(1.0, 8.0);
        }
    }
    let mut text = head(draws, time_s + 5.0, speed_mps, speed_mps + 6.0);
    let profile = format!("profile.steps = [{}]", steps.join(", "));
    led(draws, &mut text, speed_mps, &profile);
    text
}

/// A vehicle that comes in from a neighbouring lane: its speed, the gap when it is in, and what it does then.
fn comes_in(draws: &mut Draws, speed_mps: f64, other_mps: f64, gap_m: f64, brakes: bool) -> String {
    let (begins_s, takes_s) = (draws.between(3.0, 15.0), draws.between(1.5, 6.0));
    let in_s = begins_s + takes_s;
    let start_m = (gap_m + (speed_mps - other_mps) * in_s).max(0.0);
    let mut keys = format!(
        "initial_speed_mps = {other_mps:.2}\nlateral_offset_m = {:.2}\n\
         lateral = [{{ time_s = {begins_s:.2}, to_m = 0, duration_s = {takes_s:.2} }}]",
        draws.side() * LANE_M
    );
    if brakes {
        write!(
            keys,
            "\nprofile.steps = [{{ time_s = {:.2}, speed_mps = {:.2}, acceleration_mps2 = {:.2} }}]",
            in_s + draws.between(0.0, 3.0),
            other_mps * draws.between(0.0, 0.7),
            draws.between(0.5, 3.0)
        )
        .expect("a string takes all");
    }
    let mut text = head(draws, in_s + 25.0, speed_mps, speed_mps + 1.0);
    actor(&mut text, "other", start_m, &keys);
    text
}

fn cut_in(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 34.0);
    let other_mps = (speed_mps - draws.between(-2.0, 6.0)).max(3.0);
    let gap_m = 3.0 + draws.between(0.8, 2.5) * speed_mps;
    let brakes = draws.chance(0.4);
    comes_in(draws, speed_mps, other_mps, gap_m, brakes)
}

fn pulls_away(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 30.0);
    let other_mps = speed_mps + draws.between(2.0, 8.0);
    let gap_m = draws.between(6.0, 25.0) + 0.3 * speed_mps;
    // A faster vehicle comes from behind: it appears beside the ego, so its gap grows from the start.
    let (appears_s, takes_s) = (draws.between(2.0, 12.0), draws.between(1.5, 4.0));
    let keys = format!(
        "initial_speed_mps = {other_mps:.2}\nlateral_offset_m = {:.2}\nappears_at_s = {appears_s:.2}\n\
         lateral = [{{ time_s = {:.2}, to_m = 0, duration_s = {takes_s:.2} }}]",
        draws.side() * LANE_M,
        appears_s + 1.0
    );
    let mut text = head(draws, appears_s + 25.0, speed_mps, speed_mps + 2.0);
    actor(&mut text, "other", gap_m, &keys);
    text
}

fn cut_out(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 30.0);
    let gap_m = 4.0 + 1.8 * speed_mps;
    let (begins_s, takes_s) = (draws.between(10.0, 20.0), draws.between(1.5, 4.0));
    let keys = format!(
        "initial_speed_mps = {speed_mps:.2}\n\
         lateral = [{{ time_s = {begins_s:.2}, to_m = {:.2}, duration_s = {takes_s:.2} }}]",
        draws.side() * LANE_M
    );
    let slow_mps = if draws.chance(0.4) { 0.0 } else { draws.between(0.0, 0.7) * speed_mps };
    // The slow vehicle is this far ahead of the lead when the lead has left.
    let ahead_m = draws.between(2.0, 5.0) * speed_mps;
    let slow_m = gap_m + 5.0 + ahead_m + (speed_mps - slow_mps) * (begins_s + takes_s);
    let mut text = head(draws, begins_s + 30.0, speed_mps, speed_mps + 2.0);
    actor(&mut text, "lead", gap_m, &keys);
    actor(&mut text, "slow", slow_m, &format!("initial_speed_mps = {slow_mps:.2}"));
    text
}

fn slow_ahead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(12.0, 34.0);
    let slow_mps = (speed_mps - draws.between(2.0, 20.0)).max(0.0);
    let gap_m = draws.between(100.0, 400.0);
    let mut text = head(draws, 50.0, speed_mps, speed_mps);
    actor(&mut text, "slow", gap_m, &format!("initial_speed_mps = {slow_mps:.2}"));
    text
}

fn queue_beside(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 25.0);
    let crawl_mps = draws.one(&[0.0, 0.5, 1.5, 3.0, 5.0]);
    let mut text = head(draws, 40.0, speed_mps, speed_mps);
    let (mut place_m, side) = (draws.between(30.0, 120.0), draws.side());
    let is_double = draws.chance(0.3);
    // A scenario takes eight actors, and one may lead.
    for number in 0..7 {
        let side = if is_double && number % 2 == 1 { -side } else { side };
        let keys = format!(
            "initial_speed_mps = {crawl_mps}\nlateral_offset_m = {:.2}\nlength_m = {}",
            side * draws.between(3.1, 3.8),
            draws.one(&[4.5, 4.5, 4.5, 12.0])
        );
        actor(&mut text, &format!("queue-{number}"), place_m, &keys);
        place_m += 12.5 + draws.between(1.0, 8.0);
    }
    if draws.chance(0.4) {
        led(draws, &mut text, speed_mps, "");
    }
    text
}

fn passing(draws: &mut Draws) -> String {
    let speed_mps = draws.between(12.0, 34.0);
    let mut text = head(draws, 40.0, speed_mps, speed_mps);
    let mut place_m = draws.between(5.0, 30.0);
    for (number, side) in [1.0, -1.0, 1.0, -1.0, 1.0].into_iter().enumerate() {
        let other_mps = (speed_mps + draws.between(-12.0, 8.0)).max(1.0);
        let (lateral_m, near_m) = (side * draws.between(3.2, 3.8), side * draws.between(2.9, 3.5));
        let at_s = draws.between(1.0, 20.0);
        let keys = format!(
            "initial_speed_mps = {other_mps:.2}\nlateral_offset_m = {lateral_m:.2}\n\
             lateral = [{{ time_s = {at_s:.2}, to_m = {near_m:.2}, duration_s = 3 }}, \
             {{ time_s = {:.2}, to_m = {lateral_m:.2}, duration_s = 3 }}]",
            at_s + 4.0
        );
        actor(&mut text, &format!("lane-{number}"), place_m, &keys);
        place_m += draws.between(10.0, 50.0);
    }
    if draws.chance(0.5) {
        led(draws, &mut text, speed_mps, "");
    }
    text
}

fn clutter(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = format!(
        "[perception.radar]\nlatency_ms = 50\ndropout_probability = {:.3}\n[perception.radar.detections]\n\
         false_alarms_per_scan = {:.1}\nsnr_at_100_m_db = {:.1}\nstanding_objects_per_km = {:.0}\nguard_rail_share = 1\n",
        draws.between(0.0, 0.3),
        draws.between(1.0, 10.0),
        draws.between(8.0, 15.0),
        draws.between(50.0, 300.0),
    );
    let mut text = with_radar(draws, (60.0, speed_mps, speed_mps + 3.0), law, &radar);
    let profile = waves(draws, speed_mps);
    led(draws, &mut text, speed_mps, &profile);
    text
}

fn signals(draws: &mut Draws) -> String {
    let law = draws.one(&["cacc-mpc", "acc-signal-stop"]);
    corridor(draws.random.next_u32().into(), law)
}

fn lossy_air(draws: &mut Draws) -> String {
    let mut text = corridor(draws.random.next_u32().into(), "cacc-mpc");
    write!(
        text,
        "[v2x.air]\nloss_probability = {:.2}\ndelay_ms = {:.0}\njitter_ms = {:.0}\nduplicate_probability = {:.2}\n\
         reorder_probability = {:.2}\nreorder_ms = {:.0}\n[v2x.obu]\nclock_offset_ms = {:.0}\n",
        draws.between(0.0, 0.6),
        draws.between(0.0, 300.0),
        draws.between(0.0, 200.0),
        draws.between(0.0, 0.3),
        draws.between(0.0, 0.3),
        draws.between(0.0, 500.0),
        draws.between(-150.0, 150.0),
    )
    .expect("a string takes all");
    text
}

fn truck(draws: &mut Draws) -> String {
    let speed_mps = draws.between(15.0, 25.0);
    let model = draws.one(&["object-list", "detections"]);
    let filter = draws.one(&["singer", "interacting-models"]);
    let mut text = format!(
        "schema_version = 1\nname = \"\"\nduration_s = 100\nseed = {}\nset_speed_mps = {:.2}\n\
         [plant]\nvehicle = \"{}\"\nperiod_ms = 20\nintegration_step_ms = 20\ninitial_speed_mps = {speed_mps:.2}\n\
         length_m = 16.5\nactuator_time_constant_s = 0.4\nmin_acceleration_mps2 = -6.5\n\
         [road.generated]\nseed = {}\nlength_km = 8\ngrade_sigma_percent = {:.2}\n\
         [perception]\nperiod_ms = 100\nradar = {{ model = \"{model}\", max_range_m = 200 }}\n\
         tracker = {{ filter = \"{filter}\" }}\n\
         [aebs]\ndead_time_ms = 300\njerk_mps3 = 10\ndeceleration_mps2 = 5.5\nmargin_m = 3\n\
         [v2x]\nperiod_ms = 500\n[controller]\nname = \"predictive\"\n",
        draws.number + 1,
        speed_mps + 1.0,
        draws.one(&["jh6-49t", "jh6-25t"]),
        draws.number + 1,
        draws.between(0.3, 1.5),
    );
    let profile = format!(
        "profile.steps = [{{ time_s = {:.1}, speed_mps = {:.1}, acceleration_mps2 = {:.2} }}, \
         {{ time_s = 60, speed_mps = {speed_mps:.1}, acceleration_mps2 = 0.5 }}]",
        draws.between(10.0, 30.0),
        speed_mps * draws.between(0.4, 1.0),
        draws.between(0.3, 2.0)
    );
    led(draws, &mut text, speed_mps, &profile);
    text
}

fn cycle(draws: &mut Draws) -> String {
    let cycle = draws.one(&["udds", "hwfet", "us06", "wltc-3b"]);
    let mut text = head(draws, 300.0, 0.0, 38.0);
    actor(&mut text, "lead", 8.0, &format!("profile.cycle = \"{cycle}\""));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_drive_is_a_scenario_without_faults() {
        for number in 0..20 * KINDS.len() {
            let (kind, scenario) =
                drive(1, number).unwrap_or_else(|error| panic!("drive {number}: {error}"));
            assert_eq!(kind, KINDS[number % KINDS.len()].0);
            assert!(scenario.faults.is_empty());
        }
    }

    #[test]
    fn seed_and_number_make_the_drive() {
        let text = |seed, number| drive(seed, number).expect("a scenario").1.to_toml();
        assert_eq!(text(1, 4), text(1, 4));
        assert_ne!(text(1, 4), text(2, 4));
        assert_ne!(text(1, 4), text(1, 4 + KINDS.len()));
    }
}
