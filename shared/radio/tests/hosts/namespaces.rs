//! Two hosts on one machine: namespaces `a` and `b`, with the air in a third one between them.

use libtest_mimic::{Arguments, Failed, Trial};
use radio::RadioReport;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

const WATCHDOG: Duration = Duration::from_secs(120);

/// The folder `tests` of this crate, for each package that compiles this module.
fn tests() -> PathBuf {
    let packages = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut tests = packages.map(|package| package.join("shared/radio/tests"));
    tests.find(|tests| tests.is_dir()).expect("the sources are there")
}

fn script() -> PathBuf {
    tests().join("hosts/air.py")
}

/// The missing permission or program, if any.
fn missing() -> Option<String> {
    let name = format!("tg-{}-try", std::process::id());
    let made = run(&["ip", "netns", "add", &name]);
    if let Err(why) = made {
        return Some(format!("no network namespaces here ({why})"));
    }
    let tried = run(&["ip", "netns", "exec", &name, "python3", "--version"]);
    // Created above.
    let _ = run(&["ip", "netns", "delete", &name]);
    tried.err().map(|why| format!("no Python in a network namespace ({why})"))
}

fn run(words: &[&str]) -> Result<(), String> {
    let output = Command::new(words[0]).args(&words[1..]).stdin(Stdio::null()).output();
    let output = output.map_err(|e| format!("{}: {e}", words[0]))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("{}: {}", words.join(" "), said.lines().next().unwrap_or("it failed")))
}

/// The hosts and their air.
pub struct Hosts {
    prefix: String,
    air: Option<Process>,
    directory: PathBuf,
}

impl Hosts {
    /// Makes both hosts, 10.99.7.1 on `a0` and 10.99.7.2 on `b0`, with good air between them.
    pub fn new() -> Result<Self, Failed> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let prefix = format!("tg-{}-{number}", std::process::id());
        let directory = std::env::temp_dir().join(&prefix);
        std::fs::create_dir_all(&directory)?;
        let mut this = Self { prefix, air: None, directory };
        let air = this.name("air");
        run(&["ip", "netns", "add", &air])?;
        for (host, address) in [("a", "10.99.7.1/24"), ("b", "10.99.7.2/24")] {
            let name = this.name(host);
            let (near, far) = (format!("{host}0"), format!("{host}1"));
            run(&["ip", "netns", "add", &name])?;
            run(&[
                "ip", "-n", &air, "link", "add", &far, "type", "veth", "peer", "name", &near,
                "netns", &name,
            ])?;
            run(&["ip", "-n", &air, "link", "set", &far, "up"])?;
            run(&["ip", "-n", &name, "address", "add", address, "dev", &near])?;
            run(&["ip", "-n", &name, "link", "set", "lo", "up"])?;
            run(&["ip", "-n", &name, "link", "set", &near, "up"])?;
            let script = script().display().to_string();
            run(&["ip", "netns", "exec", &name, "python3", &script, "plain", &near])?;
        }
        let script = script().display().to_string();
        this.air = Some(this.process("air", "python3", &[&script, "forward", "a1", "b1", "7"])?);
        this.air("air 1 0 0")?;
        Ok(this)
    }

    /// The name of a host's namespace.
    pub fn name(&self, host: &str) -> String {
        format!("{}-{host}", self.prefix)
    }

    fn process(&self, host: &str, program: &str, arguments: &[&str]) -> Result<Process, Failed> {
        let mut child = Command::new("ip")
            .args(["netns", "exec", &self.name(host), program])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let input = child.stdin.take();
        let output = child.stdout.take().ok_or("it is piped")?;
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Ok(Process { child, input, lines, heard: 0, last: None })
    }

    /// Starts a station on a host: this program again.
    pub fn station(&self, host: &str, arguments: &[&str]) -> Result<Process, Failed> {
        let program = std::env::current_exe()?.display().to_string();
        let arguments = [&["station"], arguments].concat();
        self.process(host, &program, &arguments)
    }

    fn ask_air(&mut self, command: &str) -> Result<serde_json::Value, Failed> {
        let air = self.air.as_mut().ok_or("the air has gone")?;
        let input = air.input.as_mut().ok_or("its input was closed")?;
        writeln!(input, "{command}")?;
        Ok(serde_json::from_str(&air.next_line()?)?)
    }

    /// Changes the air: `air DELAY_MS JITTER_MS LOSS` or `cut`.
    pub fn air(&mut self, command: &str) -> Result<(), Failed> {
        self.ask_air(command).map(drop)
    }

    /// Waits until the air is empty.
    pub fn quiet(&mut self) -> Result<(), Failed> {
        let begun = Instant::now();
        while self.ask_air("count")?["waiting"] != 0 {
            if begun.elapsed() > WATCHDOG {
                return Err("the air does not become empty".into());
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Ok(())
    }

    /// Frames from `a` to `b` that the air dropped.
    pub fn dropped_frames(&mut self) -> Result<u64, Failed> {
        let told = self.ask_air("count")?;
        told["dropped"][0].as_u64().ok_or_else(|| "the air does not count".into())
    }

    /// Writes zenoh's configuration of the router on host `a` or of its client; returns its address.
    #[cfg(feature = "zenoh")]
    pub fn configuration(&self, which: &str) -> Result<String, Failed> {
        let certificates = tests().join("certificates");
        let at = |name: &str| certificates.join(name).display().to_string();
        let (place, end, owner) = match which {
            "router" => ("listen", "listen", "router"),
            _ => ("connect", "connect", "vehicle"),
        };
        let text = format!(
            r#"{{ mode: "{which}", {place}: {{ endpoints: ["tls/10.99.7.1:7447"] }},
                 scouting: {{ multicast: {{ enabled: false }} }},
                 transport: {{ link: {{ tx: {{ lease: 4000 }}, tls: {{
                     root_ca_certificate: "{}", enable_mtls: true,
                     {end}_certificate: "{}", {end}_private_key: "{}" }} }} }} }}"#,
            at("ca.pem"),
            at(&format!("{owner}.pem")),
            at(&format!("{owner}.key.pem")),
        );
        let path = self.directory.join(format!("{which}.json5"));
        std::fs::write(&path, text)?;
        Ok(format!("zenoh:{}", path.display()))
    }

    /// Removes both hosts; an error if a process is left in one.
    pub fn remove(mut self) -> Result<(), Failed> {
        self.air = None;
        for host in ["a", "b", "air"] {
            let name = self.name(host);
            let pids = Command::new("ip").args(["netns", "pids", &name]).output()?;
            if !pids.stdout.is_empty() {
                let left = String::from_utf8_lossy(&pids.stdout).into_owned();
                return Err(format!("processes are left in {name}: {left}").into());
            }
        }
        Ok(())
    }
}

impl Drop for Hosts {
    fn drop(&mut self) {
        self.air = None;
        for host in ["a", "b", "air"] {
            // Removing an absent one fails without harm.
            let _ = run(&["ip", "netns", "delete", &self.name(host)]);
        }
        let _ = std::fs::remove_dir_all(&self.directory);
    }
}

/// A process on a host; it ends when this is dropped.
pub struct Process {
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<String>,
    heard: u64,
    last: Option<String>,
}

impl Process {
    fn next_line(&mut self) -> Result<String, Failed> {
        match self.lines.recv_timeout(WATCHDOG) {
            Ok(line) => Ok(line),
            Err(_) => Err("a process printed no more lines".into()),
        }
    }

    /// Waits for a line.
    pub fn line(&mut self, expected: &str) -> Result<(), Failed> {
        let line = self.next_line()?;
        if line == expected { Ok(()) } else { Err(format!("it printed {line}").into()) }
    }

    /// Waits for `count` more frames.
    pub fn frames(&mut self, count: u64) -> Result<(), Failed> {
        let until = self.heard() + count;
        let begun = Instant::now();
        while self.heard() < until {
            if begun.elapsed() > WATCHDOG {
                return Err(format!("{} of {until} frames came", self.heard).into());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(())
    }

    /// Frames received so far.
    pub fn heard(&mut self) -> u64 {
        while let Ok(line) = self.lines.try_recv() {
            self.take(line);
        }
        self.heard
    }

    fn take(&mut self, line: String) {
        if line.starts_with("frame") {
            self.heard += 1;
        } else {
            self.last = Some(line);
        }
    }

    /// Waits until no frame arrived for half a second.
    pub fn until_quiet(&mut self) {
        while let Ok(line) = self.lines.recv_timeout(Duration::from_millis(500)) {
            self.take(line);
        }
    }

    /// Closes its input and returns its counts.
    pub fn finish(&mut self) -> Result<RadioReport, Failed> {
        self.input = None;
        while let Ok(line) = self.lines.recv_timeout(WATCHDOG) {
            self.take(line);
        }
        let status = self.child.wait()?;
        let last = self.last.take().ok_or("it printed nothing")?;
        if !status.success() {
            return Err(format!("it ended with {status}: {last}").into());
        }
        Ok(serde_json::from_str(&last)?)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.input = None;
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A test on two hosts.
pub type Test = (&'static str, fn() -> Result<(), Failed>);

/// Runs tests; without two hosts they are skipped visibly.
pub fn conclude(tests: &[Test]) -> ExitCode {
    let missing = missing();
    let trials = tests.iter().map(|&(name, run)| {
        let test = Trial::test(name, run);
        match &missing {
            None => test,
            Some(why) => test.with_kind(format!("SKIPPED: {why}")).with_ignored_flag(true),
        }
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit_code()
}
