//! The bridge of a run in progress, started with it by the supervisor or later by a person, and of a recording.

use crate::inject::{announcement, injector, parameters};
use crate::port;
use crate::protocol::Subject;
use crate::server::Server;
use messages::{Header, Topic};
use recorder::{Encoder, FILE, Metadata, Recording, Report, Start, Taps, ToRecorder, orders};
use runtime::{Group, Guest, Mode, monotonic_ns};
use scenario::Scenario;
use serde::Deserialize;
use std::convert::Infallible;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};
use supervise::{Error, MachineError, UsageError};
use supervise::{hold_signals, is_alive, is_signalled, law_names};

/// Time between two looks at the topics, whose buffers hold half a second, or at the viewers of a recording.
const REALTIME_POLL: Duration = Duration::from_millis(20);
/// The same in lockstep, which is as fast as it can be. What comes between two looks may be lost.
const LOCKSTEP_POLL: Duration = Duration::from_millis(1);
/// Longest time for what still waits for viewers at the end.
const LEAVE: Duration = Duration::from_secs(1);
/// Politeness of the process to all others.
const NICE: i32 = 10;

/// Becomes the bridge of a run. `arguments` are the run's root and the port.
pub fn run(arguments: &[OsString]) -> ExitCode {
    recorder::attend(arguments, |root, address| {
        follow_orders(root, port("--bridge", &format!("foxglove:{}", address.display()))?)
    })
}

fn follow_orders(root: &Path, port: u16) -> Result<Option<Report>, Error> {
    let group = Group::read(root)?;
    let scenario = group.scenario()?;
    // The start is not known yet; viewers may connect all the same.
    let server = open(port, &metadata(&group, &scenario, monotonic_ns()), Some(root))?;
    let taps = Guest::join(&group, "bridge").and_then(Taps::open)?;
    let orders = orders()?;
    let metadata = recorder::begin(&taps, &orders)?.metadata(&scenario, group.mode);
    follow(&group, &taps, &metadata, server, |wait| {
        let order = orders.recv_timeout(wait);
        matches!(order, Ok(ToRecorder::Finish) | Err(RecvTimeoutError::Disconnected))
    })?;
    Ok(None)
}

/// Metadata for viewers of a run whose time began at `start_ns`.
fn metadata(group: &Group, scenario: &Scenario, start_ns: i64) -> Metadata {
    let start = Start { start_ns, law: law_names(scenario), ..Start::default() };
    start.metadata(scenario, group.mode)
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
    hold_signals()?;
    let mistake = |why| UsageError::at(path.display(), why, "a run's file");
    match live.transpose().map_err(mistake)?.filter(|live| is_alive(&live.group.root)) {
        Some(live) => join(&live, port).map(|()| ExitCode::SUCCESS),
        None => {
            let recording = Recording::open(&run)?;
            Ok(play(&recording, open(port, recording.metadata(), None)?, speed))
        }
    }
}

/// The newest results in `runs`.
fn latest(runs: &Path) -> Result<PathBuf, UsageError> {
    let entries = std::fs::read_dir(runs).into_iter().flatten().flatten();
    let shown = |path: &PathBuf| path.join("live.json").exists() || path.join(FILE).exists();
    let results = entries.map(|entry| entry.path()).filter(shown);
    let newest = results.max_by_key(|path| path.metadata().and_then(|file| file.modified()).ok());
    newest.ok_or_else(|| {
        UsageError::option("--run", "latest", "there is no run in ./runs", "a results directory")
    })
}

fn join(Live { group, start_monotonic_ns }: &Live, port: u16) -> Result<(), Error> {
    let metadata = metadata(group, &group.scenario()?, *start_monotonic_ns);
    let server = open(port, &metadata, Some(&group.root))?;
    let taps = Guest::join(group, "guest-bridge").and_then(Taps::open)?;
    follow(group, &taps, &metadata, server, |wait| {
        std::thread::sleep(wait);
        is_signalled() || !is_alive(&group.root)
    })
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
    server: Server,
    mut ended: impl FnMut(Duration) -> bool,
) -> Result<(), Error> {
    let mut show = show(metadata, &server);
    let poll = match group.mode {
        Mode::Realtime => REALTIME_POLL,
        Mode::Lockstep => LOCKSTEP_POLL,
    };
    let published_ns = |message: &[u8]| {
        bytemuck::pod_read_unaligned::<Header>(&message[..size_of::<Header>()]).publish_ns
    };
    let mut is_last = false;
    while !is_last {
        is_last = ended(poll);
        let batch = taps.take()?;
        // Without a viewer it costs nothing to encode.
        let mut messages: Vec<_> = batch.messages().filter(|_| server.is_watched()).collect();
        messages.sort_by_key(|(_, bytes)| published_ns(bytes));
        messages.into_iter().for_each(|(topic, bytes)| show(topic, published_ns(bytes), bytes));
    }
    let ended = Instant::now();
    server.end("the run has ended", || ended.elapsed() < LEAVE);
    Ok(())
}

/// Plays all of a recording, from the moment at which the first viewer subscribes. Status 1 if parts of it are damaged,
/// which lines name.
fn play(recording: &Recording, server: Server, speed: f64) -> ExitCode {
    while !server.is_watched() && !is_signalled() {
        std::thread::sleep(REALTIME_POLL);
    }
    let mut show = show(recording.metadata(), &server);
    let begun = Instant::now();
    let (mut first_ns, mut shown) = (None, Duration::ZERO);
    let mut records = recording.records();
    for record in records.by_ref().take_while(|_| !is_signalled()) {
        let run_ns = record.log_time_ns - *first_ns.get_or_insert(record.log_time_ns);
        let due = Duration::from_nanos(run_ns.unsigned_abs()).div_f64(speed);
        // Messages of one look are sent together.
        if due > shown + REALTIME_POLL {
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
            shown = due;
        }
        show(record.topic, record.log_time_ns, record.bytes());
    }
    server.end("the recording has ended", || !is_signalled());
    let damage: Vec<_> = recording.damage().iter().chain(records.damage()).collect();
    damage.iter().for_each(|damage| eprintln!("{}: {damage}", recording.path().display()));
    if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Sends a message of a topic with its run time, ns, and what is drawn by it.
fn show(metadata: &Metadata, server: &Server) -> impl FnMut(Topic, i64, &[u8]) {
    let mut encoder = Encoder::of(metadata);
    move |topic, run_ns, bytes| {
        let Ok(()) = encoder.encode(topic, run_ns, bytes, |head, payload| {
            server.send(head.channel_id, head.log_time, payload);
            Ok::<(), Infallible>(())
        });
    }
}
