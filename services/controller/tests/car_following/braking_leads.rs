//! Leads that brake with 3 to 9 m/s² at 8 to 36 m/s, after settled following.

use controller::laws;
use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::Scenario;

use crate::world::{Perception, STEP_S, Vehicle, World, avoidable};

/// Reaction time of the yardstick, s.
const REACTION_S: f64 = 0.35;
/// Time for which the law settles before the lead brakes, s.
const SETTLE_S: f64 = 20.0;

/// What became of the leads.
#[derive(Debug, Default)]
struct Tally {
    collisions: u32,
    avoidable: Vec<u64>,
    settled_s: f64,
    least_settled_s: f64,
}

fn law(keys: &str) -> Box<dyn controller::law::Law> {
    let text = format!("schema_version = 1\nname = \"following\"\n[controller]\n{keys}\n");
    let scenario = Scenario::parse("following", &text).expect("the keys are right");
    laws::build(&scenario).unwrap_or_else(|problem| panic!("{keys}: {problem:?}"))
}

fn braking_leads(keys: &str, perception: Perception, cases: u64) -> Tally {
    let mut tally = Tally { least_settled_s: f64::INFINITY, ..Tally::default() };
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
        let mut world = World::new(law(keys), perception, 0.1, (ego, lead), seed);
        // The lead is slower than the set speed, so that the law's own gap decides.
        world.set_speed_mps = speed_mps + 4.0;
        let steps = ((SETTLE_S + uniform(0.0, 0.1)) / STEP_S) as u32;
        for _ in 0..steps {
            world.advance(0.0);
        }
        let headway_s = world.gap_m() / world.ego.speed_mps;
        tally.settled_s += headway_s / cases as f64;
        tally.least_settled_s = tally.least_settled_s.min(headway_s);
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

#[test]
#[ignore = "prints figures"]
fn survey() {
    let cases = std::env::var("CASES").map_or(100, |n| n.parse().expect("a number"));
    for keys in std::env::var("LAWS")
        .unwrap_or("acc-mpc,six-mode,quadratic-bounded,predictive".into())
        .split(',')
    {
        let mut parts = keys.splitn(2, ':');
        let name = parts.next().expect("a name");
        let more = parts.next().unwrap_or("").replace(';', "\n");
        let source = if name == "predictive" { Perception::Measured } else { Perception::Tracked };
        for perception in [Perception::Ideal, source] {
            let begun = std::time::Instant::now();
            let tally = braking_leads(&format!("name = \"{name}\"\n{more}"), perception, cases);
            println!("{keys} {perception:?} {:?} {:.1?}", tally, begun.elapsed());
        }
    }
}
