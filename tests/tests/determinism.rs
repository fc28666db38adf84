//! Lockstep: equal scenario and seed give equal bytes on every topic, under any load of the machine.

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use serde_json::Value;
use std::sync::atomic::{AtomicBool, Ordering};
use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Digests of all messages of all topics, by topic and sender.
fn digests(corner: &Corner, scenario: &str, seed: &str) -> Vec<(String, Value)> {
    let arguments = ["run", scenario, "--mode", "lockstep", "--seed", seed, "--duration", "10"];
    let summary = corner.json(&arguments);
    let messages = summary["messages"].as_object().expect("topics");
    // The emergency brake adds two topics: its detections and its requests.
    let topics = if scenario == "cacc-a" { 10 } else { 12 };
    assert_eq!(messages.len(), topics, "every topic is there");
    messages
        .iter()
        .map(|(topic, counts)| {
            assert_eq!(counts["lost"].as_u64().unwrap_or(0), 0, "{topic} lost messages");
            assert!(counts["sent"].as_u64() > Some(90), "{topic}: {counts}");
            (topic.clone(), counts["digests"].clone())
        })
        .collect()
}

/// Runs `work` while both cores are busy.
fn under_load<T>(work: impl FnOnce() -> T) -> T {
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut x = 1_u64;
                while !stop.load(Ordering::Relaxed) {
                    x = std::hint::black_box(x.wrapping_mul(6_364_136_223_846_793_005) + 1);
                }
            });
        }
        let result = work();
        stop.store(true, Ordering::Relaxed);
        result
    })
}

/// Runs `work` with this thread and its children on one core.
fn on_one_core<T>(work: impl FnOnce() -> T) -> T {
    let before = sched_getaffinity(None).expect("readable");
    let first = (0..CpuSet::MAX_CPU).find(|&core| before.is_set(core)).expect("some core");
    let mut one = CpuSet::new();
    one.set(first);
    sched_setaffinity(None, &one).expect("a core of ours");
    let result = work();
    sched_setaffinity(None, &before).expect("what it was");
    result
}

#[test]
fn every_topic_repeats_byte_for_byte() {
    // One exact and one with a noisy radar, a tracker and a cut-in.
    for scenario in ["cacc-a", "cut-in"] {
        let corner = Corner::new(PROGRAM);
        let first = digests(&corner, scenario, "7");
        assert_eq!(first, digests(&corner, scenario, "7"), "{scenario}: again");
        let loaded = under_load(|| digests(&corner, scenario, "7"));
        assert_eq!(first, loaded, "{scenario}: under load");
        let pinned = on_one_core(|| digests(&corner, scenario, "7"));
        assert_eq!(first, pinned, "{scenario}: on one core");
    }
}

#[test]
fn another_seed_gives_other_radar_bytes() {
    let corner = Corner::new(PROGRAM);
    let [one, two] = ["1", "2"].map(|seed| digests(&corner, "cut-in", seed));
    let of = |digests: &[(String, Value)], topic: &str| {
        digests.iter().find(|(name, _)| name == topic).map(|(_, digest)| digest.clone())
    };
    assert_ne!(of(&one, "radar/tracks"), of(&two, "radar/tracks"));
    assert_eq!(of(&one, "truth/signals"), of(&two, "truth/signals"));
}
