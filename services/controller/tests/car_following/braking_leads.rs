//! Leads that brake with 3 to 9 m/s² at 8 to 36 m/s, after settled following. They brake at once, or after they have
//! pulled away.

use controller::laws;
use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::Scenario;

use crate::world::{Perception, STEP_S, Vehicle, World, avoidable};

/// Reaction time of the yardstick, s.
const REACTION_S: f64 = 0.35;
/// Time for which the law settles before the lead brakes, s.
const SETTLE_S: f64 = 20.0;

/// Motion of a lead before it brakes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Before {
    Settled,
    /// It pulls away with 1.5 to 3 m/s² for 2 to 6 s, and is the faster when it brakes.
    PullsAway,
}

/// Result of the leads.
#[derive(Debug, Default)]
struct Tally {
    collisions: u32,
    /// Seeds of the collisions that the law's own brakes avoid.
    avoidable: Vec<u64>,
    /// Mean time gap before the lead brakes, s.
    settled_s: f64,
}

fn law(keys: &str) -> Box<dyn controller::law::Law> {
    let text = format!("schema_version = 1\nname = \"following\"\n[controller]\n{keys}\n");
    let scenario = Scenario::parse("following", &text).expect("the keys are right");
    laws::build(&scenario).unwrap_or_else(|problem| panic!("{keys}: {problem:?}"))
}

fn braking_leads(keys: &str, before: Before, cases: u64) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..cases {
        let mut rng = Pcg64::new(u128::from(seed), 5);
        let mut uniform = |low: f64, high: f64| {
            low + (high - low) * (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
        };
        let lead_mps2 = -uniform(3.0, 9.0);
        let speed_mps = uniform(8.0, 36.0);
        let ego = Vehicle { speed_mps, ..Vehicle::default() };
        let gap_m = 6.0 + 2.0 * speed_mps;
        let lead = Vehicle { position_m: gap_m, speed_mps, acceleration_mps2: 0.0 };
        let mut world = World::new(law(keys), Perception::Tracked, 0.1, (ego, lead), seed);
        // The lead is slower than the set speed, so that the law's own gap decides.
        world.set_speed_mps = speed_mps + 4.0;
        let steps = ((SETTLE_S + uniform(0.0, 0.1)) / STEP_S) as u32;
        for _ in 0..steps {
            world.advance(0.0);
        }
        if before == Before::PullsAway {
            let (pull_mps2, pull_s) = (uniform(1.5, 3.0), uniform(2.0, 6.0));
            for _ in 0..(pull_s / STEP_S) as u32 {
                world.advance(pull_mps2);
            }
        }
        let headway_s = world.gap_m() / world.ego.speed_mps;
        tally.settled_s += headway_s / cases as f64;
        let can = avoidable(world.ego, world.lead, world.authority_mps2(), REACTION_S, lead_mps2);
        let mut hit = false;
        for _ in 0..3000 {
            world.advance(lead_mps2);
            hit |= world.gap_m() <= 0.0;
            if hit || world.ego.speed_mps <= 0.0 {
                break;
            }
        }
        tally.collisions += u32::from(hit);
        if hit && can {
            tally.avoidable.push(seed);
        }
    }
    tally
}

/// Leads for each law.
const CASES: u64 = 200;
/// The same of leads that pull away first.
const PULLING_AWAY: u64 = 100;

/// No collision that the law's own brakes avoid after the reaction time.
fn none_is_avoidable(keys: &str) {
    for (before, cases) in [(Before::Settled, CASES), (Before::PullsAway, PULLING_AWAY)] {
        let tally = braking_leads(keys, before, cases);
        println!("{keys}, {before:?}: {tally:?}");
        assert!(tally.avoidable.is_empty(), "{keys}, {before:?}: seeds {:?}", tally.avoidable);
        assert!(tally.collisions * 5 < cases as u32, "{keys}: {} collisions", tally.collisions);
    }
}

#[test]
fn acc_mpc() {
    none_is_avoidable("name = \"acc-mpc\"");
}

#[test]
fn cacc_mpc() {
    none_is_avoidable("name = \"cacc-mpc\"");
}

#[test]
fn six_mode() {
    none_is_avoidable("name = \"six-mode\"");
}

#[test]
fn quadratic_bounded() {
    none_is_avoidable("name = \"quadratic-bounded\"");
}

#[test]
fn the_yardstick_shows_what_brakes_can_do() {
    let ego = Vehicle { speed_mps: 20.0, ..Vehicle::default() };
    let at = |gap_m| Vehicle { position_m: gap_m, ..ego };
    // 20 m/s: 7 m of reaction, 10 m of lag, 41 m of braking, against 25 m of the lead's.
    assert!(avoidable(ego, at(36.0), -4.9, REACTION_S, -8.0));
    assert!(!avoidable(ego, at(30.0), -4.9, REACTION_S, -8.0));
}
