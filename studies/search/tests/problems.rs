//! The published problems, and files that are not problems.

use std::path::{Path, PathBuf};

use frame::Command;
use search::SearchArguments;
use search::method::{Chooser, MethodName};
use search::problem::{FAULT, Problem};

fn open(words: &[&str]) -> Result<Problem, String> {
    let Command { study, options } = Command::<SearchArguments>::read(words).expect("arguments");
    Problem::open(&study, &options.group).map_err(|error| error.to_string())
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("problems")
}

/// A problem opens, the reference avoids its nominal scene, and every choice of a fault can be driven.
#[test]
fn the_published_problems_are_problems() {
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder of problems") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a text");
        if !text.contains("\n[vary]\n") {
            continue;
        }
        let name = path.to_string_lossy().into_owned();
        let problem = open(&[&name]).unwrap_or_else(|error| panic!("{name}: {error}"));
        let nominal = problem.nominal_values();
        let value = problem.admit(&problem.point(&nominal)).expect("it can be driven");
        assert!(value < 0.0, "{name}: {value}");
        let choice = problem.variables.iter().position(|variable| variable.name == FAULT);
        let words = choice.map_or(0, |place| problem.variables[place].domain.count().unwrap_or(0));
        for word in 0..words {
            let mut point = vec![0.37; problem.dimensions()];
            point[choice.expect("it has words")] = (word as f64 + 0.5) / words as f64;
            let scenario = problem.scenario(&problem.values(&point), 1);
            let scenario = scenario.unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(scenario.faults.len(), usize::from(word > 0), "{name}");
        }
        count += 1;
    }
    assert!(count >= 6, "{count} problems");
}

#[test]
fn a_file_that_is_not_a_problem_is_refused_with_its_place() {
    for (words, parts) in [
        (&["following"][..], &["nothing varies", "--vary KEY=A..B"][..]),
        (&["following", "--vary", "set_speed_mps"], &["--vary set_speed_mps: no `=`"]),
        (&["following", "--vary", "set_speed_mps=3..2"], &["after its end 2", "KEY=A..B:log"]),
        (
            &["following", "--vary", "set_sped_mps=2..3"],
            &["set_sped_mps = 2", "unknown", "set_speed_mps"],
        ),
        (
            &["following", "--vary", "set_speed_mps=2..300"],
            &["refuses set_speed_mps = 300", "0 to 100"],
        ),
        (
            &["following", "--vary", "set_speed_mps=20..30", "--require", "always gap > 2"],
            &["column 8", "unknown signal"],
        ),
        (
            &["following", "--vary", "set_speed_mps=20..30", "--require", "always[0,90] gap_m > 2"],
            &["the window ends after the run"],
        ),
        (
            &["following", "--vary", "seed=1..2", "--vary", "seed=3..4"],
            &["--vary seed=3..4: the key varies already"],
        ),
        (
            &[
                "following",
                "--vary",
                "set_speed_mps=20..30",
                "--law",
                "mine=true",
                "--controller",
                "acc-mpc",
            ],
            &["mine"],
        ),
    ] {
        let said = open(words).expect_err("refused");
        assert!(parts.iter().all(|part| said.contains(part)), "{words:?}: {said}");
    }
}

/// A car that stands a metre ahead cannot be avoided.
#[test]
fn a_box_that_the_reference_never_avoids_is_refused() {
    let words =
        ["tight-brake", "--vary", "actors.0.gap_m=1..2", "--set", "actors.0.initial_speed_mps=0"];
    let problem = open(&words).expect("a problem");
    let mut chooser = Chooser::new(MethodName::Sobol, &problem.kinds(), 1, 1);
    // The admission of one point is that of all: the others need not be driven.
    let one = problem.admit(&[0.5]).expect("it can be driven");
    let said = chooser.propose(0, &|_| Ok(one)).expect_err("refused").to_string();
    assert!(one > 0.0 && said.contains("none of 10000 points"), "{said}");
}
