//! The bridge of a run in progress: started with it by the supervisor, or later by a person.

use crate::inject::{announcement, injector, parameters};
use crate::server::{Server, Subject};
use crate::{port, recorded};
use messages::{Header, Topic};
use recorder::{Encoder, FromRecorder, Metadata, Recording, Start, Taps, ToRecorder, orders, say};
use runtime::{Group, Mode, Tap, log_warnings, monotonic_ns};
use scenario::Scenario;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;
use supervise::{Error, MachineError, UsageError, is_alive, law_names};

/// Time between two looks at the topics; their buffers hold half a second.
const REALTIME_POLL: Duration = Duration::from_millis(20);
/// The same in lockstep, which is as fast as it can be. What comes between two looks may be lost.
const LOCKSTEP_POLL: Duration = Duration::from_millis(1);
/// Politeness of the process to all others.
const NICE: i32 = 10;

/// Becomes the bridge of a run. `arguments` are the run's root and the port.
pub fn run(arguments: &[OsString]) -> ExitCode {
    let [root, port] = arguments else { return refuse() };
    let Some(port) = port.to_str().and_then(|port| port.parse().ok()) else { return refuse() };
    log_warnings();
    match follow_orders(Path::new(root), port) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            say(&FromRecorder::Failed(reason.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn refuse() -> ExitCode {
    eprintln!("the bridge is a service of timegap: start it with `timegap run --bridge foxglove`");
    ExitCode::from(2)
}

fn follow_orders(root: &Path, port: u16) -> Result<(), Error> {
    let group = Group::read(root)?;
    let scenario = group.scenario()?;
    // Its time is not known yet; viewers may connect all the same.
    let now = Start { start_ns: monotonic_ns(), ..start_of(&scenario) };
    let server = open(port, &now.metadata(&scenario, group.mode), Some(root))?;
    let taps = Tap::join(&group, "bridge").and_then(Taps::open)?;
    let orders = orders().map_err(MachineError::cannot("listen to the launcher"))?;
    loop {
        match orders.recv() {
            Ok(ToRecorder::Connect) => drop(taps.take()?),
            Ok(ToRecorder::Start(start)) => {
                let metadata = start.metadata(&scenario, group.mode);
                let ended = |wait| has_ended(&orders, wait);
                return follow(&group, &taps, &metadata, start.start_ns, server, ended);
            }
            Ok(ToRecorder::Finish) | Err(_) => return Ok(()),
        }
        say(&FromRecorder::Ready);
    }
}

/// Waits for an order; true if it is the one to end.
fn has_ended(orders: &Receiver<ToRecorder>, wait: Duration) -> bool {
    matches!(
        orders.recv_timeout(wait),
        Ok(ToRecorder::Finish) | Err(RecvTimeoutError::Disconnected)
    )
}

/// Facts about a run that was not there from its start.
fn start_of(scenario: &Scenario) -> Start {
    Start {
        start_ns: 0,
        scheduling: BTreeMap::new(),
        programs: BTreeMap::new(),
        law: law_names(scenario),
    }
}

/// A run's `live.json`.
#[derive(Deserialize)]
struct Live {
    #[serde(flatten)]
    group: Group,
    start_monotonic_ns: i64,
}

/// Serves `run` to viewers: the results of a run in progress, a recording, or `latest` for the newest results below
/// `runs`. A recording is played `speed` times as fast as it was.
///
/// # Errors
/// If it is neither, the run is another user's, or the port is taken.
pub fn serve(viewer: &str, run: &Path, speed: f64) -> Result<ExitCode, Error> {
    let port = port("timegap bridge", viewer)?;
    if !(speed > 0.0 && speed <= 1_000.0) {
        let expected = "a factor above 0, at most 1000";
        return Err(UsageError::option("--speed", speed, "out of range", expected).into());
    }
    let run = if run == Path::new("latest") { latest(Path::new("runs"))? } else { run.to_owned() };
    let path = run.join("live.json");
    let live = std::fs::read_to_string(&path).ok().map(|text| serde_json::from_str::<Live>(&text));
    match live {
        Some(Ok(live)) if is_alive(&live.group.root) => join(&live, port)?,
        Some(Err(why)) => return Err(UsageError::at(path.display(), why, "a run's file").into()),
        Some(Ok(_)) | None => {
            let recording = Recording::open(&run)?;
            recorded::play(&recording, open(port, recording.metadata(), None)?, speed);
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The newest directory in `runs`; their names begin with the time.
fn latest(runs: &Path) -> Result<PathBuf, UsageError> {
    let entries = std::fs::read_dir(runs).into_iter().flatten().flatten();
    let newest = entries.map(|entry| entry.path()).filter(|path| path.is_dir()).max();
    newest.ok_or_else(|| {
        UsageError::option("--run", "latest", "there is no run in ./runs", "a results directory")
    })
}

fn join(live: &Live, port: u16) -> Result<(), Error> {
    let Live { group, start_monotonic_ns } = live;
    let scenario = group.scenario()?;
    let start = Start { start_ns: *start_monotonic_ns, ..start_of(&scenario) };
    let metadata = start.metadata(&scenario, group.mode);
    let server = open(port, &metadata, Some(&group.root))?;
    let taps = Tap::join(group, "guest-bridge").and_then(Taps::open)?;
    let ended = |wait| {
        std::thread::sleep(wait);
        !is_alive(&group.root)
    };
    follow(group, &taps, &metadata, start.start_ns, server, ended)
}

/// Opens the server of a run with this metadata. Faults go to the run at `root`.
fn open(port: u16, metadata: &Metadata, root: Option<&Path>) -> Result<Server, MachineError> {
    // Failure leaves it as polite as others.
    let _ = rustix::process::setpriority_process(None, NICE);
    let subject = Subject {
        name: format!("timegap {} · {}", metadata.scenario_name, metadata.controller),
        session: format!("{}-{}", metadata.started_unix_ns, std::process::id()),
        channels: Encoder::channels(metadata),
        parameters: parameters(&metadata.scenario),
        service: root.map(|root| (announcement(), injector(root.to_owned()))),
    };
    let server = Server::open(port, subject);
    let server = server.map_err(MachineError::cannot(format!("open 127.0.0.1:{port}")))?;
    eprintln!("Foxglove: open ws://127.0.0.1:{}", server.port());
    Ok(server)
}

/// Hands the run's messages to viewers until `ended`, which waits between two looks.
fn follow(
    group: &Group,
    taps: &Taps,
    metadata: &Metadata,
    start_ns: i64,
    server: Server,
    mut ended: impl FnMut(Duration) -> bool,
) -> Result<(), Error> {
    let mut encoder = Encoder::of(metadata);
    let poll = match group.mode {
        Mode::Realtime => REALTIME_POLL,
        Mode::Lockstep => LOCKSTEP_POLL,
    };
    let mut is_last = false;
    while !is_last {
        is_last = ended(poll);
        let batch = taps.take()?;
        // Without a viewer it costs nothing to encode.
        if !server.is_watched() {
            continue;
        }
        let now_ns = match group.mode {
            Mode::Realtime => monotonic_ns() - start_ns,
            Mode::Lockstep => i64::MAX,
        };
        let mut messages: Vec<_> = (batch.messages())
            .map(|(topic, bytes)| (published_ns(bytes).min(now_ns), topic, bytes))
            .collect();
        messages.sort_by_key(|(published_ns, ..)| *published_ns);
        let mut newest = None;
        for (published_ns, topic, bytes) in messages {
            newest = Some(hand_on(&mut encoder, (topic, published_ns, bytes), &server));
        }
        newest.into_iter().for_each(|unix_ns| server.send_time(unix_ns));
    }
    server.end("the run has ended");
    Ok(())
}

/// Sends a message, and what is drawn by it; the instant in ns since 1970.
pub(crate) fn hand_on(
    encoder: &mut Encoder,
    (topic, run_ns, bytes): (Topic, i64, &[u8]),
    server: &Server,
) -> u64 {
    let mut unix_ns = 0;
    let Ok(()) = encoder.encode(topic, run_ns, bytes, |head, payload| {
        unix_ns = head.log_time;
        server.send(head.channel_id, head.log_time, payload);
        Ok::<(), Infallible>(())
    });
    unix_ns
}

fn published_ns(message: &[u8]) -> i64 {
    bytemuck::pod_read_unaligned::<Header>(&message[..size_of::<Header>()]).publish_ns
}
