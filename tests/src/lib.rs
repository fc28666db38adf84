//! Shared parts of the whole-system tests: a command in a directory of its own, and its leftovers.

pub mod browser;
pub mod cases;
pub mod fuzz;
pub mod missing;
pub mod python;
pub mod schema;
pub mod storyboards;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Time after which waiting for an event fails: a watchdog, not a measurement.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A temporary directory of one test, in which its commands run.
#[derive(Debug)]
pub struct Corner {
    path: PathBuf,
    program: PathBuf,
}

impl Corner {
    /// A new corner for commands of `program`.
    #[must_use]
    pub fn new(program: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        // Short: paths of event sockets below it must fit into 108 bytes.
        let name = format!("tgt{:x}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = PathBuf::from("/tmp").join(name);
        std::fs::create_dir_all(&path).expect("the temporary directory is writable");
        Self { path, program: program.into() }
    }

    /// The directory.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A command whose runs are in this corner.
    #[must_use]
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command
            .args(arguments)
            .current_dir(&self.path)
            .env("TMPDIR", &self.path)
            // Small files of runs are below it, so that this corner's runs are distinct.
            .env("XDG_RUNTIME_DIR", &self.path)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Runs a command to its end.
    #[must_use]
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the command starts")
    }

    /// Starts a command.
    #[must_use]
    pub fn start(&self, arguments: &[&str]) -> Child {
        self.command(arguments).spawn().expect("the command starts")
    }

    /// Runs `timegap ARGUMENTS --json`, which must end with status 0, and parses its output.
    #[must_use]
    pub fn json(&self, arguments: &[&str]) -> Value {
        let arguments: Vec<_> = arguments.iter().copied().chain(["--json"]).collect();
        let output = self.run(&arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output));
        serde_json::from_slice(&output.stdout).expect("--json prints one JSON object")
    }

    /// The schemas of all results, by the names of the commands.
    #[must_use]
    pub fn schemas(&self) -> Value {
        let output = self.run(&["print", "schema", "results"]);
        let schema: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
        schema["$defs"].clone()
    }

    /// Directories of existing runs.
    #[must_use]
    pub fn roots(&self) -> Vec<PathBuf> {
        let base = std::fs::read_dir(&self.path).into_iter().flatten().flatten();
        let base = base.map(|entry| entry.path()).find(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("timegap-"))
        });
        let roots = base.and_then(|base| std::fs::read_dir(base).ok()).into_iter().flatten();
        roots.flatten().map(|entry| entry.path()).collect()
    }

    /// Living processes of runs in this corner, with their names.
    #[must_use]
    pub fn processes(&self) -> Vec<(i32, String)> {
        let needle = self.path.to_string_lossy().into_owned();
        let mut found = Vec::new();
        for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
            let Some(pid) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else {
                continue;
            };
            let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
            let line = String::from_utf8_lossy(&line).into_owned();
            let mut words = line.split('\0');
            let name = words.next().unwrap_or_default().to_owned();
            // Also processes that were started ahead and are not services yet.
            let is_ours = name.starts_with("timegap-") || name.starts_with("prepare-");
            if is_ours && words.any(|word| word.starts_with(&needle)) {
                found.push((pid, name));
            }
        }
        found
    }

    /// Shared-memory objects of the runs whose roots are `roots`.
    #[must_use]
    pub fn shared_memory(roots: &[PathBuf]) -> Vec<String> {
        let entries = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let ids: Vec<_> = roots
            .iter()
            .filter_map(|root| {
                root.file_name().map(|id| format!("timegap_{}_", id.to_string_lossy()))
            })
            .collect();
        names.filter(|name| ids.iter().any(|id| name.starts_with(id.as_str()))).collect()
    }

    /// Waits until no process, directory or shared memory of `roots` is left.
    ///
    /// # Panics
    /// If something is left after [`PATIENCE`].
    pub fn expect_nothing_left(&self, roots: &[PathBuf]) {
        let left = || (self.processes(), self.roots(), Self::shared_memory(roots));
        let gone = wait_for(|| {
            let (processes, roots, memory) = left();
            processes.is_empty() && roots.is_empty() && memory.is_empty()
        });
        assert!(gone, "left behind: {:?}", left());
    }

    /// Waits until a service of this name runs, and returns its process id.
    ///
    /// # Panics
    /// If none appears within [`PATIENCE`].
    #[must_use]
    pub fn wait_for_process(&self, name: &str) -> i32 {
        let mut pid = 0;
        let alive = wait_for(|| {
            let found = self.processes().into_iter().find(|(_, n)| n == name);
            pid = found.map_or(0, |(pid, _)| pid);
            pid != 0
        });
        assert!(alive, "no process {name} in {:?}", self.processes());
        pid
    }
}

impl Drop for Corner {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// A number in the status of a process, in the unit that the kernel has; `None` without the process or the field.
pub fn status_of(pid: i32, field: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let of = |line: &str| line.strip_prefix(field)?.strip_prefix(':').map(str::to_owned);
    let value = status.lines().find_map(of)?;
    value.split_whitespace().next()?.parse().ok()
}

/// Polls `condition` until it holds; false after [`PATIENCE`].
pub fn wait_for(mut condition: impl FnMut() -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        if condition() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    false
}

/// Lets commands that start from now on end by SIGHUP. Under `nohup` the tests ignore it, and so would the commands; a
/// handled signal is not inherited.
pub fn ignore_no_hang_up() {
    let handled = std::sync::Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGHUP, handled)
        .expect("SIGHUP can be handled");
}

/// Output and errors of a command.
#[must_use]
pub fn text(output: &Output) -> String {
    format!(
        "{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// Rows of a CSV file as numbers, by the named columns. An empty field is NaN.
///
/// # Panics
/// If a column is missing or a field is not a number.
#[must_use]
pub fn csv(text: &str, columns: &[&str]) -> Vec<Vec<f64>> {
    let mut lines = text.lines();
    let head: Vec<_> = lines.next().unwrap_or_default().split(',').collect();
    let places: Vec<_> = columns
        .iter()
        .map(|column| head.iter().position(|name| name == column))
        .map(|place| place.expect("the column is in the header"))
        .collect();
    let number = |field: &str| match field {
        "" => f64::NAN,
        field => field.parse().expect("a field is a number"),
    };
    lines
        .map(|line| {
            let fields: Vec<_> = line.split(',').collect();
            places.iter().map(|&place| number(fields[place])).collect()
        })
        .collect()
}
