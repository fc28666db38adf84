//! Everyday scenes by the thousand: contacts that brakes would have avoided, and interventions that were not needed.
//!
//! ```sh
//! cargo run --release -p standards --example everyday -- --count 53
//! cargo run --release -p standards --example everyday -- --kinds braking-lead --count 500 --laws acc-mpc
//! ```
//!
//! `--count` scenes of each kind are driven by every law, with the emergency brake and without it. The table has for
//! each kind and law
//!
//! * with the emergency brake: avoidable contacts, and drives with a needless intervention,
//! * without it: avoidable contacts, by the law's own brakes.
//!
//! Each contact and needless intervention is printed with the number of its scene, which repeats it. The exit status
//! is 1 if one of the goals is missed.

use clap::{Parser, ValueEnum};
use controller::laws;
use report::table::TextTable;
use standards::everyday::limits::ALONE_AT_MOST;
use standards::everyday::{Kind, Verdict};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

#[derive(Debug, Parser)]
struct Arguments {
    /// Kinds of scenes [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    kinds: Vec<Kind>,
    /// Scenes of each kind
    #[arg(long, default_value_t = 53)]
    count: u32,
    /// The first scene's number
    #[arg(long, default_value_t = 0)]
    first: u32,
    /// Laws [default: all]
    #[arg(long, value_delimiter = ',')]
    laws: Vec<String>,
    /// Drives at a time
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// With the emergency brake only
    #[arg(long, conflicts_with = "alone")]
    braked: bool,
    /// Without the emergency brake only
    #[arg(long)]
    alone: bool,
}

/// One drive.
#[derive(Clone, Debug)]
struct Drive {
    kind: Kind,
    number: u32,
    law: String,
    aebs: bool,
}

/// Counts of one kind and law, or of several.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    braked: u32,
    braked_avoidable: u32,
    needless: u32,
    alone: u32,
    alone_avoidable: u32,
}

impl Counts {
    fn add(&mut self, drive: &Drive, verdict: &Verdict) {
        if drive.aebs {
            self.braked += 1;
            self.braked_avoidable += u32::from(verdict.avoidable);
            self.needless += u32::from(!verdict.needless_s.is_empty());
        } else {
            self.alone += 1;
            self.alone_avoidable += u32::from(verdict.avoidable);
        }
    }

    fn alone_share(&self) -> f64 {
        f64::from(self.alone_avoidable) / f64::from(self.alone.max(1))
    }

    fn cell(&self) -> String {
        format!("{} {} {}", self.braked_avoidable, self.needless, self.alone_avoidable)
    }

    fn is_good(&self) -> bool {
        self.braked_avoidable == 0 && self.needless == 0 && self.alone_share() <= ALONE_AT_MOST
    }
}

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if arguments.kinds.is_empty() {
        arguments.kinds = Kind::value_variants().to_vec();
    }
    if arguments.laws.is_empty() {
        arguments.laws = laws::own().map(|law| law.name.to_owned()).collect();
    }
    let drives = plan(&arguments);
    let found = drive_all(&drives, arguments.jobs);
    if report(&arguments, &found) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn plan(arguments: &Arguments) -> Vec<Drive> {
    let mut drives = Vec::new();
    for &kind in &arguments.kinds {
        for number in arguments.first..arguments.first + arguments.count {
            for law in &arguments.laws {
                let each = [true, false].into_iter();
                let wanted =
                    each.filter(|aebs| if *aebs { !arguments.alone } else { !arguments.braked });
                drives.extend(wanted.map(|aebs| Drive { kind, number, law: law.clone(), aebs }));
            }
        }
    }
    drives
}

fn drive_all(drives: &[Drive], jobs: usize) -> Vec<(Drive, Verdict)> {
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Vec::with_capacity(drives.len()));
    let work = || {
        while let Some(drive) = drives.get(next.fetch_add(1, Ordering::Relaxed)) {
            match drive.kind.drive(drive.number, &drive.law, drive.aebs) {
                Ok(verdict) => {
                    found.lock().expect("no worker panics").push((drive.clone(), verdict));
                }
                Err(error) => eprintln!("{drive:?}: {error}"),
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.max(1) {
            scope.spawn(work);
        }
    });
    let mut found = found.into_inner().expect("no worker panics");
    found.sort_by_key(|(drive, _)| (drive.kind, drive.law.clone(), drive.aebs, drive.number));
    found
}

/// Prints the tables; true if all goals are met.
fn report(arguments: &Arguments, found: &[(Drive, Verdict)]) -> bool {
    for (drive, verdict) in found {
        let Drive { kind, number, law, aebs } = drive;
        let with = if *aebs { "with" } else { "without" };
        if verdict.collided || !verdict.needless_s.is_empty() {
            println!("{kind:?} {number}, {law} {with} the emergency brake: {verdict:?}");
        }
        if verdict.collided != verdict.referee_collided {
            println!("{kind:?} {number}, {law}: oracle and referee differ on the contact");
        }
    }
    let heads = arguments.laws.iter().map(String::as_str);
    let mut table =
        TextTable::of_figures(["kind", "drives"].into_iter().chain(heads).chain(["all"]));
    let count = |holds: &dyn Fn(&Drive) -> bool| {
        let mut counts = Counts::default();
        for (drive, verdict) in found.iter().filter(|(drive, _)| holds(drive)) {
            counts.add(drive, verdict);
        }
        counts
    };
    let mut row = |name: String, of: &dyn Fn(&Drive) -> bool| {
        let all = count(of);
        let laws = arguments.laws.iter().map(|law| count(&|d| of(d) && d.law == *law).cell());
        let drives = (all.braked + all.alone).to_string();
        table.row([name, drives].into_iter().chain(laws).chain([all.cell()]));
    };
    for &kind in &arguments.kinds {
        row(format!("{kind:?}"), &|drive| drive.kind == kind);
    }
    row("all".into(), &|_| true);
    println!(
        "with the brake: avoidable contacts, needless interventions; alone: avoidable contacts"
    );
    print!("{}", table.text());
    let all = count(&|_| true);
    println!(
        "with the brake {} drives: {} avoidable contacts (goal 0), {} with a needless intervention (goal 0)",
        all.braked, all.braked_avoidable, all.needless
    );
    println!(
        "alone {} drives: {} avoidable contacts, {:.2} % (goal 1 %)",
        all.alone,
        all.alone_avoidable,
        100.0 * all.alone_share()
    );
    all.is_good()
}
