//! The solvers of Python: `peers.py` with the sets on its standard input.

use crate::Answers;
use crate::problems::Set;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::process::{Command, Stdio};

#[derive(Serialize)]
struct Asked<'a> {
    repeats: usize,
    sets: &'a [Set],
}

/// Name of a solver, its times in µs, its inputs.
type OfSolver = (String, Vec<f64>, Vec<Vec<f64>>);

#[derive(Deserialize)]
struct Answered {
    /// For each set, the answers of each solver.
    sets: Vec<Vec<OfSolver>>,
    notes: Vec<String>,
}

/// Answers for each set, and remarks.
pub(crate) fn solve(sets: &[Set], repeats: usize) -> (Vec<Vec<Answers>>, Vec<String>) {
    match ask(sets, repeats) {
        Ok(Answered { sets, notes }) => {
            let answers = |(solver, times_us, inputs)| Answers { solver, times_us, inputs };
            let of_set = |set: Vec<_>| set.into_iter().map(answers).collect();
            (sets.into_iter().map(of_set).collect(), notes)
        }
        Err(error) => {
            (Vec::new(), vec![format!("the solvers of Python are not compared: {error}")])
        }
    }
}

fn ask(sets: &[Set], repeats: usize) -> Result<Answered, std::io::Error> {
    let python = std::env::var("TIMEGAP_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/peers.py");
    let mut child =
        Command::new(python).arg(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
    let asked = serde_json::to_vec(&Asked { repeats, sets })?;
    child.stdin.take().expect("it is piped").write_all(&asked)?;
    let output = child.wait_with_output()?;
    if !output.status.success() {
        return Err(std::io::Error::other("peers.py failed; its message is above"));
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}
