//! Cost of a call of each law, also of those that are programs of their own: `cargo bench -p controller --bench laws
//! [-- PROGRAM ARGUMENTS...]`.
//!
//! The drive is the same for all. A lead 40 m ahead speeds up and slows down, the light is green, and a truck has
//! hills. The foreign law is `examples/my_law.py` where there is a Python, and the program that the arguments name. It
//! is called as in simulated time: the whole way through both pipes counts.

use controller::law::{
    Ego, Input, Law, Output, Phase, PhaseInterval, Powertrain, Preview, SignalAhead, Target,
};
use controller::laws;
use scenario::Scenario;
use std::path::Path;
use std::time::Instant;

/// Calls that are measured, behind as many that are not.
const CALLS: usize = 3000;

fn main() {
    let program: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/my_law.py");
    println!("{:<46} {:>9} {:>9} {:>9} {:>6}", "law, µs per call", "p50", "p99", "max", "n");
    for law in laws::own() {
        let vehicle = if law.trucks_alone { "jh6-49t" } else { "car" };
        measure(law.name, law.name, vehicle, "");
    }
    if Path::new(example).exists() {
        foreign(&["python3".to_owned(), example.to_owned()]);
    }
    if !program.is_empty() {
        foreign(&program);
    }
}

fn foreign(command: &[String]) {
    let words: Vec<String> = command.iter().map(|word| format!("{word:?}")).collect();
    let name = command.last().and_then(|word| Path::new(word).file_name());
    let name = name.map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    measure(
        &format!("external: {name}"),
        "external",
        "car",
        &format!("command = [{}]", words.join(", ")),
    );
}

fn measure(label: &str, law: &str, vehicle: &str, keys: &str) {
    let text = format!(
        "schema_version = 1\nname = \"bench\"\nplant.vehicle = \"{vehicle}\"\n[controller]\nname = \"{law}\"\n\
         {keys}\n"
    );
    let scenario = Scenario::parse("bench", &text).expect("the keys are right");
    let mut law = match laws::build(&scenario) {
        Ok(law) => law,
        Err(problem) => return println!("{label:<46} {}", problem.message),
    };
    if let Some(hosted) = law.hosted()
        && let Err(error) = hosted.start()
    {
        return println!("{label:<46} {error}");
    }
    calls(law.as_mut());
    let mut times_us = calls(law.as_mut());
    times_us.sort_by(f64::total_cmp);
    let at = |part: f64| times_us[(part * (CALLS - 1) as f64) as usize];
    println!("{label:<46} {:>9.2} {:>9.2} {:>9.2} {CALLS:>6}", at(0.5), at(0.99), at(1.0));
}

/// The times of [`CALLS`] calls, µs.
fn calls(law: &mut dyn Law) -> Vec<f64> {
    let mut output = Output::default();
    let mut time_us = |k| {
        let input = moment(k);
        let begun = Instant::now();
        law.step(&input, &mut output);
        begun.elapsed().as_secs_f64() * 1e6
    };
    (0..CALLS).map(&mut time_us).collect()
}

fn moment(k: usize) -> Input {
    let time_s = 0.1 * k as f64;
    let mut intervals = [PhaseInterval::default(); 8];
    intervals[0] = PhaseInterval { phase: Phase::Green, ends_in_s: 12.0 };
    intervals[1] = PhaseInterval { phase: Phase::Red, ends_in_s: 40.0 };
    let mut input = Input {
        time_s,
        period_s: 0.1,
        ego: Ego { position_m: 20.0 * time_s, speed_mps: 20.0, acceleration_mps2: 0.0 },
        target: Some(Target {
            track_id: 1,
            gap_m: 40.0 + 5.0 * libm::sin(0.3 * time_s),
            relative_speed_mps: 1.5 * libm::cos(0.3 * time_s),
            acceleration_mps2: -0.45 * libm::sin(0.3 * time_s),
            age_s: 0.02,
        }),
        set_speed_mps: 25.0,
        speed_limit_mps: 30.0,
        ..Input::default()
    };
    input.signals[0] =
        Some(SignalAhead { id: 257, distance_m: 150.0, intervals, count: 2, likely_s: 0.0 });
    input.powertrain =
        Some(Powertrain { gear: 5, since_shift_s: 20.0, engine_torque_nm: 800.0, grade: 0.005 });
    input.preview = Some(Preview {
        start_m: 20.0 * time_s,
        cell_m: 50.0,
        grades: std::array::from_fn(|cell| if cell % 20 < 10 { 0.01 } else { -0.015 }),
        count: 45,
    });
    input
}
