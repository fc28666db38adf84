//! The live page in a real browser, and the run that it does not disturb.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use system_tests::cases::{self, Needed, case, needing};
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Debian's chromium, or another of its kind.
fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .flat_map(|directory| {
            ["chromium", "chromium-browser", "google-chrome"].map(|name| directory.join(name))
        })
        .find(|program| program.is_file())
}

fn chromium() -> Needed {
    browser().map(|_| ()).ok_or_else(|| "no chromium".to_owned())
}

/// Starts a run that serves itself, and reads from it where.
fn serve(corner: &Corner, seconds: &str) -> (Child, String, std::thread::JoinHandle<String>) {
    let arguments = ["run", "--duration", seconds, "--serve", "0", "--out", "out", "--json"];
    let mut run = corner.start(&arguments);
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

/// A browser with one page, spoken to in the DevTools protocol through two pipes.
struct Browser {
    process: Child,
    to: File,
    from: BufReader<File>,
    asked: u64,
    session: Option<String>,
}

impl Browser {
    /// Opens `address` in `program`.
    fn open(program: &Path, corner: &Corner, number: usize, address: &str) -> Self {
        let path = |name: &str| corner.path().join(format!("{name}-{number}"));
        let (to, from) = (path("to"), path("from"));
        let made = Command::new("mkfifo").args([&to, &from]).status().expect("mkfifo is there");
        assert!(made.success());
        // The browser reads its orders on descriptor 3 and answers on 4.
        let process = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<\"$TO\" 4>\"$FROM\""])
            .arg(program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"])
            .arg(format!("--user-data-dir={}", path("profile").display()))
            .env("TO", &to)
            .env("FROM", &from)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("a shell starts");
        let to = File::options().write(true).open(to).expect("the browser reads");
        let from = BufReader::new(File::open(from).expect("the browser answers"));
        let mut browser = Self { process, to, from, asked: 0, session: None };
        let page = browser.call("Target.createTarget", json!({ "url": address }));
        let attach = json!({ "targetId": page["targetId"], "flatten": true });
        let attached = browser.call("Target.attachToTarget", attach);
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        browser
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut order = json!({ "id": self.asked, "method": method, "params": params });
        if let Some(session) = &self.session {
            order["sessionId"] = json!(session);
        }
        let mut bytes = order.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).expect("the browser lives");
        loop {
            let mut bytes = Vec::new();
            self.from.read_until(0, &mut bytes).expect("the browser lives");
            assert_eq!(bytes.pop(), Some(0), "the browser went away");
            let answer: Value = serde_json::from_slice(&bytes).expect("the protocol is JSON");
            if answer["id"] == self.asked {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
        }
    }

    /// What an expression gives in the page.
    fn evaluate(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true });
        self.call("Runtime.evaluate", params)["result"]["value"].clone()
    }

    fn close(mut self) {
        let _ = self.call("Browser.close", json!({}));
        let _ = self.process.wait();
    }
}

/// What the page shows: frames taken, points of each curve, status.
const SHOWN: &str = "({ frames: Number(document.body.dataset.frames ?? 0),
    over: document.body.dataset.over === 'true',
    status: document.getElementById('status').textContent,
    mode: document.getElementById('mode').textContent,
    points: Object.fromEntries(STRIPS.flatMap(({ curves, plot }) => curves.map(([, , field], index) =>
        [field, plot.data.at(-1 - index)[1].filter((value) => value !== null).length]))) })";

fn the_page_draws_updates_and_survives_the_end_of_the_run() {
    let program = browser().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    // Long: the test ends it when it has seen enough.
    let (run, address, rest) = serve(&corner, "600");
    let mut browsers = [0, 1].map(|number| Browser::open(&program, &corner, number, &address));
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
        assert_eq!(shown["status"], "under way", "{shown}");
        assert_ne!(shown["mode"], "–", "{shown}");
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
