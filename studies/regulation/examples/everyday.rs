//! Everyday scenes by the thousand: interventions of the emergency brake, and collisions.
//!
//! ```sh
//! cargo run --release -p regulation --example everyday -- --kinds cut-in,stop,pass,queue --count 10000
//! cargo run --release -p regulation --example everyday -- --kinds braking-lead --count 500
//! ```
//!
//! Every scene is driven by the next law of the list. What was not as it should be is printed with its
//! number, which repeats it.

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use clap::Parser;
use controller::laws;
use regulation::everyday::{Kind, Verdict};

#[derive(Debug, Parser)]
struct Arguments {
    /// Kinds of scenes
    #[arg(long, value_enum, value_delimiter = ',', default_value = "cut-in,stop,pass,queue")]
    kinds: Vec<Kind>,
    /// Scenes of each kind
    #[arg(long, default_value_t = 1000)]
    count: u32,
    /// The first scene's number
    #[arg(long, default_value_t = 0)]
    first: u32,
    /// Laws [default: all]
    #[arg(long, value_delimiter = ',')]
    laws: Vec<String>,
    /// Without the emergency brake
    #[arg(long)]
    alone: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut names = arguments.laws.clone();
    if names.is_empty() {
        names = laws::own().map(|law| law.name.to_owned()).collect();
    }
    let mut ok = true;
    for &kind in &arguments.kinds {
        let next = AtomicU32::new(0);
        let found: Mutex<Vec<(u32, String, Verdict)>> = Mutex::new(Vec::new());
        let work = || loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= arguments.count {
                return;
            }
            let number = arguments.first + k;
            let law = &names[number as usize % names.len()];
            let drive = || kind.drive(&kind.scenario(number, law, !arguments.alone)?);
            match drive() {
                Ok(verdict) => {
                    found.lock().expect("no worker panics").push((number, law.clone(), verdict));
                }
                Err(error) => eprintln!("{kind:?} {number} with {law}: {error}"),
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(work);
            }
        });
        let mut found = found.into_inner().expect("no worker panics");
        found.sort_by_key(|(number, ..)| *number);
        let count = |holds: fn(&Verdict) -> bool| {
            found.iter().filter(|(.., verdict)| holds(verdict)).count()
        };
        println!(
            "{kind:?}: {} scenes, {} with interventions, {} collisions, {} avoidable, {} with false targets, \
             {} with braking",
            found.len(),
            count(|verdict| verdict.interventions > 0),
            count(|verdict| verdict.collided),
            count(|verdict| verdict.avoidable),
            count(|verdict| verdict.false_targets > 0),
            count(|verdict| verdict.brakes),
        );
        for (number, law, verdict) in &found {
            let wrong = match kind {
                Kind::BrakingLead => verdict.avoidable,
                Kind::CutOut => verdict.collided,
                Kind::CutIn | Kind::Stop | Kind::Pass | Kind::Queue | Kind::LedQueue => {
                    verdict.collided || verdict.interventions > 0
                }
            };
            if wrong {
                println!("  {number} with {law}: {verdict:?}");
                ok = false;
            }
        }
    }
    if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
