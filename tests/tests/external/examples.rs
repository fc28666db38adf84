//! The examples unchanged: Python, C and the notebook.

use super::{LOCKSTEP, ODD_LAW, PROGRAM, by, controller, run_by};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use system_tests::{Corner, cases, python, text};

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples");

pub fn the_python_example_drives() {
    let corner = Corner::new(PROGRAM);
    std::fs::copy(Path::new(EXAMPLES).join("my_law.py"), corner.path().join("my_law.py"))
        .expect("our own directory");
    let code = std::fs::read_to_string(corner.path().join("my_law.py")).expect("text");
    assert!(code.lines().count() <= 20, "a law is fifteen lines and a head");
    let command = by(&["python3", "my_law.py"]);
    let summary = corner.json(&run_by(&command, &[&LOCKSTEP[..], &["--no-record"]].concat()));
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let program = &controller(&summary)["program"];
    assert_eq!(
        (&program["command"], &program["name"]),
        (&"python3 my_law.py".into(), &"my_law".into())
    );
    // The module of `layouts` gives the same law in three lines.
    let module = corner.run(&["print", "layouts", "--law", "--python"]);
    std::fs::write(corner.path().join("timegap_law.py"), module.stdout).expect("ours");
    let short = "import timegap_law\n\ndef law(q):\n    v = q.speed_mps\n    print('for people')\n    \
                 free = 0.4 * (min(q.set_speed_mps, q.speed_limit_mps) - v)\n    \
                 follow = 0.2 * (q.gap_m - 5.0 - 2.0 * v) + 0.7 * q.relative_speed_mps\n    \
                 return max(-4.0, min(2.0, min(free, follow) if q.has_target else free))\n\n\
                 timegap_law.drive(law)\n";
    std::fs::write(corner.path().join("short.py"), short).expect("ours");
    let command = by(&["python3", "short.py"]);
    let again = corner.json(&run_by(&command, &[&LOCKSTEP[..], &["--no-record"]].concat()));
    let digest = |summary: &Value| summary["messages"]["vehicle/odometry"]["digests"].clone();
    assert_eq!(digest(&again), digest(&summary), "the same law, the same drive");
    // Python's errors are shown.
    std::fs::write(corner.path().join("wrong.py"), "import no_such_module\n").expect("ours");
    let output = corner.run(&run_by(&by(&["python3", "wrong.py"]), &LOCKSTEP));
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("No module named 'no_such_module'"), "{}", text(&output));
}

pub fn the_c_example_drives() {
    let corner = Corner::new(PROGRAM);
    let header = corner.run(&["print", "layouts", "--law", "--c"]);
    std::fs::write(corner.path().join("timegap_law.h"), header.stdout).expect("ours");
    let compiled = Command::new("cc")
        .args([
            "-std=c11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            "-I.",
            "-O2",
            "-o",
            "my_law",
        ])
        .arg(Path::new(EXAMPLES).join("my_law.c"))
        .arg("-lm")
        .current_dir(corner.path())
        .output()
        .expect("looked for before");
    assert!(compiled.status.success(), "{}", text(&compiled));
    let command = by(&["./my_law"]);
    let summary = corner.json(&run_by(&command, &[&LOCKSTEP[..], &["--no-record"]].concat()));
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let odd = by(&[ODD_LAW]);
    let same = corner.json(&run_by(&odd, &[&LOCKSTEP[..], &["--no-record"]].concat()));
    let digest = |summary: &Value| summary["messages"]["vehicle/odometry"]["digests"].clone();
    assert_eq!(digest(&summary), digest(&same), "C and Rust say the same");
}

pub fn the_notebook_runs_as_it_is() {
    const EXECUTE: &str = "import sys, nbformat, nbclient\n\
        notebook = nbformat.read(sys.argv[1], 4)\n\
        nbformat.validate(notebook)\n\
        nbclient.NotebookClient(notebook, timeout=300).execute()\n\
        print(*[o.text for c in notebook.cells for o in c.get('outputs', []) if 'text' in o])\n";
    let python = notebook_interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    let output = Command::new(python)
        .args(["-c", EXECUTE])
        .arg(Path::new(EXAMPLES).join("my_law.ipynb"))
        .env("TIMEGAP", PROGRAM)
        .env("TMPDIR", corner.path())
        .env("XDG_RUNTIME_DIR", corner.path())
        .current_dir(corner.path())
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("external completed"), "{}", text(&output));
}

fn notebook_interpreter() -> Result<std::path::PathBuf, system_tests::missing::Missing> {
    python::NOTEBOOK.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

pub fn notebooks() -> cases::Needed {
    notebook_interpreter().map(|_| ())
}

pub fn python3() -> cases::Needed {
    cases::program("python3")
}

pub fn c_compiler() -> cases::Needed {
    cases::program("cc")
}
