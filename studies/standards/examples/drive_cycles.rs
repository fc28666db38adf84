//! Behind leads that drive the regulatory cycles: every law, with the emergency brake.
//!
//! ```sh
//! cargo run --release -p standards --example drive_cycles -- --seed 1
//! cargo run --release -p standards --example drive_cycles -- --cycles udds --laws acc-mpc --show
//! ```
//!
//! | column | meaning |
//! |---|---|
//! | stop jerk | largest jerk below 1 m/s while the ego brakes, m/s³ |
//! | jerk | largest jerk of the whole drive, m/s³ |
//! | time gap | mean of gap over speed above 2 m/s, s |
//! | changes | changes of the law's mode |
//! | fall-back | share of the commands that the law's fall-back gave |
//!
//! A drive is marked after a collision or an emergency braking. It is also marked if the stop jerk is above 5 m/s³, or
//! if the mean time gap of `six-mode` exceeds 3 s.

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use controller::laws;
use group::report::Outcome;
use group::{Drive, DriveStep};
use report::summary::Summary;
use runtime::Mode;
use scenario::cycle::Cycle;
use scenario::{Overrides, Scenario};

/// The end of a stop is what happens below this speed, m/s.
const STOPPING_MPS: f64 = 1.0;
/// Slowest speed at which a time gap is counted, m/s.
const MOVING_MPS: f64 = 2.0;
/// Largest jerk at a stop, m/s³.
const SOFT_MPS3: f64 = 5.0;
/// Largest mean time gap of `six-mode`, s.
const TIME_GAP_S: f64 = 3.0;
/// Jerks that `--show` prints, m/s³, and the time around them for which it prints the requests, s.
const SHOWN_MPS3: f64 = 5.0;
const AROUND_S: f64 = 0.65;

#[derive(Debug, Parser)]
struct Arguments {
    /// Cycles [default: all]
    #[arg(long, value_delimiter = ',')]
    cycles: Vec<String>,
    /// Laws [default: all]
    #[arg(long, value_delimiter = ',')]
    laws: Vec<String>,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Without the emergency brake
    #[arg(long)]
    alone: bool,
    /// Print where the jerk is large
    #[arg(long)]
    show: bool,
    /// Drives at a time
    #[arg(long, default_value_t = 2)]
    jobs: usize,
}

/// Figures of a drive.
#[derive(Clone, Copy, Debug, Default)]
struct Figures {
    collision_s: Option<f64>,
    interventions: u64,
    stop_jerk_mps3: f64,
    stop_jerk_s: f64,
    jerk_mps3: f64,
    jerk_s: f64,
    time_gap_s: f64,
    mode_changes: usize,
    fall_back: f64,
    stops: u64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut names = arguments.laws.clone();
    if names.is_empty() {
        names = laws::own().map(|law| law.name.to_owned()).collect();
    }
    let chosen = |cycle: &Cycle| {
        arguments.cycles.is_empty() || arguments.cycles.iter().any(|name| name == cycle.name())
    };
    let drives: Vec<(Cycle, String)> = (Cycle::ALL.into_iter().filter(chosen))
        .flat_map(|cycle| names.iter().map(move |law| (cycle, law.clone())))
        .collect();
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Figures)>> = Mutex::new(Vec::new());
    let work = || {
        while let Some((cycle, law)) = drives.get(next.fetch_add(1, Ordering::Relaxed)) {
            let figures = drive(&arguments, *cycle, law);
            let place = drives.iter().position(|other| other == &(*cycle, law.clone()));
            if let (Some(figures), Some(place)) = (figures, place) {
                done.lock().expect("no worker panics").push((place, figures));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..arguments.jobs.max(1) {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().expect("no worker panics");
    done.sort_by_key(|(place, _)| *place);
    println!(
        "{:<9} {:<18} {:>9} {:>13} {:>16} {:>14} {:>8} {:>7} {:>9} {:>5}",
        "cycle",
        "law",
        "collision",
        "interventions",
        "stop jerk",
        "jerk",
        "time gap",
        "changes",
        "fall-back",
        "stops"
    );
    let mut ok = done.len() == drives.len();
    for (place, figures) in &done {
        let (cycle, law) = &drives[*place];
        let holds = figures.collision_s.is_none()
            && figures.interventions == 0
            && figures.stop_jerk_mps3 <= SOFT_MPS3
            && (law != "six-mode" || figures.time_gap_s <= TIME_GAP_S);
        ok &= holds;
        println!(
            "{:<9} {law:<18} {:>9} {:>13} {:>6.1} at {:>6.1} {:>5.1} at {:>6.1} {:>7.2} {:>7} {:>8.1} % {:>5}{}",
            cycle.name(),
            figures.collision_s.map_or_else(|| "none".into(), |time_s| format!("{time_s:.1} s")),
            figures.interventions,
            figures.stop_jerk_mps3,
            figures.stop_jerk_s,
            figures.jerk_mps3,
            figures.jerk_s,
            figures.time_gap_s,
            figures.mode_changes,
            100.0 * figures.fall_back,
            figures.stops,
            if holds { "" } else { "  MISSED" },
        );
    }
    if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn scenario(arguments: &Arguments, cycle: Cycle, law: &str) -> Option<Scenario> {
    let mut overrides = Overrides::new();
    let keys = [
        format!("seed={}", arguments.seed),
        format!("controller.name=\"{law}\""),
        format!("aebs.enabled={}", !arguments.alone),
    ];
    for key in keys {
        overrides.set(&key).expect("the keys are right");
    }
    match Scenario::open(cycle.name(), &overrides, &laws::check) {
        Ok(scenario) => Some(scenario),
        Err(error) => {
            eprintln!("{error}");
            None
        }
    }
}

fn drive(arguments: &Arguments, cycle: Cycle, law: &str) -> Option<Figures> {
    let scenario = scenario(arguments, cycle, law)?;
    let group = match group::in_process::run(&scenario) {
        Ok(group) => group,
        Err(error) => {
            eprintln!("{} with {law}: {error}", cycle.name());
            return None;
        }
    };
    let summary = Summary::new(&scenario, Mode::Lockstep, &group, group.ran_for);
    if arguments.show {
        show(&format!("{} {law}", cycle.name()), &group.drive);
    }
    let mut figures = of_steps(&group.drive.steps);
    figures.collision_s = (summary.outcome == Outcome::Collision).then_some(summary.duration_s);
    figures.interventions = summary.aebs.interventions.unwrap_or(0);
    figures.mode_changes = summary.control.mode_changes.map_or(0, |changes| changes.len());
    figures.stops = summary.control.figures.stops.unwrap_or(0);
    Some(figures)
}

/// Jerk from one step to the next, without the step in which the vehicle comes to a stand.
fn jerk_mps3(pair: &[DriveStep]) -> f64 {
    if pair[1].speed_mps <= 0.0 {
        return 0.0;
    }
    let rise = pair[1].acceleration_mps2 - pair[0].acceleration_mps2;
    (rise / (pair[1].time_s - pair[0].time_s)).abs()
}

fn of_steps(steps: &[DriveStep]) -> Figures {
    let mut figures = Figures::default();
    let (mut gaps_s, mut moving, mut cycles, mut fall_back) = (0.0, 0.0, 0.0, 0.0);
    for pair in steps.windows(2) {
        let (before, now) = (&pair[0], &pair[1]);
        let jerk = jerk_mps3(pair);
        if jerk > figures.jerk_mps3 {
            (figures.jerk_mps3, figures.jerk_s) = (jerk, now.time_s);
        }
        let stopping = before.speed_mps < STOPPING_MPS && before.acceleration_mps2 < 0.0;
        if stopping && jerk > figures.stop_jerk_mps3 {
            (figures.stop_jerk_mps3, figures.stop_jerk_s) = (jerk, now.time_s);
        }
        if let Some(gap_m) = now.gap_m
            && now.speed_mps > MOVING_MPS
        {
            gaps_s += gap_m / now.speed_mps;
            moving += 1.0;
        }
        if let Some(quality) = now.quality {
            cycles += 1.0;
            fall_back += f64::from(u8::from(quality == FALL_BACK));
        }
    }
    figures.time_gap_s = gaps_s / moving;
    figures.fall_back = fall_back / cycles;
    figures
}

/// `messages`' number of a command that the law's fall-back gave.
const FALL_BACK: u32 = 3;

fn show(name: &str, drive: &Drive) {
    let mut last_s = f64::NEG_INFINITY;
    for pair in drive.steps.windows(2) {
        let (now, jerk) = (&pair[1], jerk_mps3(pair));
        if jerk > SHOWN_MPS3 && now.time_s > last_s + 1.0 {
            last_s = now.time_s;
            println!("{name}: jerk {jerk:.1} m/s³ at {:.2} s", now.time_s);
            let near = |step: &&DriveStep| {
                (step.time_s - now.time_s).abs() < AROUND_S && step.request_mps2.is_some()
            };
            drive.steps.iter().filter(near).for_each(print_step);
        }
    }
}

fn print_step(step: &DriveStep) {
    println!(
        "  {:.2} s: {:.2} m/s {:.2} m/s², asked {:.2}, gap {:.2?} m, lead {:.2?} m/s, mode {:?}, \
         quality {:?}, {:.2?}",
        step.time_s,
        step.speed_mps,
        step.acceleration_mps2,
        step.request_mps2.unwrap_or(f64::NAN),
        step.gap_m,
        step.lead_speed_mps,
        step.mode,
        step.quality,
        step.figures,
    );
}
