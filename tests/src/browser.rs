//! A headless browser with one page, controlled by the DevTools protocol over two pipes.

use crate::cases::Needed;
use crate::{Corner, wait_for};
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Debian's chromium, or a similar browser.
fn program() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .flat_map(|directory| {
            ["chromium", "chromium-browser", "google-chrome"].map(|name| directory.join(name))
        })
        .find(|program| program.is_file())
}

/// A browser on the search path.
///
/// # Errors
/// The reason, if it is missing.
pub fn chromium() -> Needed {
    program().map(|_| ()).ok_or_else(|| "no chromium".into())
}

/// A browser with one page.
pub struct Browser {
    process: Child,
    to: File,
    from: BufReader<File>,
    asked: u64,
    session: Option<String>,
    errors: Vec<String>,
}

impl Browser {
    /// Opens `address`. The browser's files are in the corner, under `number`.
    ///
    /// # Panics
    /// If the browser is missing, or does not answer.
    #[must_use]
    pub fn open(corner: &Corner, number: usize, address: &str) -> Self {
        let path = |name: &str| corner.path().join(format!("{name}-{number}"));
        let (to, from) = (path("to"), path("from"));
        let made = Command::new("mkfifo").args([&to, &from]).status().expect("mkfifo is there");
        assert!(made.success());
        // The browser reads commands on descriptor 3 and answers on 4.
        let process = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<\"$TO\" 4>\"$FROM\""])
            .arg(program().expect("looked for before"))
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
        let (session, errors) = (None, Vec::new());
        let mut browser = Self { process, to, from, asked: 0, session, errors };
        let page = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": page["targetId"], "flatten": true });
        let attached = browser.call("Target.attachToTarget", attach);
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        browser.call("Runtime.enable", json!({}));
        browser.call("Log.enable", json!({}));
        browser.call("Page.navigate", json!({ "url": address }));
        browser
    }

    /// Calls a method of the protocol and returns its result.
    ///
    /// # Panics
    /// If the browser has ended or refuses.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        let answer = self.answer(method, params);
        assert!(answer["error"].is_null(), "{method}: {answer}");
        answer["result"].clone()
    }

    /// Calls a method and returns its whole answer: a result or an error.
    fn answer(&mut self, method: &str, params: Value) -> Value {
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
                return answer;
            }
            let is_error = answer["params"]["entry"]["level"] == "error"
                || answer["params"]["type"] == "error"
                || answer["method"] == "Runtime.exceptionThrown";
            if is_error {
                self.errors.push(answer.to_string());
            }
        }
    }

    /// The value of an expression in the page. Null while the page has no context: in the middle of a navigation.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true });
        self.answer("Runtime.evaluate", params)["result"]["result"]["value"].clone()
    }

    /// Waits until an expression is true in the page; false after a timeout.
    pub fn becomes(&mut self, expression: &str) -> bool {
        wait_for(|| self.evaluate(expression) == true)
    }

    /// Sends a mouse event at a place of the window, px.
    pub fn mouse(&mut self, kind: &str, (x, y): (f64, f64)) {
        let pressed = if kind == "mouseMoved" { "none" } else { "left" };
        let params = json!({ "type": kind, "x": x, "y": y, "button": pressed, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", params);
    }

    /// Errors in the page's console so far.
    #[must_use]
    pub fn errors(&self) -> &[String] {
        &self.errors
    }

    /// Ends the browser.
    pub fn close(mut self) {
        let _ = self.call("Browser.close", json!({}));
        let _ = self.process.wait();
    }
}
