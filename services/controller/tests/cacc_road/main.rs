//! The road formulation in a closed loop.

mod world;

use controller::cacc::config::{Config, SolverKind};
use controller::cacc::road::RoadLaw;
use controller::law::{Law, Output};
use world::{Breach, Event, Signal, World};

fn law() -> RoadLaw {
    let config = Config::default();
    let solver = SolverKind::Riccati.create(config.horizon_steps);
    RoadLaw::new(&config, true, solver).expect("the default configuration is convex")
}

fn signal(line_m: f64, lengths_s: [f64; 3], phase: usize, left_s: f64) -> Signal {
    Signal { id: 256 + line_m as u32, line_m, lengths_s, phase, left_s }
}

struct Run {
    world: World,
    hardest_mps2: f64,
    max_jerk_mps3: f64,
}

/// Runs for `seconds`, with events at their times.
fn run(mut world: World, seconds: f64, events: &[(f64, Event)], verbose: bool) -> Result<Run, Breach> {
    let mut law = law();
    let mut output = Output::default();
    let (mut hardest, mut max_jerk) = (0.0_f64, 0.0_f64);
    let mut next = 0;
    while world.time_s < seconds - 1e-6 {
        while next < events.len() && events[next].0 <= world.time_s + 1e-6 {
            world.apply(events[next].1);
            next += 1;
        }
        let a = world.ego.acceleration_mps2;
        world.step(&mut law, &mut output)?;
        if verbose {
            let gap = world.lead.map_or(f64::NAN, |l| l.position_m - world.ego.position_m);
            let v_lead = world.lead.map_or(f64::NAN, |l| l.speed_mps);
            println!(
                "{:5.1} x {:7.2} v {:6.2} a {:5.2} u {:5.2} gap {:6.2} vl {:5.2} {:8} {:16} {:?} corr {:.2} short {:.2} cost {:.0}/{:.0} it {}",
                world.time_s, world.ego.position_m, world.ego.speed_mps, world.ego.acceleration_mps2,
                output.request_mps2(), gap, v_lead, law.mode_names()[output.mode as usize],
                law.reason_names()[output.mode_reason as usize], output.quality, output.figures[2],
                output.figures[4], output.figures[5], output.figures[6], output.solver_iterations
            );
        }
        hardest = hardest.min(world.ego.acceleration_mps2);
        max_jerk = max_jerk.max((world.ego.acceleration_mps2 - a).abs() / 0.1);
    }
    Ok(Run { world, hardest_mps2: hardest, max_jerk_mps3: max_jerk })
}

#[test]
fn dbg_cruise() {
    let w = World::new(5.0, 15.0);
    let r = run(w, 20.0, &[], true).unwrap();
    println!("{} {}", r.hardest_mps2, r.max_jerk_mps3);
}
#[test]
fn dbg_red() {
    let mut w = World::new(15.0, 15.0);
    w.signals.push(signal(200.0, [20.0, 3.0, 20.0], 2, 25.0));
    let r = run(w, 45.0, &[], true).unwrap();
    println!("{} {}", r.hardest_mps2, r.max_jerk_mps3);
}
#[test]
fn dbg_approach() {
    let mut w = World::new(20.0, 20.0);
    w.apply(Event::LeadAppears { gap_m: 150.0, speed_mps: 0.0 });
    let r = run(w, 45.0, &[(25.0, Event::LeadAccelerates(1.5)), (32.0, Event::LeadAccelerates(0.0))], true).unwrap();
    println!("{} {}", r.hardest_mps2, r.max_jerk_mps3);
}
