//! The live page in a real browser, and its run.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, ExitCode};
use system_tests::browser::{Browser, chromium};
use system_tests::cases::{self, case, needing};
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Starts a run with `--serve` and reads its address.
fn serve(corner: &Corner, seconds: &str) -> (Child, String, std::thread::JoinHandle<String>) {
    let fault = "faults=[{ kind = \"kill\", service = \"controller\", at_s = 0.5 }]";
    let arguments = ["run", "--duration", seconds, "--serve", "0", "--out", "out", "--json"];
    let mut run = corner.start(&[&arguments[..], &["--set", fault]].concat());
    let mut lines = BufReader::new(run.stderr.take().expect("piped")).lines();
    let mut address = None;
    while address.is_none()
        && let Some(Ok(line)) = lines.next()
    {
        address = line.strip_prefix("live at ").map(str::to_owned);
    }
    let rest =
        std::thread::spawn(move || lines.map_while(Result::ok).collect::<Vec<_>>().join("\n"));
    (run, address.expect("the run says where it is served"), rest)
}

/// State of the page: frames received, points of each curve, status.
const SHOWN: &str = "({ frames: Number(document.body.dataset.frames ?? 0),
    over: document.body.dataset.over === 'true',
    status: document.getElementById('status').textContent,
    mode: document.getElementById('mode').textContent,
    level: document.getElementById('level').textContent,
    time: document.getElementById('time').textContent,
    events: document.getElementById('events').textContent,
    points: Object.fromEntries(STRIPS.flatMap(({ curves, plot }) => curves.map(([, , field], index) =>
        [field, plot.data.at(-1 - index)[1].filter((value) => value !== null).length]))) })";

fn the_page_draws_updates_and_survives_the_end_of_the_run() {
    let corner = Corner::new(PROGRAM);
    // Long: the test ends it.
    let (run, address, rest) = serve(&corner, "600");
    let mut browsers = [0, 1].map(|number| Browser::open(&corner, number, &address));
    for browser in &mut browsers {
        let mut frames = Vec::new();
        let updated = wait_for(|| {
            let shown = browser.evaluate(SHOWN);
            let drawn = |field: &str| shown["points"][field].as_u64() > Some(10);
            if ["speed_mps", "gap_m", "request_mps2", "acceleration_mps2"].into_iter().all(drawn) {
                frames.push(shown["frames"].as_u64());
            }
            frames.first() < frames.last()
        });
        assert!(updated, "{}", browser.evaluate(SHOWN));
        let shown = browser.evaluate(SHOWN);
        assert_eq!(shown["status"], "running", "{shown}");
        assert_ne!(shown["mode"], "–", "{shown}");
        let time = shown["time"].as_str().unwrap_or_default();
        assert!(time.ends_with(" of 600.0 s"), "{shown}");
        let mended = wait_for(|| {
            let shown = browser.evaluate(SHOWN);
            let events = shown["events"].as_str().unwrap_or_default();
            events.contains("kill controller: detected after") && events.contains("back after")
        });
        assert!(mended, "{}", browser.evaluate(SHOWN));
    }
    let pid = Pid::from_raw(i32::try_from(run.id()).expect("a pid")).expect("not zero");
    kill_process(pid, Signal::INT).expect("it lives");
    let output = run.wait_with_output().expect("the run ends");
    assert_eq!(output.status.code(), Some(130), "{}", rest.join().unwrap_or_default());
    let summary: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(summary["outcome"], "aborted", "nothing but JSON on standard output");
    for mut browser in browsers {
        assert!(wait_for(|| browser.evaluate(SHOWN)["over"] == true), "it says that it is over");
        let shown = browser.evaluate(SHOWN);
        let status = shown["status"].as_str().unwrap_or_default();
        assert!(status.starts_with("The run is over: aborted (interrupted)"), "{shown}");
        assert!(shown["points"]["speed_mps"].as_u64() > Some(10), "its curves stay: {shown}");
        browser.close();
    }
}

fn a_run_without_a_viewer_ends_as_usual() {
    let corner = Corner::new(PROGRAM);
    let (run, _, rest) = serve(&corner, "1");
    let output = run.wait_with_output().expect("the run ends");
    assert!(output.status.success(), "{}", rest.join().unwrap_or_default());
    let shown = corner.run(&["run", "--duration", "1", "--watch"]);
    assert_eq!(shown.status.code(), Some(2), "no terminal here: {}", text(&shown));
}

fn a_port_that_is_taken_is_said() {
    let corner = Corner::new(PROGRAM);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("bound").port().to_string();
    let output = corner.run(&["run", "--duration", "1", "--serve", &port]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(text(&output).contains(&port), "{}", text(&output));
}

fn main() -> ExitCode {
    cases::run(&[
        needing(
            chromium,
            "the_page_draws_updates_and_survives_the_end_of_the_run",
            the_page_draws_updates_and_survives_the_end_of_the_run,
        ),
        case("a_run_without_a_viewer_ends_as_usual", a_run_without_a_viewer_ends_as_usual),
        case("a_port_that_is_taken_is_said", a_port_that_is_taken_is_said),
    ])
}
