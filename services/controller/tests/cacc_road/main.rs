//! The road formulation in a closed loop.

mod cases;
mod solvers;
mod world;

use cases::Case;
use controller::cacc::config::{Config, SolverKind};
use controller::cacc::road::RoadLaw;
use controller::law::{Law, Output};
use mpc_solver::Solver;
use solvers::{Fake, Temper};
use world::{Breach, Event, Signal, World};

fn law_with(solver: Box<dyn Solver + Send>) -> RoadLaw {
    RoadLaw::new(&Config::default(), true, solver).expect("the default configuration is convex")
}

fn law() -> RoadLaw {
    law_with(solvers::real(SolverKind::Riccati))
}

fn signal(line_m: f64, lengths_s: [f64; 3], phase: usize, left_s: f64) -> Signal {
    Signal { id: 256 + line_m as u32, line_m, lengths_s, phase, left_s }
}

fn trace(world: &World, output: &Output, law: &RoadLaw) {
    let gap = world.lead.map_or(f64::NAN, |l| l.position_m - world.ego.position_m);
    let (v_lead, a_lead) =
        world.lead.map_or((f64::NAN, f64::NAN), |l| (l.speed_mps, l.acceleration_mps2));
    let next = world.signals.iter().find(|s| s.line_m > world.ego.position_m);
    println!(
        "{:5.1} x {:7.2} v {:6.2} a {:5.2} u {:5.2} gap {:6.2} vl {:5.2} al {:5.2} {:6} {:16} {:?} corr {:.2} short {:.2} cost {:.0}/{:.0} it {} sil {} line {:?}",
        world.time_s,
        world.ego.position_m,
        world.ego.speed_mps,
        world.ego.acceleration_mps2,
        output.request_mps2(),
        gap,
        v_lead,
        a_lead,
        law.mode_names()[output.mode as usize],
        law.reason_names()[output.mode_reason as usize],
        output.quality,
        output.figures[2],
        output.figures[4],
        output.figures[5],
        output.figures[6],
        output.solver_iterations,
        world.silence,
        next.map(|s| ((s.line_m - world.ego.position_m) as f32, s.phase, s.left_s as f32)),
    );
}

struct Run {
    world: World,
    hardest_mps2: f64,
    max_jerk_mps3: f64,
}

/// Runs for `seconds`, with events at their times.
fn run(
    mut world: World,
    seconds: f64,
    events: &[(f64, Event)],
    verbose: bool,
) -> Result<Run, Breach> {
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
            trace(&world, &output, &law);
        }
        hardest = hardest.min(world.ego.acceleration_mps2);
        max_jerk = max_jerk.max((world.ego.acceleration_mps2 - a).abs() / 0.1);
    }
    Ok(Run { world, hardest_mps2: hardest, max_jerk_mps3: max_jerk })
}

#[test]
fn dbg_red() {
    let mut w = World::new(15.0, 15.0);
    w.signals.push(signal(200.0, [20.0, 3.0, 20.0], 2, 25.0));
    let r = run(w, 45.0, &[], true).unwrap();
    println!("{} {}", r.hardest_mps2, r.max_jerk_mps3);
}

fn random_case(seed: u64, law: &mut RoadLaw, verbose: bool) -> Result<f64, Breach> {
    let mut case = Case::new(seed);
    if verbose {
        println!("{:?}", case.kind);
    }
    law.reset();
    let mut output = Output::default();
    let mut hardest = 0.0_f64;
    while case.world.time_s < case.seconds {
        for event in case.events() {
            if verbose {
                println!("{event:?}");
            }
            case.world.apply(event);
        }
        let r = case.world.step(law, &mut output);
        if verbose {
            trace(&case.world, &output, law);
        }
        r?;
        hardest = hardest.min(case.world.ego.acceleration_mps2);
    }
    Ok(hardest)
}

#[test]
fn dbg_random() {
    let from: u64 = std::env::var("FROM").map_or(0, |s| s.parse().unwrap());
    let n: u64 = std::env::var("N").map_or(500, |s| s.parse().unwrap());
    let which = std::env::var("SOLVER").unwrap_or_default();
    let mut bad = 0;
    for seed in from..from + n {
        let mut law = match which.as_str() {
            "fails" => law_with(Box::new(Fake::new(Temper::Fails, seed))),
            "lies" => law_with(Box::new(Fake::new(Temper::Lies, seed))),
            _ => law(),
        };
        if let Err(breach) = random_case(seed, &mut law, n == 1) {
            println!("seed {seed}: {breach:?}");
            bad += 1;
        }
    }
    println!("bad {bad} of {n}");
}
