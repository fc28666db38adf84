//! Processes of no service that take processor time or memory from the others.

use crate::Error;
use crate::root::RunRoot;
use crate::start::attendant::Attendant;
use runtime::scheduling::{become_ordinary, pin_to, usable_cores};
use std::ffi::OsStr;
use std::hint::black_box;
use std::process::ExitCode;

/// Such processes; they end with this.
#[derive(Debug)]
pub struct Disturbance(#[expect(dead_code, reason = "held for its end")] Vec<Attendant>);

impl Disturbance {
    /// Keeps `core` busy, or all cores.
    pub fn hog(root: &RunRoot, core: Option<u16>) -> Result<Self, Error> {
        let cores = core.map_or_else(usable_cores, |core| vec![core.into()]);
        let start = |core: &usize| {
            let core = core.to_string();
            Attendant::spawn("hog", &[OsStr::new("core"), OsStr::new(&core)], root, 0)
        };
        cores.iter().map(start).collect::<Result<_, _>>().map(Self)
    }

    /// Takes `mib` MiB of memory and touches all of it.
    pub fn memory(root: &RunRoot, mib: u32) -> Result<Self, Error> {
        let mib = mib.to_string();
        let process = Attendant::spawn("hog", &[OsStr::new("mib"), OsStr::new(&mib)], root, 0)?;
        Ok(Self(vec![process]))
    }
}

/// Such a process itself: `core` or `mib`, and how many. It ends with its standard input.
pub fn run(what: &str, number: usize) -> ExitCode {
    become_ordinary();
    let mut memory = Vec::new();
    if what == "core" {
        if let Err(reason) = pin_to(number) {
            eprintln!("core {number}: {reason}");
        }
        std::thread::spawn(|| {
            let mut state = 1_u64;
            loop {
                state = black_box(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
            }
        });
    } else {
        memory.resize(number << 20, 1_u8);
        black_box(&mut memory);
    }
    // Content does not matter: it is not meant for us, and only the end counts.
    let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
    ExitCode::SUCCESS
}
