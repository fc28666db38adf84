//! The dialogue of launcher and recorder: JSON lines on the recorder's standard streams, as with every process of the
//! group.

use crate::{LawNames, Metadata, Tally};
use runtime::scheduling::Granted;
use runtime::{Mode, Program, RuntimeError, monotonic_ns};
use scenario::Scenario;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{BufRead, Write};
use std::sync::mpsc::{Receiver, channel};
use std::time::SystemTime;

/// A line from the launcher to the recorder. The end of the input means [`ToRecorder::Finish`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToRecorder {
    /// Connect to all senders, whose ports exist now.
    Connect,
    Start(Start),
    /// Record what has been sent, and end.
    Finish,
}

/// Facts that are known when the group starts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Run time 0, in `CLOCK_MONOTONIC` ns.
    pub start_ns: i64,
    /// Scheduling that the kernel granted to each service, by its name.
    pub scheduling: BTreeMap<String, Granted>,
    /// The programs of the user's that take part, by the service that they are or compute for.
    #[serde(default)]
    pub programs: BTreeMap<String, Program>,
    /// Meaning of the law's numbers.
    pub law: LawNames,
}

impl Start {
    pub fn metadata(&self, scenario: &Scenario, mode: Mode) -> Metadata {
        let since_1970 =
            SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let now_ns = i64::try_from(since_1970.as_nanos()).unwrap_or(0);
        let started_unix_ns = now_ns - (monotonic_ns() - self.start_ns);
        let (scheduling, law) = (self.scheduling.clone(), self.law.clone());
        let metadata = Metadata::new(scenario, mode, started_unix_ns, scheduling, law);
        Metadata { programs: self.programs.clone(), ..metadata }
    }
}

/// A line from the recorder to the launcher.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FromRecorder {
    /// It receives every sender.
    Ready,
    /// It cannot begin, or go on.
    Failed(String),
    Report(Report),
}

/// The account of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    pub tally: Tally,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Reason why the file ends early, if it does.
    pub failed: Option<String>,
}

/// Listens to the launcher: JSON lines on standard input.
///
/// # Errors
/// If the thread that reads them cannot be started.
pub fn orders<Order: DeserializeOwned + Send + 'static>() -> Result<Receiver<Order>, RuntimeError> {
    let (sender, orders) = channel();
    let listen = move || {
        let orders = std::io::stdin().lock().lines().map_while(Result::ok);
        let mut orders = orders.filter_map(|line| serde_json::from_str(&line).ok());
        orders.all(|order| sender.send(order).is_ok());
    };
    let thread = std::thread::Builder::new().name("link".into()).spawn(listen);
    let failed = |reason| RuntimeError::Setup("a thread that listens".into(), reason);
    thread.map(|_| orders).map_err(failed)
}

/// Tells the launcher something: a JSON line on standard output.
pub fn say(message: &impl Serialize) {
    let line = serde_json::to_string(message).expect("link messages are plain data");
    // The launcher may be gone.
    let _ = writeln!(std::io::stdout().lock(), "{line}");
}
