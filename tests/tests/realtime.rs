//! A realtime run: nothing lost, every chain accounted for. No test here asserts how fast.

use serde_json::Value;
use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

#[test]
fn a_realtime_run_is_measured_whole() {
    let corner = Corner::new(PROGRAM);
    let summary = corner.json(&["run", "--duration", "3"]);
    assert_eq!(summary["outcome"], "completed");
    assert_eq!(summary["mode"], "realtime");
    for (topic, counts) in summary["messages"].as_object().expect("topics") {
        assert_eq!(counts["lost"].as_u64().unwrap_or(0), 0, "{topic}: {counts}");
    }

    let timing = &summary["timing"];
    let cycles = timing["cycles"].as_u64().expect("counted");
    let misses = timing["deadline_misses"].as_u64().expect("counted");
    assert!(cycles > 0 && cycles <= 31 && misses <= 31, "{timing}");
    let reaction = &timing["reaction_time_us"];
    let count = reaction["count"].as_u64().expect("counted");
    assert!(count > 0 && count <= cycles);
    for hop in ["radar_to_controller", "controller_compute", "controller_to_plant"] {
        assert_eq!(timing["hops_us"][hop]["count"].as_u64(), Some(count), "every chain has {hop}");
    }
    // The plant looks ten times for each command.
    assert!(timing["data_age_us"]["count"].as_u64() > Some(count));
    for figure in ["reaction_time_us", "data_age_us", "solve_us", "release_jitter_us"] {
        let order =
            ["p50", "p90", "p99", "p999", "p9999", "max"].map(|p| number(&timing[figure][p]));
        assert!(order.windows(2).all(|pair| pair[0] <= pair[1] * 1.01), "{figure}: {order:?}");
    }

    for service in summary["services"].as_array().expect("services") {
        assert_eq!(service["exit"], "ok", "{service}");
        let rss = service["peak_rss_kib"].as_u64().expect("read");
        assert!(rss < 16 * 1024, "{service}");
        let scheduling = &service["scheduling"];
        // Whatever was granted is what the kernel said, and what was refused is named.
        let granted = scheduling["granted"].as_str().expect("read back");
        if granted != scheduling["requested"].as_str().expect("asked") {
            assert!(!scheduling["refused"].as_array().expect("a list").is_empty(), "{service}");
        }
    }
}

#[test]
fn the_timer_releases_as_well_as_the_radar() {
    let corner = Corner::new(PROGRAM);
    let timer = ["run", "--duration", "2", "--set", "controller.release=timer"];
    let summary = corner.json(&timer);
    assert_eq!(summary["outcome"], "completed");
    let cycles = summary["timing"]["cycles"].as_u64().expect("counted");
    assert!((1..=21).contains(&cycles), "{cycles}");
    // In simulated time there is no difference: the sample of the step is there either way.
    let drive = |release: &str| {
        let key = format!("controller.release={release}");
        corner.json(&["run", "--mode", "lockstep", "--set", &key])["control"].clone()
    };
    assert_eq!(drive("timer"), drive("radar"));
}

/// iceoryx2 0.10 makes one small allocation for every message that is sent (the reference count of
/// the loaned sample). The loops themselves make none, so that the counts are equal.
#[test]
fn the_loops_allocate_nothing_of_their_own() {
    let corner = Corner::new(PROGRAM);
    for mode in ["realtime", "lockstep"] {
        for controller in ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded"] {
            let summary = corner.json(&[
                "run",
                "corridor",
                "--mode",
                mode,
                "--duration",
                "1",
                "--controller",
                controller,
            ]);
            let sent = |topic: &str| summary["messages"][topic]["sent"].as_u64().expect("counted");
            let beats = sent("health/heartbeat") / 4;
            for (service, own) in [
                ("plant", sent("vehicle/odometry")),
                ("perception-sim", sent("radar/tracks") + sent("truth/vehicles")),
                ("v2x-sim", sent("v2x/spat") + sent("v2x/map") + sent("truth/signals")),
                ("controller", sent("control/command") + sent("control/diagnostics")),
            ] {
                let services = summary["services"].as_array().expect("services");
                let found = services.iter().find(|found| found["name"] == service);
                let allocations = &found.expect("every service is listed")["allocations_in_loop"];
                assert_eq!(
                    allocations.as_u64(),
                    Some(own + beats),
                    "{mode} {controller} {service}"
                );
            }
        }
    }
}
