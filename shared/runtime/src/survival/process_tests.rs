//! A standby beside a real process: its end, its silence, and the wait for either.

use super::fence::tests::Run;
use super::standby::{ActiveProcess, Cause, Standby};
use crate::counts::figures::Figures;
use crate::machine::scheduling::Granted;
use crate::words::RunWords;
use messages::{Service, Topic};
use scenario::Scenario;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

const SERVICE: Service = Service::Controller;
/// A watchdog, not a limit.
const PATIENCE: Duration = Duration::from_secs(60);

/// A process that lives until it is killed.
fn process() -> Child {
    let mut command = Command::new("cat");
    command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().expect("`cat` is everywhere")
}

fn begin(run: &Run, active: ActiveProcess, keys: &str) -> Standby {
    // The requested scheduling is not in force: no priority is to be given.
    let granted = Granted {
        requested: "fifo".to_owned(),
        granted: "other".to_owned(),
        core: None,
        memory_locked: false,
        refused: Vec::new(),
    };
    let text = format!("schema_version = 1\nname = \"standby\"\n{keys}");
    let scenario = Scenario::parse("standby", &text).expect("a scenario");
    let words = run.peers().words;
    let own = (SERVICE, 1);
    Standby::begin(&run.0, &words, &scenario, own, active, &granted).expect("it begins")
}

/// Ends the process, and waits for the thread that watches it: its last act is to wake the loop.
fn end(mut active: Child, run: &Run) {
    let before = woken(run);
    active.kill().expect("it is ours");
    active.wait().expect("it is ours");
    assert!(wait_until(|| woken(run)[1] != before[1]));
}

/// Scheduling policy of this thread: the 41st field of its `stat`.
fn policy() -> String {
    let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("it is there on Linux");
    let (_, fields) = stat.rsplit_once(')').expect("the name is in brackets");
    fields.split_whitespace().nth(38).expect("more fields").to_owned()
}

fn wait_until(mut is_so: impl FnMut() -> bool) -> bool {
    let end = Instant::now() + PATIENCE;
    while !is_so() {
        if Instant::now() > end {
            return false;
        }
        std::thread::yield_now();
    }
    true
}

/// Number of wake-ups of the waiters on the topics that can release a loop.
fn woken(run: &Run) -> [u32; 3] {
    let words = RunWords::map(&run.0.prefix).expect("shared memory");
    [Topic::RadarTracks, Topic::RadarDetections, Topic::Odometry]
        .map(|topic| words.wake(topic).load(Ordering::SeqCst))
}

#[test]
fn the_end_of_the_process_is_a_take_over_that_wakes_the_loop() {
    let run = Run::new("ends", &[SERVICE]);
    let mut active = process();
    let pid = active.id().cast_signed();
    let standby = begin(&run, ActiveProcess { incarnation: 0, pid }, "");
    let before = woken(&run);
    assert_eq!(policy(), "0", "without a priority it has none to give up");
    let (begun, pause) = (Instant::now(), Duration::from_millis(20));
    standby.wait(pause);
    assert!(begun.elapsed() >= pause, "nothing ended the wait early");
    assert!(standby.stands_by() && standby.taken_over().is_none(), "the process lives");
    active.kill().expect("it is ours");
    active.wait().expect("it is ours");
    let limit = Instant::now() + PATIENCE;
    while standby.stands_by() && Instant::now() < limit {
        standby.wait(PATIENCE);
    }
    assert!(matches!(standby.taken_over(), Some((Cause::Gone, noticed_ns)) if noticed_ns > 0));
    assert!(run.peers().accept(SERVICE.to_wire(), 1) && !run.peers().accept(SERVICE.to_wire(), 0));
    // Only the topics that can release the loop are woken.
    assert!(wait_until(|| woken(&run)[..2].iter().zip(&before).all(|(now, then)| now != then)));
    assert_eq!(woken(&run)[2], before[2]);
}

#[test]
fn a_process_that_is_gone_already_is_taken_over_from_at_once() {
    let run = Run::new("gone", &[SERVICE]);
    let mut active = process();
    let pid = active.id().cast_signed();
    active.kill().expect("it is ours");
    active.wait().expect("it is ours");
    let before = woken(&run);
    let standby = begin(&run, ActiveProcess { incarnation: 0, pid }, "");
    assert!(wait_until(|| !standby.stands_by()));
    assert!(matches!(standby.taken_over(), Some((Cause::Gone, _))));
    let changed = |now: &[u32]| now[..2].iter().zip(&before).all(|(now, then)| now != then);
    assert!(wait_until(|| changed(&woken(&run))));
    // A wait after it ends at once.
    standby.wait(PATIENCE);
}

#[test]
fn a_process_that_lives_and_does_nothing_is_silent() {
    let run = Run::new("silent", &[SERVICE]);
    let mut counts = Figures::open(&run.0, SERVICE).expect("shared memory");
    counts.begin(0);
    let active = process();
    let pid = active.id().cast_signed();
    let keys = "[supervision]\nstandby_timeout_ms = 20";
    let mut standby = begin(&run, ActiveProcess { incarnation: 0, pid }, keys);
    // As long as it works, nothing happens.
    let until = Instant::now() + Duration::from_millis(60);
    let mut cycles = 0;
    while Instant::now() < until {
        cycles += 1;
        counts.show_progress(cycles);
        standby.look_at_active();
        assert!(standby.stands_by(), "cycle {cycles}");
    }
    assert!(wait_until(|| {
        standby.look_at_active();
        !standby.stands_by()
    }));
    assert!(matches!(standby.taken_over(), Some((Cause::Silent, _))));
    end(active, &run);
    let _ = std::fs::remove_file(format!("/dev/shm/{}{SERVICE}.counts", run.0.prefix));
}
