//! Tables of results: CSV and Parquet, the drives of a study and their trajectories, read by PyPI's `pyarrow`.

use std::path::Path;
use std::process::Command;

use system_tests::{Corner, text};

use super::{PROGRAM, SCRIPTS, interpreter, printed, succeeded};

/// Every table as CSV and as Parquet, compared cell by cell with pyarrow.
pub fn parquet_tables_hold_what_csv_tables_hold() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    for (scenario, tables) in [("corridor", 10), ("truck-follow", 10)] {
        let run = ["run", scenario, "--mode", "lockstep", "--duration", "5", "--out", scenario];
        printed(&corner, &run);
        printed(&corner, &["recording", "export", scenario, "--csv", "--parquet"]);
        let script = Path::new(SCRIPTS).join("parquet.py");
        let compared =
            succeeded(Command::new(&python).arg(script).arg(corner.path().join(scenario)));
        let compared: usize = compared.trim().parse().expect("a number of tables");
        assert!(compared >= tables, "{compared} tables of {scenario}");
    }
}

pub fn kept_trajectories_are_those_of_the_runs() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    for (keep, runs) in [("all", "4"), ("worst:1", "1")] {
        let keys = ["--vary", "runtime.extra_delay_ms=0,100", "--seeds", "1,2", "--duration", "12"];
        let sweep = [&["sweep", "cut-in", "--keep", keep, "--out", keep], &keys[..]].concat();
        printed(&corner, &sweep);
        let script = Path::new(SCRIPTS).join("trajectories.py");
        let found = succeeded(Command::new(&python).arg(script).arg(corner.path().join(keep)));
        assert_eq!(found.trim(), runs);
    }
}

/// The table of all drives beside the kept trajectories, in studies whose runs are several drives or wait for others.
pub fn every_drive_of_a_study_has_its_row_and_its_trajectory() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    let string =
        ["string", "following", "--vehicles", "2", "--frequencies", "0.1", "--duration", "30"];
    let r157 = ["test", "r157", "--matrix", "cut-in", "--controllers", "acc-mpc", "--sample", "3"];
    for (words, keys, least) in [
        (&string[..], "vehicle,frequency_hz", 4),
        (&r157[..], "matrix,case,aebs", 3),
        (&["papers", "six-mode"][..], "paper,piece,drive,set", 2),
        (&["test", "iso15622", "--controllers", "acc-mpc"][..], "test", 3),
    ] {
        let out = keys.split(',').next_back().expect("a key");
        let study = [words, &["--keep", "all", "--out", out]].concat();
        let output = corner.run(&study);
        // A study may find that a requirement is broken.
        assert!(matches!(output.status.code(), Some(0 | 1)), "{study:?}: {}", text(&output));
        let script = Path::new(SCRIPTS).join("drives.py");
        let directory = corner.path().join(out);
        let drives = succeeded(Command::new(&python).arg(script).arg(directory).arg(keys));
        let drives: usize = drives.trim().parse().expect("a number");
        assert!(drives >= least, "{out}: {drives} drives");
    }
    let worst = [&r157[..], &["--keep", "worst:2", "--out", "worst", "--force"]].concat();
    let said = text(&corner.run(&worst));
    assert!(said.contains("trajectories kept: 2 in"), "{said}");
}
